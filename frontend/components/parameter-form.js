// @ts-check
// The form of one algorithm, made from its parameter schema. Only what was changed is sent; an empty field means
// the default, which is shown in its place.

import { define, h, put, uniqueId } from "../js/dom.js";
import { t, told } from "../js/i18n.js";
import { fieldsOf, placeholderOf, rangeOf, readField } from "../js/schema.js";
import { MatrixEditor } from "./matrix-editor.js";
import { RegionsEditor } from "./regions-editor.js";
import { RowsEditor } from "./rows-editor.js";
import { copyText } from "./toast-area.js";

/** @import { ParametersSchema, Site } from "../types.d.ts" */
/** @import { FieldSpec } from "../js/schema.js" */

/** @typedef {{root: HTMLElement, input: HTMLInputElement | HTMLSelectElement | HTMLTextAreaElement | MatrixEditor | RegionsEditor | RowsEditor, refresh: () => void}} FieldView */

export class ParameterForm extends HTMLElement {
  /** @type {ParametersSchema} */
  schema = {};
  /** @type {Site | null} */
  site = null;
  /** @type {Record<string, string>} typed text by field; "" or absent = default */
  texts = {};
  /** @type {Map<string, string>} what the server said about a field */
  told = new Map();
  onchanged = () => {};
  /** Gets what lies behind polygons. @type {() => Promise<import("../js/regions.js").Path[]>} */
  paths = async () => [];
  /** @type {Map<string, FieldView>} */
  views = new Map();

  connectedCallback() {
    this.fields = fieldsOf(this.schema);
    this.draw();
  }

  /** @param {Record<string, unknown>} parameters */
  setParameters(parameters) {
    this.texts = {};
    for (const [name, value] of Object.entries(parameters)) {
      if (value !== null && value !== undefined) this.texts[name] = typeof value === "object" ? JSON.stringify(value) : String(value);
    }
    if (this.isConnected) this.draw();
  }

  /** What would be sent: changed fields that can be read. @returns {{parameters: Record<string, unknown>, wrong: string[]}} */
  read() {
    /** @type {Record<string, unknown>} */
    const parameters = {};
    const wrong = [];
    for (const field of this.fields ?? fieldsOf(this.schema)) {
      const { value, error } = readField(field, this.texts[field.name] ?? "");
      if (error) wrong.push(field.name);
      else if (value !== undefined) parameters[field.name] = value;
    }
    return { parameters, wrong };
  }

  /** @param {Site | null} site */
  setSite(site) {
    this.site = site;
    for (const view of this.views.values()) view.refresh();
  }

  /** The run has other measurements now: what lies behind polygons. */
  setPaths() {
    for (const { input } of this.views.values()) if (input instanceof RegionsEditor) input.look();
  }

  /** Show what the server said about fields; focus the first. @param {Map<string, string>} errors */
  setErrors(errors) {
    this.tellErrors(errors)?.input.focus();
  }

  /** Show what the server said about fields; returns the view of the first. @param {Map<string, string>} errors */
  tellErrors(errors) {
    this.told = errors;
    for (const view of this.views.values()) view.refresh();
    const first = (this.fields ?? []).find((field) => errors.has(field.name));
    const view = first && this.views.get(first.name);
    view?.root.closest("details")?.setAttribute("open", "");
    return view;
  }

  draw() {
    this.views.clear();
    const fields = this.fields ?? [];
    const plain = fields.filter((field) => !field.advanced);
    const advanced = fields.filter((field) => field.advanced);
    const changed = advanced.some((field) => this.texts[field.name]);
    this.json = h("textarea", { rows: 4, spellcheck: "false", "aria-label": t("form.json"), onchange: () => this.readJson() });
    put(this,
      this.groups(plain),
      advanced.length ? h("details", { style: "margin-top: 12px", open: changed },
        h("summary", null, t("form.more", { n: advanced.length })), h("div", null, this.groups(advanced))) : null,
      h("details", { style: "margin-top: 12px", ontoggle: () => this.showJson() }, h("summary", { class: "small" }, t("form.json")),
        h("div", { class: "stack tight" }, this.json,
          h("div", { class: "row small" }, h("button", { class: "link", type: "button", onclick: () => copyText(this.json?.value ?? "") }, t("action.copy")), h("span", { class: "muted" }, t("form.json_hint"))))));
    if (!fields.length) put(this, h("p", { class: "muted" }, t("form.no_parameters")));
  }

