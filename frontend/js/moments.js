// @ts-check
// Which points of a chart stand at an instant: by time, and for marks by the row of the recording.

import { rowOf } from "./figure.js";

/** @import { Trace } from "../types.d.ts" */

/** @typedef {{trace: Trace, x: any, y: any, z?: any, text?: any, time: number, row: number | null, at: number}} Point */
/** @typedef {{trace: Trace, times: Float64Array, order: Int32Array, reach: number}} Curve */

// Limits, bands and stations have no value of their own at an instant.
const READ = new Set(["series", "truth", "measurement", "rejected"]);
// A point further from the cursor than so many usual intervals says nothing about it.
const REACH = 1.5;
const SAME_S = 1e-6;

export class Moments {
  /** @type {{row: number, time: number}[] | undefined} */
  sorted;

  /**
   * @param {Trace[]} traces with decoded arrays
   * @param {boolean} overTime whether x is time; else the points' texts are
   */
  constructor(traces, overTime) {
    /** @type {Curve[]} */
    this.curves = traces.flatMap((trace) => curveOf(trace, overTime) ?? []);
  }

  /** First and last instant, or null. @returns {[number, number] | null} */
  get span() {
    const ends = this.curves.filter((curve) => curve.times.length);
    if (!ends.length) return null;
    return [Math.min(...ends.map((curve) => curve.times[0] ?? 0)), Math.max(...ends.map((curve) => curve.times.at(-1) ?? 0))];
  }

  /** The marks that have points, in the order of time; found when first asked for. */
  get marks() {
    this.sorted ??= marksOf(this.curves);
    return this.sorted;
  }

  /**
   * The nearest point of each curve; of curves of single marks only those no further away than their entry's others.
   * @param {number} time
   * @param {number | null} [row]
   * @returns {Point[]}
   */
  at(time, row = null) {
    const near = this.curves.flatMap((curve) => nearest(curve, time, row) ?? []);
    /** @type {Map<unknown, number>} */
    const closest = new Map();
    for (const point of near) {
      const label = point.trace.meta?.label ?? null;
      closest.set(label, Math.min(closest.get(label) ?? Infinity, Math.abs(point.time - time)));
    }
    return near.filter((point) => {
      const gap = Math.abs(point.time - time);
      if (point.trace.meta?.role === "rejected" && gap > SAME_S) return false;
      // The nearest mark may be of another target: where a mark is looked at, only it counts.
      if (row !== null && point.row !== null && point.row !== row && !isLine(point.trace)) return false;
      return isLine(point.trace) || gap <= (closest.get(point.trace.meta?.label ?? null) ?? 0) + SAME_S;
    });
  }

  /**
   * All estimates between two instants, at most about `most` of each curve.
   * @param {number} from
   * @param {number} to
   * @param {number} most
   * @returns {{trace: Trace, x: any, y: any}[]}
   */
  between(from, to, most) {
    return this.curves.filter(({ trace }) => trace.meta?.role === "series").flatMap(({ trace, times, order }) => {
      const inside = [...times.keys()].filter((k) => (times[k] ?? 0) >= from && (times[k] ?? 0) <= to);
      const every = Math.ceil(inside.length / most);
      return inside.filter((_, k) => k % every === 0).map((k) => ({ trace, x: trace.x[order[k] ?? 0], y: trace.y[order[k] ?? 0] }));
    });
  }

  /**
   * The mark `step` marks after an instant.
   * @param {number | null} time
   * @param {number | null} row
   * @param {number} step
   */
  step(time, row, step) {
    const { marks } = this;
    const own = row === null ? -1 : marks.findIndex((mark) => mark.row === row);
    const before = time === null ? -1 : marks.findLastIndex((mark) => mark.time <= time + SAME_S);
    const at = own >= 0 ? own : before;
    const between = own < 0 && time !== null && Math.abs((marks[before]?.time ?? -Infinity) - time) > SAME_S;
    const to = step < 0 && between ? at + step + 1 : at + step;
    return marks[Math.min(marks.length - 1, Math.max(0, to))] ?? null;
  }

  /** The mark nearest to an instant. @param {number} time */
  snap(time) {
    const { marks } = this;
    let low = 0;
    let high = marks.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((marks[middle]?.time ?? 0) < time) low = middle + 1;
      else high = middle;
    }
    const [before, after] = [marks[low - 1], marks[low]];
    if (!before || !after) return after ?? before ?? null;
    return time - before.time < after.time - time ? before : after;
  }
}

/** @param {Trace} trace */
function isLine(trace) {
  return trace.type === "bar" || String(trace.mode ?? "").includes("lines");
}

/**
 * @param {Trace} trace
 * @param {boolean} overTime
 * @returns {Curve | null}
 */
function curveOf(trace, overTime) {
  const at = overTime ? trace.x : trace.text;
  if (trace.visible === false || trace.type === "heatmap" || !READ.has(trace.meta?.role ?? "") || !at || typeof at === "string") return null;
  const all = Float64Array.from(at, (/** @type {any} */ one) => (one === "" || one === null ? NaN : Number(one)));
  const order = Int32Array.from(all.keys()).filter((i) => Number.isFinite(all[i]) && Number.isFinite(trace.x[i]) && Number.isFinite(trace.y[i]));
  order.sort((a, b) => (all[a] ?? 0) - (all[b] ?? 0));
  const times = Float64Array.from(order, (i) => all[i] ?? 0);
  const gaps = times.subarray(1).map((time, i) => time - (times[i] ?? 0)).filter((gap) => gap > 0).sort();
  return { trace, times, order, reach: REACH * (gaps[(gaps.length - 1) >> 1] ?? 1) };
}

/**
 * @param {Curve} curve
 * @param {number} time
 * @param {number | null} row
 * @returns {Point | null}
 */
function nearest({ trace, times, order, reach }, time, row) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) < time - SAME_S) low = middle + 1;
    else high = middle;
  }
  let best = -1;
  for (let i = Math.max(0, low - 1); i < times.length && (i <= low || (times[i] ?? 0) <= time + SAME_S); i += 1) {
    const own = row !== null && rowOf(trace.customdata?.[order[i] ?? 0]) === row;
    if (own || best < 0 || Math.abs((times[i] ?? 0) - time) < Math.abs((times[best] ?? 0) - time)) best = i;
    if (own) break;
  }
  if (best < 0 || Math.abs((times[best] ?? 0) - time) > reach) return null;
  const i = order[best] ?? 0;
  return { trace, x: trace.x[i], y: trace.y[i], text: trace.text?.[i], time: times[best] ?? 0, row: rowOf(trace.customdata?.[i]), at: i };
}

/** @param {Curve[]} curves */
function marksOf(curves) {
  /** @type {Map<number, number>} */
  const times = new Map();
  for (const { trace, times: at, order } of curves) {
    if (!trace.customdata) continue;
    for (let k = 0; k < order.length; k += 1) {
      const row = rowOf(trace.customdata[order[k] ?? 0]);
      if (row !== null && !times.has(row)) times.set(row, at[k] ?? 0);
    }
  }
  return [...times].map(([row, time]) => ({ row, time })).sort((a, b) => a.time - b.time || a.row - b.row);
}
