import assert from "node:assert/strict";
import test from "node:test";
import { joined, ownerOf, placesOf, trialVerdict } from "../../frontend/js/trial-verdict.js";

const labels = ["rdf", "rdfv"];
const metric = (label, value, more = {}) => ({ metric: "rms_horizontal_m", label, segment: "", target: "", value, ci95_low: 0.9 * value, ci95_high: 1.1 * value, ...more });
const pair = (label, against, ratio, verdict, more = {}) => ({ metric: "rms_horizontal_m", label, against, segment: "", target: "", ratio, ratio_low: 0.9 * ratio, ratio_high: 1.1 * ratio, verdict, ...more });

test("one cell: the paired ratio decides, not the intervals of each alone", () => {
  const [found] = trialVerdict({ metrics: [metric("rdf", 105), metric("rdfv", 100)], comparisons: [pair("rdf", "rdfv", 1.05, "larger")], labels });
  assert.equal(found.kind, "best");
  assert.equal(found.label, "rdfv");
  assert.equal(found.ratio.value, 1.05);
  const [even] = trialVerdict({ metrics: [metric("rdf", 105), metric("rdfv", 100)], comparisons: [pair("rdf", "rdfv", 1.05, "no_difference")], labels });
  assert.equal(even.kind, "no_difference");
});

test("of several that are worse the first is told in full, the others by name and ratio", () => {
  const many = ["a", "b", "c", "d"];
  const metrics = many.map((label, i) => metric(label, 10 * (i + 1)));
  const comparisons = [pair("a", "d", 0.25, "smaller"), pair("a", "b", 0.5, "smaller"), pair("a", "c", 0.4, "smaller")];
  const found = trialVerdict({ metrics, comparisons, labels: many });
  assert.deepEqual(found.map((one) => one.kind), ["best", "larger"]);
  assert.equal(found[0].next, "b");
  assert.deepEqual(found[1].others.map((one) => [one.next, one.ratio.value]), [["c", 2.5], ["d", 4]]);
  // Nobody is the most accurate of all where one is as good.
  const even = trialVerdict({ metrics, comparisons: [pair("a", "b", 0.98, "no_difference"), pair("a", "c", 0.4, "smaller")], labels: many });
  assert.deepEqual(even.map((one) => one.kind), ["no_difference", "larger"]);
});

test("seen from the other side ratio and bounds turn over", () => {
  const [found] = trialVerdict({ metrics: [metric("rdf", 50), metric("rdfv", 100)], comparisons: [pair("rdf", "rdfv", 0.5, "smaller")], labels });
  assert.equal(found.label, "rdf");
  assert.equal(found.ratio.value, 2);
  assert.ok(found.ratio.low < 2 && found.ratio.high > 2);
});

test("a swept scenario: variants of one algorithm are no rivals, and it is said where the order holds", () => {
  const name = "scenario.sigma_altitude_m";
  const metrics = [10, 3000].flatMap((v) => [metric("rdf", 105, { [name]: v }), metric("rdfv", 100, { [name]: v })]);
  const everywhere = trialVerdict({ metrics, comparisons: [pair("rdf", "rdfv", 2, "larger", { [name]: 10 }), pair("rdf", "rdfv", 1.1, "larger", { [name]: 3000 })], labels })[0];
  assert.deepEqual([everywhere.kind, everywhere.label, everywhere.next, everywhere.least.value, everywhere.most.value], ["everywhere", "rdfv", "rdf", 1.1, 2]);
  assert.deepEqual([everywhere.most.low, everywhere.most.high], [1.8, 2.2]);
  const somewhere = trialVerdict({ metrics, comparisons: [pair("rdf", "rdfv", 2, "larger", { [name]: 10 }), pair("rdf", "rdfv", 1.01, "no_difference", { [name]: 3000 })], labels })[0];
  assert.equal(somewhere.kind, "somewhere");
  assert.deepEqual([somewhere.better, somewhere.of, somewhere.most.value, somewhere.at], [1, 2, 2, "sigma_altitude_m = 10"]);
  assert.deepEqual(somewhere.even, { at: "sigma_altitude_m = 3000", more: 0, count: 1, of: 2 });
  assert.equal(somewhere.worse, null);
  const even = [10, 3000].map((v) => pair("rdf", "rdfv", 1.01, "no_difference", { [name]: v }));
  assert.equal(trialVerdict({ metrics, comparisons: even, labels })[0].kind, "even_everywhere");
});

test("a swept algorithm: its own variants are left out where there is another label", () => {
  const names = [10, 100].map((v) => `rdfv, sigma_altitude_m = ${v}`);
  const comparisons = [pair("rdf", names[0], 0.8, "smaller"), pair("rdf", names[1], 1.5, "larger"), pair(names[0], names[1], 1.9, "larger")];
  const [found] = trialVerdict({ metrics: [metric("rdf", 105)], comparisons, labels });
  assert.equal(found.kind, "somewhere");
  assert.deepEqual([found.label, found.better, found.of, found.worse.at], ["rdfv", 1, 2, "sigma_altitude_m = 10"]);
});

test("a sweep over the settings of two trackers is told by what its cases have in common, not case by case", () => {
  const trackers = ["imm", "curve"];
  const gates = ["paper", "sqrt", "exact"];
  const comparisons = [2, 3, 4].flatMap((first) => gates.map((gate) => {
    const [ratio, verdict] = gate === "exact" ? [1.02, "no_difference"] : first === 4 && gate === "sqrt" ? [0.9, "smaller"] : [1.2 + first / 10, "larger"];
    return pair(`curve, gate = ${gate}, kept = 3`, `imm, confirm = ${first}`, ratio, verdict);
  }));
  const [found] = trialVerdict({ metrics: [metric("imm", 100), metric("curve", 130)], comparisons, labels: trackers });
  assert.deepEqual([found.kind, found.label, found.better, found.of], ["somewhere", "imm", 5, 9]);
  assert.deepEqual([found.most.value, found.at], [1.6, "gate = paper (curve), kept = 3 (curve), confirm = 4"]);
  assert.deepEqual(found.even, { at: "gate = exact (curve)", more: 0, count: 3, of: 9 });
  assert.deepEqual(found.worse, { at: "gate = sqrt (curve), kept = 3 (curve), confirm = 4", more: 0, count: 1, of: 9 });
});

