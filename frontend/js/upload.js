// @ts-check
// Which of several dropped files are the marks, which the site, which the truth.

/** @typedef {"file" | "site" | "truth"} Role */

/**
 * Guess roles from file names; a lone file is always the marks.
 * @param {string[]} names
 * @returns {Role[]}
 */
export function guessRoles(names) {
  if (names.length === 1) return ["file"];
  let site = false;
  let truth = false;
  const roles = names.map((/** @type {string} */ name) => {
    if (!site && (/(site|sensors?|stations?|receivers?)/i.test(name) || name.toLowerCase().endsWith(".json"))) {
      site = true;
      return "site";
    }
    if (!truth && /(truth|reference|ads-?b|gnss|gps)/i.test(name)) {
      truth = true;
      return "truth";
    }
    return "file";
  });
  // Something must hold the marks.
  if (!roles.includes("file")) roles[roles.length - 1] = "file";
  return /** @type {Role[]} */ (roles);
}
