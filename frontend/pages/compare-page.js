// @ts-check
// Two to ten runs side by side: the verdict, metrics, charts of all entries, and what they were given.

import { define, h, put } from "../js/dom.js";
import { Problem, get } from "../js/api.js";
import { CursorBus } from "../js/cursor.js";
import { metricName, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatExact } from "../js/numbers.js";
import { changeQuery, rememberQuery, routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { chartPanel } from "../components/chart-panel.js";
import { compareTable } from "../components/compare-table.js";
import { metricCell } from "../components/run-tabs.js";
import { runVerdict } from "../components/run-verdict.js";
import { emptyState, failed, loading } from "../components/states.js";
import { showTargetOf, targetPicker } from "../components/target-picker.js";
import "../components/legend-chips.js";

/** @import { Comparison, Summary } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { ChartPanel } from "../components/chart-panel.js" */
/** @import { LegendChips } from "../components/legend-chips.js" */
/** @import { Mark } from "../components/chart-cursor.js" */
/** @import { TargetPicker } from "../components/target-picker.js" */

const BESIDE = ["drms", "nis"];

class ComparePage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  bus = new CursorBus();
  /** @type {ChartPanel[]} */
  panels = [];
  /** @type {Comparison | null} */
  comparison = null;
  /** @type {(() => void) | null} */
  unwatch = null;
  /** @type {TargetPicker | null} */
  picker = null;

  get runs() {
    return this.route.query.getAll("run");
  }

  /** Where the tables show every line and not only differences. */
  get all() {
    return this.route.query.get("all") === "1";
  }

  connectedCallback() {
    setTitle(t("compare.title"));
    this.stop = new AbortController();
    put(this, h("h1", { class: "sr-only" }, t("compare.title")), loading());
    this.look = throttled(() => this.lookAgain());
    this.unwatch = watch((news) => { if (!news || this.runs.includes(news.id)) this.look?.(); });
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  /** A run may have got another name, or be gone: nothing of it stays on the page. */
  async lookAgain() {
    // What is being loaded may be old already: it is looked at again when it stands.
    this.missed = !this.comparison;
    if (this.missed) return;
    try {
      const comparison = await this.ask();
      if (JSON.stringify(comparison) === JSON.stringify(this.comparison)) return;
      this.comparison = comparison;
      this.drawTables();
    } catch (error) {
      if (this.stop?.signal.aborted || !(error instanceof Problem) || error.status === 0) return;
      this.comparison = null;
      put(this, h("h1", { class: "sr-only" }, t("compare.title")), failed(error, { retry: () => this.load() }), this.others(error));
    }
  }

  /** @param {URLSearchParams} query */
  queryChanged(query) {
    const runs = query.getAll("run");
    const known = this.comparison?.runs.map((run) => run.id) ?? [];
    if (runs.join() !== known.join()) {
      this.load();
      return;
    }
    const before = this.target;
    this.picker?.choose(query.get("target") ?? "");
    if (this.target === before) this.drawTables();
    else this.follow();
  }

  /** The target that everything is about; empty = all, also where the address names one that there is not. */
  get target() {
    return this.picker?.known ? this.picker.chosen : "";
  }

  /** Everything on the page is about another target now. */
  async follow() {
    const { target } = this;
    for (const panel of this.panels) panel.ask({ target });
    await this.refresh();
  }

  /** Ask for the numbers again: of another target, of another segment. */
  async refresh() {
    const { target } = this;
    this.verdict?.classList.add("stale");
    this.metrics?.classList.add("stale");
    try {
      const comparison = await this.ask();
      if (this.target !== target) return;
      this.comparison = comparison;
      this.drawTables();
    } catch (error) {
      if (!this.stop?.signal.aborted && this.metrics) put(this.metrics, failed(error));
    } finally {
      this.verdict?.classList.remove("stale");
      this.metrics?.classList.remove("stale");
    }
  }

  /** Show the target of a mark alone. @param {Mark} mark */
  pick(mark) {
    const { comparison } = this;
    const run = comparison?.entries.find((entry) => entry.label === mark.label)?.run_id;
    // A true path is of no entry; where all runs share their recording it is of that.
    const of = comparison?.runs.find((one) => (run ? one.id === run : comparison.same_recording));
    if (of) showTargetOf(of.recording_id, mark.row, this.stop?.signal);
  }

  async load() {
    const heading = h("h1", { class: "sr-only" }, t("compare.title"));
    if (this.runs.length < 2) {
      put(this, heading, h("div", { class: "card" }, emptyState(t("compare.too_few"), h("a", { class: "button", href: routeTo(["runs"], { pick: this.runs }) }, t("nav.runs")))));
      return;
    }
    try {
      this.comparison = await this.ask();
      this.draw(this.comparison);
      if (this.missed) this.look?.();
    } catch (error) {
      if (this.stop?.signal.aborted) return;
      put(this, heading, failed(error, { retry: () => this.load() }), this.others(error));
    }
  }

  /** @returns {Promise<Comparison>} */
  ask() {
    const { query } = this.route;
    return get("compare", { query: { run: this.runs, target: this.picker ? this.target : query.get("target"), segment: query.get("segment") }, signal: this.stop?.signal });
  }

  /** Where some of the runs cannot be compared, the way to the comparison of the others. @param {unknown} error */
  others(error) {
    const bad = error instanceof Problem ? error.errors.flatMap((one) => /^\/query\/run\/(\d+)$/.exec(one.pointer)?.[1] ?? []) : [];
    const rest = this.runs.filter((_, i) => !bad.includes(String(i)));
    if (!bad.length) return null;
    return h("p", { class: "row", style: "margin-top: 12px" }, rest.length > 1
      ? h("a", { class: "button", href: routeTo(["compare"], { run: rest }) }, t("compare.without", { n: rest.length }))
      : h("a", { class: "button", href: routeTo(["runs"], { pick: rest }) }, t("nav.runs")));
  }

  /** @param {Comparison} comparison */
  draw(comparison) {
    setTitle(comparison.runs.map((run) => run.title).join(", "), t("compare.title"));
    const { query } = this.route;
    const hidden = new Set(query.getAll("hide"));
    const chips = /** @type {LegendChips} */ (document.createElement("legend-chips"));
    Object.assign(chips, { labels: comparison.entries.map((entry) => entry.label), hiddenLabels: hidden });
    chips.onchoose = (now) => {
      rememberQuery({ hide: [...now] });
      for (const panel of this.panels) panel.hideLabels(now);
    };
    const only = h("input", { type: "checkbox", checked: !this.all, onchange: () => this.choose({ all: only.checked ? null : "1" }) });
    const targets = comparison.targets.filter(Boolean).map((name) => ({ name }));
    const picker = targetPicker(targets, query.get("target") ?? "", (name) => changeQuery({ target: name }));
    this.picker = picker;
    this.verdict = h("div", null);
    this.metrics = h("div", null);
    this.given = h("div", null);
    put(this,
      h("h1", { class: "sr-only" }, t("compare.title")),
      h("div", { class: "page-head" },
        h("label", { class: "check" }, only, t("compare.only_differences")),
        picker, this.segmentPicker(comparison.segments),
        h("div", { class: "actions" }, h("a", { class: "button", href: routeTo(["runs"], { pick: this.runs }) }, t("compare.change")))),
      h("div", { class: "run-legend" }, chips),
      comparison.same_recording ? this.verdict : h("p", { class: "notice", style: "margin-bottom: 8px" }, t("compare.other_recordings")),
      h("section", { class: "card", style: "margin-bottom: 8px" }, h("div", { class: "card-head" }, h("h2", null, t("tab.metrics"))), this.metrics),
      h("div", { class: "run-charts" }, this.charts(comparison, hidden)),
      notDrawn(comparison),
      h("section", { class: "card" }, h("div", { class: "card-head" }, h("h2", null, t("tab.parameters"))), this.given));
    this.drawTables();
  }

  /** @param {string[]} values */
  segmentPicker(values) {
    if (values.length < 2) return null;
    const field = h("select", { "aria-label": t("metrics.segment"), value: this.route.query.get("segment") ?? "", onchange: () => {
      this.choose({ segment: field.value || null });
      this.refresh();
    } }, values.map((value) => h("option", { value }, value || t("metrics.all"))));
    return h("label", { class: "row" }, h("span", { class: "muted" }, t("metrics.segment")), field);
  }

  /** @param {Record<string, string | null>} query */
  choose(query) {
    rememberQuery(query);
    for (const [name, value] of Object.entries(query)) {
      if (value) this.route.query.set(name, value);
      else this.route.query.delete(name);
    }
    this.drawTables();
  }

  /**
   * @param {Comparison} comparison
   * @param {Set<string>} hidden
   */
  charts(comparison, hidden) {
    const place = (/** @type {string} */ name) => (name === "plan" ? "first" : BESIDE.includes(name) ? "time" : "rest");
    const order = ["first", "time", "rest"];
    const charts = comparison.charts.filter((chart) => !chart.obstacle).toSorted((a, b) => order.indexOf(place(a.name)) - order.indexOf(place(b.name)));
    this.panels = [];
    return charts.map((chart) => {
      const heading = told(`chart.${chart.name}`, chart.title);
      const panel = chartPanel({
        source: `compare/charts/${chart.name}`, query: { run: comparison.runs.map((run) => run.id), target: this.target }, heading, bus: this.bus, hidden, class: place(chart.name),
        onpick: comparison.targets.length > 1 ? (mark) => this.pick(mark) : null,
      });
      this.panels.push(panel);
      return panel;
    });
  }

  drawTables() {
    const { comparison, metrics, given } = this;
    if (!comparison || !metrics || !given) return;
    const only = !this.all;
    if (this.verdict) put(this.verdict, runVerdict(summaryOf(comparison), this.target));
    put(metrics, compareTable(comparison, t("tab.metrics"), comparison.metrics.map((row) => ({
      name: row.metric, head: metricName(row.metric), differs: row.differs,
      cells: row.values.map((cell, i) => (cell ? metricCell({
        metric: row.metric, unit: row.unit, value: cell.value, ci95_low: cell.ci95?.[0] ?? null, ci95_high: cell.ci95?.[1] ?? null,
      }, row.best.includes(i)) : "–")),
    })), only));
    put(given, compareTable(comparison, t("tab.parameters"), [
      ...comparison.given.map((row) => ({ name: row.name, head: told(`compare.given.${row.name}`, row.name), differs: row.differs, cells: row.values.map(formatExact) })),
      ...comparison.parameters.map((row) => ({
        name: row.name, head: h("code", null, row.name), differs: row.differs,
        cells: row.values.map((cell) => (cell === null ? h("span", { class: "muted", title: t("compare.no_such_parameter") }, "–")
          : h("span", { class: cell.source === "run" ? "best" : null, title: told(`source.${cell.source}`, cell.source) }, formatExact(cell.value)))),
      })),
      ...comparison.software.map((row) => ({ name: row.name, head: told(`software.${row.name}`, row.name), differs: row.differs, cells: row.values.map(formatExact) })),
    ], only));
  }
}

/** Which charts there cannot be, and why; a panel for each would be a page of empty ones. @param {Comparison} comparison */
function notDrawn(comparison) {
  const names = comparison.charts.filter((chart) => chart.obstacle).map((chart) => told(`chart.${chart.name}`, chart.title));
  return names.length ? h("p", { class: "muted small", style: "margin: 8px 0", data: { notDrawn: "" } }, t("compare.not_drawn", { charts: names.join(", ") }), " ", t("compare.obstacle")) : null;
}

/** The metrics of all entries as the summary of one run, under the labels of the charts. @param {Comparison} comparison */
function summaryOf(comparison) {
  /** @type {Summary} */
  const summary = {};
  for (const row of comparison.metrics) {
    summary[row.metric] = Object.fromEntries(row.values.flatMap((cell, i) => (cell ? [[comparison.entries[i]?.label ?? "", { value: cell.value, ci95: cell.ci95, unit: row.unit }]] : [])));
  }
  return summary;
}

define("compare-page", ComparePage);
