// @ts-check
// Tables of a run as objects by column name.

import { get } from "./api.js";

/** @import { Cell, TableData } from "../types.d.ts" */

/** @typedef {Record<string, Cell>} Row */

/**
 * @param {TableData} table
 * @returns {Row[]}
 */
export function rowsAsObjects(table) {
  return table.rows.map((row) => Object.fromEntries(table.columns.map((name, i) => [name, row[i] ?? null])));
}

// A table of the page shows at most so many rows; the rest is in the CSV, and the page says so.
const MOST_ROWS = 20000;

/**
 * @param {string} run
 * @param {string} name
 * @param {string} [target] only this one's rows
 * @returns {Promise<{rows: Row[], total: number}>}
 */
export async function loadTable(run, name, target = "") {
  /** @type {TableData} */
  const table = await get(`runs/${run}/tables/${name}.json`, { query: { limit: MOST_ROWS, target } });
  return { rows: rowsAsObjects(table), total: table.total ?? table.rows.length };
}
