// What the columns of a file mean: from a suggestion or options, and back.

import assert from "node:assert/strict";
import test from "node:test";
import { Meanings } from "../../frontend/js/meanings.js";

const natives = {
  toa_marks: [{ name: "time_s", units: ["s", "ms"] }, { name: "toa_<station>_ns", units: ["ns", "us"] }, { name: "altitude_m", units: ["m", "ft"] }],
  polar_plots: [{ name: "time_s", units: ["s", "ms"] }, { name: "range_m", units: ["m", "NM"] }, { name: "azimuth_deg", units: ["deg", "rad"] }, { name: "east_m", units: ["m"] }],
};
const preview = (columns, suggestion, more = {}) => ({ format: null, columns, rows: [], suggestion, trial: null, error: null, native_columns: natives, ...more });

test("a suggestion becomes the same options when it is taken as it is", () => {
  const mapping = { time_s: { column: "ToD", unit: "ms" }, range_m: { column: "Rho", unit: "NM" }, azimuth_deg: { column: "Theta", unit: null } };
  const found = Meanings.of(preview(["ToD", "Rho", "Theta", "x"], { kind: "polar_plots", mapping }), {});
  assert.deepEqual(found.options(), {
    kind: "polar_plots", where: {},
    mapping: { time_s: { column: "ToD", unit: "ms" }, range_m: { column: "Rho", unit: "NM" }, azimuth_deg: { column: "Theta" } },
  });
});

test("stations of receptions", () => {
  const found = Meanings.of(preview(["t", "rx1"], { kind: "toa_marks", mapping: { time_s: { column: "t" }, toa_1_ns: { column: "rx1", unit: "us" } } }), {});
  const reception = found.columns[1];
  assert.equal(Meanings.isReception(reception), true);
  reception.station = "North";
  assert.deepEqual(found.options().mapping.toa_North_ns, { column: "rx1", unit: "us" });
});

test("native columns need no mapping, but may have another unit, and cannot be left out", () => {
  const found = Meanings.of(preview(["time_s", "toa_A_ns", "altitude_m"], { kind: "toa_marks", mapping: {} }), {});
  assert.deepEqual(found.options().mapping, {});
  found.columns[2].unit = "ft";
  assert.deepEqual(found.options().mapping, { altitude_m: { column: "altitude_m", unit: "ft" } });
  assert.deepEqual(found.offered(found.columns[2]), ["altitude_m"]);
});

test("options win over the suggestion, also as plain names, with filter and difference", () => {
  const options = { kind: "polar_plots", mapping: { east_m: { column: "e", minus: "own" }, time_s: "t" }, where: { scan: 3 } };
  const found = Meanings.of(preview(["t", "e", "own"], { kind: "toa_marks", mapping: {} }), options);
  assert.deepEqual(found.options(), { kind: "polar_plots", mapping: { time_s: { column: "t" }, east_m: { column: "e", minus: "own" } }, where: { scan: "3" } });
});

test("two columns cannot mean the same, and another kind keeps what it knows", () => {
  const found = Meanings.of(preview(["a", "b"], { kind: "polar_plots", mapping: { time_s: { column: "a" }, range_m: { column: "b" } } }), {});
  found.setMeaning(found.columns[1], "time_s");
  assert.deepEqual(found.repeated(), ["time_s"]);
  found.setMeaning(found.columns[1], "range_m");
  found.setKind("toa_marks");
  assert.deepEqual(found.columns.map((one) => one.means), ["time_s", ""]);
});
