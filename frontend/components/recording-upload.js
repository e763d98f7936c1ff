// @ts-check
// Upload of a recording: the marks (one file or several of one kind), and where they are not in it, the site and
// the truth. Roles of dropped files are guessed from their names and can be corrected.

import { define, h, put, uniqueId } from "../js/dom.js";
import { Problem, post } from "../js/api.js";
import { t } from "../js/i18n.js";
import { formatBytes } from "../js/numbers.js";
import { guessRoles } from "../js/upload.js";
import { mapColumns } from "./column-mapping.js";
import { failed } from "./states.js";

/** @import { Preview, ReadOptions, Recording } from "../types.d.ts" */
/** @import { Key } from "../js/i18n.js" */

/** @typedef {{key: "file" | "site" | "truth", text: Key, hint: Key, several: boolean}} Slot */

/** @type {Slot[]} */
const SLOTS = [
  { key: "file", text: "upload.marks", hint: "upload.marks_hint", several: true },
  { key: "site", text: "upload.site", hint: "upload.site_hint", several: false },
  { key: "truth", text: "upload.truth", hint: "upload.truth_hint", several: false },
];

/** What a file is refused for when its columns are not called as they should be. */
const MAPPING_HELPS = new Set(["unsupported_format", "kind_unknown", "kind_ambiguous", "missing_column", "doppler_channels", "no_usable_rows", "where_matches_nothing"]);

export class RecordingUpload extends HTMLElement {
  /** @type {(recording: Recording) => void} */
  onuploaded = () => {};
  /** When set, the stored bytes of this recording are read again with the files given here. @type {string | null} */
  again = null;
  /** How it was read the first time. @type {ReadOptions} */
  options = {};
  /** Kind, mapping and row filter that the user chose. @type {ReadOptions | null} */
  chosen = null;
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
    this.mapButton = h("button", { type: "button", onclick: () => this.map() }, t("upload.map"));
    const slots = SLOTS.filter((slot) => !this.again || slot.key !== "file");
    const name = uniqueId("upload");
    this.nameField = h("input", { id: name, type: "text", maxlength: 120, autocomplete: "off", placeholder: t("upload.name_hint") });
    put(this, h("form", { class: "stack", onsubmit: (/** @type {Event} */ event) => this.submit(event) },
      slots.map((slot) => this.fileSlot(slot)),
      h("div", { class: "field" }, h("label", { for: name }, t("upload.name")), this.nameField),
      this.mapped = h("div"),
      this.message,
      h("div", { class: "row" }, this.send, this.mapButton)));
    this.check();
    this.showChosen();
  }

  /** @param {Slot} slot */
  fileSlot(slot) {
    const id = uniqueId("upload");
    const input = h("input", {
      id, type: "file", multiple: slot.several, data: { role: slot.key }, "aria-describedby": `${id}-hint`, onchange: () => {
        this.files[slot.key] = [...(input.files ?? [])];
        if (slot.key === "file") this.forgetMapping();
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
      if (slot.key === "file") this.forgetMapping();
      list();
    });
    names.textContent = this.files[slot.key].map((file) => `${file.name} (${formatBytes(file.size)})`).join(", ");
    names.hidden = !this.files[slot.key].length;
    return box;
  }

  check() {
    const needed = this.again ? [...this.files.site, ...this.files.truth, ...(this.chosen ? [this.chosen] : [])] : this.files.file;
    if (this.send) this.send.disabled = this.busy === true || needed.length === 0;
    if (this.mapButton) this.mapButton.disabled = this.busy === true || (!this.again && !this.files.file.length);
  }

  /** Another file has other columns. */
  forgetMapping() {
    this.chosen = null;
    this.showChosen();
  }

  /** Ask what the columns mean; what is chosen goes with the upload. */
  async map() {
    const bytes = this.files.file.reduce((sum, file) => sum + file.size, 0);
    const chosen = await mapColumns({ look: (options) => this.look(options), options: { ...this.options, ...this.chosen }, bytes });
    if (chosen) this.chosen = chosen;
    put(/** @type {HTMLElement} */ (this.message));
    this.showChosen();
    this.check();
    this.mapButton?.focus();
  }

  showChosen() {
    if (!this.mapped) return;
    const n = Object.keys(this.chosen?.mapping ?? {}).length;
    const text = this.chosen?.mapping ? t("upload.mapped", { n }) : t("upload.options_chosen");
    put(this.mapped, this.chosen ? h("p", { class: "row small" }, h("span", null, text),
      h("button", { type: "button", class: "link", onclick: () => { this.forgetMapping(); this.check(); } }, t("upload.unmap"))) : null);
  }

  /**
   * Read on trial.
   * @param {ReadOptions} options
   * @returns {Promise<Preview>}
   */
  async look(options) {
    if (this.again) return post("recordings/preview", { ...(await this.readAgainPayload(this.again, "")), options });
    return post("recordings/preview", this.form(options));
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
      put(/** @type {HTMLElement} */ (this.message),
        failed(error),
        error instanceof Problem && MAPPING_HELPS.has(error.code) ? h("p", null, t("upload.map_helps")) : null);
      if (!(error instanceof Problem)) throw error;
    } finally {
      this.busy = false;
      this.check();
    }
  }

  async payload() {
    const name = this.nameField?.value.trim();
    if (this.again) return this.readAgainPayload(this.again, name);
    return this.form({ ...this.chosen, ...(name ? { name } : {}) });
  }

  /** @param {ReadOptions} options */
  form(options) {
    const form = new FormData();
    for (const { key } of SLOTS) for (const file of this.files[key]) form.append(key, file, file.name);
    if (Object.keys(options).length) form.append("options", JSON.stringify(options));
    return form;
  }

  /**
   * Stored bytes are read again with a corrected site or truth, sent as they stand in their files, so that the same
   * files make the same recording.
   * @param {string} id
   * @param {string | undefined} name
   */
  async readAgainPayload(id, name) {
    const site = await this.files.site[0]?.text();
    const truth = await this.files.truth[0]?.text();
    return {
      from_recording_id: id,
      ...(site === undefined ? {} : { site }),
      ...(truth === undefined ? {} : { truth }),
      ...(name || this.chosen ? { options: { ...this.options, ...this.chosen, ...(name ? { name } : {}) } } : {}),
    };
  }
}

define("recording-upload", RecordingUpload);
