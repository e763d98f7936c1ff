// @ts-check
// One chart of a run or a recording: fetched when it becomes visible, drawn in the theme's colours, its data one
// click away.

import { define, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { apiUrl, get } from "../js/api.js";
import { language, t, told } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { DotsCanvas } from "../js/dots.js";
import { dressFigure, drawsInSpace, isOverTime } from "../js/figure.js";
import { inTurn } from "../js/turns.js";
import { loadPlotly } from "../js/plotly.js";
import { chartColours, isDark, themes } from "../js/theme.js";
import { failed, loading, notApplicable } from "./states.js";
import { ChartCursor } from "./chart-cursor.js";
import { chartMenu } from "./chart-menu.js";
import { chartTable } from "./chart-table.js";

/** @import { Figure, PlotlyElement, PlotlyLibrary } from "../types.d.ts" */
/** @import { CursorBus } from "../js/cursor.js" */
/** @import { Query } from "../js/api.js" */
/** @import { Mark } from "./chart-cursor.js" */
/** @import { PlanTools } from "./plan-tools.js" */

const CONFIG = { displaylogo: false, showSendToCloud: false, plotlyServerURL: "", displayModeBar: false, doubleClick: "reset+autosize" };
const NARROW_PX = 480;
// A change of the height by which titles are set anew.
const TITLES_PX = 60;
// Points of a curve; marks are drawn one by one up to ten times as many for each entry. SVG draws these at once.
const POINTS = 1500;
// More points than this would stop the browser for seconds; they are in the CSV.
const MOST_POINTS = 60000;

export class ChartPanel extends HTMLElement {
  /** Where the chart's data are: `runs/ID/charts/plan`; empty where figures are given (`give`). */
  source = "";
  /** What the addresses of its data ask for besides. @type {Query} */
  query = {};
  heading = "";
  /** @type {CursorBus | null} */
  bus = null;
  /** @type {Set<string>} labels whose traces are hidden */
  hiddenLabels = new Set();
  full = false;
  /** Of the drawn chart, px. */
  height = 0;
  panning = false;
  /** @type {Figure | null} */
  figure = null;
  /** @type {PlotlyLibrary | null} */
  plotly = null;
  /** @type {ChartCursor | null} */
  cursor = null;
  /** Where crowds of markers are painted. @type {DotsCanvas | null} */
  dots = null;
  /** Asked for the target of a mark alone. @type {((mark: Mark) => void) | null} */
  onpick = null;
  /** What a plan measures. @type {PlanTools | null} */
  tools = null;
  /** Stands under the values. @type {HTMLElement[]} */
  foot = [];
  /** Counts the requests; only the last one is drawn. */
  asked = 0;
  /** What the reader zoomed into, by axis. @type {Record<string, [number, number]>} */
  zoom = {};
  /** The time that the page looks at, in charts over time; what the reader zooms into goes before. @type {[number, number] | null} */
  span = null;

  connectedCallback() {
    this.stop = new AbortController();
    const { signal } = this.stop;
    this.plot = /** @type {PlotlyElement} */ (h("div", { class: "plot", role: "img", tabindex: 0, "aria-label": this.heading }));
    this.cursor = new ChartCursor(this, this.plot);
    this.dots = new DotsCanvas(this.plot);
    this.body = h("div", { class: "body" }, loading());
    this.note = h("span", { class: "note small muted" });
    this.tableButton = h("button", { class: "plain", type: "button", "aria-pressed": "false", title: t("chart.as_table"), "aria-label": `${t("chart.as_table")}: ${this.heading}`, onclick: () => this.toggleTable() }, icon("table"));
    put(this,
      h("div", { class: "head" },
        h("h2", { class: "clip", title: this.heading }, this.heading), this.note,
        h("div", { class: "actions" }, this.source ? this.tableButton : null,
          h("button", { class: "plain", type: "button", title: t("chart.expand"), "aria-label": `${t("chart.expand")}: ${this.heading}`, onclick: () => this.toggleFullscreen() }, icon("expand")),
          this.source ? chartMenu(this) : null)),
      this.body, this.cursor.strip, ...this.foot, this.cursor.told);
    this.cursor.listen(signal);
    themes.addEventListener("change", () => this.draw(), { signal });
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

  /** Draw a figure that somebody else has fetched. @param {Figure} figure */
  async give(figure) {
    this.figure = figure;
    this.plotly ??= await loadPlotly();
    // A later figure may have come meanwhile; it draws itself.
    if (this.figure === figure) await inTurn(() => this.draw());
  }

  /** Fetch the figure and draw it; called again when the run has moved on or something else is asked for. */
  async load() {
    if (!this.source) return;
    this.asked += 1;
    const turn = this.asked;
    this.body?.setAttribute("aria-busy", "true");
    try {
      const [figure, plotly] = await Promise.all([
        /** @type {Promise<Figure>} */ (get(`${this.source}.json`, { query: { ...this.query, ...(this.full ? { full: true } : { points: POINTS }) }, signal: this.stop?.signal })),
        loadPlotly(),
      ]);
      if (turn !== this.asked) return;
      this.figure = figure;
      this.plotly = plotly;
      await inTurn(() => this.draw());
    } catch (error) {
      if (turn === this.asked && !this.stop?.signal.aborted && this.body) put(this.body, failed(error, { retry: () => this.load() }));
    } finally {
      if (turn === this.asked) this.body?.removeAttribute("aria-busy");
    }
  }

  /** Ask for something else of the same chart: another target. @param {Query} query */
  async ask(query) {
    this.query = { ...this.query, ...query };
    // Every point of one target may be a few; of all of them it may be millions.
    this.full = false;
    // What was not seen yet is fetched when it is.
    if (!this.asked) return;
    const table = this.tableButton?.getAttribute("aria-pressed") === "true";
    await this.load();
    if (table) {
      await this.toggleTable();
      await this.toggleTable();
    }
  }

  /** Draw what was fetched, in the colours of the theme. */
  async draw() {
    const { figure, plotly, plot, body, cursor, dots } = this;
    if (!figure || !plotly || !plot || !body || !cursor || !dots || !this.isConnected) return;
    this.showNotes(figure);
    const reason = figure.layout.meta?.not_applicable;
    if (reason) {
      cursor.forget();
      put(body, notApplicable(told(`chart.reason.${reason}`, figure.layout.meta.detail ?? reason)));
      return;
    }
    if (figure.layout.scene && !drawsInSpace()) {
      cursor.forget();
      put(body, notApplicable(t("chart.no_space")));
      return;
    }
    if (plot.parentElement !== body) put(body, dots.canvas, plot, cursor.overlay);
    const narrow = body.clientWidth < NARROW_PX;
    this.height = body.clientHeight;
    const dressed = this.dress(figure, narrow);
    dressed.layout.dragmode = this.panning ? "pan" : "zoom";
    if (this.span && isOverTime(figure)) dressed.layout.xaxis = { ...dressed.layout.xaxis, range: [...this.span], autorange: false };
    for (const [axis, range] of Object.entries(this.zoom)) dressed.layout[axis] = { ...dressed.layout[axis], range: [...range], autorange: false };
    this.narrow = narrow;
    const fresh = !plot._fullLayout;
    await plotly.react(plot, dressed.data, dressed.layout, CONFIG);
    if (fresh) {
      dots.follow();
      plot.on?.("plotly_relayout", (change) => this.noteZoom(change));
    }
    cursor.takeOver(fresh);
    plot.setAttribute("aria-label", this.summary());
    this.dataset.drawn = "yes";
    this.dispatchEvent(new Event("drawn"));
    cursor.show();
  }

  /**
   * The figure in the page's look.
   * @param {Figure} figure
   * @param {boolean} narrow
   * @param {boolean} [dots] whether crowds of markers are painted apart
   */
  dress(figure, narrow, dots = true) {
    return dressFigure(figure, { colours: chartColours(), dark: isDark(), hidden: this.hiddenLabels, narrow, width: this.body?.clientWidth ?? 0, height: this.height, font: getComputedStyle(this).fontFamily, dots });
  }

  /** Remember the ranges that the reader chose, or forget them when all is shown again. @param {Record<string, any>} change */
  noteZoom(change) {
    for (const name of Object.keys(change)) {
      const axis = /^([xy]axis\d*)\.(range|autorange)/.exec(name);
      if (!axis?.[1]) continue;
      const range = this.plot?._fullLayout?.[axis[1]]?.range;
      if (axis[2] === "range" && range) this.zoom[axis[1]] = [range[0], range[1]];
      else delete this.zoom[axis[1]];
      if (axis[1] === "xaxis") this.span = null;
    }
  }

  /** Look at a time, or at all of it. @param {[number, number] | null} span */
  lookAt(span) {
    this.span = span;
    delete this.zoom.xaxis;
    if (this.figure && isOverTime(this.figure)) this.draw();
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
        !this.source ? null : about.decimated.of <= MOST_POINTS ? h("button", { class: "link", type: "button", onclick: () => this.setFull(true) }, t("chart.all_points"))
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
    if (layout.scene) update["scene.camera"] = layout.scene.camera;
    this.plotly.relayout(this.plot, update).then(() => { this.zoom = {}; this.span = null; });
  }

  togglePanning() {
    this.panning = !this.panning;
    this.draw();
  }

  /** @param {"png" | "svg"} format */
  async saveImage(format) {
    if (!this.plot || !this.plotly || !this.figure) return;
    // An image has every marker as a drawing, and shows what the reader has zoomed into.
    const { data } = this.dress(this.figure, this.narrow ?? false, false);
    const url = await this.plotly.toImage({ data, layout: this.plot.layout ?? {}, config: CONFIG }, { format, scale: format === "png" ? 2 : 1, width: this.plot.clientWidth, height: this.plot.clientHeight });
    h("a", { href: url, download: `${this.source.replaceAll("/", "-")}.${format}` }).click();
  }

  /** The address of this chart's data. @param {string} suffix */
  address(suffix) {
    // A page that stands alone is written in the language of this one.
    return apiUrl(`${this.source}.${suffix}`, suffix === "html" && language() !== "en" ? { ...this.query, language: language() } : this.query);
  }

  fit() {
    const { plot, plotly, body } = this;
    if (!plot?._fullLayout || !plotly || !body || plot.parentElement !== body || !body.clientWidth) return;
    // Titles are as large as a low chart has room for.
    if ((body.clientWidth < NARROW_PX) !== this.narrow || Math.abs(body.clientHeight - this.height) > TITLES_PX) this.draw();
    else plotly.Plots.resize(plot);
  }
}

define("chart-panel", ChartPanel);

/**
 * @param {{source: string, query?: Query, heading: string, bus?: CursorBus | null, hidden?: Set<string>, class?: string,
 *   onpick?: ((mark: Mark) => void) | null}} options
 * @returns {ChartPanel}
 */
export function chartPanel(options) {
  const panel = /** @type {ChartPanel} */ (document.createElement("chart-panel"));
  panel.source = options.source;
  if (options.query) panel.query = options.query;
  panel.heading = options.heading;
  panel.bus = options.bus ?? null;
  panel.onpick = options.onpick ?? null;
  if (options.hidden) panel.hiddenLabels = options.hidden;
  if (options.class) panel.className = options.class;
  return panel;
}
