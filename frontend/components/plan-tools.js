// @ts-check
// What a plan tells of the place under the pointer, and what can be measured on it: range rings, distances.

import { define, h, put, svg } from "../js/dom.js";
import { axisTitle, splitTitle } from "../js/figure.js";
import { enuToGeodetic, niceStep, rangeAzimuth } from "../js/geodesy.js";
import { t } from "../js/i18n.js";
import { formatExact, formatNumber } from "../js/numbers.js";

/** @import { ChartPanel } from "./chart-panel.js" */
/** @import { Origin } from "../js/geodesy.js" */

/** @typedef {{east: number, north: number}} Place in metres */

const RINGS = 5;
// Rings beyond the view are not drawn; a view far from the origin would need thousands.
const MOST_RINGS = 40;

export class PlanTools extends HTMLElement {
  /** @type {ChartPanel | null} */
  panel = null;
  /** @type {Origin | null} */
  origin = null;
  rings = false;
  measuring = false;
  /** The ends of the distance. @type {Place[]} */
  ends = [];
  /** @type {Place | null} */
  pointer = null;

  connectedCallback() {
    this.className = "plan-tools small";
    this.readout = h("span", { class: "readout" });
    this.measured = h("b", { class: "readout", role: "status" });
    this.ringButton = h("button", { type: "button", class: "plain", "aria-pressed": String(this.rings), onclick: () => this.toggleRings() }, t("plan.rings"));
    this.measureButton = h("button", { type: "button", class: "plain", "aria-pressed": "false", title: t("plan.measure_hint"), onclick: () => this.setMeasuring(!this.measuring) }, t("plan.measure"));
    put(this, h("div", { class: "words" }, this.measured, this.readout), h("div", { class: "row tight" }, this.ringButton, this.measureButton));
    this.say();
  }

  /** Metres for one unit of the plan's axes. */
  get unit_m() {
    const title = axisTitle(this.panel?.figure?.layout.xaxis);
    return splitTitle(title).unit === "m" ? 1 : 1000;
  }

  /** The place under the pointer, or null outside of the axes. @param {MouseEvent} event @returns {Place | null} */
  placeOf(event) {
    const plot = this.panel?.plot;
    const layout = plot?._fullLayout;
    if (!plot || !layout) return null;
    const box = plot.getBoundingClientRect();
    const [left, top] = [event.clientX - box.left - layout.xaxis._offset, event.clientY - box.top - layout.yaxis._offset];
    if (left < 0 || top < 0 || left > layout.xaxis._length || top > layout.yaxis._length) return null;
    return { east: layout.xaxis.p2d(left) * this.unit_m, north: layout.yaxis.p2d(top) * this.unit_m };
  }

  /** @param {MouseEvent | null} event */
  move(event) {
    this.pointer = event && this.placeOf(event);
    this.say();
    if (this.measuring && this.ends.length === 1) this.panel?.cursor?.place();
  }

  /** Take a point of the distance; false where the click is for somebody else. @param {MouseEvent} event */
  press(event) {
    const place = this.measuring ? this.placeOf(event) : null;
    if (place) this.take(place);
    return this.measuring;
  }

  /** @param {Place} place */
  take(place) {
    this.ends = this.ends.length === 1 ? [...this.ends, place] : [place];
    this.say();
    this.panel?.cursor?.place();
  }

  toggleRings() {
    this.rings = !this.rings;
    this.ringButton?.setAttribute("aria-pressed", String(this.rings));
    this.panel?.cursor?.place();
  }

  /** @param {boolean} on */
  setMeasuring(on) {
    this.measuring = on;
    this.ends = [];
    this.measureButton?.setAttribute("aria-pressed", String(on));
    this.panel?.toggleAttribute("data-measuring", on);
    this.say();
    this.panel?.cursor?.place();
  }

