// @ts-check
// The frame: rail, bar, the page of the route, and what must be said over every page (lost server, token).

import { define, h, put } from "../js/dom.js";
import { icon } from "../js/icons.js";
import { connection, get } from "../js/api.js";
import { LANGUAGES, language, setLanguage, t } from "../js/i18n.js";
import { THEMES, setTheme, theme } from "../js/theme.js";
import { parseRoute } from "../js/router.js";
import "./engine-state.js";
import "./keyboard-help.js";
import { toast } from "./toast-area.js";
import "./drop-zone.js";
import "./token-form.js";
import { failed } from "./states.js";

/** @import { Key, Language } from "../js/i18n.js" */
/** @import { Route } from "../js/router.js" */

/** @type {{name: string, key: Key}[]} */
const PLACES = [
  { name: "runs", key: "nav.runs" },
  { name: "new", key: "nav.new" },
  { name: "recordings", key: "nav.recordings" },
  { name: "scenarios", key: "nav.scenarios" },
  { name: "studies", key: "nav.studies" },
  { name: "map", key: "nav.map" },
  { name: "algorithms", key: "nav.algorithms" },
];

/** First part of the route -> [element without an id, element with an id]. Pages are loaded when visited. */
const PAGES = /** @type {Record<string, [string, string | null]>} */ ({
  runs: ["runs-page", "run-page"],
  new: ["new-page", null],
  compare: ["compare-page", null],
  recordings: ["recordings-page", "recording-page"],
  scenarios: ["scenarios-page", null],
  studies: ["studies-page", "study-page"],
  map: ["map-page", null],
  algorithms: ["algorithms-page", "algorithm-page"],
  about: ["about-page", null],
});

/** A page is told its route when it is made, and when only the query of its address changes. */
/** @typedef {HTMLElement & {route: Route, queryChanged?: (query: URLSearchParams) => void}} PageElement */

const FIND_AGAIN_MS = 2000;
// Once the first page stands, the others are fetched too: going to them then needs no server.
const LOAD_PAGES_AFTER_MS = 1000;

function loadPages() {
  for (const tag of Object.values(PAGES).flat()) if (tag) import(`../pages/${tag}.js`).catch(() => undefined);
  // The library of the charts takes half a second to start: while nobody waits for it.
  const charts = () => import("../js/plotly.js").then(({ loadPlotly }) => loadPlotly()).catch(() => undefined);
  if (window.requestIdleCallback) window.requestIdleCallback(charts);
  else charts();
}

class AppFrame extends HTMLElement {
  /** The route whose page is drawn. */
  shown = "";
  /** @type {PageElement | undefined} */
  page = undefined;
  /** @type {number | undefined} */
  finder = undefined;

  connectedCallback() {
    this.stop = new AbortController();
    const { signal } = this.stop;
    window.addEventListener("hashchange", () => this.show(), { signal });
    connection.addEventListener("lost", () => this.onLost(), { signal });
    connection.addEventListener("found", () => this.onFound(), { signal });
    connection.addEventListener("unauthorised", () => this.askToken(), { signal });
    document.addEventListener("filterroom:title", (event) => {
      const { title, where } = /** @type {CustomEvent<{title: string, where: string}>} */ (event).detail;
      document.title = `${title} · Filter Room`;
      if (this.where) this.where.textContent = where;
    }, { signal });
    this.draw();
  }

  disconnectedCallback() {
    this.stop?.abort();
  }

