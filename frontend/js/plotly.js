// @ts-check
// Plotly is a classic script of the server's own; it is fetched when the page has nothing else to do, or a chart is near.

import { get } from "./api.js";

/** @import { PlotlyLibrary, Meta } from "../types.d.ts" */

/** @type {Promise<PlotlyLibrary> | null} */
let loading = null;

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
