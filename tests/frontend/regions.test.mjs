import assert from "node:assert/strict";
import test from "node:test";
import { polygonFault } from "../../frontend/js/polygon.js";
import { faultOf, numbersOf, pathsOf, placeIn, placeOf, viewOf } from "../../frontend/js/regions.js";
import { fieldsOf, placeErrors, readField, rulesOf } from "../../frontend/js/schema.js";

const REGION = {
  properties: {
    name: { type: "string", default: "" },
    corners: { type: "array", items: { type: "array", prefixItems: [{ type: "number" }, { type: "number" }] }, default: [] },
    lowest_up_m: { type: "number", default: -1e6 },
    highest_up_m: { type: "number", default: 1e6 },
    transition: { type: "array", items: { type: "array", items: { type: "number" } }, labels_from: "models", row_sum: 1 },
  },
};
const SCHEMA = { $defs: { Region: { type: "object", ...REGION } }, properties: { regions: { type: "array", items: { $ref: "#/$defs/Region" }, default: [] } } };
const RULES = rulesOf(REGION, 2);
const CALM = [[0.9, 0.1], [0.2, 0.8]];
const SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10]];

test("regions have an editor of their own, and their matrices the names of the models", () => {
  const [regions] = fieldsOf(SCHEMA);
  assert.deepEqual([regions.type, regions.labelsFrom], ["regions", "models"]);
  assert.deepEqual(fieldsOf(regions.rowSchema).map((one) => one.type), ["text", "points", "number", "number", "matrix"]);
  const whole = [{ transition: CALM }, { corners: SQUARE, transition: CALM }];
  assert.deepEqual(readField(regions, JSON.stringify(whole)), { value: whole });
  assert.deepEqual(readField(regions, JSON.stringify([{ corners: [[1, null]], transition: CALM }])), { error: "regions" });
});

test("the first fault is named with its region and its place", () => {
  const good = { corners: SQUARE, lowest_up_m: 0, highest_up_m: 10, transition: CALM };
  assert.equal(faultOf([good, { transition: CALM }], RULES), null);
  const found = (/** @type {any} */ wrong) => faultOf([good, { ...good, ...wrong }], RULES);
  assert.deepEqual(found({ corners: [[0, 0], [1, 0], [null, 3]] }), { region: 1, place: "corner", at: 2 });
  assert.deepEqual(found({ corners: [[0, 0], [1, 0]] }), { region: 1, place: "few" });
  assert.deepEqual(found({ corners: [[0, 0], [9, 9], [9, 0], [0, 9]] }), { region: 1, place: "crossing", edges: [[0, 1], [2, 3]] });
  assert.deepEqual(found({ highest_up_m: 0 }), { region: 1, place: "field", field: "highest_up_m" });
  assert.deepEqual(found({ lowest_up_m: null }), { region: 1, place: "field", field: "lowest_up_m" });
  assert.deepEqual(found({ transition: [[1]] }), { region: 1, place: "matrix" });
  assert.deepEqual(found({ transition: [[0.9, 0.1], [0.2, null]] }), { region: 1, place: "matrix" });
  assert.deepEqual(found({ transition: [[0.9, 0.1], [0.2, 0.7]] }), { region: 1, place: "matrix_rows", at: 1 });
});

test("a polygon is judged as the server judges it", () => {
  assert.equal(polygonFault(SQUARE), null);
  assert.equal(polygonFault([...SQUARE, SQUARE[0]]), null);
  assert.equal(polygonFault([[0, 0], [9, 0], [9, 9], [6, 1], [5, 9], [3, 1], [0, 9]]), null);
  assert.deepEqual(polygonFault([[1, 2], [3, 4], [1, 2]]), { place: "few" });
  assert.deepEqual(polygonFault([[1, 2]]), { place: "few" });
  assert.deepEqual(polygonFault([[0.1, 0.3], [0.2, 0.6], [0.3, 0.9]]), { place: "flat" });
  const edges = (/** @type {any} */ corners) => polygonFault(corners)?.edges;
  assert.deepEqual(edges([[0, 0], [4, 5], [9, -5], [9, 5]]), [[1, 2], [3, 0]]);
  assert.deepEqual(edges([[0, 0], [8, 0], [8, 4], [4, 0], [0, 4]]), [[0, 1], [2, 3]]);
  assert.deepEqual(edges([[0, 0], [9, 0], [4, 0], [4, 5]]), [[0, 1], [1, 2]]);
});

test("a new corner goes into the edge that it lengthens least", () => {
  assert.equal(placeOf([], 1, 1), 0);
  assert.equal(placeOf([[0, 0], [1, 1]], 5, 5), 2);
  assert.deepEqual([placeOf(SQUARE, 5, -1), placeOf(SQUARE, 11, 5), placeOf(SQUARE, 5, 11), placeOf(SQUARE, -1, 5)], [1, 2, 3, 4]);
});

test("the server names regions, corners and axes", () => {
  assert.deepEqual(placeIn("regions/1/corners/2/0"), { region: 1, field: "corners", corner: 2, axis: 0 });
  assert.deepEqual(placeIn("regions/0"), { region: 0, field: "", corner: null, axis: null });
  assert.deepEqual(placeIn("regions/0/transition/1"), { region: 0, field: "transition", corner: null, axis: null });
  const { entries } = placeErrors([{ pointer: "/algorithms/0/parameters/regions/1/corners/2/0", detail: "too far" }]);
  assert.deepEqual([...entries.get(0)], [["regions", "too far"], ["regions/1/corners/2/0", "too far"]]);
});

test("paths come from a drawn plan, in metres, the truth before plots", () => {
  const packed = { dtype: "f4", bdata: Buffer.from(new Float32Array([1.5, -2]).buffer).toString("base64") };
  assert.deepEqual(numbersOf(packed), [1.5, -2]);
  const figure = { data: [{ meta: { role: "measurement" }, x: [9], y: [9] }, { meta: { role: "truth" }, x: packed, y: [3, 4] }], layout: { xaxis: { title: { text: "East, km" } } } };
  assert.deepEqual(pathsOf(/** @type {any} */ (figure)), [{ line: true, east: [1500, -2000], north: [3000, 4000] }]);
  figure.data.pop();
  figure.layout.xaxis.title.text = "East, m";
  assert.deepEqual(pathsOf(/** @type {any} */ (figure)), [{ line: false, east: [9], north: [9] }]);
  assert.deepEqual(pathsOf(undefined), []);
});

test("everything lies inside the view, on one scale", () => {
  const { metres, east, north } = viewOf([{ east: [0, 1000, NaN], north: [0, 100, 5] }], 320, 240);
  assert.ok(east < 0 && east + 320 * metres > 1000 && north > 100 && north - 240 * metres < 0);
  assert.ok(viewOf([], 320, 240).metres > 0);
});
