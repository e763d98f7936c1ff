// @ts-check
// The verdict of a run in words.

import { associationsOf } from "../js/association-verdict.js";
import { h } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { formatBounds, formatNumber, formatQuantity, formatShare } from "../js/numbers.js";
import { verdictOf } from "../js/verdict.js";

/** @import { Summary } from "../types.d.ts" */
/** @import { Found } from "../js/association-verdict.js" */
/** @import { Ranked, Sentence } from "../js/verdict.js" */

/**
 * @param {Summary | null} summary
 * @param {string} [target] the one that it is about; empty = all
 */
export function runVerdict(summary, target = "") {
  const associated = associationsOf(summary);
  if (associated) {
    return h("p", { class: "verdict", data: { kind: "association" } },
      target ? h("span", { class: "muted" }, t("verdict.of_target", { name: target }), " ") : null,
      associated.map((one, i) => h("span", { class: i ? "muted" : null }, i ? " " : "", associationWords(one))));
  }
  const [first, ...rest] = verdictOf(summary);
  return h("p", { class: "verdict", data: { kind: first?.kind ?? "nothing" } },
    target ? h("span", { class: "muted" }, t("verdict.of_target", { name: target }), " ") : null,
    first ? h("span", null, sentence(first)) : null,
    rest.map((one) => h("span", { class: "muted" }, " ", sentence(one))));
}

/** @param {Found} one */
function associationWords(one) {
  const share = (/** @type {number | null} */ value) => (value === null ? "–" : formatShare(value));
  return one.recall === null
    ? t("verdict.associated", { label: one.label, accepted: share(one.accepted), undecided: share(one.undecided) })
    : t("verdict.associated_truth", { label: one.label, recall: share(one.recall), precision: share(one.precision), undecided: share(one.undecided) });
}

/** @param {Ranked} one */
function amount(one) {
  const value = formatQuantity(one.value, "m");
  return one.low === null || one.high === null ? value : `${value} (${formatBounds(one.low, one.high, one.value, "m")})`;
}

/** @param {Sentence} one @returns {string} */
function sentence(one) {
  switch (one.kind) {
    case "nothing":
      return t("verdict.nothing");
    case "no_truth":
      return one.best ? t("verdict.no_truth", { label: one.best.label, value: formatQuantity(one.best.value, "m") }) : t("verdict.no_truth_no_claim");
    case "alone":
      return t("verdict.alone", { label: one.best.label, value: amount(one.best) });
    case "no_difference":
      return t("verdict.no_difference", { best: one.best.label, value: amount(one.best), next: one.next.label, next_value: amount(one.next) });
    case "best":
      return t(one.proven ? "verdict.best" : "verdict.best_unproven", {
        label: one.best.label, value: amount(one.best), next: one.next?.label ?? "", next_value: one.next ? amount(one.next) : "", ratio: formatNumber(one.ratio, 2),
      });
    case "other_measure":
      return t("verdict.other_measure", { label: one.label, value: formatQuantity(one.value, "m"), next: formatQuantity(one.next, "m"), next_label: one.nextLabel });
    case "claim":
      if (one.honest) return t("verdict.claim_honest", { label: one.label, ratio: formatNumber(one.ratio, 2) });
      return one.ratio > 1
        ? t("verdict.claim_small", { label: one.label, ratio: formatNumber(one.ratio, 2) })
        : t("verdict.claim_large", { label: one.label, ratio: formatNumber(1 / one.ratio, 2) });
    case "coverage":
      return t("verdict.coverage", { label: one.label, share: formatShare(one.share), best: one.best, best_share: formatShare(one.bestShare) });
    case "tracking":
      return t(one.wrong === null ? "verdict.tracking_of_target" : "verdict.tracking", { label: one.label, share: formatShare(one.share), switches: formatQuantity(one.switches, "1"), wrong: formatQuantity(one.wrong, "1") });
    case "tracks":
      return t("verdict.tracks", { label: one.label, count: formatQuantity(one.count, "1"), share: formatShare(one.share) });
    case "far":
      return t("verdict.far", { label: one.label, share: formatShare(one.share) });
  }
}
