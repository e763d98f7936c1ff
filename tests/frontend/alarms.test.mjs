import assert from "node:assert/strict";
import test from "node:test";
import { alarmsOf } from "../../frontend/js/alarms.js";
import { dressFigure } from "../../frontend/js/figure.js";

test("alarms are told once, with whose they are; other notes are none", () => {
  const alarm = { code: "registration_alarm", detail: "Radar east is turned.", count: 1 };
  const rival = { code: "registration_ambiguous", detail: "A shift would explain it.", count: 1 };
  const notes = {
    first: [{ code: "height_unknown", detail: "No height.", count: 3 }, alarm],
    second: [alarm, rival, { code: "suspect_azimuth_unit", detail: "Radians.", count: 1 }],
  };
  assert.deepEqual(alarmsOf(notes), [
    { detail: alarm.detail, labels: ["first", "second"] },
    { detail: rival.detail, labels: ["second"] },
    { detail: "Radians.", labels: ["second"] },
  ]);
  assert.deepEqual(alarmsOf(null), []);
  assert.deepEqual(alarmsOf({ a: [{ code: "unusable_plots", detail: "x", count: 1 }] }), []);
});

test("a chart that asks for it gets a legend of its curves", () => {
  const look = { colours: { text: "t", muted: "m", line: "l", grid: "g", surface: "s", measurement: "rgb(1,1,1)" }, dark: false, hidden: new Set(), font: "f", narrow: false };
  const curve = (name, more = {}) => ({ type: "scatter", name, x: [1], y: [1], meta: { role: "interval", label: null, index: null }, ...more });
  const figure = (legend) => ({ data: [curve("lin"), curve("quiet", { showlegend: false })], layout: { meta: { notes: [], ...(legend ? { legend: true } : {}) } } });
  const asked = dressFigure(figure(true), look);
  assert.equal(asked.layout.showlegend, true);
  assert.deepEqual(asked.data.map((trace) => trace.showlegend), [true, false]);
  const plain = dressFigure(figure(false), look);
  assert.equal(plain.layout.showlegend, false);
  assert.deepEqual(plain.data.map((trace) => trace.showlegend), [false, false]);
});
