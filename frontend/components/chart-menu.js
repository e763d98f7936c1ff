// @ts-check
// What can be done with a chart: look at it in another way, take it along as image or data.

import { h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { t } from "../js/i18n.js";
import { copyText } from "./toast-area.js";

/** @import { ChartPanel } from "./chart-panel.js" */

/** @param {ChartPanel} panel */
export function chartMenu(panel) {
  const item = (/** @type {string} */ text, /** @type {() => void} */ act) =>
    h("button", { class: "plain", type: "button", onclick: () => { close(); act(); } }, text);
  const link = (/** @type {string} */ text, /** @type {string} */ suffix) =>
    h("a", { class: "button plain", href: panel.address(suffix), download: "", onclick: () => close() }, text);
  // The addresses follow what the chart shows when the menu is opened.
  const items = () => [
    item(t("chart.reset_view"), () => panel.resetView()),
    item(t("chart.pan"), () => panel.togglePanning()),
    item("PNG", () => panel.saveImage("png")),
    item("SVG", () => panel.saveImage("svg")),
    link("CSV", "csv"), link("JSON", "json"), panel.source.startsWith("compare/") ? null : link("HTML", "html"),
    item(t("chart.copy_address"), () => copyText(panel.address("json"))),
  ];
  const list = h("div", { hidden: true });
  const button = h("button", {
    class: "plain", type: "button", title: t("chart.menu"), "aria-label": `${t("chart.menu")}: ${panel.heading}`, "aria-expanded": "false",
    onclick: () => (list.hidden ? open() : close()),
  }, icon("more"));
  const root = h("div", { class: "menu" }, button, list);

  function open() {
    put(list, ...items());
    list.hidden = false;
    button.setAttribute("aria-expanded", "true");
  }
  function close() {
    list.hidden = true;
    button.setAttribute("aria-expanded", "false");
  }
  root.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || list.hidden) return;
    event.stopPropagation();
    close();
    button.focus();
  });
  root.addEventListener("focusout", (event) => {
    if (!root.contains(/** @type {Node | null} */ (event.relatedTarget))) close();
  });
  // Some browsers do not focus a clicked button; keep the focus inside so that leaving it closes the menu.
  root.addEventListener("click", () => { if (!list.hidden) button.focus(); });
  return root;
}
