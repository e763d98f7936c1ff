// @ts-check
// The verdict of a Monte Carlo run in words.

import { associationsOverTrials } from "../js/association-verdict.js";
import { h, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { formatBounds, formatCount, formatNumber, formatQuantity, formatShare } from "../js/numbers.js";
import { loadTable } from "../js/tables.js";
import { trialVerdict } from "../js/trial-verdict.js";

/** @import { Run } from "../types.d.ts" */
/** @import { Amount, Leg, Places, TrialSentence } from "../js/trial-verdict.js" */

/**
 * @param {Run} run
 * @param {string} target the one that it is about; empty = all
 */
export async function trialsVerdict(run, target) {
  const box = h("p", { class: "verdict", data: { kind: "trials" } });
  const [metrics, comparisons] = await Promise.all(["metrics", "comparisons"].map((name) => loadTable(run.id, name, target)));
  const found = trialVerdict({ metrics: metrics?.rows ?? [], comparisons: comparisons?.rows ?? [], labels: run.algorithms.map((entry) => entry.label ?? entry.name), target });
  const trials = formatCount(run.trials);
  const associated = associationsOverTrials(metrics?.rows ?? [], target);
  if (associated) {
    box.dataset.kind = "association";
    put(box, target ? h("span", { class: "muted" }, t("verdict.of_target", { name: target }), " ") : null, t("trials.associated", { trials }),
      associationWords(associated).map((words, i) => h("span", { class: i ? "muted" : null }, " ", words)));
    return box;
  }
  box.dataset.kind = found[0]?.kind ?? "nothing";
  put(box, target ? h("span", { class: "muted" }, t("verdict.of_target", { name: target }), " ") : null,
    found.map((one, i) => h("span", { class: i ? "muted" : null }, i ? " " : "", sentence(one, trials))));
  return box;
}

/** @param {NonNullable<ReturnType<typeof associationsOverTrials>>} found */
function associationWords({ shares, ranges }) {
  return [
    ...shares.map((one) => t("trials.associated_shares", { label: one.label, correct: formatShare(one.correct), wrong: formatShare(one.wrong), undecided: formatShare(one.undecided) })),
    ...ranges.map((one) => t("trials.associated_range", { label: one.label, from: formatShare(one.from), at: one.at, to: formatShare(one.to), until: one.until })),
  ];
}

/** @param {Amount} one @param {(value: number) => string} words */
function amount(one, words) {
  return one.low === null || one.high === null ? words(one.value) : `${words(one.value)} (${formatBounds(one.low, one.high, one.value, words === metres ? "m" : "")})`;
}

const metres = (/** @type {number} */ value) => formatQuantity(value, "m");

/** @param {TrialSentence} one @param {string} trials @returns {string} */
function sentence(one, trials) {
  switch (one.kind) {
    case "no_truth":
      return t("verdict.nothing");
    case "alone":
      return one.at[0] === one.at[1] ? t("verdict.alone", { label: one.label, value: amount(one.from, metres) })
        : t("trials.verdict_range", { label: one.label, from: amount(one.from, metres), at_from: one.at[0], to: amount(one.to, metres), at_to: one.at[1] });
    case "best":
      return t("trials.verdict_best", { label: one.label, next: one.next, trials, value: one.value ? amount(one.value, metres) : "–", ratio: amount(one.ratio, formatNumber) });
    case "larger":
      return t("trials.verdict_larger_of", { list: one.others.map(({ next, ratio }) => t("trials.verdict_times", { next, ratio: amount(ratio, formatNumber) })).join(", ") });
    case "no_difference":
      return t("trials.verdict_even", { label: one.label, next: one.next, trials, ratio: amount(one.ratio, formatNumber) });
    case "everywhere":
      return t("trials.verdict_everywhere", { label: one.label, next: one.next, from: amount(one.least, formatNumber), to: amount(one.most, formatNumber) });
    case "even_everywhere":
      return t("trials.verdict_even_everywhere", { label: one.label, next: one.next, trials });
    case "somewhere": {
      const first = one.most ? t("trials.verdict_somewhere", { label: one.label, next: one.next, better: formatCount(one.better), of: formatCount(one.of), ratio: amount(one.most, formatNumber), at: one.at })
        : t("trials.verdict_nowhere", { label: one.label, next: one.next });
      const rest = one.even && one.worse ? t("trials.verdict_at_both", { even: where(one.even), worse: where(one.worse), trials })
        : one.even ? t("trials.verdict_at_even", { even: where(one.even), trials }) : one.worse ? t("trials.verdict_at_worse", { worse: where(one.worse) }) : "";
      return `${first} ${rest}`;
    }
    case "setting":
      return t("trials.verdict_setting", { at: one.at, ratio: amount(one.most, formatNumber) }) + (one.even ? ` ${t("trials.verdict_at_even", { even: where(one.even), trials })}` : "");
    case "coverage":
      return t("verdict.coverage", { label: one.label, share: formatShare(one.share), best: one.best, best_share: formatShare(one.bestShare) });
    case "honesty":
      return honestyWords(one.label, one.legs) + (one.swept ? ` ${t("trials.farthest")}` : "");
  }
}

/** @param {Places} places */
function where({ at, more, count, of }) {
  const numbers = { at, of: formatCount(of) };
  if (!at) return t("trials.in_cases", { ...numbers, count: formatCount(count) });
  return more ? t("trials.at_and_cases", { ...numbers, count: formatCount(more) }) : t("trials.at", numbers);
}

/** @param {string} label @param {Leg[]} legs */
function honestyWords(label, legs) {
  const list = (/** @type {Leg["word"]} */ word) => legs.filter((leg) => leg.word === word).map((leg) => {
    const ratio = formatNumber(word === "large" ? 1 / leg.ratio : leg.ratio, 2);
    return leg.name ? `${leg.name} ${ratio}` : ratio;
  }).join(", ");
  const parts = [
    list("honest") ? t("trials.honest", { legs: list("honest") }) : "",
    list("small") ? t("trials.too_small", { legs: list("small") }) : "",
    list("large") ? t("trials.too_large", { legs: list("large") }) : "",
  ].filter(Boolean).join("; ");
  return t("trials.honesty", { label, parts });
}