  draw() {
    const help = document.createElement("keyboard-help");
    this.where = h("span", { class: "where clip" });
    this.rail = h("nav", { class: "rail", id: "rail", "aria-label": t("nav.label") },
      h("a", { class: "brand", href: "#/runs" }, h("img", { src: "icon.svg", alt: "", width: 18, height: 18 }), "Filter Room"),
      PLACES.map(({ name, key }) => h("a", { href: `#/${name}`, data: { place: name } }, icon(name), t(key))),
      h("a", { class: "last", href: "#/about", data: { place: "about" } }, icon("about"), t("nav.about")));
    this.lostLine = h("div", { class: "lost", role: "status", hidden: true }, t("connection.lost"));
    const engine = /** @type {import("./engine-state.js").EngineState} */ (document.createElement("engine-state"));
    engine.line = h("div", { class: "trouble", role: "status", hidden: true });
    this.outlet = h("main", { id: "main", tabindex: -1 });
    const menu = h("button", { class: "menu-button", type: "button", "aria-label": t("nav.menu"), "aria-expanded": "false", "aria-controls": "rail" }, icon("menu"));
    menu.addEventListener("click", () => menu.setAttribute("aria-expanded", String(this.rail?.classList.toggle("open"))));
    this.menu = menu;
    put(this,
      h("a", { class: "skip", href: "#main", onclick: (/** @type {Event} */ event) => { event.preventDefault(); this.outlet?.focus(); } }, t("nav.skip")),
      this.rail,
      h("header", { class: "bar" },
        menu, this.where,
        engine,
        chooser(t("bar.language"), LANGUAGES.map((name) => [name, name.toUpperCase()]), language(), (name) => this.chooseLanguage(/** @type {Language} */ (name))),
        chooser(t("bar.theme"), THEMES.map((name) => [name, t(`theme.${name}`)]), theme(), (name) => setTheme(/** @type {"auto"} */ (name))),
        h("button", { type: "button", "aria-label": t("keys.title"), onclick: () => help.togglePopover() }, "?")),
      h("div", { class: "content" }, this.lostLine, engine.line, this.outlet),
      help, document.createElement("toast-area"), document.createElement("drop-zone"));
    this.shown = "";
    this.show();
  }

  /** Show the page of the address, or tell the page that its query changed. */
  async show() {
    const route = parseRoute(location.hash);
    const key = route.path.join("/");
    if (key === this.shown && this.page?.queryChanged) {
      this.page.route = route;
      this.page.queryChanged(route.query);
      return;
    }
    this.shown = key;
    const [place = "runs", id] = route.path;
    const tag = (id === undefined ? PAGES[place]?.[0] : PAGES[place]?.[1]) ?? "missing-page";
    try {
      await import(`../pages/${tag}.js`);
    } catch (error) {
      if (this.shown !== key || !this.outlet) return;
      this.page = undefined;
      put(this.outlet, failed(error, { retry: () => location.reload() }));
      get("meta").catch(() => undefined); // tells the frame when it is the server that is away
      return;
    }
    if (this.shown !== key || !this.outlet) return;
    const page = /** @type {PageElement} */ (document.createElement(tag));
    page.route = route;
    const first = !this.page;
    this.page = page;
    for (const link of this.querySelectorAll("[data-place]")) {
      if (/** @type {HTMLElement} */ (link).dataset.place === place) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
    this.rail?.classList.remove("open");
    this.menu?.setAttribute("aria-expanded", "false");
    put(this.outlet, page);
    window.scrollTo(0, 0);
    if (!first) this.outlet.focus({ preventScroll: true });
    else setTimeout(loadPages, LOAD_PAGES_AFTER_MS);
  }

  /** @param {Language} name */
  async chooseLanguage(name) {
    localStorage.setItem("filterroom.language", name);
    await setLanguage(name);
    this.page = undefined;
    this.draw();
  }

  onLost() {
    if (this.lostLine) this.lostLine.hidden = false;
    this.outlet?.classList.add("stale");
    this.finder ??= window.setInterval(() => get("meta").catch(() => undefined), FIND_AGAIN_MS);
  }

  onFound() {
    window.clearInterval(this.finder);
    this.finder = undefined;
    if (this.lostLine) this.lostLine.hidden = true;
    toast(t("connection.found"));
    this.outlet?.classList.remove("stale");
    // What failed to load meanwhile is loaded by drawing the page again; a form in work is left alone.
    if (this.outlet?.querySelector(".failure") && !this.outlet.querySelector("form")) {
      this.shown = "";
      this.show();
    }
  }

  askToken() {
    if (!this.outlet || this.outlet.querySelector("token-form")) return;
    this.shown = "token";
    put(this.outlet, document.createElement("token-form"));
  }
}

/**
 * @param {string} label
 * @param {readonly (readonly [string, string])[]} options
 * @param {string} chosen
 * @param {(value: string) => void} onchoice
 */
function chooser(label, options, chosen, onchoice) {
  return h("select", {
    "aria-label": label, value: chosen, style: "width: auto",
    onchange: (/** @type {Event} */ event) => onchoice(/** @type {HTMLSelectElement} */ (event.target).value),
  }, options.map(([value, text]) => h("option", { value }, text)));
}

/**
 * Set the words of the browser's tab, and of the bar where these would only repeat the page's heading.
 * @param {string} title
 * @param {string} [where]
 */
export function setTitle(title, where = title) {
  document.dispatchEvent(new CustomEvent("filterroom:title", { detail: { title, where } }));
}

define("app-frame", AppFrame);
