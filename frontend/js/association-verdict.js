// @ts-check
// The answer of a run that decides which plots belong together: how many pairs are right, not how far positions are off.

/** @import { Row } from "./tables.js" */
/** @import { Summary } from "../types.d.ts" */

/**
 * @typedef {{label: string, recall: number | null, precision: number | null, accepted: number | null, undecided: number | null}} Found
 * @typedef {{label: string, correct: number, wrong: number, undecided: number}} Shares
 * @typedef {{label: string, from: number, at: string, to: number, until: string}} Range
 */

/**
 * What the algorithms made of a recording, the one that finds most first; null where none of them associates plots.
 * @param {Summary | null} summary
 * @returns {Found[] | null}
 */
export function associationsOf(summary) {
  const labels = Object.keys(summary?.accepted_share ?? {});
  if (!summary || !labels.length) return null;
  const value = (/** @type {string} */ metric, /** @type {string} */ label) => summary[metric]?.[label]?.value ?? null;
  return labels
    .map((label) => ({
      label, recall: value("recall", label), precision: value("precision", label), accepted: value("accepted_share", label), undecided: value("undecided_share", label),
    }))
    .sort((a, b) => (b.recall ?? b.accepted ?? 0) - (a.recall ?? a.accepted ?? 0));
}

/** @param {Row} row */
const conditions = (row) => Object.keys(row).filter((name) => name.includes(".") && row[name] !== null && row[name] !== undefined)
  .map((name) => `${name.slice(name.lastIndexOf(".") + 1)} = ${row[name]}`).join(", ");

/**
 * Shares over trials of each algorithm, or from where to where they go over swept values; the best first.
 * @param {Row[]} metrics @param {string} target
 * @returns {{shares: Shares[], ranges: Range[]} | null} null where no algorithm of the run associates plots
 */
export function associationsOverTrials(metrics, target) {
  const about = metrics.filter((row) => !row.segment && String(row.target ?? "") === target && typeof row.value === "number");
  const correct = about.filter((row) => row.metric === "probability_correct");
  if (!correct.length) return null;
  /** @type {Shares[]} */
  const shares = [];
  /** @type {Range[]} */
  const ranges = [];
  for (const label of new Set(correct.map((row) => String(row.label)))) {
    const own = correct.filter((row) => row.label === label).sort((a, b) => Number(a.value) - Number(b.value));
    const [low, high] = [own[0], own[own.length - 1]];
    if (!low || !high) continue;
    if (own.length > 1) {
      ranges.push({ label, from: Number(low.value), at: conditions(low), to: Number(high.value), until: conditions(high) });
      continue;
    }
    const share = (/** @type {string} */ metric) => Number(about.find((row) => row.metric === metric && row.label === label)?.value ?? 0);
    shares.push({ label, correct: Number(low.value), wrong: share("probability_wrong"), undecided: share("probability_undecided") });
  }
  shares.sort((a, b) => b.correct - a.correct);
  ranges.sort((a, b) => b.from + b.to - a.from - a.to);
  return { shares, ranges };
}
