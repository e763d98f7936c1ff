// @ts-check
// Regions with a polygon, a height band and a matrix each, to add and to take away. Its `value` is JSON text, "" = none.

import { define, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { t } from "../js/i18n.js";
import { parseTable } from "../js/matrix.js";
import { formatExact, parseNumber } from "../js/numbers.js";
import { faultOf, knownCorners, placeIn } from "../js/regions.js";
import { fieldsOf, rangeOf, readField, rulesOf } from "../js/schema.js";
import { MatrixEditor } from "./matrix-editor.js";
import { RegionPlan } from "./region-plan.js";

/** @import { ParametersSchema } from "../types.d.ts" */
/** @import { Matrix } from "../js/matrix.js" */
/** @import { Corner, Path, Region } from "../js/regions.js" */
/** @import { FieldSpec } from "../js/schema.js" */

export class RegionsEditor extends HTMLElement {
  /** Schema of one region. @type {ParametersSchema} */
  schema = {};
  label = "";
  /** What rows and columns of the matrices stand for. @type {string[]} */
  names = [];
  /** The matrix that a new region begins with. @type {() => Matrix | null} */
  matrix = () => null;
  /** Gets what the run's measurements look like in the plan. @type {() => Promise<Path[]>} */
  paths = async () => [];
  /** @type {Region[]} */
  regions = [];
  /** What the server said, by pointer below the list. @type {Map<string, string>} */
  told = new Map();
  /** @type {Path[]} */
  behind = [];
  /** @type {RegionPlan[]} */
  plans = [];
  /** @type {MatrixEditor[]} */
  matrices = [];

  connectedCallback() {
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", this.label);
    this.draw();
    this.look();
  }

  get value() {
    return this.regions.length ? JSON.stringify(this.regions) : "";
  }

  set value(text) {
    try {
      const given = text ? JSON.parse(text) : [];
      this.regions = Array.isArray(given) ? given : [];
    } catch {
      this.regions = [];
    }
    if (this.isConnected) this.draw();
  }

  focus() {
    /** @type {HTMLElement | null} */ (this.querySelector("[aria-invalid=true]") ?? this.querySelector("input, button"))?.focus();
  }

  /** Another run, another path behind the polygons. */
  async look() {
    const asked = (this.asked = (this.asked ?? 0) + 1);
    const paths = this.regions.length ? await this.paths().catch(() => []) : [];
    if (asked !== this.asked || paths === this.behind) return;
    this.behind = paths;
    for (const plan of this.plans) plan.setPaths(paths);
  }

  /** @param {string[]} names */
  setNames(names) {
    if (names.join("\n") === this.names.join("\n")) return;
    this.names = names;
    for (const editor of this.matrices) editor.setNames(names);
  }

  draw() {
    const fields = fieldsOf(this.schema);
    this.plans = [];
    this.matrices = [];
    this.note = h("div", { class: "small bad", "aria-live": "polite" });
    put(this,
      this.regions.map((region, i) => this.region(fields, region, i)),
      h("div", null, h("button", { type: "button", class: "plain", "aria-label": `${t("scenarios.add")}: ${this.label}`, onclick: () => this.add(fields) }, icon("new"), t("regions.add"))),
      this.note);
    this.judge();
  }

  /** @param {FieldSpec[]} fields @param {Region} region @param {number} i */
  region(fields, region, i) {
    const single = fields.filter((field) => !["points", "matrix"].includes(field.type));
    const matrix = fields.find((field) => field.type === "matrix");
    const name = t("regions.region", { n: i + 1 });
    const plan = new RegionPlan();
    plan.label = `${name}: ${t("regions.plan")}`;
    plan.paths = this.behind;
    plan.setCorners(knownCorners(region), this.othersOf(i));
    plan.onchanged = (corners, done) => this.drawn(i, corners, done);
    this.plans.push(plan);
    const table = h("div", { class: "corners" });
    const box = h("section", { class: "card region", role: "group", "aria-label": name, data: { region: i } },
      h("div", { class: "card-head" }, h("h4", { class: "grow" }, name),
        h("button", { type: "button", class: "plain", title: t("scenarios.drop"), "aria-label": `${t("scenarios.drop")}: ${name}`, onclick: () => this.take(this.regions.filter((_, k) => k !== i)) }, icon("close"))),
      h("div", { class: "card-body stack" },
        h("div", { class: "fields" }, single.map((field) => this.single(field, region, i))),
        h("div", { class: "polygon" }, h("div", { class: "stack tight" }, h("span", { class: "small muted" }, t("regions.corners_hint")), table), h("div", { class: "stack tight" }, plan, h("span", { class: "small muted" }, t("regions.plan_hint")))),
        matrix ? this.matrixOf(matrix, region, i) : null));
    this.corners(table, i);
    return box;
  }

  /** @param {FieldSpec} field @param {Region} region @param {number} i */
  single(field, region, i) {
    const value = region[field.name];
    const label = field.unit ? `${field.title}, ${field.unit}` : field.title;
    return h("label", { class: "field" }, h("span", { class: "small" }, label),
      h("input", {
        type: "text", autocomplete: "off", inputmode: field.type === "text" ? null : "decimal", "aria-label": `${t("regions.region", { n: i + 1 })}: ${label}`, data: { field: field.name },
        value: value === undefined || value === null ? "" : String(value), placeholder: field.default === null || field.default === "" ? "" : formatExact(/** @type {number} */ (field.default)),
        oninput: (/** @type {Event} */ event) => {
          event.stopPropagation();
          const input = /** @type {HTMLInputElement} */ (event.target);
          const { value: read, error } = readField(field, input.value);
          input.setAttribute("aria-invalid", String(Boolean(error)));
          input.dataset.wrong = error ? t(`field.${error}`, { range: rangeOf(field), unit: field.unit }) : "";
          this.put(i, { [field.name]: error ? null : read });
        },
      }));
  }

  /** @param {FieldSpec} field @param {Region} region @param {number} i */
  matrixOf(field, region, i) {
    const editor = new MatrixEditor();
    editor.label = `${t("regions.region", { n: i + 1 })}: ${field.title}`;
    editor.rowSum = field.rowSum;
    editor.names = this.names;
    editor.value = JSON.stringify(region[field.name] ?? null);
    editor.addEventListener("input", (event) => {
      event.stopPropagation();
      this.put(i, { [field.name]: editor.matrix ?? undefined });
    });
    this.matrices.push(editor);
    return h("div", { class: "stack tight" }, h("span", { class: "small" }, field.title), editor);
  }

  /** The table of a region's corners. @param {HTMLElement} table @param {number} i */
  corners(table, i) {
    const rows = /** @type {Corner[]} */ (this.regions[i]?.corners ?? []);
    const cell = (/** @type {number} */ k, /** @type {0 | 1} */ axis) => h("td", null, h("input", {
      type: "text", inputmode: "decimal", autocomplete: "off", value: rows[k]?.[axis] ?? "", data: { corner: k, axis },
      "aria-label": `${t("regions.region", { n: i + 1 })}, ${t("regions.corner", { n: k + 1 })}: ${t(axis ? "regions.north_m" : "regions.east_m")}`,
      oninput: (/** @type {Event} */ event) => {
        event.stopPropagation();
        const number = parseNumber(/** @type {HTMLInputElement} */ (event.target).value.trim());
        const now = /** @type {Corner[]} */ (this.regions[i]?.corners ?? []);
        this.put(i, { corners: now.map((corner, n) => (n === k ? /** @type {Corner} */ (corner.with(axis, number)) : corner)) });
        this.show(i);
      },
      onpaste: (/** @type {ClipboardEvent} */ event) => this.pasted(event, table, i),
    }));
    // What was typed since the table was drawn counts.
    const again = (/** @type {(now: Corner[]) => Corner[]} */ change, /** @type {number} */ at) => {
      const next = change(/** @type {Corner[]} */ (this.regions[i]?.corners ?? []));
      this.put(i, { corners: next.length ? next : undefined });
      this.corners(table, i);
      this.show(i);
      this.judge();
      /** @type {HTMLElement | null} */ (table.querySelector(`input[data-corner="${at}"]`) ?? table.querySelector("button"))?.focus();
    };
    put(table,
      rows.length ? h("div", { class: "scroll" }, h("table", { class: "edit" },
        h("thead", null, h("tr", null, h("td"), h("th", { scope: "col" }, t("regions.east_m")), h("th", { scope: "col" }, t("regions.north_m")), h("td"))),
        h("tbody", null, rows.map((_, k) => h("tr", null, h("th", { scope: "row" }, k + 1), cell(k, 0), cell(k, 1),
          h("td", null, h("button", { type: "button", class: "plain", title: t("scenarios.drop"), "aria-label": `${t("scenarios.drop")}: ${t("regions.region", { n: i + 1 })}, ${t("regions.corner", { n: k + 1 })}`, onclick: () => again((now) => now.filter((__, n) => n !== k), Math.max(k - 1, 0)) }, icon("close")))))))) : h("p", { class: "small" }, t("regions.everywhere")),
      h("div", null, h("button", { type: "button", class: "plain", "aria-label": `${t("regions.add_corner")}: ${t("regions.region", { n: i + 1 })}`, onclick: () => again((now) => [...now, [null, null]], rows.length) }, icon("new"), t("regions.add_corner"))));
  }

  /** A table of two columns goes into the corners at once. @param {ClipboardEvent} event @param {HTMLElement} table @param {number} i */
  pasted(event, table, i) {
    const rows = parseTable(event.clipboardData?.getData("text") ?? "");
    if (!rows || rows[0]?.length !== 2) return;
    event.preventDefault();
    this.put(i, { corners: rows });
    this.corners(table, i);
    this.show(i);
    table.querySelector("input")?.focus();
  }

  /** The pointer has changed a polygon. @param {number} i @param {number[][]} corners @param {boolean} done */
  drawn(i, corners, done) {
    this.put(i, { corners });
    const table = /** @type {HTMLElement | null} */ (this.querySelector(`[data-region="${i}"] .corners`));
    if (table) this.corners(table, i);
    if (done) this.show(i);
  }

  /** Polygons of the other regions. @param {number} i */
  othersOf(i) {
    return this.regions.filter((_, k) => k !== i).map(knownCorners);
  }

  /** The plans after corners of a region were changed. @param {number} i */
  show(i) {
    this.plans.forEach((plan, k) => plan.setCorners(k === i ? knownCorners(this.regions[i] ?? {}) : plan.corners, this.othersOf(k)));
  }

  /** @param {FieldSpec[]} fields */
  add(fields) {
    const matrix = fields.find((field) => field.type === "matrix");
    const first = this.matrix();
    this.take([...this.regions, matrix && first ? { [matrix.name]: first } : {}], this.regions.length);
    if (this.regions.length === 1) this.look();
  }

  /** @param {Region[]} regions @param {number} [at] the region to go on in */
  take(regions, at = 0) {
    this.regions = regions;
    this.told = new Map();
    this.draw();
    /** @type {HTMLElement | null} */ (this.querySelector(`[data-region="${at}"] input`) ?? this.querySelector("button"))?.focus();
    this.tell();
  }

  /** @param {number} i @param {Record<string, unknown>} changed what is undefined is left out */
  put(i, changed) {
    this.regions = this.regions.map((region, k) => (k === i ? Object.fromEntries(Object.entries({ ...region, ...changed }).filter(([, value]) => value !== undefined)) : region));
    this.told = new Map();
    this.judge();
    this.tell();
  }

  tell() {
    this.dispatchEvent(new Event("input", { bubbles: true }));
  }

  /** @param {Map<string, string>} told what the server said, by pointer below the list */
  setErrors(told) {
    this.told = told;
    this.judge();
  }

  /** Say what is wrong, of which region and which corner, and mark the place. */
  judge() {
    if (!this.note) return;
    for (const input of this.querySelectorAll("input[data-corner], input[data-field]")) {
      if (/** @type {HTMLElement} */ (input).dataset.wrong) continue;
      input.setAttribute("aria-invalid", "false");
    }
    const says = [this.fault(), ...[...this.told].map(([pointer, detail]) => this.said(pointer, detail))].filter(Boolean);
    this.note.textContent = says.join(" ");
  }

  /** @returns {string} */
  fault() {
    const typed = /** @type {HTMLElement | null} */ (this.querySelector("input[data-wrong]:not([data-wrong=''])"));
    if (typed) return `${typed.getAttribute("aria-label")}: ${typed.dataset.wrong}`;
    const fault = faultOf(this.regions, rulesOf(this.schema, this.names.length));
    if (!fault) return "";
    const region = t("regions.region", { n: fault.region + 1 });
    if (fault.place === "corner") {
      this.mark(fault.region, `input[data-corner="${fault.at}"]`, (input) => input.value.trim() === "" || parseNumber(input.value.trim()) === null);
      return `${region}, ${t("regions.corner", { n: (fault.at ?? 0) + 1 })}: ${t("field.not_a_number", { unit: "m", range: "" })}`;
    }
    if (fault.place === "field") {
      this.mark(fault.region, `input[data-field="${fault.field}"]`);
      return `${region}: ${t("regions.no_height")}`;
    }
    if (fault.edges) {
      const [one = [], other = []] = fault.edges.map((edge) => edge.map((corner) => corner + 1));
      for (const corner of new Set(fault.edges.flat())) this.mark(fault.region, `input[data-corner="${corner}"]`);
      return `${region}: ${t("regions.wrong_crossing", { a: one[0], b: one[1], c: other[0], d: other[1] })}`;
    }
    return `${region}: ${t(`regions.wrong_${fault.place}`, { row: this.names[fault.at ?? 0] ?? "" })}`;
  }

  /** @param {string} pointer @param {string} detail */
  said(pointer, detail) {
    const place = placeIn(pointer);
    if (!place) return detail;
    const corner = place.corner === null ? "" : `, ${t("regions.corner", { n: place.corner + 1 })}`;
    if (place.corner !== null) this.mark(place.region, `input[data-corner="${place.corner}"]${place.axis === null ? "" : `[data-axis="${place.axis}"]`}`);
    else if (place.field) this.mark(place.region, `input[data-field="${CSS.escape(place.field)}"]`);
    return `${t("regions.region", { n: place.region + 1 })}${corner}: ${detail}`;
  }

  /** @param {number} region @param {string} selector @param {(input: HTMLInputElement) => boolean} [only] */
  mark(region, selector, only = () => true) {
    for (const input of this.querySelectorAll(`[data-region="${region}"] ${selector}`)) {
      if (only(/** @type {HTMLInputElement} */ (input))) input.setAttribute("aria-invalid", "true");
    }
  }
}

define("regions-editor", RegionsEditor);
