// @ts-check
// Home: the runs, newest first, and the ways to a new one.

import { define, h, put } from "../js/dom.js";
import { get, remove } from "../js/api.js";
import { formatInstant, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatDuration, formatQuantity } from "../js/numbers.js";
import { rememberQuery, routeTo } from "../js/router.js";
import { keyMetric } from "../js/verdict.js";
import { setTitle } from "../components/app-frame.js";
import { confirmDeletion } from "../components/confirm-dialog.js";
import { dataTable } from "../components/data-table.js";
import { composeWith } from "../components/drop-zone.js";
import { emptyState, failed, loading, stateBadge } from "../components/states.js";
import { toast } from "../components/toast-area.js";

/** @import { Page, Run } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */

const STATES = ["queued", "running", "succeeded", "failed", "cancelled"];

class RunsPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {Run[]} */
  runs = [];
  /** @type {string | null | undefined} */
  cursor = null;
  /** @type {(() => void) | null} */
  unwatch = null;

  connectedCallback() {
    setTitle(t("runs.title"));
    this.stop = new AbortController();
    const filter = h("input", {
      type: "search", placeholder: t("runs.filter"), "aria-label": t("runs.filter"), value: this.route.query.get("filter") ?? "",
      oninput: () => {
        rememberQuery({ filter: filter.value });
        this.show();
      },
    });
    const state = h("select", {
      "aria-label": t("runs.state"), value: this.route.query.get("state") ?? "",
      onchange: () => {
        rememberQuery({ state: state.value });
        this.load();
      },
    }, h("option", { value: "" }, t("runs.any_state")), STATES.map((name) => h("option", { value: name }, told(`state.${name}`, name))));
    this.filter = filter;
    this.stateFilter = state;
    this.body = h("div", { class: "card" }, loading());
    this.foot = h("div", { class: "row", style: "margin-top: 8px" });
    const picker = h("input", { type: "file", multiple: true, class: "sr-only", tabindex: -1, "aria-hidden": "true", onchange: () => composeWith([...(picker.files ?? [])]) });
    put(this,
      h("div", { class: "page-head" }, h("h1", { class: "sr-only" }, t("runs.title")), filter, state,
        h("div", { class: "actions" }, h("a", { class: "button primary", href: "#/new" }, t("runs.new")))),
      h("div", { class: "dropline" }, h("span", null, t("runs.drop")),
        h("button", { type: "button", class: "link", onclick: () => picker.click() }, t("runs.choose_files")), picker),
      this.body, this.foot);
    this.look = throttled(() => this.load());
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  async load() {
    try {
      /** @type {Page<Run>} */
      const page = await get("runs", { query: { limit: 50, state: this.stateFilter?.value }, signal: this.stop?.signal });
      const seen = new Set(page.items.map((run) => run.id));
      // What "older" had fetched stays, unless the filter changed what belongs here.
      const older = this.loadedFor === this.stateFilter?.value ? this.runs.filter((run) => !seen.has(run.id) && this.olderIds?.has(run.id)) : [];
      if (!older.length) this.cursor = page.next_cursor;
      this.loadedFor = this.stateFilter?.value;
      this.runs = [...page.items, ...older];
      this.show();
      this.followLive();
    } catch (error) {
      if (this.stop?.signal.aborted) return;
      if (!this.runs.length) put(/** @type {HTMLElement} */ (this.body), failed(error, { retry: () => this.load() }));
    }
  }

  async loadOlder() {
    /** @type {Page<Run>} */
    const page = await get("runs", { query: { limit: 50, cursor: this.cursor, state: this.stateFilter?.value }, signal: this.stop?.signal });
    this.cursor = page.next_cursor;
    this.olderIds = new Set([...(this.olderIds ?? []), ...page.items.map((run) => run.id)]);
    this.runs = [...this.runs, ...page.items];
    this.show();
  }

  /** Listen to news only while something is going on. */
  followLive() {
    const active = this.runs.some((run) => run.state === "queued" || run.state === "running");
    if (active && !this.unwatch) this.unwatch = watch(() => this.look?.());
    else if (!active && this.unwatch) {
      this.unwatch();
      this.unwatch = null;
    }
  }

  show() {
    const words = (this.filter?.value ?? "").toLowerCase().split(/\s+/).filter(Boolean);
    const rows = this.runs.filter((run) => {
      const text = [titleOf(run), run.source.name, run.state, ...run.tags, ...run.algorithms.flatMap((entry) => [entry.name, entry.label])].join(" ").toLowerCase();
      return words.every((word) => text.includes(word));
    });
    const body = /** @type {HTMLElement} */ (this.body);
    if (!this.runs.length) {
      put(body, emptyState(t(this.stateFilter?.value ? "runs.none_in_state" : "runs.none"), h("a", { class: "button", href: "#/new" }, t("runs.new"))));
    } else if (!rows.length) put(body, emptyState(t("runs.none_match")));
    else if (this.table?.isConnected) this.table.setRows(rows);
    else {
      this.table = dataTable({ caption: t("runs.title"), rows, fold: true, link: (/** @type {Run} */ run) => routeTo(["runs", run.id]), columns: this.columns() });
      put(body, this.table);
    }
    put(/** @type {HTMLElement} */ (this.foot),
      this.cursor ? h("button", { type: "button", onclick: () => this.loadOlder() }, t("runs.older")) : null,
      words.length && this.cursor ? h("span", { class: "muted small" }, t("runs.filter_loaded", { n: this.runs.length })) : null);
  }

  /** @returns {import("../components/data-table.js").Column<Run>[]} */
  columns() {
    return [
      { title: t("runs.column_state"), cell: (run) => stateCell(run), sort: (run) => run.state },
      { title: t("runs.column_run"), head: true, cell: (run) => h("a", { href: routeTo(["runs", run.id]), class: "break", data: { rowLink: "" } }, titleOf(run)), sort: titleOf },
      { title: t("runs.column_algorithms"), wide: true, cell: (run) => h("span", { class: "break" }, run.algorithms.map((entry) => entry.label ?? entry.name).join(", ")) },
      { title: t("runs.column_metric"), number: true, cell: (run) => metricCell(run), sort: (run) => keyMetric(run.summary)?.best.value ?? null },
      { title: t("runs.column_duration"), number: true, cell: (run) => formatDuration(durationOf(run)), sort: durationOf },
      { title: t("runs.column_created"), cell: (run) => h("span", { class: "nowrap muted" }, formatInstant(run.created_at)), sort: (run) => run.created_at },
      { title: t("table.actions"), quiet: true, cell: (run) => this.deleteButton(run) },
    ];
  }

  /** @param {Run} run */
  deleteButton(run) {
    if (run.state === "queued" || run.state === "running") return null;
    return h("button", { type: "button", class: "plain small", "aria-label": `${t("action.delete")}: ${titleOf(run)}`, onclick: async () => {
      if (!(await confirmDeletion(t("runs.delete_question", { name: titleOf(run) }), t("runs.delete_detail")))) return;
      try {
        await remove(`runs/${run.id}`);
        this.runs = this.runs.filter((one) => one.id !== run.id);
        this.show();
        toast(t("toast.deleted"));
      } catch (error) {
        toast(error instanceof Error ? error.message : String(error));
      }
    } }, t("action.delete"));
  }
}

