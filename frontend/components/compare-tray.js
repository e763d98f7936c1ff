// @ts-check
// The runs that were ticked in the list, in the order of the ticks, with the colours they will have.

import { define, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { t } from "../js/i18n.js";
import { swatch } from "../js/palette.js";
import { routeTo } from "../js/router.js";
import { titleOf } from "../js/runs.js";

/** @import { Run } from "../types.d.ts" */

export const FEWEST_RUNS = 2;
export const MOST_RUNS = 10;

export class CompareTray extends HTMLElement {
  /** @type {(id: string) => void} */
  onremove = () => {};
  onclear = () => {};

  connectedCallback() {
    this.className = "tray";
    this.hidden = true;
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("tray.title"));
  }

  /**
   * @param {string[]} ids
   * @param {Map<string, Run>} known
   */
  show(ids, known) {
    this.hidden = ids.length < FEWEST_RUNS;
    let index = 0;
    put(this,
      h("ul", { class: "row grow" }, ids.map((id) => {
        const run = known.get(id);
        const name = run ? titleOf(run) : id.slice(0, 6);
        // Where one run is not known, the colours of those after it are not either.
        const swatches = run && Number.isFinite(index) ? run.algorithms.map((_, i) => swatch(index + i)) : [];
        index = run ? index + run.algorithms.length : NaN;
        return h("li", { class: "row tight" }, swatches, h("span", { class: "clip" }, name),
          h("button", { type: "button", class: "plain", "aria-label": t("tray.drop", { name }), onclick: () => this.onremove(id) }, icon("close")));
      })),
      h("span", { class: "small muted", role: "status" }, t("tray.chosen", { n: ids.length })),
      h("button", { type: "button", onclick: () => this.onclear() }, t("tray.clear")),
      h("a", { class: "button primary", href: routeTo(["compare"], { run: ids }), data: { compare: "" } }, t("tray.compare")));
  }
}

define("compare-tray", CompareTray);
