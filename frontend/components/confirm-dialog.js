// @ts-check
// The only modal dialog: a deletion that cannot be undone.

import { h } from "../js/dom.js";
import { t } from "../js/i18n.js";

/**
 * Ask before deleting.
 * @param {string} question
 * @param {string} detail what goes with it
 * @returns {Promise<boolean>}
 */
export function confirmDeletion(question, detail) {
  return new Promise((resolve) => {
    const dialog = h("dialog", { class: "confirm", "aria-labelledby": "confirm-title" },
      h("h2", { id: "confirm-title", class: "break" }, question),
      h("p", { class: "muted break", style: "margin-top: 6px" }, detail),
      h("div", { class: "row" },
        h("button", { type: "button", onclick: () => dialog.close() }, t("action.keep")),
        h("button", { type: "button", class: "danger", onclick: () => dialog.close("delete") }, t("action.delete"))));
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue === "delete");
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
