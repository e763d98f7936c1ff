// @ts-check
// What of a run's notes nobody may miss: sensors that disagree as a whole, and mistakes in the data that would explain it.

/** @typedef {{detail: string, labels: string[]}} Alarm */

const ALARMS = /^(registration_|suspect_|radars_disagree$|disagreement_|geometry_cannot_separate$)/;

/**
 * Alarms of all entries, each once, with whose they are; in the order in which they were said.
 * @param {Record<string, {code: string, detail: string, count: number}[]> | null | undefined} notes
 * @returns {Alarm[]}
 */
export function alarmsOf(notes) {
  /** @type {Map<string, Alarm>} */
  const found = new Map();
  for (const [label, said] of Object.entries(notes ?? {})) {
    for (const note of said) {
      if (!ALARMS.test(note.code)) continue;
      const known = found.get(note.detail) ?? { detail: note.detail, labels: [] };
      if (!known.labels.includes(label)) known.labels.push(label);
      found.set(note.detail, known);
    }
  }
  return [...found.values()];
}
