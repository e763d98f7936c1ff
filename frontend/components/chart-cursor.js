// @ts-check
// The cursor of a chart: follows the pointer and the keys, tells the bus that all charts of the page share, and draws
// where that stands in this chart, with its values in the strip below.

import { h, put, svg } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { describePoints, isOverTime, rowOf } from "../js/figure.js";
import { Moments } from "../js/moments.js";
import { pieceAt, pieceName } from "../js/pieces.js";
import { replayed } from "../js/replay.js";

/** @import { PlotlyElement } from "../types.d.ts" */
/** @import { ChartPanel } from "./chart-panel.js" */
/** @import { Point } from "../js/moments.js" */

/** @typedef {{time: number, row: number | null, label?: string | null}} Mark */

// A press and its release no further apart than this are a click and not a drag.
const CLICK_PX = 4;
// A replay shows so much of the past, and at most so many points of a curve in it.
const TRAIL_S = 60;
const TRAIL_POINTS = 300;

export class ChartCursor {
  /** Which points stand at an instant; null until the chart is drawn. @type {Moments | null} */
  moments = null;
  /** @type {(Point & {piece: ReturnType<typeof pieceAt>})[]} */
  marked = [];
  /** The mark under the pointer in a plan. @type {Mark | null} */
  hovered = null;
  /** Whether only the last minute before the instant is strong, as in a replay. */
  trailing = false;

  /**
   * @param {ChartPanel} panel
   * @param {PlotlyElement} plot
   */
  constructor(panel, plot) {
    this.panel = panel;
    this.plot = plot;
    this.overlay = svg("svg", { class: "overlay", "aria-hidden": "true" });
    this.strip = h("div", { class: "strip", role: "group", "aria-label": t("chart.strip_hint") }, t("chart.strip_hint"));
    this.told = h("span", { class: "sr-only", "aria-live": "polite" });
  }

  get bus() {
    return this.panel.bus;
  }

  get figure() {
    return this.panel.figure;
  }

