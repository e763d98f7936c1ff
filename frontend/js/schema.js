// @ts-check
// From an algorithm's JSON schema to the fields of its form, and from what was typed back to parameters.

import { said } from "./i18n.js";
import { wrongRows } from "./matrix.js";
import { faultOf } from "./regions.js";
import { parseNumber, formatCount, formatExact } from "./numbers.js";

/** @import { ParameterSchema, ParametersSchema, Site, FieldError } from "../types.d.ts" */

/**
 * @typedef {object} FieldSpec
 * @property {string} name
 * @property {string} title
 * @property {string} description
 * @property {string} unit
 * @property {string} symbol
 * @property {string} group
 * @property {boolean} advanced
 * @property {"number" | "integer" | "boolean" | "choice" | "text" | "matrix" | "rows" | "points" | "regions" | "json"} type
 * @property {boolean} nullable
 * @property {unknown} default
 * @property {string} fromSite
 * @property {unknown} fallback
 * @property {{value: string | number, meaning: string}[]} choices
 * @property {number | null} least
 * @property {number | null} most
 * @property {boolean} leastOpen whether the lower bound itself is excluded
 * @property {boolean} mostOpen
 * @property {string} labelsFrom the field whose rows name the rows and columns of a matrix
 * @property {number | null} rowSum what each row of a matrix must sum to
 * @property {ParametersSchema} rowSchema the fields of one row of a list
 */

/** The order in which the groups of parameters stand in every form. */
const GROUPS = ["measurement", "motion", "association", "start", "output"];

/**
 * The fields of a schema, group by group, inside a group in the schema's order.
 * @param {ParametersSchema} schema
 * @returns {FieldSpec[]}
 */
export function fieldsOf(schema) {
  const place = (/** @type {FieldSpec} */ field) => (GROUPS.includes(field.group) ? GROUPS.indexOf(field.group) : GROUPS.length);
  return Object.entries(schema.properties ?? {}).map(([name, property]) => fieldOf(name, property, schema.$defs ?? {}))
    .sort((a, b) => place(a) - place(b));
}

/**
 * @param {string} name
 * @param {ParameterSchema} property
 * @param {Record<string, ParameterSchema>} definitions
 * @returns {FieldSpec}
 */
function fieldOf(name, property, definitions) {
  const options = (property.anyOf ?? [property]).map((one) => resolve(one, definitions));
  const nullable = options.some((one) => one.type === "null");
  const real = options.filter((one) => one.type !== "null");
  const main = { ...(real.length === 1 ? real[0] : {}) };
  const words = property.choices ?? {};
  const allowed = main.enum ?? (main.const !== undefined ? [main.const] : Object.keys(words));
  /** @type {FieldSpec["type"]} */
  let type = "json";
  if (real.length === 1) {
    if (allowed.length) type = "choice";
    else if (main.type === "number" || main.type === "integer" || main.type === "boolean") type = main.type;
    else if (main.type === "string") type = "text";
    else if (main.type === "array") type = listType(main, definitions);
  }
  const leastOpen = main.exclusiveMinimum ?? property.exclusiveMinimum;
  const mostOpen = main.exclusiveMaximum ?? property.exclusiveMaximum;
  return {
    name,
    title: said(property.title ?? name.charAt(0).toUpperCase() + name.slice(1).replaceAll("_", " ")),
    description: said(property.description ?? ""),
    // A number without a unit has "1" there; shown behind it, it would be read as a digit of it.
    unit: property.unit === "1" ? "" : said(property.unit ?? ""),
    symbol: property.symbol ?? "",
    group: property.group ?? "measurement",
    advanced: property.advanced ?? false,
    type,
    nullable,
    default: property.default ?? null,
    fromSite: property.from_site ?? "",
    fallback: property.fallback ?? null,
    choices: allowed.map((value) => ({
      value: /** @type {string | number} */ (value),
      meaning: said(words[String(value)] ?? ""),
    })),
    least: main.minimum ?? property.minimum ?? leastOpen ?? null,
    most: main.maximum ?? property.maximum ?? mostOpen ?? null,
    leastOpen: leastOpen !== undefined,
    mostOpen: mostOpen !== undefined,
    labelsFrom: property.labels_from ?? (type === "regions" ? matricesIn(main, definitions)[0]?.labels_from ?? "" : ""),
    rowSum: property.row_sum ?? null,
    rowSchema: { properties: resolve(main.items ?? {}, definitions).properties ?? {}, $defs: definitions },
  };
}

/** The properties of a list's objects that are matrices. @param {ParameterSchema} list @param {Record<string, ParameterSchema>} definitions */
function matricesIn(list, definitions) {
  return Object.values(resolve(list.items ?? {}, definitions).properties ?? {}).filter((one) => one.labels_from);
}

/**
 * Lists that have an editor of their own: rows of numbers, pairs of them, objects of single values, and regions, which
 * hold pairs beside matrices and single values.
 * @param {ParameterSchema} list
 * @param {Record<string, ParameterSchema>} definitions
 * @returns {"matrix" | "rows" | "points" | "regions" | "json"}
 */
function listType(list, definitions) {
  const item = resolve(list.items ?? {}, definitions);
  if (item.type === "array" && item.items?.type === "number") return "matrix";
  if (item.type === "array" && item.prefixItems?.length === 2 && item.prefixItems.every((one) => one.type === "number")) return "points";
  const types = Object.entries(item.properties ?? {}).map(([name, one]) => fieldOf(name, one, definitions).type);
  if (item.type !== "object" || !types.length || types.includes("json") || types.includes("rows") || types.includes("regions")) return "json";
  if (types.includes("points")) return "regions";
  return types.includes("matrix") ? "json" : "rows";
}

