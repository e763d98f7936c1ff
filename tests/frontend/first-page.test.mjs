import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { dirname, join, normalize } from "node:path";
import test from "node:test";

const ROOT = new URL("../../frontend/", import.meta.url).pathname;
// What main.js and the frame import only when they run, before the list of runs stands.
const STARTS = ["js/main.js", "components/app-frame.js", "pages/runs-page.js"];

/** Every module that these need, themselves included. */
function needed(starts) {
  const found = new Set();
  const todo = [...starts];
  for (let path; (path = todo.pop()) !== undefined;) {
    if (found.has(path)) continue;
    found.add(path);
    const text = readFileSync(join(ROOT, path), "utf8");
    for (const [, name] of text.matchAll(/^import\s(?:[^"]*?\sfrom\s)?"(\.[^"]+)";/gm)) {
      todo.push(normalize(join(dirname(path), name)));
    }
  }
  return found;
}

test("the first page's modules are asked for at once, and no others", () => {
  const page = readFileSync(join(ROOT, "index.html"), "utf8");
  const asked = [...page.matchAll(/<link rel="modulepreload" href="([^"]+)">/g)].map(([, path]) => path);
  const modules = needed(STARTS);
  assert.ok(modules.size > 20);
  modules.delete("js/main.js"); // the script itself
  assert.deepEqual([...asked].sort(), [...modules].sort());
});
