// @ts-check
// Colours and dash patterns of the entries of a run: the same in chips, forms and charts, on both themes.

import { svg } from "./dom.js";

// Safe for colour-blind people; the server draws the charts in this order too.
const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"];
const DASHES = ["solid", "dash", "dashdot", "longdash", "dot", "longdashdot"];
const STROKES = { solid: "", dash: "6 3", dot: "2 2", dashdot: "6 2 2 2", longdash: "9 3", longdashdot: "9 2 2 2" };

/**
 * Colour and dash pattern of the entry with this index.
 * @param {number} index
 */
export function entryStyle(index) {
  const lap = Math.floor(index / COLOURS.length);
  return {
    colour: /** @type {string} */ (COLOURS[index % COLOURS.length]),
    dash: /** @type {keyof typeof STROKES} */ (DASHES[(index + lap) % DASHES.length]),
  };
}

/**
 * A short piece of the entry's line.
 * @param {number} index
 * @param {{colour?: string, dash?: string}} [drawn] what the charts really use, where known
 */
export function swatch(index, drawn = {}) {
  const style = entryStyle(index);
  const dash = /** @type {Record<string, string>} */ (STROKES)[drawn.dash ?? style.dash] ?? "";
  return svg("svg", { viewBox: "0 0 26 10", width: 26, height: 10, class: "swatch", "aria-hidden": "true" },
    svg("line", {
      x1: 1, y1: 5, x2: 25, y2: 5, "stroke-width": 2.5, stroke: drawn.colour ?? style.colour, "stroke-dasharray": dash || null,
    }));
}
