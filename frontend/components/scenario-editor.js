// @ts-check
// The editor of a scenario, made from its schema: numbers as fields, lists as tables, targets as cards with tables in
// them. What is typed changes a tree of values; errors stand at the field, the row or the list that they point to.

import { define, focusNear, h, put, uniqueId } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { said, t, told } from "../js/i18n.js";
import { fieldsOf, rangeOf, readField } from "../js/schema.js";
import { changedOf, completed, defaultsOf, nextRow, parseNumbers, serves, shapeOf } from "../js/scenario.js";
import { symbolOf } from "./parameter-form.js";
import { hiddenBy, pathChoice } from "./target-path.js";
import { copyText } from "./toast-area.js";

/** @import { ParameterSchema, ParametersSchema } from "../types.d.ts" */
/** @import { FieldSpec } from "../js/schema.js" */
/** @import { Shape, Values } from "../js/scenario.js" */

/** Where a message about a place is shown. @typedef {{input: HTMLElement | null, line: HTMLElement, label: string}} Spot */

export class ScenarioEditor extends HTMLElement {
  /** @type {ParametersSchema} */
  schema = {};
  /** @type {Values} */
  values = {};
  onchanged = () => {};
  /** Places by JSON pointer. @type {Map<string, Spot>} */
  spots = new Map();
  /** Typed texts that cannot be read, by JSON pointer. @type {Map<string, string>} */
  wrong = new Map();
  /** What the server said, by JSON pointer. @type {Map<string, string>} */
  told = new Map();
  /** Marks of changed fields. @type {(() => void)[]} */
  marks = [];

  connectedCallback() {
    this.draw();
  }

  /** @param {ParametersSchema} schema @param {Values} changed */
  setScenario(schema, changed) {
    this.schema = schema;
    this.values = completed({ ...defaultsOf(schema), ...structuredClone(changed) }, schema.properties ?? {}, schema.$defs ?? {});
    this.wrong.clear();
    this.told.clear();
    if (this.isConnected) this.draw();
  }

  /** What would be sent. */
  changed() {
    return changedOf(this.values, this.schema);
  }

  /** @param {Map<string, string>} places what the server said, by JSON pointer */
  setErrors(places) {
    this.told = places;
    this.showErrors();
  }

  get definitions() {
    return this.schema.$defs ?? {};
  }

  draw() {
    this.spots.clear();
    this.marks = [];
    const fields = fieldsOf(this.schema).filter((field) => serves(field.name, this.values));
    const groups = [...new Set(fields.map((field) => field.group))];
    this.json = h("textarea", { rows: 5, spellcheck: "false", "aria-label": t("form.json"), onchange: () => this.readJson() });
    put(this,
      groups.map((group) => this.group(group, fields.filter((field) => field.group === group))),
      h("details", { class: "card", ontoggle: () => this.showJson() },
        h("summary", { class: "card-head" }, t("form.json")),
        h("div", { class: "card-body stack tight" }, this.json,
          h("div", { class: "row small" }, h("button", { class: "link", type: "button", onclick: () => copyText(this.json?.value ?? "") }, t("action.copy")), h("span", { class: "muted" }, t("form.json_hint"))))));
    this.showErrors();
  }

  /** @param {string} name @param {FieldSpec[]} fields */
  group(name, fields) {
    const plain = fields.filter((field) => !field.advanced);
    const more = fields.filter((field) => field.advanced);
    const title = told(`group.${name}`, name);
    const changed = this.changed();
    const body = (/** @type {FieldSpec[]} */ some) => this.fields(some, this.values, "", true);
    return h("details", { class: "card", open: true, data: { group: name } },
      h("summary", { class: "card-head" }, h("h2", null, title)),
      h("div", { class: "card-body stack" }, body(plain),
        more.length ? h("details", { open: more.some((field) => field.name in changed) }, h("summary", null, t("form.more", { n: more.length })), h("div", { class: "stack", style: "margin-top: 8px" }, body(more))) : null));
  }

