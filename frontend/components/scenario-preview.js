// @ts-check
// What a scenario looks like while it is edited: how many marks, and the charts of one noisy recording. One request is
// under way at a time; what was typed meanwhile is asked for when it is answered, and an answer to what is no longer
// wanted is not shown.

import { define, h, put } from "../js/dom.js";
import { Problem, post } from "../js/api.js";
import { t, told } from "../js/i18n.js";
import { formatCount, formatExact, formatNumber } from "../js/numbers.js";
import { CursorBus } from "../js/cursor.js";
import { chartPanel } from "./chart-panel.js";
import { rowsWords } from "./recording-report.js";
import { failed, loading } from "./states.js";

/** @import { ScenarioPreview as Answer } from "../types.d.ts" */
/** @import { ChartPanel } from "./chart-panel.js" */

// Long enough for a number to be typed, short enough to follow.
const WAIT_MS = 200;
const ORDER = ["plan", "measurements", "receptions"];

export class ScenarioPreview extends HTMLElement {
  /** What is wrong with the scenario, null when nothing is. @type {(problem: Problem | null) => void} */
  ontold = () => {};
  /** Of what is measured. */
  kind = "";
  /** @type {unknown} */
  wanted = null;
  busy = false;
  timer = 0;
  /** @type {Map<string, ChartPanel>} */
  panels = new Map();
  bus = new CursorBus();

  connectedCallback() {
    this.facts = h("div", { class: "card card-facts", role: "status" }, loading(1));
    this.charts = h("div", { class: "scenario-charts" });
    put(this, this.facts, this.charts);
    if (this.wanted) this.ask(this.wanted, true);
  }

  disconnectedCallback() {
    clearTimeout(this.timer);
    this.wanted = null;
  }

  /**
   * Look at a scenario, soon.
   * @param {unknown} request
   * @param {boolean} [now]
   */
  ask(request, now = false) {
    this.wanted = request;
    this.dataset.fresh = "no";
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.send(), now ? 0 : WAIT_MS);
  }

  /** Nothing can be looked at: the form holds what cannot be read. */
  pause() {
    this.wanted = null;
    clearTimeout(this.timer);
    this.charts?.classList.add("earlier");
  }

  async send() {
    if (this.busy || !this.wanted || !this.isConnected) return;
    const asked = this.wanted;
    this.busy = true;
    /** @type {Answer | null} */
    let answer = null;
    /** @type {unknown} */
    let problem = null;
    try {
      answer = await post("scenarios/preview", asked);
    } catch (error) {
      problem = error;
    }
    this.busy = false;
    if (!this.isConnected) return;
    if (asked === this.wanted) await this.show(answer, problem);
    else this.send();
  }

  /** @param {Answer | null} answer @param {unknown} problem */
  async show(answer, problem) {
    const { facts, charts } = this;
    if (!facts || !charts) return;
    charts.classList.toggle("earlier", !answer);
    if (answer) {
      this.ontold(null);
      put(facts, factsOf(answer, this.kind));
      await this.draw(answer);
      this.dataset.fresh = "yes";
      return;
    }
    if (problem instanceof Problem && problem.status === 422) {
      this.ontold(problem);
      put(facts, h("p", { class: "bad", role: "alert" }, t("scenarios.cannot_be")));
    } else put(facts, failed(problem, { retry: () => this.ask(this.wanted, true) }));
    this.dataset.fresh = "failed";
  }

  /** @param {Answer} answer */
  async draw(answer) {
    const names = Object.keys(answer.charts).sort((a, b) => (ORDER.indexOf(a) + 1 || 99) - (ORDER.indexOf(b) + 1 || 99));
    if (names.join() !== [...this.panels.keys()].join()) {
      this.panels = new Map(names.map((name) => [name, chartPanel({ source: "", heading: told(`chart.${name}`, name), bus: this.bus, class: name })]));
      put(/** @type {HTMLElement} */ (this.charts), ...this.panels.values());
    }
    await Promise.all(names.map((name) => this.panels.get(name)?.give(/** @type {any} */ (answer.charts[name]))));
  }
}

/** Milliseconds are enough. @param {number} time */
function seconds(time) {
  return formatExact(Math.round(time * 1000) / 1000);
}

/** @param {Answer} answer @param {string} kind of the measurements */
function factsOf(answer, kind) {
  const [first, last] = answer.time_span_s;
  const complete = answer.complete_share === null ? "" : t("scenarios.complete", { share: formatNumber(100 * answer.complete_share, 3) });
  const legs = answer.legs.map((leg) => `${leg.name} ${formatExact(leg.start_s)}–${formatExact(leg.stop_s)}`).join(", ");
  return h("div", { class: "row" },
    h("strong", null, rowsWords(kind, answer.rows)),
    h("span", null, t("scenarios.span", { from: seconds(first), to: seconds(last) })),
    answer.targets.length > 1 ? h("span", null, t("scenarios.targets", { n: answer.targets.length })) : null,
    complete ? h("span", null, complete) : null,
    answer.unheard ? h("span", { class: "warn" }, t("scenarios.unheard", { n: formatCount(answer.unheard) })) : null,
    legs ? h("span", { class: "muted small" }, t("scenarios.legs", { legs })) : null);
}

define("scenario-preview", ScenarioPreview);
