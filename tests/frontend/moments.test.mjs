import assert from "node:assert/strict";
import test from "node:test";
import { CursorBus } from "../../frontend/js/cursor.js";
import { Moments } from "../../frontend/js/moments.js";

const series = (label, x, y, rows, more = {}) => ({ type: "scatter", mode: "markers", x, y, customdata: rows, meta: { role: "series", label }, ...more });

test("each curve gives its point nearest to the instant, and none from far away", () => {
  const moments = new Moments([
    series("a", [0, 10, 20, 30], [1, 2, 3, 4], [1, 2, 3, 4], { mode: "lines" }),
    series("b", [0, 10, 300], [5, 6, 7], [1, 2, 9]),
    series("b", [12], [8], [5]),
    { type: "scatter", x: [0, 300], y: [1, 1], meta: { role: "bound" } },
    series("c", [10], [9], [2], { visible: false }),
  ], true);
  assert.deepEqual(moments.span, [0, 300]);
  assert.deepEqual(moments.at(10).map((point) => point.y), [2, 6], "of marks of one entry only the nearest");
  assert.deepEqual(moments.at(12).map((point) => point.y), [2, 8]);
  assert.deepEqual(moments.at(100).map((point) => point.y), []);
});

test("a row decides between marks of one instant; gaps and unused marks are not invented", () => {
  const plan = new Moments([
    series("a", [1, 2, NaN], [3, 4, 5], [7, 8, 9], { text: ["5", "5", "6"] }),
    { ...series("a", [1], [1], [9]), text: ["6"], meta: { role: "rejected", label: "a" } },
  ], false);
  assert.equal(plan.at(5, 8)[0].x, 2);
  assert.equal(plan.at(5, 7)[0].x, 1);
  assert.deepEqual(plan.at(5.5).map((point) => point.trace.meta.role), ["series"]);
  assert.deepEqual(plan.at(6).map((point) => point.trace.meta.role), ["rejected"]);
});

test("steps go from mark to mark and stop at the ends", () => {
  const moments = new Moments([series("a", [0, 10, 20], [1, 1, 1], [1, 2, 3]), series("b", [10], [1], [4])], true);
  assert.deepEqual(moments.marks.map((mark) => mark.row), [1, 2, 4, 3]);
  assert.equal(moments.step(null, null, 1).row, 1);
  assert.equal(moments.step(10, 2, 1).row, 4);
  assert.equal(moments.step(10, 2, -1).row, 1);
  assert.equal(moments.step(15, null, 1).row, 3);
  assert.equal(moments.step(15, null, -1).row, 4);
  assert.equal(moments.step(20, 3, 1).row, 3);
  assert.equal(moments.snap(14).row, 4);
  assert.equal(moments.snap(16).row, 3);
  assert.equal(new Moments([], true).step(null, null, 1), null);
});

test("a locked cursor moves only by another lock", () => {
  const bus = new CursorBus();
  let changes = 0;
  bus.addEventListener("change", () => { changes += 1; });
  bus.look(1, { row: 4 });
  bus.look(1, { row: 4 });
  bus.look(2, { lock: true });
  bus.look(3);
  assert.deepEqual([bus.now.time, bus.now.locked, changes], [2, true, 2]);
  bus.release();
  bus.release();
  assert.deepEqual([bus.now.time, changes], [null, 3]);
});
