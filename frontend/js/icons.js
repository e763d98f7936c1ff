// @ts-check
// Small line drawings; each state has its own shape as well as its colour.

import { svg } from "./dom.js";

/** @type {Record<string, string>} */
const PATHS = {
  runs: "M2 4h12M2 8h12M2 12h8",
  new: "M8 3v10M3 8h10",
  recordings: "M4 2h5l3 3v9H4zM9 2v3h3M6 8h4M6 11h4",
  scenarios: "M2 13c2-8 5-9 7-6s4 1 5-4M2 13h.1M5.5 12.5h.1M12 12h.1",
  studies: "M3 2h8l2 2v10H3zM5.5 6h5M5.5 8.5h5M5.5 11h3",
  map: "M8 13.5a5.5 5.5 0 1 0 0-11 5.5 5.5 0 0 0 0 11zM8 10.500a2.500 2.500 0 1 0 0-5 2.500 2.500 0 0 0 0 5zM8 8v.1",
  algorithms: "M2 12c3 0 3-8 6-8s3 8 6 8M2 14h12",
  about: "M8 7v4M8 5v.1M8 14a6 6 0 1 1 0-12 6 6 0 0 1 0 12z",
  menu: "M2 4h12M2 8h12M2 12h12",
  queued: "M8 14A6 6 0 1 1 8 2a6 6 0 0 1 0 12z",
  running: "M8 2a6 6 0 0 1 0 12",
  succeeded: "M2.5 8.5l3.5 3.5 7.5-8",
  failed: "M3 3l10 10M13 3L3 13",
  cancelled: "M2.5 8h11",
  more: "M3 8v.1M8 8v.1M13 8v.1",
  expand: "M9 2h5v5M7 14H2V9M14 2L9 7M2 14l5-5",
  table: "M2 3h12v10H2zM2 6.5h12M2 10h12M6 3v10",
  play: "M5 3l8 5-8 5z",
  pause: "M5 3v10M11 3v10",
  back: "M11 3L6 8l5 5M4 3v10",
  forward: "M5 3l5 5-5 5M12 3v10",
  recommended: "M8 2l1.800 3.800 4.200.5-3.100 2.900.800 4.100L8 11.300 4.300 13.300l.800-4.100L2 6.300l4.200-.5z",
  close: "M4 4l8 8M12 4l-8 8",
  edit: "M3 13l.7-3L11 2.7l2.3 2.3L6 12.3zM9.5 4.2l2.3 2.3",
  again: "M13 8a5 5 0 1 1-1.6-3.7M13 2v3h-3",
  delete: "M3 4.5h10M6.5 4V2.5h3V4M4.5 4.5l.5 9h6l.5-9M7 7v4M9 7v4",
};

/** @param {string} name */
export function icon(name) {
  const shape = { parsing: "running", ready: "succeeded" }[name] ?? name;
  return svg("svg", {
    viewBox: "0 0 16 16", fill: "none", stroke: "currentColor",
    "stroke-width": shape === "more" || shape === "cancelled" ? 2.4 : 1.6, "stroke-linecap": "round", "stroke-linejoin": "round", "aria-hidden": "true",
  }, svg("path", { d: PATHS[shape] ?? "" }));
}
