// @ts-check
// Tabs: arrow keys move, the panel below is drawn when its tab is chosen.

import { define, h, put, uniqueId } from "../js/dom.js";

/** @typedef {{name: string, title: string, draw: () => Node}} Tab */

// How much of the tab beside the chosen one is shown, so that there seems to be one.
const NEXT_PX = 24;

export class TabBar extends HTMLElement {
  /** @type {Tab[]} */
  tabs = [];
  chosen = "";
  label = "";
  /** @type {(name: string) => void} */
  onchoose = () => {};

  connectedCallback() {
    this.ids = uniqueId("tab");
    this.list = h("div", { class: "tabs", role: "tablist", "aria-label": this.label });
    this.panel = h("div", { role: "tabpanel", id: `${this.ids}-panel`, tabindex: 0 });
    this.className = "card";
    this.style.display = "block";
    put(this, this.list, this.panel);
    this.drawTabs();
    this.choose(this.chosen, false);
    this.list.addEventListener("keydown", (event) => this.onKey(event));
  }

  drawTabs() {
    put(/** @type {HTMLElement} */ (this.list), this.tabs.map((tab) => h("button", {
      type: "button", role: "tab", id: `${this.ids}-${tab.name}`, "aria-controls": `${this.ids}-panel`,
      onclick: () => this.choose(tab.name),
    }, tab.title)));
  }

  /**
   * @param {string} name
   * @param {boolean} [tell]
   */
  choose(name, tell = true) {
    const tab = this.tabs.find((one) => one.name === name) ?? this.tabs[0];
    if (!tab || !this.list || !this.panel) return;
    this.chosen = tab.name;
    for (const button of this.list.querySelectorAll("button")) {
      const chosen = button.id === `${this.ids}-${tab.name}`;
      button.setAttribute("aria-selected", String(chosen));
      button.tabIndex = chosen ? 0 : -1;
      if (chosen) this.bring(button);
    }
    this.panel.setAttribute("aria-labelledby", `${this.ids}-${tab.name}`);
    put(this.panel, tab.draw());
    if (tell) this.onchoose(tab.name);
  }

  /** On a phone not all tabs have room: the chosen one is brought into sight, the page stays where it is. @param {Element} button */
  bring(button) {
    const list = /** @type {HTMLElement} */ (this.list);
    const [box, own] = [list.getBoundingClientRect(), button.getBoundingClientRect()];
    if (own.right > box.right) list.scrollLeft += own.right - box.right + NEXT_PX;
    else if (own.left < box.left) list.scrollLeft -= box.left - own.left + NEXT_PX;
  }

  /** Put new words on a tab. @param {string} name @param {string} title */
  retitle(name, title) {
    const button = this.list?.querySelector(`#${this.ids}-${name}`);
    if (button) button.textContent = title;
  }

  /** @param {KeyboardEvent} event */
  onKey(event) {
    const at = this.tabs.findIndex((tab) => tab.name === this.chosen);
    const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: this.tabs.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    const tab = this.tabs[(to + this.tabs.length) % this.tabs.length];
    if (!tab) return;
    this.choose(tab.name);
    /** @type {HTMLElement | null | undefined} */ (this.list?.querySelector(`#${this.ids}-${tab.name}`))?.focus();
  }
}

define("tab-bar", TabBar);
