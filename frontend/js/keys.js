// @ts-check
// Every key that does something, in one table: the help shows it, and the frame acts by it. Keys that a part of a page
// handles itself (`act` is missing) stand here for the help; a test compares them with the handlers.

import { go } from "./router.js";

/** @import { Key } from "./i18n.js" */

/**
 * `keys` are pressed one after another, or, where `any`, each does something of its own.
 * @typedef {{keys: string[], text: Key, any?: true, act?: (key: string) => void}} Command
 */

/** @type {Command[]} */
export const COMMANDS = [
  { keys: ["g", "r"], text: "keys.runs", act: () => go("#/runs") },
  { keys: ["g", "d"], text: "keys.recordings", act: () => go("#/recordings") },
  { keys: ["g", "a"], text: "keys.algorithms", act: () => go("#/algorithms") },
  { keys: ["g", "s"], text: "keys.scenarios", act: () => go("#/scenarios") },
  { keys: ["g", "m"], text: "keys.map", act: () => go("#/map") },
  { keys: ["g", "t"], text: "keys.studies", act: () => go("#/studies") },
  { keys: ["n"], text: "keys.new", act: () => go("#/new") },
  { keys: ["/"], text: "keys.filter", act: () => element("main input[type=search]")?.focus() },
  { keys: ["j", "k"], any: true, text: "keys.rows", act: (key) => moveRow(key === "j" ? 1 : -1) },
  { keys: ["Enter"], text: "keys.open" },
  { keys: ["e"], text: "keys.edit", act: () => inRow("[data-edit]")?.click() },
  { keys: ["x"], text: "keys.pick", act: () => inRow("[data-pick]")?.click() },
  { keys: ["c"], text: "keys.compare", act: () => element("main compare-tray:not([hidden]) [data-compare]")?.click() },
  { keys: ["←", "→", "Home", "End"], any: true, text: "keys.tabs" },
  { keys: ["Enter", "Space"], any: true, text: "keys.show_row" },
  { keys: ["←", "→"], any: true, text: "keys.cursor" },
  { keys: ["←", "→", "↑", "↓"], any: true, text: "keys.station" },
  { keys: ["Enter"], text: "keys.target" },
  { keys: ["Esc"], text: "keys.escape" },
  { keys: ["?"], text: "keys.help", act: () => element("keyboard-help")?.togglePopover() },
];

/**
 * The command of a key; `before` is the key that was pressed just before it.
 * @param {string} key
 * @param {string} [before]
 */
export function commandOf(key, before) {
  const able = COMMANDS.filter((command) => command.act);
  const pair = able.find(({ keys, any }) => !any && keys.length === 2 && keys[0] === before && keys[1] === key);
  return pair ?? able.find(({ keys, any }) => (any ? keys.includes(key) : keys.length === 1 && keys[0] === key));
}

/** @param {string} selector @returns {HTMLElement | null} */
function element(selector) {
  return document.querySelector(selector);
}

/** Move the focus along the rows of the page's first list. @param {number} step */
function moveRow(step) {
  const rows = /** @type {HTMLElement[]} */ ([...document.querySelectorAll("main [data-row-link]")]);
  const here = document.activeElement?.closest("tr");
  const at = rows.findIndex((row) => row === document.activeElement || (here !== null && here === row.closest("tr")));
  rows[Math.min(rows.length - 1, Math.max(0, at + step))]?.focus();
}

/** What a key acts on: in the row that has the focus, else in the head of the page. @param {string} selector */
function inRow(selector) {
  const place = document.activeElement?.closest("tr") ?? document.querySelector("main .run-head");
  return /** @type {HTMLElement | null} */ (place?.querySelector(selector) ?? null);
}
