// @ts-check
// What stands below the charts of a Monte Carlo run: metrics with intervals, comparisons, honesty, claims of a study.

import { h, put } from "../js/dom.js";
import { metricName, said, t, told } from "../js/i18n.js";
import { formatBounds, formatCount, formatNumber, formatQuantity, formatShare } from "../js/numbers.js";
import { follow } from "../js/live.js";
import { loadTable } from "../js/tables.js";
import { metricCell } from "./run-tabs.js";
import { dataTable } from "./data-table.js";
import { emptyState, failed, loading } from "./states.js";

/** @import { Run } from "../types.d.ts" */
/** @import { Row } from "../js/tables.js" */
/** @import { Column, DataTable } from "./data-table.js" */

/** Tables of trials in the order of their tabs. */
export const TRIAL_TABLES = ["claims", "comparisons", "consistency"];

/** Names that the run sweeps. @param {Run} run */
function sweptOf(run) {
  return Object.keys(/** @type {Record<string, unknown>} */ (run.source.sweep ?? {}));
}

/**
 * Load a table of a run; while its trials run it is loaded again whenever `news` tells of more.
 * @param {Run} run
 * @param {string} name
 * @param {(rows: Row[]) => Node | null} draw what to show; null where it has changed what it drew before
 * @param {EventTarget | null} [news]
 */
function withRows(run, name, draw, news = null) {
  const box = h("div", null, loading());
  let drawn = false;
  const load = () => loadTable(run.id, name).then(({ rows }) => {
    const content = draw(rows);
    if (content) put(box, content);
    drawn = true;
  }, (error) => { if (!drawn) put(box, h("div", { style: "padding: 12px" }, failed(error))); });
  load();
  if (news) follow(news, box, load);
  return box;
}

/** @param {string[]} swept @returns {Column<Row>[]} */
function sweptColumns(swept) {
  return swept.map((name) => ({
    title: name, number: true,
    cell: (/** @type {Row} */ row) => (typeof row[name] === "number" ? formatNumber(row[name]) : String(row[name] ?? "")),
    sort: (/** @type {Row} */ row) => (typeof row[name] === "number" ? row[name] : String(row[name] ?? "")),
  }));
}

/** @param {Row} row @param {string} name @returns {number | null} */
function number(row, name) {
  const value = row[name];
  return typeof value === "number" ? value : null;
}

/**
 * One row for each metric, algorithm, leg and swept value.
 * @param {Run} run
 * @param {EventTarget | null} [news] tells of more trials
 */
export function trialMetricsTab(run, news = null) {
  const chosen = { metric: "rms_horizontal_m", segment: "" };
  /** @type {Row[]} */
  let rows = [];
  /** @type {DataTable | null} */
  let table = null;
  const shown = () => rows.filter((row) => row.metric === chosen.metric && (chosen.segment === "*" || String(row.segment ?? "") === chosen.segment));
  const columns = /** @type {Column<Row>[]} */ ([
    { title: t("table.label"), cell: (row) => row.label, sort: (row) => String(row.label) },
    ...sweptColumns(sweptOf(run)),
    { title: t("trials.leg"), cell: (row) => row.segment || t("metrics.all"), sort: (row) => String(row.segment ?? "") },
    { title: t("metrics.target"), cell: (row) => row.target || t("metrics.all"), sort: (row) => String(row.target ?? "") },
    { title: t("trials.value"), number: true, cell: (row) => metricCell(row, false), sort: (row) => number(row, "value") },
    { title: t("metrics.n"), number: true, cell: (row) => formatCount(number(row, "n")), sort: (row) => number(row, "n") },
  ]);
  const choose = (/** @type {"metric" | "segment"} */ key, /** @type {string} */ title, /** @type {[string, string][]} */ options) => h("label", { class: "row" },
    h("span", { class: "muted" }, title),
    h("select", { style: "width: auto", value: chosen[key], onchange: (/** @type {Event} */ event) => {
      chosen[key] = /** @type {HTMLSelectElement} */ (event.target).value;
      table?.setRows(shown());
    } }, options.map(([value, text]) => h("option", { value }, text))));
  return withRows(run, "metrics", (found) => {
    rows = found;
    if (table) {
      // What was chosen and ordered stays.
      table.setRows(shown());
      return null;
    }
    const metrics = [...new Set(rows.map((row) => String(row.metric)))];
    if (!metrics.includes(chosen.metric)) chosen.metric = metrics[0] ?? "";
    const segments = [...new Set(rows.map((row) => String(row.segment ?? "")))];
    table = dataTable({ caption: t("tab.metrics"), columns, rows: shown() });
    return h("div", { data: { table: "metrics" } },
      h("div", { class: "row", style: "padding: 8px 12px" },
        choose("metric", t("metrics.metric"), metrics.map((name) => [name, metricName(name)])),
        segments.length > 1 ? choose("segment", t("trials.leg"), [["", t("metrics.all")], ["*", t("trials.each_leg")], .../** @type {[string, string][]} */ (segments.filter(Boolean).map((one) => [one, one]))]) : null),
      table);
  }, news);
}

