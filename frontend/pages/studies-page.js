// @ts-check
// The papers: what each study reproduces and how many claims it judges.

import { define, h, put } from "../js/dom.js";
import { get } from "../js/api.js";
import { said, t } from "../js/i18n.js";
import { routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { emptyState, failed, loading } from "../components/states.js";

/** @import { Study } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */

class StudiesPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };

  async connectedCallback() {
    setTitle(t("studies.title"));
    this.stop = new AbortController();
    put(this, loading());
    try {
      /** @type {{items: Study[]}} */
      const { items } = await get("studies", { signal: this.stop.signal });
      const papers = [...new Set(items.map((study) => study.paper.text ?? study.paper.key))];
      put(this, h("h1", null, t("studies.title")), h("p", { class: "muted" }, t("studies.what")),
        items.length ? papers.map((paper) => h("section", { class: "stack" },
          h("h2", null, paper),
          h("div", { class: "stack" }, items.filter((study) => (study.paper.text ?? study.paper.key) === paper).map((study) => h("a", { class: "card card-link", href: routeTo(["studies", study.name]) },
            h("strong", null, said(study.title)), " ", h("span", { class: "muted" }, said(study.item)),
            h("div", { class: "small muted" }, said(study.summary)),
            h("div", { class: "small" }, t("studies.claims_count", { n: study.claims.length }))))))) : emptyState(t("studies.none")));
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, h("h1", { class: "sr-only" }, t("studies.title")), failed(error, { retry: () => this.connectedCallback() }));
    }
  }

  disconnectedCallback() {
    this.stop?.abort();
  }
}

define("studies-page", StudiesPage);
