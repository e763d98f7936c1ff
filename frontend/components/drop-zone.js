// @ts-check
// Files may be dropped anywhere on the page; they go to the page that composes a run.

import { define, put } from "../js/dom.js";
import { t } from "../js/i18n.js";
import { go } from "../js/router.js";

/** @type {File[]} */
let dropped = [];

/** The files that were dropped last, once. */
export function takeDropped() {
  const files = dropped;
  dropped = [];
  return files;
}

/** Hand files over to the page that composes a run. @param {File[]} files */
export function composeWith(files) {
  if (!files.length) return;
  dropped = files;
  go("#/new?source=upload");
}

class DropZone extends HTMLElement {
  connectedCallback() {
    this.className = "dropping";
    this.hidden = true;
    put(this, t("drop.here"));
    this.stop = new AbortController();
    const { signal } = this.stop;
    let depth = 0;
    const carriesFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes("Files") ?? false;
    window.addEventListener("dragenter", (event) => {
      if (!carriesFiles(event)) return;
      depth += 1;
      this.hidden = false;
    }, { signal });
    window.addEventListener("dragleave", () => {
      depth = Math.max(0, depth - 1);
      if (!depth) this.hidden = true;
    }, { signal });
    window.addEventListener("dragover", (event) => {
      if (carriesFiles(event)) event.preventDefault();
    }, { signal });
    window.addEventListener("drop", (event) => {
      depth = 0;
      this.hidden = true;
      if (!carriesFiles(event) || event.defaultPrevented) return;
      event.preventDefault();
      composeWith([...(event.dataTransfer?.files ?? [])]);
    }, { signal });
  }

  disconnectedCallback() {
    this.stop?.abort();
  }
}

define("drop-zone", DropZone);
