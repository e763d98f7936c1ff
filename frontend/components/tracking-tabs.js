// @ts-check
// What stands below the charts of a run of a tracker: what was asked of it, and which tracks of several radars are one.

import { h } from "../js/dom.js";
import { metricName, said, t, told } from "../js/i18n.js";
import { formatCount, formatNumber, formatQuantity, formatShare } from "../js/numbers.js";
import { dataTable } from "./data-table.js";
import { withTable } from "./run-tabs.js";
import { emptyState } from "./states.js";

/** @import { Run } from "../types.d.ts" */
/** @import { Row } from "../js/tables.js" */
/** @import { Column } from "./data-table.js" */

/** @param {Row} row @param {string} name */
const number = (row, name) => (typeof row[name] === "number" ? /** @type {number} */ (row[name]) : null);

/** @param {Row[]} rows @returns {Column<Row>[]} */
function labelColumn(rows) {
  const several = new Set(rows.map((row) => row.label)).size > 1;
  return several ? [{ title: t("table.label"), cell: (row) => String(row.label), sort: (row) => String(row.label) }] : [];
}

/** @param {Row} row @param {string} column */
function amount(row, column) {
  const value = number(row, column);
  if (value === null) return "–";
  return String(row.requirement).endsWith("_share") ? formatShare(value) : formatQuantity(value, row.unit === "1" ? "" : String(row.unit));
}

/**
 * A row for each target, segment and requirement, passed or not.
 * @param {Run} run
 * @param {string} target
 */
export function requirementsTab(run, target) {
  return withTable(run, "requirements", target, (rows) => {
    if (!rows.length) return emptyState(t("requirements.none"));
    const columns = [...labelColumn(rows), .../** @type {Column<Row>[]} */ ([
      { title: t("metrics.target"), cell: (row) => String(row.target ?? t("metrics.all")), sort: (row) => String(row.target ?? "") },
      { title: t("metrics.segment"), cell: (row) => told(`requirements.${row.segment}`, String(row.segment)), sort: (row) => String(row.segment) },
      { title: t("requirements.requirement"), cell: (row) => metricName(String(row.requirement)), sort: (row) => String(row.requirement) },
      { title: t("requirements.value"), number: true, cell: (row) => amount(row, "value"), sort: (row) => number(row, "value") },
      { title: t("requirements.threshold"), number: true, cell: (row) => amount(row, "threshold"), sort: (row) => number(row, "threshold") },
      { title: t("trials.verdict"), cell: (row) => verdict(String(row.verdict)), sort: (row) => String(row.verdict) },
      { title: t("metrics.n"), number: true, cell: (row) => formatCount(number(row, "n")), sort: (row) => number(row, "n") },
    ])];
    const table = dataTable({ caption: t("tab.requirements"), columns, rows });
    table.dataset.table = "requirements";
    table.tall = true;
    const words = ["failed", "passed", "no data", "not asked"].filter((word) => rows.some((row) => row.verdict === word));
    const count = (/** @type {string} */ word) => rows.filter((row) => row.verdict === word).length;
    const asked = words.some((word) => word === "failed" || word === "passed");
    return h("div", null,
      h("div", { class: "row", style: "padding: 8px 12px" },
        h("select", {
          style: "width: auto", "aria-label": t("trials.verdict"), onchange: (/** @type {Event} */ event) => {
            const { value } = /** @type {HTMLSelectElement} */ (event.target);
            table.setRows(rows.filter((row) => !value || row.verdict === value));
          },
        }, h("option", { value: "" }, t("decisions.all", { n: rows.length })), words.map((value) => h("option", { value }, `${told(`requirements.${value}`, value)} (${formatCount(count(value))})`))),
        h("span", { class: "small muted" }, t(asked ? "requirements.hint" : "requirements.not_set"))),
      table);
  });
}

/** A verdict is told by a sign and a word, not by a colour alone. @param {string} word */
function verdict(word) {
  const sign = { passed: "✓ ", failed: "✗ " }[word] ?? "";
  const colour = { passed: "good", failed: "bad" }[word] ?? "muted";
  return h("strong", { class: colour }, sign, told(`requirements.${word}`, word));
}

/**
 * Which tracks of different radars were compared, and which are one target.
 * @param {Run} run
 */
export function joinsTab(run) {
  return withTable(run, "compared_tracks", "", (rows) => {
    if (!rows.length) return emptyState(t("joins.none"));
    const columns = [...labelColumn(rows), .../** @type {Column<Row>[]} */ ([
      { title: t("joins.first"), number: true, cell: (row) => formatCount(number(row, "track_1")), sort: (row) => number(row, "track_1") },
      { title: t("joins.second"), number: true, cell: (row) => formatCount(number(row, "track_2")), sort: (row) => number(row, "track_2") },
      { title: t("joins.instants"), number: true, cell: (row) => formatCount(number(row, "instants")), sort: (row) => number(row, "instants") },
      { title: t("joins.statistic"), number: true, cell: (row) => formatNumber(number(row, "statistic"), 3), sort: (row) => number(row, "statistic") },
      { title: t("decisions.threshold"), number: true, cell: (row) => formatNumber(number(row, "threshold"), 3), sort: (row) => number(row, "threshold") },
      { title: t("decisions.decision"), cell: (row) => told(`joins.${row.decision}`, String(row.decision)), sort: (row) => String(row.decision) },
      { title: t("decisions.reason"), wide: true, cell: (row) => said(String(row.reason)) },
    ])];
    const table = dataTable({ caption: t("tab.joins"), columns, rows });
    table.dataset.table = "joins";
    table.tall = true;
    return h("div", null, h("p", { class: "small muted", style: "padding: 8px 12px 0" }, t("joins.hint")), table);
  });
}
