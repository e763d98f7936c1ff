// @ts-check
// One study: what the paper claims, the run that judges it, and what earlier runs of it found.

import { define, h, put, uniqueId } from "../js/dom.js";
import { get, post } from "../js/api.js";
import { formatInstant, said, t } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { go, routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { dataTable } from "../components/data-table.js";
import { emptyState, failed, loading, stateBadge, wordsOf } from "../components/states.js";
import { toast } from "../components/toast-area.js";
import { claimsTab } from "../components/trial-tabs.js";

/** @import { Run, Study } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */

class StudyPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };

  async connectedCallback() {
    setTitle(t("studies.one"));
    this.stop = new AbortController();
    put(this, loading());
    const name = this.route.path[1] ?? "";
    try {
      const [study, runs] = await Promise.all([
        /** @type {Promise<Study>} */ (get(`studies/${name}`, { signal: this.stop.signal })),
        /** @type {Promise<{items: Run[]}>} */ (get("runs", { query: { text: name, limit: 20 }, signal: this.stop.signal })),
      ]);
      this.draw(study, runs.items.filter((run) => run.source.study === name));
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, h("h1", { class: "sr-only" }, t("studies.one")), failed(error, { retry: () => this.connectedCallback() }));
    }
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** @param {Study} study @param {Run[]} runs */
  draw(study, runs) {
    setTitle(said(study.title), t("studies.one"));
    const trials = uniqueId("trials");
    const input = h("input", { id: trials, type: "text", inputmode: "numeric", value: String(study.trials), style: "width: 10ch", autocomplete: "off" });
    const message = h("div", { role: "status" });
    const start = h("button", { type: "button", class: "primary", onclick: async () => {
      start.disabled = true;
      try {
        /** @type {Run} */
        const run = await post("runs", { study: study.name, trials: Number(input.value.replace(/\s/g, "")) });
        document.dispatchEvent(new Event("filterroom:runs"));
        toast(t("toast.started"));
        go(routeTo(["runs", run.id]));
      } catch (error) {
        start.disabled = false;
        start.focus();
        put(message, failed(error));
        toast(wordsOf(error));
      }
    } }, t("studies.run"));
    this.className = "stack";
    const done = runs.find((run) => run.state === "succeeded");
    put(this,
      h("div", { class: "page-head" }, h("h1", null, said(study.title)),
        h("div", { class: "actions" }, h("label", { for: trials, class: "row small muted" }, t("trials.count")), input, start)),
      message,
      h("p", null, said(study.summary)),
      h("p", { class: "muted" }, (study.paper.text ?? study.paper.key).replace(/\.$/, ""), ", ", said(study.item)),
      h("div", { class: "card" }, h("div", { class: "card-head" }, h("h2", { class: "grow" }, t("tab.claims")),
        done ? h("a", { href: routeTo(["runs", done.id]) }, t("studies.from_run", { time: formatInstant(done.finished_at), n: formatCount(done.trials) })) : null),
      done ? claimsTab(done) : dataTable({
        caption: t("tab.claims"), rows: study.claims, columns: [
          { title: t("claims.figure"), cell: (row) => said(row.figure) },
          { title: t("claims.claim"), wide: true, cell: (row) => said(row.claim) },
          { title: t("claims.paper"), cell: (row) => said(row.paper) },
        ],
      })),
      h("section", { class: "card", "aria-label": t("studies.runs") }, h("div", { class: "card-head" }, h("h2", null, t("studies.runs"))),
        runs.length ? h("ul", { class: "plain-list", style: "padding: 8px 12px" }, runs.map((run) => h("li", { class: "row" }, stateBadge(run.state), h("a", { href: routeTo(["runs", run.id]) }, formatInstant(run.created_at)), h("span", { class: "muted" }, t("trials.of", { n: run.trials ?? 1 }))))) : emptyState(t("studies.no_runs"))));
  }
}

define("study-page", StudyPage);
