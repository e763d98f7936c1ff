// @ts-check
// Plotly is a classic script of the server's own; it is fetched when the first chart becomes visible.

import { get } from "./api.js";

/** @import { PlotlyLibrary, Meta } from "../types.d.ts" */

/** @type {Promise<PlotlyLibrary> | null} */
let loading = null;
/** @type {boolean | null} */
let webgl = null;

/** Whether this browser gives drawing contexts of WebGL; where it does not, markers are drawn as SVG. */
export function hasWebgl() {
  if (webgl === null) {
    const context = document.createElement("canvas").getContext("webgl");
    webgl = context !== null;
    // Browsers keep few contexts alive; this one was only a question.
    context?.getExtension("WEBGL_lose_context")?.loseContext();
  }
  return webgl;
}

/** Remember that a context was taken away: from now on everything is SVG. */
export function giveUpWebgl() {
  webgl = false;
}

/** @returns {Promise<PlotlyLibrary>} */
export function loadPlotly() {
  loading ??= load().catch((error) => {
    loading = null; // a later chart may try again
    throw error;
  });
  return loading;
}

/** @returns {Promise<PlotlyLibrary>} */
async function load() {
  /** @type {Meta} */
  const meta = await get("meta");
  const script = document.createElement("script");
  script.src = new URL(`assets/plotly-${meta.plotly_js}.min.js`, document.baseURI).href;
  await new Promise((resolve, reject) => {
    script.addEventListener("load", resolve, { once: true });
    script.addEventListener("error", () => reject(new Error(`${script.src} was not delivered`)), { once: true });
    document.head.append(script);
  });
  if (!window.Plotly) throw new Error(`${script.src} is not Plotly`);
  return window.Plotly;
}
