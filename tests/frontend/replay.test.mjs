import assert from "node:assert/strict";
import test from "node:test";

import { coming, latest, outline } from "../../frontend/js/replay.js";

test("of each track the newest estimate at the instant is shown, and none that is stale", () => {
  const vectors = { index: [0, 0, 0, 1, 0], t: [0, 5, 10, 5, -30], east: [], north: [], v_east: [], v_north: [], track: [1, 1, 1, 1, 2] };
  assert.deepEqual(latest(vectors, 7), [1, 3]);
  assert.deepEqual(latest(vectors, 10), [2, 3]);
  assert.deepEqual(latest(vectors, 100), []);
});

test("the gates are those of the scan that comes", () => {
  const gates = { index: [0, 0, 0], t: [5, 5, 10], east: [], north: [], major: [], minor: [], azimuth: [] };
  assert.deepEqual(coming(gates, 3), [0, 1]);
  assert.deepEqual(coming(gates, 5), [0, 1]);
  assert.deepEqual(coming(gates, 5.5), [2]);
  assert.deepEqual(coming(gates, 11), []);
});

test("the long axis of a gate points where its azimuth says, clockwise from north", () => {
  const gates = { index: [0], t: [0], east: [1000], north: [2000], major: [300], minor: [100], azimuth: [90] };
  const [first] = outline(gates, 0);
  assert.ok(Math.hypot(first[0] - 1300, first[1] - 2000) < 1e-6);
  const quarter = outline(gates, 0)[12];
  assert.ok(Math.hypot(quarter[0] - 1000, quarter[1] - 1900) < 1e-6);
  // An inner ellipse has the same middle and direction.
  const [inner] = outline(gates, 0, 0.5);
  assert.ok(Math.hypot(inner[0] - 1150, inner[1] - 2000) < 1e-6);
});