/**
 * @param {ParameterSchema} schema
 * @param {Record<string, ParameterSchema>} definitions
 * @returns {ParameterSchema}
 */
function resolve(schema, definitions) {
  const only = schema.$ref ?? (schema.allOf?.length === 1 ? schema.allOf[0]?.$ref : undefined);
  const found = only ? definitions[only.replace("#/$defs/", "")] : undefined;
  return found ?? schema;
}

/**
 * The value a field has when nothing is typed, and where it comes from.
 * Stations with different accuracies give a range, as the algorithm uses each station's own.
 * @param {FieldSpec} field
 * @param {Site | null} site
 * @returns {{text: string, source: "site" | "default" | "fallback"}}
 */
export function placeholderOf(field, site) {
  if (field.fromSite && field.default === null) {
    const values = siteValues(site, field.fromSite);
    if (values.length) {
      const low = Math.min(...values);
      const high = Math.max(...values);
      return { text: low === high ? formatExact(low) : `${formatExact(low)}…${formatExact(high)}`, source: "site" };
    }
    if (field.fallback !== null) return { text: formatExact(field.fallback), source: "fallback" };
  }
  const shown = field.default ?? field.fallback;
  return { text: shown === null || shown === undefined ? "" : formatExact(shown), source: "default" };
}

/**
 * @param {Site | null} site
 * @param {string} name
 * @returns {number[]}
 */
function siteValues(site, name) {
  if (!site) return [];
  const own = [site, ...(site.stations ?? []), ...(site.radars ?? [])];
  return own.map((place) => place[name]).filter((value) => typeof value === "number");
}

/**
 * Turn typed text into a parameter's value.
 * @param {FieldSpec} field
 * @param {string} text
 * @returns {{value?: unknown, error?: "not_a_number" | "not_whole" | "too_small" | "too_large" | "not_json" | "not_complete" | "row_sum" | "regions"}}
 */
export function readField(field, text) {
  const typed = text.trim();
  if (typed === "") return {};
  if (field.type === "number" || field.type === "integer") {
    const value = parseNumber(typed, field.unit);
    if (value === null) return { error: "not_a_number" };
    if (field.type === "integer" && !Number.isInteger(value)) return { error: "not_whole" };
    if (field.least !== null && (field.leastOpen ? value <= field.least : value < field.least)) return { error: "too_small" };
    if (field.most !== null && (field.mostOpen ? value >= field.most : value > field.most)) return { error: "too_large" };
    return { value };
  }
  if (field.type === "boolean") return { value: typed === "true" };
  if (field.type === "choice") {
    return { value: field.choices.find((choice) => String(choice.value) === typed)?.value ?? typed };
  }
  if (field.type === "text") return { value: typed };
  try {
    const value = JSON.parse(typed);
    if (field.type === "matrix" && Array.isArray(value)) {
      if (value.some((row) => !Array.isArray(row) || row.includes(null))) return { error: "not_complete" };
      if (field.rowSum !== null && wrongRows(value, field.rowSum).length) return { error: "row_sum" };
    }
    if (field.type === "regions" && Array.isArray(value) && faultOf(value, rulesOf(field.rowSchema, null))) return { error: "regions" };
    return { value };
  } catch {
    return { error: "not_json" };
  }
}

/**
 * What regions of a schema must keep.
 * @param {ParametersSchema} schema of one region
 * @param {number | null} size of their matrices, null = any
 * @returns {import("./regions.js").Rules}
 */
export function rulesOf(schema, size) {
  const fields = fieldsOf(schema);
  const named = (/** @type {string} */ start) => fields.find((field) => field.name.startsWith(start))?.name;
  const [low, high] = [named("lowest_"), named("highest_")];
  return { bands: low && high ? [[low, high]] : [], matrices: fields.filter((field) => field.type === "matrix").map((field) => ({ name: field.name, sum: field.rowSum })), size };
}

/**
 * The range of a field in signs, or an empty text.
 * @param {FieldSpec} field
 */
export function rangeOf(field) {
  const low = field.least === null ? "" : formatBound(field.least);
  const high = field.most === null ? "" : formatBound(field.most);
  if (low && high) return `${field.leastOpen ? ">" : ""}${field.leastOpen ? " " : ""}${low} … ${field.mostOpen ? "< " : ""}${high}`;
  if (low) return `${field.leastOpen ? ">" : "≥"} ${low}`;
  return high ? `${field.mostOpen ? "<" : "≤"} ${high}` : "";
}

/** @param {number} bound */
function formatBound(bound) {
  return Number.isInteger(bound) && Math.abs(bound) < 1e9 ? formatCount(bound) : formatExact(bound);
}

/**
 * Sort a problem's errors to the entries and parameters of the form they belong to.
 * @param {FieldError[]} errors
 * @returns {{entries: Map<number, Map<string, string>>, rest: FieldError[]}} an entry's own error stands under ""
 */
export function placeErrors(errors) {
  /** @type {Map<number, Map<string, string>>} */
  const entries = new Map();
  /** @type {FieldError[]} */
  const rest = [];
  for (const error of errors) {
    const found = /^\/algorithms\/(\d+)(?:\/parameters\/([^/]+)(\/.+)?|\/(label|name))?/.exec(error.pointer ?? "");
    if (!found) {
      rest.push(error);
      continue;
    }
    const index = Number(found[1]);
    const fields = entries.get(index) ?? new Map();
    const name = found[2] ?? found[4] ?? "";
    // A place inside a parameter is told twice: editors of lists show the place, other fields what is said of them.
    for (const place of found[3] ? [name, name + found[3]] : [name]) fields.set(place, [fields.get(place), said(error.detail)].filter(Boolean).join(" "));
    entries.set(index, fields);
  }
  return { entries, rest };
}
