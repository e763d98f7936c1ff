import assert from "node:assert/strict";
import test from "node:test";
import { looksTransposed, parseTable, resized, rowSums, transposed, wrongRows } from "../../frontend/js/matrix.js";
import { fieldsOf, readField } from "../../frontend/js/schema.js";

const COLUMNS_SUM = [[0.9, 0.3], [0.1, 0.7]];

test("sums of rows, and which are wrong", () => {
  assert.deepEqual(rowSums([[0.5, 0.5], [1, null]]), [1, null]);
  assert.deepEqual(wrongRows([[0.333, 0.667], [0.5, 0.6], [null, 1]], 1), [1]);
  assert.deepEqual(wrongRows([[1 / 3, 2 / 3], [0.1 + 0.2, 0.7]], 1), []);
});

test("exchanged rows and columns are recognised, and only they", () => {
  assert.equal(looksTransposed(COLUMNS_SUM, 1), true);
  assert.equal(looksTransposed(transposed(COLUMNS_SUM), 1), false);
  assert.equal(looksTransposed([[0.5, 0.4], [0.5, 0.5]], 1), false);
});

test("a matrix of another size keeps what it has; what is new changes nothing", () => {
  assert.deepEqual(resized([[0.9, 0.1], [0.2, 0.8]], 3), [[0.9, 0.1, 0], [0.2, 0.8, 0], [0, 0, 1]]);
  assert.deepEqual(resized([[0.9, 0.1], [0.2, 0.8]], 1), [[0.9]]);
});

test("tables from spreadsheets, MATLAB and Python", () => {
  const wanted = [[0.9, 0.1], [0.2, 0.8]];
  for (const text of ["0.9\t0.1\n0.2\t0.8", "0,9\t0,1\r\n0,2\t0,8\r\n", "[0.9 0.1; 0.2 0.8]", "[[0.9, 0.1], [0.2, 0.8]]"]) assert.deepEqual(parseTable(text), wanted, text);
  for (const text of ["", "0.9 0.1\n0.2", "a b\nc d"]) assert.equal(parseTable(text), null, text);
});

const SCHEMA = {
  $defs: { Model: { type: "object", properties: { kind: { enum: ["cv", "ca"], type: "string", default: "cv" }, sigma_mps2: { type: "number", minimum: 0, default: 1 } } } },
  properties: {
    models: { type: "array", items: { $ref: "#/$defs/Model" }, default: [{ kind: "cv", sigma_mps2: 0.05 }] },
    transition: { anyOf: [{ type: "array", items: { type: "array", items: { type: "number" } } }, { type: "null" }], default: null, labels_from: "models", row_sum: 1 },
    deep: { type: "array", items: { type: "object", properties: { inner: { type: "array", items: { type: "number" } } } } },
  },
};

test("lists with an editor of their own are told from those without", () => {
  const [models, transition, deep] = fieldsOf(SCHEMA);
  assert.deepEqual([models.type, transition.type, deep.type], ["rows", "matrix", "json"]);
  assert.deepEqual(Object.keys(models.rowSchema.properties), ["kind", "sigma_mps2"]);
  assert.deepEqual([transition.labelsFrom, transition.rowSum], ["models", 1]);
  assert.deepEqual(readField(transition, "[[0.9, 0.1], [0.2, 0.8]]"), { value: [[0.9, 0.1], [0.2, 0.8]] });
  assert.deepEqual(readField(transition, "[[0.9, 0.2], [0.2, 0.8]]"), { error: "row_sum" });
  assert.deepEqual(readField(transition, "[[0.9, null], [0.2, 0.8]]"), { error: "not_complete" });
});
