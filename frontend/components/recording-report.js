// @ts-check
// What was read of a recording and what was not: counts, warnings, and every rejected row with its reason.

import { h, put } from "../js/dom.js";
import { apiUrl, getText } from "../js/api.js";
import { parseCsv } from "../js/csv.js";
import { said, t, told } from "../js/i18n.js";
import { formatCount, formatNumber } from "../js/numbers.js";
import { dataTable } from "./data-table.js";
import { failed } from "./states.js";

/** @import { Key } from "../js/i18n.js" */
/** @import { Recording, Rejection } from "../types.d.ts" */

/**
 * The counts in large figures.
 * @param {Recording} recording
 */
export function readCounts(recording) {
  const { read, accepted, rejected } = recording.rows;
  const tile = (/** @type {string} */ name, /** @type {Node | string} */ value, /** @type {string} */ type = "") =>
    h("div", null, h("dt", null, name), h("dd", { class: type || null }, value));
  return h("dl", { class: "tiles" },
    tile(t("report.read"), formatCount(read)),
    tile(t("report.accepted"), formatCount(accepted)),
    tile(t("report.rejected"), h("span", { class: rejected ? "bad" : null }, formatCount(rejected))),
    tile(t("report.kind"), told(`kind.${recording.kind}`, recording.kind ?? "–"), "text"),
    tile(t("report.format"), recording.format ?? "–", "text"),
    tile(t("report.span"), spanOf(recording), "text"),
    tile(t("report.site"), siteWords(recording), "text"),
    tile(t("report.truth"), t(recording.has_truth ? "report.truth_yes" : "report.truth_no"), "text"));
}

/**
 * How many rows, by what they are; empty where no kind is known.
 * @param {string | null} kind
 * @param {number} n
 */
export function rowsWords(kind, n) {
  return kind ? t(/** @type {Key} */ (`rows.${kind}`), { n }) : "";
}

/** @param {Recording} recording */
export function siteWords(recording) {
  const { site } = recording;
  if (!site) return t("site.none_short");
  if (site.stations) return t("site.stations_count", { n: site.stations.length });
  if (site.radars) return t("site.radars_count", { n: site.radars.length });
  return t("site.receivers_count", { n: site.receivers?.length ?? 0 });
}

/** @param {Recording} recording */
function spanOf(recording) {
  const span = recording.time_span_s;
  if (span === null || span === undefined) return "–";
  if (typeof span === "number") return `${formatNumber(span, 4)} ${t("unit.s")}`;
  return `${formatNumber(span[1] - span[0], 4)} ${t("unit.s")}`;
}

/** @param {Recording} recording */
export function warningsList(recording) {
  if (!recording.warnings.length) return null;
  return h("div", { class: "notice" },
    h("ul", { class: "stack tight" }, recording.warnings.map((warning) => h("li", null,
      told(`warning.${warning.code}`, ""), told(`warning.${warning.code}`, "") ? ": " : "", said(warning.detail),
      warning.count > 1 ? h("span", { class: "muted" }, ` (${formatCount(warning.count)}×)`) : null))));
}

/** Rejected rows; the first hundred come with the recording, all of them on demand. @param {Recording} recording */
export function rejectionsTable(recording) {
  if (!recording.rows.rejected) return h("p", { class: "muted" }, t("report.none_rejected"));
  const several = new Set((recording.files ?? []).filter((file) => file.role === "data").map((file) => file.name)).size > 1;
  const table = dataTable({
    caption: t("report.rejections"),
    columns: [
      { title: t("report.row"), number: true, cell: (/** @type {Rejection} */ one) => formatCount(one.row), sort: (one) => one.row },
      ...(several ? [{ title: t("report.file"), cell: (/** @type {Rejection} */ one) => one.file ?? "" }] : []),
      { title: t("report.reason"), cell: (one) => told(`rejection.${one.code}`, one.code.replaceAll("_", " ")), sort: (one) => one.code },
      { title: t("report.detail"), cell: (one) => h("span", { class: "break" }, said(one.detail)) },
    ],
    rows: recording.rejections ?? [],
  });
  const shown = recording.rejections?.length ?? 0;
  const foot = h("div", { class: "row small", style: "padding: 6px 0" });
  const download = h("a", { href: apiUrl(`recordings/${recording.id}/rejections.csv`), download: "" }, t("report.rejections_csv"));
  const all = h("button", {
    class: "link", type: "button", onclick: async () => {
      try {
        table.setRows(readRejections(await getText(`recordings/${recording.id}/rejections.csv`)));
        put(foot, download);
      } catch (error) {
        put(foot, failed(error));
      }
    },
  }, t("report.show_all", { n: formatCount(recording.rows.rejected) }));
  put(foot, shown < recording.rows.rejected ? all : null, download);
  return h("div", null, table, foot);
}

/** @param {string} text @returns {Rejection[]} */
function readRejections(text) {
  const { columns, rows } = parseCsv(text);
  const at = (/** @type {string} */ name) => columns.indexOf(name);
  return rows.map((row) => ({
    row: row[at("row")] ? Number(row[at("row")]) : null,
    code: row[at("code")] ?? "",
    detail: row[at("detail")] ?? "",
    file: row[at("file")] ?? null,
  }));
}
