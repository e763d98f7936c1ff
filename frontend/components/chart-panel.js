// @ts-check
// One chart of a run or a recording: fetched when it becomes visible, drawn in the theme's colours, with its values
// in a fixed strip, its cursor shared with the other charts, and its data one click away.

import { define, h, put, svg } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { apiUrl, get } from "../js/api.js";
import { t, told } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { describePoints, dressFigure, isOverTime, rowOf } from "../js/figure.js";
import { Moments } from "../js/moments.js";
import { loadPlotly } from "../js/plotly.js";
import { chartColours, isDark, themes } from "../js/theme.js";
import { failed, loading, notApplicable } from "./states.js";
import { chartMenu } from "./chart-menu.js";
import { chartTable } from "./chart-table.js";

/** @import { Figure, PlotlyElement, PlotlyLibrary } from "../types.d.ts" */
/** @import { CursorBus } from "../js/cursor.js" */
/** @import { Query } from "../js/api.js" */
/** @import { Point } from "../js/moments.js" */
/** @import { PlanTools } from "./plan-tools.js" */

const CONFIG = { displaylogo: false, showSendToCloud: false, plotlyServerURL: "", displayModeBar: false, doubleClick: "reset+autosize" };
const NARROW_PX = 480;
// A press and its release no further apart than this are a click and not a drag.
const CLICK_PX = 4;
// A replay shows so much of the past, and at most so many points of a curve in it.
const TRAIL_S = 60;
const TRAIL_POINTS = 300;
// Points of a curve; marks are drawn one by one up to ten times as many for each entry. SVG draws these at once.
const POINTS = 1500;
// More points than this would stop the browser for seconds; they are in the CSV.
const MOST_POINTS = 60000;

export class ChartPanel extends HTMLElement {
  /** Where the chart's data are: `runs/ID/charts/plan`. */
  source = "";
  /** What the addresses of its data ask for besides. @type {Query} */
  query = {};
  heading = "";
  /** @type {CursorBus | null} */
  bus = null;
  /** @type {Set<string>} labels whose traces are hidden */
  hiddenLabels = new Set();
  full = false;
  panning = false;
  /** @type {Figure | null} */
  figure = null;
  /** @type {PlotlyLibrary | null} */
  plotly = null;
  /** Which points stand at an instant; null until the chart is drawn. @type {Moments | null} */
  moments = null;
  /** @type {Point[]} */
  marked = [];
  /** What a plan measures. @type {PlanTools | null} */
  tools = null;
  /** Stands under the values. @type {HTMLElement[]} */
  foot = [];
  /** Whether only the last minute before the instant is strong, as in a replay. */
  trailing = false;

