// @ts-check
// Where transmitters and receivers stand, typed on the page: the recording is read again with it. Their places decide
// everything here, so nobody should have to write a file for them.

import { define, h, put, uniqueId } from "../js/dom.js";
import { post } from "../js/api.js";
import { emptyTyped, GROUPS, LAYOUTS, layoutOf, NUMBERS, PLACES, siteFrom, typedOf } from "../js/doppler-site.js";
import { t } from "../js/i18n.js";
import { failed } from "./states.js";

/** @import { Recording, Site } from "../types.d.ts" */
/** @import { Typed } from "../js/doppler-site.js" */

export class DopplerSiteForm extends HTMLElement {
  recordingId = "";
  /** @type {Site | null} */
  site = null;
  /** @type {(recording: Recording) => void} */
  onread = () => {};
  /** @type {Typed} */
  typed = emptyTyped("1x2");

  connectedCallback() {
    const known = this.site && typedOf(this.site);
    if (known) this.typed = known;
    this.draw();
  }

  draw() {
    const layoutId = uniqueId("layout");
    this.message = h("div", { "aria-live": "polite" });
    put(this, h("form", { class: "stack", novalidate: true, onsubmit: (/** @type {Event} */ event) => { event.preventDefault(); this.send(); } },
      h("div", { class: "field" }, h("label", { for: layoutId, class: "small muted" }, t("doppler_site.layout")),
        h("select", { id: layoutId, value: layoutOf(this.typed), onchange: (/** @type {Event} */ event) => {
          this.typed = emptyTyped(/** @type {HTMLSelectElement} */ (event.target).value, this.typed);
          this.draw();
          this.querySelector("select")?.focus();
        } }, LAYOUTS.map((layout) => h("option", { value: layout }, t(`doppler_site.layout_${layout}`))))),
      h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": t("report.site") }, h("table", { class: "edit" },
        h("thead", null, h("tr", null, h("th", { scope: "col" }, t("site.name")), PLACES.map((axis) => h("th", { scope: "col" }, t(`doppler_site.${axis}`))))),
        h("tbody", null, GROUPS.flatMap((group) => this.typed[group].map((place, i) => h("tr", null,
          h("td", { class: "text" }, this.input(`${group}.${i}.name`, place, "name", t("site.name"), `${t(`site.${group}`)} ${i + 1}: `)),
          PLACES.map((axis) => h("td", null, this.input(`${group}.${i}.${axis}`, place, axis, t(`doppler_site.${axis}`), `${place.name}: `))))))))),
      h("div", { class: "row" }, NUMBERS.map((name) => {
        const id = uniqueId(name);
        return h("div", { class: "field" }, h("label", { for: id, class: "small muted" }, t(`doppler_site.${name}`)), this.input(name, this.typed, name, "", "", id));
      })),
      h("p", { class: "small muted" }, t("doppler_site.hint")),
      h("div", null, h("button", { type: "submit", class: "primary" }, t("doppler_site.send"))),
      this.message));
  }

  /** @param {string} field @param {Record<string, any>} holder @param {string} key @param {string} title @param {string} before @param {string} [id] */
  input(field, holder, key, title, before, id) {
    const text = key === "name";
    return h("input", { type: "text", id: id ?? null, value: holder[key], "aria-label": id ? null : before + title, autocomplete: "off", inputmode: text ? null : "decimal", data: { field },
      oninput: (/** @type {Event} */ event) => {
        const input = /** @type {HTMLInputElement} */ (event.target);
        holder[key] = input.value;
        input.removeAttribute("aria-invalid");
      } });
  }

  async send() {
    const found = siteFrom(this.typed, this.site);
    const message = /** @type {HTMLElement} */ (this.message);
    if ("wrong" in found) {
      const input = /** @type {HTMLInputElement | null} */ (this.querySelector(`[data-field="${found.wrong}"]`));
      input?.setAttribute("aria-invalid", "true");
      put(message, h("p", { class: "bad" }, t("doppler_site.wrong", { field: input?.labels?.[0]?.textContent || input?.getAttribute("aria-label") || found.wrong })));
      input?.focus();
      return;
    }
    put(message, h("p", { role: "status", class: "muted" }, t("upload.reading")));
    try {
      this.onread(/** @type {Recording} */ (await post("recordings", { from_recording_id: this.recordingId, site: found.site })));
      put(message);
    } catch (error) {
      put(message, failed(error));
    }
  }
}

define("doppler-site-form", DopplerSiteForm);

/** The form, folded where there is a site; none where its places are on the globe. @param {Recording} recording @param {(recording: Recording) => void} onread */
export function dopplerSiteForm(recording, onread) {
  if (recording.site && !typedOf(recording.site)) return null;
  const form = /** @type {DopplerSiteForm} */ (document.createElement("doppler-site-form"));
  Object.assign(form, { recordingId: recording.id, site: recording.site, onread });
  return recording.site ? h("details", null, h("summary", null, t("doppler_site.change")), form) : form;
}
