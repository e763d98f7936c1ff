import assert from "node:assert/strict";
import test from "node:test";
import { CROWD, dotOf, lengthOf, pixelsOf, withDots } from "../../frontend/js/dots.js";
import { dressFigure } from "../../frontend/js/figure.js";
import { inTurn } from "../../frontend/js/turns.js";

const encoded = (values) => ({ dtype: "f4", bdata: Buffer.from(new Float32Array(values).buffer).toString("base64") });
const marks = (count, more = {}) => {
  const values = encoded(Array.from({ length: count }, (_, i) => i));
  return { type: "scatter", mode: "markers", x: values, y: values, marker: { color: "#0072B2", size: 4, opacity: 0.3 }, meta: { role: "series", label: "a" }, ...more };
};

test("arrays are counted without decoding them", () => {
  for (const count of [0, 1, 2, 3, 4, 1000]) assert.equal(lengthOf(encoded(Array(count).fill(0))), count);
  assert.equal(lengthOf({ dtype: "i1", bdata: Buffer.from(new Int8Array(7).buffer).toString("base64") }), 7);
  assert.equal(lengthOf([1, 2, 3]), 3);
  assert.equal(lengthOf(undefined), 0);
});

test("a crowd of like markers is painted, anything else stays with the drawing", () => {
  assert.deepEqual(dotOf(marks(CROWD + 1)), { symbol: "circle", size: 4, colour: "#0072B2", opacity: 0.3, stroke: 0 });
  assert.equal(dotOf(marks(CROWD)), null);
  assert.equal(dotOf(marks(CROWD + 1, { mode: "lines" })), null);
  assert.equal(dotOf(marks(CROWD + 1, { mode: "markers+text" })), null);
  assert.equal(dotOf(marks(CROWD + 1, { marker: { color: "red", size: [1, 2] } })), null);
  assert.equal(dotOf(marks(CROWD + 1, { marker: { color: "red", symbol: "star" } })), null);
  assert.equal(dotOf(marks(CROWD + 1, { y: Array(CROWD + 1).fill("station") })), null);
  const hollow = dotOf(marks(CROWD + 1, { marker: { color: "red", symbol: "square-open", size: 7, line: { color: "red", width: 1.2 } } }));
  assert.deepEqual(hollow, { symbol: "square", size: 7, colour: "red", opacity: 1, stroke: 1.2 });
});

test("what is painted keeps its line and its points, in the theme's colour", () => {
  assert.equal(withDots(marks(CROWD + 1)).mode, "none");
  const curve = withDots(marks(CROWD + 1, { mode: "lines+markers" }));
  assert.equal(curve.mode, "lines");
  assert.equal(lengthOf(curve.x), CROWD + 1);
  const look = { colours: { text: "t", muted: "m", line: "l", grid: "g", surface: "s", measurement: "rgb(1, 2, 3)" }, dark: true, hidden: new Set(), font: "f", narrow: false };
  const figure = { data: [marks(CROWD + 1, { type: "scattergl", meta: { role: "measurement", label: null } })], layout: { xaxis: {}, yaxis: {} } };
  assert.equal(dressFigure(figure, look).data[0].meta.dot.colour, "rgba(1, 2, 3, 0.5)");
  const image = dressFigure(figure, { ...look, dots: false }).data[0];
  assert.equal(image.mode, "markers", "an image has its markers drawn");
  assert.equal(image.meta.dot, undefined);
});

test("a crowd has its marker in a legend that is asked for", () => {
  const look = { colours: { text: "t", muted: "m", line: "l", grid: "g", surface: "s", measurement: "rgb(1, 2, 3)" }, dark: false, hidden: new Set(), font: "f", narrow: false };
  const figure = { data: [marks(CROWD + 1, { name: "ca_30" }), marks(3, { name: "cv_1" })], layout: { xaxis: {}, yaxis: {}, meta: { legend: true } } };
  const { data } = dressFigure(figure, look);
  assert.deepEqual(data.map((trace) => [trace.name, trace.showlegend, trace.mode]), [["ca_30", false, "none"], ["cv_1", true, "markers"], ["ca_30", true, "markers"]]);
  assert.deepEqual([data[2].x, data[2].marker.color], [[null], "#0072B2"]);
  assert.equal(dressFigure(figure, { ...look, dots: false }).data.length, 2);
});

// An axis as Plotly keeps it: its scale follows its range only at the end of a drag.
const axis = (id, length, range, scaled = range) => {
  const [from, to] = id === "y" ? [scaled[1], scaled[0]] : scaled;
  const l2p = (value) => ((value - from) / (to - from)) * length;
  return { _id: id, _length: length, range, r2l: Number, l2p, d2p: l2p };
};

test("dots follow the axes, also while these are dragged", () => {
  const across = pixelsOf(axis("x", 400, [10, 20]));
  assert.deepEqual([across(10), across(15), across(20)], [0, 200, 400]);
  const down = pixelsOf(axis("y", 100, [0, 1]));
  assert.deepEqual([down(1), down(0)], [0, 100]);
  const dragged = pixelsOf(axis("x", 400, [12, 22], [10, 20]));
  assert.deepEqual([dragged(12), dragged(22)], [0, 400]);
  const lifted = pixelsOf(axis("y", 100, [0.5, 1.5], [0, 1]));
  assert.deepEqual([lifted(1.5), lifted(0.5)], [0, 100]);
});

test("pieces of work come one after another, each in a task of its own", async () => {
  const seen = [];
  const first = inTurn(() => {
    seen.push("first");
    setTimeout(() => seen.push("the page"));
    throw new Error("broken");
  });
  const second = inTurn(async () => { seen.push("second"); return 2; });
  await assert.rejects(first, /broken/);
  assert.equal(await second, 2);
  assert.deepEqual(seen, ["first", "the page", "second"]);
});
