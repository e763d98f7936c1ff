// @ts-check
// From the site's local plane to latitude and longitude (WGS-84), and range and azimuth in the plane.

/** @typedef {{latitude_deg: number, longitude_deg: number, height_m?: number | null}} Origin */

const A = 6378137;
const F = 1 / 298.257223563;
const E2 = F * (2 - F);
const DEGREE = Math.PI / 180;
// Each pass gains three digits; five are enough for micrometres from the ground to space.
const PASSES = 5;

/**
 * Geodetic place of a point of the local east-north-up frame.
 * @param {Origin} origin
 * @param {number} east in m
 * @param {number} north in m
 * @param {number} [up] in m
 */
export function enuToGeodetic(origin, east, north, up = 0) {
  const [sinLat, cosLat] = [Math.sin(origin.latitude_deg * DEGREE), Math.cos(origin.latitude_deg * DEGREE)];
  const [sinLon, cosLon] = [Math.sin(origin.longitude_deg * DEGREE), Math.cos(origin.longitude_deg * DEGREE)];
  const height = origin.height_m ?? 0;
  const n0 = A / Math.sqrt(1 - E2 * sinLat ** 2);
  const outward = cosLat * up - sinLat * north;
  const x = (n0 + height) * cosLat * cosLon + cosLon * outward - sinLon * east;
  const y = (n0 + height) * cosLat * sinLon + sinLon * outward + cosLon * east;
  const z = (n0 * (1 - E2) + height) * sinLat + cosLat * north + sinLat * up;
  const p = Math.hypot(x, y);
  let latitude = Math.atan2(z, p * (1 - E2));
  for (let pass = 0; pass < PASSES; pass += 1) {
    const n = A / Math.sqrt(1 - E2 * Math.sin(latitude) ** 2);
    latitude = Math.atan2(z + E2 * n * Math.sin(latitude), p);
  }
  const n = A / Math.sqrt(1 - E2 * Math.sin(latitude) ** 2);
  const [s, c] = [Math.sin(latitude), Math.cos(latitude)];
  return { latitude_deg: latitude / DEGREE, longitude_deg: Math.atan2(y, x) / DEGREE, height_m: p * c + z * s - n * (1 - E2 * s * s) };
}

/**
 * Range in m and azimuth in degrees from north to east, 0 to 360.
 * @param {number} east
 * @param {number} north
 */
export function rangeAzimuth(east, north) {
  const azimuth = Math.atan2(east, north) / DEGREE;
  return { range_m: Math.hypot(east, north), azimuth_deg: azimuth < 0 ? azimuth + 360 : azimuth };
}

/**
 * A step of 1, 2 or 5 times a power of ten that divides a span into about `parts`.
 * @param {number} span
 * @param {number} parts
 */
export function niceStep(span, parts) {
  const rough = span / parts;
  const power = 10 ** Math.floor(Math.log10(rough));
  return ([1, 2, 5].find((one) => one * power >= rough) ?? 10) * power;
}
