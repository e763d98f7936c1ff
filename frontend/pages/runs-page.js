// @ts-check
// Home: the runs, newest first, narrowed down by the server, and the ways to a new one.

import { define, h, put } from "../js/dom.js";
import { get, listAll, remove } from "../js/api.js";
import { formatInstant, metricName, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatBytes, formatDuration, formatQuantity } from "../js/numbers.js";
import { icon } from "../js/icons.js";
import { rememberQuery, routeTo } from "../js/router.js";
import { againRoute, durationOf, sourceOf, titleOf } from "../js/runs.js";
import { keyMetric } from "../js/verdict.js";
import { setTitle } from "../components/app-frame.js";
import { confirmDeletion } from "../components/confirm-dialog.js";
import { dataTable } from "../components/data-table.js";
import { MOST_RUNS as MOST_COMPARED } from "../components/compare-tray.js";
import { composeWith } from "../components/drop-zone.js";
import { editButton, tagLinks } from "../components/run-name-form.js";
import { emptyState, failed, loading, stateBadge, wordsOf } from "../components/states.js";
import { toast } from "../components/toast-area.js";

/** @import { Algorithm, Page, Recording, Run } from "../types.d.ts" */
/** @import { Key } from "../js/i18n.js" */
/** @import { Route } from "../js/router.js" */
/** @import { CompareTray } from "../components/compare-tray.js" */

const STATES = ["queued", "running", "succeeded", "failed", "cancelled"];
const FILTERS = ["text", "state", "algorithm", "recording", "tag"];
const PAGE_RUNS = 50;
// The server gives at most so many at once.
const MOST_RUNS = 500;
const TYPING_MS = 200;

class RunsPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {Run[]} */
  runs = [];
  /** @type {string | null | undefined} */
  cursor = null;
  /** @type {(() => void) | null} */
  unwatch = null;
  /** Number of the last question to the server. */
  asked = 0;
  /** Answers to earlier questions come too late: a later one is shown, or the filters have changed. */
  answered = 0;
  /** @type {Record<string, HTMLInputElement | HTMLSelectElement>} */
  filters = {};
  /** Ids of the runs that are ticked, in the order of the ticks. @type {string[]} */
  picked = [];
  /** Every run seen so far: what is ticked may be filtered away. @type {Map<string, Run>} */
  known = new Map();
  /** The rows that are drawn. */
  drawn = "";
  /** A pointer is down in the list: rows that changed now would swallow its click. */
  pressed = false;

  connectedCallback() {
    setTitle(t("runs.title"));
    this.stop = new AbortController();
    const { signal } = this.stop;
    this.picked = this.route.query.getAll("pick").slice(0, MOST_COMPARED);
    this.tray = /** @type {CompareTray} */ (document.createElement("compare-tray"));
    this.tray.onremove = (id) => this.pick(id, false);
    this.tray.onclear = () => this.setPicked([]);
    this.body = h("div", { class: "card" }, loading());
    this.foot = h("div", { class: "row", style: "margin-top: 8px" });
    const picker = h("input", { type: "file", multiple: true, class: "sr-only", tabindex: -1, "aria-hidden": "true", onchange: () => composeWith([...(picker.files ?? [])]) });
    put(this,
      h("h1", { class: "sr-only" }, t("runs.title")),
      h("div", { class: "page-head", role: "search", "aria-label": t("runs.filter") }, this.filterFields(),
        h("div", { class: "actions" }, h("a", { class: "button primary", href: "#/new" }, t("runs.new")))),
      h("div", { class: "dropline" }, h("span", null, t("runs.drop")),
        h("button", { type: "button", class: "link", onclick: () => picker.click() }, t("runs.choose_files")), picker),
      this.body, this.foot, this.tray);
    this.body.addEventListener("pointerdown", () => { this.pressed = true; }, { signal });
    for (const end of ["pointerup", "pointercancel"]) {
      // The click comes after it.
      window.addEventListener(end, () => setTimeout(() => {
        if (this.pressed && this.isConnected) {
          this.pressed = false;
          this.show();
        }
      }), { signal });
    }
    const [look, lookAtChoices] = [throttled(() => this.load()), throttled(() => this.loadChoices())];
    this.unwatch = watch((news) => {
      if (news?.kind !== "recording.changed") look();
      if (news && news.kind !== "run.progress") lookAtChoices();
    });
    // The list first: it is what the reader waits for.
    this.load().then(() => this.loadChoices());
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  /** @param {URLSearchParams} query */
  queryChanged(query) {
    for (const name of FILTERS) setField(this.filters[name], query.get(name) ?? "");
    this.picked = query.getAll("pick").slice(0, MOST_COMPARED);
    this.filtered();
  }

  filterFields() {
    const { query } = this.route;
    const text = h("input", { type: "search", placeholder: t("runs.filter_hint"), "aria-label": t("runs.filter"), value: query.get("text") ?? "", oninput: () => {
      window.clearTimeout(this.typing);
      this.typing = window.setTimeout(() => this.choose(), TYPING_MS);
    } });
    const select = (/** @type {string} */ name, /** @type {Key} */ any, /** @type {(readonly [string, string])[]} */ options) => {
      const field = h("select", { "aria-label": t(`runs.${/** @type {"state"} */ (name)}`), onchange: () => this.choose() }, h("option", { value: "" }, t(any)), optionsOf(options));
      setField(field, query.get(name) ?? "");
      return field;
    };
    this.filters = {
      text,
      state: select("state", "runs.any_state", STATES.map((name) => [name, told(`state.${name}`, name)])),
      algorithm: select("algorithm", "runs.any_algorithm", []),
      recording: select("recording", "runs.any_recording", []),
      tag: select("tag", "runs.any_tag", []),
    };
    this.clear = h("button", { type: "button", class: "link", hidden: true, onclick: () => {
      for (const field of Object.values(this.filters)) field.value = "";
      this.choose();
      text.focus();
    } }, t("runs.clear_filters"));
    return [...Object.values(this.filters), this.clear];
  }

  /** What can be chosen in the filters; where that cannot be had, the chosen values stay. */
  async loadChoices() {
    const signal = this.stop?.signal;
    const [algorithms, recordings, tags] = await Promise.all([
      /** @type {Promise<{items: Algorithm[]}>} */ (get("algorithms", { signal })),
      /** @type {Promise<Recording[]>} */ (listAll("recordings", { signal })),
      /** @type {Promise<{items: {tag: string, runs: number}[]}>} */ (get("tags", { signal })),
    ]).catch(() => [null, null, null]);
    if (!algorithms || !recordings || !tags) return;
    fillSelect(this.filters.algorithm, algorithms.items.map((one) => [one.name, one.name]));
    fillSelect(this.filters.recording, recordings.map((one) => [one.id, one.name]));
    fillSelect(this.filters.tag, tags.items.map((one) => [one.tag, `${one.tag} (${one.runs})`]));
  }

  /** The filters as the API takes them. */
  chosen() {
    return Object.fromEntries(FILTERS.map((name) => [name, this.filters[name]?.value.trim() ?? ""]));
  }

  choose() {
    rememberQuery(this.chosen());
    this.filtered();
  }

  filtered() {
    this.runs = [];
    this.answered = this.asked + 1;
    this.load();
  }

  /** Ask for what is shown again: as many runs as there are, and what came since. */
  async load() {
    this.asked += 1;
    const { asked } = this;
    const chosen = this.chosen();
    if (this.clear) this.clear.hidden = !Object.values(chosen).some(Boolean);
    try {
      const limit = Math.min(MOST_RUNS, Math.max(PAGE_RUNS, this.runs.length));
      /** @type {Page<Run>} */
      const page = await get("runs", { query: { ...chosen, limit }, signal: this.stop?.signal });
      if (asked < this.answered) return;
      this.answered = asked;
      const last = page.items.at(-1);
      const older = page.next_cursor && last ? this.runs.filter((run) => run.created_at < last.created_at) : [];
      if (!older.length) this.cursor = page.next_cursor;
      this.runs = [...page.items, ...older];
      this.show();
    } catch (error) {
      if (this.stop?.signal.aborted || asked < this.answered) return;
      if (!this.runs.length) put(/** @type {HTMLElement} */ (this.body), failed(error, { retry: () => this.load() }));
    }
  }

  async loadOlder() {
    try {
      /** @type {Page<Run>} */
      const page = await get("runs", { query: { ...this.chosen(), limit: PAGE_RUNS, cursor: this.cursor }, signal: this.stop?.signal });
      this.cursor = page.next_cursor;
      this.runs = [...this.runs, ...page.items];
      this.show();
    } catch (error) {
      if (!this.stop?.signal.aborted) toast(wordsOf(error));
    }
  }

  show() {
    const body = /** @type {HTMLElement} */ (this.body);
    for (const run of this.runs) this.known.set(run.id, run);
    this.tray?.show(this.picked, this.known);
    // A row that is being edited or pressed is not taken away; saving or letting go draws it anew.
    if (this.pressed || body.querySelector("form")) return;
    const now = JSON.stringify([this.runs, this.cursor, this.chosen()]);
    if (now === this.drawn && this.table?.isConnected) return;
    this.drawn = now;
    const filtered = Object.values(this.chosen()).some(Boolean);
    if (!this.runs.length) {
      put(body, filtered ? emptyState(t("runs.none_match")) : emptyState(t("runs.none"), h("a", { class: "button", href: "#/new" }, t("runs.new"))));
    } else if (this.table?.isConnected) this.table.setRows(this.runs);
    else {
      this.table = dataTable({
        caption: t("runs.title"), rows: this.runs, fold: true, pageRows: Number.MAX_SAFE_INTEGER, link: (/** @type {Run} */ run) => routeTo(["runs", run.id]), columns: this.columns(), isCurrent: (run) => this.picked.includes(run.id),
      });
      put(body, this.table);
    }
    put(/** @type {HTMLElement} */ (this.foot), this.cursor ? h("button", { type: "button", onclick: () => this.loadOlder() }, t("runs.older")) : null);
  }

  /** @returns {import("../components/data-table.js").Column<Run>[]} */
  columns() {
    return [
      { title: t("runs.pick"), quiet: true, cell: (run) => this.pickBox(run) },
      { title: t("runs.column_state"), cell: (run) => stateCell(run), sort: (run) => run.state },
      { title: t("runs.column_run"), head: true, cell: (run) => this.nameCell(run), sort: titleOf },
      { title: t("runs.column_algorithms"), wide: true, cell: (run) => h("span", { class: "break" }, run.algorithms.map((entry) => entry.label ?? entry.name).join(", ")) },
      { title: t("runs.column_metric"), number: true, cell: (run) => metricCell(run), sort: (run) => keyMetric(run.summary)?.best.value ?? null },
      { title: t("runs.column_duration"), number: true, cell: (run) => formatDuration(durationOf(run)), sort: durationOf },
      { title: t("runs.column_size"), number: true, cell: (run) => formatBytes(run.size_bytes), sort: (run) => run.size_bytes ?? null },
      { title: t("runs.column_created"), cell: (run) => h("span", { class: "muted" }, formatInstant(run.created_at)), sort: (run) => run.created_at },
      { title: t("table.actions"), quiet: true, cell: (run) => this.actions(run) },
    ];
  }

  /** @param {Run} run */
  pickBox(run) {
    const done = run.state === "succeeded";
    const box = h("input", {
      type: "checkbox", checked: this.picked.includes(run.id), disabled: !done, "aria-label": t("runs.pick_run", { name: titleOf(run) }), title: done ? null : t("runs.pick_unfinished"), data: { pick: run.id },
      onchange: () => this.pick(run.id, box.checked),
    });
    return box;
  }

  /**
   * @param {string} id
   * @param {boolean} on
   */
  pick(id, on) {
    const others = this.picked.filter((one) => one !== id);
    if (on && others.length >= MOST_COMPARED) toast(t("runs.pick_most", { n: MOST_COMPARED }));
    this.setPicked(on && others.length < MOST_COMPARED ? [...others, id] : others);
  }

  /** The boxes follow what is ticked; the rows stay, and with them the focus. @param {string[]} picked */
  setPicked(picked) {
    this.picked = picked;
    rememberQuery({ pick: picked });
    for (const box of /** @type {NodeListOf<HTMLInputElement>} */ (this.querySelectorAll("[data-pick]"))) {
      box.checked = picked.includes(box.dataset.pick ?? "");
      box.closest("tr")?.classList.toggle("current", box.checked);
    }
    this.tray?.show(picked, this.known);
  }

  /** @param {Run} run */
  nameCell(run) {
    const source = run.label && run.source.name !== run.label ? sourceOf(run) : "";
    return h("div", { class: "run-name", data: { run: run.id } },
      h("a", { href: routeTo(["runs", run.id]), class: "break", data: { rowLink: "" } }, titleOf(run)),
      source || run.source.scenario ? h("span", { class: "small muted break" },
        [source, run.source.scenario ? t("trials.of", { n: run.trials ?? 1 }) : ""].filter(Boolean).join(" · ")) : null, tagLinks(run));
  }

  /** @param {Run} run */
  actions(run) {
    const name = titleOf(run);
    const active = run.state === "queued" || run.state === "running";
    return h("div", { class: "row-actions" },
      editButton(run, name, () => /** @type {HTMLElement} */ (this.querySelector(`[data-run="${run.id}"]`)), (changed) => {
        this.runs = this.runs.map((one) => (one.id === changed.id ? changed : one));
        this.show();
        this.loadChoices();
      }),
      h("a", { class: "button plain", href: againRoute(run), title: t("run.again"), "aria-label": `${t("run.again")}: ${name}` }, icon("again")),
      active ? null : h("button", { type: "button", class: "plain", title: t("action.delete"), "aria-label": `${t("action.delete")}: ${name}`, onclick: () => this.delete(run) }, icon("delete")));
  }

  /** @param {Run} run */
  async delete(run) {
    if (!(await confirmDeletion(t("runs.delete_question", { name: titleOf(run) }), t("runs.delete_detail")))) return;
    try {
      await remove(`runs/${run.id}`);
      this.runs = this.runs.filter((one) => one.id !== run.id);
      if (this.picked.includes(run.id)) this.pick(run.id, false);
      this.show();
      toast(t("toast.deleted"));
    } catch (error) {
      toast(wordsOf(error));
    }
  }
}

