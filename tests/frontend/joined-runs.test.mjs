// Runs over several recordings: which they are, where a row stands, and how the run is asked for again.

import assert from "node:assert/strict";
import { test } from "node:test";

import { againRoute, placeOf, recordingsOf, requestOf } from "../../frontend/js/runs.js";

const one = { id: "r", source: { recording_id: "a" }, algorithms: [{ name: "x" }], tags: [], label: "" };
const two = { ...one, source: { recording_ids: ["a", "b"], first_rows: [1, 101], name: "a + b" } };

test("a row belongs to the recording whose rows it is numbered among", () => {
  assert.deepEqual(placeOf(two, 1), { recording: "a", row: 1 });
  assert.deepEqual(placeOf(two, 100), { recording: "a", row: 100 });
  assert.deepEqual(placeOf(two, 101), { recording: "b", row: 1 });
  assert.deepEqual(placeOf(one, 250), { recording: "a", row: 250 });
  assert.equal(placeOf(two, null), null);
  assert.equal(placeOf({ ...one, source: { scenario: {} } }, 3), null);
});

test("the run is asked for again with all its recordings", () => {
  assert.deepEqual(recordingsOf(two), ["a", "b"]);
  assert.deepEqual(requestOf(two), { recording_ids: ["a", "b"], algorithms: [{ name: "x" }] });
  assert.deepEqual(requestOf(one), { recording_id: "a", algorithms: [{ name: "x" }] });
  assert.match(againRoute(two), /recording=a&recording=b/);
});
