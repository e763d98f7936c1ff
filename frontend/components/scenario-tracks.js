// @ts-check
// Targets from recorded tracks: a file is read, its longest tracks (or those that are named) replace the preset's targets.

import { h, put, uniqueId } from "../js/dom.js";
import { Problem, post } from "../js/api.js";
import { formatInstant, t } from "../js/i18n.js";
import { formatCount } from "../js/numbers.js";
import { failed } from "./states.js";

/** @import { ParametersSchema, TracksScenario } from "../types.d.ts" */

/** Whether the targets of a preset may follow points. @param {ParametersSchema} schema */
export function takesTracks(schema) {
  return Boolean(schema.$defs?.["Target"]?.properties?.["points"] && schema.properties?.["targets"]);
}

/**
 * A form in a fold.
 * @param {() => {preset: string | undefined, parameters: Record<string, unknown>}} now what the editor holds
 * @param {(made: TracksScenario) => void} onmade
 */
export function tracksForm(now, onmade) {
  const [file, most, names] = [uniqueId("tracks"), uniqueId("most"), uniqueId("names")];
  const message = h("div", { role: "status" });
  const chosen = h("input", { id: file, type: "file", "aria-describedby": `${file}-hint`, onchange: () => { send.disabled = !chosen.files?.length; } });
  const count = h("input", { id: most, type: "text", inputmode: "numeric", value: "10", autocomplete: "off", style: "width: 9ch" });
  const named = h("input", { id: names, type: "text", autocomplete: "off", placeholder: t("tracks_in.longest") });
  const send = h("button", { type: "submit", disabled: true }, t("tracks_in.read"));
  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    const [first] = chosen.files ?? [];
    if (!first) return;
    send.disabled = true;
    put(message, h("p", { class: "muted" }, t("upload.reading")));
    const { preset, parameters: { targets: _, ...parameters } } = now();
    const wanted = named.value.split(/[,;]\s*/).map((name) => name.trim()).filter(Boolean);
    const form = new FormData();
    form.append("file", first, first.name);
    form.append("options", JSON.stringify({ preset, parameters, tracks: { most_targets: Number(count.value) || 10, targets: wanted } }));
    try {
      /** @type {TracksScenario} */
      const made = await post("scenarios/from-tracks", form);
      put(message, told(made));
      onmade(made);
    } catch (error) {
      put(message, failed(error));
      if (!(error instanceof Problem)) throw error;
    } finally {
      send.disabled = false;
      if (document.activeElement === document.body) send.focus({ preventScroll: true });
    }
  };
  return h("details", { class: "panel" }, h("summary", null, t("tracks_in.title")),
    h("form", { class: "stack", onsubmit: submit, style: "padding: 12px" },
      h("div", { class: "field" }, h("label", { for: file }, t("tracks_in.file")), chosen, h("span", { class: "small muted", id: `${file}-hint` }, t("tracks_in.hint"))),
      h("div", { class: "field" }, h("label", { for: most }, t("tracks_in.most")), count),
      h("div", { class: "field" }, h("label", { for: names }, t("tracks_in.names")), named),
      h("div", { class: "row" }, send), message));
}

/** @param {TracksScenario} made */
function told(made) {
  const lost = made.tracks.filter((track) => track.problem);
  const from = made.start_utc ? t("tracks_in.from", { time: formatInstant(made.start_utc) }) : "";
  return h("div", null,
    h("p", null, t("tracks_in.made", { n: formatCount(made.tracks.length - lost.length), of: formatCount(made.tracks_found) }), " ", from),
    lost.length ? h("ul", { class: "small" }, lost.map((track) => h("li", null, `${track.name}: ${track.problem}`))) : null);
}
