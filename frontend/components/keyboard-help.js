// @ts-check
// The list of keys, opened with `?`, and the keys that serve on every page.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { COMMANDS, commandOf } from "../js/keys.js";

// The second key of a pair must be pressed within this time; a page that is busy may hear of it later.
const PAIR_MS = 1500;

class KeyboardHelp extends HTMLElement {
  /** The key before, and when it was pressed. */
  last = { key: "", at: -PAIR_MS };

  connectedCallback() {
    this.className = "help";
    this.setAttribute("popover", "auto");
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", t("keys.title"));
    put(this, h("h2", null, t("keys.title")),
      h("dl", null, COMMANDS.map(({ keys, text }) => [
        h("dt", { class: "row tight" }, keys.map((key) => h("kbd", null, key))),
        h("dd", null, t(text)),
      ]).flat()));
    this.stop = new AbortController();
    document.addEventListener("keydown", (event) => this.onKey(event), { signal: this.stop.signal });
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** @param {KeyboardEvent} event */
  onKey(event) {
    const target = /** @type {HTMLElement} */ (event.target);
    const typing = target.matches?.("input:not([type=checkbox], [type=radio]), textarea, select");
    if (event.key === "Escape" && typing) target.blur();
    if (typing || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const key = latin(event);
    const { last } = this;
    this.last = { key, at: event.timeStamp };
    const command = commandOf(key, event.timeStamp - last.at < PAIR_MS ? last.key : undefined);
    if (!command?.act) return;
    command.act(key);
    event.preventDefault();
  }
}

/**
 * The key as a Latin keyboard has it: with a Russian layout switched on, the same keys serve.
 * @param {KeyboardEvent} event
 */
function latin({ key, code }) {
  if (/^\p{L}$/u.test(key) && !/^[a-z]$/i.test(key)) return code.replace(/^Key/, "").toLowerCase();
  if (code === "Slash" && (key === "." || key === ",")) return key === "," ? "?" : "/";
  return key;
}

define("keyboard-help", KeyboardHelp);
