// @ts-check
// A chart's numbers as a table, from the same address as the chart with the suffix `.csv`.

import { h, put } from "../js/dom.js";
import { apiUrl, getText } from "../js/api.js";
import { parseCsv } from "../js/csv.js";
import { said, t, told } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { failed } from "./states.js";

/** @import { Query } from "../js/api.js" */

// More rows than this belong into a file and not on a page.
const MOST_ROWS = 1000;

/**
 * @param {string} source
 * @param {string} heading
 * @param {Query} [query]
 */
export async function chartTable(source, heading, query = {}) {
  const box = h("div", { class: "as-table", tabindex: 0, role: "region", "aria-label": `${t("chart.as_table")}: ${heading}` });
  try {
    const { columns, rows, more } = parseCsv(await getText(`${source}.csv`, { query }), MOST_ROWS);
    const label = columns.indexOf("label");
    put(box,
      h("table", null,
        h("thead", null, h("tr", null, columns.map((name) => h("th", { scope: "col" }, told(`chart_column.${name}`, name))))),
        h("tbody", null, rows.map((row) => h("tr", null, row.map((cell, i) => h("td", { class: isNumber(cell) ? "number" : null }, words(columns[i] ?? "", cell, row[label] ?? ""))))))),
      more ? h("p", { class: "table-foot" }, t("table.first_rows", { n: formatCount(rows.length) }), " ",
        h("a", { href: apiUrl(`${source}.csv`, query), download: "" }, t("table.all_as_csv"))) : null);
  } catch (error) {
    put(box, failed(error));
  }
  return box;
}

/**
 * A cell in the page's language; labels are names.
 * @param {string} column
 * @param {string} cell
 * @param {string} label of the entry that the row is of
 */
function words(column, cell, label) {
  if (column === "role") return told(`role.${cell}`, cell);
  if (column === "label" || isNumber(cell)) return cell;
  return label && cell.startsWith(`${label}, `) ? `${label}, ${said(cell.slice(label.length + 2))}` : said(cell);
}

/** @param {string} cell */
function isNumber(cell) {
  return cell !== "" && Number.isFinite(Number(cell));
}