/** @param {Run} run */
export function comparisonsTab(run) {
  return withRows(run, "comparisons", (rows) => {
    if (!rows.length) return emptyState(t("trials.no_comparisons"));
    const swept = sweptOf(run).filter((name) => name.startsWith("scenario."));
    const columns = /** @type {Column<Row>[]} */ ([
      { title: t("metrics.metric"), cell: (row) => metricName(String(row.metric)), sort: (row) => String(row.metric) },
      { title: t("table.label"), cell: (row) => row.label, sort: (row) => String(row.label) },
      { title: t("trials.against"), cell: (row) => row.against, sort: (row) => String(row.against) },
      ...sweptColumns(swept),
      { title: t("trials.leg"), cell: (row) => row.segment || t("metrics.all"), sort: (row) => String(row.segment ?? "") },
      { title: t("trials.difference"), number: true, cell: (row) => [formatQuantity(number(row, "difference"), String(row.unit ?? "")), interval(row, "ci95_low", "ci95_high", "difference")], sort: (row) => number(row, "difference") },
      { title: t("trials.ratio"), number: true, cell: (row) => [formatNumber(number(row, "ratio"), 3), interval(row, "ratio_low", "ratio_high")], sort: (row) => number(row, "ratio") },
      { title: t("trials.verdict"), cell: (row) => told(`trials.verdict_${row.verdict}`, String(row.verdict)), sort: (row) => String(row.verdict) },
    ]);
    return h("div", null, h("p", { class: "small muted", style: "padding: 8px 12px" }, t("trials.comparisons_hint")), dataTable({ caption: t("tab.comparisons"), columns, rows }));
  });
}

/** @param {Row} row @param {string} low @param {string} high @param {string} [value] whose bounds they are; without it they have no unit */
function interval(row, low, high, value = "") {
  const [from, to] = [number(row, low), number(row, high)];
  return from === null || to === null ? null : h("span", { class: "interval" }, ` ${formatBounds(from, to, number(row, value), value ? String(row.unit ?? "") : "")}`);
}

/** @param {Run} run */
export function consistencyTab(run) {
  return withRows(run, "consistency", (rows) => {
    if (!rows.length) return emptyState(t("trials.no_consistency"));
    const columns = /** @type {Column<Row>[]} */ ([
      { title: t("table.label"), cell: (row) => row.label, sort: (row) => String(row.label) },
      { title: t("trials.statistic"), cell: (row) => String(row.statistic).toUpperCase(), sort: (row) => String(row.statistic) },
      ...sweptColumns(sweptOf(run)),
      { title: t("trials.leg"), cell: (row) => row.segment || t("metrics.all"), sort: (row) => String(row.segment ?? "") },
      { title: t("trials.per_dof"), number: true, cell: (row) => formatNumber(number(row, "value")), sort: (row) => number(row, "value") },
      { title: t("trials.bounds"), number: true, cell: (row) => `${formatNumber(number(row, "bound_low"))}…${formatNumber(number(row, "bound_high"))}`, sort: (row) => number(row, "bound_high") },
      { title: t("trials.inside"), number: true, cell: (row) => formatShare(number(row, "inside_share")), sort: (row) => number(row, "inside_share") },
      { title: t("trials.verdict"), wide: true, cell: (row) => told(`trials.consistency_${row.verdict}`, String(row.verdict)), sort: (row) => String(row.verdict) },
    ]);
    return h("div", null, h("p", { class: "small muted", style: "padding: 8px 12px" }, t("trials.consistency_hint")), dataTable({ caption: t("tab.consistency"), columns, rows }));
  });
}

/** What the paper says and what came out. @param {Run} run */
export function claimsTab(run) {
  return withRows(run, "claims", (rows) => {
    const columns = /** @type {Column<Row>[]} */ ([
      { title: t("claims.figure"), cell: (row) => said(String(row.figure ?? "")) },
      { title: t("claims.claim"), wide: true, cell: (row) => said(String(row.claim)) },
      { title: t("claims.paper"), wide: true, cell: (row) => said(String(row.paper)) },
      { title: t("claims.ours"), number: true, cell: (row) => [formatQuantity(number(row, "value"), String(row.unit ?? "")), interval(row, "ci95_low", "ci95_high", "value")] },
      { title: t("trials.verdict"), cell: (row) => h("strong", { class: `claim ${row.verdict}` }, told(`claims.${row.verdict}`, String(row.verdict))) },
      { title: t("claims.reason"), wide: true, cell: (row) => said(String(row.reason)) },
    ]);
    return dataTable({ caption: t("tab.claims"), columns, rows });
  });
}