  /**
   * Fields of one object: scalars side by side, lists below each other.
   * @param {FieldSpec[]} fields
   * @param {Values} owner
   * @param {string} pointer
   * @param {boolean} top whether a field can be set back to the preset's value
   */
  fields(fields, owner, pointer, top = false) {
    const parts = fields.map((field) => ({ field, shape: this.shape(owner, field, top) }));
    const flat = parts.filter(({ shape }) => shape.kind === "scalar");
    return [
      flat.length ? h("div", { class: "fields" }, flat.map(({ field }) => this.field(field, owner, `${pointer}/${field.name}`, top))) : null,
      ...parts.filter(({ shape }) => shape.kind !== "scalar").map(({ field, shape }) => this.pieceOf(field, shape, owner, `${pointer}/${field.name}`, top)),
    ];
  }

  /** @param {Values} owner @param {FieldSpec} field @param {boolean} top */
  shape(owner, field, top) {
    const properties = top ? this.schema.properties : this.propertiesOf.get(owner);
    return shapeOf(properties?.[field.name] ?? {}, this.definitions);
  }

  /** The schema's properties of each nested object. @type {WeakMap<Values, Record<string, ParameterSchema>>} */
  propertiesOf = new WeakMap();

  /** @param {Record<string, ParameterSchema>} properties @param {Values} owner */
  specs(properties, owner) {
    this.propertiesOf.set(owner, properties);
    return fieldsOf({ properties, $defs: this.schema.$defs });
  }

  /** One scalar with its label. @param {FieldSpec} field @param {Values} owner @param {string} pointer @param {boolean} top */
  field(field, owner, pointer, top) {
    const input = this.input(field, owner, pointer);
    const hint = [field.description.replace(/\s+/g, " "), rangeOf(field) ? `${rangeOf(field)} ${field.unit}` : ""].filter(Boolean);
    const line = h("span", { class: "error", id: `${input.id}-error`, hidden: true });
    this.spots.set(pointer, { input, line, label: field.title });
    return h("div", { class: "field", data: { pointer } },
      h("div", { class: "name" }, h("label", { for: input.id }, field.title), field.symbol ? symbolOf(field.symbol) : null, top ? this.resetter(field) : null),
      h("div", { class: "entry" }, input, field.unit && field.type !== "choice" ? h("span", { class: "unit" }, field.unit) : null),
      top ? h("span", { class: "hint", title: hint.join(" ") }, hint[0] ?? "") : null, line);
  }

  /** A dot at what differs from the preset, and a way back. @param {FieldSpec} field */
  resetter(field) {
    const dot = h("span", { class: "dot", title: t("form.changed"), hidden: true });
    const button = h("button", {
      class: "link reset", type: "button", hidden: true, "aria-label": `${t("action.reset")}: ${field.title}`,
      onclick: () => {
        this.values[field.name] = defaultsOf(this.schema)[field.name];
        for (const place of this.wrong.keys()) if (place === `/${field.name}` || place.startsWith(`/${field.name}/`)) this.wrong.delete(place);
        this.draw();
        // A list has no field of its own: what adds to it.
        (this.spots.get(`/${field.name}`)?.input ?? /** @type {HTMLElement | null} */ (this.querySelector(`[data-add="/${field.name}"]`)))?.focus();
        this.changedNow();
      },
    }, t("action.reset"));
    this.marks.push(() => { dot.hidden = button.hidden = !(field.name in this.changed()); });
    return [dot, button];
  }

