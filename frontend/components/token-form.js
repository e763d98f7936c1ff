// @ts-check
// Asks for the access token when the server does not know this browser. The server swaps it for a cookie that
// scripts cannot read; the page itself never keeps the token.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";

class TokenForm extends HTMLElement {
  connectedCallback() {
    const refused = sessionStorage.getItem("filterroom.token-tried") === "yes";
    const field = h("input", {
      id: "token", type: "password", autocomplete: "off", required: true, "aria-describedby": "token-hint",
      "aria-invalid": refused ? "true" : null,
    });
    put(this, h("form", { class: "card token stack", onsubmit: (/** @type {Event} */ event) => submit(event, field.value.trim()) },
      h("h1", null, t("token.title")),
      h("p", { id: "token-hint", class: "muted" }, t("token.hint")),
      refused ? h("p", { class: "bad", role: "alert" }, t("token.refused")) : null,
      h("div", { class: "field" }, h("label", { for: "token" }, t("token.label")), field),
      h("div", { class: "row" }, h("button", { class: "primary" }, t("token.enter")))));
    field.focus();
  }
}

/**
 * @param {Event} event
 * @param {string} token
 */
function submit(event, token) {
  event.preventDefault();
  if (!token) return;
  sessionStorage.setItem("filterroom.token-tried", "yes");
  const url = new URL(document.baseURI);
  url.search = new URLSearchParams({ token }).toString();
  url.hash = location.hash;
  location.assign(url.href);
}

define("token-form", TokenForm);
