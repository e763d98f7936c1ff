// @ts-check
// Label and tags of a run: shown, and edited where they stand.

import { h, put, uniqueId } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { patch } from "../js/api.js";
import { t } from "../js/i18n.js";
import { routeTo } from "../js/router.js";
import { failed } from "./states.js";

/** @import { Run } from "../types.d.ts" */

/** Split what was typed between commas; a tag given twice counts once. @param {string} text */
export function readTags(text) {
  return [...new Set(text.split(",").map((tag) => tag.trim()).filter(Boolean))];
}

/** The tags of a run; each leads to the runs that carry it. @param {Run} run */
export function tagLinks(run) {
  return run.tags.map((tag) => h("a", { class: "tag", href: routeTo(["runs"], { tag }), title: t("runs.with_tag", { tag }) }, tag));
}

/**
 * A button that turns `place` into a form for the run's label and tags.
 * @param {Run} run
 * @param {string} name what the run is called on the page
 * @param {() => HTMLElement} place what the form stands in for until it is saved or given up
 * @param {(run: Run) => void} onsaved
 */
export function editButton(run, name, place, onsaved) {
  const button = h("button", {
    type: "button", class: "plain", title: t("run.edit"), "aria-label": `${t("run.edit")}: ${name}`, data: { edit: "" },
    onclick: () => {
      const kept = place();
      const form = nameForm(run, (changed) => {
        form.replaceWith(kept);
        if (changed) onsaved(changed);
        if (button.isConnected) button.focus();
      });
      kept.replaceWith(form);
      form.querySelector("input")?.focus();
    },
  }, icon("edit"));
  return button;
}

/**
 * @param {Run} run
 * @param {(changed: Run | null) => void} onend null: given up
 */
function nameForm(run, onend) {
  const [labelId, tagsId] = [uniqueId("label"), uniqueId("tags")];
  const label = h("input", { id: labelId, type: "text", maxlength: 200, value: run.label ?? "", placeholder: run.source.name ?? "" });
  const tags = h("input", { id: tagsId, type: "text", value: run.tags.join(", "), placeholder: t("run.tags_hint") });
  const message = h("div", { class: "grow" });
  const save = h("button", { type: "submit", class: "primary" }, t("action.save"));
  const form = h("form", { class: "run-name-form" },
    h("div", { class: "field grow" }, h("label", { for: labelId, class: "small muted" }, t("compose.run_label")), label),
    h("div", { class: "field grow" }, h("label", { for: tagsId, class: "small muted" }, t("run.tags")), tags),
    save, h("button", { type: "button", onclick: () => onend(null) }, t("action.give_up")), message);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    save.disabled = true;
    try {
      onend(await patch(`runs/${run.id}`, { label: label.value.trim(), tags: readTags(tags.value) }));
    } catch (error) {
      save.disabled = false;
      save.focus();
      put(message, failed(error));
    }
  });
  form.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    onend(null);
  });
  return form;
}
