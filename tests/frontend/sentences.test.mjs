import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";
import { setLanguage, said } from "../../frontend/js/i18n.js";
import { sentences } from "../../frontend/i18n/ru-server.js";
import { translator } from "../../frontend/js/sentences.js";

const translate = translator(sentences);

test("what is filled in is carried over", () => {
  assert.equal(translate("There is no run 'xx'."), "Расчёта 'xx' нет.");
  assert.equal(translate("must lie between 0 and 100 m"), "должен быть в пределах от 0 до 100 m");
});

test("a sentence inside a sentence is translated too", () => {
  assert.equal(translate("line 5: column 'time_s' holds 'noon', which is not a number"), "строка файла 5: столбец 'time_s' содержит 'noon', это не число");
  assert.equal(translate("/runs: Input should be greater than 0. (2 more)"), "/runs: Должно быть больше 0. (и ещё 2)");
});

test("message and remedy come as one text", () => {
  assert.equal(translate("x.csv is a PDF document, which is not read here. Upload the measurements as CSV."), "x.csv – документ PDF; такое здесь не читается. Загрузите измерения в CSV.");
});

test("a name that looks like the end of a sentence stays a name", () => {
  assert.equal(translate("The run 'A. B' (12) is failed: it has no result to compare."), "Расчёт 'A. B' (12) не удался: сравнивать нечего.");
});

test("what nobody knows stays as it is, whole", () => {
  assert.equal(translate("There is no run 'xx'. Ask the owl."), null);
  assert.equal(translate("owl: 5"), null);
});

test("every sentence is found again with its places filled in", () => {
  for (const [english, russian] of Object.entries(sentences)) {
    if (!/[A-Za-z]{3}/.test(english.replace(/\{\d+\}/g, ""))) continue;
    const fill = (text) => text.replace(/\{(\d+)\}/g, (_, i) => `'v${i}'`);
    assert.equal(translate(fill(english)), fill(russian), english);
  }
});

test("the page speaks them only where it speaks Russian", async () => {
  globalThis.document = { documentElement: {} };
  assert.equal(said("There is no run 'xx'."), "There is no run 'xx'.");
  await setLanguage("ru");
  assert.equal(said("There is no\nrun 'xx'."), "Расчёта 'xx' нет.");
  // The server writes its reports by the same rules: tests/unit/charts/test_language.py reads this list too.
  const both = JSON.parse(readFileSync(new URL("./said-in-russian.json", import.meta.url), "utf-8"));
  for (const [english, words] of Object.entries(both)) assert.equal(said(english), words);
  await setLanguage("en");
});
