// @ts-check
// Upload of a recording: the marks (one file or several of one kind), and where they are not in it, the site and
// the truth. Roles of dropped files are guessed from their names and can be corrected.

import { define, h, put, uniqueId } from "../js/dom.js";
import { Problem, post } from "../js/api.js";
import { t } from "../js/i18n.js";
import { formatBytes } from "../js/numbers.js";
import { guessRoles } from "../js/upload.js";
import { failed, problemOf } from "./states.js";

/** @import { Recording } from "../types.d.ts" */
/** @import { Key } from "../js/i18n.js" */

/** @typedef {{key: "file" | "site" | "truth", text: Key, hint: Key, several: boolean}} Slot */

/** @type {Slot[]} */
const SLOTS = [
  { key: "file", text: "upload.marks", hint: "upload.marks_hint", several: true },
  { key: "site", text: "upload.site", hint: "upload.site_hint", several: false },
  { key: "truth", text: "upload.truth", hint: "upload.truth_hint", several: false },
];

export class RecordingUpload extends HTMLElement {
  /** @type {(recording: Recording) => void} */
  onuploaded = () => {};
  /** When set, the stored bytes of this recording are read again with the files given here. @type {string | null} */
  again = null;
  /** How it was read the first time. @type {Record<string, unknown>} */
  options = {};
  /** @type {Record<"file" | "site" | "truth", File[]>} */
  files = { file: [], site: [], truth: [] };

  connectedCallback() {
    this.draw();
  }

  /** @param {File[]} files */
  takeFiles(files) {
    const roles = guessRoles(files.map((file) => file.name));
    for (const [i, file] of files.entries()) this.files[roles[i] ?? "file"].push(file);
    this.draw();
  }

  draw() {
    this.message = h("div");
    this.send = h("button", { class: "primary" }, t(this.again ? "upload.read_again" : "upload.send"));
    const slots = SLOTS.filter((slot) => !this.again || slot.key !== "file");
    const name = uniqueId("upload");
    this.nameField = h("input", { id: name, type: "text", maxlength: 120, autocomplete: "off", placeholder: t("upload.name_hint") });
    put(this, h("form", { class: "stack", onsubmit: (/** @type {Event} */ event) => this.submit(event) },
      slots.map((slot) => this.fileSlot(slot)),
      h("div", { class: "field" }, h("label", { for: name }, t("upload.name")), this.nameField),
      this.message,
      h("div", { class: "row" }, this.send)));
    this.check();
  }

  /** @param {Slot} slot */
  fileSlot(slot) {
    const id = uniqueId("upload");
    const input = h("input", {
      id, type: "file", multiple: slot.several, data: { role: slot.key }, "aria-describedby": `${id}-hint`, onchange: () => {
        this.files[slot.key] = [...(input.files ?? [])];
        list();
      },
    });
    const names = h("span", { class: "small break" });
    const list = () => {
      names.textContent = this.files[slot.key].map((file) => `${file.name} (${formatBytes(file.size)})`).join(", ");
      names.hidden = !this.files[slot.key].length;
      this.check();
    };
    const box = h("div", { class: "file" },
      h("label", { for: id, style: "font-weight: 500" }, t(slot.text)), input, names,
      h("span", { class: "small muted", id: `${id}-hint` }, t(slot.hint)));
    box.addEventListener("dragover", (event) => {
      event.preventDefault();
      box.classList.add("over");
    });
    box.addEventListener("dragleave", () => box.classList.remove("over"));
    box.addEventListener("drop", (event) => {
      event.preventDefault();
      box.classList.remove("over");
      const dropped = [...(event.dataTransfer?.files ?? [])];
      this.files[slot.key] = slot.several ? dropped : dropped.slice(0, 1);
      list();
    });
    names.textContent = this.files[slot.key].map((file) => `${file.name} (${formatBytes(file.size)})`).join(", ");
    names.hidden = !this.files[slot.key].length;
    return box;
  }

  check() {
    const needed = this.again ? [...this.files.site, ...this.files.truth] : this.files.file;
    if (this.send) this.send.disabled = this.busy === true || needed.length === 0;
  }

  /** @param {Event} event */
  async submit(event) {
    event.preventDefault();
    this.busy = true;
    this.check();
    put(/** @type {HTMLElement} */ (this.message), h("p", { role: "status", class: "muted" }, t("upload.reading")));
    try {
      const recording = /** @type {Recording} */ (await post("recordings", await this.payload()));
      put(/** @type {HTMLElement} */ (this.message));
      this.onuploaded(recording);
    } catch (error) {
      put(/** @type {HTMLElement} */ (this.message), failed(error instanceof SyntaxError
        ? problemOf({ code: "site_not_json", title: t("problem.site_not_json"), detail: error.message }) : error));
      if (!(error instanceof Problem) && !(error instanceof SyntaxError)) throw error;
    } finally {
      this.busy = false;
      this.check();
    }
  }

  async payload() {
    const name = this.nameField?.value.trim();
    if (this.again) return this.readAgainPayload(this.again, name);
    const form = new FormData();
    for (const { key } of SLOTS) for (const file of this.files[key]) form.append(key, file, file.name);
    if (name) form.append("options", JSON.stringify({ name }));
    return form;
  }

  /**
   * Stored bytes are read again with a corrected site (Site JSON, or a sensor table as text) or truth.
   * @param {string} id
   * @param {string | undefined} name
   */
  async readAgainPayload(id, name) {
    const site = await this.files.site[0]?.text();
    const truth = await this.files.truth[0]?.text();
    return {
      from_recording_id: id,
      ...(site === undefined ? {} : { site: site.trimStart().startsWith("{") ? JSON.parse(site) : site }),
      ...(truth === undefined ? {} : { truth }),
      ...(name ? { options: { ...this.options, name } } : {}),
    };
  }
}

define("recording-upload", RecordingUpload);
