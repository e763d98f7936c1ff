// @ts-check
// What the pages say about a run, and what would start it again.

import { said, t } from "./i18n.js";
import { routeTo } from "./router.js";

/** @import { Run, TrialsRequest } from "../types.d.ts" */

/** The words for a run: its label, else what it reprocessed. @param {Run} run */
export function titleOf(run) {
  // Only labels of samples and studies are the program's own; what a user wrote stays as it was written.
  const label = run.tags.includes("sample") || run.source.study ? said(run.label ?? "") : run.label;
  return label || sourceOf(run) || t("run.untitled", { id: run.id.slice(0, 8) });
}

/** What a run works on: the name of a recording as the user gave it, or of a scenario. @param {Run} run @returns {string} */
export function sourceOf(run) {
  const { name, recording_id, recording_ids } = run.source;
  return recording_id || recording_ids ? (name ?? "") : said(name ?? "");
}

/** @param {Run} run @returns {number | null} */
export function durationOf(run) {
  if (!run.started_at || !run.finished_at) return null;
  return (Date.parse(run.finished_at) - Date.parse(run.started_at)) / 1000;
}

/**
 * What would start this run again.
 * @param {Run} run
 * @returns {import("./snippets.js").Request}
 */
export function requestOf(run) {
  const { scenario, sweep, study } = /** @type {{scenario?: TrialsRequest["scenario"], sweep?: TrialsRequest["sweep"] | null, study?: string}} */ (run.source);
  const named = { ...(run.label ? { label: run.label } : {}), ...(run.tags.length ? { tags: run.tags } : {}), ...(run.seed ? { seed: run.seed } : {}) };
  if (study) return { study, trials: run.trials ?? 1, ...named };
  const algorithms = run.algorithms.map((entry) => ({
    name: entry.name,
    ...(entry.label && entry.label !== entry.name ? { label: entry.label } : {}),
    ...(entry.parameters && Object.keys(entry.parameters).length ? { parameters: entry.parameters } : {}),
  }));
  if (scenario) return { scenario, trials: run.trials ?? 1, ...(sweep ? { sweep } : {}), algorithms, ...named };
  const { recording_id = "", recording_ids } = run.source;
  return recording_ids ? { recording_ids, algorithms, ...named } : { recording_id, algorithms, ...named };
}

/** The recordings that a run works on, several where they are joined. @param {Run} run @returns {string[]} */
export function recordingsOf(run) {
  const { recording_id, recording_ids } = run.source;
  return recording_ids ?? (recording_id ? [recording_id] : []);
}

/**
 * Where a row of a run stands in its recordings: rows of joined ones are numbered on.
 * @param {Run} run
 * @param {number | null} row
 * @returns {{recording: string, row: number} | null}
 */
export function placeOf(run, row) {
  if (row === null) return null;
  const recordings = recordingsOf(run);
  const firsts = /** @type {number[]} */ (run.source["first_rows"] ?? [1]);
  const at = firsts.findLastIndex((first) => first <= row);
  const recording = recordings[at];
  return recording === undefined ? null : { recording, row: row - (firsts[at] ?? 1) + 1 };
}

/** The page that composes this run again, everything filled in; of a study the page of the study. @param {Run} run */
export function againRoute(run) {
  const { algorithms = [], scenario, trials, sweep, label, tags, seed, study } = requestOf(run);
  if (study) return routeTo(["studies", study]);
  return routeTo(["new"], {
    recording: recordingsOf(run), scenario: scenario ? JSON.stringify(scenario) : null, trials: scenario ? String(trials) : null, sweep: sweep ? JSON.stringify(sweep) : null,
    a: algorithms.map((entry) => JSON.stringify(entry)), label, tag: tags, seed: seed ? String(seed) : null,
  });
}
