// @ts-check
// Where the stations stand and how accurate they are: only the columns that the site really gives.

import { h } from "../js/dom.js";
import { t, told } from "../js/i18n.js";
import { formatExact } from "../js/numbers.js";
import { emptyState } from "./states.js";

/** @import { Site, Station } from "../types.d.ts" */

const GROUPS = /** @type {const} */ (["stations", "radars", "transmitters", "receivers"]);

/** @param {Site | null} site */
export function siteTable(site) {
  if (!site) return emptyState(t("site.none"));
  const groups = GROUPS.filter((name) => site[name]?.length);
  const own = Object.entries(site).filter(([name, value]) => !GROUPS.includes(/** @type {"stations"} */ (name)) && name !== "origin" && value !== null && value !== undefined);
  return h("div", { class: "stack" },
    groups.map((name) => placeTable(told(`site.${name}`, name), site[name] ?? [])),
    site.origin ? h("p", { class: "small muted" }, t("site.origin", {
      latitude: formatExact(site.origin.latitude_deg), longitude: formatExact(site.origin.longitude_deg), height: formatExact(site.origin.height_m ?? 0),
    })) : null,
    own.length ? h("dl", { class: "pairs" }, own.flatMap(([name, value]) => [h("dt", null, h("code", null, name)), h("dd", null, formatExact(value))])) : null);
}

/**
 * @param {string} caption
 * @param {Station[]} places
 */
function placeTable(caption, places) {
  const columns = [...new Set(places.flatMap((place) => Object.keys(place)))]
    .filter((name) => name !== "name" && places.some((place) => place[name] !== null && place[name] !== undefined && place[name] !== ""));
  return h("div", { class: "table-wrap tall", tabindex: 0, role: "region", "aria-label": caption },
    h("table", null,
      h("caption", null, `${caption}: ${places.length}`),
      h("thead", null, h("tr", null, h("th", { scope: "col" }, t("site.name")), columns.map((name) => h("th", { scope: "col", class: "number" }, h("code", null, name))))),
      h("tbody", null, places.map((place) => h("tr", null,
        h("th", { scope: "row" }, place.name),
        columns.map((name) => h("td", { class: "number" }, formatPlace(name, place[name]))))))));
}

/**
 * Millimetres and 1e-7 degrees are beyond any survey of a station.
 * @param {string} name
 * @param {unknown} value
 */
function formatPlace(name, value) {
  if (typeof value !== "number") return formatExact(value);
  return formatExact(Number(value.toFixed(name.endsWith("_deg") ? 7 : 3)));
}
