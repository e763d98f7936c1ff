// @ts-check
// One run: how far it is, then what came of it: verdict, charts, tables.

import { define, h, put } from "../js/dom.js";
import { Problem, get, post, remove } from "../js/api.js";
import { formatInstant, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatDuration, formatNumber } from "../js/numbers.js";
import { CursorBus } from "../js/cursor.js";
import { loadPlotly } from "../js/plotly.js";
import { changeQuery, go, parseRoute, rememberQuery, routeTo } from "../js/router.js";
import { loadTable } from "../js/tables.js";
import { allTargets, simulatedTargets, targetsOf } from "../js/run-targets.js";
import { againRoute, durationOf, placeOf, recordingsOf, requestOf, titleOf } from "../js/runs.js";
import { curlSnippet, pythonSnippet } from "../js/snippets.js";
import { setTitle } from "../components/app-frame.js";
import { chartPanel } from "../components/chart-panel.js";
import { planTools } from "../components/plan-tools.js";
import { timePlayer } from "../components/time-player.js";
import { confirmDeletion } from "../components/confirm-dialog.js";
import { decisionsTab, exportTab, logTab, metricsTab, parametersTab, receiversTab, tracksTab } from "../components/run-tabs.js";
import { editButton, tagLinks } from "../components/run-name-form.js";
import { registrationTab, runAlarms } from "../components/run-alarms.js";
import { runVerdict } from "../components/run-verdict.js";
import { joinsTab, requirementsTab } from "../components/tracking-tabs.js";
import { trialsSoFar } from "../components/trials-so-far.js";
import { trialsVerdict } from "../components/trials-verdict.js";
import { claimsTab, comparisonsTab, consistencyTab, trialMetricsTab } from "../components/trial-tabs.js";
import { emptyState, failed, gone, loading, stateBadge, wordsOf } from "../components/states.js";
import { showTargetOf, targetPicker } from "../components/target-picker.js";
import { copyText, toast } from "../components/toast-area.js";
import "../components/legend-chips.js";
import "../components/tab-bar.js";

/** @import { ChartItem, Recording, Run, Summary } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { ChartPanel } from "../components/chart-panel.js" */
/** @import { LegendChips } from "../components/legend-chips.js" */
/** @import { Mark } from "../components/chart-cursor.js" */
/** @import { TabBar } from "../components/tab-bar.js" */
/** @import { TargetPicker } from "../components/target-picker.js" */
/** @import { TrialsSoFar } from "../components/trials-so-far.js" */