  /** @param {FieldSpec[]} fields */
  groups(fields) {
    const names = [...new Set(fields.map((field) => field.group))];
    return names.map((name) => h("div", { class: "group", role: "group", "aria-label": told(`group.${name}`, name) },
      h("div", { class: "legend" }, told(`group.${name}`, name)),
      h("div", { class: "fields" }, fields.filter((field) => field.group === name).map((field) => this.field(field)))));
  }

  /** @param {FieldSpec} field */
  field(field) {
    const id = uniqueId("field");
    const input = this.input(field, id);
    const dot = h("span", { class: "dot", title: t("form.changed"), hidden: true });
    const reset = h("button", {
      class: "link reset", type: "button", hidden: true, "aria-label": `${t("action.reset")}: ${field.title}`, onclick: () => {
        input.value = "";
        this.typed(field, "");
        input.focus();
      },
    }, t("action.reset"));
    const hint = h("span", { class: "hint", id: `${id}-hint` });
    const error = h("span", { class: "error", id: `${id}-error`, hidden: true });
    const unit = field.unit && field.type !== "choice" && field.type !== "boolean";
    const wide = ["matrix", "rows", "regions"].includes(field.type);
    const root = h("div", { class: wide ? "field wide" : "field", data: { name: field.name } },
      h("div", { class: "name" },
        h("label", { for: id }, field.title),
        field.symbol ? symbolOf(field.symbol) : null,
        dot, reset),
      h("div", { class: "entry" }, input, unit ? h("span", { class: "unit" }, field.unit) : null),
      hint, error);
    const refresh = () => {
      const typed = this.texts[field.name] ?? "";
      const wrong = readField(field, typed).error;
      // The matrix itself says which row, the regions which of them and where.
      const message = wrong === "row_sum" || wrong === "regions" || input instanceof RegionsEditor ? "" : wrong ? t(`field.${wrong}`, { range: rangeOf(field), unit: field.unit }) : this.told.get(field.name);
      dot.hidden = reset.hidden = !typed;
      error.hidden = !message;
      error.textContent = message ?? "";
      input.setAttribute("aria-invalid", String(Boolean(wrong || message)));
      input.setAttribute("aria-describedby", message ? error.id : hint.id);
      hint.textContent = this.hintOf(field, typed);
      hint.title = words(field.description);
      if (input instanceof MatrixEditor || input instanceof RegionsEditor) input.setNames(this.namesOf(field));
      if (input instanceof RegionsEditor) input.setErrors(new Map([...this.told].filter(([place]) => place.startsWith(`${field.name}/`))));
      if (input instanceof HTMLSelectElement) this.showDefault(field, input);
      else if (!(input instanceof MatrixEditor || input instanceof RowsEditor || input instanceof RegionsEditor)) input.placeholder = placeholderOf(field, this.site).text;
    };
    this.views.set(field.name, { root, input, refresh });
    refresh();
    return root;
  }

  /**
   * @param {FieldSpec} field
   * @param {string} id
   */
  input(field, id) {
    const value = this.texts[field.name] ?? "";
    const onchange = (/** @type {Event} */ event) => this.typed(field, /** @type {HTMLInputElement} */ (event.target).value);
    if (field.type === "choice" || field.type === "boolean") {
      const choices = field.type === "boolean" ? ["true", "false"] : field.choices.map((choice) => String(choice.value));
      const words = (/** @type {string} */ one) => (field.type === "boolean" ? t(one === "true" ? "form.yes" : "form.no") : one);
      return h("select", { id, value, oninput: onchange }, h("option", { value: "" }), choices.map((one) => h("option", { value: one }, words(one))));
    }
    if (field.type === "regions") return this.regions(field, value, onchange);
    if (field.type === "matrix" || field.type === "rows") return this.list(field, value, onchange);
    if (field.type === "json") return h("textarea", { id, value, rows: 2, spellcheck: "false", oninput: onchange });
    const room = field.unit ? `padding-right: ${field.unit.length + 2}ch` : null;
    return h("input", { id, value, type: "text", inputmode: field.type === "text" ? null : "decimal", autocomplete: "off", style: room, oninput: onchange });
  }

