// @ts-check
// Above the charts of a run: radars that disagree, which one, and by how much; below them every explanation.

import { alarmsOf } from "../js/alarms.js";
import { h } from "../js/dom.js";
import { said, t, told } from "../js/i18n.js";
import { formatNumber } from "../js/numbers.js";
import { dataTable } from "./data-table.js";
import { withTable } from "./run-tabs.js";
import { emptyState } from "./states.js";

/** @import { Run } from "../types.d.ts" */
/** @import { Row } from "../js/tables.js" */
/** @import { Column } from "./data-table.js" */

/** @param {Run} run @returns {HTMLElement | null} null where nothing is wrong */
export function runAlarms(run) {
  const alarms = alarmsOf(run.notes);
  if (!alarms.length) return null;
  const everybody = run.algorithms.length;
  return h("section", { class: "notice stack tight", style: "margin-bottom: 8px", "aria-label": t("alarms.title"), data: { alarms: "" } },
    alarms.map(({ detail, labels }) => h("p", { style: "margin: 0" }, said(detail),
      labels.length < everybody ? h("span", { class: "muted small" }, ` (${labels.join(", ")})`) : null)));
}

/** @param {Row} row @param {string} name */
const number = (row, name) => (typeof row[name] === "number" ? /** @type {number} */ (row[name]) : null);

/** What may be wrong between the radars, the best explanation first. @param {Run} run */
export function registrationTab(run) {
  return withTable(run, "registration", "", (rows) => {
    if (!rows.length) return emptyState(t("registration.none"));
    const several = new Set(rows.map((row) => row.label)).size > 1;
    const columns = /** @type {Column<Row>[]} */ ([
      ...(several ? [{ title: t("table.label"), cell: (/** @type {Row} */ row) => row.label, sort: (/** @type {Row} */ row) => String(row.label) }] : []),
      { title: t("registration.radar"), cell: (row) => row.radar, sort: (row) => String(row.radar) },
      { title: t("registration.against"), cell: (row) => (row.against === "others" ? t("registration.others") : row.against), sort: (row) => String(row.against) },
      { title: t("registration.offset"), cell: (row) => told(`registration.${row.offset}`, String(row.offset)), sort: (row) => String(row.offset) },
      { title: t("registration.value"), number: true, cell: (row) => `${formatNumber(number(row, "value"), 4)} ± ${formatNumber(number(row, "sd"), 2)} ${row.unit === "deg" ? "°" : told(`unit.${row.unit}`, String(row.unit))}`, sort: (row) => number(row, "value") },
      { title: t("registration.statistic"), number: true, cell: (row) => formatNumber(number(row, "statistic"), 3), sort: (row) => number(row, "statistic") },
      { title: t("registration.tail"), number: true, cell: (row) => formatNumber(number(row, "tail"), 2), sort: (row) => number(row, "tail") },
    ]);
    const table = dataTable({ caption: t("tab.registration"), rows, columns });
    table.dataset.table = "registration";
    return h("div", null, h("p", { class: "small muted", style: "padding: 8px 12px 0" }, t("registration.hint")), table);
  });
}
