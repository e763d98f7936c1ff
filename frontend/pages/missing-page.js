// @ts-check
// An address that names no page.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { setTitle } from "../components/app-frame.js";
import { emptyState } from "../components/states.js";

class MissingPage extends HTMLElement {
  connectedCallback() {
    setTitle(t("missing.title"));
    put(this, h("h1", { class: "sr-only" }, t("missing.title")), h("div", { class: "card" }, emptyState(t("missing.text"), h("a", { class: "button", href: "#/runs" }, t("nav.runs")))));
  }
}

define("missing-page", MissingPage);