/** The words for a run: its label, else what it reprocessed. @param {Run} run */
export function titleOf(run) {
  return run.label || run.source.name || t("run.untitled", { id: run.id.slice(0, 8) });
}

/** @param {Run} run @returns {number | null} */
export function durationOf(run) {
  if (!run.started_at || !run.finished_at) return null;
  return (Date.parse(run.finished_at) - Date.parse(run.started_at)) / 1000;
}

/** @param {Run} run */
function stateCell(run) {
  const badge = stateBadge(run.state);
  if (run.state !== "running" || !run.progress.total) return badge;
  const share = Math.round((100 * run.progress.done) / run.progress.total);
  return [badge, h("span", { class: "muted small" }, ` ${share}\u202f%`)];
}

/** @param {Run} run */
function metricCell(run) {
  const key = keyMetric(run.summary);
  if (!key) return run.error ? h("span", { class: "small muted" }, run.error.code ?? "") : "";
  return h("span", { title: told(`metric.${key.metric}`, key.metric) },
    h("b", null, formatQuantity(key.best.value, key.metric.endsWith("_m") ? "m" : "")), " ",
    h("span", { class: "small muted" }, `${key.best.label}, ${told(`metric_short.${key.metric}`, key.metric)}`));
}

define("runs-page", RunsPage);
