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

/**
 * @param {string} run
 * @param {string} name
 * @param {AbortSignal} [signal]
 */
export async function loadTable(run, name, signal) {
  /** @type {TableData} */
  const table = await get(`runs/${run}/tables/${name}.json`, { signal });
  return rowsAsObjects(table);
}
