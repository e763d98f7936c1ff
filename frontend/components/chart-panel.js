// @ts-check
// One chart of a run or a recording: fetched when it becomes visible, drawn in the theme's colours, with its values
// in a fixed strip, its cursor shared with the other charts, and its data one click away.

import { define, h, put, svg } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { apiUrl, get } from "../js/api.js";
import { t, told } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { describePoints, dressFigure, isOverTime, pointsOfRow, rowOf, rowsOf } from "../js/figure.js";
import { loadPlotly } from "../js/plotly.js";
import { chartColours, isDark, themes } from "../js/theme.js";
import { failed, loading, notApplicable } from "./states.js";
import { chartMenu } from "./chart-menu.js";
import { chartTable } from "./chart-table.js";

/** @import { Figure, PlotlyElement, PlotlyLibrary } from "../types.d.ts" */
/** @import { CursorBus } from "../js/cursor.js" */

const CONFIG = { displaylogo: false, showSendToCloud: false, plotlyServerURL: "", displayModeBar: false, doubleClick: "reset+autosize" };
const NARROW_PX = 480;
// Points of a curve; marks are drawn one by one up to ten times as many for each entry. SVG draws these at once.
const POINTS = 1500;
// More points than this would stop the browser for seconds; they are in the CSV.
const MOST_POINTS = 60000;

export class ChartPanel extends HTMLElement {
  /** Where the chart's data are: `runs/ID/charts/plan`. */
  source = "";
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

