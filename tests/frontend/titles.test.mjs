import assert from "node:assert/strict";
import test from "node:test";
import { titleSize } from "../../frontend/js/figure.js";

test("an upright title is as large as there is room for it", () => {
  const long = "Horizontal error (rms), m";
  assert.equal(titleSize(long, undefined, 12, 0), 12, "of an unknown chart nothing is known");
  assert.equal(titleSize(long, undefined, 12, 400), 12);
  const low = titleSize(long, undefined, 12, 200);
  assert.ok(low >= 9 && low < 12, String(low));
  assert.ok(low * 0.64 * long.length <= 200 - 48 + 24);
  // Below this nobody reads it.
  assert.equal(titleSize(long, undefined, 12, 60), 9);
  // Panels stand above each other.
  assert.equal(titleSize("Marks, %", [0.34, 0.62], 12, 600), 12);
  assert.ok(titleSize("Marks, %", [0.34, 0.62], 12, 220) < 12);
});
