// @ts-check
// A chart's numbers as a table, from the same address as the chart with the suffix `.csv`.

import { h, put } from "../js/dom.js";
import { apiUrl, getText } from "../js/api.js";
import { parseCsv } from "../js/csv.js";
import { t } from "../js/i18n.js";
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
    put(box,
      h("table", null,
        h("thead", null, h("tr", null, columns.map((name) => h("th", { scope: "col" }, name)))),
        h("tbody", null, rows.map((row) => h("tr", null, row.map((cell) => h("td", { class: isNumber(cell) ? "number" : null }, cell)))))),
      more ? h("p", { class: "table-foot" }, t("table.first_rows", { n: formatCount(rows.length) }), " ",
        h("a", { href: apiUrl(`${source}.csv`, query), download: "" }, t("table.all_as_csv"))) : null);
  } catch (error) {
    put(box, failed(error));
  }
  return box;
}

/** @param {string} cell */
function isNumber(cell) {
  return cell !== "" && Number.isFinite(Number(cell));
}
