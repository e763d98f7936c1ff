// @ts-check
// One algorithm: what it does, what it takes, every parameter, what it gives, where it comes from.

import { define, h, put } from "../js/dom.js";
import { get } from "../js/api.js";
import { said, t, told } from "../js/i18n.js";
import { formatExact } from "../js/numbers.js";
import { routeTo } from "../js/router.js";
import { fieldsOf, rangeOf } from "../js/schema.js";
import { setTitle } from "../components/app-frame.js";
import { symbolOf } from "../components/parameter-form.js";
import { failed, loading } from "../components/states.js";

/** @import { Algorithm, Reference } from "../types.d.ts" */
/** @import { FieldSpec } from "../js/schema.js" */
/** @import { Route } from "../js/router.js" */

class AlgorithmPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };

  async connectedCallback() {
    this.stop = new AbortController();
    put(this, loading());
    try {
      /** @type {Algorithm} */
      const algorithm = await get(`algorithms/${encodeURIComponent(this.route.path[1] ?? "")}`, { signal: this.stop.signal });
      setTitle(said(algorithm.title), t("algorithms.one"));
      this.draw(algorithm);
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, h("h1", { class: "sr-only" }, t("algorithms.one")), failed(error, { retry: () => this.connectedCallback() }));
    }
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** @param {Algorithm} algorithm */
  draw(algorithm) {
    const section = (/** @type {string} */ title, /** @type {Node} */ body) => h("section", { class: "card" },
      h("div", { class: "card-head" }, h("h2", null, title)), h("div", { class: "card-body" }, body));
    put(this,
      h("div", { class: "page-head" }, h("h1", null, said(algorithm.title)), h("code", { class: "muted" }, algorithm.name), algorithm.recommended ? h("span", { class: "tag" }, t("algorithms.recommended")) : null,
        h("div", { class: "actions" }, h("a", { class: "button primary", href: routeTo(["new"], { a: JSON.stringify({ name: algorithm.name }) }) }, t("algorithms.use")))),
      h("div", { class: "stack narrow" },
        h("p", { style: "white-space: pre-line" }, said(algorithm.summary)),
        h("p", { class: "muted" }, t("algorithms.takes", { kinds: algorithm.takes.map((kind) => told(`kind.${kind}`, kind)).join(", ") })),
        section(t("algorithms.parameters"), parameterTable(fieldsOf(algorithm.parameters_schema))),
        section(t("algorithms.outputs"), outputTable(algorithm)),
        section(t("algorithms.references"), h("ul", { class: "stack tight" }, algorithm.references.map((one) => h("li", null, referenceText(one)))))));
  }
}

/** @param {FieldSpec[]} fields */
function parameterTable(fields) {
  return h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": t("algorithms.parameters") }, h("table", null,
    h("thead", null, h("tr", null, [t("algorithms.parameter"), t("algorithms.symbol"), t("algorithms.default"), t("algorithms.range"), t("algorithms.meaning")].map((one) => h("th", { scope: "col" }, one)))),
    h("tbody", null, fields.map((field) => h("tr", null,
      h("th", { scope: "row" }, field.title, h("br", null), h("code", { class: "muted" }, field.name)),
      h("td", null, field.symbol ? symbolOf(field.symbol) : ""),
      h("td", { class: "nowrap" }, defaultText(field)),
      h("td", null, field.choices.length ? field.choices.map((choice) => h("div", null, h("code", null, String(choice.value)), choice.meaning ? `: ${choice.meaning}` : "")) : `${rangeOf(field)}${rangeOf(field) && field.unit ? ` ${field.unit}` : ""}`),
      h("td", null, field.description))))));
}

/** @param {FieldSpec} field */
function defaultText(field) {
  const unit = field.unit ? ` ${field.unit}` : "";
  if (field.default !== null) return `${formatExact(field.default)}${unit}`;
  if (field.fromSite) return field.fallback === null ? t("algorithms.from_site") : t("algorithms.from_site_or", { value: `${formatExact(field.fallback)}${unit}` });
  return field.fallback === null ? "–" : `${formatExact(field.fallback)}${unit}`;
}

/** @param {Algorithm} algorithm */
function outputTable(algorithm) {
  return h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": t("algorithms.outputs") }, h("table", null,
    h("thead", null, h("tr", null, [t("algorithms.output"), t("algorithms.axes"), t("algorithms.unit"), t("algorithms.meaning")].map((one) => h("th", { scope: "col" }, one)))),
    h("tbody", null, algorithm.outputs.map((output) => h("tr", null,
      h("th", { scope: "row" }, h("code", null, output.name)), h("td", null, output.axes.map((one) => told(`axis.${one}`, one)).join(" × ")), h("td", { class: "nowrap" }, said(output.unit ?? "") || "–"), h("td", null, said(output.meaning ?? "")))))));
}

/** @param {Reference} reference */
function referenceText(reference) {
  const text = typeof reference.text === "string" ? reference.text : reference.key;
  return reference.place ? `${text} (${reference.place})` : text;
}

define("algorithm-page", AlgorithmPage);
