import assert from "node:assert/strict";
import test from "node:test";
import { keyMetric, verdictOf } from "../../frontend/js/verdict.js";

const one = (value, ci95 = null, unit = "m") => ({ value, ci95, unit });

test("without truth nothing is called accurate", () => {
  const [sentence] = verdictOf({ claimed_horizontal_m: { rdf: one(80), rdfv: one(60) } });
  assert.equal(sentence.kind, "no_truth");
  assert.equal(sentence.best.label, "rdfv");
  assert.equal(verdictOf({})[0].best, null);
  assert.equal(verdictOf(null)[0].kind, "nothing");
});

test("separate intervals prove a difference, overlapping ones do not", () => {
  const apart = verdictOf({ rms_horizontal_m: { rdf: one(319, [310, 330]), rdfv: one(171, [168, 175]) } })[0];
  assert.equal(apart.kind, "best");
  assert.equal(apart.proven, true);
  assert.equal(apart.best.label, "rdfv");
  assert.ok(Math.abs(apart.ratio - 319 / 171) < 1e-12);
  const overlapping = verdictOf({ rms_horizontal_m: { rdf: one(180, [160, 200]), rdfv: one(171, [150, 190]) } })[0];
  assert.equal(overlapping.kind, "no_difference");
});

test("without intervals a difference is only of this recording, and a tiny one is none", () => {
  assert.equal(verdictOf({ rms_horizontal_m: { a: one(100), b: one(150) } })[0].proven, false);
  assert.equal(verdictOf({ rms_horizontal_m: { a: one(100), b: one(101) } })[0].kind, "no_difference");
  assert.equal(verdictOf({ rms_horizontal_m: { a: one(100), b: one(null) } })[0].kind, "alone");
});

test("the claim of the best is compared with its actual error", () => {
  const claim = (actual, claimed) => verdictOf({ rms_horizontal_m: { a: one(actual) }, claimed_horizontal_m: { a: one(claimed) } }).find((s) => s.kind === "claim");
  assert.equal(claim(110, 100).honest, true);
  assert.equal(claim(200, 100).honest, false);
  assert.equal(claim(200, 100).ratio, 2);
  assert.equal(claim(50, 100).honest, false);
});

test("fewer answers, far errors and another order by the median are said", () => {
  const kinds = verdictOf({
    rms_horizontal_m: { a: one(100), b: one(300) },
    median_horizontal_m: { a: one(60), b: one(40) },
    answered_share: { a: one(0.6, null, ""), b: one(0.99, null, "") },
    over_5km_share: { a: one(0.01, null, ""), b: one(0, null, "") },
  }).map((sentence) => sentence.kind);
  assert.deepEqual(kinds, ["best", "other_measure", "coverage", "far"]);
});

test("lists show the actual error, else the claimed one", () => {
  assert.equal(keyMetric({ rms_horizontal_m: { a: one(3), b: one(2) }, claimed_horizontal_m: { a: one(1) } }).best.label, "b");
  assert.equal(keyMetric({ claimed_horizontal_m: { a: one(1) } }).metric, "claimed_horizontal_m");
  assert.equal(keyMetric(null), null);
});

test("of trackers the verdict says how steady their tracks are, and without truth how many there are", () => {
  const one = (value) => ({ imm: { value, ci95: null, unit: "1" } });
  const told = verdictOf({ rms_horizontal_m: one(171), tracked_share: one(0.99), switches: one(1), false_tracks: one(2) });
  assert.deepEqual(told.at(-1), { kind: "tracking", label: "imm", share: 0.99, switches: 1, wrong: 2 });
  assert.equal(verdictOf({ rms_horizontal_m: one(171), tracked_share: one(0.99), switches: one(1) }).at(-1).wrong, null);
  const blind = verdictOf({ confirmed_tracks: one(12), tracked_plots_share: one(0.4) });
  assert.deepEqual(blind.map((sentence) => sentence.kind), ["no_truth", "tracks"]);
  assert.deepEqual(verdictOf({ rms_horizontal_m: one(171) }).map((sentence) => sentence.kind), ["alone"]);
});
