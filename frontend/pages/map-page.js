// @ts-check
// Accuracy map: what one mark can say at each place, for a site that can be changed on the plan itself. One request is
// under way at a time; while a station is dragged the map is coarser, so that it follows.

import { define, h, put, uniqueId } from "../js/dom.js";
import { Problem, get, post } from "../js/api.js";
import { said, t } from "../js/i18n.js";
import { formatNumber } from "../js/numbers.js";
import { rememberQuery } from "../js/router.js";
import { setTitle } from "../components/app-frame.js";
import { chartPanel } from "../components/chart-panel.js";
import { dataTable } from "../components/data-table.js";
import { failed, loading } from "../components/states.js";
import "../components/station-handles.js";

/** @import { AccuracyMap, Recording, Scenario } from "../types.d.ts" */
/** @import { Route } from "../js/router.js" */
/** @import { StationHandles } from "../components/station-handles.js" */

/** @typedef {AccuracyMap["site"]["stations"][number]} Station */

const VARIANTS = /** @type {const} */ (["space", "altitude_measured", "altitude_known", "altitude_gain", "clock"]);
const NUMBERS = /** @type {const} */ (["altitude_m", "sigma_toa_ns", "sigma_altitude_m"]);
const AXES = /** @type {const} */ (["east_m", "north_m", "up_m"]);
const WAIT_MS = 150;
const WHOLE = 200;
const COARSE = 100;

class MapPage extends HTMLElement {
  /** @type {Route} */
  route = { path: [], query: new URLSearchParams() };
  /** @type {AccuracyMap | null} */
  shown = null;
  /** The site once it was changed here. @type {AccuracyMap["site"] | null} */
  site = null;
  /** Names of stations that do not receive. @type {Set<string>} */
  silent = new Set();
  /** Where the map lies, once it is known: it stays while stations are moved. @type {{east_m: any, north_m: any} | null} */
  frame = null;
  /** What is filled in for each station. @type {Map<string, {hears: HTMLInputElement, fields: HTMLInputElement[], clock: HTMLElement}>} */
  cells = new Map();
  busy = false;
  again = false;
  coarse = false;
  timer = 0;

  async connectedCallback() {
    setTitle(t("map.title"));
    this.stop = new AbortController();
    put(this, loading());
    try {
      const [scenarios, recordings] = await Promise.all([
        /** @type {Promise<{items: Scenario[]}>} */ (get("scenarios", { signal: this.stop.signal })),
        /** @type {Promise<{items: Recording[]}>} */ (get("recordings", { query: { limit: 200 }, signal: this.stop.signal })),
      ]);
      this.presets = scenarios.items.filter((one) => one.kind === "toa_marks");
      this.recordings = recordings.items.filter((one) => one.kind === "toa_marks" && one.site);
    } catch (error) {
      if (!this.stop.signal.aborted) put(this, h("h1", { class: "sr-only" }, t("map.title")), failed(error, { retry: () => this.connectedCallback() }));
      return;
    }
    this.draw();
  }

  disconnectedCallback() {
    this.stop?.abort();
    clearTimeout(this.timer);
  }

  /** The address was changed by a link or by going back. */
  queryChanged() {
    this.draw();
  }

