// @ts-check
// Crowds of markers, painted on a canvas under Plotly's drawing. As elements of an SVG thousands of them take seconds to
// make and slow down every later repaint of the page; Plotly's own canvas compiles its WebGL commands from strings,
// which the page's policy forbids (no unsafe-eval).

import { h } from "./dom.js";

/** @import { PlotlyElement, Trace } from "../types.d.ts" */

/** @typedef {{symbol: string, size: number, colour: string, opacity: number, stroke: number}} Dot */

// More markers of one trace than this are a crowd.
export const CROWD = 250;
const BYTES = /** @type {Record<string, number>} */ ({ f4: 4, f8: 8, i1: 1, u1: 1, i2: 2, u2: 2, i4: 4, u4: 4 });
// Corners of the symbols on a circle around the marker, clockwise from above; as large as Plotly's. Two are a stroke.
const POLYGONS = /** @type {Record<string, {corners: number, turn: number, reach: number}>} */ ({
  "line-ew": { corners: 2, turn: 90, reach: 1.4 },
  square: { corners: 4, turn: 45, reach: Math.SQRT2 },
  diamond: { corners: 4, turn: 0, reach: 1.3 },
  "triangle-up": { corners: 3, turn: 0, reach: 1 },
  "triangle-down": { corners: 3, turn: 180, reach: 1 },
  pentagon: { corners: 5, turn: 0, reach: 1 },
});

/**
 * How many values an array of a figure has, decoded or not.
 * @param {any} values
 */
export function lengthOf(values) {
  if (typeof values?.bdata !== "string") return values?.length ?? 0;
  return Math.floor((values.bdata.replace(/=+$/, "").length * 3) / 4 / (BYTES[values.dtype] ?? 1));
}

/**
 * How a dressed trace's markers are painted as dots, or null where they stay with Plotly: a few, or unlike each other.
 * @param {Trace} trace
 * @returns {Dot | null}
 */
export function dotOf({ type, mode = "", marker, opacity: whole = 1, x, y }) {
  if (!(type === "scatter" && mode.includes("markers")) || mode.includes("text") || !marker) return null;
  if (typeof x?.bdata !== "string" || typeof y?.bdata !== "string" || lengthOf(x) <= CROWD) return null;
  const { symbol = "circle", size = 6, color, opacity = 1, line } = marker;
  if (typeof symbol !== "string" || typeof size !== "number" || typeof color !== "string" || typeof opacity !== "number") return null;
  const open = symbol.endsWith("-open");
  const shape = open ? symbol.slice(0, -5) : symbol;
  if (!(shape === "circle" || shape in POLYGONS) || (line?.width && !open)) return null;
  return { symbol: shape, size, colour: color, opacity: opacity * whole, stroke: open ? (line?.width ?? 1) : 0 };
}

/**
 * The trace without the markers that are painted as dots; the pointer still finds its points.
 * @param {Trace} trace
 * @returns {Trace}
 */
export function withDots(trace) {
  const dot = dotOf(trace);
  if (!dot) return trace;
  return { ...trace, mode: String(trace.mode).includes("lines") ? "lines" : "none", meta: { ...trace.meta, dot } };
}

/** The canvas of one chart. */
export class DotsCanvas {
  /** @param {PlotlyElement} plot */
  constructor(plot) {
    this.plot = plot;
    this.canvas = h("canvas", { class: "dots", "aria-hidden": "true" });
  }

  /** Paint what Plotly has drawn, again whenever it draws or moves the axes under the pointer. */
  follow() {
    this.paint();
    this.plot.on?.("plotly_afterplot", () => this.paint());
    this.plot.on?.("plotly_relayouting", () => this.paint());
  }

  /** Paint the crowds that are visible. */
  paint() {
    const { plot, canvas } = this;
    const layout = plot._fullLayout;
    const crowds = (plot._fullData ?? []).filter((trace) => trace.meta?.dot && trace.visible === true);
    canvas.hidden = !crowds.length;
    if (!layout || !crowds.length) return;
    const scale = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(layout.width * scale), Math.round(layout.height * scale)];
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    Object.assign(canvas.style, { width: `${layout.width}px`, height: `${layout.height}px` });
    const context = canvas.getContext("2d");
    if (!context) return;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    for (const trace of crowds) paintCrowd(context, trace, layout, scale);
  }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Trace} trace
 * @param {Record<string, any>} layout
 * @param {number} scale
 */
function paintCrowd(context, trace, layout, scale) {
  const x = layout[`xaxis${String(trace.xaxis ?? "x").slice(1)}`];
  const y = layout[`yaxis${String(trace.yaxis ?? "y").slice(1)}`];
  const dot = /** @type {Dot} */ (trace.meta?.dot);
  const sprite = spriteOf(dot, scale);
  const half = sprite.width / 2;
  const [left, top, right, bottom] = [x._offset * scale, y._offset * scale, (x._offset + x._length) * scale, (y._offset + y._length) * scale];
  const [across, down] = [pixelsOf(x), pixelsOf(y)];
  context.save();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
  context.globalAlpha = dot.opacity;
  for (let i = 0; i < trace.x.length; i += 1) {
    const [px, py] = [left + across(trace.x[i]) * scale, top + down(trace.y[i]) * scale];
    // Gaps, and zeros on a logarithmic axis, are no numbers here.
    // Whole pixels are copied; parts of them would be computed anew for every dot.
    if (px >= left - half && px <= right + half && py >= top - half && py <= bottom + half) context.drawImage(sprite, Math.round(px - half), Math.round(py - half));
  }
  context.restore();
}

/**
 * Where a value stands on an axis, in pixels from its left or top end; also while the axis is being dragged, when its
 * range has moved and its scale not yet.
 * @param {any} axis
 * @returns {(value: number) => number}
 */
export function pixelsOf(axis) {
  const ends = axis.range.map((/** @type {any} */ end) => axis.l2p(axis.r2l(end)));
  const [first, last] = axis._id.startsWith("y") ? [ends[1], ends[0]] : ends;
  const stretch = axis._length / (last - first);
  return (value) => (axis.d2p(value) - first) * stretch;
}

/**
 * One dot, to be stamped.
 * @param {Dot} dot
 * @param {number} scale
 */
function spriteOf({ symbol, size, colour, stroke }, scale) {
  const polygon = POLYGONS[symbol];
  const radius = (size / 2) * scale;
  const room = Math.ceil(radius * (polygon?.reach ?? 1) + stroke * scale) + 1;
  const sprite = h("canvas", { width: 2 * room, height: 2 * room });
  const context = /** @type {CanvasRenderingContext2D} */ (sprite.getContext("2d"));
  context.translate(room, room);
  context.beginPath();
  if (polygon) {
    for (let k = 0; k < polygon.corners; k += 1) {
      const angle = ((polygon.turn + (360 * k) / polygon.corners) * Math.PI) / 180;
      context.lineTo(radius * polygon.reach * Math.sin(angle), -radius * polygon.reach * Math.cos(angle));
    }
    context.closePath();
  } else context.arc(0, 0, radius, 0, 2 * Math.PI);
  if (stroke) Object.assign(context, { strokeStyle: colour, lineWidth: stroke * scale }).stroke();
  else Object.assign(context, { fillStyle: colour }).fill();
  return sprite;
}
