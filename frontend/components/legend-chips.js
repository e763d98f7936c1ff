// @ts-check
// The legend of all charts of a page: one chip for each entry, colour and dash; a click hides or shows it.

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { swatch } from "../js/palette.js";

export class LegendChips extends HTMLElement {
  /** @type {string[]} */
  labels = [];
  /** @type {Set<string>} */
  hiddenLabels = new Set();
  /** @type {(hidden: Set<string>) => void} */
  onchoose = () => {};

  connectedCallback() {
    this.className = "chips";
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", t("run.legend"));
    this.draw();
  }

  draw() {
    put(this, this.labels.map((label, index) => h("button", {
      type: "button", title: label, "aria-pressed": String(!this.hiddenLabels.has(label)), onclick: () => this.toggle(label),
    }, swatch(index), ...chipText(label))));
  }

  /** @param {string} label */
  toggle(label) {
    const hidden = new Set(this.hiddenLabels);
    if (!hidden.delete(label)) hidden.add(label);
    this.hiddenLabels = hidden;
    const at = this.labels.indexOf(label);
    this.draw();
    /** @type {HTMLElement | undefined} */ (this.children[at])?.focus();
    this.onchoose(hidden);
  }
}

/** Of `run / entry` only the run's name may be cut short. @param {string} label */
function chipText(label) {
  const at = label.lastIndexOf(" / ");
  return at < 0 ? [h("span", null, label)] : [h("span", null, label.slice(0, at)), h("span", { class: "whole" }, label.slice(at).trim())];
}

define("legend-chips", LegendChips);