  draw() {
    const { query } = this.route;
    this.site = siteOf(query.get("site"));
    this.silent = new Set(query.getAll("without"));
    this.frame = null;
    this.cells = new Map();
    const field = (/** @type {string} */ label, /** @type {HTMLElement} */ input, /** @type {string} */ id) => h("div", { class: "field" }, h("label", { for: id }, label), input);
    const source = uniqueId("source");
    this.source = h("select", { id: source, onchange: () => this.changeSource() },
      h("optgroup", { label: t("map.presets") }, (this.presets ?? []).map((one) => h("option", { value: `scenario:${one.name}` }, said(one.title)))),
      this.recordings?.length ? h("optgroup", { label: t("map.recordings") }, this.recordings.map((one) => h("option", { value: `recording:${one.id}` }, one.name))) : null);
    this.source.value = query.get("source") ?? "";
    if (this.source.selectedIndex < 0) this.source.selectedIndex = 0;
    const variant = uniqueId("variant");
    this.variant = h("select", { id: variant, onchange: () => this.ask() }, VARIANTS.map((one) => h("option", { value: one }, t(`map.variant.${one}`))));
    this.variant.value = query.get("variant") ?? "space";
    if (this.variant.selectedIndex < 0) this.variant.selectedIndex = 0;
    const quantity = uniqueId("quantity");
    this.quantity = h("select", { id: quantity, onchange: () => this.ask() }, h("option", { value: "drms_m" }, "DRMS"), h("option", { value: "gdop" }, "GDOP"));
    this.quantity.value = query.get("quantity") === "gdop" ? "gdop" : "drms_m";
    this.inputs = new Map(NUMBERS.map((name) => {
      const id = uniqueId(name);
      return [name, h("input", { id, type: "text", inputmode: "decimal", autocomplete: "off", value: query.get(name) ?? (name === "altitude_m" ? "10000" : ""), oninput: () => this.ask() })];
    }));
    this.message = h("div", { role: "status" });
    this.facts = h("p", { class: "small muted", role: "status" });
    this.panel = chartPanel({ source: "", heading: t("map.title"), class: "accuracy" });
    this.handles = /** @type {StationHandles} */ (document.createElement("station-handles"));
    this.handles.onmoved = (index, east, north, done) => this.moved(index, east, north, done);
    this.handles.follow(this.panel);
    this.stations = h("section", { class: "card" });
    this.subsets = h("section", { class: "card" });
    put(this,
      h("div", { class: "page-head" }, h("h1", null, t("map.title"))),
      h("div", { class: "map-page" },
        h("div", { class: "stack" },
          h("section", { class: "card" }, h("div", { class: "card-body stack" },
            field(t("map.source"), this.source, source), field(t("map.shows"), this.variant, variant), field(t("map.quantity"), this.quantity, quantity),
            ...NUMBERS.map((name) => field(t(`map.${name}`), /** @type {HTMLElement} */ (this.inputs?.get(name)), /** @type {string} */ (this.inputs?.get(name)?.id))))),
          this.stations),
        h("div", { class: "stack" }, this.message, this.panel, this.facts, this.subsets)));
    this.ask(true);
  }

  changeSource() {
    this.site = null;
    this.silent.clear();
    this.frame = null;
    this.ask(true);
  }

  /** What is asked for; null where a number cannot be read. @param {boolean} [subsets] */
  request(subsets = false) {
    /** @type {Record<string, any>} */
    const body = { variant: this.variant?.value, quantity: this.quantity?.value };
    for (const [name, input] of this.inputs ?? []) {
      const text = input.value.trim().replace(",", ".");
      const wrong = text !== "" && !Number.isFinite(Number(text));
      input.setAttribute("aria-invalid", String(wrong));
      if (wrong) return null;
      if (text !== "") body[name] = Number(text);
    }
    const [kind = "", ...rest] = (this.source?.value ?? "").split(":");
    const name = rest.join(":");
    if (this.site) body.site = this.site;
    else if (kind === "recording") body.recording_id = name;
    else body.scenario = { preset: name };
    const known = this.site?.stations ?? this.shown?.site.stations;
    if (this.silent.size && known) body.stations = known.map((one) => one.name).filter((one) => !this.silent.has(one));
    if (this.frame) {
      const count = this.coarse ? COARSE : WHOLE;
      for (const axis of /** @type {const} */ (["east_m", "north_m"])) body[axis] = { ...this.frame[axis], count };
    }
    if (subsets) body.subsets = true;
    return body;
  }