  /**
   * @param {FieldSpec} field
   * @param {Values} owner
   * @param {string} pointer
   * @returns {HTMLInputElement | HTMLSelectElement}
   */
  input(field, owner, pointer) {
    const id = uniqueId("scenario");
    const value = owner[field.name];
    const label = field.unit ? `${field.title}, ${field.unit}` : field.title;
    if (field.type === "choice" || field.type === "boolean") {
      const choices = field.type === "choice" ? field.choices : [{ value: "true", meaning: t("form.yes") }, { value: "false", meaning: t("form.no") }];
      return h("select", { id, value: String(value), "aria-label": label, oninput: (/** @type {Event} */ event) => {
        const chosen = /** @type {HTMLSelectElement} */ (event.target).value;
        owner[field.name] = field.type === "boolean" ? chosen === "true" : chosen;
        this.draw();
        this.spots.get(pointer)?.input?.focus();
        this.changedNow();
      } }, choices.map((one) => h("option", { value: String(one.value) }, one.meaning || String(one.value))));
    }
    const room = field.unit ? `padding-right: ${field.unit.length + 2}ch` : null;
    return h("input", {
      id, type: "text", value: value === null || value === undefined ? "" : String(value), "aria-label": label, autocomplete: "off", inputmode: field.type === "text" ? null : "decimal", style: room,
      placeholder: field.nullable ? t("scenarios.none") : field.default === null ? null : String(field.default),
      oninput: (/** @type {Event} */ event) => this.typed(field, owner, pointer, /** @type {HTMLInputElement} */ (event.target).value),
    });
  }

  /** @param {FieldSpec} field @param {Values} owner @param {string} pointer @param {string} text */
  typed(field, owner, pointer, text) {
    const { value, error } = readField(field, text);
    const empty = text.trim() === "";
    this.wrong.delete(pointer);
    if (error) this.wrong.set(pointer, t(`field.${error}`, { range: rangeOf(field), unit: field.unit }));
    else if (empty && field.type === "text") owner[field.name] = "";
    else if (empty && !field.nullable && field.default === null) this.wrong.set(pointer, t("scenarios.needed"));
    else if (empty) owner[field.name] = field.nullable ? null : field.default;
    else owner[field.name] = value;
    this.told.delete(pointer);
    this.changedNow();
  }

  /**
   * @param {FieldSpec} field
   * @param {Shape} shape
   * @param {Values} owner
   * @param {string} pointer
   * @param {boolean} top
   */
  pieceOf(field, shape, owner, pointer, top) {
    const head = h("div", { class: "name row" }, h("h3", { title: field.description, class: field.title === told(`group.${field.group}`, "") ? "sr-only" : null }, field.title), top ? this.resetter(field) : null);
    const line = h("p", { class: "error small bad", hidden: true });
    this.spots.set(pointer, { input: null, line, label: field.title });
    const box = h("div", { class: "stack tight", role: "group", "aria-label": field.title, data: { pointer } });
    const redraw = () => { put(box, head, this.inside(field, shape, owner, pointer, redraw), line); };
    redraw();
    return box;
  }

  /**
   * @param {FieldSpec} field
   * @param {Shape} shape
   * @param {Values} owner
   * @param {string} pointer
   * @param {() => void} redraw
   */
  inside(field, shape, owner, pointer, redraw) {
    const again = () => {
      for (const place of [...this.spots.keys()]) if (place.startsWith(`${pointer}/`)) this.spots.delete(place);
      for (const place of [...this.wrong.keys()]) if (place.startsWith(`${pointer}/`)) this.wrong.delete(place);
      // The lists of receptions stand elsewhere and have changed too.
      if (pointer === "/stations") this.draw();
      else redraw();
      this.changedNow();
    };
    if (shape.kind === "object") return this.optional(field, shape, owner, pointer, again);
    if (shape.kind === "numbers") {
      const input = this.numbers(field, owner, pointer);
      input.setAttribute("aria-label", field.unit ? `${field.title}, ${field.unit}` : field.title);
      const spot = this.spots.get(pointer);
      if (spot) this.spots.set(pointer, { ...spot, input });
      return input;
    }
    const rows = /** @type {Values[]} */ (owner[field.name] ?? []);
    const add = h("button", {
      type: "button", class: "plain", data: { add: pointer }, "aria-label": `${t("scenarios.add")}: ${field.title}`, onclick: () => {
        const row = nextRow(shape.properties, rows);
        if (Array.isArray(row.probabilities) && !row.probabilities.length) row.probabilities = this.values.stations.map(() => 1);
        owner[field.name] = [...rows, row];
        if (pointer === "/stations") this.eachReception((shares) => [...shares, 1]);
        again();
        [...this.spots].find(([place, { input }]) => input && place.startsWith(`${pointer}/${rows.length}/`))?.[1].input?.focus();
      },
    }, icon("new"), t("scenarios.add"));
    const drop = (/** @type {number} */ i) => h("button", {
      type: "button", class: "plain", data: { drop: pointer }, title: t("scenarios.drop"), "aria-label": `${t("scenarios.drop")}: ${field.title} ${i + 1}`, onclick: () => {
        owner[field.name] = rows.filter((_, k) => k !== i);
        if (pointer === "/stations") this.eachReception((shares) => shares.filter((_, k) => k !== i));
        again();
        focusNear(this, `[data-drop="${pointer}"]`, `[data-add="${pointer}"]`, i);
      },
    }, icon("close"));
    const nested = Object.values(shape.properties).some((one) => shapeOf(one, this.definitions).kind === "rows");
    const list = nested ? rows.map((row, i) => this.card(field, shape, row, `${pointer}/${i}`, drop(i), again)) : rows.length ? [this.table(field, shape, rows, pointer, drop)] : [];
    return h("div", { class: "stack tight" }, ...list, h("div", null, add));
  }

