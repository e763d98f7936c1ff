// @ts-check
// What a target of a scenario follows: a start with segments, or a table of points; never both.

import { h } from "../js/dom.js";
import { t } from "../js/i18n.js";

/** @import { Values } from "../js/scenario.js" */

/** Fields that say nothing where a target follows points. */
const OF_SEGMENTS = ["east_m", "north_m", "altitude_m", "heading_deg", "speed_mps", "segments"];

/** @param {Values} row @param {string} name */
export function hiddenBy(row, name) {
  if (!("points" in row && "segments" in row)) return false;
  return row.points.length ? OF_SEGMENTS.includes(name) : name === "points";
}

/** What a target follows; the other way is made from what it has. @param {Values} row @param {() => void} again */
export function pathChoice(row, again) {
  if (!("points" in row && "segments" in row)) return null;
  return h("select", {
    "aria-label": t("scenarios.path"), style: "width: auto", value: row.points.length ? "points" : "segments",
    onchange: (/** @type {Event} */ event) => {
      const points = /** @type {HTMLSelectElement} */ (event.target).value === "points";
      if (points) {
        const seconds = row.segments.reduce((/** @type {number} */ sum, /** @type {Values} */ one) => sum + one.duration_s, 0) || 60;
        const heading = (row.heading_deg * Math.PI) / 180;
        const place = (/** @type {number} */ time) => ({ time_s: time, east_m: Math.round(row.east_m + time * row.speed_mps * Math.sin(heading)), north_m: Math.round(row.north_m + time * row.speed_mps * Math.cos(heading)), altitude_m: row.altitude_m, up_m: null });
        row.points = [place(0), place(seconds)];
        row.segments = [];
      } else {
        const [first, last] = [row.points[0], row.points[row.points.length - 1]];
        row.segments = [{ duration_s: Math.max(last.time_s - first.time_s, 1), turn_rate_deg_s: 0, climb_rate_mps: 0, acceleration_mps2: 0 }];
        [row.east_m, row.north_m] = [first.east_m, first.north_m];
        row.points = [];
      }
      again();
    },
  }, h("option", { value: "segments" }, t("scenarios.by_segments")), h("option", { value: "points" }, t("scenarios.by_points")));
}
