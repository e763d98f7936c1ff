// @ts-check
// Scenarios: choose a preset, change it, see at once what it makes; keep a recording of it or take it to a new run.
// The address holds everything: `preset`, `parameters` (JSON of what differs from the preset) and `seed`.

import { define, h, put, showChosen, uniqueId } from "../js/dom.js";
import { Problem, apiUrl, get, post } from "../js/api.js";
import { said, t, told } from "../js/i18n.js";
import { rememberQuery, routeTo } from "../js/router.js";
import { placesOf } from "../js/scenario.js";
import { setTitle } from "../components/app-frame.js";
import { takesTracks, tracksForm } from "../components/scenario-tracks.js";
import { emptyState, failed, loading } from "../components/states.js";
import { toast } from "../components/toast-area.js";
import "../components/scenario-editor.js";
import "../components/scenario-preview.js";

/** @import { Recording, Scenario } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { ScenarioEditor } from "../components/scenario-editor.js" */
/** @import { ScenarioPreview } from "../components/scenario-preview.js" */

class ScenariosPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {Scenario[]} */
  scenarios = [];
  /** @type {Scenario | null} */
  scenario = null;
  seed = 0;

  async connectedCallback() {
    setTitle(t("scenarios.title"));
    this.stop = new AbortController();
    put(this, loading());
    try {
      /** @type {{items: Scenario[]}} */
      const { items } = await get("scenarios", { signal: this.stop.signal });
      this.scenarios = items;
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, h("h1", { class: "sr-only" }, t("scenarios.title")), failed(error, { retry: () => this.connectedCallback() }));
      return;
    }
    this.draw();
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** The address was changed by hand, by a link or by going back. */
  queryChanged() {
    this.take();
  }

  draw() {
    const group = uniqueId("preset");
    const seed = uniqueId("seed");
    this.editor = /** @type {ScenarioEditor} */ (document.createElement("scenario-editor"));
    this.editor.onchanged = () => this.changed();
    this.preview = /** @type {ScenarioPreview} */ (document.createElement("scenario-preview"));
    this.preview.ontold = (problem) => this.editor?.setErrors(problem ? placesOf(problem.errors) : new Map());
    this.seedInput = h("input", { id: seed, type: "text", inputmode: "numeric", style: "width: 9ch", autocomplete: "off", oninput: () => this.seedTyped() });
    this.picker = h("div", { class: "picker", role: "radiogroup", "aria-label": t("scenarios.presets") },
      [...new Set(this.scenarios.map((one) => one.family))].flatMap((family) => [
        h("div", { class: "family small" }, told(`family.${family}`, family)),
        ...this.scenarios.filter((one) => one.family === family).map((one) => h("label", null,
          h("input", { type: "radio", name: group, value: one.name, onchange: () => this.choose(one) }),
          h("span", null, h("strong", null, said(one.title)), " ", h("code", { class: "muted" }, one.name), h("div", { class: "small muted" }, said(one.summary))))),
      ]));
    this.run = h("a", { class: "button", href: "#/new" }, t("scenarios.use"));
    this.store = h("button", { type: "button", class: "primary", onclick: () => this.keep(false) }, t("scenarios.store"));
    this.download = h("button", { type: "button", onclick: () => this.keep(true) }, t("scenarios.download"));
    this.message = h("div", { role: "status" });
    this.tracks = tracksForm(() => this.request(), (made) => {
      if (!this.scenario || this.scenario.name !== made.preset) return;
      this.show(this.scenario, made.parameters);
      this.remember();
    });
    put(this,
      h("div", { class: "page-head" }, h("h1", null, t("scenarios.title")),
        h("div", { class: "actions" },
          h("label", { for: seed, class: "row small muted" }, t("scenarios.seed")), this.seedInput,
          this.run, this.download, this.store)),
      this.message,
      this.scenarios.length
        ? h("div", { class: "scenario" },
          h("div", { class: "stack" }, this.picker, this.tracks, this.editor),
          h("div", { class: "scenario-view" }, this.preview))
        : emptyState(t("scenarios.none_registered")));
    this.take();
  }

  /** Show what the address says. */
  take() {
    const { query } = this.route;
    const wanted = query.get("preset");
    const scenario = this.scenarios.find((one) => one.name === wanted) ?? this.scenarios[0];
    if (!scenario || !this.editor || !this.seedInput) return;
    const { values, readable } = readParameters(query.get("parameters"));
    this.seed = Number(query.get("seed")) || 0;
    this.seedInput.value = String(this.seed);
    this.show(scenario, values);
    const lost = [wanted && scenario.name !== wanted ? t("scenarios.unknown", { name: wanted }) : "", readable ? "" : t("scenarios.unreadable")].filter(Boolean);
    put(/** @type {HTMLElement} */ (this.message), lost.length ? h("p", { class: "notice" }, lost.join(" ")) : null);
  }

  /** @param {Scenario} scenario */
  choose(scenario) {
    put(/** @type {HTMLElement} */ (this.message));
    this.show(scenario, {});
    this.remember();
  }

  /** @param {Scenario} scenario @param {Record<string, unknown>} values */
  show(scenario, values) {
    this.scenario = scenario;
    for (const radio of this.picker?.querySelectorAll("input") ?? []) radio.checked = radio.value === scenario.name;
    showChosen(this.picker);
    if (this.tracks) this.tracks.hidden = !takesTracks(scenario.parameters_schema);
    if (this.preview) this.preview.kind = scenario.kind;
    this.editor?.setScenario(scenario.parameters_schema, values);
    this.look(true);
  }

  changed() {
    this.remember();
    this.look(false);
  }

  seedTyped() {
    const text = this.seedInput?.value.trim() ?? "";
    const right = /^\d{1,15}$/.test(text);
    this.seedInput?.setAttribute("aria-invalid", String(!right));
    if (!right) return;
    this.seed = Number(text);
    this.changed();
  }

  request() {
    return { preset: this.scenario?.name, parameters: this.editor?.changed() ?? {}, seed: this.seed };
  }

  /** @param {boolean} now */
  look(now) {
    const readable = this.editor?.wrong.size === 0;
    for (const button of [this.store, this.download]) if (button) button.disabled = !readable;
    if (readable) this.preview?.ask(this.request(), now);
    else this.preview?.pause();
    const { preset, parameters, seed } = this.request();
    this.run?.setAttribute("href", routeTo(["new"], { scenario: JSON.stringify({ preset, parameters }), seed: String(seed) }));
  }

  remember() {
    const { preset, parameters, seed } = this.request();
    rememberQuery({ preset, parameters: Object.keys(parameters).length ? JSON.stringify(parameters) : null, seed: seed ? String(seed) : null });
  }

  /** Store one recording of the scenario; a download is of what was stored. @param {boolean} download */
  async keep(download) {
    const message = /** @type {HTMLElement} */ (this.message);
    // A button that is switched off loses the focus.
    const focused = [this.store, this.download].find((one) => one === document.activeElement);
    for (const button of [this.store, this.download]) if (button) button.disabled = true;
    try {
      /** @type {Recording} */
      const recording = await post("scenarios/recording", this.request());
      const file = h("a", { href: apiUrl(`recordings/${recording.id}/data.csv`), download: "" }, "data.csv");
      put(message, h("p", { class: "notice done" }, t("scenarios.stored"), " ",
        h("a", { href: routeTo(["recordings", recording.id]) }, recording.name), " · ", file, " · ",
        h("a", { href: routeTo(["new"], { recording: recording.id }) }, t("recordings.new_run"))));
      if (download) file.click();
      else toast(t("scenarios.stored"));
    } catch (error) {
      if (error instanceof Problem && error.status === 422) this.editor?.setErrors(placesOf(error.errors));
      put(message, failed(error));
    } finally {
      for (const button of [this.store, this.download]) if (button) button.disabled = this.editor?.wrong.size !== 0;
      if (document.activeElement === document.body) focused?.focus({ preventScroll: true });
    }
  }
}

/** @param {string | null} text */
function readParameters(text) {
  try {
    const values = JSON.parse(text ?? "{}");
    if (values && typeof values === "object" && !Array.isArray(values)) return { values, readable: true };
  } catch {
    // A cut-off address: the preset itself is shown, and that is said.
  }
  return { values: {}, readable: false };
}

define("scenarios-page", ScenariosPage);
