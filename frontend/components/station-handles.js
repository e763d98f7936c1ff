// @ts-check
// Stations on a plan that can be taken and moved: by the pointer, or by the arrow keys (with Shift ten times as far).

import { define, h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { formatNumber } from "../js/numbers.js";

/** @import { ChartPanel } from "./chart-panel.js" */

/** @typedef {{name: string, east_m: number, north_m: number}} Place */

const STEP_PX = 4;
const FAR = 10;

export class StationHandles extends HTMLElement {
  /** @type {ChartPanel | null} */
  panel = null;
  /** @type {Place[]} */
  places = [];
  /** Called with every move; `done` when the station is let go. @type {(index: number, east_m: number, north_m: number, done: boolean) => void} */
  onmoved = () => {};
  /** @type {HTMLElement[]} */
  handles = [];

  /** Lie over a chart whose axes are in kilometres. @param {ChartPanel} panel */
  follow(panel) {
    this.panel = panel;
    panel.addEventListener("drawn", () => {
      if (this.parentElement !== panel.body) panel.body?.append(this);
      if (!this.listening) {
        // Every later change of the view: panning, zooming, another size.
        panel.plot?.on?.("plotly_afterplot", () => this.place());
        panel.plot?.on?.("plotly_relayouting", () => this.place());
      }
      this.listening = true;
      this.place();
    });
  }

  /** @param {Place[]} places */
  setPlaces(places) {
    this.places = places;
    if (places.map((one) => one.name).join("\n") !== this.handles.map((one) => one.dataset.name).join("\n")) {
      this.handles = places.map((one, index) => this.handle(one.name, index));
      put(this, ...this.handles);
    }
    this.place();
  }

  get axes() {
    const layout = this.panel?.plot?._fullLayout;
    return layout?.xaxis && layout.yaxis ? layout : null;
  }

  place() {
    const { axes } = this;
    if (!axes) return;
    for (const [index, handle] of this.handles.entries()) {
      const { name, east_m, north_m } = /** @type {Place} */ (this.places[index]);
      const [left, top] = [axes.xaxis.d2p(east_m / 1000), axes.yaxis.d2p(north_m / 1000)];
      handle.hidden = !(left >= 0 && top >= 0 && left <= axes.xaxis._length && top <= axes.yaxis._length);
      handle.style.left = `${axes.xaxis._offset + left}px`;
      handle.style.top = `${axes.yaxis._offset + top}px`;
      handle.setAttribute("aria-label", t("map.handle", { name, east: formatNumber(east_m / 1000, 4), north: formatNumber(north_m / 1000, 4) }));
    }
  }

  /** @param {string} name @param {number} index */
  handle(name, index) {
    const handle = h("button", { type: "button", class: "handle", data: { name }, title: t("map.handle_hint") });
    handle.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
      const from = { x: event.clientX, y: event.clientY };
      const move = (/** @type {PointerEvent} */ next) => {
        this.by(index, next.clientX - from.x, next.clientY - from.y, false);
        [from.x, from.y] = [next.clientX, next.clientY];
      };
      const release = () => {
        handle.removeEventListener("pointermove", move);
        this.by(index, 0, 0, true);
      };
      handle.addEventListener("pointermove", move);
      handle.addEventListener("lostpointercapture", release, { once: true });
    });
    handle.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      const step = STEP_PX * (event.shiftKey ? FAR : 1);
      this.by(index, step * (way[0] ?? 0), step * (way[1] ?? 0), true);
    });
    return handle;
  }

  /** Move a station by so many pixels. @param {number} index @param {number} right @param {number} down @param {boolean} done */
  by(index, right, down, done) {
    const { axes } = this;
    const at = this.places[index];
    if (!axes || !at) return;
    const perPixel = (/** @type {any} */ axis) => (1000 * (axis.range[1] - axis.range[0])) / axis._length;
    at.east_m += right * perPixel(axes.xaxis);
    at.north_m -= down * perPixel(axes.yaxis);
    this.place();
    this.onmoved(index, at.east_m, at.north_m, done);
  }
}

define("station-handles", StationHandles);
