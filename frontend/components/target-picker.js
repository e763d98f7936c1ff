// @ts-check
// Which target everything on a page is about: all of them, or one alone, and the way back.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { get } from "../js/api.js";
import { formatCount } from "../js/numbers.js";
import { icon } from "../js/icons.js";
import { changeQuery } from "../js/router.js";
import { wordsOf } from "./states.js";
import { toast } from "./toast-area.js";

/** @import { Target } from "../types.d.ts" */

export class TargetPicker extends HTMLElement {
  /** @type {Target[]} */
  targets = [];
  /** The name of the target; empty = all. */
  chosen = "";
  /** @type {(name: string) => void} */
  onchoose = () => {};

  connectedCallback() {
    this.className = "target-picker";
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", t("metrics.target"));
    this.stop = new AbortController();
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.chosen && !isTaken(event)) this.onchoose("");
    }, { signal: this.stop.signal, capture: true });
    this.draw();
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /** Whether the page can follow what was asked for. */
  get known() {
    return !this.chosen || this.targets.some((target) => target.name === this.chosen);
  }

  /** @param {string} name */
  choose(name) {
    this.chosen = name;
    this.draw();
  }

  draw() {
    const focused = this.contains(document.activeElement);
    this.hidden = this.targets.length < 2 && !this.chosen;
    this.toggleAttribute("data-chosen", Boolean(this.chosen));
    const select = h("select", { "aria-label": t("metrics.target"), value: this.known ? this.chosen : "", onchange: () => this.onchoose(select.value) },
      h("option", { value: "" }, t("target.all", { n: formatCount(this.targets.length) })),
      this.targets.map((target) => h("option", { value: target.name }, target.marks === undefined ? target.name : t("target.option", { name: target.name, marks: formatCount(target.marks) }))));
    put(this, h("span", { class: "muted", "aria-hidden": "true" }, t("metrics.target")), select,
      this.known ? null : h("span", { role: "alert" }, t("target.unknown", { name: this.chosen })),
      this.chosen ? h("button", { type: "button", class: "plain", title: t("target.show_all_hint"), onclick: () => this.onchoose("") }, icon("close"), t("target.show_all")) : null,
      h("span", { class: "sr-only", role: "status" }, this.chosen && this.known ? t("target.only", { name: this.chosen }) : ""));
    if (focused) select.focus();
  }
}

/** Whether Escape means something nearer: a field, a menu, a locked cursor. @param {KeyboardEvent} event */
function isTaken(event) {
  const at = /** @type {Element | null} */ (event.target instanceof Element ? event.target : null);
  if (at?.closest("target-picker")) return false;
  return Boolean(at?.closest("input:not([type=checkbox], [type=radio], [type=range]), textarea, select")
    || document.querySelector("dialog[open], :popover-open, chart-panel[data-locked], chart-panel[data-measuring], .menu > div:not([hidden])") || document.fullscreenElement);
}

define("target-picker", TargetPicker);

/**
 * @param {Target[]} targets
 * @param {string} chosen
 * @param {(name: string) => void} onchoose
 */
export function targetPicker(targets, chosen, onchoose) {
  return Object.assign(/** @type {TargetPicker} */ (document.createElement("target-picker")), { targets, chosen, onchoose });
}

/**
 * Show the target of a mark alone.
 * @param {string} recording its id
 * @param {number | null} row the mark's row number
 * @param {AbortSignal | undefined} signal
 */
export async function showTargetOf(recording, row, signal) {
  if (row === null) return;
  try {
    /** @type {{items: Target[]}} */
    const { items } = await get(`recordings/${recording}/targets`, { query: { row }, signal });
    if (items[0]) changeQuery({ target: items[0].name });
  } catch (error) {
    if (!signal?.aborted) toast(wordsOf(error));
  }
}
