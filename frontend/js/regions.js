// @ts-check
// Regions of a form: polygons and height bands with a matrix each. What is wrong with them, and the paths behind them.

import { wrongRows } from "./matrix.js";
import { polygonFault } from "./polygon.js";

/** @import { Figure } from "../types.d.ts" */
/** @import { Matrix } from "./matrix.js" */

/** East and north in metres; null where nobody has typed a number yet. @typedef {[number | null, number | null]} Corner */
/** @typedef {{corners?: Corner[], [name: string]: unknown}} Region */
/** A path or a crowd of points, metres. @typedef {{line: boolean, east: number[], north: number[]}} Path */
/** What the server calls the fields of a height band, matrices with their sums of rows, and of which size they are. @typedef {{bands: [string, string][], matrices: {name: string, sum: number | null}[], size: number | null}} Rules */
/** @typedef {{region: number, place: "corner" | "few" | "flat" | "crossing" | "matrix" | "matrix_rows" | "field", at?: number, field?: string, edges?: [number, number][]}} Fault */

/** @type {Record<string, (view: DataView, at: number) => number>} */
const READERS = {
  f4: (view, at) => view.getFloat32(at, true), f8: (view, at) => view.getFloat64(at, true),
  i4: (view, at) => view.getInt32(at, true), i2: (view, at) => view.getInt16(at, true), u2: (view, at) => view.getUint16(at, true),
  i1: (view, at) => view.getInt8(at), u1: (view, at) => view.getUint8(at),
};

/** Numbers of a figure, which the server may have packed. @param {any} values @returns {number[]} */
export function numbersOf(values) {
  const read = READERS[values?.dtype];
  if (!read || typeof values.bdata !== "string") return Array.isArray(values) ? values.map((one) => (typeof one === "number" ? one : NaN)) : [];
  const bytes = Uint8Array.from(atob(values.bdata), (letter) => letter.charCodeAt(0));
  const size = Number(values.dtype[1]);
  const view = new DataView(bytes.buffer);
  return Array.from({ length: Math.floor(bytes.length / size) }, (_, i) => read(view, i * size));
}

/** True paths of a drawn plan, or its plots where the truth is unknown. @param {Figure | undefined} figure @returns {Path[]} */
export function pathsOf(figure) {
  const title = figure?.layout?.xaxis?.title;
  const metres = String(title?.text ?? title ?? "").trimEnd().endsWith("km") ? 1000 : 1;
  const of = (/** @type {string} */ role) => (figure?.data ?? []).filter((trace) => trace.meta?.role === role).map((trace) => ({
    line: role === "truth", east: numbersOf(trace.x).map((x) => x * metres), north: numbersOf(trace.y).map((y) => y * metres),
  }));
  const truth = of("truth");
  return truth.length ? truth : of("measurement");
}

/**
 * The smallest box, a little larger, that holds all points; the same metres on both axes.
 * @param {{east: number[], north: number[]}[]} paths
 * @param {number} width
 * @param {number} height
 */
export function viewOf(paths, width, height) {
  const known = paths.flatMap(({ east, north }) => east.map((x, i) => [x, north[i] ?? NaN])).filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
  const span = (/** @type {number} */ axis) => {
    const values = known.map((point) => /** @type {number} */ (point[axis]));
    return values.length ? [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))] : [-5000, 5000];
  };
  const [[west = 0, east = 0], [south = 0, north = 0]] = [span(0), span(1)];
  const metres = Math.max((east - west) / width, (north - south) / height, 0.1) * 1.25;
  return { metres, east: (west + east) / 2 - (metres * width) / 2, north: (south + north) / 2 + (metres * height) / 2 };
}

/**
 * Where a new corner belongs: into the edge that it lengthens least, so that a polygon does not cross itself.
 * @param {number[][]} corners
 * @param {number} east
 * @param {number} north
 */
export function placeOf(corners, east, north) {
  if (corners.length < 3) return corners.length;
  const way = (/** @type {number[]} */ a, /** @type {number[]} */ b) => Math.hypot((a[0] ?? 0) - (b[0] ?? 0), (a[1] ?? 0) - (b[1] ?? 0));
  const longer = corners.map((from, i) => {
    const to = corners[(i + 1) % corners.length] ?? from;
    return way(from, [east, north]) + way([east, north], to) - way(from, to);
  });
  return longer.indexOf(Math.min(...longer)) + 1;
}

/** Corners whose both numbers are known. @param {Region} region @returns {number[][]} */
export function knownCorners(region) {
  return (region.corners ?? []).flatMap(([east, north]) => (typeof east === "number" && typeof north === "number" ? [[east, north]] : []));
}

/**
 * The first thing that is wrong with regions, and where.
 * @param {Region[]} regions
 * @param {Rules} rules
 * @returns {Fault | null}
 */
export function faultOf(regions, { bands, matrices, size }) {
  for (const [region, one] of regions.entries()) {
    const corners = one.corners ?? [];
    const empty = corners.findIndex((corner) => corner.includes(null));
    if (empty >= 0) return { region, place: "corner", at: empty };
    const fault = corners.length ? polygonFault(/** @type {[number, number][]} */ (corners)) : null;
    if (fault) return { region, ...fault };
    const unread = Object.keys(one).find((name) => one[name] === null);
    if (unread) return { region, place: "field", field: unread };
    for (const [low, high] of bands) {
      const [from, to] = [one[low], one[high]];
      if (typeof from === "number" && typeof to === "number" && to <= from) return { region, place: "field", field: high };
    }
    for (const { name, sum } of matrices) {
      const matrix = /** @type {Matrix} */ (one[name] ?? []);
      if (size !== null && matrix.length !== size) return { region, place: "matrix" };
      if (!matrix.length || matrix.some((row) => row.length !== matrix.length || row.includes(null))) return { region, place: "matrix" };
      const wrong = sum === null ? [] : wrongRows(matrix, sum);
      if (wrong.length) return { region, place: "matrix_rows", at: wrong[0] };
    }
  }
  return null;
}

/**
 * The region, and the corner or field in it, that a pointer of the server names: `regions/1/corners/2/0`.
 * @param {string} pointer
 * @returns {{region: number, field: string, corner: number | null, axis: number | null} | null}
 */
export function placeIn(pointer) {
  const found = /^[^/]+\/(\d+)(?:\/([^/]+)(?:\/(\d+)(?:\/(\d+))?)?)?/.exec(pointer);
  if (!found) return null;
  const field = found[2] ?? "";
  const number = (/** @type {string | undefined} */ text) => (text === undefined ? null : Number(text));
  return { region: Number(found[1]), field, corner: field === "corners" ? number(found[3]) : null, axis: field === "corners" ? number(found[4]) : null };
}