  /** What was drawn anew has the focus again. @param {string} pointer @param {string} what */
  focusIn(pointer, what) {
    /** @type {HTMLElement | null} */ (this.querySelector(`[data-pointer="${pointer}"] ${what}`))?.focus({ preventScroll: true });
  }

  /** The lists that follow the list of stations follow it. @param {(shares: number[]) => number[]} change */
  eachReception(change) {
    for (const interval of this.values.receptions ?? []) interval.probabilities = change(interval.probabilities);
  }

  /** An object that may be absent. @param {FieldSpec} field @param {Shape} shape @param {Values} owner @param {string} pointer @param {() => void} again */
  optional(field, shape, owner, pointer, again) {
    const given = owner[field.name];
    return h("div", { class: "stack tight" },
      h("label", { class: "check" }, h("input", {
        type: "checkbox", checked: Boolean(given), onchange: () => {
          owner[field.name] = given ? null : nextRow(shape.properties, []);
          again();
          this.focusIn(pointer, "[type=checkbox]");
        },
      }), field.description.replace(/\s+/g, " ")),
      ...(given ? this.fields(this.specs(shape.properties, given), given, pointer) : []));
  }

  /**
   * @param {FieldSpec} field
   * @param {Shape} shape
   * @param {Values} row
   * @param {string} pointer
   * @param {HTMLElement} drop
   * @param {() => void} again
   */
  card(field, shape, row, pointer, drop, again) {
    const line = h("p", { class: "error small bad", hidden: true });
    const number = Number(pointer.split("/").pop()) + 1;
    this.spots.set(pointer, { input: null, line, label: `${field.title} ${number}` });
    const specs = this.specs(shape.properties, row).filter((one) => !hiddenBy(row, one.name));
    return h("section", { class: "card entry", "aria-label": `${field.title} ${number}`, data: { pointer } },
      h("div", { class: "card-head" }, h("h3", { class: "grow" }, `${number}${row.name ? ` · ${row.name}` : ""}`), pathChoice(row, () => { again(); this.focusIn(pointer, "select"); }), drop),
      h("div", { class: "card-body stack" }, this.fields(specs, row, pointer), line));
  }

