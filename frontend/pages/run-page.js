// @ts-check
// One run: how far it is, then what came of it: verdict, charts, tables.

import { define, h, put } from "../js/dom.js";
import { Problem, get, post, remove } from "../js/api.js";
import { formatInstant, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatDuration, formatNumber } from "../js/numbers.js";
import { CursorBus } from "../js/cursor.js";
import { go, rememberQuery, routeTo } from "../js/router.js";
import { againRoute, durationOf, requestOf, titleOf } from "../js/runs.js";
import { curlSnippet, pythonSnippet } from "../js/snippets.js";
import { setTitle } from "../components/app-frame.js";
import { chartPanel } from "../components/chart-panel.js";
import { planTools } from "../components/plan-tools.js";
import { timePlayer } from "../components/time-player.js";
import { confirmDeletion } from "../components/confirm-dialog.js";
import { decisionsTab, exportTab, logTab, metricsTab, parametersTab, receiversTab, tracksTab } from "../components/run-tabs.js";
import { editButton, tagLinks } from "../components/run-name-form.js";
import { runVerdict } from "../components/run-verdict.js";
import { emptyState, failed, loading, stateBadge, wordsOf } from "../components/states.js";
import { copyText, toast } from "../components/toast-area.js";
import "../components/legend-chips.js";
import "../components/tab-bar.js";

/** @import { ChartItem, Recording, Run } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { ChartPanel } from "../components/chart-panel.js" */
/** @import { LegendChips } from "../components/legend-chips.js" */
/** @import { TabBar } from "../components/tab-bar.js" */

// The plan stands at the left, these two beside it; whatever else a run has follows below.
const BESIDE = ["drms", "nis"];

class RunPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {Run | null} */
  run = null;
  /** @type {(() => void) | null} */
  unwatch = null;
  bus = new CursorBus();
  /** @type {ChartPanel[]} */
  panels = [];
  drawn = "";

  get runId() {
    return this.route.path[1] ?? "";
  }

  connectedCallback() {
    setTitle(t("run.title"));
    this.stop = new AbortController();
    this.head = h("div", { class: "run-head" });
    this.body = h("div", null, loading());
    put(this, this.head, this.body);
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  async load() {
    try {
      /** @type {Run} */
      const run = await get(`runs/${this.runId}`, { signal: this.stop?.signal });
      this.run = run;
      setTitle(titleOf(run), t("run.title"));
      const active = run.state === "queued" || run.state === "running";
      if (active) this.unwatch ??= watch(throttled(() => this.load()));
      else {
        this.unwatch?.();
        this.unwatch = null;
      }
      this.drawHead(run, active);
      if (this.drawn !== run.state) await this.drawBody(run);
      this.drawn = run.state;
    } catch (error) {
      // While the server is away the frame says so, and what was drawn stays.
      if (this.stop?.signal.aborted || (this.run && error instanceof Problem && error.status === 0)) return;
      if (!this.run) put(/** @type {HTMLElement} */ (this.head), h("h1", { class: "sr-only" }, t("run.title")));
      put(/** @type {HTMLElement} */ (this.body), failed(error, { retry: () => this.load() }));
    }
  }

  /**
   * @param {Run} run
   * @param {boolean} active
   */
  drawHead(run, active) {
    const base = new URL("./", document.baseURI).href;
    const share = run.progress.total ? run.progress.done / run.progress.total : 0;
    const recording = run.source.recording_id;
    const details = [
      run.seed === null ? "" : t("run.seed", { seed: run.seed }),
      durationOf(run) === null ? "" : formatDuration(durationOf(run)),
      formatInstant(run.created_at),
    ].filter(Boolean).join(" · ");
    // A name that is being edited is not taken away; saving draws it anew.
    if (this.head?.querySelector("form")) return;
    const name = h("div", { class: "run-name" }, h("h1", null, titleOf(run)), tagLinks(run));
    put(/** @type {HTMLElement} */ (this.head),
      name, editButton(run, titleOf(run), () => name, () => this.load()), stateBadge(run.state),
      h("span", { class: "muted small" }, details),
      recording && run.label ? h("a", { class: "small break", href: routeTo(["recordings", recording]) }, run.source.name ?? t("recordings.one")) : recording ? h("a", { class: "small", href: routeTo(["recordings", recording]) }, t("recordings.one")) : null,
      active ? h("span", { class: "row" },
        h("progress", { value: share, max: 1, "aria-label": t("run.progress") }),
        h("span", { class: "small muted", role: "status" }, progressText(run, share))) : null,
      h("div", { class: "actions" },
        active ? h("button", { type: "button", onclick: () => this.cancel() }, t("run.cancel")) : null,
        h("a", { class: "button", href: againRoute(run) }, t("run.again")),
        h("button", { type: "button", class: "plain", onclick: () => copyText(curlSnippet(base, requestOf(run))) }, t("run.copy_curl")),
        h("button", { type: "button", class: "plain", onclick: () => copyText(pythonSnippet(base, requestOf(run))) }, t("run.copy_python")),
        active ? null : h("button", { type: "button", class: "plain", onclick: () => this.delete(run) }, t("action.delete"))));
  }

  /** @param {Run} run */
  async drawBody(run) {
    const body = /** @type {HTMLElement} */ (this.body);
    if (run.state === "queued") put(body, h("div", { class: "card" }, emptyState(t("run.is_queued"))));
    else if (run.state === "running") put(body, h("div", { class: "card" }, emptyState(t("run.is_running"))));
    else if (run.state === "succeeded") await this.drawResult(run, body);
    else {
      const tabs = this.tabs([{ name: "log", title: t("tab.log"), draw: () => logTab(run) }, { name: "parameters", title: t("tab.parameters"), draw: () => parametersTab(run) }]);
      put(body, h("div", { class: "stack" },
        run.state === "failed" ? failed(run.error ?? { code: "internal" }) : h("p", { class: "notice" }, t("run.was_cancelled")), tabs));
    }
  }

  /**
   * @param {Run} run
   * @param {HTMLElement} body
   */
  async drawResult(run, body) {
    const signal = this.stop?.signal;
    const recording = run.source.recording_id;
    const [charts, tables, site] = await Promise.all([
      /** @type {Promise<{items: ChartItem[]}>} */ (get(`runs/${run.id}/charts`, { signal })),
      /** @type {Promise<{items: {name: string, rows?: number}[]}>} */ (get(`runs/${run.id}/tables`, { signal })),
      // Only the origin is wanted of the recording; one that was deleted takes nothing else away.
      recording ? get(`recordings/${recording}`, { signal }).then((/** @type {Recording} */ one) => one.site, () => null) : null,
    ]);
    const labels = run.algorithms.map((entry) => entry.label ?? entry.name);
    const hidden = new Set(this.route.query.getAll("hide"));
    const chips = /** @type {LegendChips} */ (document.createElement("legend-chips"));
    Object.assign(chips, { labels, hiddenLabels: hidden });
    chips.onchoose = (now) => {
      rememberQuery({ hide: [...now] });
      for (const panel of this.panels) panel.hideLabels(now);
    };
    const panel = (/** @type {ChartItem} */ chart, /** @type {string} */ place) => chartPanel({
      source: `runs/${run.id}/charts/${chart.name}`, heading: told(`chart.${chart.name}`, chart.title), bus: this.bus, hidden, class: place,
    });
    const byName = new Map(charts.items.map((chart) => [chart.name, chart]));
    const first = byName.get("plan") ?? charts.items[0];
    const beside = BESIDE.flatMap((name) => byName.get(name) ?? []).filter((chart) => chart !== first);
    const rest = charts.items.filter((chart) => chart !== first && !beside.includes(chart));
    this.panels = [
      ...(first ? [panel(first, "first")] : []),
      ...beside.map((chart) => panel(chart, "time")),
      ...rest.map((chart) => panel(chart, "rest")),
    ];
    const plan = this.panels.find((one) => first?.name === "plan" && one.className === "first");
    if (plan) plan.foot = [timePlayer(plan, this.bus), planTools(plan, site?.origin)];
    const tabs = this.resultTabs(run, charts.items, tables.items);
    put(body,
      h("div", { class: "run-legend" }, chips, h("span", { class: "small muted" }, t("run.legend_more"))),
      runVerdict(run.summary),
      h("div", { class: "run-charts" }, this.panels),
      tabs);
  }

  /**
   * @param {Run} run
   * @param {ChartItem[]} charts
   * @param {{name: string, rows?: number}[]} tables
   */
  resultTabs(run, charts, tables) {
    const has = (/** @type {string} */ name) => tables.some((table) => table.name === name);
    const count = (/** @type {string} */ name) => tables.find((table) => table.name === name)?.rows;
    const decisions = count("decisions");
    return this.tabs([
      { name: "metrics", title: t("tab.metrics"), draw: () => metricsTab(run) },
      ...(has("decisions") ? [{ name: "decisions", title: decisions === undefined ? t("tab.decisions") : t("tab.decisions_count", { n: decisions }), draw: () => decisionsTab(run, this.bus) }] : []),
      ...(has("tracks") ? [{ name: "tracks", title: t("tab.tracks"), draw: () => tracksTab(run) }] : []),
      ...(has("receivers") ? [{ name: "receivers", title: t("tab.receivers"), draw: () => receiversTab(run) }] : []),
      { name: "parameters", title: t("tab.parameters"), draw: () => parametersTab(run) },
      { name: "log", title: t("tab.log"), draw: () => logTab(run) },
      { name: "export", title: t("tab.export"), draw: () => exportTab(run, charts, tables.map((table) => table.name)) },
    ]);
  }

  /** @param {import("../components/tab-bar.js").Tab[]} tabs */
  tabs(tabs) {
    const bar = /** @type {TabBar} */ (document.createElement("tab-bar"));
    Object.assign(bar, { tabs, label: t("run.tables"), chosen: this.route.query.get("tab") ?? "" });
    bar.onchoose = (name) => rememberQuery({ tab: name });
    return bar;
  }

  async cancel() {
    try {
      await post(`runs/${this.runId}/cancel`);
    } catch (error) {
      toast(wordsOf(error));
    }
    await this.load();
  }

  /** @param {Run} run */
  async delete(run) {
    if (!(await confirmDeletion(t("runs.delete_question", { name: titleOf(run) }), t("runs.delete_detail")))) return;
    try {
      await remove(`runs/${run.id}`);
      toast(t("toast.deleted"));
      go("#/runs");
    } catch (error) {
      toast(wordsOf(error));
    }
  }
}

/**
 * @param {Run} run
 * @param {number} share
 */
function progressText(run, share) {
  const percent = `${Math.round(share * 100)}\u202f%`;
  return run.progress.eta_s ? t("run.progress_eta", { percent, eta: `${formatNumber(run.progress.eta_s, 2)} ${t("unit.s")}` }) : percent;
}

define("run-page", RunPage);
