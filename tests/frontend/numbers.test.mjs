import assert from "node:assert/strict";
import test from "node:test";
import { formatBounds, formatBytes, formatCount, formatDuration, formatExact, formatNumber, formatQuantity, formatShare, parseNumber } from "../../frontend/js/numbers.js";

test("numbers are read as people type them", () => {
  for (const [text, unit, value] of [
    ["100", "", 100], ["1e3", "", 1000], ["-2.5E-2", "", -0.025], ["0,5", "", 0.5], ["1 000", "", 1000], ["1\u202f000\u202f000,5", "", 1000000.5],
    [" 90 ns ", "ns", 90], ["90ns", "ns", 90], ["−3", "", -3], [".5", "", 0.5], ["5.", "", 5],
  ]) assert.equal(parseNumber(text, unit), value, text);
});

test("the digit by which schemas say that there is no unit is none that people type", () => {
  for (const [text, value] of [["0.91", 0.91], ["1", 1], ["0.01", 0.01], ["11", 11]]) assert.equal(parseNumber(text, "1"), value, text);
});

test("what is not exactly one number is refused", () => {
  for (const text of ["", "abc", "1,2,3", "1 2", "0x10", "Infinity", "NaN", "1e999", "90 m", "1,000.5", "--1", "1e"]) assert.equal(parseNumber(text, "ns"), null, text);
});

test("numbers keep three significant digits and thin spaces", () => {
  assert.equal(formatNumber(121.4), "121");
  assert.equal(formatNumber(0.012345), "0.0123");
  assert.equal(formatNumber(1234567), "1\u202f234\u202f567");
  assert.equal(formatNumber(-54.26), "−54.3");
  assert.equal(formatNumber(0), "0");
  assert.equal(formatNumber(null), "–");
  assert.equal(formatNumber(2.5e-7), "2.50e−7");
  assert.equal(formatCount(2986), "2986");
  assert.equal(formatCount(63212), "63\u202f212");
});

test("units scale with the quantity", () => {
  assert.equal(formatQuantity(12345, "m"), "12.3 km");
  assert.equal(formatQuantity(345, "m"), "345 m");
  // Bounds are in the unit of what they bound.
  assert.equal(formatBounds(0.777, 0.892, 0.843, "share"), "77.7…89.2");
  assert.equal(formatBounds(14100, 16300, 15200, "m"), "14.1…16.3");
  assert.equal(formatBounds(9100, 10300, 9700, "m"), "9100…10\u202f300");
  // Tracks are counted, not measured; a mean number of them is.
  assert.equal(formatQuantity(4, "1"), "4");
  assert.equal(formatQuantity(4.5, "1"), "4.50");
  assert.equal(formatQuantity(4, "m"), "4.00 m");
  assert.equal(formatShare(0.895), "89.5\u202f%");
  assert.equal(formatDuration(4.23), "4.2 s");
  assert.equal(formatDuration(125), "2 min 5 s");
  assert.equal(formatBytes(182733), "183 kB");
});

test("kept values are shown without binary noise and without absent parts", () => {
  assert.equal(formatExact(0.1 + 0.2), "0.3");
  assert.equal(formatExact({ mode: "auto", state: null }), '{"mode":"auto"}');
});
