import assert from "node:assert/strict";
import test from "node:test";
import { associationsOf, associationsOverTrials } from "../../frontend/js/association-verdict.js";

const one = (value) => ({ value, ci95: null, unit: "1" });

test("a recording's associations are ranked by the pairs found, without truth by the plots that have a partner", () => {
  assert.equal(associationsOf(null), null);
  assert.equal(associationsOf({ rms_horizontal_m: { a: one(10) } }), null);
  const known = associationsOf({ accepted_share: { a: one(0.9), b: one(0.5) }, recall: { a: one(0.4), b: one(0.8) }, precision: { a: one(0.5), b: one(1) } });
  assert.deepEqual(known.map((found) => found.label), ["b", "a"]);
  assert.equal(known[0].precision, 1);
  const plain = associationsOf({ accepted_share: { a: one(0.4), b: one(0.5) }, undecided_share: { a: one(0.1), b: one(0) } });
  assert.deepEqual(plain.map((found) => [found.label, found.recall, found.accepted]), [["b", null, 0.5], ["a", null, 0.4]]);
});

test("over trials each algorithm has its shares, over swept values the range", () => {
  const row = (metric, label, value, more = {}) => ({ metric, label, value, segment: "", target: "", ...more });
  const metrics = [
    row("probability_correct", "lin", 0.66), row("probability_wrong", "lin", 0.01), row("probability_undecided", "lin", 0.33),
    row("probability_correct", "best", 0.97), row("probability_wrong", "best", 0), row("probability_undecided", "best", 0.03),
    row("probability_correct", "lin", 0.5, { target: "2" }), row("rms_horizontal_m", "lin", 100),
  ];
  const found = associationsOverTrials(metrics, "");
  assert.deepEqual(found.shares.map((s) => [s.label, s.correct, s.wrong, s.undecided]), [["best", 0.97, 0, 0.03], ["lin", 0.66, 0.01, 0.33]]);
  assert.deepEqual(associationsOverTrials(metrics, "2").shares.map((s) => s.correct), [0.5]);
  assert.equal(associationsOverTrials([row("rms_horizontal_m", "a", 1)], ""), null);
  const swept = associationsOverTrials([0, 10, 20].map((base) => row("probability_correct", "lin", 1 - base / 100, { "scenario.base_m": base })), "");
  assert.deepEqual(swept.ranges, [{ label: "lin", from: 0.8, at: "base_m = 20", to: 1, until: "base_m = 0" }]);
});
