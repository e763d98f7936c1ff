// @ts-check
// The recordings: what has been uploaded and how much of it could be read.

import { define, h, put } from "../js/dom.js";
import { listAll } from "../js/api.js";
import { formatInstant, t, told } from "../js/i18n.js";
import { throttled, watch } from "../js/live.js";
import { formatBytes, formatCount } from "../js/numbers.js";
import { rememberQuery, routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { dataTable } from "../components/data-table.js";
import { siteWords } from "../components/recording-report.js";
import { emptyState, failed, loading, stateBadge } from "../components/states.js";

/** @import { Recording } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */

class RecordingsPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {Recording[]} */
  recordings = [];
  /** @type {(() => void) | null} */
  unwatch = null;

  connectedCallback() {
    setTitle(t("recordings.title"));
    this.stop = new AbortController();
    const filter = h("input", {
      type: "search", placeholder: t("recordings.filter"), "aria-label": t("recordings.filter"), value: this.route.query.get("filter") ?? "",
      oninput: () => {
        rememberQuery({ filter: filter.value });
        this.show();
      },
    });
    this.filter = filter;
    this.body = h("div", { class: "card" }, loading());
    put(this,
      h("div", { class: "page-head" }, h("h1", { class: "sr-only" }, t("recordings.title")), filter,
        h("div", { class: "actions" }, h("a", { class: "button primary", href: "#/new?source=upload" }, t("recordings.upload")))),
      this.body);
    const look = throttled(() => this.load());
    this.unwatch = watch((news) => { if (!news || news.kind === "recording.changed") look(); });
    this.load();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.unwatch?.();
  }

  async load() {
    try {
      /** @type {Recording[]} */
      const found = await listAll("recordings", { signal: this.stop?.signal });
      if (this.table?.isConnected && JSON.stringify(found) === JSON.stringify(this.recordings)) return;
      this.recordings = found;
      this.show();
    } catch (error) {
      if (!this.stop?.signal.aborted && !this.recordings.length) put(/** @type {HTMLElement} */ (this.body), failed(error, { retry: () => this.load() }));
    }
  }

  show() {
    const words = (this.filter?.value ?? "").toLowerCase().split(/\s+/).filter(Boolean);
    const rows = this.recordings.filter((one) => words.every((word) => `${one.name} ${one.kind} ${one.format} ${one.state}`.toLowerCase().includes(word)));
    const body = /** @type {HTMLElement} */ (this.body);
    if (!this.recordings.length) put(body, emptyState(t("recordings.none"), h("a", { class: "button", href: "#/new?source=upload" }, t("recordings.upload"))));
    else if (!rows.length) put(body, emptyState(t("recordings.none_match")));
    else if (this.table?.isConnected) this.table.setRows(rows);
    else {
      this.table = dataTable({
        caption: t("recordings.title"), rows, fold: true, link: (/** @type {Recording} */ one) => routeTo(["recordings", one.id]), columns: [
          { title: t("runs.column_state"), cell: (one) => stateBadge(one.state), sort: (one) => one.state },
          { title: t("recordings.name"), head: true, cell: (one) => h("a", { href: routeTo(["recordings", one.id]), class: "break", data: { rowLink: "" } }, one.name), sort: (one) => one.name },
          { title: t("report.kind"), cell: (one) => told(`kind.${one.kind}`, one.kind ?? "–"), sort: (one) => one.kind },
          { title: t("report.accepted"), number: true, cell: (one) => formatCount(one.rows.accepted), sort: (one) => one.rows.accepted },
          { title: t("report.rejected"), number: true, cell: (one) => h("span", { class: one.rows.rejected ? "bad" : "muted" }, formatCount(one.rows.rejected)), sort: (one) => one.rows.rejected },
          { title: t("report.site"), cell: (one) => siteWords(one) },
          { title: t("report.truth"), named: true, cell: (one) => t(one.has_truth ? "form.yes" : "form.no"), sort: (one) => Number(one.has_truth) },
          { title: t("recordings.size"), number: true, cell: (one) => formatBytes(one.size_bytes), sort: (one) => one.size_bytes ?? null },
          { title: t("runs.column_created"), cell: (one) => h("span", { class: "muted nowrap" }, formatInstant(one.created_at)), sort: (one) => one.created_at ?? null },
        ],
      });
      put(body, this.table);
    }
  }
}

define("recordings-page", RecordingsPage);