  connectedCallback() {
    this.stop = new AbortController();
    const { signal } = this.stop;
    this.plot = /** @type {PlotlyElement} */ (h("div", { class: "plot", role: "img", tabindex: 0, "aria-label": this.heading }));
    this.overlay = svg("svg", { class: "overlay", "aria-hidden": "true" });
    this.body = h("div", { class: "body" }, loading());
    this.strip = h("div", { class: "strip" }, t("chart.strip_hint"));
    this.told = h("span", { class: "sr-only", "aria-live": "polite" });
    this.note = h("span", { class: "note small muted" });
    this.tableButton = h("button", { class: "plain", type: "button", "aria-pressed": "false", title: t("chart.as_table"), "aria-label": `${t("chart.as_table")}: ${this.heading}`, onclick: () => this.toggleTable() }, icon("table"));
    put(this,
      h("div", { class: "head" },
        h("h2", { class: "clip", title: this.heading }, this.heading), this.note,
        h("div", { class: "actions" }, this.tableButton,
          h("button", { class: "plain", type: "button", title: t("chart.expand"), "aria-label": `${t("chart.expand")}: ${this.heading}`, onclick: () => this.toggleFullscreen() }, icon("expand")),
          chartMenu(this))),
      this.body, this.strip, ...this.foot, this.told);
    this.plot.addEventListener("keydown", (event) => this.onKey(event), { signal });
    this.plot.addEventListener("pointermove", (event) => this.onMove(event), { signal });
    this.plot.addEventListener("pointerdown", (event) => this.onPress(event), { signal, capture: true });
    this.plot.addEventListener("pointerleave", () => this.onLeave(), { signal });
    themes.addEventListener("change", () => this.draw(), { signal });
    this.bus?.addEventListener("change", () => this.showCursor(), { signal });
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      this.bus?.release();
      if (this.tools?.measuring) this.tools.setMeasuring(false);
    }, { signal });
    this.seen = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      this.seen?.disconnect();
      this.load();
    }, { rootMargin: "200px" });
    this.seen.observe(this);
    this.sizes = new ResizeObserver(() => this.fit());
    this.sizes.observe(this.body);
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.seen?.disconnect();
    this.sizes?.disconnect();
    if (this.plot && this.plotly) this.plotly.purge(this.plot);
    this.figure = null;
  }

  /** Fetch the figure and draw it; called again when the run has moved on. */
  async load() {
    try {
      const [figure, plotly] = await Promise.all([
        /** @type {Promise<Figure>} */ (get(`${this.source}.json`, { query: { ...this.query, ...(this.full ? { full: true } : { points: POINTS }) }, signal: this.stop?.signal })),
        loadPlotly(),
      ]);
      this.figure = figure;
      this.plotly = plotly;
      await this.draw();
    } catch (error) {
      if (!this.stop?.signal.aborted && this.body) put(this.body, failed(error, { retry: () => this.load() }));
    }
  }

  /** Draw what was fetched, in the colours of the theme. */
  async draw() {
    const { figure, plotly, plot, body, overlay } = this;
    if (!figure || !plotly || !plot || !body || !overlay || !this.isConnected) return;
    this.showNotes(figure);
    const reason = figure.layout.meta?.not_applicable;
    if (reason) {
      put(body, notApplicable(told(`chart.reason.${reason}`, figure.layout.meta.detail ?? reason)));
      return;
    }
    if (plot.parentElement !== body) put(body, plot, overlay);
    const narrow = body.clientWidth < NARROW_PX;
    const dressed = dressFigure(figure, {
      colours: chartColours(), dark: isDark(), hidden: this.hiddenLabels, narrow, font: getComputedStyle(this).fontFamily,
    });
    dressed.layout.dragmode = this.panning ? "pan" : "zoom";
    this.narrow = narrow;
    const fresh = !plot._fullLayout;
    await plotly.react(plot, dressed.data, dressed.layout, CONFIG);
    if (fresh) {
      plot.on?.("plotly_hover", (event) => this.onHover(event));
      plot.on?.("plotly_afterplot", () => this.placeCursor());
    }
    this.moments = new Moments(plot._fullData ?? [], isOverTime(figure));
    plot.setAttribute("aria-label", this.summary());
    this.dataset.drawn = "yes";
    this.dispatchEvent(new Event("drawn"));
    this.showCursor();
  }

  /** What a reader who cannot see the chart is told. */
  summary() {
    const traces = (this.plot?._fullData ?? []).filter((trace) => trace.visible !== false && trace.name);
    const names = [...new Set(traces.map((trace) => trace.name))].join(", ");
    return t("chart.summary", { title: this.heading, names });
  }

  /** @param {Figure} figure */
  showNotes(figure) {
    const about = figure.layout.meta ?? {};
    const parts = [];
    if (about.decimated) {
      parts.push(h("span", { class: "nowrap" }, t("chart.decimated", { shown: formatCount(about.decimated.shown), of: formatCount(about.decimated.of) })),
        about.decimated.of <= MOST_POINTS ? h("button", { class: "link", type: "button", onclick: () => this.setFull(true) }, t("chart.all_points"))
          : h("a", { href: this.address("csv"), download: "" }, t("chart.all_in_csv")));
    } else if (this.full) {
      parts.push(h("button", { class: "link", type: "button", onclick: () => this.setFull(false) }, t("chart.fewer_points")));
    }
    const notes = (about.notes ?? []).map((/** @type {any} */ note) => `${note.label ? `${note.label}: ` : ""}${told(`chart.note.${note.code}`, note.text)}`);
    if (notes.length) {
      parts.push(h("button", { class: "link", type: "button", title: notes.join("\n"), "aria-expanded": "false", onclick: (/** @type {Event} */ event) => this.toggleNotes(notes, /** @type {HTMLElement} */ (event.target)) }, t("chart.notes", { n: notes.length })));
    }
    put(/** @type {HTMLElement} */ (this.note), ...parts);
  }

  /**
   * @param {string[]} notes
   * @param {HTMLElement} button
   */
  toggleNotes(notes, button) {
    const shown = this.body?.querySelector(".notes");
    button.setAttribute("aria-expanded", String(!shown));
    if (shown) shown.remove();
    else this.body?.append(h("ul", { class: "notes small", role: "status" }, notes.map((note) => h("li", null, note))));
  }

  /** @param {boolean} full */
  async setFull(full) {
    this.full = full;
    await this.load();
  }

  /** Hide the traces of these labels. @param {Set<string>} labels */
  hideLabels(labels) {
    this.hiddenLabels = labels;
    this.draw();
  }

  /** In a plan, the mark under the pointer; in a map over time, the cell. @param {any} event */
  onHover(event) {
    const first = event.points?.[0];
    if (!first || !this.figure || this.bus?.now.locked) return;
    if (isOverTime(this.figure)) {
      this.describe(event.points.map((/** @type {any} */ point) => ({ trace: point.fullData, x: point.x, y: point.y, z: point.z })), this.bus?.now.time ?? null);
      return;
    }
    const mark = this.markOf(first);
    this.hovered = mark;
    if (mark) this.bus?.look(mark.time, mark);
    else this.describe([{ trace: first.fullData, x: first.x, y: first.y }], null);
  }

  /** The mark that a point of a plan stands for. @param {any} point */
  markOf(point) {
    const row = rowOf(point.customdata);
    const time = Number(point.text || NaN);
    return row === null || !Number.isFinite(time) ? null : { time, row, label: point.fullData.meta?.label ?? null };
  }

  /** Over time, the instant under the pointer is looked at, at the nearest mark. @param {PointerEvent} event */
  onMove(event) {
    this.tools?.move(event);
    if (event.buttons || !this.bus || this.bus.now.locked || !this.figure || !isOverTime(this.figure)) return;
    const mark = this.markUnder(event);
    if (mark) this.bus.look(mark.time, mark);
  }

  /** @param {PointerEvent} event */
  markUnder(event) {
    const axis = this.plot?._fullLayout?.xaxis;
    if (!axis || !this.moments || !this.plot) return null;
    const left = event.clientX - this.plot.getBoundingClientRect().left - axis._offset;
    if (left < 0 || left > axis._length) return null;
    const time = Number(axis.p2d(left));
    return this.moments.snap(time) ?? { time, row: null };
  }

  /** A click locks the cursor where it is, a second one at the same mark frees it. @param {PointerEvent} down */
  onPress(down) {
    if (down.button !== 0 || !this.bus) return;
    window.addEventListener("pointerup", (up) => {
      if (Math.hypot(up.clientX - down.clientX, up.clientY - down.clientY) > CLICK_PX) return;
      this.plot?.focus({ preventScroll: true });
      this.onClick(up);
    }, { once: true, signal: this.stop?.signal });
  }

  /** @param {PointerEvent} event */
  onClick(event) {
    if (!this.bus || !this.figure || this.tools?.press(event)) return;
    const mark = isOverTime(this.figure) ? this.markUnder(event) : this.hovered;
    if (!mark) return;
    const { now } = this.bus;
    if (now.locked && now.time === mark.time && now.row === mark.row) this.bus.release();
    else this.lock(mark);
  }

  /** @param {{time: number, row: number | null, label?: string | null}} mark */
  lock(mark) {
    this.bus?.look(mark.time, { row: mark.row, label: mark.label ?? null, lock: true });
    // Only the chart that was acted on speaks; the others follow in silence.
    if (this.told && this.strip) this.told.textContent = [...this.strip.children].map((part) => part.textContent).join(", ");
  }

  onLeave() {
    this.hovered = null;
    this.tools?.move(null);
    if (this.bus && !this.bus.now.locked) this.bus.release();
    else if (!this.bus) put(/** @type {HTMLElement} */ (this.strip), t("chart.strip_hint"));
  }

  /** Arrow keys step one mark, Escape frees the cursor. @param {KeyboardEvent} event */
  onKey(event) {
    if (!this.bus || !this.moments) return;
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    const place = this.marked[0];
    if (event.key === "Enter" && this.tools?.measuring && place) this.tools.take({ east: place.x * this.tools.unit_m, north: place.y * this.tools.unit_m });
    if (!step) return;
    event.preventDefault();
    const { time, row, label } = this.bus.now;
    const mark = this.moments.step(time, row, step);
    if (mark) this.lock({ ...mark, label });
  }

  /** Follow the cursor that all charts of the page share. */
  showCursor() {
    const { time, row, locked } = this.bus?.now ?? { time: null, row: null, locked: false };
    this.marked = time === null || !this.moments ? [] : this.moments.at(time, row);
    this.toggleAttribute("data-locked", locked);
    if (!locked) this.trailing = false;
    this.toggleAttribute("data-trailing", this.trailing);
    if (time === null) put(/** @type {HTMLElement} */ (this.strip), t("chart.strip_hint"));
    else if (this.figure && this.plot?._fullData) this.describe(this.marked, time);
    this.placeCursor();
  }

  /** Draw the cursor over the chart: a line at the instant, or a ring around each point that stands there. */
  placeCursor() {
    const layout = this.plot?._fullLayout;
    const overlay = /** @type {SVGElement} */ (this.overlay);
    put(overlay);
    const time = this.bus?.now.time ?? null;
    if (!layout || !this.figure) return;
    if (isOverTime(this.figure)) {
      const x = layout.xaxis;
      const left = time === null ? NaN : x._offset + x.d2p(time);
      const rows = Object.keys(layout).filter((name) => /^yaxis\d*$/.test(name)).map((name) => layout[name]);
      if (!(left >= x._offset - 1 && left <= x._offset + x._length + 1)) return;
      overlay.append(svg("line", { x1: left, x2: left, y1: Math.min(...rows.map((y) => y._offset)), y2: Math.max(...rows.map((y) => y._offset + y._length)) }));
      return;
    }
    const { xaxis: x, yaxis: y } = layout;
    // A drawing of its own, so that nothing reaches beyond the axes.
    const inner = svg("svg", { x: x._offset, y: y._offset, width: x._length, height: y._length });
    overlay.append(inner);
    this.tools?.paint(inner, layout);
    const trail = this.trailing && time !== null && this.moments ? this.moments.between(time - TRAIL_S, time, TRAIL_POINTS) : [];
    const dot = (/** @type {any} */ point, /** @type {number} */ r, /** @type {string} */ name) => svg("circle", {
      cx: x.d2p(point.x), cy: y.d2p(point.y), r, class: name, style: `color: ${point.trace.line?.color ?? point.trace.marker?.color}`,
    });
    inner.append(...trail.map((point) => dot(point, 2, "trail")), ...this.marked.map((point) => dot(point, 8, "mark")));
  }

  /**
   * @param {{trace: any, x: any, y: any, z?: any}[]} points
   * @param {number | null} time
   */
  describe(points, time) {
    const parts = describePoints(points, this.figure?.layout ?? {}, time);
    put(/** @type {HTMLElement} */ (this.strip), parts.map((part) => h("span", null,
      part.colour ? h("span", { class: "swatch", style: `border-color: ${part.colour}` }) : null,
      part.name, part.value ? " " : null, part.value ? h("b", null, part.value) : null)));
  }

  async toggleTable() {
    const on = this.tableButton?.getAttribute("aria-pressed") !== "true";
    this.tableButton?.setAttribute("aria-pressed", String(on));
    this.body?.querySelector(".as-table")?.remove();
    if (on) this.body?.append(await chartTable(this.source, this.heading, this.query));
  }

  toggleFullscreen() {
    if (document.fullscreenElement === this) document.exitFullscreen();
    else this.requestFullscreen();
  }

  resetView() {
    if (!this.plot || !this.plotly || !this.figure) return;
    const { layout } = this.figure;
    /** @type {Record<string, unknown>} */
    const update = {};
    for (const name of Object.keys(layout)) {
      if (!/^[xy]axis\d*$/.test(name)) continue;
      if (layout[name].range) update[`${name}.range`] = [...layout[name].range];
      else update[`${name}.autorange`] = true;
    }
    this.plotly.relayout(this.plot, update);
  }

  togglePanning() {
    this.panning = !this.panning;
    this.draw();
  }

  /** @param {"png" | "svg"} format */
  async saveImage(format) {
    if (!this.plot || !this.plotly || !this.figure) return;
    const url = await this.plotly.toImage(this.plot, { format, scale: format === "png" ? 2 : 1, width: this.plot.clientWidth, height: this.plot.clientHeight });
    h("a", { href: url, download: `${this.source.replaceAll("/", "-")}.${format}` }).click();
  }

  /** The address of this chart's data. @param {string} suffix */
  address(suffix) {
    return apiUrl(`${this.source}.${suffix}`, this.query);
  }

  fit() {
    const { plot, plotly, body } = this;
    if (!plot?._fullLayout || !plotly || !body || plot.parentElement !== body || !body.clientWidth) return;
    if ((body.clientWidth < NARROW_PX) !== this.narrow) this.draw();
    else plotly.Plots.resize(plot);
  }
}

define("chart-panel", ChartPanel);

/**
 * @param {{source: string, query?: Query, heading: string, bus?: CursorBus | null, hidden?: Set<string>, class?: string}} options
 * @returns {ChartPanel}
 */
export function chartPanel(options) {
  const panel = /** @type {ChartPanel} */ (document.createElement("chart-panel"));
  panel.source = options.source;
  if (options.query) panel.query = options.query;
  panel.heading = options.heading;
  panel.bus = options.bus ?? null;
  if (options.hidden) panel.hiddenLabels = options.hidden;
  if (options.class) panel.className = options.class;
  return panel;
}
