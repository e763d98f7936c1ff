// @ts-check
// Light, dark or as the system wishes; charts redraw on `themes`' change event.

export const themes = new EventTarget();
export const THEMES = /** @type {const} */ (["auto", "light", "dark"]);
/** @typedef {(typeof THEMES)[number]} Theme */

const system = window.matchMedia("(prefers-color-scheme: dark)");
system.addEventListener("change", () => themes.dispatchEvent(new Event("change")));

// A choice made in another tab holds here too.
window.addEventListener("storage", (event) => {
  if (event.key !== "filterroom.theme") return;
  applyTheme();
  themes.dispatchEvent(new Event("change"));
});

/** @returns {Theme} */
export function theme() {
  return THEMES.find((name) => name === localStorage.getItem("filterroom.theme")) ?? "auto";
}

/** @param {Theme} name */
export function setTheme(name) {
  localStorage.setItem("filterroom.theme", name);
  applyTheme();
  themes.dispatchEvent(new Event("change"));
}

export function applyTheme() {
  const name = theme();
  if (name === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = name;
}

/** Whether the page is dark now. */
export function isDark() {
  return theme() === "auto" ? system.matches : theme() === "dark";
}

/** The resolved colours that charts use. */
export function chartColours() {
  const style = getComputedStyle(document.documentElement);
  const read = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
  return {
    text: read("--text"),
    muted: read("--muted"),
    line: read("--line"),
    grid: read("--grid"),
    surface: read("--surface"),
    measurement: read("--measurement"),
  };
}
