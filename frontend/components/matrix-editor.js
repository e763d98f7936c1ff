// @ts-check
// A square matrix as a table of fields, with the sum of each row beside it. Its `value` is JSON text, "" = the default.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { looksTransposed, parseTable, resized, rowSums, transposed, wrongRows } from "../js/matrix.js";
import { formatExact, parseNumber } from "../js/numbers.js";

/** @import { Matrix } from "../js/matrix.js" */

export class MatrixEditor extends HTMLElement {
  /** What rows and columns stand for. @type {string[]} */
  names = [];
  /** What holds while nothing is typed. @type {Matrix | null} */
  default = null;
  /** What each row must sum to; null = anything. @type {number | null} */
  rowSum = null;
  label = "";
  /** @type {Matrix | null} */
  matrix = null;
  /** Texts that are no numbers, by "row column". @type {Map<string, string>} */
  wrong = new Map();

  connectedCallback() {
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", this.label);
    this.draw();
  }

  get value() {
    return this.matrix ? JSON.stringify(this.matrix) : "";
  }

  set value(text) {
    this.wrong.clear();
    try {
      const given = text ? JSON.parse(text) : null;
      this.matrix = Array.isArray(given) && given.every(Array.isArray) ? given : null;
    } catch {
      this.matrix = null;
    }
    if (this.isConnected) this.draw();
  }

  /** Rows and columns have other names, perhaps another number of them. @param {string[]} names */
  setNames(names) {
    if (names.join("\n") === this.names.join("\n")) return;
    this.names = names;
    if (this.matrix && names.length && this.matrix.length !== names.length) {
      this.matrix = resized(this.matrix, names.length);
      this.wrong.clear();
      this.tell();
    }
    if (this.isConnected) this.draw();
  }

  focus() {
    this.querySelector("input")?.focus();
  }

  get size() {
    return this.names.length || this.matrix?.length || this.default?.length || 0;
  }

  /** What holds: the typed matrix, else the default of this size, else nothing. @returns {Matrix} */
  get current() {
    const empty = Array.from({ length: this.size }, () => Array.from({ length: this.size }, () => null));
    return this.matrix ?? (this.default?.length === this.size ? this.default : empty);
  }

  draw() {
    const shown = this.current;
    const name = (/** @type {number} */ i) => this.names[i] ?? String(i + 1);
    this.sums = shown.map(() => h("td", { class: "sum" }));
    this.note = h("div", { class: "row small", "aria-live": "polite" });
    const cell = (/** @type {number} */ i, /** @type {number} */ j) => {
      const typed = this.matrix?.[i]?.[j];
      const standard = shown[i]?.[j];
      return h("td", null, h("input", {
        type: "text", inputmode: "decimal", autocomplete: "off", "aria-label": `${this.label}: ${name(i)} → ${name(j)}`,
        value: this.wrong.get(`${i} ${j}`) ?? (typed === null || typed === undefined ? "" : formatExact(typed)),
        placeholder: standard === null || standard === undefined ? "" : formatExact(standard),
        oninput: (/** @type {Event} */ event) => this.typed(i, j, event),
        onpaste: (/** @type {ClipboardEvent} */ event) => this.pasted(event),
      }));
    };
    put(this,
      h("div", { class: "scroll" }, h("table", { class: "edit matrix" },
        h("thead", null, h("tr", null, h("th", { class: "small muted", scope: "col" }, t("matrix.from_to")), shown.map((_, j) => h("th", { scope: "col" }, name(j))), h("th", { scope: "col", class: "sum" }, t("matrix.sum")))),
        h("tbody", null, shown.map((row, i) => h("tr", null, h("th", { scope: "row" }, name(i)), row.map((_, j) => cell(i, j)), this.sums?.[i] ?? null))))),
      this.note);
    this.judge();
  }

  /** @param {number} i @param {number} j @param {Event} event */
  typed(i, j, event) {
    event.stopPropagation();
    const text = /** @type {HTMLInputElement} */ (event.target).value.trim();
    const matrix = this.current.map((row) => [...row]);
    const row = /** @type {(number | null)[]} */ (matrix[i]);
    const number = text === "" ? (this.default?.length === this.size ? this.default[i]?.[j] ?? null : null) : parseNumber(text);
    this.wrong.delete(`${i} ${j}`);
    if (text && number === null) this.wrong.set(`${i} ${j}`, text);
    row[j] = number;
    this.matrix = matrix;
    const first = this.querySelectorAll("input");
    // Cells that showed the default as a hint now hold it.
    first.forEach((input, k) => {
      const value = matrix[Math.floor(k / this.size)]?.[k % this.size];
      if (input !== event.target && input.value === "" && value !== null && value !== undefined) input.value = formatExact(value);
    });
    this.judge();
    this.tell();
  }

  /** A whole table goes into the cells at once. @param {ClipboardEvent} event */
  pasted(event) {
    const table = parseTable(event.clipboardData?.getData("text") ?? "");
    if (!table || (table.length === 1 && table[0]?.length === 1)) return;
    event.preventDefault();
    if (table.length !== this.size || table[0]?.length !== this.size) {
      put(/** @type {HTMLElement} */ (this.note), h("span", { class: "bad" }, t("matrix.wrong_size", { rows: table.length, columns: table[0]?.length ?? 0, n: this.size })));
      return;
    }
    this.take(table);
  }

  /** @param {Matrix} matrix */
  take(matrix) {
    this.matrix = matrix;
    this.wrong.clear();
    this.draw();
    this.focus();
    this.tell();
  }

  tell() {
    this.dispatchEvent(new Event("input", { bubbles: true }));
  }

  /** The sums, which rows are wrong, and whether rows and columns were exchanged. */
  judge() {
    const shown = this.current;
    const bad = this.rowSum === null ? [] : wrongRows(shown, this.rowSum);
    rowSums(shown).forEach((sum, i) => {
      const cell = this.sums?.[i];
      if (!cell) return;
      cell.textContent = sum === null ? "" : formatExact(Number(sum.toPrecision(9)));
      cell.classList.toggle("bad", bad.includes(i));
    });
    if (!this.note) return;
    const rows = bad.map((i) => this.names[i] ?? String(i + 1)).join(", ");
    put(this.note, bad.length ? h("span", { class: "bad" }, t("matrix.row_sum", { rows, sum: this.rowSum ?? 1 })) : null,
      this.rowSum !== null && looksTransposed(shown, this.rowSum)
        ? [h("span", null, t("matrix.transposed")), h("button", { type: "button", class: "link", onclick: () => this.take(transposed(shown)) }, t("matrix.transpose"))] : null);
  }
}

define("matrix-editor", MatrixEditor);
