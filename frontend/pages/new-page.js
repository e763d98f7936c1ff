// @ts-check
// Compose a run: where the marks come from at the left, what is done with them at the right, start below.

import { define, h, put, showChosen, uniqueId } from "../js/dom.js";
import { Problem, get, listAll, post } from "../js/api.js";
import { said, t } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatBytes, formatDuration } from "../js/numbers.js";
import { go, rememberQuery, routeTo } from "../js/router.js";
import { pathsOf } from "../js/regions.js";
import { placeErrors } from "../js/schema.js";
import { setTitle } from "../components/app-frame.js";
import { takeDropped } from "../components/drop-zone.js";
import { readTags } from "../components/run-name-form.js";
import { readCounts, rejectionsTable, rowsWords, siteWords, warningsList } from "../components/recording-report.js";
import { emptyState, failed, loading, stateBadge } from "../components/states.js";
import { toast } from "../components/toast-area.js";
import "../components/algorithm-entries.js";
import "../components/recording-upload.js";
import "../components/scenario-source.js";

/** @import { Algorithm, Recording, Run, RunEntry, RunEstimate, Scenario } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { AlgorithmEntries } from "../components/algorithm-entries.js" */
/** @import { RecordingUpload } from "../components/recording-upload.js" */
/** @import { ScenarioSource } from "../components/scenario-source.js" */

/** @typedef {"recording" | "upload" | "scenario"} Mode */

class NewPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {Recording[]} */
  recordings = [];
  /** @type {Recording | null} */
  recording = null;
  /** Other recordings to run on as one with it. @type {Set<string>} */
  together = new Set();
  beside = h("div");
  /** @type {(() => void) | null} */
  unwatch = null;
  /** The plan that was last asked for, by what it shows. @type {{key: string, paths: Promise<import("../js/regions.js").Path[]>} | null} */
  planOf = null;

  async connectedCallback() {
    setTitle(t("compose.title"));
    this.stop = new AbortController();
    put(this, loading());
    try {
      const [recordings, algorithms, scenarios] = await Promise.all([
        /** @type {Promise<Recording[]>} */ (listAll("recordings", { signal: this.stop.signal })),
        /** @type {Promise<{items: Algorithm[]}>} */ (get("algorithms", { signal: this.stop.signal })),
        /** @type {Promise<{items: Scenario[]}>} */ (get("scenarios", { signal: this.stop.signal })),
      ]);
      this.scenarios = scenarios.items;
      this.recordings = recordings;
      this.algorithms = algorithms.items;
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, failed(error, { retry: () => this.connectedCallback() }));
      return;
    }
    this.draw();
    const look = throttled(() => this.lookAgain());
    this.unwatch = watch((news) => { if (!news || news.kind === "recording.changed") look(); });
  }

  disconnectedCallback() {
    this.stop?.abort();
    clearTimeout(this.asking);
    this.unwatch?.();
  }

  draw() {
    const { query } = this.route;
    const dropped = takeDropped();
    const uploading = dropped.length > 0 || query.get("source") === "upload" || !this.recordings.length;
    this.entries = /** @type {AlgorithmEntries} */ (document.createElement("algorithm-entries"));
    this.entries.algorithms = this.algorithms ?? [];
    this.entries.onchanged = () => this.remember();
    this.entries.paths = () => this.paths();
    this.upload = /** @type {RecordingUpload} */ (document.createElement("recording-upload"));
    this.upload.onuploaded = (recording) => this.take(recording);
    this.picker = h("div", { class: "picker", role: "radiogroup", "aria-label": t("compose.recording") });
    this.trials = /** @type {ScenarioSource} */ (document.createElement("scenario-source"));
    Object.assign(this.trials, { scenarios: this.scenarios ?? [], algorithms: this.algorithms ?? [] });
    this.trials.take(readTrials(query));
    this.trials.onchanged = () => this.remember();
    this.report = h("div", { class: "stack", "aria-live": "polite" });
    this.sourceBody = h("div", { class: "card-body stack" });
    this.message = h("div", { class: "grow" });
    const label = uniqueId("run");
    this.label = h("input", { id: label, type: "text", maxlength: 200, placeholder: t("compose.run_label_hint"), value: query.get("label") ?? "", oninput: () => this.remember() });
    const tags = uniqueId("tags");
    this.tags = h("input", { id: tags, type: "text", placeholder: t("run.tags_hint"), value: query.getAll("tag").join(", "), oninput: () => this.remember() });
    this.seed = Number(query.get("seed")) || 0;
    this.start = h("button", { class: "primary", type: "button", onclick: () => this.submit() }, t("compose.start"));
    put(this,
      h("h1", { class: "sr-only" }, t("compose.title")),
      h("div", { class: "compose" },
        h("section", { class: "card", "aria-label": t("compose.source") },
          h("div", { class: "card-head" }, h("h2", { class: "grow" }, t("compose.source")),
            h("div", { class: "segments", role: "group", "aria-label": t("compose.source") }, /** @type {Mode[]} */ (["recording", "upload", "scenario"]).map((mode) => h("button", { type: "button", data: { mode }, onclick: () => { this.setMode(mode); this.remember(); } }, t(`compose.mode_${mode}`))))),
          this.sourceBody),
        h("section", { "aria-label": t("compose.algorithms") }, this.entries)),
      h("div", { class: "startbar" },
        h("div", { class: "field" }, h("label", { for: label, class: "small muted" }, t("compose.run_label")), this.label),
        h("div", { class: "field" }, h("label", { for: tags, class: "small muted" }, t("run.tags")), this.tags),
        this.seed && !query.has("scenario") ? h("span", { class: "small muted" }, t("compose.seed", { seed: this.seed })) : null,
        this.estimate = h("span", { class: "small muted", role: "status" }),
        this.message, this.start));
    const wanted = query.getAll("a").flatMap(readEntry);
    const unknown = this.entries.setEntries(wanted);
    if (unknown.length) put(this.message, h("p", { class: "warn" }, t("compose.unknown_algorithms", { names: unknown.join(", ") })));
    this.setMode(query.has("scenario") || query.get("source") === "scenario" ? "scenario" : uploading ? "upload" : "recording");
    if (dropped.length) this.upload.takeFiles(dropped);
    const [id, ...others] = query.getAll("recording");
    this.together = new Set(others);
    if (id) this.choose(id);
    else if (this.mode === "recording" && this.recordings.length === 1 && this.recordings[0]) this.choose(this.recordings[0].id);
    this.checkStart();
  }

  /** @param {Mode} mode */
  setMode(mode) {
    this.mode = mode;
    if (!this.sourceBody || !this.upload || !this.picker || !this.report || !this.trials) return;
    for (const button of this.querySelectorAll("[data-mode]")) button.setAttribute("aria-pressed", String(/** @type {HTMLElement} */ (button).dataset.mode === mode));
    this.drawPicker();
    if (mode === "scenario") {
      this.trials.setEntries(this.entries?.read().entries ?? []);
      put(this.sourceBody, this.trials);
      this.entries?.setSource(null, this.trials.scenario?.kind ?? null);
    } else {
      put(this.sourceBody, mode === "upload" ? this.upload : this.picker, this.beside, this.report);
      this.entries?.setSource(this.recording?.site ?? null, this.recording?.kind ?? null);
    }
    this.checkStart();
  }

  drawPicker() {
    const group = uniqueId("recording");
    put(/** @type {HTMLElement} */ (this.picker), this.recordings.length ? this.recordings.map((recording) => h("label", null,
      h("input", { type: "radio", name: group, value: recording.id, checked: recording.id === this.recording?.id, disabled: recording.state === "failed", onchange: () => this.choose(recording.id) }),
      h("span", { class: "break" }, recording.name, h("br", null),
        h("span", { class: "small muted" }, recording.state === "ready"
          ? [rowsWords(recording.kind, recording.rows.accepted), siteWords(recording)].filter(Boolean).join(", ")
          : stateBadge(recording.state))))) : emptyState(t("compose.no_recordings")));
  }

  /** Recordings of other radars that may be joined to the chosen one. */
  drawBeside() {
    const { recording } = this;
    const others = this.recordings.filter((one) => one.id !== recording?.id && one.kind === "polar_plots" && one.state === "ready");
    // Only plots of radars can be joined.
    if (recording?.kind !== "polar_plots") this.together.clear();
    for (const id of this.together) if (!others.some((one) => one.id === id)) this.together.delete(id);
    put(this.beside, recording?.kind === "polar_plots" && others.length ? h("details", { open: this.together.size > 0 },
      h("summary", null, t("compose.together")),
      h("fieldset", { class: "plain" }, h("legend", { class: "small muted" }, t("compose.together_hint")),
        others.map((one) => h("label", { class: "row" },
          h("input", { type: "checkbox", checked: this.together.has(one.id), onchange: (/** @type {Event} */ event) => this.join(one.id, /** @type {HTMLInputElement} */ (event.target).checked) }),
          h("span", { class: "break" }, one.name))))) : null);
  }

  /** @param {string} id @param {boolean} wanted */
  join(id, wanted) {
    if (wanted) this.together.add(id);
    else this.together.delete(id);
    if (this.recording) rememberQuery({ recording: [this.recording.id, ...this.together] });
    this.checkStart();
  }

  /** Take what was uploaded as the source. @param {Recording} recording */
  take(recording) {
    this.recordings = [recording, ...this.recordings.filter((one) => one.id !== recording.id)];
    this.setMode("recording");
    this.choose(recording.id, recording);
  }

  /**
   * @param {string} id
   * @param {Recording} [known]
   */
  async choose(id, known) {
    this.together.delete(id);
    rememberQuery({ recording: [id, ...this.together], source: null });
    try {
      const recording = known?.rejections ? known : /** @type {Recording} */ (await get(`recordings/${id}`, { signal: this.stop?.signal }));
      this.recording = recording;
      this.entries?.setSource(recording.site, recording.kind);
      this.showReport(recording);
      this.drawBeside();
      for (const radio of this.picker?.querySelectorAll("input") ?? []) radio.checked = radio.value === id;
      showChosen(this.picker);
    } catch (error) {
      if (this.stop?.signal.aborted) return;
      this.recording = null;
      put(/** @type {HTMLElement} */ (this.report), failed(error));
    }
    this.checkStart();
  }

  /** The recordings may be others now: read to the end, uploaded in another tab, deleted there. */
  async lookAgain() {
    /** @type {Recording[]} */
    const found = await listAll("recordings", { signal: this.stop?.signal }).catch(() => this.recordings);
    if (JSON.stringify(found) === JSON.stringify(this.recordings)) return;
    this.recordings = found;
    const focused = this.picker?.contains(document.activeElement) ? /** @type {HTMLInputElement} */ (document.activeElement).value : null;
    this.drawPicker();
    if (focused) /** @type {HTMLElement | null | undefined} */ (this.picker?.querySelector(`input[value="${CSS.escape(focused)}"]`))?.focus();
    const { recording } = this;
    if (!recording) return;
    const now = found.find((one) => one.id === recording.id);
    if (now && now.state !== recording.state) await this.choose(now.id);
    else if (!now) {
      this.recording = null;
      put(/** @type {HTMLElement} */ (this.report), h("p", { class: "warn", role: "alert" }, t("compose.gone")));
      this.checkStart();
    }
  }

  /** @param {Recording} recording */
  showReport(recording) {
    const report = /** @type {HTMLElement} */ (this.report);
    if (recording.state === "parsing") put(report, stateBadge("parsing"));
    else if (recording.state === "failed") put(report, failed(recording.error ?? { code: "unreadable" }));
    else {
      put(report, h("h3", { class: "break" }, recording.name),
        readCounts(recording), warningsList(recording),
        recording.rows.rejected ? h("details", { open: true }, h("summary", null, t("report.rejections")), rejectionsTable(recording)) : null,
        h("a", { href: routeTo(["recordings", recording.id]) }, t("compose.open_recording")));
    }
  }

  remember() {
    const { entries } = /** @type {AlgorithmEntries} */ (this.entries).read();
    const trials = this.mode === "scenario" ? this.trials?.read().request : null;
    rememberQuery({
      a: entries.map((entry) => JSON.stringify(entry)), label: this.label?.value.trim() || null, tag: readTags(this.tags?.value ?? ""),
      scenario: trials ? JSON.stringify(trials.scenario) : null, trials: trials ? String(trials.trials) : null, sweep: trials?.sweep ? JSON.stringify(trials.sweep) : null,
      seed: trials ? String(trials.seed || "") : this.seed ? String(this.seed) : null,
    });
    if (this.mode === "scenario") this.entries?.setSource(null, this.trials?.scenario?.kind ?? null);
    put(/** @type {HTMLElement} */ (this.message));
    this.checkStart();
  }

  checkStart() {
    if (!this.start || !this.entries) return;
    const { entries, wrong } = this.entries.read();
    this.trials?.setEntries(entries);
    const ready = this.mode === "scenario" ? this.trials?.read().wrong === false : this.recording?.state === "ready";
    this.start.disabled = this.busy === true || !ready || !entries.length || wrong;
    clearTimeout(this.asking);
    if (this.start.disabled) put(/** @type {HTMLElement} */ (this.estimate));
    else this.asking = setTimeout(() => this.ask(), 300);
  }

  /** What the run would take, or what is wrong with it; an answer to an earlier choice is not shown. */
  async ask() {
    const choice = () => ({ algorithms: this.entries?.read().entries ?? [], ...this.sourceOf() });
    const body = choice();
    /** @type {RunEstimate | null} */
    const found = await post("runs/estimate?check=true", body).catch((error) => {
      if (error instanceof Problem) return null;
      throw error;
    });
    if (this.start?.disabled !== false || JSON.stringify(choice()) !== JSON.stringify(body)) return;
    const { entries, rest } = placeErrors(found?.errors ?? []);
    const unplaced = this.entries?.tellErrors(entries) ?? [];
    const says = [...rest.map((error) => said(error.detail)), ...unplaced, ...(entries.size && !unplaced.length ? [t("compose.errors_above")] : [])];
    const words = says.length ? h("span", { class: "bad" }, says.join(" ")) : found ? estimateWords(found) : "";
    put(/** @type {HTMLElement} */ (this.estimate), words);
  }

  /** Where the measurements come from, as it is sent. */
  sourceOf() {
    if (this.mode === "scenario") return this.trials?.read().request;
    const seed = this.seed ? { seed: this.seed } : {};
    const together = [this.recording?.id, ...this.together];
    return together.length > 1 ? { recording_ids: together, ...seed } : { recording_id: this.recording?.id, ...seed };
  }

  /** The plan of what the run works on, for polygons in the forms. */
  async paths() {
    const scenario = this.mode === "scenario" ? this.trials?.read().request.scenario : null;
    const key = JSON.stringify(scenario ?? this.recording?.id ?? null);
    if (this.planOf?.key !== key) {
      const asked = scenario ? post("scenarios/preview", scenario).then((answer) => answer.charts.plan)
        : this.recording?.state === "ready" ? get(`recordings/${this.recording.id}/charts/plan.json`, { signal: this.stop?.signal }) : Promise.resolve(undefined);
      this.planOf = { key, paths: asked.then(pathsOf) };
    }
    return this.planOf.paths;
  }

  async submit() {
    const { entries } = /** @type {AlgorithmEntries} */ (this.entries).read();
    if (!this.recording && this.mode !== "scenario") return;
    this.busy = true;
    this.checkStart();
    try {
      /** @type {Run} */
      const run = await post("runs", {
        algorithms: entries, ...this.sourceOf(), label: this.label?.value.trim() ?? "", tags: readTags(this.tags?.value ?? ""),
      });
      document.dispatchEvent(new Event("filterroom:runs"));
      toast(t("toast.started"));
      go(routeTo(["runs", run.id]));
    } catch (error) {
      this.busy = false;
      this.showErrors(error);
    }
  }

  /** Errors that name a field stand under it, the rest beside the button. @param {unknown} error */
  showErrors(error) {
    const { entries, rest } = placeErrors(error instanceof Problem ? error.errors : []);
    this.entries?.setErrors(entries);
    this.checkStart();
    if (rest.length || !entries.size) put(/** @type {HTMLElement} */ (this.message), failed(error));
    else put(/** @type {HTMLElement} */ (this.message), h("p", { class: "bad", role: "alert" }, t("compose.errors_above")));
  }
}

