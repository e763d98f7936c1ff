// @ts-check
// A matrix of numbers as a form edits it: sums of its rows, another size, a table from the clipboard.

import { parseNumber } from "./numbers.js";

/** A cell that nobody has filled is null. @typedef {(number | null)[][]} Matrix */

/** A sum this near to what it must be is that: people write 0.333. */
export const SUM_TOLERANCE = 1e-6;

/** Sum of each row, null where a cell is empty. @param {Matrix} matrix @returns {(number | null)[]} */
export function rowSums(matrix) {
  return matrix.map((row) => (row.includes(null) ? null : /** @type {number[]} */ (row).reduce((sum, value) => sum + value, 0)));
}

/** Rows whose sum is known and is not `wanted`. @param {Matrix} matrix @param {number} wanted @returns {number[]} */
export function wrongRows(matrix, wanted) {
  return rowSums(matrix).flatMap((sum, i) => (sum !== null && Math.abs(sum - wanted) > SUM_TOLERANCE ? [i] : []));
}

/** @param {Matrix} matrix @returns {Matrix} */
export function transposed(matrix) {
  return matrix.map((_, i) => matrix.map((row) => row[i] ?? null));
}

/** Whether the columns sum to what the rows should. @param {Matrix} matrix @param {number} wanted */
export function looksTransposed(matrix, wanted) {
  const columns = transposed(matrix);
  return wrongRows(matrix, wanted).length > 0 && !rowSums(columns).includes(null) && wrongRows(columns, wanted).length === 0;
}

/**
 * The matrix with another number of rows and columns: what is new changes nothing (1 on the diagonal, else 0).
 * @param {Matrix} matrix
 * @param {number} n
 * @returns {Matrix}
 */
export function resized(matrix, n) {
  return Array.from({ length: n }, (_, i) => Array.from({ length: n }, (_, j) => {
    const known = matrix[i]?.[j];
    return known === undefined ? (i === j ? 1 : 0) : known;
  }));
}

/**
 * Read a table of numbers as spreadsheets, MATLAB and Python put it on the clipboard; null where it is none.
 * @param {string} text
 * @returns {number[][] | null}
 */
export function parseTable(text) {
  const bare = text.replace(/^[\s[(]+|[\s\])]+$/g, "");
  const lines = bare.split(/\r?\n|;|\]\s*,?\s*\[/).map((line) => line.trim()).filter(Boolean);
  const rows = lines.map((line) => line.replace(/[[\]]/g, " ").trim().split(/\t|\s+|,\s+/).map((cell) => parseNumber(cell.replace(/,$/, ""))));
  const width = rows[0]?.length ?? 0;
  if (!width || rows.some((row) => row.length !== width || row.includes(null))) return null;
  return /** @type {number[][]} */ (rows);
}
