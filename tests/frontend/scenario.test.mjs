import assert from "node:assert/strict";
import test from "node:test";
import { changedOf, completed, defaultsOf, nextRow, parseNumbers, placesOf, shapeOf, sweptValues } from "../../frontend/js/scenario.js";

const DEFINITIONS = {
  Segment: { type: "object", properties: { duration_s: { type: "number", exclusiveMinimum: 0 }, turn_rate_deg_s: { type: "number", default: 0 } } },
  Target: { type: "object", properties: { name: { type: "string", default: "" }, segments: { type: "array", items: { $ref: "#/$defs/Segment" }, default: [] } } },
  Origin: { type: "object", properties: { latitude_deg: { type: "number" } } },
};
const SCHEMA = {
  $defs: DEFINITIONS,
  properties: {
    sigma: { type: "number", default: 10 },
    targets: { type: "array", items: { $ref: "#/$defs/Target" }, default: [{ name: "A", segments: [{ duration_s: 9, turn_rate_deg_s: 0 }] }] },
    origin: { anyOf: [{ $ref: "#/$defs/Origin" }, { type: "null" }], default: null },
    shares: { type: "array", items: { type: "number" }, default: [1, 1] },
  },
};

test("each part of a scenario has its shape", () => {
  assert.deepEqual(Object.entries(SCHEMA.properties).map(([, one]) => shapeOf(one, DEFINITIONS).kind), ["scalar", "rows", "object", "numbers"]);
  assert.deepEqual(Object.keys(shapeOf(SCHEMA.properties.targets, DEFINITIONS).properties), ["name", "segments"]);
});

test("only what differs from the preset is sent, and what a row leaves out is its default", () => {
  const values = defaultsOf(SCHEMA);
  assert.deepEqual(changedOf(values, SCHEMA), {});
  values.sigma = 20;
  values.targets[0].segments[0].turn_rate_deg_s = 1;
  assert.deepEqual(Object.keys(changedOf(values, SCHEMA)), ["sigma", "targets"]);
  const given = completed({ targets: [{ name: "A", segments: [{ duration_s: 9 }] }] }, SCHEMA.properties, DEFINITIONS);
  assert.equal(given.targets[0].segments[0].turn_rate_deg_s, 0);
  assert.deepEqual(changedOf(given, SCHEMA), {});
  assert.equal(SCHEMA.properties.targets.default[0].segments[0].turn_rate_deg_s, 0, "the schema is not touched");
});

test("a further row is like the last one but later, elsewhere, with a name of its own", () => {
  assert.deepEqual(nextRow(DEFINITIONS.Segment.properties, []), { duration_s: 60, turn_rate_deg_s: 0 });
  assert.deepEqual(nextRow({}, [{ time_s: 0, east_m: 5 }, { time_s: 30, east_m: 7 }]), { time_s: 60, east_m: 1007 });
  assert.deepEqual(nextRow({}, [{ start_s: 10, stop_s: 40 }]), { start_s: 40, stop_s: 70 });
  assert.deepEqual(nextRow({}, [{ name: "1" }, { name: "4" }, { name: "3" }]), { name: "5" });
  assert.deepEqual(nextRow({}, [{ name: "" }]), { name: "" });
});

test("numbers in one field may be divided by spaces, semicolons, or commas with a space", () => {
  assert.deepEqual(parseNumbers(" 0.9 0,45;1 "), [0.9, 0.45, 1]);
  assert.deepEqual(parseNumbers("0.9, 0.45, 1"), [0.9, 0.45, 1]);
  assert.deepEqual(parseNumbers(""), []);
  assert.equal(parseNumbers("0.9 x"), null);
});

test("swept values: a comma without a space behind it is decimal wherever something else separates", () => {
  for (const [text, values] of [
    ["10; 30; 100", [10, 30, 100]], ["0,5; 1,5", [0.5, 1.5]], ["0,5 1,5", [0.5, 1.5]], ["0,5, 1,5", [0.5, 1.5]], ["10, 30, 100", [10, 30, 100]],
    ["10,30,100", [10, 30, 100]], ["10 30", [10, 30]], ["1 000; 2 000", [1000, 2000]], ["paper, white", ["paper", "white"]], [" ", []],
  ]) assert.deepEqual(sweptValues(text), values, text);
});

test("errors of one place stand together, without the request's prefix", () => {
  const places = placesOf([{ pointer: "/parameters/a/0", detail: "One." }, { pointer: "/parameters/a/0", detail: "Two." }, { pointer: "/preset", detail: "Three." }]);
  assert.deepEqual([...places], [["/a/0", "One. Two."], ["/preset", "Three."]]);
});
