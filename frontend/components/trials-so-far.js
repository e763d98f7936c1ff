// @ts-check
// What a Monte Carlo run can say while its trials still run: how many there are, its charts and its metrics so far.

import { define, h, put } from "../js/dom.js";
import { get } from "../js/api.js";
import { t, told } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { chartPanel } from "./chart-panel.js";

/** @import { ChartItem, Run } from "../types.d.ts" */
/** @import { CursorBus } from "../js/cursor.js" */
/** @import { ChartPanel } from "./chart-panel.js" */

// The charts are drawn anew this often at most.
const LOOK_MS = 700;

export class TrialsSoFar extends HTMLElement {
  /** @type {CursorBus | null} */
  bus = null;
  /** Makes what stands below the charts; it follows `news` by itself. @type {(run: Run, news: EventTarget) => Node} */
  below = () => h("div");
  /** @type {ChartPanel[]} */
  panels = [];
  news = new EventTarget();
  looked = 0;

  connectedCallback() {
    this.stop = new AbortController();
    this.style.display = "block";
    this.count = h("p", { class: "notice", role: "status" }, t("trials.waiting"));
    this.charts = h("div", { class: "run-charts" });
    this.rest = h("div");
    put(this, this.count, this.charts, this.rest);
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  /**
   * Draw what is new, at most so often. One look ends before the next begins: where the server is slow, each figure
   * is drawn all the same. What was zoomed into, chosen or focused stays.
   * @param {Run} run
   */
  async look(run) {
    const { done, total } = run.progress;
    const cells = Math.max(1, Math.round(total / (run.trials ?? 1)));
    const words = t("trials.sofar", { done: formatCount(Math.floor(done / cells)), n: formatCount(run.trials ?? 1) });
    if (done && this.count && this.count.textContent !== words) put(this.count, words);
    const at = Date.now();
    if (!done || this.looking || at - this.looked < LOOK_MS) return;
    this.looking = true;
    this.looked = at;
    try {
      if (!this.panels.length) await this.begin(run);
      else {
        // What was not seen yet is fetched when it is.
        await Promise.all(this.panels.filter((panel) => panel.asked).map((panel) => panel.load()));
        this.news.dispatchEvent(new Event("more"));
      }
    } finally {
      this.looking = false;
    }
  }

  /** The first charts; as long as no trial is finished there are none, and the next news asks again. @param {Run} run */
  async begin(run) {
    const found = await get(`runs/${run.id}/charts`, { signal: this.stop?.signal }).catch(() => null);
    if (!found?.items.length || !this.charts || !this.rest) return;
    this.panels = found.items.map((/** @type {ChartItem} */ chart) => chartPanel({
      source: `runs/${run.id}/charts/${chart.name}`, query: {}, heading: told(`chart.${chart.name}`, chart.title), bus: this.bus, hidden: new Set(), class: "rest", onpick: null,
    }));
    put(this.charts, this.panels);
    put(this.rest, this.below(run, this.news));
  }
}

define("trials-so-far", TrialsSoFar);

/**
 * @param {{bus: CursorBus, below: (run: Run, news: EventTarget) => Node}} options
 * @returns {TrialsSoFar}
 */
export function trialsSoFar(options) {
  return Object.assign(/** @type {TrialsSoFar} */ (document.createElement("trials-so-far")), options);
}
