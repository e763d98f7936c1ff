// @ts-check
// Two to ten runs side by side: the verdict, metrics, charts of all entries, and what they were given.

import { define, h, put } from "../js/dom.js";
import { Problem, get } from "../js/api.js";
import { CursorBus } from "../js/cursor.js";
import { t, told } from "../js/i18n.js";
import { formatExact } from "../js/numbers.js";
import { rememberQuery, routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { chartPanel } from "../components/chart-panel.js";
import { compareTable } from "../components/compare-table.js";
import { metricCell } from "../components/run-tabs.js";
import { runVerdict } from "../components/run-verdict.js";
import { emptyState, failed, loading, notApplicable } from "../components/states.js";
import "../components/legend-chips.js";

/** @import { Comparison, Summary } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { ChartPanel } from "../components/chart-panel.js" */
/** @import { LegendChips } from "../components/legend-chips.js" */

const BESIDE = ["drms", "nis"];

class ComparePage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  bus = new CursorBus();
  /** @type {ChartPanel[]} */
  panels = [];
  /** @type {Comparison | null} */
  comparison = null;

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
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** @param {URLSearchParams} query */
  queryChanged(query) {
    const runs = query.getAll("run");
    const known = this.comparison?.runs.map((run) => run.id) ?? [];
    if (runs.join() === known.join()) this.drawTables();
    else this.load();
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
    } catch (error) {
      if (this.stop?.signal.aborted) return;
      put(this, heading, failed(error, { retry: () => this.load() }), this.others(error));
    }
  }

  /** @returns {Promise<Comparison>} */
  ask() {
    const { query } = this.route;
    return get("compare", { query: { run: this.runs, target: query.get("target"), segment: query.get("segment") }, signal: this.stop?.signal });
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
    this.metrics = h("div", null);
    this.given = h("div", null);
    put(this,
      h("h1", { class: "sr-only" }, t("compare.title")),
      h("div", { class: "page-head" },
        h("label", { class: "check" }, only, t("compare.only_differences")),
        this.picker("target", comparison.targets), this.picker("segment", comparison.segments),
        h("div", { class: "actions" }, h("a", { class: "button", href: routeTo(["runs"], { pick: this.runs }) }, t("compare.change")))),
      h("div", { class: "run-legend" }, chips),
      comparison.same_recording ? runVerdict(summaryOf(comparison)) : h("p", { class: "notice", style: "margin-bottom: 8px" }, t("compare.other_recordings")),
      h("section", { class: "card", style: "margin-bottom: 8px" }, h("div", { class: "card-head" }, h("h2", null, t("tab.metrics"))), this.metrics),
      h("div", { class: "run-charts" }, this.charts(comparison, hidden)),
      h("section", { class: "card" }, h("div", { class: "card-head" }, h("h2", null, t("tab.parameters"))), this.given));
    this.drawTables();
  }

  /**
   * @param {"target" | "segment"} name
   * @param {string[]} values
   */
  picker(name, values) {
    if (values.length < 2) return null;
    const field = h("select", { "aria-label": t(`metrics.${name}`), value: this.route.query.get(name) ?? "", onchange: async () => {
      this.choose({ [name]: field.value || null });
      try {
        this.comparison = await this.ask();
        this.drawTables();
      } catch (error) {
        if (!this.stop?.signal.aborted && this.metrics) put(this.metrics, failed(error));
      }
    } }, values.map((value) => h("option", { value }, value || t("metrics.all"))));
    return h("label", { class: "row" }, h("span", { class: "muted" }, t(`metrics.${name}`)), field);
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
    const charts = comparison.charts.toSorted((a, b) => order.indexOf(place(a.name)) - order.indexOf(place(b.name)));
    this.panels = [];
    return charts.map((chart) => {
      const heading = told(`chart.${chart.name}`, chart.title);
      if (chart.obstacle) {
        return h("section", { class: `card ${place(chart.name)} left-out`, "aria-label": heading },
          h("div", { class: "card-head" }, h("h2", null, heading)), notApplicable(t("compare.obstacle")));
      }
      const panel = chartPanel({
        source: `compare/charts/${chart.name}`, query: { run: comparison.runs.map((run) => run.id) }, heading, bus: this.bus, hidden, class: place(chart.name),
      });
      this.panels.push(panel);
      return panel;
    });
  }

  drawTables() {
    const { comparison, metrics, given } = this;
    if (!comparison || !metrics || !given) return;
    const only = !this.all;
    put(metrics, compareTable(comparison, t("tab.metrics"), comparison.metrics.map((row) => ({
      name: row.metric, head: told(`metric.${row.metric}`, row.metric), differs: row.differs,
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
      ...comparison.software.map((row) => ({ name: row.name, head: row.name, differs: row.differs, cells: row.values.map(formatExact) })),
    ], only));
  }
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
