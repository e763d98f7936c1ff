// @ts-check
// The targets of a run: of its recordings, or of its scenario.

import { get } from "./api.js";
import { loadTable } from "./tables.js";

/** @import { Run, Target } from "../types.d.ts" */

/** @param {string} recording @param {AbortSignal | undefined} signal @returns {Promise<Target[]>} */
export function targetsOf(recording, signal) {
  return get(`recordings/${recording}/targets`, { signal }).then((/** @type {{items: Target[]}} */ list) => list.items, () => []);
}

/** Targets of all recordings; one name is one target. @param {Target[][]} lists @returns {Target[]} */
export function allTargets(lists) {
  /** @type {Map<string, Target>} */
  const found = new Map();
  for (const target of lists.flat()) {
    const known = found.get(target.name);
    found.set(target.name, { name: target.name, marks: (known?.marks ?? 0) + (target.marks ?? 0) });
  }
  return lists.length === 1 ? lists.flat() : [...found.values()];
}

/** Targets of a scenario, as its metrics name them. @param {Run} run @returns {Promise<Target[]>} */
export async function simulatedTargets(run) {
  const { rows } = await loadTable(run.id, "metrics").catch(() => ({ rows: [] }));
  return [...new Set(rows.map((row) => String(row.target ?? "")).filter(Boolean))].map((name) => /** @type {Target} */ ({ name }));
}