test("of several rivals in a sweep the nearest is told by conditions, the others by counts", () => {
  const rows = (next, ratios) => ratios.map((ratio, i) => pair(next, "a", ratio, ratio > 1.1 ? "larger" : "no_difference", { "scenario.x": i }));
  const found = trialVerdict({ metrics: [metric("a", 100)], comparisons: [...rows("b", [1.05, 1.5]), ...rows("c", [1.08, 1.9])], labels: ["a", "b", "c"] });
  assert.deepEqual(found.map((one) => [one.next, one.even.at, one.even.count]), [["b", "x = 0", 1], ["c", "", 1]]);
});

test("places: what no few conditions hold is counted", () => {
  const all = [1, 2, 3, 4, 5, 6].flatMap((a) => [1, 2, 3, 4, 5, 6].map((b) => [`a = ${a}`, `b = ${b}`]));
  const where = (keep) => placesOf(all.filter(([a, b]) => keep(Number(a.slice(4)), Number(b.slice(4)))), all);
  assert.equal(where(() => false), null);
  assert.deepEqual(where((a) => a > 4), { at: "a = 5, 6", more: 0, count: 12, of: 36 });
  assert.deepEqual(where((a, b) => a === 1 || b === 2), { at: "a = 1; b = 2", more: 0, count: 11, of: 36 });
  assert.deepEqual(where((a, b) => a === b), { at: "", more: 6, count: 6, of: 36 });
  assert.deepEqual(where((a, b) => a === 1 || (a === b && a > 2)), { at: "a = 1", more: 4, count: 10, of: 36 });
  assert.deepEqual(where((a) => a < 6), { at: "a = 1, 2, 3, 4", more: 6, count: 30, of: 36 });
});

test("one algorithm with swept settings: the best of them, and those as good", () => {
  const names = [10, 100].map((v) => `rdfv, sigma_altitude_m = ${v}`);
  const metrics = [10, 100].map((v) => metric("rdfv", 100 + v, { "rdfv.sigma_altitude_m": v }));
  const found = trialVerdict({ metrics, comparisons: [pair(names[0], names[1], 0.9, "no_difference")], labels: ["rdfv"] });
  assert.equal(found[0].kind, "alone");
  assert.deepEqual([found[1].kind, found[1].at, found[1].even], ["setting", "sigma_altitude_m = 10", { at: "sigma_altitude_m = 100", more: 0, count: 1, of: 1 }]);
  assert.ok(Math.abs(found[1].most.value - 1 / 0.9) < 1e-12);
});

test("honesty goes by leg, and the value farthest from 1 counts", () => {
  const ratio = (segment, value) => ({ metric: "actual_over_claimed", label: "rdfv", segment, target: "", value });
  const found = trialVerdict({ metrics: [metric("rdfv", 100), ratio("", 1.1), ratio("straight", 0.95), ratio("turn", 1.1), ratio("turn", 1.4), ratio("far", 0.5)], comparisons: [], labels: ["rdfv"] });
  const honesty = found.find((one) => one.kind === "honesty");
  assert.deepEqual(honesty.legs, [{ name: "straight", ratio: 0.95, word: "honest" }, { name: "turn", ratio: 1.4, word: "small" }, { name: "far", ratio: 0.5, word: "large" }]);
});

test("errors over fewer marks are not those of the others, and that is said", () => {
  const share = (label, value, segment = "") => ({ metric: "answered_share", label, segment, target: "", value });
  const comparisons = [pair("rdf", "rdfv", 1.9, "larger")];
  const of = (...shares) => trialVerdict({ metrics: [metric("rdf", 190), metric("rdfv", 100), ...shares], comparisons, labels }).find((one) => one.kind === "coverage");
  assert.deepEqual(of(share("rdf", 0.97), share("rdfv", 0.61), share("rdf", 0.1, "end")), { kind: "coverage", label: "rdf", share: 0.97, best: "rdfv", bestShare: 0.61 });
  assert.equal(of(share("rdf", 0.97), share("rdfv", 0.96)), undefined);
  assert.equal(of(), undefined);
});

test("values of one name stand under it", () => {
  assert.equal(joined(["a = 1", "a = 2"]), "a = 1, 2");
  assert.equal(joined(["a = 1, b = 2", "a = 2, b = 2"]), "a = 1, b = 2; a = 2, b = 2");
  assert.equal(joined(["a = 1", "b = 2"]), "a = 1; b = 2");
  assert.equal(joined(["a = 1"]), "a = 1");
});

test("one target alone, no truth, and labels that begin alike", () => {
  const metrics = [metric("rdf", 10, { target: "A" }), metric("rdfv", 20, { target: "A" })];
  assert.equal(trialVerdict({ metrics, comparisons: [pair("rdf", "rdfv", 0.5, "smaller", { target: "A" })], labels, target: "A" })[0].label, "rdf");
  assert.equal(trialVerdict({ metrics, comparisons: [], labels })[0].kind, "no_truth");
  assert.equal(ownerOf("rdf, paper, q = 1", ["rdf", "rdf, paper"]), "rdf, paper");
});
