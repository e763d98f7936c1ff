// @ts-check
// What a panel shows when it has nothing to show yet, or never will: empty, loading, not applicable, failed.

import { h } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { said, t, told } from "../js/i18n.js";
import { Problem } from "../js/api.js";
import { copyText } from "./toast-area.js";

/** @import { ProblemBody } from "../types.d.ts" */

/**
 * The state of a run or a recording: shape, colour and word.
 * @param {string} state
 */
export function stateBadge(state) {
  return h("span", { class: "state", data: { state } }, icon(state), h("span", null, told(`state.${state}`, state)));
}

/**
 * Nothing here yet: what it will show, and what fills it.
 * @param {string} text
 * @param {...Node} actions
 */
export function emptyState(text, ...actions) {
  return h("div", { class: "panel-state" }, h("span", null, text), ...actions);
}

/**
 * What was shown here was deleted meanwhile, and the way on.
 * @param {string} text
 * @param {string} href
 * @param {string} where
 */
export function gone(text, href, where) {
  return h("div", { class: "card", role: "alert" }, emptyState(text, h("a", { class: "button", href }, where)));
}

/**
 * There is nothing to show, and why.
 * @param {string} why
 */
export function notApplicable(why) {
  return h("div", { class: "panel-state" }, h("strong", null, t("state.not_applicable")), h("span", null, why));
}

/** @param {number} [lines] */
export function loading(lines = 3) {
  return h("div", { class: "stack", role: "status", "aria-label": t("state.loading"), style: "padding: 12px" },
    ...Array.from({ length: lines }, (_, i) => h("div", { class: "skeleton", style: `width: ${90 - 18 * i}%` })));
}

/**
 * What went wrong: title, detail, code, and a way to copy all of it.
 * @param {unknown} error
 * @param {{retry?: () => void}} [options]
 */
export function failed(error, options = {}) {
  const body = problemOf(error);
  const title = told(`problem.${body.code}`, body.title || t("problem.unknown"));
  const detail = body.detail === body.title ? "" : said(body.detail ?? "");
  const remedy = (body.detail ?? "").includes(body.remedy ?? "") ? "" : said(body.remedy ?? "");
  const errors = (body.errors ?? []).filter((one) => one.detail !== body.detail).map((one) => ({ pointer: one.pointer, detail: said(one.detail) }));
  const all = [title, detail, remedy, body.code, ...errors.map((one) => `${one.pointer}: ${one.detail}`)];
  return h("div", { class: "failure", role: "alert" },
    h("strong", null, title),
    detail ? h("span", null, detail) : null,
    remedy ? h("span", null, remedy) : null,
    ...errors.map((one) => h("span", { class: "small" }, h("code", null, one.pointer), " ", one.detail)),
    h("span", { class: "row small" },
      body.code ? h("code", { class: "muted" }, body.code) : null,
      h("button", { class: "link", type: "button", onclick: () => copyText(all.filter(Boolean).join("\n")) }, t("action.copy")),
      options.retry ? h("button", { class: "link", type: "button", onclick: options.retry }, t("action.try_again")) : null));
}

/** What went wrong in one line. @param {unknown} error */
export function wordsOf(error) {
  const body = problemOf(error);
  return said(body.detail ?? "") || told(`problem.${body.code}`, body.title || t("problem.unknown"));
}

/**
 * @param {unknown} error
 * @returns {ProblemBody}
 */
export function problemOf(error) {
  if (error instanceof Problem) return error;
  if (error && typeof error === "object" && ("code" in error || "detail" in error)) return /** @type {ProblemBody} */ (error);
  return { code: "page_error", title: t("problem.page_error"), detail: error instanceof Error ? error.message : String(error) };
}
