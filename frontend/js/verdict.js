// @ts-check
// The answer of a run in sentences, made from its metrics and their intervals and no stronger than they allow.

/** @import { Summary } from "../types.d.ts" */

// A claimed error within this factor of the actual one counts as honest.
const HONEST = 1.25;
// Fewer answers than this share behind the best entry: the errors are not over the same marks.
export const FEWER_ANSWERS = 0.05;

/**
 * @typedef {{label: string, value: number, low: number | null, high: number | null}} Ranked
 * @typedef {{kind: "best", best: Ranked, next: Ranked | null, ratio: number, proven: boolean}
 *   | {kind: "alone", best: Ranked}
 *   | {kind: "no_difference", best: Ranked, next: Ranked}
 *   | {kind: "no_truth", best: Ranked | null}
 *   | {kind: "nothing"}
 *   | {kind: "claim", label: string, ratio: number, honest: boolean}
 *   | {kind: "coverage", label: string, share: number, best: string, bestShare: number}
 *   | {kind: "far", label: string, share: number}
 *   | {kind: "tracking", label: string, share: number, switches: number, wrong: number | null}
 *   | {kind: "tracks", label: string, count: number, share: number}
 *   | {kind: "other_measure", label: string, value: number, next: number, nextLabel: string}} Sentence
 */

/**
 * @param {Summary} summary
 * @param {string} metric
 * @returns {Ranked[]} finite values, smallest first
 */
function ranked(summary, metric) {
  return Object.entries(summary[metric] ?? {})
    .filter((pair) => Number.isFinite(pair[1].value))
    .map(([label, one]) => ({
      label,
      value: /** @type {number} */ (one.value),
      low: one.ci95?.[0] ?? null,
      high: one.ci95?.[1] ?? null,
    }))
    .sort((a, b) => a.value - b.value);
}

/**
 * What can be said about a run.
 * @param {Summary | null} summary
 * @returns {Sentence[]}
 */
export function verdictOf(summary) {
  if (!summary) return [{ kind: "nothing" }];
  const actual = ranked(summary, "rms_horizontal_m");
  const best = actual[0];
  if (!best) {
    const claimed = ranked(summary, "claimed_horizontal_m");
    return [{ kind: "no_truth", best: claimed[0] ?? null }, ...tracksOf(summary)];
  }
  /** @type {Sentence[]} */
  const sentences = [];
  const next = actual[1];
  if (!next) sentences.push({ kind: "alone", best });
  else if (indistinguishable(best, next)) sentences.push({ kind: "no_difference", best, next });
  else {
    const proven = best.high !== null && next.low !== null;
    sentences.push({ kind: "best", best, next, ratio: next.value / best.value, proven });
  }
  const median = ranked(summary, "median_horizontal_m");
  const middle = median[0];
  const own = median.find((one) => one.label === best.label);
  if (next && middle && own && middle.label !== best.label && own.value > middle.value * 1.05) {
    sentences.push({ kind: "other_measure", label: middle.label, value: middle.value, next: own.value, nextLabel: best.label });
  }
  const claim = summary.claimed_horizontal_m?.[best.label]?.value;
  if (claim && best.value) {
    const ratio = best.value / claim;
    sentences.push({ kind: "claim", label: best.label, ratio, honest: ratio < HONEST && ratio > 1 / HONEST });
  }
  const shares = summary.answered_share ?? {};
  const bestShare = shares[best.label]?.value;
  if (bestShare !== null && bestShare !== undefined) {
    for (const [label, one] of Object.entries(shares)) {
      if (label !== best.label && one.value !== null && Math.abs(one.value - bestShare) > FEWER_ANSWERS) {
        sentences.push({ kind: "coverage", label, share: one.value, best: best.label, bestShare });
        break;
      }
    }
  }
  const far = summary.over_5km_share?.[best.label]?.value;
  if (far) sentences.push({ kind: "far", label: best.label, share: far });
  return [...sentences, ...trackingOf(summary)];
}

/** How steady tracks are, of trackers alone. @param {Summary} summary @returns {Sentence[]} */
function trackingOf(summary) {
  return Object.entries(summary.tracked_share ?? {}).flatMap(([label, { value: share }]) => {
    const switches = summary.switches?.[label]?.value;
    const known = share !== null && switches !== null && switches !== undefined;
    return known ? [{ kind: /** @type {const} */ ("tracking"), label, share, switches, wrong: summary.false_tracks?.[label]?.value ?? null }] : [];
  });
}

/** Without truth: how many tracks there are, and what share of the plots they took. @param {Summary} summary @returns {Sentence[]} */
function tracksOf(summary) {
  return Object.entries(summary.confirmed_tracks ?? {}).flatMap(([label, { value: count }]) => {
    const share = summary.tracked_plots_share?.[label]?.value ?? null;
    return count !== null && share !== null ? [{ kind: /** @type {const} */ ("tracks"), label, count, share }] : [];
  });
}

/**
 * Whether two values cannot be told apart: overlapping intervals, or less than 2 % without intervals.
 * @param {Ranked} best
 * @param {Ranked} next
 */
function indistinguishable(best, next) {
  if (best.high !== null && next.low !== null) return best.high >= next.low;
  return next.value <= best.value * 1.02;
}

/**
 * The number that stands for a run in lists.
 * @param {Summary | null} summary
 * @returns {{metric: string, best: Ranked, of: number} | null}
 */
export function keyMetric(summary) {
  if (!summary) return null;
  for (const metric of ["rms_horizontal_m", "rms_position_m", "claimed_horizontal_m", "nis"]) {
    const values = ranked(summary, metric);
    if (values[0]) return { metric, best: values[0], of: values.length };
  }
  return null;
}
