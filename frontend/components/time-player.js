// @ts-check
// The time slider under a plan: it moves the instant that all charts share, by hand, step by step or by itself.

import { define, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { t } from "../js/i18n.js";
import { formatNumber } from "../js/numbers.js";

/** @import { CursorBus } from "../js/cursor.js" */
/** @import { ChartPanel } from "./chart-panel.js" */

const SPEEDS = [1, 10, 100];
const FRAME_MS = 50;
const STEPS = 1000;

export class TimePlayer extends HTMLElement {
  /** @type {ChartPanel | null} */
  panel = null;
  /** @type {CursorBus | null} */
  bus = null;
  speed = 10;
  /** @type {number | undefined} */
  timer;
  /** What the player itself set last; anything else is a person's choice. */
  at = NaN;

  connectedCallback() {
    this.className = "time-player small";
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", t("player.label"));
    this.stop = new AbortController();
    const { signal } = this.stop;
    // Nothing moves by itself for those who asked for calm: they step.
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.button = h("button", { type: "button", class: "plain", "aria-label": t("player.play"), title: t("player.play"), onclick: () => (this.timer ? this.pause() : this.play()) }, icon("play"));
    const step = (/** @type {number} */ by, /** @type {string} */ shape, /** @type {string} */ words) =>
      h("button", { type: "button", class: "plain", "aria-label": words, title: words, onclick: () => this.step(by) }, icon(shape));
    this.slider = h("input", { type: "range", min: 0, max: 1, step: "any", "aria-label": t("chart.time"), oninput: () => this.show(Number(this.slider?.value)) });
    this.time = h("output", { class: "nowrap" });
    const speed = h("select", { "aria-label": t("player.speed"), value: String(this.speed), onchange: () => { this.speed = Number(speed.value); } }, SPEEDS.map((one) => h("option", { value: one }, `×${one}`)));
    put(this, calm ? null : this.button, step(-1, "back", t("player.back")), step(1, "forward", t("player.forward")), this.slider, this.time, calm ? null : speed);
    this.bus?.addEventListener("change", () => this.follow(), { signal });
    this.panel?.addEventListener("drawn", () => this.fit(), { signal });
    this.fit();
  }

  disconnectedCallback() {
    this.stop?.abort();
    this.pause();
  }

  /** Take over the chart's first and last instant. */
  fit() {
    const span = this.panel?.cursor?.moments?.span;
    this.hidden = !span || span[0] === span[1];
    if (!span || !this.slider) return;
    const [first, last] = span;
    const step = 10 ** Math.floor(Math.log10((last - first) / STEPS));
    // Round ends, so that the slider stands at round instants.
    Object.assign(this.slider, { min: String(Math.floor(first / step) * step), max: String(Math.ceil(last / step) * step), step: String(step) });
    this.follow();
  }

  /** @param {number} time */
  show(time) {
    this.at = time;
    if (this.panel?.cursor) this.panel.cursor.trailing = true;
    this.bus?.look(time, { lock: true });
  }

  /** @param {number} by */
  step(by) {
    this.pause();
    const now = this.bus?.now;
    const cursor = this.panel?.cursor;
    const mark = now && cursor?.moments?.step(now.time, now.row, by);
    if (!mark || !cursor) return;
    cursor.trailing = true;
    cursor.lock(mark);
  }

  play() {
    const span = this.panel?.cursor?.moments?.span;
    if (!span) return;
    const now = this.bus?.now.time ?? span[0];
    let last = performance.now();
    this.show(now >= span[1] ? span[0] : now);
    this.timer = window.setInterval(() => {
      const then = performance.now();
      const time = Math.min(span[1], this.at + (this.speed * (then - last)) / 1000);
      last = then;
      this.show(time);
      if (time >= span[1]) this.pause();
    }, FRAME_MS);
    this.mark(true);
  }

  pause() {
    clearInterval(this.timer);
    this.timer = undefined;
    this.mark(false);
  }

  /** @param {boolean} playing */
  mark(playing) {
    const words = t(playing ? "player.pause" : "player.play");
    if (!this.button) return;
    this.button.setAttribute("aria-label", words);
    this.button.title = words;
    put(this.button, icon(playing ? "pause" : "play"));
  }

  /** The instant has moved: by the player, or by a person, who then holds it. */
  follow() {
    const time = this.bus?.now.time ?? null;
    if (this.timer && time !== this.at) this.pause();
    if (!this.slider || !this.time) return;
    const words = time === null ? "–" : `${formatNumber(time, 5)} ${t("unit.s")}`;
    put(this.time, words);
    this.slider.setAttribute("aria-valuetext", words);
    this.slider.value = time === null ? this.slider.min : String(time);
  }
}

define("time-player", TimePlayer);

/**
 * @param {ChartPanel} panel the plan
 * @param {CursorBus} bus
 */
export function timePlayer(panel, bus) {
  return Object.assign(/** @type {TimePlayer} */ (document.createElement("time-player")), { panel, bus });
}