  /**
   * @param {FieldSpec} field
   * @param {Shape} shape
   * @param {Values[]} rows
   * @param {string} pointer
   * @param {(i: number) => HTMLElement} drop
   */
  table(field, shape, rows, pointer, drop) {
    const specs = this.specs(shape.properties, /** @type {Values} */ (rows[0]));
    const used = (/** @type {FieldSpec} */ one) => rows.some((row) => (row[one.name] ?? one.default ?? null) !== (one.default ?? null));
    const wide = this.wide.has(pointer) || specs.some((one) => one.advanced && used(one));
    const columns = specs.filter((one) => wide || !one.advanced);
    const cell = (/** @type {FieldSpec} */ one, /** @type {Values} */ row, /** @type {number} */ i) => {
      const place = `${pointer}/${i}/${one.name}`;
      const kind = shapeOf(shape.properties[one.name] ?? {}, this.definitions).kind;
      const input = kind === "numbers" ? this.numbers(one, row, place) : this.input({ ...one, unit: "" }, row, place);
      input.setAttribute("aria-label", `${one.title} ${i + 1}`);
      this.spots.set(place, { input, line: /** @type {Spot} */ (this.spots.get(pointer)).line, label: `${i + 1}, ${one.title}` });
      return h("td", { class: one.type === "text" || kind === "numbers" ? "text" : null }, input);
    };
    return h("div", { class: "scroll" },
      h("table", { class: "edit" },
        h("thead", null, h("tr", null, columns.map((one) => h("th", { scope: "col", title: one.description }, one.title, one.unit && one.unit !== "1" ? h("span", { class: "muted" }, `, ${one.unit}`) : null)),
          h("td", null, specs.some((one) => one.advanced) && !wide ? h("button", { class: "link small", type: "button", onclick: () => { this.wide.add(pointer); this.draw(); this.spots.get(`${pointer}/0/${specs.find((one) => one.advanced)?.name}`)?.input?.focus(); } }, t("scenarios.more_columns")) : null))),
        h("tbody", null, rows.map((row, i) => h("tr", null, columns.map((one) => cell(one, row, i)), h("td", null, drop(i)))))));
  }

  /** Tables whose rarely used columns are shown. @type {Set<string>} */
  wide = new Set();

  /** @param {FieldSpec} field @param {Values} owner @param {string} pointer */
  numbers(field, owner, pointer) {
    return h("input", {
      id: uniqueId("scenario"), type: "text", value: (owner[field.name] ?? []).join("  "), autocomplete: "off", oninput: (/** @type {Event} */ event) => {
        const numbers = parseNumbers(/** @type {HTMLInputElement} */ (event.target).value);
        this.wrong.delete(pointer);
        if (numbers) owner[field.name] = numbers;
        else this.wrong.set(pointer, t("scenarios.not_numbers"));
        this.told.delete(pointer);
        this.changedNow();
      },
    });
  }

  changedNow() {
    this.showErrors();
    this.showJson();
    this.onchanged();
  }

  /** Each message at the nearest place that is drawn. */
  showErrors() {
    for (const mark of this.marks) mark();
    for (const { input, line } of this.spots.values()) {
      input?.removeAttribute("aria-invalid");
      line.hidden = true;
      line.textContent = "";
    }
    this.unplaced = [];
    for (const [pointer, message] of [...this.told, ...this.wrong]) {
      let place = pointer;
      while (place && !this.spots.has(place)) place = place.slice(0, place.lastIndexOf("/"));
      const spot = this.spots.get(place);
      if (!spot) {
        this.unplaced.push(message);
        continue;
      }
      spot.input?.setAttribute("aria-invalid", "true");
      spot.line.hidden = false;
      const shared = [...this.spots.values()].some((other) => other !== spot && other.line === spot.line);
      const words = shared && spot.input ? `${spot.label}: ${said(message)}` : said(message);
      spot.line.textContent = [spot.line.textContent, words].filter(Boolean).join(" ");
      spot.line.closest("details")?.setAttribute("open", "");
    }
  }

  /** Messages that have no place in the editor. @type {string[]} */
  unplaced = [];

  showJson() {
    if (this.json && document.activeElement !== this.json) this.json.value = JSON.stringify(this.changed(), null, 1);
  }

  readJson() {
    try {
      const given = JSON.parse(this.json?.value || "{}");
      if (typeof given !== "object" || given === null || Array.isArray(given)) throw new SyntaxError("object expected");
      this.json?.removeAttribute("aria-invalid");
      this.setScenario(this.schema, given);
      this.changedNow();
    } catch (error) {
      if (!(error instanceof SyntaxError)) throw error;
      this.json?.setAttribute("aria-invalid", "true");
    }
  }
}

define("scenario-editor", ScenarioEditor);