  /**
   * A list that is edited as a table.
   * @param {FieldSpec} field
   * @param {string} value
   * @param {(event: Event) => void} onchange
   */
  list(field, value, onchange) {
    const editor = field.type === "matrix" ? new MatrixEditor() : new RowsEditor();
    editor.label = field.title;
    if (Array.isArray(field.default)) editor.default = field.default;
    if (editor instanceof RowsEditor) editor.schema = field.rowSchema;
    else editor.rowSum = field.rowSum;
    editor.value = value;
    editor.addEventListener("input", onchange);
    return editor;
  }

  /**
   * @param {FieldSpec} field
   * @param {string} value
   * @param {(event: Event) => void} onchange
   */
  regions(field, value, onchange) {
    const editor = new RegionsEditor();
    editor.label = field.title;
    editor.schema = field.rowSchema;
    editor.names = this.namesOf(field);
    editor.paths = () => this.paths();
    // A new region begins with the matrix that holds elsewhere.
    editor.matrix = () => {
      const whole = (this.fields ?? []).find((one) => one.type === "matrix" && one.labelsFrom === field.labelsFrom);
      const read = whole ? readField(whole, this.texts[whole.name] ?? "").value ?? whole.default : null;
      return Array.isArray(read) ? read : null;
    };
    editor.value = value;
    editor.addEventListener("input", onchange);
    return editor;
  }

  /** Names of a matrix' rows: the single values of the rows of another field, as in "cv 0.05". @param {FieldSpec} field */
  namesOf(field) {
    const other = (this.fields ?? []).find((one) => one.name === field.labelsFrom);
    if (!other) return [];
    const rows = readField(other, this.texts[other.name] ?? "").value ?? other.default;
    return Array.isArray(rows) ? rows.map((row) => Object.values(row ?? {}).filter((one) => typeof one !== "object").map(String).join(" ")) : [];
  }

  /** Name the default in the empty choice. @param {FieldSpec} field @param {HTMLSelectElement} select */
  showDefault(field, select) {
    const empty = select.options[0];
    if (!empty) return;
    const { text } = placeholderOf(field, this.site);
    const word = field.type === "boolean" ? t(text === "true" ? "form.yes" : "form.no") : text;
    empty.textContent = word ? t("form.default", { value: word }) : t("form.default_unnamed");
  }

  /** @param {FieldSpec} field @param {string} typed */
  hintOf(field, typed) {
    const parts = [];
    const { text, source } = placeholderOf(field, this.site);
    const chosen = field.type === "choice" ? (typed || text) : "";
    const meaning = field.choices.find((choice) => String(choice.value) === chosen)?.meaning;
    if (meaning) parts.push(`${chosen}: ${meaning}.`);
    if (source === "site" && !typed) parts.push(t("form.from_site"));
    if (source === "fallback" && !typed) parts.push(t("form.site_has_none"));
    // One sentence under the field; all of them are in its tooltip and in the catalogue.
    if (field.description && !meaning) parts.push(words(field.description).split(/(?<=\.)\s/)[0]);
    const range = rangeOf(field);
    if (range) parts.push(`${range}${field.unit ? ` ${field.unit}` : ""}`);
    return parts.join(" ");
  }

  /** @param {FieldSpec} field @param {string} text */
  typed(field, text) {
    this.texts[field.name] = text;
    for (const place of [...this.told.keys()]) if (place === field.name || place.startsWith(`${field.name}/`)) this.told.delete(place);
    this.views.get(field.name)?.refresh();
    for (const other of this.fields ?? []) if (other.labelsFrom === field.name) this.views.get(other.name)?.refresh();
    this.showJson();
    this.onchanged();
  }

  showJson() {
    if (this.json && document.activeElement !== this.json) this.json.value = JSON.stringify(this.read().parameters, null, 1);
  }

  readJson() {
    try {
      const parameters = JSON.parse(this.json?.value || "{}");
      if (typeof parameters !== "object" || parameters === null || Array.isArray(parameters)) throw new SyntaxError("object expected");
      this.json?.removeAttribute("aria-invalid");
      this.setParameters(parameters);
      this.onchanged();
    } catch {
      this.json?.setAttribute("aria-invalid", "true");
    }
  }
}

/** A description in one line. @param {string} text */
function words(text) {
  return text.replace(/\s+/g, " ").trim();
}

/** A symbol of the paper with its index: σ_n. @param {string} text */
export function symbolOf(text) {
  const [base = "", index] = text.split(/_(.*)/s);
  return h("span", { class: "symbol", "aria-hidden": "true" }, base, index ? h("sub", null, index) : null);
}

define("parameter-form", ParameterForm);
