import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import en from "../../frontend/i18n/en.js";
import ru from "../../frontend/i18n/ru.js";

const FRONTEND = new URL("../../frontend/", import.meta.url).pathname;

test("both dictionaries have the same keys in the same order", () => {
  assert.deepEqual(Object.keys(ru), Object.keys(en));
});

test("each text fills in the same values in both languages", () => {
  const values = (entry) => [...new Set([...JSON.stringify(entry).matchAll(/\{(\w+)\}/g)].map((found) => found[1]))].sort();
  for (const key of Object.keys(en)) assert.deepEqual(values(ru[key]), values(en[key]), key);
});

test("plural entries have every form that their language needs", () => {
  for (const [language, dictionary] of Object.entries({ en, ru })) {
    const needed = new Intl.PluralRules(language).resolvedOptions().pluralCategories;
    for (const [key, entry] of Object.entries(dictionary)) {
      if (typeof entry === "object") assert.deepEqual(Object.keys(entry).sort(), [...needed].sort(), `${language} ${key}`);
    }
  }
});

test("every key that the page names is in the dictionary", () => {
  const folders = ["components", "js", "pages"];
  const sources = folders.flatMap((folder) => readdirSync(join(FRONTEND, folder)).map((name) => readFileSync(join(FRONTEND, folder, name), "utf8")));
  const named = sources.flatMap((text) => [...text.matchAll(/\bt\("([\w.]+)"/g)].map((found) => found[1]));
  assert.ok(named.length > 150);
  for (const key of named) assert.ok(key in en, key);
});

test("no message shouts or begs", () => {
  for (const [key, entry] of [...Object.entries(en), ...Object.entries(ru)]) {
    assert.doesNotMatch(JSON.stringify(entry), /!|please|пожалуйста/i, key);
  }
});
