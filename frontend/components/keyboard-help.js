// @ts-check
// The list of keys, opened with `?`, and the keys themselves.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { go } from "../js/router.js";

/** @import { Key } from "../js/i18n.js" */

/** @type {[string[], Key][]} */
const KEYS = [
  [["g", "r"], "keys.runs"],
  [["g", "d"], "keys.recordings"],
  [["g", "a"], "keys.algorithms"],
  [["g", "s"], "keys.scenarios"],
  [["n"], "keys.new"],
  [["/"], "keys.filter"],
  [["j", "k"], "keys.rows"],
  [["Enter"], "keys.open"],
  [["e"], "keys.edit"],
  [["x"], "keys.pick"],
  [["c"], "keys.compare"],
  [["←", "→"], "keys.cursor"],
  [["Enter"], "keys.target"],
  [["Esc"], "keys.escape"],
  [["?"], "keys.help"],
];

/** @type {Record<string, string>} */
const PLACES = { r: "#/runs", d: "#/recordings", a: "#/algorithms", s: "#/scenarios" };
// After `g` the second key must come within this time.
const PAIR_MS = 1500;

class KeyboardHelp extends HTMLElement {
  connectedCallback() {
    this.className = "help";
    this.setAttribute("popover", "auto");
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", t("keys.title"));
    put(this, h("h2", null, t("keys.title")),
      h("dl", null, KEYS.map(([keys, text]) => [
        h("dt", { class: "row tight" }, keys.map((key) => h("kbd", null, key))),
        h("dd", null, t(text)),
      ]).flat()));
    this.stop = new AbortController();
    document.addEventListener("keydown", (event) => this.onKey(event), { signal: this.stop.signal });
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** @param {KeyboardEvent} event */
  onKey(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    const typing = target.matches?.("input:not([type=checkbox], [type=radio]), textarea, select");
    if (event.key === "Escape" && typing) target.blur();
    if (typing || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const key = latin(event);
    const pair = this.firstAt !== undefined && Date.now() - this.firstAt < PAIR_MS;
    this.firstAt = key === "g" ? Date.now() : undefined;
    const place = pair ? PLACES[key] : undefined;
    if (place) go(place);
    else if (key === "?") this.togglePopover();
    else if (key === "n") go("#/new");
    else if (key === "/") /** @type {HTMLElement | null} */ (document.querySelector("main input[type=search]"))?.focus();
    else if (key === "j" || key === "k") moveRow(key === "j" ? 1 : -1);
    else if (key === "e") inRow("[data-edit]")?.click();
    else if (key === "x") inRow("[data-pick]")?.click();
    else if (key === "c") /** @type {HTMLElement | null} */ (document.querySelector("main compare-tray:not([hidden]) [data-compare]"))?.click();
    else return;
    event.preventDefault();
  }
}

/**
 * The key as a Latin keyboard has it: with a Russian layout switched on, the same keys serve.
 * @param {KeyboardEvent} event
 */
function latin({ key, code }) {
  if (/^\p{L}$/u.test(key) && !/^[a-z]$/i.test(key)) return code.replace(/^Key/, "").toLowerCase();
  if (code === "Slash" && (key === "." || key === ",")) return key === "," ? "?" : "/";
  return key;
}

/** Move the focus along the rows of the page's first list. @param {number} step */
function moveRow(step) {
  const rows = /** @type {HTMLElement[]} */ ([...document.querySelectorAll("main [data-row-link]")]);
  const here = document.activeElement?.closest("tr");
  const at = rows.findIndex((row) => row === document.activeElement || (here !== null && here === row.closest("tr")));
  rows[Math.min(rows.length - 1, Math.max(0, at + step))]?.focus();
}

/** What a key acts on: in the row that has the focus, else in the head of the page. @param {string} selector */
function inRow(selector) {
  const place = document.activeElement?.closest("tr") ?? document.querySelector("main .run-head");
  return /** @type {HTMLElement | null} */ (place?.querySelector(selector) ?? null);
}

define("keyboard-help", KeyboardHelp);
