// @ts-check
// Short confirmations of what the person just did; everything else is written where it belongs.

import { define, h } from "../js/dom.js";
import { t } from "../js/i18n.js";

const SHOWN_MS = 4000;

class ToastArea extends HTMLElement {
  connectedCallback() {
    this.className = "toasts";
    this.setAttribute("role", "status");
    this.setAttribute("aria-live", "polite");
  }

  /** @param {string} text */
  show(text) {
    const toast = h("div", null, text);
    this.append(toast);
    setTimeout(() => toast.remove(), SHOWN_MS);
  }
}

define("toast-area", ToastArea);

/** @param {string} text */
export function toast(text) {
  const area = document.querySelector("toast-area");
  if (area instanceof ToastArea) area.show(text);
}

/**
 * Copy to the clipboard and say so. Pages that are not on localhost or https have no clipboard interface, so an
 * old-fashioned selection serves there.
 * @param {string} text
 */
export async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = h("textarea", { class: "sr-only", value: text });
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
  }
  toast(t("toast.copied"));
}
