// @ts-check
// Simulated trials as the source of a run: which scenario, how many trials from which seed, and what is swept.

import { define, focusNear, h, put, showChosen, uniqueId } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { said, t } from "../js/i18n.js";
import { routeTo } from "../js/router.js";
import { sweptValues } from "../js/scenario.js";
import { fieldsOf } from "../js/schema.js";

/** @import { Algorithm, RunEntry, Scenario, TrialsRequest } from "../types.d.ts" */

// The server's own limits and default.
const TRIALS = 100;
const MOST_TRIALS = 1_000_000;

/** @typedef {{name: string, text: string}} SweepRow */

export class ScenarioSource extends HTMLElement {
  /** @type {Scenario[]} */
  scenarios = [];
  /** @type {Algorithm[]} */
  algorithms = [];
  onchanged = () => {};
  preset = "";
  /** Whether somebody chose the preset; until then it is one that the algorithms take. */
  chosen = false;
  /** @type {Record<string, unknown>} */
  parameters = {};
  trials = String(TRIALS);
  seed = "0";
  /** @type {SweepRow[]} */
  rows = [];
  /** @type {RunEntry[]} the algorithms of the run: their parameters can be swept too */
  entries = [];

  connectedCallback() {
    this.draw();
  }

  /** @returns {Scenario | undefined} */
  get scenario() {
    return this.scenarios.find((one) => one.name === this.preset);
  }

  /** Take what an address or an earlier run says. @param {Partial<TrialsRequest>} request */
  take({ scenario, trials, seed, sweep }) {
    if (scenario) {
      this.preset = scenario.preset;
      this.parameters = scenario.parameters ?? {};
    }
    this.chosen = Boolean(this.scenario);
    if (!this.chosen) this.preset = this.fitting();
    if (trials) this.trials = String(trials);
    if (seed) this.seed = String(seed);
    if (sweep) this.rows = Object.entries(sweep).map(([name, values]) => ({ name, text: values.map((one) => (typeof one === "string" ? one : JSON.stringify(one))).join("; ") }));
    this.draw();
  }

  /** @param {RunEntry[]} entries */
  setEntries(entries) {
    const names = JSON.stringify(this.names());
    this.entries = entries;
    const fitting = this.chosen ? this.preset : this.fitting();
    if (fitting !== this.preset) {
      this.preset = fitting;
      this.draw();
    } else if (JSON.stringify(this.names()) !== names) this.drawSweep();
  }

  /** The first preset whose measurements all chosen algorithms take; else the first. */
  fitting() {
    const taken = this.entries.map((entry) => this.algorithms.find((one) => one.name === entry.name)?.takes ?? []);
    return (this.scenarios.find(({ kind }) => taken.every((kinds) => kinds.includes(kind))) ?? this.scenarios[0])?.name ?? "";
  }

  /** What would be sent, and whether something typed cannot be read. @returns {{request: TrialsRequest, wrong: boolean}} */
  read() {
    const trials = Number(this.trials.replace(/\s/g, ""));
    const seed = Number(this.seed);
    /** @type {Record<string, unknown[]>} */
    const sweep = {};
    let wrong = !this.preset || !isTrials(this.trials) || !isSeed(this.seed);
    for (const row of this.rows) {
      const values = sweptValues(row.text);
      if (!row.name || !values.length) wrong = true;
      else sweep[row.name] = values;
    }
    return {
      request: {
        scenario: { preset: this.preset, ...(Object.keys(this.parameters).length ? { parameters: this.parameters } : {}) },
        trials, seed, ...(Object.keys(sweep).length ? { sweep } : {}),
      },
      wrong,
    };
  }

  changed() {
    this.onchanged();
  }

  draw() {
    if (!this.isConnected) return;
    const group = uniqueId("preset");
    const [trials, seed] = [uniqueId("trials"), uniqueId("seed")];
    this.sweepBox = h("div", { class: "stack" });
    const number = (/** @type {string} */ id, /** @type {string} */ value, /** @type {(text: string) => boolean} */ right, /** @type {(text: string) => void} */ oninput) => h("input", {
      id, type: "text", inputmode: "numeric", autocomplete: "off", value, style: "width: 12ch",
      oninput: (/** @type {Event} */ event) => {
        const input = /** @type {HTMLInputElement} */ (event.target);
        oninput(input.value.trim());
        input.setAttribute("aria-invalid", String(!right(input.value.trim())));
        this.changed();
      },
    });
    put(this,
      h("div", { class: "picker", role: "radiogroup", "aria-label": t("scenarios.presets") }, this.scenarios.map((one) => h("label", null,
        h("input", { type: "radio", name: group, value: one.name, checked: one.name === this.preset, onchange: () => this.choose(one.name) }),
        h("span", null, h("strong", null, said(one.title)), " ", h("code", { class: "muted" }, one.name), h("div", { class: "small muted" }, said(one.summary)))))),
      this.state = h("div", { class: "row small" }),
      h("div", { class: "row" },
        h("div", { class: "field" }, h("label", { for: trials, class: "small muted" }, t("trials.count")), number(trials, this.trials, isTrials, (text) => { this.trials = text; })),
        h("div", { class: "field" }, h("label", { for: seed, class: "small muted" }, t("scenarios.seed")), number(seed, this.seed, isSeed, (text) => { this.seed = text; }))),
      h("h3", null, t("trials.sweep")),
      this.sweepBox);
    showChosen(this.querySelector(".picker"));
    this.drawState();
    this.drawSweep();
  }

