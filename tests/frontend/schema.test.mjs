import assert from "node:assert/strict";
import test from "node:test";
import { fieldsOf, placeErrors, placeholderOf, rangeOf, readField } from "../../frontend/js/schema.js";

const SCHEMA = {
  $defs: { Start: { type: "object", properties: { mode: { type: "string" } } } },
  properties: {
    start: { $ref: "#/$defs/Start", group: "start", default: { mode: "auto", state: null } },
    sigma_toa_ns: {
      anyOf: [{ type: "number", exclusiveMinimum: 0, maximum: 1e6 }, { type: "null" }], title: "Time-of-arrival error", unit: "ns", symbol: "σ_n",
      group: "measurement", default: null, from_site: "sigma_toa_ns", fallback: 10,
    },
    history: { type: "integer", minimum: 1, title: "History", default: 5, group: "association" },
    process_noise: { anyOf: [{ enum: ["paper", "white"], type: "string" }, { type: "null" }], choices: { paper: "as printed", white: "white jerk" }, default: null, group: "motion" },
    smooth: { type: "boolean", default: false, group: "output", advanced: true },
  },
};
const FIELDS = Object.fromEntries(fieldsOf(SCHEMA).map((field) => [field.name, field]));

test("fields come group by group with their types", () => {
  assert.deepEqual(fieldsOf(SCHEMA).map((field) => [field.name, field.type]), [
    ["sigma_toa_ns", "number"], ["process_noise", "choice"], ["history", "integer"], ["start", "json"], ["smooth", "boolean"],
  ]);
  assert.equal(FIELDS.sigma_toa_ns.nullable, true);
  assert.equal(FIELDS.start.title, "Start");
  assert.deepEqual(FIELDS.process_noise.choices[1], { value: "white", meaning: "white jerk" });
});

test("a share is read to its last digit, which is no unit", () => {
  const [field] = fieldsOf({ properties: { share: { type: "number", unit: "1", minimum: 0, maximum: 1, default: 0.9, title: "Share" } } });
  assert.equal(field.unit, "");
  for (const [text, value] of [["0.91", 0.91], ["1", 1], ["0.01", 0.01]]) assert.deepEqual(readField(field, text), { value });
});

test("an empty field shows the site's value, else the fallback, else the default", () => {
  const field = FIELDS.sigma_toa_ns;
  assert.deepEqual(placeholderOf(field, null), { text: "10", source: "fallback" });
  assert.deepEqual(placeholderOf(field, { sigma_toa_ns: 90 }), { text: "90", source: "site" });
  assert.deepEqual(placeholderOf(field, { stations: [{ name: "A", sigma_toa_ns: 40 }, { name: "B", sigma_toa_ns: 90 }] }), { text: "40…90", source: "site" });
  assert.deepEqual(placeholderOf(FIELDS.history, null), { text: "5", source: "default" });
});

test("typed text becomes a value or a reason", () => {
  const field = FIELDS.sigma_toa_ns;
  assert.deepEqual(readField(field, ""), {});
  assert.deepEqual(readField(field, "1e2 ns"), { value: 100 });
  assert.deepEqual(readField(field, "0,5"), { value: 0.5 });
  assert.deepEqual(readField(field, "0"), { error: "too_small" });
  assert.deepEqual(readField(field, "1e6"), { value: 1e6 });
  assert.deepEqual(readField(field, "1000001"), { error: "too_large" });
  assert.deepEqual(readField(field, "ten"), { error: "not_a_number" });
  assert.deepEqual(readField(FIELDS.history, "1"), { value: 1 });
  assert.deepEqual(readField(FIELDS.history, "1.5"), { error: "not_whole" });
  assert.deepEqual(readField(FIELDS.smooth, "true"), { value: true });
  assert.deepEqual(readField(FIELDS.process_noise, "white"), { value: "white" });
  assert.deepEqual(readField(FIELDS.start, '{"mode": "auto"}'), { value: { mode: "auto" } });
  assert.deepEqual(readField(FIELDS.start, "{"), { error: "not_json" });
});

test("ranges are written with open and closed ends", () => {
  assert.equal(rangeOf(FIELDS.sigma_toa_ns), "> 0 … 1\u202f000\u202f000");
  assert.equal(rangeOf(FIELDS.history), "≥ 1");
  assert.equal(rangeOf(FIELDS.smooth), "");
});

test("errors of the server find their fields", () => {
  const { entries, rest } = placeErrors([
    { pointer: "/algorithms/1/parameters/sigma_toa_ns", detail: "too small" },
    { pointer: "/algorithms/1/label", detail: "taken" },
    { pointer: "/algorithms/0", detail: "wrong" },
    { pointer: "/site", detail: "missing" },
  ]);
  assert.equal(entries.get(1).get("sigma_toa_ns"), "too small");
  assert.equal(entries.get(1).get("label"), "taken");
  assert.equal(entries.get(0).get(""), "wrong");
  assert.deepEqual(rest.map((error) => error.pointer), ["/site"]);
});
