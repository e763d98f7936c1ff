import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import test from "node:test";
import { parseCsv } from "../../frontend/js/csv.js";
import { describePoints, dressFigure, fewerTicks, isOverTime, rowOf, splitTitle, withAlpha } from "../../frontend/js/figure.js";
import { parseRoute, routeTo } from "../../frontend/js/router.js";
import { curlSnippet, pythonSnippet, shellQuote } from "../../frontend/js/snippets.js";
import { guessRoles } from "../../frontend/js/upload.js";

test("addresses go there and back", () => {
  const hash = routeTo(["runs", "a/b %"], { tab: "log", hide: ["x y", "z&"], none: null });
  const route = parseRoute(hash);
  assert.deepEqual(route.path, ["runs", "a/b %"]);
  assert.equal(route.query.get("tab"), "log");
  assert.deepEqual(route.query.getAll("hide"), ["x y", "z&"]);
  assert.equal(route.query.has("none"), false);
  assert.deepEqual(parseRoute("").path, ["runs"]);
  assert.deepEqual(parseRoute("#/runs/100%").path, ["runs", "100%"]);
});

test("CSV with quotes, line ends of Windows and a byte order mark is read", () => {
  const { columns, rows } = parseCsv('\ufeffa,b\r\n1,"x, ""y""\nz"\r\n2,\r\n');
  assert.deepEqual(columns, ["a", "b"]);
  assert.deepEqual(rows, [["1", 'x, "y"\nz'], ["2", ""]]);
  assert.equal(parseCsv("a\n1\n2\n3\n", 2).rows.length, 2);
  assert.equal(parseCsv("a\n1\n2\n3\n", 2).more, true);
});

test("dropped files find their roles", () => {
  assert.deepEqual(guessRoles(["sensors.csv"]), ["file"]);
  assert.deepEqual(guessRoles(["set_1.csv", "sensors.csv"]), ["file", "site"]);
  assert.deepEqual(guessRoles(["sample_site.json", "sample_marks.csv", "truth.csv"]), ["site", "file", "truth"]);
  assert.deepEqual(guessRoles(["a.csv", "b.csv"]), ["file", "file"]);
});

