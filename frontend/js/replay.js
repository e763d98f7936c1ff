// @ts-check
// What a plan shows of the instant that is looked at: where each track is going, and the gates of the next scan.

import { svg } from "./dom.js";

/**
 * @typedef {{index: number[], t: number[], east: number[], north: number[]}} Places
 * @typedef {Places & {v_east: number[], v_north: number[], track: number[]}} Vectors
 * @typedef {Places & {major: number[], minor: number[], azimuth: number[], gate: string[]}} Gates
 */

// A speed vector ends where the target would be so much later.
export const AHEAD_S = 30;
// A track that was not seen for so long is not drawn.
const STALE_S = 15;
const SAME_S = 1e-3;
const CORNERS = 48;

/**
 * The newest estimate of each track at an instant.
 * @param {Vectors} vectors
 * @param {number} time
 * @returns {number[]} positions in the lists
 */
export function latest(vectors, time) {
  /** @type {Map<string, number>} */
  const newest = new Map();
  vectors.t.forEach((t, i) => {
    if (t > time + SAME_S || t < time - STALE_S) return;
    const key = `${vectors.index[i]} ${vectors.track[i]}`;
    const before = newest.get(key);
    if (before === undefined || (vectors.t[before] ?? 0) <= t) newest.set(key, i);
  });
  return [...newest.values()];
}

/**
 * The gates of the first scan that is not over yet.
 * @param {Gates} gates
 * @param {number} time
 * @returns {number[]} positions in the lists
 */
export function coming(gates, time) {
  const next = Math.min(...gates.t.filter((t) => t >= time - SAME_S));
  return next - time > STALE_S ? [] : [...gates.t.keys()].filter((i) => Math.abs((gates.t[i] ?? 0) - next) < SAME_S);
}

/**
 * An ellipse as a closed line, in metres.
 * @param {Gates} gates
 * @param {number} i
 * @param {number} [share] of its size
 * @returns {[number, number][]}
 */
export function outline(gates, i, share = 1) {
  const [major, minor, turn] = [share * (gates.major[i] ?? 0), share * (gates.minor[i] ?? 0), ((gates.azimuth[i] ?? 0) * Math.PI) / 180];
  return Array.from({ length: CORNERS + 1 }, (_, k) => {
    const along = major * Math.cos((2 * Math.PI * k) / CORNERS);
    const across = minor * Math.sin((2 * Math.PI * k) / CORNERS);
    return [(gates.east[i] ?? 0) + along * Math.sin(turn) + across * Math.cos(turn), (gates.north[i] ?? 0) + along * Math.cos(turn) - across * Math.sin(turn)];
  });
}

/**
 * @param {{vectors: Vectors, gates: Gates, rings: Record<string, number[]>, unit_m: number} | undefined} replay
 * @param {number | null} time
 * @param {any[]} traces
 * @param {any} x axes
 * @param {any} y
 * @returns {SVGElement[]}
 */
export function replayed(replay, time, traces, x, y) {
  if (!replay || time === null) return [];
  const { vectors, gates, rings, unit_m: unit } = replay;
  // Entries that are hidden have no colour here.
  const colours = new Map(traces.filter((trace) => trace.visible === true && trace.meta?.role === "series").map((trace) => [trace.meta.index, trace.line?.color]));
  const at = (/** @type {number} */ east, /** @type {number} */ north) => `${x.d2p(east / unit)},${y.d2p(north / unit)}`;
  const line = (/** @type {string[]} */ places, /** @type {string} */ name, /** @type {number | undefined} */ index) =>
    colours.has(index) ? [svg("polyline", { class: name, points: places.join(" "), style: `color: ${colours.get(index)}` })] : [];
  return [
    ...coming(gates, time).flatMap((i) => {
      const kind = gates.gate[i] ?? "tracking";
      const inner = kind === "tracking" ? rings[String(gates.index[i])] ?? [] : [];
      return [1, ...inner].flatMap((share) => line(outline(gates, i, share).map(([east, north]) => at(east, north)), `gate-area ${share < 1 ? "gate-ring" : `gate-${kind}`}`, gates.index[i]));
    }),
    ...latest(vectors, time).flatMap((i) => {
      const [east, north] = [vectors.east[i] ?? 0, vectors.north[i] ?? 0];
      return line([at(east, north), at(east + AHEAD_S * (vectors.v_east[i] ?? 0), north + AHEAD_S * (vectors.v_north[i] ?? 0))], "speed-vector", vectors.index[i]);
    }),
  ];
}