  say() {
    const { pointer, ends, readout, measured } = this;
    if (!readout || !measured) return;
    put(readout, ...(pointer ? this.words(pointer) : [t("plan.hint")]));
    const [from, to = pointer] = ends;
    if (!this.measuring) put(measured);
    else if (!from || !to) put(measured, t("plan.measure_hint"));
    else {
      const { range_m, azimuth_deg } = rangeAzimuth(to.east - from.east, to.north - from.north);
      put(measured, t("plan.distance", { range: lengthOf(range_m), azimuth: azimuth_deg.toFixed(1) }));
    }
  }

  /** @param {Place} place */
  words(place) {
    const { range_m, azimuth_deg } = rangeAzimuth(place.east, place.north);
    const words = [t("chart.place", { east: formatNumber(place.east / this.unit_m, 5), north: formatNumber(place.north / this.unit_m, 5), unit: t(this.unit_m === 1 ? "unit.m" : "unit.km") })];
    if (this.origin) {
      const { latitude_deg, longitude_deg } = enuToGeodetic(this.origin, place.east, place.north);
      words.push(t(latitude_deg < 0 ? "plan.south" : "plan.north", { degrees: Math.abs(latitude_deg).toFixed(5) }) + " " + t(longitude_deg < 0 ? "plan.west" : "plan.east", { degrees: Math.abs(longitude_deg).toFixed(5) }));
    }
    words.push(t("plan.from_origin", { range: lengthOf(range_m), azimuth: azimuth_deg.toFixed(1) }));
    return words.map((one) => h("span", null, one));
  }

  /** Draw rings and the distance over the plan. @param {SVGElement} overlay @param {Record<string, any>} layout */
  paint(overlay, layout) {
    const { xaxis: x, yaxis: y } = layout;
    if (this.rings) this.paintRings(overlay, x, y);
    const [from, to = this.pointer] = this.ends;
    if (!from) return;
    const place = (/** @type {Place} */ one) => [x.d2p(one.east / this.unit_m), y.d2p(one.north / this.unit_m)];
    const [x1, y1] = place(from);
    overlay.append(svg("circle", { cx: x1, cy: y1, r: 4, class: "end" }));
    if (!to) return;
    const [x2, y2] = place(to);
    overlay.append(svg("line", { x1, y1, x2, y2, class: "distance" }), svg("circle", { cx: x2, cy: y2, r: 4, class: "end" }));
  }

  /**
   * @param {SVGElement} overlay
   * @param {any} x
   * @param {any} y
   */
  paintRings(overlay, x, y) {
    const [west, east] = x.range.map(Number);
    const [south, north] = y.range.map(Number);
    const step = niceStep(Math.max(east - west, north - south) / 2, RINGS);
    const nearest = Math.hypot(Math.max(west, -east, 0), Math.max(south, -north, 0));
    const furthest = Math.hypot(Math.max(-west, east), Math.max(-south, north));
    const [cx, cy] = [x.d2p(0), y.d2p(0)];
    const first = Math.max(1, Math.ceil(nearest / step));
    for (let k = first; k * step <= furthest && k < first + MOST_RINGS; k += 1) {
      const r = Math.abs(x.d2p(k * step) - cx);
      overlay.append(svg("circle", { cx, cy, r, class: "ring" }), svg("text", { x: cx + 3, y: cy - r - 3, class: "ring" }, ringName(k * step * this.unit_m)));
    }
  }
}

/** @param {number} metres */
function lengthOf(metres) {
  return metres >= 10000 ? `${formatNumber(metres / 1000, 4)} ${t("unit.km")}` : `${formatNumber(metres, 4)} ${t("unit.m")}`;
}

/** @param {number} metres */
function ringName(metres) {
  return metres >= 1000 ? `${formatExact(metres / 1000)} ${t("unit.km")}` : `${formatExact(metres)} ${t("unit.m")}`;
}

define("plan-tools", PlanTools);

/**
 * @param {ChartPanel} panel the plan
 * @param {Origin | null | undefined} origin of the site, where it has one
 */
export function planTools(panel, origin) {
  const tools = /** @type {PlanTools} */ (document.createElement("plan-tools"));
  Object.assign(tools, { panel, origin: origin ?? null });
  panel.tools = tools;
  return tools;
}