// The plan, or the error over trials, stands at the left, these beside it; whatever else a run has follows below.
const FIRST = ["trials_sweep", "trials_error", "trials_probability", "trials_scans", "trials_decisions", "plan"];
const BESIDE = ["drms", "nis"];
const BESIDE_TRIALS = ["trials_error", "trials_consistency", "trials_nonlinearity", "trials_statistic", "trials_tradeoff"];

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
  leaving = false;
  /** @type {TargetPicker | null} */
  picker = null;
  /** Tells of each look at a run that waits. */
  news = new EventTarget();
  /** What stands there while trials run. @type {TrialsSoFar | null} */
  sofar = null;
  /** Draws what stands below the charts. @type {() => TabBar} */
  makeTabs = () => this.tabs([]);

  get runId() {
    return this.route.path[1] ?? "";
  }

  connectedCallback() {
    setTitle(t("run.title"));
    this.stop = new AbortController();
    this.head = h("div", { class: "run-head" });
    this.body = h("div", null, loading());
    put(this, this.head, this.body);
    // It takes longer than what the charts show; whoever draws one says why it is missing.
    loadPlotly().catch(() => undefined);
    const look = throttled(() => this.load());
    this.unwatch = watch((news) => { if (!this.leaving && (!news || news.id === this.runId)) look(); });
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  /** The target that everything is about; empty = all, also where the address names one that there is not. */
  get target() {
    return this.picker?.known ? this.picker.chosen : "";
  }

  /** @param {URLSearchParams} query */
  queryChanged(query) {
    const before = this.target;
    this.picker?.choose(query.get("target") ?? "");
    if (this.target !== before) this.follow();
  }

  async load() {
    try {
      /** @type {Run} */
      const run = await get(`runs/${this.runId}`, { signal: this.stop?.signal });
      setTitle(titleOf(run), t("run.title"));
      // What stands there already stays, and with it the focus.
      const same = JSON.stringify(run) === JSON.stringify(this.run);
      this.run = run;
      if (!same) this.drawHead(run, run.state === "queued" || run.state === "running");
      if (this.drawn === run.state) {
        if (run.state === "running") await this.sofar?.look(run);
        else this.news.dispatchEvent(new Event("more"));
        return;
      }
      this.drawn = run.state;
      await this.drawBody(run).catch((error) => {
        this.drawn = "";
        throw error;
      });
    } catch (error) {
      // While the server is away the frame says so, and what was drawn stays.
      if (this.stop?.signal.aborted || (this.run && error instanceof Problem && error.status === 0)) return;
      put(/** @type {HTMLElement} */ (this.head), h("h1", { class: "sr-only" }, t("run.title")));
      const deleted = this.run && error instanceof Problem && error.status === 404;
      put(/** @type {HTMLElement} */ (this.body), deleted ? gone(t("run.gone"), "#/runs", t("nav.runs")) : failed(error, { retry: () => this.load() }));
      if (deleted) this.unwatch?.();
      this.run = null;
      this.drawn = "";
    }
  }

  /**
   * @param {Run} run
   * @param {boolean} active
   */
  drawHead(run, active) {
    const base = new URL("./", document.baseURI).href;
    const share = run.progress.total ? run.progress.done / run.progress.total : 0;
    const recordings = recordingsOf(run);
    const details = [
      run.source.scenario ? t("trials.of", { n: run.trials ?? 1 }) : "",
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
      recordings.map((recording, i) => h("a", { class: "small break", href: routeTo(["recordings", recording]) },
        recordings.length > 1 ? t("recordings.numbered", { n: i + 1 }) : run.label ? run.source.name ?? t("recordings.one") : t("recordings.one"))),
      run.source.study ? h("a", { class: "small", href: routeTo(["studies", run.source.study]) }, t("studies.one")) : run.source.scenario ? h("a", { class: "small", href: scenarioRoute(run) }, t("trials.scenario")) : null,
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
    // Why it waits, where that is not for others' sake, stands in its log.
    if (run.state === "queued") put(body, h("div", { class: "stack" }, h("div", { class: "card" }, emptyState(t("run.is_queued"))), this.tabs([{ name: "log", title: t("tab.log"), draw: () => logTab(run, this.news) }])));
    else if (run.state === "running" && run.source.scenario) {
      this.sofar = trialsSoFar({ bus: this.bus, below: (now, news) => this.tabs([
        { name: "metrics", title: t("tab.metrics"), draw: () => trialMetricsTab(now, news) },
        { name: "log", title: t("tab.log"), draw: () => logTab(now, news) },
      ]) });
      put(body, this.sofar);
      await this.sofar.look(run);
    }
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
    const recordings = recordingsOf(run);
    const [charts, tables, site, targets] = await Promise.all([
      /** @type {Promise<{items: ChartItem[]}>} */ (get(`runs/${run.id}/charts`, { signal })),
      /** @type {Promise<{items: {name: string, rows?: number}[]}>} */ (get(`runs/${run.id}/tables`, { signal })),
      // Only the origin is wanted of the recording; one that was deleted takes nothing else away.
      recordings[0] ? get(`recordings/${recordings[0]}`, { signal }).then((/** @type {Recording} */ one) => one.site, () => null) : null,
      recordings.length ? Promise.all(recordings.map((one) => targetsOf(one, signal))).then(allTargets) : simulatedTargets(run),
    ]);
    const labels = run.algorithms.map((entry) => entry.label ?? entry.name);
    const hidden = new Set(this.route.query.getAll("hide"));
    const chips = /** @type {LegendChips} */ (document.createElement("legend-chips"));
    Object.assign(chips, { labels, hiddenLabels: hidden });
    chips.onchoose = (now) => {
      rememberQuery({ hide: [...now] });
      for (const panel of this.panels) panel.hideLabels(now);
    };
    const picker = targetPicker(targets, this.route.query.get("target") ?? "", (name) => changeQuery({ target: name }));
    this.picker = picker;
    const panel = (/** @type {ChartItem} */ chart, /** @type {string} */ place) => chartPanel({
      source: `runs/${run.id}/charts/${chart.name}`, query: { target: this.target }, heading: told(`chart.${chart.name}`, chart.title), bus: this.bus, hidden, class: place,
      onpick: recordings.length && targets.length > 1 ? (mark) => this.pick(mark) : null,
    });
    const byName = new Map(charts.items.map((chart) => [chart.name, chart]));
    const first = FIRST.flatMap((name) => byName.get(name) ?? [])[0] ?? charts.items[0];
    const beside = (run.source.scenario ? BESIDE_TRIALS : BESIDE).flatMap((name) => byName.get(name) ?? []).filter((chart) => chart !== first).slice(0, 2);
    const rest = charts.items.filter((chart) => chart !== first && !beside.includes(chart));
    this.panels = [
      ...(first ? [panel(first, "first")] : []),
      ...beside.map((chart) => panel(chart, "time")),
      ...rest.map((chart) => panel(chart, "rest")),
    ];
    const seen = this.sofar?.panels ?? [];
    this.sofar = null;
    // What was zoomed into while trials ran stays, and so does the focus.
    for (const one of this.panels) one.zoom = seen.find(({ source }) => source === one.source)?.zoom ?? one.zoom;
    const focused = seen.find((one) => one.contains(document.activeElement))?.source;
    const plan = this.panels.find((one) => first?.name === "plan" && one.className === "first");
    if (plan) plan.foot = [timePlayer(plan, this.bus), planTools(plan, site?.origin)];
    this.makeTabs = () => this.resultTabs(run, charts.items, tables.items, targets.length > 1);
    const example = run.source.scenario ? h("p", { class: "small muted" }, t("trials.example")) : null;
    this.verdict = h("div", null, run.source.scenario ? h("p", { class: "verdict" }, t("state.loading")) : runVerdict(this.target ? null : run.summary));
    this.below = h("div", null, this.makeTabs());
    put(body,
      h("div", { class: "run-legend" }, chips, picker, h("span", { class: "small muted" }, t("run.legend_more"))),
      this.verdict, runAlarms(run), example,
      h("div", { class: "run-charts" }, this.panels),
      this.below);
    const again = this.panels.find(({ source }) => source === focused);
    // Whoever has gone elsewhere meanwhile is not called back.
    again?.addEventListener("drawn", () => { if (document.activeElement === document.body) again.plot?.focus({ preventScroll: true }); }, { once: true });
    if (this.target || run.source.scenario) this.judge(run);
  }

  /** Everything on the page is about another target now. */
  follow() {
    const { run, below } = this;
    if (!run || !below) return;
    for (const panel of this.panels) panel.ask({ target: this.target });
    this.judge(run);
    const focused = below.contains(document.activeElement);
    put(below, this.makeTabs());
    // What had the focus is gone: its place takes over.
    if (focused) /** @type {HTMLElement | null} */ (below.querySelector("[role=tab][aria-selected=true]"))?.focus();
  }

  /** Say who was best, on this target or on all. @param {Run} run */
  async judge(run) {
    const { target, verdict } = this;
    if (!verdict) return;
    verdict.classList.toggle("stale", Boolean(target));
    if (run.source.scenario) {
      const words = await trialsVerdict(run, target).catch(() => runVerdict(null, target));
      if (this.target !== target) return;
      put(verdict, words);
      verdict.classList.remove("stale");
      return;
    }
    const summary = target ? await targetSummary(run, target).catch(() => null) : run.summary;
    // Meanwhile another target may have been chosen.
    if (this.target !== target) return;
    put(verdict, runVerdict(summary, target));
    verdict.classList.remove("stale");
  }

  /** Show the target of a mark alone. @param {Mark} mark */
  pick(mark) {
    const place = this.run && placeOf(this.run, mark.row);
    if (place) showTargetOf(place.recording, place.row, this.stop?.signal);
  }

  /**
   * @param {Run} run
   * @param {ChartItem[]} charts
   * @param {{name: string, rows?: number}[]} tables
   * @param {boolean} choosable whether there are targets to choose from
   */
  resultTabs(run, charts, tables, choosable) {
    const { target } = this;
    const has = (/** @type {string} */ name) => tables.some((table) => table.name === name);
    const count = (/** @type {string} */ name) => tables.find((table) => table.name === name)?.rows;
    // How many of them are of one target is seen when they are loaded.
    const decisions = target ? undefined : count("decisions");
    return this.tabs([
      ...(has("claims") ? [{ name: "claims", title: t("tab.claims"), draw: () => claimsTab(run) }] : []),
      { name: "metrics", title: t("tab.metrics"), draw: () => (run.source.scenario ? trialMetricsTab(run) : metricsTab(run, target)) },
      ...(has("comparisons") ? [{ name: "comparisons", title: t("tab.comparisons"), draw: () => comparisonsTab(run) }] : []),
      ...(has("consistency") ? [{ name: "consistency", title: t("tab.consistency"), draw: () => consistencyTab(run) }] : []),
      ...(has("decisions") ? [{ name: "decisions", title: decisions === undefined ? t("tab.decisions") : t("tab.decisions_count", { n: decisions }), draw: () => decisionsTab(run, target, this.bus) }] : []),
      ...(has("tracks") ? [{ name: "tracks", title: t("tab.tracks"), draw: () => tracksTab(run, target, choosable ? (name) => changeQuery({ target: name }) : null, (span) => this.panels.forEach((panel) => panel.lookAt(span))) }] : []),
      ...(has("receivers") ? [{ name: "receivers", title: t("tab.receivers"), draw: () => receiversTab(run, target) }] : []),
      ...(count("registration") ? [{ name: "registration", title: t("tab.registration"), draw: () => registrationTab(run) }] : []),
      ...(count("requirements") ? [{ name: "requirements", title: t("tab.requirements"), draw: () => requirementsTab(run, target) }] : []),
      ...(count("compared_tracks") ? [{ name: "joins", title: t("tab.joins"), draw: () => joinsTab(run) }] : []),
      { name: "parameters", title: t("tab.parameters"), draw: () => parametersTab(run) },
      { name: "log", title: t("tab.log"), draw: () => logTab(run) },
      { name: "export", title: t("tab.export"), draw: () => exportTab(run, charts, tables.map((table) => table.name), target) },
    ]);
  }

  /** @param {import("../components/tab-bar.js").Tab[]} tabs */
  tabs(tabs) {
    const bar = /** @type {TabBar} */ (document.createElement("tab-bar"));
    Object.assign(bar, { tabs, label: t("run.tables"), chosen: parseRoute(location.hash).query.get("tab") ?? "" });
    bar.onchoose = (name) => rememberQuery({ tab: name });
    return bar;
  }

  async cancel() {
    // With its trials goes what they say so far: a chart asked for meanwhile would be refused.
    if (this.sofar) put(/** @type {HTMLElement} */ (this.body), loading());
    this.sofar = null;
    try {
      await post(`runs/${this.runId}/cancel`);
    } catch (error) {
      toast(wordsOf(error));
      this.drawn = "";
    }
    await this.load();
  }

  /** @param {Run} run */
  async delete(run) {
    if (!(await confirmDeletion(t("runs.delete_question", { name: titleOf(run) }), t("runs.delete_detail")))) return;
    // The news of one's own deletion is no news.
    this.leaving = true;
    try {
      await remove(`runs/${run.id}`);
      toast(t("toast.deleted"));
      go("#/runs");
    } catch (error) {
      this.leaving = false;
      toast(wordsOf(error));
    }
  }
}

/** Where the scenario of a run is looked at and changed. @param {Run} run */
function scenarioRoute(run) {
  const { preset, parameters } = /** @type {{preset: string, parameters?: Record<string, unknown>}} */ (run.source.scenario);
  return routeTo(["scenarios"], { preset, parameters: parameters && Object.keys(parameters).length ? JSON.stringify(parameters) : null, seed: run.seed ? String(run.seed) : null });
}

/** The metrics of one target as the summary of a run. @param {Run} run @param {string} target */
async function targetSummary(run, target) {
  const { rows } = await loadTable(run.id, "metrics", target);
  /** @type {Summary} */
  const summary = {};
  for (const { metric, label, segment, value, ci95_low: low, ci95_high: high, unit } of rows) {
    if (segment) continue;
    (summary[String(metric)] ??= {})[String(label)] = {
      value: typeof value === "number" ? value : null, ci95: typeof low === "number" && typeof high === "number" ? [low, high] : null, unit: String(unit ?? ""),
    };
  }
  return summary;
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