/** @param {RunEstimate} found */
function estimateWords(found) {
  return [
    found.seconds === null ? t("compose.not_measured") : t("compose.takes_about", { time: formatDuration(found.seconds) }),
    found.memory_bytes === null ? "" : t("compose.memory", { size: formatBytes(found.memory_bytes) }),
    found.queue_position ? t("compose.waits_for", { n: found.queue_position }) : "",
  ].filter(Boolean).join(" · ");
}

/** Simulated trials that an address asks for. @param {URLSearchParams} query @returns {Partial<import("../types.d.ts").TrialsRequest>} */
function readTrials(query) {
  const parsed = (/** @type {string} */ name) => {
    try {
      return JSON.parse(query.get(name) ?? "null") ?? undefined;
    } catch {
      return undefined; // a cut-off address: start without it
    }
  };
  return { scenario: parsed("scenario"), sweep: parsed("sweep"), trials: Number(query.get("trials")) || undefined, seed: Number(query.get("seed")) || undefined };
}

/** @param {string} text @returns {RunEntry[]} */
function readEntry(text) {
  try {
    const entry = JSON.parse(text);
    return typeof entry?.name === "string" ? [entry] : [];
  } catch {
    return []; // a cut-off address: start without this entry
  }
}

define("new-page", NewPage);
