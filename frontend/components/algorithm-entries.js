// @ts-check
// The algorithms of a run that is being composed: which, under which labels, with which parameters. The same
// algorithm may stand there several times.

import { define, focusNear, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { said, t, told } from "../js/i18n.js";
import { swatch } from "../js/palette.js";
import "./parameter-form.js";

/** @import { Algorithm, RunEntry, Site } from "../types.d.ts" */
/** @import { ParameterForm } from "./parameter-form.js" */

/** @typedef {{algorithm: Algorithm, label: string, form: ParameterForm, open: boolean}} Entry */

export class AlgorithmEntries extends HTMLElement {
  /** @type {Algorithm[]} */
  algorithms = [];
  /** @type {Site | null} */
  site = null;
  /** @type {string | null} */
  kind = null;
  onchanged = () => {};
  /** Gets what the run's measurements look like in the plan. @type {() => Promise<import("../js/regions.js").Path[]>} */
  paths = async () => [];
  /** @type {Entry[]} */
  entries = [];

  connectedCallback() {
    this.list = h("div");
    this.adder = h("div");
    put(this, this.adder, this.list);
    this.draw();
  }

  /** @param {RunEntry[]} entries those whose algorithm is not known are left out and given back */
  setEntries(entries) {
    this.entries = [];
    const unknown = [];
    for (const { name, label, parameters } of entries) {
      const algorithm = this.algorithms.find((one) => one.name === name);
      if (algorithm) this.push(algorithm, label && label !== name ? label : "", parameters ?? {});
      else unknown.push(name);
    }
    this.draw();
    return unknown;
  }

  /**
   * @param {Site | null} site
   * @param {string | null} kind
   */
  setSource(site, kind) {
    this.showPaths();
    // Drawn anew, a form would take the field from under whoever types in it.
    if (site === this.site && kind === this.kind) return;
    this.site = site;
    this.kind = kind;
    for (const entry of this.entries) entry.form.setSite(site);
    this.draw();
  }

  /** What lies behind polygons in the forms is another now. */
  showPaths() {
    for (const entry of this.entries) entry.form.setPaths();
  }

  /** The entries as they would be sent. @returns {{entries: RunEntry[], wrong: boolean}} */
  read() {
    let wrong = false;
    const entries = this.entries.map(({ algorithm, label, form }) => {
      const read = form.read();
      if (read.wrong.length) wrong = true;
      /** @type {RunEntry} */
      const entry = { name: algorithm.name };
      if (label.trim()) entry.label = label.trim();
      if (Object.keys(read.parameters).length) entry.parameters = read.parameters;
      return entry;
    });
    return { entries, wrong };
  }

  /** @param {Map<number, Map<string, string>>} errors by entry and field */
  setErrors(errors) {
    this.errors = errors;
    this.entries.forEach((entry, i) => {
      const own = errors.get(i);
      if (own) entry.open = true;
    });
    this.draw();
    this.entries.forEach((entry, i) => entry.form.setErrors(new Map(errors.get(i) ?? [])));
  }

  /**
   * Mark fields while somebody types: nothing is drawn anew and the focus stays. What belongs to no field is returned.
   * @param {Map<number, Map<string, string>>} errors by entry and field
   */
  tellErrors(errors) {
    this.entries.forEach((entry, i) => entry.form.tellErrors(new Map(errors.get(i) ?? [])));
    return [...errors.values()].flatMap((own) => ["", "label", "name"].flatMap((place) => own.get(place) ?? []));
  }

  /**
   * @param {Algorithm} algorithm
   * @param {string} label
   * @param {Record<string, unknown>} parameters
   */
  push(algorithm, label, parameters) {
    const form = /** @type {ParameterForm} */ (document.createElement("parameter-form"));
    form.schema = algorithm.parameters_schema;
    form.site = this.site;
    form.paths = () => this.paths();
    form.setParameters(parameters);
    form.onchanged = () => this.onchanged();
    this.entries.push({ algorithm, label, form, open: this.entries.length === 0 || Object.keys(parameters).length > 0 });
  }

  /** @param {Algorithm} algorithm */
  add(algorithm) {
    const again = this.entries.filter((entry) => entry.algorithm === algorithm).length;
    this.push(algorithm, again ? `${algorithm.name} ${again + 1}` : "", {});
    const last = this.entries[this.entries.length - 1];
    if (last) last.open = true;
    this.draw();
    this.onchanged();
    // Drawn anew, the button lost the focus: whoever works with keys may want another one.
    /** @type {HTMLElement | null} */ (this.querySelector(`[data-add="${algorithm.name}"]`))?.focus({ preventScroll: true });
  }

  /** @param {Entry} entry */
  drop(entry) {
    const at = this.entries.indexOf(entry);
    this.entries = this.entries.filter((one) => one !== entry);
    this.errors = undefined;
    this.draw();
    this.onchanged();
    focusNear(this, "[data-drop]", `[data-add="${entry.algorithm.name}"]`, at);
  }

  draw() {
    if (!this.list || !this.adder) return;
    const fits = this.algorithms.filter((algorithm) => !this.kind || algorithm.takes.includes(this.kind));
    const families = [...new Set(fits.map((algorithm) => algorithm.family))];
    // Of one family the heading says nothing.
    put(this.adder, h("div", { class: "adder", role: "group", "aria-label": t("compose.add") },
      families.map((family) => h("div", { class: "row" },
        h("span", families.length > 1 ? { class: "muted small heading" } : { class: "muted" }, families.length > 1 ? told(`family.${family}`, family) : t("compose.add")),
        fits.filter((algorithm) => algorithm.family === family).map((algorithm) => this.addButton(algorithm)))),
      fits.some((algorithm) => algorithm.recommended) ? h("p", { class: "small muted" }, icon("recommended"), " ", t("compose.recommended")) : null));
    put(this.list, this.entries.length ? this.entries.map((entry, i) => this.card(entry, i)) : h("p", { class: "card panel-state" }, t("compose.no_algorithms")));
  }

  /** @param {Algorithm} algorithm */
  addButton(algorithm) {
    const { recommended } = algorithm;
    return h("button", {
      type: "button", title: [recommended ? t("algorithms.recommended") : "", said(algorithm.title), said(algorithm.summary)].filter(Boolean).join(". "), data: { add: algorithm.name }, onclick: () => this.add(algorithm),
    }, icon("new"), algorithm.name, recommended ? icon("recommended") : null);
  }

  /**
   * @param {Entry} entry
   * @param {number} i
   */
  card(entry, i) {
    const { algorithm } = entry;
    const own = this.errors?.get(i);
    const general = [own?.get(""), own?.get("label"), own?.get("name")].filter(Boolean).join(" ");
    const misfit = this.kind && !algorithm.takes.includes(this.kind) ? t("compose.misfit", { takes: algorithm.takes.join(", ") }) : "";
    const body = h("div", { class: "card-body", hidden: !entry.open }, entry.form);
    const toggle = h("button", {
      class: "plain", type: "button", "aria-expanded": String(entry.open), onclick: () => {
        entry.open = !entry.open;
        body.hidden = !entry.open;
        toggle.setAttribute("aria-expanded", String(entry.open));
        toggle.textContent = t(entry.open ? "compose.hide_form" : "compose.show_form");
      },
    }, t(entry.open ? "compose.hide_form" : "compose.show_form"));
    return h("section", { class: "card entry-card", "aria-label": entry.label || algorithm.name, data: { algorithm: algorithm.name } },
      h("div", { class: "card-head" },
        swatch(i), h("h3", null, algorithm.name),
        h("span", { class: "muted small clip grow", title: said(algorithm.title) }, said(algorithm.title)),
        h("input", {
          type: "text", value: entry.label, placeholder: algorithm.name, "aria-label": `${t("compose.label")}: ${algorithm.name}`, maxlength: 80, title: t("compose.label"), "aria-invalid": own?.has("label") ? "true" : null,
          oninput: (/** @type {Event} */ event) => {
            entry.label = /** @type {HTMLInputElement} */ (event.target).value;
            this.onchanged();
          },
        }),
        toggle,
        h("button", { class: "plain", type: "button", data: { drop: "" }, title: t("compose.drop"), "aria-label": `${t("compose.drop")}: ${entry.label || algorithm.name}`, onclick: () => this.drop(entry) }, icon("close"))),
      general || misfit ? h("p", { class: "bad small", role: "alert", style: "padding: 6px 12px 0" }, [general, misfit].filter(Boolean).join(" ")) : null,
      body);
  }
}

define("algorithm-entries", AlgorithmEntries);
