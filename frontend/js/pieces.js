// @ts-check
// The unbroken pieces of a line: each is a track, or the path of a target.

import { t } from "./i18n.js";

/** @import { Trace } from "../types.d.ts" */

/**
 * The piece of a line on which a point lies: which one it is, and where it begins and ends among the line's points.
 * @param {Trace} trace with decoded arrays
 * @param {number} at index of the point
 * @returns {{number: number, from: number, to: number} | null} null where nothing names the pieces
 */
export function pieceAt(trace, at) {
  if (!trace.meta?.pieces || !isThere(trace, at)) return null;
  let number = 0;
  let from = 0;
  for (let i = 1; i <= at; i += 1) {
    if (!isThere(trace, i) || isThere(trace, i - 1)) continue;
    // A line that begins with a gap has its first piece behind it.
    if (from > 0 || isThere(trace, 0)) number += 1;
    from = i;
  }
  let to = at + 1;
  while (to < trace.x.length && isThere(trace, to)) to += 1;
  return { number, from, to };
}

/**
 * What a piece is called: its target, or its track.
 * @param {Trace} trace
 * @param {number} number
 */
export function pieceName(trace, number) {
  const name = trace.meta?.pieces?.[number];
  if (typeof name === "number") return name < 0 ? "" : t("chart.track", { n: name });
  return name ?? "";
}

/**
 * @param {Trace} trace
 * @param {number} i
 */
function isThere(trace, i) {
  return Number.isFinite(trace.x[i]) && Number.isFinite(trace.y[i]);
}
