import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { COMMANDS, commandOf } from "../../frontend/js/keys.js";

const ROOT = new URL("../../frontend/", import.meta.url).pathname;
const WRITTEN = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc", " ": "Space" };

/** The keys that each source acts upon by itself, as the help writes them. */
function handled() {
  const found = new Map();
  for (const folder of ["components", "js", "pages"]) {
    for (const name of readdirSync(join(ROOT, folder))) {
      const text = readFileSync(join(ROOT, folder, name), "utf8");
      if (!/["'](keydown|keyup|keypress)["']|onkey(down|up|press)|accesskey/i.test(text)) continue;
      const compared = [...text.matchAll(/\bevent\.key\s*[!=]==\s*"([^"]+)"/g)].map(([, key]) => key);
      const looked = [...text.matchAll(/\{([^{}]*)\}\[event\.key\]/g)]
        .flatMap(([, table]) => [...table.matchAll(/(\w+)\s*:/g)].map(([, key]) => key));
      found.set(`${folder}/${name}`, [...compared, ...looked].map((key) => WRITTEN[key] ?? key));
    }
  }
  return found;
}

test("the help lists every key that something acts upon, and no other", () => {
  const found = handled();
  assert.ok(found.size >= 6);
  for (const [source, keys] of found) assert.ok(keys.length > 0, `${source} handles keys in a way this test does not see`);
  const listed = new Set(COMMANDS.flatMap(({ keys }) => keys));
  const local = new Set([...found.values()].flat());
  for (const [source, keys] of found) for (const key of keys) assert.ok(listed.has(key), `${key} of ${source} is not listed`);
  for (const { keys, act } of COMMANDS) if (!act) for (const key of keys) assert.ok(local.has(key) || key === "Enter", key);
});

test("each command of the table is found by its keys, and by no part of them", () => {
  for (const command of COMMANDS.filter(({ act }) => act)) {
    if (command.any) for (const key of command.keys) assert.equal(commandOf(key), command);
    else assert.equal(commandOf(command.keys.at(-1), command.keys.at(-2)), command);
  }
  assert.equal(commandOf("r"), undefined);
  assert.equal(commandOf("g"), undefined);
  assert.equal(commandOf("r", "n"), undefined);
  assert.equal(commandOf("n", "g").text, "keys.new");
  assert.equal(commandOf("Enter"), undefined);
});

test("no two commands share their keys where the frame acts", () => {
  const keys = COMMANDS.filter(({ act }) => act).flatMap(({ keys, any }) => (any ? keys : [keys.join(" ")]));
  assert.equal(new Set(keys).size, keys.length);
});