  /** Follow the pointer, the keys and the other charts until the panel goes away. @param {AbortSignal} signal */
  listen(signal) {
    const { plot, bus } = this;
    this.signal = signal;
    plot.addEventListener("keydown", (event) => this.onKey(event), { signal });
    plot.addEventListener("pointermove", (event) => this.onMove(event), { signal });
    plot.addEventListener("pointerdown", (event) => this.onPress(event), { signal, capture: true });
    plot.addEventListener("pointerleave", () => this.onLeave(), { signal });
    bus?.addEventListener("change", () => this.show(), { signal });
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      bus?.release();
      if (this.panel.tools?.measuring) this.panel.tools.setMeasuring(false);
    }, { signal });
  }

  /** Take over what Plotly has drawn. @param {boolean} fresh whether it is the first time */
  takeOver(fresh) {
    const { plot, figure } = this;
    if (!figure) return;
    if (fresh) {
      plot.on?.("plotly_hover", (event) => this.onHover(event));
      plot.on?.("plotly_afterplot", () => this.place());
    }
    this.moments = new Moments(plot._fullData ?? [], isOverTime(figure));
    this.hovered = null;
  }

  /** The chart is empty: nothing stands at any instant. */
  forget() {
    this.moments = null;
    this.hovered = null;
    this.show();
  }

  /** In a plan, the mark under the pointer; in a map over time, the cell. @param {any} event */
  onHover(event) {
    const first = event.points?.[0];
    if (!first || !this.figure || this.bus?.now.locked) return;
    if (isOverTime(this.figure)) {
      this.describe(event.points.map((/** @type {any} */ point) => ({ trace: point.fullData, x: point.x, y: point.y, z: point.z })), this.bus?.now.time ?? null);
      return;
    }
    const mark = markOf(first);
    this.hovered = mark;
    if (mark) this.bus?.look(mark.time, mark);
    else this.describe([{ trace: first.fullData, x: first.x, y: first.y, text: first.hovertext, value: first.fullData.type === "heatmap" ? first.customdata : undefined }], null);
  }

  /** Over time, the instant under the pointer is looked at, at the nearest mark. @param {PointerEvent} event */
  onMove(event) {
    this.panel.tools?.move(event);
    if (event.buttons || !this.bus || this.bus.now.locked || !this.figure || !isOverTime(this.figure)) return;
    const mark = this.markUnder(event);
    if (mark) this.bus.look(mark.time, mark);
  }

  /** @param {PointerEvent} event @returns {Mark | null} */
  markUnder(event) {
    const axis = this.plot._fullLayout?.xaxis;
    if (!axis || !this.moments) return null;
    const left = event.clientX - this.plot.getBoundingClientRect().left - axis._offset;
    if (left < 0 || left > axis._length) return null;
    const time = Number(axis.p2d(left));
    return this.moments.snap(time) ?? { time, row: null };
  }

  /** @param {PointerEvent} down */
  onPress(down) {
    if (down.button !== 0 || !this.bus) return;
    // Plotly covers the page while a button is down, so what lay under the pointer is only known now.
    const { hovered } = this;
    window.addEventListener("pointerup", (up) => {
      if (Math.hypot(up.clientX - down.clientX, up.clientY - down.clientY) > CLICK_PX) return;
      this.plot.focus({ preventScroll: true });
      this.onClick(up, hovered);
    }, { once: true, signal: this.signal });
  }

  /**
   * A click locks the cursor where it is, a second one at the same mark frees it; a click on a track of a plan also
   * asks for its target alone.
   * @param {PointerEvent} event
   * @param {Mark | null} hovered the mark that lay under the pointer
   */
  onClick(event, hovered) {
    if (!this.bus || !this.figure || this.panel.tools?.press(event)) return;
    const overTime = isOverTime(this.figure);
    const mark = overTime ? this.markUnder(event) : hovered;
    if (!mark) return;
    const { now } = this.bus;
    if (now.locked && now.time === mark.time && now.row === mark.row) {
      this.bus.release();
      return;
    }
    this.lock(mark);
    if (!overTime) this.panel.onpick?.(mark);
  }

  /** @param {Mark} mark */
  lock(mark) {
    this.bus?.look(mark.time, { row: mark.row, label: mark.label ?? null, lock: true });
    // Only the chart that was acted on speaks; the others follow in silence.
    this.told.textContent = [...this.strip.children].map((part) => part.textContent).join(", ");
  }

  onLeave() {
    this.hovered = null;
    this.panel.tools?.move(null);
    if (this.bus && !this.bus.now.locked) this.bus.release();
    else if (!this.bus) put(this.strip, t("chart.strip_hint"));
  }

  /** Arrow keys step one mark, Enter takes the mark: as an end of a distance, or its target alone. @param {KeyboardEvent} event */
  onKey(event) {
    if (!this.bus || !this.moments) return;
    if (event.key === "Enter") this.onEnter();
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const { time, row, label } = this.bus.now;
    const mark = this.moments.step(time, row, step);
    if (mark) this.lock({ ...mark, label });
  }

  onEnter() {
    const { tools } = this.panel;
    const place = this.marked[0];
    if (tools?.measuring) {
      if (place) tools.take({ east: place.x * tools.unit_m, north: place.y * tools.unit_m });
      return;
    }
    const { time, row, label } = this.bus?.now ?? {};
    if (typeof time === "number" && typeof row === "number") this.panel.onpick?.({ time, row, label });
  }

  /** Follow the cursor that all charts of the page share. */
  show() {
    const { time, row, locked } = this.bus?.now ?? { time: null, row: null, locked: false };
    this.marked = time === null || !this.moments ? [] : this.moments.at(time, row).map((point) => ({ ...point, piece: pieceAt(point.trace, point.at) }));
    this.panel.toggleAttribute("data-locked", locked);
    if (!locked) this.trailing = false;
    this.panel.toggleAttribute("data-trailing", this.trailing);
    if (time === null) put(this.strip, t("chart.strip_hint"));
    else if (this.figure && this.plot._fullData) this.describe(this.marked, time);
    // Values that a locked cursor leaves outside can be scrolled to by keyboard.
    const scrolls = locked && this.strip.scrollHeight > this.strip.clientHeight;
    if (scrolls) this.strip.tabIndex = 0;
    else this.strip.removeAttribute("tabindex");
    this.place();
  }

  /** Draw the cursor over the chart: a line at the instant, or a ring around each point that stands there. */
  place() {
    const layout = this.plot._fullLayout;
    put(this.overlay);
    const time = this.bus?.now.time ?? null;
    // In space nothing lies over the drawing; the values stand below.
    if (!layout || !this.figure || this.figure.layout.scene) return;
    if (isOverTime(this.figure)) this.placeLine(layout, time);
    else this.placeRings(layout, time);
  }

  /**
   * @param {Record<string, any>} layout
   * @param {number | null} time
   */
  placeLine(layout, time) {
    const x = layout.xaxis;
    const left = time === null ? NaN : x._offset + x.d2p(time);
    const rows = Object.keys(layout).filter((name) => /^yaxis\d*$/.test(name)).map((name) => layout[name]);
    if (!(left >= x._offset - 1 && left <= x._offset + x._length + 1)) return;
    this.overlay.append(svg("line", { x1: left, x2: left, y1: Math.min(...rows.map((y) => y._offset)), y2: Math.max(...rows.map((y) => y._offset + y._length)) }));
  }

  /**
   * @param {Record<string, any>} layout
   * @param {number | null} time
   */
  placeRings(layout, time) {
    const { xaxis: x, yaxis: y } = layout;
    // A drawing of its own, so that nothing reaches beyond the axes.
    const inner = svg("svg", { x: x._offset, y: y._offset, width: x._length, height: y._length });
    this.overlay.append(inner);
    this.panel.tools?.paint(inner, layout);
    const trail = this.trailing && time !== null && this.moments ? this.moments.between(time - TRAIL_S, time, TRAIL_POINTS) : [];
    // The track or target that the mark looked at is of, out of many.
    const followed = this.marked.filter((point) => point.piece && point.row !== null && point.row === this.bus?.now.row);
    inner.append(...followed.flatMap(({ trace, piece }) => outlined(trace, /** @type {NonNullable<typeof piece>} */ (piece), x, y)));
    const dot = (/** @type {any} */ point, /** @type {number} */ r, /** @type {string} */ name) => svg("circle", {
      cx: x.d2p(point.x), cy: y.d2p(point.y), r, class: name, style: `color: ${point.trace.line?.color ?? point.trace.marker?.color}`,
    });
    inner.append(...replayed(this.figure?.layout?.meta?.replay, time, this.plot._fullData ?? [], x, y));
    inner.append(...trail.map((point) => dot(point, 2, "trail")), ...this.marked.map((point) => dot(point, 8, "mark")));
  }

  /**
   * @param {{trace: any, x: any, y: any, z?: any, text?: any, value?: any, piece?: {number: number} | null}[]} points
   * @param {number | null} time
   */
  describe(points, time) {
    const parts = describePoints(points.map((point) => ({ ...point, of: point.piece ? pieceName(point.trace, point.piece.number) : "" })), this.figure?.layout ?? {}, time);
    put(this.strip, parts.map((part) => h("span", null,
      part.colour ? h("span", { class: "swatch", style: `border-color: ${part.colour}` }) : null,
      part.name, part.value ? " " : null, part.value ? h("b", null, part.value) : null)));
  }
}

/**
 * A piece of a line, strong, with a rim that sets it off from the others.
 * @param {any} trace
 * @param {{from: number, to: number}} piece
 * @param {any} x axes
 * @param {any} y
 */
function outlined(trace, { from, to }, x, y) {
  const places = Array.from({ length: to - from }, (_, k) => `${x.d2p(trace.x[from + k])},${y.d2p(trace.y[from + k])}`);
  return ["piece rim", "piece"].map((name) => svg("polyline", { class: name, points: places.join(" "), style: `color: ${trace.line?.color}` }));
}

/** The mark that a point of a plan stands for. @param {any} point @returns {Mark | null} */
function markOf(point) {
  const row = rowOf(point.customdata);
  const time = Number(point.text || NaN);
  return row === null || !Number.isFinite(time) ? null : { time, row, label: point.fullData.meta?.label ?? null };
}