/** @param {(readonly [string, string])[]} options */
function optionsOf(options) {
  return options.map(([value, text]) => h("option", { value }, text));
}

/**
 * Set a filter; what a select does not offer (yet) is added, so that an address keeps its meaning.
 * @param {HTMLInputElement | HTMLSelectElement | undefined} field
 * @param {string} value
 */
function setField(field, value) {
  if (!field) return;
  if (field instanceof HTMLSelectElement && ![...field.options].some((option) => option.value === value)) field.append(h("option", { value }, value));
  field.value = value;
}

/**
 * @param {HTMLInputElement | HTMLSelectElement | undefined} field
 * @param {(readonly [string, string])[]} options
 */
function fillSelect(field, options) {
  if (!field) return;
  const { value } = field;
  const any = field.querySelector("option");
  put(field, any, optionsOf(options));
  setField(field, value);
}

/** @param {Run} run */
function stateCell(run) {
  const badge = stateBadge(run.state);
  if (run.state !== "running" || !run.progress.total) return badge;
  const share = Math.round((100 * run.progress.done) / run.progress.total);
  return h("span", { class: "nowrap" }, badge, h("span", { class: "muted small" }, ` ${share}\u202f%`));
}

/** @param {Run} run */
function metricCell(run) {
  const key = keyMetric(run.summary);
  if (!key) return run.error ? h("span", { class: "small muted" }, told(`problem.${run.error.code}`, run.error.code ?? "")) : "";
  return h("span", { class: "key-metric", title: metricName(key.metric) },
    h("b", { class: "nowrap" }, formatQuantity(key.best.value, key.metric.endsWith("_m") ? "m" : "")), " ",
    h("span", { class: "small muted" }, `${key.best.label}, ${told(`metric_short.${key.metric}`, key.metric)}`));
}

define("runs-page", RunsPage);
