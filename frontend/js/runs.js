// @ts-check
// What the pages say about a run, and what would start it again.

import { said, t } from "./i18n.js";
import { routeTo } from "./router.js";

/** @import { Run } from "../types.d.ts" */

/** The words for a run: its label, else what it reprocessed. @param {Run} run */
export function titleOf(run) {
  return said(run.label ?? "") || run.source.name || t("run.untitled", { id: run.id.slice(0, 8) });
}

/** @param {Run} run @returns {number | null} */
export function durationOf(run) {
  if (!run.started_at || !run.finished_at) return null;
  return (Date.parse(run.finished_at) - Date.parse(run.started_at)) / 1000;
}

/**
 * What would start this run again.
 * @param {Run} run
 */
export function requestOf(run) {
  return { recording_id: run.source.recording_id ?? "", algorithms: run.algorithms.map((entry) => ({
    name: entry.name,
    ...(entry.label && entry.label !== entry.name ? { label: entry.label } : {}),
    ...(entry.parameters && Object.keys(entry.parameters).length ? { parameters: entry.parameters } : {}),
  })), ...(run.label ? { label: run.label } : {}), ...(run.tags.length ? { tags: run.tags } : {}), ...(run.seed ? { seed: run.seed } : {}) };
}

/** The page that composes this run again, everything filled in. @param {Run} run */
export function againRoute(run) {
  const { recording_id, algorithms, label, tags, seed } = requestOf(run);
  return routeTo(["new"], { recording: recording_id, a: algorithms.map((entry) => JSON.stringify(entry)), label, tag: tags, seed: seed ? String(seed) : null });
}