  /** @param {string} preset */
  choose(preset) {
    this.preset = preset;
    this.chosen = true;
    this.parameters = {};
    this.drawState();
    this.drawSweep();
    this.changed();
  }

  drawState() {
    if (!this.state) return;
    const n = Object.keys(this.parameters).length;
    put(this.state,
      h("span", { class: "muted" }, n ? t("trials.changed", { n }) : t("trials.unchanged")),
      h("a", { href: routeTo(["scenarios"], { preset: this.preset, parameters: n ? JSON.stringify(this.parameters) : null, seed: this.seed === "0" ? null : this.seed }) }, t("trials.edit")));
  }

  /** Every number that a run on this scenario has. */
  names() {
    const own = (/** @type {string} */ owner, /** @type {import("../types.d.ts").ParametersSchema} */ schema) => fieldsOf(schema)
      .filter((field) => field.type === "number" || field.type === "integer" || field.type === "choice")
      .map((field) => ({ name: `${owner}.${field.name}`, title: field.title, unit: field.unit, owner }));
    return [
      ...(this.scenario ? own("scenario", this.scenario.parameters_schema) : []),
      ...this.entries.flatMap((entry) => {
        const algorithm = this.algorithms.find((one) => one.name === entry.name);
        return algorithm ? own(entry.label ?? entry.name, algorithm.parameters_schema) : [];
      }),
    ];
  }

  drawSweep() {
    if (!this.sweepBox) return;
    const names = this.names();
    const owners = [...new Set(names.map((one) => one.owner))];
    put(this.sweepBox,
      h("p", { class: "small muted" }, t("trials.sweep_hint")),
      this.rows.map((row, i) => h("div", { class: "row", role: "group", "aria-label": t("trials.sweep_row", { n: i + 1 }), data: { sweep: row.name } },
        h("select", { "aria-label": t("trials.sweep_name"), value: row.name, style: "width: auto; max-width: 26ch", onchange: (/** @type {Event} */ event) => {
          row.name = /** @type {HTMLSelectElement} */ (event.target).value;
          this.changed();
        } }, h("option", { value: "" }, t("trials.sweep_choose")),
        names.some((one) => one.name === row.name) || !row.name ? null : h("option", { value: row.name }, row.name),
        owners.map((owner) => h("optgroup", { label: owner === "scenario" ? t("trials.scenario") : owner }, names.filter((one) => one.owner === owner).map((one) => h("option", { value: one.name }, one.unit ? `${one.title}, ${one.unit}` : one.title))))),
        h("input", { type: "text", class: "grow", value: row.text, placeholder: "10; 30; 100", "aria-label": t("trials.sweep_values"), autocomplete: "off", oninput: (/** @type {Event} */ event) => {
          row.text = /** @type {HTMLInputElement} */ (event.target).value;
          this.changed();
        } }),
        h("button", { type: "button", class: "plain", title: t("trials.sweep_drop"), "aria-label": `${t("trials.sweep_drop")}: ${row.name}`, onclick: () => {
          this.rows = this.rows.filter((one) => one !== row);
          this.drawSweep();
          this.changed();
          focusNear(this.sweepBox, "[data-sweep] button", "button", i);
        } }, icon("close")))),
      h("div", null, h("button", { type: "button", onclick: () => {
        this.rows.push({ name: "", text: "" });
        this.drawSweep();
        this.changed();
        /** @type {HTMLElement | undefined} */ ([...(this.sweepBox?.querySelectorAll("[data-sweep] select") ?? [])].at(-1))?.focus();
      } }, icon("new"), t("trials.sweep_add"))));
  }
}

/** @param {string} text */
function isTrials(text) {
  const trials = Number(text.replace(/\s/g, ""));
  return Number.isInteger(trials) && trials >= 1 && trials <= MOST_TRIALS;
}

/** @param {string} text */
function isSeed(text) {
  return /^\d{1,15}$/.test(text);
}

define("scenario-source", ScenarioSource);
