// @ts-check
// A list of objects with scalar fields as a table: a row each, to add and to take away. Its `value` is JSON text,
// "" = the default, which is shown until something is changed.

import { define, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { t } from "../js/i18n.js";
import { fieldsOf, rangeOf, readField } from "../js/schema.js";
import { nextRow } from "../js/scenario.js";

/** @import { ParametersSchema } from "../types.d.ts" */
/** @import { FieldSpec } from "../js/schema.js" */
/** @import { Values } from "../js/scenario.js" */

export class RowsEditor extends HTMLElement {
  /** Schema of one row. @type {ParametersSchema} */
  schema = {};
  /** What holds while nothing is typed. @type {Values[]} */
  default = [];
  label = "";
  /** @type {Values[] | null} */
  rows = null;

  connectedCallback() {
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", this.label);
    this.draw();
  }

  get value() {
    return this.rows ? JSON.stringify(this.rows) : "";
  }

  set value(text) {
    try {
      const given = text ? JSON.parse(text) : null;
      this.rows = Array.isArray(given) ? given : null;
    } catch {
      this.rows = null;
    }
    if (this.isConnected) this.draw();
  }

  focus() {
    /** @type {HTMLElement | null} */ (this.querySelector("input, select, button"))?.focus();
  }

  /** The rows that hold, typed or default. @returns {Values[]} */
  get current() {
    return this.rows ?? this.default;
  }

  draw() {
    const columns = fieldsOf(this.schema);
    const rows = this.current;
    this.note = h("div", { class: "small bad", "aria-live": "polite" });
    put(this,
      h("div", { class: "scroll" }, h("table", { class: "edit" },
        h("thead", null, h("tr", null, columns.map((one) => h("th", { scope: "col", title: one.description }, one.title, one.unit && one.unit !== "1" ? h("span", { class: "muted" }, `, ${one.unit}`) : null)), h("td"))),
        h("tbody", null, rows.map((row, i) => h("tr", null,
          columns.map((one) => h("td", { class: one.type === "text" || one.type === "choice" ? "text" : null }, this.cell(one, row, i))),
          h("td", null, h("button", { type: "button", class: "plain", title: t("scenarios.drop"), "aria-label": `${t("scenarios.drop")}: ${this.label} ${i + 1}`, onclick: () => this.take(rows.filter((_, k) => k !== i)) }, icon("close"))))))) ),
      h("div", null, h("button", { type: "button", class: "plain", "aria-label": `${t("scenarios.add")}: ${this.label}`, onclick: () => this.take([...rows, nextRow(this.schema.properties ?? {}, rows)], rows.length) }, icon("new"), t("scenarios.add"))),
      this.note);
  }

  /** @param {FieldSpec} field @param {Values} row @param {number} i */
  cell(field, row, i) {
    const name = `${field.title} ${i + 1}`;
    const value = row[field.name] ?? field.default;
    if (field.type === "choice") {
      return h("select", { value: String(value), "aria-label": name, oninput: (/** @type {Event} */ event) => this.typed(field, i, event) },
        field.choices.map((one) => h("option", { value: String(one.value) }, one.meaning || String(one.value))));
    }
    return h("input", { type: "text", value: value === null || value === undefined ? "" : String(value), "aria-label": name, autocomplete: "off", inputmode: field.type === "text" ? null : "decimal", oninput: (/** @type {Event} */ event) => this.typed(field, i, event) });
  }

  /** @param {FieldSpec} field @param {number} i @param {Event} event */
  typed(field, i, event) {
    event.stopPropagation();
    const input = /** @type {HTMLInputElement | HTMLSelectElement} */ (event.target);
    const { value, error } = readField(field, input.value);
    input.setAttribute("aria-invalid", String(Boolean(error)));
    if (this.note) this.note.textContent = error ? `${field.title} ${i + 1}: ${t(`field.${error}`, { range: rangeOf(field), unit: field.unit })}` : "";
    if (error) return;
    this.rows = this.current.map((row, k) => (k === i ? { ...row, [field.name]: value ?? field.default } : row));
    this.tell();
  }

  /** @param {Values[]} rows @param {number} [at] the row to go on in */
  take(rows, at = 0) {
    this.rows = rows;
    this.draw();
    const row = this.querySelectorAll("tbody tr")[at] ?? this;
    /** @type {HTMLElement | null} */ (row.querySelector("input, select, button"))?.focus();
    this.tell();
  }

  tell() {
    this.dispatchEvent(new Event("input", { bubbles: true }));
  }
}

define("rows-editor", RowsEditor);
