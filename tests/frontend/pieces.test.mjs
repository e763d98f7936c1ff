import assert from "node:assert/strict";
import test from "node:test";
import { describePoints } from "../../frontend/js/figure.js";
import { Moments } from "../../frontend/js/moments.js";
import { pieceAt, pieceName } from "../../frontend/js/pieces.js";

const line = (x, pieces, more = {}) => ({ type: "scatter", mode: "lines", name: "a", x, y: x, text: x, customdata: x.map((_, i) => i + 1), meta: { role: "series", label: "a", pieces }, ...more });

test("a point is of the piece between two gaps", () => {
  const trace = line([1, 2, NaN, 3, NaN, NaN, 5, 6, 7], ["one", "two", "three"]);
  assert.deepEqual([0, 1, 3, 6, 8].map((at) => pieceAt(trace, at)), [
    { number: 0, from: 0, to: 2 }, { number: 0, from: 0, to: 2 }, { number: 1, from: 3, to: 4 }, { number: 2, from: 6, to: 9 }, { number: 2, from: 6, to: 9 },
  ]);
  assert.equal(pieceAt(trace, 2), null, "a gap is of none");
  assert.deepEqual(pieceAt(line([NaN, 4, 5, NaN, 6], ["one", "two"]), 4), { number: 1, from: 4, to: 5 });
  assert.equal(pieceAt(line([1, 2], undefined), 0), null);
});

test("a piece is called by its target or its track", () => {
  const trace = line([1, NaN, 2, NaN, 3], ["flight 7", 12, -1]);
  assert.equal(pieceName(trace, 0), "flight 7");
  assert.match(pieceName(trace, 1), /12/);
  assert.equal(pieceName(trace, 2), "");
  assert.equal(pieceName(trace, 3), "");
});

test("a point at an instant knows its place in the line, and the strip its target", () => {
  const trace = line([1, 2, NaN, 3, 4], ["flight 1", "flight 2"]);
  const [point] = new Moments([trace], false).at(3, 4);
  assert.equal(point.at, 3);
  const layout = { xaxis: { title: { text: "East, km" } }, yaxis: { title: { text: "North, km" } } };
  assert.deepEqual(describePoints([{ ...point, of: "flight 2" }], layout, 3).map((part) => part.name).at(-1), "a, flight 2");
  assert.deepEqual(describePoints([point], layout, 3).map((part) => part.name).at(-1), "a");
});
