// @ts-check
// A polygon on a small plan: the paths of the run behind it, corners that the pointer adds and moves. The table of
// corners beside it does the same by keyboard.

import { define, put, svg } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { formatExact } from "../js/numbers.js";
import { placeOf, viewOf } from "../js/regions.js";

/** @import { Path } from "../js/regions.js" */

const [WIDTH, HEIGHT] = [320, 240];
// A click this near to where the pointer went down is no drag.
const STILL_PX = 3;

export class RegionPlan extends HTMLElement {
  /** @type {Path[]} */
  paths = [];
  /** Corners of the region, metres. @type {number[][]} */
  corners = [];
  /** Polygons of the other regions. @type {number[][][]} */
  others = [];
  label = "";
  /** Called with the corners after a corner was added or moved. @type {(corners: number[][], done: boolean) => void} */
  onchanged = () => {};
  /** Kept while a corner is moved, else it would run away. @type {ReturnType<typeof viewOf> | null} */
  view = null;

  connectedCallback() {
    this.draw();
  }

  /** @param {number[][]} corners @param {number[][][]} others */
  setCorners(corners, others) {
    this.corners = corners;
    this.others = others;
    this.view = null;
    this.draw();
  }

  /** @param {Path[]} paths */
  setPaths(paths) {
    this.paths = paths;
    this.view = null;
    this.draw();
  }

  draw() {
    if (!this.isConnected) return;
    const polygons = [this.corners, ...this.others].map((corners) => ({ east: corners.map(([x]) => x ?? 0), north: corners.map(([, y]) => y ?? 0) }));
    this.view ??= viewOf([...this.paths, ...polygons], WIDTH, HEIGHT);
    const { metres, east, north } = this.view;
    const at = (/** @type {number} */ x, /** @type {number} */ y) => `${((x - east) / metres).toFixed(1)},${((north - y) / metres).toFixed(1)}`;
    const points = (/** @type {number[][]} */ corners) => corners.map(([x, y]) => at(x ?? 0, y ?? 0)).join(" ");
    // The length of the bar: 1, 2 or 5 of a power of ten, at most a third of the width.
    const most = (metres * WIDTH) / 3;
    const power = 10 ** Math.floor(Math.log10(most));
    const bar = ([5, 2, 1].find((one) => one * power <= most) ?? 1) * power;
    const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": this.label },
      ...this.paths.flatMap((path) => (path.line ? linesOf(path, at) : path.east.flatMap((x, i) => (Number.isFinite(x) ? [svg("circle", { class: "plot-dot", cx: (x - east) / metres, cy: (north - (path.north[i] ?? 0)) / metres, r: 1.5 })] : [])))),
      ...this.others.filter((corners) => corners.length > 1).map((corners) => svg("polygon", { class: "other", points: points(corners) })),
      this.corners.length > 1 ? svg("polygon", { class: "own", points: points(this.corners) }) : null,
      ...this.corners.map(([x = 0, y = 0], i) => svg("g", { class: "corner", data: { corner: i } },
        svg("circle", { cx: (x - east) / metres, cy: (north - y) / metres, r: 9, class: "grip" }),
        svg("circle", { cx: (x - east) / metres, cy: (north - y) / metres, r: 4 }),
        svg("text", { x: (x - east) / metres + 7, y: (north - y) / metres - 6 }, i + 1))),
      svg("path", { class: "bar", d: `M10 ${HEIGHT - 12}v4h${bar / metres}v-4` }),
      svg("text", { class: "scale", x: 10, y: HEIGHT - 16 }, bar >= 1000 ? t("regions.km", { n: formatExact(bar / 1000) }) : t("regions.m", { n: formatExact(bar) })),
      svg("text", { class: "scale", x: WIDTH - 12, y: 16, "text-anchor": "end" }, t("regions.north")));
    drawing.addEventListener("pointerdown", (event) => this.taken(/** @type {PointerEvent} */ (event), drawing));
    put(this, drawing);
  }

  /** Metres under the pointer. @param {PointerEvent} event @param {Element} drawing */
  under(event, drawing) {
    const box = drawing.getBoundingClientRect();
    const { metres, east, north } = /** @type {ReturnType<typeof viewOf>} */ (this.view);
    const round = (/** @type {number} */ value) => Number(value.toPrecision(4)) || 0;
    const [x, y] = [((event.clientX - box.left) * WIDTH) / box.width, ((event.clientY - box.top) * HEIGHT) / box.height];
    return [round(east + x * metres), round(north - y * metres)];
  }

  /** @param {PointerEvent} event @param {SVGElement} drawing */
  taken(event, drawing) {
    if (event.button !== 0) return;
    const grip = /** @type {Element} */ (event.target).closest("[data-corner]");
    const from = { x: event.clientX, y: event.clientY };
    const index = grip instanceof SVGElement ? Number(grip.dataset.corner) : -1;
    event.preventDefault();
    const stop = new AbortController();
    // The drawing is made anew with each move, so the window is listened to.
    window.addEventListener("pointermove", (next) => {
      if (index < 0) return;
      this.corners = this.corners.map((corner, i) => (i === index ? this.under(next, this.firstElementChild ?? drawing) : corner));
      this.draw();
      this.onchanged(this.corners, false);
    }, { signal: stop.signal });
    window.addEventListener("pointerup", (last) => {
      stop.abort();
      if (index < 0 && Math.hypot(last.clientX - from.x, last.clientY - from.y) <= STILL_PX) {
        const [x = 0, y = 0] = this.under(last, drawing);
        this.corners = this.corners.toSpliced(placeOf(this.corners, x, y), 0, [x, y]);
        this.draw();
      } else if (index < 0) return;
      this.onchanged(this.corners, true);
    }, { signal: stop.signal });
    window.addEventListener("pointercancel", () => stop.abort(), { signal: stop.signal });
  }
}

/** A path may have gaps. @param {Path} path @param {(x: number, y: number) => string} at @returns {SVGElement[]} */
function linesOf({ east, north }, at) {
  /** @type {string[][]} */
  const pieces = [[]];
  east.forEach((x, i) => {
    const y = north[i] ?? NaN;
    if (Number.isFinite(x) && Number.isFinite(y)) pieces[pieces.length - 1]?.push(at(x, y));
    else if (pieces[pieces.length - 1]?.length) pieces.push([]);
  });
  return pieces.filter((piece) => piece.length > 1).map((piece) => svg("polyline", { class: "true-path", points: piece.join(" ") }));
}

define("region-plan", RegionPlan);
