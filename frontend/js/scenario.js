// @ts-check
// A scenario as a tree of values: what shape each part has, what differs from the preset, what a further row holds.

import { parseNumber } from "./numbers.js";

/** @import { ParameterSchema, ParametersSchema } from "../types.d.ts" */

/** @typedef {Record<string, any>} Values */
/** @typedef {{kind: "scalar" | "rows" | "numbers" | "object", properties: Record<string, ParameterSchema>}} Shape */

/**
 * What a part of a scenario is: one value, a list of rows, a list of numbers, or an object that may be absent.
 * @param {ParameterSchema} property
 * @param {Record<string, ParameterSchema>} definitions
 * @returns {Shape}
 */
export function shapeOf(property, definitions) {
  const real = (property.anyOf ?? [property]).map((one) => resolved(one, definitions)).filter((one) => one.type !== "null");
  const [main] = real;
  if (real.length !== 1 || !main) return { kind: "scalar", properties: {} };
  if (main.type === "object") return { kind: "object", properties: main.properties ?? {} };
  if (main.type !== "array") return { kind: "scalar", properties: {} };
  const item = resolved(main.items ?? {}, definitions);
  return item.type === "object" ? { kind: "rows", properties: item.properties ?? {} } : { kind: "numbers", properties: {} };
}

/**
 * @param {ParameterSchema} schema
 * @param {Record<string, ParameterSchema>} definitions
 */
function resolved(schema, definitions) {
  return (schema.$ref ? definitions[schema.$ref.replace("#/$defs/", "")] : undefined) ?? schema;
}

/** The preset's own values. @param {ParametersSchema} schema @returns {Values} */
export function defaultsOf(schema) {
  return structuredClone(Object.fromEntries(Object.entries(schema.properties ?? {}).map(([name, property]) => [name, property.default ?? null])));
}

/**
 * Fill in what rows and objects leave out, as the server does: nothing is undefined afterwards.
 * @param {Values} values
 * @param {Record<string, ParameterSchema>} properties
 * @param {Record<string, ParameterSchema>} definitions
 * @returns {Values}
 */
export function completed(values, properties, definitions) {
  for (const [name, property] of Object.entries(properties)) {
    values[name] ??= structuredClone(property.default ?? null);
    const { kind, properties: inner } = shapeOf(property, definitions);
    const parts = kind === "rows" ? values[name] : kind === "object" && values[name] ? [values[name]] : [];
    if (Array.isArray(parts)) for (const part of parts) if (part && typeof part === "object") completed(part, inner, definitions);
  }
  return values;
}

/**
 * The top-level fields that differ from the preset; lists are given whole.
 * @param {Values} values
 * @param {ParametersSchema} schema
 * @returns {Values}
 */
export function changedOf(values, schema) {
  const own = defaultsOf(schema);
  return Object.fromEntries(Object.entries(values).filter(([name, value]) => !same(value, own[name])));
}

/** @param {unknown} a @param {unknown} b @returns {boolean} */
function same(a, b) {
  if (a === b) return true;
  if (typeof a !== "object" || typeof b !== "object" || !a || !b || Array.isArray(a) !== Array.isArray(b)) return false;
  // A field that is not given is its default, which the preset's own values spell out.
  const [one, other] = [/** @type {Values} */ (a), /** @type {Values} */ (b)];
  const names = [...new Set([...Object.keys(one), ...Object.keys(other)])];
  return names.every((name) => same(one[name] ?? null, other[name] ?? null));
}

/** Fields that only one way of timing looks at. @type {Record<string, string>} */
const OF_TIMING = { period_s: "regular", minimum_interval_s: "irregular", mean_extra_interval_s: "irregular", interrogators: "interrogators" };

/** Whether a field has a meaning with these values. @param {string} name @param {Values} values */
export function serves(name, values) {
  return !("timing" in values) || !(name in OF_TIMING) || OF_TIMING[name] === values.timing;
}

/** What one further row moves on from the last one, so that it is not the same again. */
const STEP_M = 1000;
const STEP_S = 60;

/**
 * A further row: like the last one but later, elsewhere and under another name; the first one from the schema.
 * @param {Record<string, ParameterSchema>} properties
 * @param {Values[]} rows
 * @returns {Values}
 */
export function nextRow(properties, rows) {
  const last = rows[rows.length - 1];
  if (!last) return Object.fromEntries(Object.entries(properties).map(([name, property]) => [name, blank(property)]));
  const row = structuredClone(last);
  const before = rows[rows.length - 2];
  if (typeof row.time_s === "number") row.time_s += before && last.time_s > before.time_s ? last.time_s - before.time_s : STEP_S;
  if (typeof row.stop_s === "number") [row.start_s, row.stop_s] = [last.stop_s, last.stop_s + Math.max(last.stop_s - last.start_s, 1)];
  if ("name" in row && row.name) row.name = freeName(rows.map((one) => String(one.name)));
  if (typeof row.east_m === "number") row.east_m += STEP_M;
  return row;
}

/** @param {ParameterSchema} property */
function blank(property) {
  if (property.default !== undefined) return structuredClone(property.default);
  if (property.type === "string") return "1";
  if (property.type === "array") return [];
  if (property.exclusiveMinimum !== undefined) return STEP_S;
  return property.type === "number" || property.type === "integer" ? 0 : null;
}

/** @param {string[]} taken */
function freeName(taken) {
  let n = taken.length + 1;
  while (taken.includes(String(n))) n += 1;
  return String(n);
}

/**
 * Read numbers as a person types them into one field: between spaces, semicolons, or commas with a space behind.
 * @param {string} text
 * @returns {number[] | null} null when one of them is none
 */
export function parseNumbers(text) {
  const parts = text.trim().split(/[\s;]+|,\s+/).map((part) => part.replace(/,$/, "")).filter(Boolean);
  const numbers = parts.map((part) => parseNumber(part));
  return numbers.includes(null) ? null : /** @type {number[]} */ (numbers);
}

/**
 * Read the values of a swept parameter: between semicolons, else between spaces with or without a comma, so that `0,5 1,5`
 * are two; between commas alone where there are no spaces. What is no number stays a text: a choice, or told wrong.
 * @param {string} text
 * @returns {(number | string)[]}
 */
export function sweptValues(text) {
  const typed = text.trim();
  const between = typed.includes(";") ? ";" : /\s/.test(typed) ? /\s*,\s+|\s+,\s*|\s+/ : ",";
  return typed.split(between).map((one) => one.trim()).filter(Boolean).map((one) => parseNumber(one) ?? one);
}

/**
 * Put what a problem says of a scenario to its places: pointers without the prefix of the request.
 * @param {import("../types.d.ts").FieldError[]} errors
 * @returns {Map<string, string>}
 */
export function placesOf(errors) {
  /** @type {Map<string, string>} */
  const places = new Map();
  for (const { pointer, detail } of errors) {
    const place = (pointer ?? "").replace(/^\/parameters/, "");
    places.set(place, [places.get(place), detail].filter(Boolean).join(" "));
  }
  return places;
}
