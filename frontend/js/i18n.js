// @ts-check
// Every text of the page comes from a dictionary; `t` fills it in, plural forms follow the language.

import en from "../i18n/en.js";
import { translator } from "./sentences.js";

/** @typedef {keyof typeof en} Key */
/** @typedef {string | Record<string, string>} Entry */

export const LANGUAGES = /** @type {const} */ (["en", "ru"]);
/** @typedef {(typeof LANGUAGES)[number]} Language */

/** @type {Record<string, Entry>} */
let dictionary = en;
/** @type {Language} */
let current = "en";
/** The language's own words for what the server sends in English. @type {{codes: Record<string, string>, words: Record<string, string>, patterns: [RegExp, string][], sentences: Record<string, string>} | null} */
let server = null;
/** @type {(text: string) => string | null} */
let sentence = () => null;
let plurals = new Intl.PluralRules("en");

/** The language in use. */
export function language() {
  return current;
}

/** The stored choice, else the browser's wish, else English. @returns {Language} */
export function preferredLanguage() {
  const stored = localStorage.getItem("filterroom.language");
  const wish = stored ?? navigator.language.slice(0, 2);
  return LANGUAGES.find((name) => name === wish) ?? "en";
}

/**
 * Load a dictionary and make it the page's language.
 * @param {Language} name
 */
export async function setLanguage(name) {
  dictionary = name === "en" ? en : (await import(`../i18n/${name}.js`)).default;
  server = name === "en" ? null : await import(`../i18n/${name}-server.js`);
  sentence = server ? translator(server.sentences) : () => null;
  current = name;
  plurals = new Intl.PluralRules(name);
  document.documentElement.lang = name;
}

/**
 * The text of a key with its values filled in; `n` also chooses the plural form.
 * @param {Key} key
 * @param {Record<string, string | number>} [values]
 */
export function t(key, values = {}) {
  return render(dictionary[key] ?? en[key], values);
}

/**
 * The text of a code that the server chose; where the dictionary does not know it, the server's own words.
 * @param {string} key
 * @param {string} fallback
 */
export function told(key, fallback) {
  const entry = Object.hasOwn(dictionary, key) ? dictionary[key] : server?.codes[key];
  return entry === undefined ? said(fallback) : render(entry, {});
}

/**
 * Name of a metric; of a motion model's mean probability with the model's own name.
 * @param {string} name
 * @returns {string}
 */
export function metricName(name) {
  const model = /^mode_probability_(.+)$/.exec(name)?.[1];
  return model ? t("metric.mode_probability", { model }) : told(`metric.${name}`, name);
}

/**
 * What the server says in English, in the page's language where it is known there.
 * @param {string} text
 * @returns {string}
 */
export function said(text) {
  if (!server || !text) return text;
  const plain = text.replace(/\s+/g, " ").trim();
  const known = Object.hasOwn(server.words, plain) ? server.words[plain] : undefined;
  if (known !== undefined) return known;
  for (const [pattern, words] of server.patterns) if (pattern.test(plain)) return plain.replace(pattern, words);
  return sentence(plain) ?? text;
}

/**
 * @param {Entry | undefined} entry
 * @param {Record<string, string | number>} values
 */
function render(entry, values) {
  if (entry === undefined) return "";
  const text = typeof entry === "string" ? entry : (entry[plurals.select(Number(values.n))] ?? entry.other ?? "");
  return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}

/**
 * A UTC instant in the reader's own time zone, or a dash.
 * @param {string | null | undefined} iso
 */
export function formatInstant(iso) {
  if (!iso) return "–";
  return new Intl.DateTimeFormat(current === "en" ? "en-GB" : current, {
    dateStyle: "medium",
    timeStyle: "medium",
  }).format(new Date(iso));
}
