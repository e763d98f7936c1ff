// @ts-check
// What runs here: versions, engine, limits, licences, and the way to the documentation of the interface for scripts.

import { define, h, put } from "../js/dom.js";
import { get } from "../js/api.js";
import { formatInstant, said, t, told } from "../js/i18n.js";
import { formatBytes, formatCount } from "../js/numbers.js";
import { setTitle } from "../components/app-frame.js";
import { failed, loading } from "../components/states.js";

/** @import { Meta } from "../types.d.ts" */
/** @import { Child } from "../js/dom.js" */

class AboutPage extends HTMLElement {
  async connectedCallback() {
    setTitle(t("nav.about"));
    this.stop = new AbortController();
    put(this, loading());
    try {
      this.draw(await get("meta", { signal: this.stop.signal }));
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, failed(error, { retry: () => this.connectedCallback() }));
    }
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** @param {Meta} meta */
  draw(meta) {
    const docs = new URL("docs", document.baseURI).href;
    const openapi = new URL("openapi.json", document.baseURI).href;
    const { engine, limits } = meta;
    put(this,
      h("h1", { class: "sr-only" }, t("nav.about")),
      h("div", { class: "stack narrow" },
        section(t("about.program"), h("div", { class: "stack" },
          h("p", null, t("about.what")),
          pairs([
            [t("about.version"), meta.version],
            [t("about.licence"), meta.licence],
            [t("about.started"), formatInstant(meta.started_at)],
            [t("about.api"), h("span", { class: "row" }, h("a", { href: docs }, t("about.docs")), h("a", { href: openapi }, "openapi.json"))],
          ]))),
        section(t("about.engine"), pairs([
          [t("runs.column_state"), told(`engine_state.${engine.state}`, engine.state)],
          [t("about.workers"), formatCount(engine.workers)],
          [t("state.running"), formatCount(engine.running)],
          [t("state.queued"), formatCount(engine.queued)],
          ...(engine.detail ? [/** @type {Pair} */ ([t("report.detail"), said(engine.detail)])] : []),
        ])),
        section(t("about.limits"), pairs([
          [t("about.max_upload"), formatBytes(limits.max_upload_bytes)],
          [t("about.max_rows"), formatCount(limits.max_rows)],
          [t("about.disk_free"), formatBytes(meta.disk_free_bytes)],
        ])),
        section(t("about.libraries"), pairs([
          ...Object.entries(meta.versions),
          ["plotly.js", meta.plotly_js],
        ]))));
  }
}

/** @typedef {[string, Child]} Pair */

/** @param {Pair[]} values */
function pairs(values) {
  return h("dl", { class: "pairs" }, values.flatMap(([name, value]) => [h("dt", null, name), h("dd", null, value)]));
}

/**
 * @param {string} title
 * @param {Node} body
 */
function section(title, body) {
  return h("section", { class: "card", "aria-label": title }, h("div", { class: "card-head" }, h("h2", null, title)), h("div", { class: "card-body" }, body));
}

define("about-page", AboutPage);
