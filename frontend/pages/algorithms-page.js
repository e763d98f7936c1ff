// @ts-check
// The catalogue of algorithms.

import { define, h, put } from "../js/dom.js";
import { get } from "../js/api.js";
import { said, t, told } from "../js/i18n.js";
import { routeTo } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { failed, loading } from "../components/states.js";

/** @import { Algorithm } from "../types.d.ts" */

class AlgorithmsPage extends HTMLElement {
  async connectedCallback() {
    setTitle(t("algorithms.title"));
    this.stop = new AbortController();
    put(this, loading());
    try {
      /** @type {{items: Algorithm[]}} */
      const { items } = await get("algorithms", { signal: this.stop.signal });
      const families = [...new Set(items.map((one) => one.family))];
      put(this, h("h1", { class: "sr-only" }, t("algorithms.title")),
        families.map((family) => h("section", { class: "stack" },
          h("h2", null, told(`family.${family}`, family)),
          h("div", { class: "listing" }, items.filter((one) => one.family === family).map((one) =>
            h("a", { class: "card", href: routeTo(["algorithms", one.name]), data: { rowLink: "" } },
              h("span", { class: "row" }, h("strong", null, said(one.title)), h("code", { class: "muted" }, one.name), one.recommended ? h("span", { class: "tag" }, t("algorithms.recommended")) : null),
              h("span", null, said(one.summary)),
              h("span", { class: "small muted" }, one.takes.map((kind) => told(`kind.${kind}`, kind)).join(", "))))))));
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, failed(error, { retry: () => this.connectedCallback() }));
    }
  }

  disconnectedCallback() {
    this.stop?.abort();
  }
}

define("algorithms-page", AlgorithmsPage);