test("a label cannot break out of a shell command or of Python", () => {
  const label = `it's "here" $(rm) \\ \n`;
  const request = { recording_id: "r", algorithms: [{ name: "rdf", label, parameters: { smooth: true, x: null } }] };
  assert.equal(shellQuote("it's"), `'it'\\''s'`);
  assert.match(curlSnippet("http://localhost:1/", request), /'\\''s/);
  const python = pythonSnippet("http://localhost:1/", request);
  assert.match(python, /"smooth": True, "x": None/);
  assert.match(python, /it's \\"here\\"/);
});

const LOOK = { colours: { text: "rgb(1, 2, 3)", muted: "m", line: "l", grid: "g", surface: "s", measurement: "me" }, dark: true, hidden: new Set(["b"]), font: "f", narrow: false };

test("figures take the theme's colours by role and hide what is hidden", () => {
  const figure = {
    data: [
      { type: "scatter", name: "truth", line: { color: "#000" }, meta: { role: "truth", label: null } },
      { type: "scatter", name: "a", line: { color: "#0072B2" }, hovertemplate: "x", meta: { role: "series", label: "a" } },
      { type: "scatter", name: "b", line: { color: "#D55E00" }, meta: { role: "series", label: "b" } },
      { type: "scattergl", name: "a", marker: { color: "#0072B2" }, meta: { role: "series", label: "a" } },
      { type: "bar", name: "n", marker: { color: "#f0f4f8" }, meta: { role: "measurement", label: null } },
    ],
    layout: { title: { text: "T" }, xaxis: { title: { text: "Time, s" } }, yaxis: { title: { text: "Error, m" } } },
  };
  const { data, layout } = dressFigure(figure, LOOK);
  assert.equal(data[0].line.color, "rgb(1, 2, 3)");
  assert.equal(data[1].line.color, "#0072B2");
  assert.equal(data[1].hovertemplate, undefined);
  assert.equal(data[1].hoverinfo, "none");
  assert.equal(data[2].visible, false);
  assert.equal(data[3].type, "scatter", "the policy forbids what WebGL needs");
  assert.notEqual(data[4].marker.color, "#f0f4f8");
  assert.equal(layout.title, undefined);
  assert.equal(layout.hovermode, false, "the page finds the instant itself");
  assert.equal(figure.data[1].hovertemplate, "x", "the fetched figure stays as it was");
});

test("a row is read from customdata, whatever its form", () => {
  assert.equal(rowOf(7), 7);
  assert.equal(rowOf([3, 9]), 3);
  assert.equal(rowOf(-1), null);
  assert.equal(rowOf(undefined), null);
});

test("the strip says the instant and each value with its unit", () => {
  const layout = { xaxis: { title: { text: "Time, s" } }, yaxis: { title: { text: "Horizontal error, m" } }, meta: { start_utc: "2026-03-04T10:00:00Z" } };
  const said = describePoints([{ trace: { name: "rdf", line: { color: "#D55E00" } }, x: 12.5, y: 345.6 }], layout, 12.5);
  assert.deepEqual(said.map((part) => part.value), ["12.500 s", "10:00:12.500", "346 m"]);
  const plan = { xaxis: { title: { text: "East, km" } }, yaxis: { title: { text: "North, km" } } };
  assert.deepEqual(describePoints([{ trace: { name: "rdf" }, x: 1.25, y: -3 }], plan, 12.5).map((part) => part.value), ["12.500 s", "E 1.2500, N −3.0000 km"]);
  assert.equal(isOverTime({ data: [], layout }), true);
  assert.deepEqual(splitTitle("NIS"), { quantity: "NIS", unit: "" });
  assert.equal(withAlpha("#0072B2", 0.1), "rgba(0, 114, 178, 0.1)");
});

test("no module makes markup from text or names another host", () => {
  const root = new URL("../../frontend/", import.meta.url);
  for (const folder of ["components", "js", "pages", "i18n", "css"]) {
    for (const name of readdirSync(new URL(folder, root))) {
      const text = readFileSync(new URL(`${folder}/${name}`, root), "utf8");
      assert.doesNotMatch(text, /innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function/, name);
      assert.doesNotMatch(text.replace("http://www.w3.org/2000/svg", ""), /https?:\/\//, name);
    }
  }
});

test("ticks that have no room on a narrow chart are left out", () => {
  const values = [1, 2, 5, 10, 15, 20, 30, 40, 60, 80, 100];
  const axis = { tickmode: "array", tickvals: values, ticktext: values.map((value) => `${value}<br>b0 = ${90 - value}`) };
  const shown = fewerTicks(axis).tickvals ?? [];
  assert.ok(shown.length >= 3 && shown.length < values.length, `${shown}`);
  for (let i = 1; i < shown.length; i += 1) assert.ok(shown[i] - shown[i - 1] >= 15);
  assert.equal(fewerTicks(axis).ticktext?.length, shown.length);
  const few = { tickmode: "array", tickvals: [1, 10, 100], ticktext: ["1", "10", "100"], type: "log" };
  assert.deepEqual(fewerTicks(few).tickvals, [1, 10, 100]);
  assert.deepEqual(fewerTicks({}), {});
});

test("the label of a study's run is the program's own and is put into words", async () => {
  const { titleOf } = await import("../../frontend/js/runs.js");
  const { setLanguage } = await import("../../frontend/js/i18n.js");
  globalThis.document = { documentElement: {} };
  await setLanguage("ru");
  const run = { id: "0123456789", tags: [], label: "Horizontal error, m", source: { name: "x", study: "some" } };
  assert.equal(titleOf(run), "Плановая ошибка, м");
  assert.equal(titleOf({ ...run, source: { name: "x" } }), "Horizontal error, m");
  assert.equal(titleOf({ ...run, label: "my own words", source: run.source }), "my own words");
  await setLanguage("en");
});
