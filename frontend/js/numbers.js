// @ts-check
// Numbers as people type them and as the page shows them.

import { said } from "./i18n.js";

const THIN = "\u202f";
const KILOMETRES_FROM_M = 10_000;

/**
 * Read a number as a person types it: `1e3`, `0,5`, `1 000`, `100 m` (only the field's own unit).
 * @param {string} text
 * @param {string} [unit]
 * @returns {number | null} null when the text is not one finite number
 */
export function parseNumber(text, unit = "") {
  let body = text.trim().replace(/\u2212/g, "-");
  // A unit of digits, as "1" of what has none, is no unit: taken off 0.91 it would leave 0.9.
  if (/^\D+$/.test(unit) && body.toLowerCase().endsWith(unit.toLowerCase())) body = body.slice(0, body.length - unit.length).trim();
  body = body.replace(/(?<=\d)[\s\u00a0\u2009\u202f](?=\d{3}(?!\d))/g, "");
  if ((body.match(/,/g) ?? []).length === 1 && !body.includes(".")) body = body.replace(",", ".");
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(body)) return null;
  const value = Number(body);
  return Number.isFinite(value) ? value : null;
}

/**
 * Show a number with a given count of significant digits and thin spaces between thousands.
 * @param {number | null | undefined} value
 * @param {number} [digits]
 */
export function formatNumber(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e9 || size < 1e-4) return value.toExponential(digits - 1).replace("e+", "e").replace("-", "−");
  const places = Math.max(0, Math.min(20, digits - 1 - Math.floor(Math.log10(size))));
  return groupThousands(value.toFixed(size >= 10 ** (digits - 1) ? 0 : places));
}

/**
 * Show a whole number exactly.
 * @param {number | null | undefined} value
 */
export function formatCount(value) {
  return value === null || value === undefined ? "–" : groupThousands(String(Math.round(value)));
}

/**
 * Show a value exactly as it is kept (parameters, tables), without binary noise.
 * @param {unknown} value
 */
export function formatExact(value) {
  if (value === null || value === undefined || value === "") return "–";
  if (typeof value === "number") return String(Number(value.toPrecision(12)));
  if (typeof value === "object") return JSON.stringify(value, (_, one) => (one === null ? undefined : one)).replaceAll(",", ", ");
  return String(value);
}

/**
 * Show a share as a percentage with its unit.
 * @param {number | null | undefined} share
 */
export function formatShare(share) {
  return share === null || share === undefined ? "–" : `${formatNumber(share * 100)}${THIN}%`;
}

/**
 * Show a quantity: metres turn to kilometres above 10 km.
 * @param {number | null | undefined} value
 * @param {string} unit
 */
export function formatQuantity(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (unit === "m" && Math.abs(value) >= KILOMETRES_FROM_M) return `${formatNumber(value / 1000)} ${said("km")}`;
  if (unit && unit !== "1") return `${formatNumber(value)} ${said(unit)}`;
  // A count, such as that of tracks: decimals would say that it was measured.
  return Number.isInteger(value) ? formatCount(value) : formatNumber(value);
}

/**
 * Show the bounds of a value, in the unit in which the value itself is shown.
 * @param {number} low
 * @param {number} high
 * @param {number | null} value
 * @param {string} unit `share` = a share, shown in per cent
 */
export function formatBounds(low, high, value, unit) {
  const scale = unit === "share" ? 100 : unit === "m" && Math.abs(value ?? 0) >= KILOMETRES_FROM_M ? 1e-3 : 1;
  return `${formatNumber(low * scale)}…${formatNumber(high * scale)}`;
}

/**
 * Show a duration in seconds, minutes or hours.
 * @param {number | null | undefined} seconds
 */
export function formatDuration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  if (seconds < 60) return `${formatNumber(seconds, 2)} ${said("s")}`;
  const minutes = Math.floor(seconds / 60);
  if (minutes < 60) return `${minutes} ${said("min")} ${Math.round(seconds % 60)} ${said("s")}`;
  return `${Math.floor(minutes / 60)} ${said("h")} ${minutes % 60} ${said("min")}`;
}

/**
 * Show a size of a file.
 * @param {number | null | undefined} bytes
 */
export function formatBytes(bytes) {
  if (bytes === null || bytes === undefined) return "–";
  for (const [size, unit] of /** @type {[number, string][]} */ ([[1e9, "GB"], [1e6, "MB"], [1e3, "kB"]])) {
    if (bytes >= size) return `${formatNumber(bytes / size)} ${said(unit)}`;
  }
  return `${bytes} ${said("B")}`;
}

/** @param {string} text */
function groupThousands(text) {
  const [whole = "", fraction] = text.replace("-", "").split(".");
  const sign = text.startsWith("-") ? "−" : "";
  const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+(?!\d))/g, THIN) : whole;
  return sign + grouped + (fraction === undefined ? "" : `.${fraction}`);
}
