// @ts-check
// The site of a recording of Dopplers as a form has it: places of transmitters and receivers as typed, and back.

import { parseNumber } from "./numbers.js";

/** @import { Site, Station } from "../types.d.ts" */

export const GROUPS = /** @type {const} */ (["transmitters", "receivers"]);
export const PLACES = /** @type {const} */ (["east_m", "north_m", "up_m"]);
export const NUMBERS = /** @type {const} */ (["wavelength_m", "sigma_doppler_hz"]);
/** Transmitters and receivers that the columns of a recording can belong to. */
export const LAYOUTS = /** @type {const} */ (["1x2", "2x1", "2x2", "1x1"]);

/** @typedef {{name: string, east_m: string, north_m: string, up_m: string}} Place what was typed */
/** @typedef {{transmitters: Place[], receivers: Place[], wavelength_m: string, sigma_doppler_hz: string}} Typed */

/** Nothing typed yet. @param {string} layout @param {Typed} [kept] what stands in it already */
export function emptyTyped(layout, kept) {
  const [transmitters = 1, receivers = 2] = layout.split("x").map(Number);
  const places = (/** @type {string} */ prefix, /** @type {number} */ count, /** @type {Place[]} */ known) =>
    Array.from({ length: count }, (_, i) => known[i] ?? { name: count === 1 ? prefix : `${prefix}${i + 1}`, east_m: "", north_m: "", up_m: "0" });
  return /** @type {Typed} */ ({
    transmitters: places("TX", transmitters, kept?.transmitters ?? []), receivers: places("RX", receivers, kept?.receivers ?? []),
    wavelength_m: kept?.wavelength_m ?? "", sigma_doppler_hz: kept?.sigma_doppler_hz ?? "",
  });
}

/** What a site has, as if typed; null where its places are not in metres. @param {Site} site @returns {Typed | null} */
export function typedOf(site) {
  const groups = GROUPS.map((group) => site[group] ?? []);
  if (groups.some((places) => !places.length || places.some((place) => typeof place.east_m !== "number"))) return null;
  const text = (/** @type {unknown} */ value) => (typeof value === "number" ? String(value) : "");
  const place = (/** @type {Station} */ one) => ({ name: String(one.name), east_m: text(one.east_m), north_m: text(one.north_m), up_m: text(one.up_m ?? 0) });
  const values = /** @type {Record<string, unknown>} */ (/** @type {unknown} */ (site));
  return { transmitters: (groups[0] ?? []).map(place), receivers: (groups[1] ?? []).map(place), wavelength_m: text(values.wavelength_m), sigma_doppler_hz: text(values.sigma_doppler_hz) };
}

/** @param {Typed} typed */
export function layoutOf(typed) {
  return `${typed.transmitters.length}x${typed.receivers.length}`;
}

/**
 * The site that was typed, over what the old one says of other things; or the first field that is no number.
 * @param {Typed} typed
 * @param {Site | null} before
 * @returns {{site: Record<string, unknown>} | {wrong: string}}
 */
export function siteFrom(typed, before) {
  /** @type {Record<string, unknown>} */
  const site = { ...before };
  for (const group of GROUPS) {
    /** @type {Record<string, unknown>[]} */
    const places = [];
    for (const [i, place] of typed[group].entries()) {
      /** @type {Record<string, unknown>} */
      const read = { name: place.name.trim() };
      for (const axis of PLACES) {
        const value = parseNumber(place[axis]);
        if (value === null || !Number.isFinite(value)) return { wrong: `${group}.${i}.${axis}` };
        read[axis] = value;
      }
      places.push(read);
    }
    site[group] = places;
  }
  for (const name of NUMBERS) {
    const text = typed[name].trim();
    const value = text ? parseNumber(text) : null;
    // The error of the Dopplers may stay open; a run then takes its own.
    if (text ? !(value !== null && value > 0 && Number.isFinite(value)) : name === "wavelength_m") return { wrong: name };
    if (value === null) delete site[name];
    else site[name] = value;
  }
  return { site };
}