  connectedCallback() {
    this.stop = new AbortController();
    const { signal } = this.stop;
    this.plot = /** @type {PlotlyElement} */ (h("div", { class: "plot", role: "img", tabindex: 0, "aria-label": this.heading }));
    this.overlay = svg("svg", { class: "overlay", "aria-hidden": "true" });
    this.body = h("div", { class: "body" }, loading());
    this.strip = h("div", { class: "strip" }, t("chart.strip_hint"));
    this.note = h("span", { class: "note small muted" });
    this.tableButton = h("button", { class: "plain", type: "button", "aria-pressed": "false", title: t("chart.as_table"), "aria-label": `${t("chart.as_table")}: ${this.heading}`, onclick: () => this.toggleTable() }, icon("table"));
    put(this,
      h("div", { class: "head" },
        h("h2", { class: "clip", title: this.heading }, this.heading), this.note,
        h("div", { class: "actions" }, this.tableButton,
          h("button", { class: "plain", type: "button", title: t("chart.expand"), "aria-label": `${t("chart.expand")}: ${this.heading}`, onclick: () => this.toggleFullscreen() }, icon("expand")),
          chartMenu(this))),
      this.body, this.strip);
    this.plot.addEventListener("keydown", (event) => this.onKey(event), { signal });
    this.plot.addEventListener("mouseleave", () => this.onLeave(), { signal });
    themes.addEventListener("change", () => this.draw(), { signal });
    this.bus?.addEventListener("change", () => this.showCursor(), { signal });
    this.seen = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      this.seen?.disconnect();
      this.load();
    }, { rootMargin: "200px" });
    this.seen.observe(this);
    this.sizes = new ResizeObserver(() => this.fit());
    this.sizes.observe(this);
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
        /** @type {Promise<Figure>} */ (get(`${this.source}.json`, { query: this.full ? { full: true } : { points: POINTS }, signal: this.stop?.signal })),
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
      plot.on?.("plotly_click", (event) => this.onClick(event));
      plot.on?.("plotly_afterplot", () => this.placeCursor());
    }
    plot.setAttribute("aria-label", this.summary());
    this.dataset.drawn = "yes";
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

  /** @param {any} event */
  onHover(event) {
    const points = event.points ?? [];
    const first = points[0];
    if (!first) return;
    const row = rowOf(first.customdata);
    if (row !== null) this.bus?.look(row, { label: first.fullData.meta?.label ?? null });
    if (!this.bus?.now.locked) this.describe(points.map((/** @type {any} */ point) => ({ trace: point.fullData, x: point.x, y: point.y, z: point.z, text: point.text })));
  }

  /** @param {any} event */
  onClick(event) {
    const point = event.points?.[0];
    const row = point ? rowOf(point.customdata) : null;
    if (!this.bus || row === null) return;
    if (this.bus.now.locked && this.bus.now.row === row) this.bus.release();
    else this.bus.look(row, { label: point.fullData.meta?.label ?? null, lock: true });
  }

  onLeave() {
    if (this.bus && !this.bus.now.locked) this.bus.release();
    else if (!this.bus) put(/** @type {HTMLElement} */ (this.strip), t("chart.strip_hint"));
  }

  /** Arrow keys step one mark, Escape frees the cursor. @param {KeyboardEvent} event */
  onKey(event) {
    if (!this.bus || !this.plot?._fullData) return;
    if (event.key === "Escape") this.bus.release();
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const rows = rowsOf(this.plot._fullData);
    const now = this.bus.now.row;
    const at = now === null ? -1 : rows.indexOf(now);
    const row = rows[Math.min(rows.length - 1, Math.max(0, at + step))];
    if (row !== undefined) this.bus.look(row, { label: this.bus.now.label, lock: true });
    this.strip?.setAttribute("aria-live", "polite");
  }

  /** Follow the cursor that all charts of the page share. */
  showCursor() {
    const row = this.bus?.now.row ?? null;
    const traces = this.plot?._fullData;
    this.marked = row === null || !traces ? [] : pointsOfRow(traces, row, this.figure && isOverTime(this.figure) ? null : this.bus?.now.label);
    if (row === null) put(/** @type {HTMLElement} */ (this.strip), t("chart.strip_hint"));
    else if (this.marked.length) this.describe(this.marked);
    this.placeCursor();
  }

  /** Draw the cursor over the chart: a line at the instant, or a ring around the point. */
  placeCursor() {
    const layout = this.plot?._fullLayout;
    const overlay = /** @type {SVGElement} */ (this.overlay);
    put(overlay);
    if (!layout || !this.marked?.length || !this.figure) return;
    const overTime = isOverTime(this.figure);
    for (const point of overTime ? this.marked.slice(0, 1) : this.marked) {
      const x = layout[`xaxis${String(point.trace.xaxis ?? "x").slice(1)}`];
      const y = layout[`yaxis${String(point.trace.yaxis ?? "y").slice(1)}`];
      const left = x._offset + x.d2p(point.x);
      if (!Number.isFinite(left) || left < x._offset - 1 || left > x._offset + x._length + 1) continue;
      if (overTime) overlay.append(svg("line", { x1: left, x2: left, y1: y._offset, y2: y._offset + y._length }));
      else {
        const top = y._offset + y.d2p(point.y);
        if (Number.isFinite(top) && top >= y._offset && top <= y._offset + y._length) overlay.append(svg("circle", { cx: left, cy: top, r: 8 }));
      }
    }
  }

  /** @param {{trace: any, x: any, y: any, z?: any, text?: any}[]} points */
  describe(points) {
    const parts = describePoints(points, this.plot?.layout ?? {});
    put(/** @type {HTMLElement} */ (this.strip), parts.map((part) => h("span", null,
      part.colour ? h("span", { class: "swatch", style: `border-color: ${part.colour}` }) : null,
      part.name, part.value ? " " : null, part.value ? h("b", null, part.value) : null)));
  }

  async toggleTable() {
    const on = this.tableButton?.getAttribute("aria-pressed") !== "true";
    this.tableButton?.setAttribute("aria-pressed", String(on));
    this.body?.querySelector(".as-table")?.remove();
    if (on) this.body?.append(await chartTable(this.source, this.heading));
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
    return apiUrl(`${this.source}.${suffix}`);
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
 * @param {{source: string, heading: string, bus?: CursorBus | null, hidden?: Set<string>, class?: string}} options
 * @returns {ChartPanel}
 */
export function chartPanel(options) {
  const panel = /** @type {ChartPanel} */ (document.createElement("chart-panel"));
  panel.source = options.source;
  panel.heading = options.heading;
  panel.bus = options.bus ?? null;
  if (options.hidden) panel.hiddenLabels = options.hidden;
  if (options.class) panel.className = options.class;
  return panel;
}
