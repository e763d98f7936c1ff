// @ts-check
// One recording: what was read, what was rejected and why, where the stations stand, what the data look like.

import { define, h, put } from "../js/dom.js";
import { Problem, apiUrl, get, remove } from "../js/api.js";
import { formatInstant, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatBytes } from "../js/numbers.js";
import { CursorBus } from "../js/cursor.js";
import { changeQuery, go, routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { chartPanel } from "../components/chart-panel.js";
import { planTools } from "../components/plan-tools.js";
import { confirmDeletion } from "../components/confirm-dialog.js";
import { readCounts, rejectionsTable, warningsList } from "../components/recording-report.js";
import { dopplerSiteForm } from "../components/doppler-site-form.js";
import { siteTable } from "../components/site-table.js";
import { failed, gone, loading, stateBadge, wordsOf } from "../components/states.js";
import { showTargetOf, targetPicker } from "../components/target-picker.js";
import { toast } from "../components/toast-area.js";
import "../components/recording-upload.js";

/** What a recording is given as; each reads back as the same rows. */
const FORMS = ["csv", "parquet", "mat", "npz"];

/** @import { ChartItem, Recording, Target } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { ChartPanel } from "../components/chart-panel.js" */
/** @import { TargetPicker } from "../components/target-picker.js" */
/** @import { RecordingUpload } from "../components/recording-upload.js" */

class RecordingPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {(() => void) | null} */
  unwatch = null;
  leaving = false;
  /** What is drawn. @type {Recording | null} */
  recording = null;
  /** @type {ChartPanel[]} */
  panels = [];
  /** @type {TargetPicker | null} */
  picker = null;

  get recordingId() {
    return this.route.path[1] ?? "";
  }

  connectedCallback() {
    setTitle(t("recordings.one"));
    this.stop = new AbortController();
    put(this, loading());
    const look = throttled(() => this.load());
    this.unwatch = watch((news) => { if (!this.leaving && (!news || news.id === this.recordingId)) look(); });
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  /** @param {URLSearchParams} query */
  queryChanged(query) {
    this.picker?.choose(query.get("target") ?? "");
    for (const panel of this.panels) panel.ask({ target: this.target });
  }

  /** The target that the charts are about; empty = all, also where the address names one that there is not. */
  get target() {
    return this.picker?.known ? this.picker.chosen : "";
  }

  async load() {
    try {
      /** @type {Recording} */
      const recording = await get(`recordings/${this.recordingId}`, { signal: this.stop?.signal });
      setTitle(recording.name, t("recordings.one"));
      // What stands there already stays, and with it what is being filled in.
      if (JSON.stringify(recording) !== JSON.stringify(this.recording)) this.draw(recording);
      this.recording = recording;
    } catch (error) {
      // While the server is away the frame says so, and what was drawn stays.
      if (this.stop?.signal.aborted || (this.recording && error instanceof Problem && error.status === 0)) return;
      const deleted = this.recording && error instanceof Problem && error.status === 404;
      put(this, h("h1", { class: "sr-only" }, t("recordings.one")),
        deleted ? gone(t("recordings.gone"), "#/recordings", t("nav.recordings")) : failed(error, { retry: () => this.load() }));
      if (deleted) this.unwatch?.();
      this.recording = null;
    }
  }

  /** @param {Recording} recording */
  draw(recording) {
    const ready = recording.state === "ready";
    const typable = ready && recording.kind === "doppler_pairs";
    const bus = new CursorBus();
    const charts = h("div", { class: "stack" });
    if (ready) this.drawCharts(recording, charts, bus);
    put(this,
      h("div", { class: "page-head" },
        h("h1", { class: "break" }, recording.name), stateBadge(recording.state),
        h("div", { class: "actions" },
          ready ? h("a", { class: "button primary", href: routeTo(["new"], { recording: recording.id }) }, t("recordings.new_run")) : null,
          ...(ready ? FORMS.map((form) => h("a", { class: "button", href: apiUrl(`recordings/${recording.id}/data.${form}`), download: "" }, `data.${form}`)) : []),
          // Paths of a truth file are not in the rows; whoever uploads the data elsewhere needs them too.
          ready && recording.files?.some((file) => file.role === "truth") ? h("a", { class: "button", href: apiUrl(`recordings/${recording.id}/truth.csv`), download: "" }, "truth.csv") : null,
          h("button", { type: "button", class: "danger", onclick: () => this.delete(recording) }, t("action.delete")))),
      h("div", { class: "stack" },
        recording.state === "failed" ? failed(recording.error ?? { code: "unreadable" }) : null,
        h("section", { class: "card", "aria-label": t("recordings.what_was_read") },
          h("div", { class: "card-head" }, h("h2", null, t("recordings.what_was_read"))),
          h("div", { class: "card-body stack" }, readCounts(recording), warningsList(recording))),
        ready ? charts : null,
        h("div", { class: "columns" },
          h("section", { class: "card" },
            h("div", { class: "card-head" }, h("h2", null, t("report.rejections"))),
            h("div", { class: "card-body" }, rejectionsTable(recording))),
          h("section", { class: "card", "aria-label": t("report.site") },
            h("div", { class: "card-head" }, h("h2", null, t("report.site"))),
            h("div", { class: "card-body stack" }, typable && !recording.site ? h("p", { class: "muted" }, t("doppler_site.none")) : siteTable(recording.site),
              typable ? dopplerSiteForm(recording, (made) => this.readAgain(recording, made)) : null))),
        h("div", { class: "columns" },
          h("section", { class: "card", "aria-label": t("recordings.again") },
            h("div", { class: "card-head" }, h("h2", null, t("recordings.again"))),
            h("div", { class: "card-body stack" }, h("p", { class: "muted" }, t("recordings.again_hint")), this.again(recording))),
          h("section", { class: "card", "aria-label": t("recordings.details") },
            h("div", { class: "card-head" }, h("h2", null, t("recordings.details"))),
            h("div", { class: "card-body" }, details(recording))))));
  }

  /**
   * @param {Recording} recording
   * @param {HTMLElement} box
   * @param {CursorBus} bus
   */
  async drawCharts(recording, box, bus) {
    try {
      const { signal } = /** @type {AbortController} */ (this.stop);
      const [{ items }, { items: targets }] = await Promise.all([
        /** @type {Promise<{items: ChartItem[]}>} */ (get(`recordings/${recording.id}/charts`, { signal })),
        /** @type {Promise<{items: Target[]}>} */ (get(`recordings/${recording.id}/targets`, { signal })),
      ]);
      items.sort((a, b) => Number(b.name === "plan") - Number(a.name === "plan"));
      this.picker = targetPicker(targets, this.route.query.get("target") ?? "", (name) => changeQuery({ target: name }));
      this.panels = items.map((chart) => {
        const panel = chartPanel({
          source: `recordings/${recording.id}/charts/${chart.name}`, query: { target: this.target }, heading: told(`chart.${chart.name}`, chart.title), bus,
          onpick: targets.length > 1 ? (mark) => showTargetOf(recording.id, mark.row, signal) : null,
        });
        if (chart.name === "plan") panel.foot = [planTools(panel, recording.site?.origin)];
        return panel;
      });
      put(box, this.picker, h("div", { class: "recording-charts" }, this.panels));
    } catch (error) {
      if (!this.stop?.signal.aborted) put(box, failed(error));
    }
  }

  /** @param {Recording} recording @param {Recording} made */
  readAgain(recording, made) {
    if (made.id === recording.id) toast(t("toast.same_recording"));
    else go(routeTo(["recordings", made.id]));
  }

  /** @param {Recording} recording */
  again(recording) {
    const upload = /** @type {RecordingUpload} */ (document.createElement("recording-upload"));
    upload.again = recording.id;
    upload.options = recording.options ?? {};
    upload.onuploaded = (made) => this.readAgain(recording, made);
    return upload;
  }

  /** @param {Recording} recording */
  async delete(recording) {
    if (!(await confirmDeletion(t("recordings.delete_question", { name: recording.name }), t("recordings.delete_detail")))) return;
    // The news of one's own deletion is no news.
    this.leaving = true;
    try {
      await remove(`recordings/${recording.id}`).catch(async (error) => {
        if (!(error instanceof Problem) || error.code !== "recording_in_use") throw error;
        if (await confirmDeletion(t("recordings.delete_runs_question"), wordsOf(error))) await remove(`recordings/${recording.id}`, { runs: "delete" });
        else this.leaving = false;
      });
    } catch (error) {
      this.leaving = false;
      toast(wordsOf(error));
    }
    if (!this.leaving) return;
    toast(t("toast.deleted"));
    go("#/recordings");
  }
}

/** @param {Recording} recording */
function details(recording) {
  const files = (recording.files ?? []).map((file) => `${told(`file_role.${file.role}`, file.role)}: ${file.name} (${formatBytes(file.size)})`);
  return h("dl", { class: "pairs" },
    h("dt", null, t("recordings.id")), h("dd", null, h("code", null, recording.id)),
    h("dt", null, "SHA-256"), h("dd", null, h("code", null, recording.sha256)),
    h("dt", null, t("runs.column_created")), h("dd", null, formatInstant(recording.created_at)),
    h("dt", null, t("recordings.start_utc")), h("dd", null, recording.start_utc ?? t("recordings.start_unknown")),
    files.length ? [h("dt", null, t("recordings.files")), h("dd", null, files.map((text) => h("div", null, text)))] : null,
    recording.options && Object.keys(recording.options).length ? [h("dt", null, t("recordings.options")), h("dd", null, h("code", null, JSON.stringify(recording.options)))] : null);
}

define("recording-page", RecordingPage);