  /** @param {boolean} [now] */
  ask(now = false) {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.send(), now ? 0 : WAIT_MS);
  }

  async send() {
    if (this.busy) {
      this.again = true;
      return;
    }
    const body = this.request();
    if (!this.isConnected) return;
    if (!body) {
      this.outdated(true);
      return;
    }
    this.busy = true;
    try {
      /** @type {AccuracyMap} */
      const answer = await post("accuracy-map", body);
      // An address names the silent stations; who is left to receive is known from the first answer on.
      if (this.silent.size && !body.stations) this.again = true;
      if (this.isConnected) await this.show(answer);
    } catch (error) {
      if (this.isConnected) this.refuse(error);
    }
    this.busy = false;
    if (!this.again) return;
    this.again = false;
    this.send();
  }

  /** @param {unknown} error */
  refuse(error) {
    const items = error instanceof Problem ? error.errors : [];
    for (const [name, input] of this.inputs ?? []) if (items.some((item) => item.pointer === `/${name}`)) input.setAttribute("aria-invalid", "true");
    put(/** @type {HTMLElement} */ (this.message), failed(error, { retry: () => this.send() }));
    this.outdated(true);
  }

  /** The map is of what was asked before. @param {boolean} is */
  outdated(is) {
    for (const part of [this.panel, this.facts, this.stations]) part?.classList.toggle("stale", is);
  }

  /** @param {AccuracyMap} answer */
  async show(answer) {
    const sameStations = this.shown?.site.stations.map((one) => one.name).join() === answer.site.stations.map((one) => one.name).join();
    this.shown = answer;
    this.frame = { east_m: answer.east_m, north_m: answer.north_m };
    this.outdated(false);
    put(/** @type {HTMLElement} */ (this.message));
    put(/** @type {HTMLElement} */ (this.facts), t("map.facts", { share: formatNumber(100 * answer.observable_share, 3), median: answer.median === null ? "–" : formatNumber(answer.median, 3), unit: said(answer.unit) }));
    this.remember();
    const places = answer.places;
    // What is being dragged is ahead of the answer.
    if (!this.coarse) this.handles?.setPlaces(places.map((one) => ({ ...one })));
    if (!sameStations) put(/** @type {HTMLElement} */ (this.subsets), this.subsetsHead());
    if (!sameStations || !this.cells.size) this.drawStations(answer);
    this.fillStations(answer);
    await this.panel?.give(/** @type {any} */ (answer.chart));
    this.dataset.fresh = this.again ? "no" : "yes";
  }

  remember() {
    const values = Object.fromEntries([...(this.inputs ?? [])].map(([name, input]) => [name, input.value.trim() || null]));
    rememberQuery({ source: this.source?.value, variant: this.variant?.value, quantity: this.quantity?.value, ...values, without: [...this.silent], site: this.site ? JSON.stringify(this.site) : null });
  }

  /** The site with stations in metres, so that they can be moved. */
  editable() {
    if (!this.site && this.shown) {
      const { site, places, origin } = this.shown;
      const sigma = (/** @type {string} */ name) => site.stations.find((one) => one.name === name)?.sigma_toa_ns;
      this.site = { ...site, origin: origin ?? undefined, stations: places.map((one) => ({ ...one, sigma_toa_ns: sigma(one.name) })) };
    }
    return this.site;
  }

  /** @param {number} index @param {number} east @param {number} north @param {boolean} done */
  moved(index, east, north, done) {
    const site = this.editable();
    const station = site?.stations[index];
    if (!site || !station) return;
    station.east_m = Math.round(east);
    station.north_m = Math.round(north);
    this.coarse = !done;
    this.dataset.fresh = "no";
    this.send();
  }

  /** A row for each station; its numbers are filled in apart, so that a field keeps its focus. @param {AccuracyMap} answer */
  drawStations(answer) {
    this.cells = new Map(answer.places.map(({ name }, index) => [name, {
      hears: h("input", { type: "checkbox", onchange: (/** @type {Event} */ event) => this.hear(name, /** @type {HTMLInputElement} */ (event.target).checked) }),
      fields: AXES.map((axis) => this.field(index, name, axis)),
      clock: h("td", { class: "number" }),
    }]));
    put(/** @type {HTMLElement} */ (this.stations), h("div", { class: "card-head" }, h("h2", null, t("map.stations"))),
      h("div", { class: "table-wrap", tabindex: 0, role: "region", "aria-label": t("map.stations") }, h("table", { class: "edit" },
        h("thead", null, h("tr", null, [t("map.receives"), ...AXES.map((axis) => t(`map.${axis}`)), t("map.clock")].map((one) => h("th", { scope: "col" }, one)))),
        h("tbody", null, [...this.cells].map(([name, { hears, fields, clock }]) => h("tr", null,
          h("th", { scope: "row" }, h("label", { class: "row nowrap" }, hears, name)), fields.map((field) => h("td", null, field)), clock))))),
      h("p", { class: "small muted card-body" }, t("map.clock_hint")));
  }

  /** @param {number} index @param {string} name @param {typeof AXES[number]} axis */
  field(index, name, axis) {
    const input = h("input", {
      type: "text", inputmode: "decimal", "aria-label": `${t(`map.${axis}`)}, ${name}`, onchange: () => {
        const text = input.value.trim().replace(",", ".");
        const right = text !== "" && Number.isFinite(Number(text));
        input.setAttribute("aria-invalid", String(!right));
        const station = right ? this.editable()?.stations[index] : null;
        if (!station) return;
        station[axis] = Number(text);
        this.ask(true);
      },
    });
    return input;
  }

  /** @param {AccuracyMap} answer */
  fillStations(answer) {
    const clocks = new Map(answer.clocks.map((one) => [one.station, one]));
    for (const place of answer.places) {
      const cells = this.cells.get(place.name);
      if (!cells) continue;
      cells.hears.checked = !this.silent.has(place.name);
      put(cells.clock, clockWords(clocks.get(place.name)));
      for (const [k, field] of cells.fields.entries()) {
        if (field === document.activeElement) continue;
        field.value = String(Math.round(place[/** @type {typeof AXES[number]} */ (AXES[k])]));
        field.removeAttribute("aria-invalid");
      }
    }
  }

  /** @param {string} name @param {boolean} receives */
  hear(name, receives) {
    if (receives) this.silent.delete(name);
    else this.silent.add(name);
    this.ask(true);
  }

  subsetsHead() {
    return h("div", { class: "card-head" }, h("h2", null, t("map.subsets")),
      h("button", { type: "button", onclick: () => this.compareSubsets() }, t("map.compare_subsets")));
  }

  async compareSubsets() {
    const card = /** @type {HTMLElement} */ (this.subsets);
    const body = this.request(true);
    if (!body) return;
    delete body.stations;
    put(card, this.subsetsHead(), loading(2));
    try {
      /** @type {AccuracyMap} */
      const answer = await post("accuracy-map", { ...body, ...this.frame && { east_m: { ...this.frame.east_m, count: COARSE }, north_m: { ...this.frame.north_m, count: COARSE } } });
      const all = answer.site.stations.map((one) => one.name);
      put(card, this.subsetsHead(), dataTable({
        caption: t("map.subsets"), rows: answer.subsets ?? [], pageRows: 60,
        columns: [
          { title: t("map.stations"), head: true, cell: (row) => row.stations.join(", ") },
          { title: t("map.seen"), number: true, cell: (row) => `${formatNumber(100 * row.observable_share, 3)} %`, sort: (row) => row.observable_share },
          { title: answer.unit ? `${t("map.median")}, ${said(answer.unit)}` : t("map.median"), number: true, cell: (row) => formatNumber(row.median), sort: (row) => row.median },
          { title: t("map.quantile_90"), number: true, cell: (row) => formatNumber(row.quantile_90), sort: (row) => row.quantile_90 },
          { title: t("map.ratio"), number: true, cell: (row) => formatNumber(row.common_ratio), sort: (row) => row.common_ratio },
        ],
        onpick: (row) => {
          this.silent = new Set(all.filter((name) => !row.stations.includes(name)));
          this.ask(true);
        },
      }));
    } catch (error) {
      put(card, this.subsetsHead(), failed(error, { retry: () => this.compareSubsets() }));
    }
  }
}

/** @param {AccuracyMap["clocks"][number] | undefined} clock */
function clockWords(clock) {
  return clock?.median_m_per_ns == null ? "–" : `${formatNumber(clock.median_m_per_ns, 3)} (${formatNumber(clock.largest_m_per_ns, 3)})`;
}

/** @param {string | null} text @returns {AccuracyMap["site"] | null} */
function siteOf(text) {
  try {
    const site = JSON.parse(text ?? "null");
    return Array.isArray(site?.stations) ? site : null;
  } catch {
    return null;
  }
}

define("map-page", MapPage);
