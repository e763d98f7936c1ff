// @ts-check
// What runs here: versions, engine, limits, licences, and the way to the documentation of the interface for scripts.

import { define, h, put } from "../js/dom.js";
import { get } from "../js/api.js";
import { t } from "../js/i18n.js";
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
    put(this,
      h("h1", { class: "sr-only" }, t("nav.about")),
      h("div", { class: "stack narrow" },
        h("section", { class: "card card-body stack" , style: "padding: 12px" },
          h("p", null, t("about.what")),
          h("p", { class: "row" }, h("a", { href: docs }, t("about.docs")), h("a", { href: openapi }, "openapi.json"))),
        Object.entries(meta).filter((pair) => pair[1] !== null && typeof pair[1] === "object").map(([name, value]) =>
          h("section", { class: "card", "aria-label": name }, h("div", { class: "card-head" }, h("h2", null, name.replaceAll("_", " "))), h("div", { class: "card-body" }, pairs(value)))),
        h("section", { class: "card card-body", style: "padding: 12px" },
          pairs(Object.fromEntries(Object.entries(meta).filter((pair) => typeof pair[1] !== "object"))))));
  }
}

/** @param {any} values @returns {HTMLElement} */
function pairs(values) {
  return h("dl", { class: "pairs" }, Object.entries(values).flatMap(([name, value]) => [
    h("dt", null, name.replaceAll("_", " ")),
    h("dd", null, ...plain(value)),
  ]));
}

/** @param {unknown} value @returns {Child[]} */
function plain(value) {
  if (Array.isArray(value)) return value.map((one) => h("div", null, ...plain(one)));
  if (value && typeof value === "object") return [pairs(value)];
  return [value === null || value === undefined || value === "" ? "–" : String(value)];
}

define("about-page", AboutPage);
