// @ts-check
// Whether a polygon is one, judged as the server judges it, so that a bad one is said while it is drawn.

/** @typedef {[number, number]} Point */
/** An edge by the numbers of its corners. @typedef {[number, number]} Edge */
/** @typedef {{place: "few"} | {place: "flat"} | {place: "crossing", edges: [Edge, Edge]}} PolygonFault */

// Sine of the angle below which three corners lie on one line.
const FLAT = 1e-14;

/**
 * What is wrong with the corners of a polygon, which are counted from 0; a corner that repeats the one before it, or
 * closes the polygon, is no fault.
 * @param {Point[]} corners
 * @returns {PolygonFault | null}
 */
export function polygonFault(corners) {
  const at = (/** @type {number} */ i) => /** @type {Point} */ (corners.at(i));
  const same = (/** @type {Point} */ a, /** @type {Point} */ b) => a[0] === b[0] && a[1] === b[1];
  const known = [...corners.keys()].filter((i) => !same(at(i), at(i - 1)));
  if (new Set(known.map((i) => at(i).join(" "))).size < 3) return { place: "few" };
  const [first = 0, second = 0] = known;
  if (known.every((i) => side(at(first), at(second), at(i)) === 0)) return { place: "flat" };
  /** @type {Edge[]} */
  const edges = known.map((i, k) => [i, known[(k + 1) % known.length] ?? 0]);
  for (const [k, one] of edges.entries()) {
    for (const [m, other] of edges.entries()) {
      if (m <= k) continue;
      const meet = m - k === 1 || m - k === edges.length - 1 ? folded : crossed;
      if (meet(at(one[0]), at(one[1]), at(other[0]), at(other[1]))) return { place: "crossing", edges: [one, other] };
    }
  }
  return null;
}

/** On which side of the line from a to b the point c lies: 1 left, -1 right, 0 on it. @param {Point} a @param {Point} b @param {Point} c */
function side(a, b, c) {
  const [one, other] = [(b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])];
  return Math.abs(one - other) <= FLAT * (Math.abs(one) + Math.abs(other)) ? 0 : Math.sign(one - other);
}

/** Whether neighbouring edges go back over each other. @param {Point} a @param {Point} b @param {Point} c @param {Point} d */
function folded(a, b, c, d) {
  const [shared, one, other] = b[0] === c[0] && b[1] === c[1] ? [b, a, d] : [a, b, c];
  const ahead = (one[0] - shared[0]) * (other[0] - shared[0]) + (one[1] - shared[1]) * (other[1] - shared[1]);
  return side(shared, one, other) === 0 && ahead > 0;
}

/** Whether edges have a point in common. @param {Point} a @param {Point} b @param {Point} c @param {Point} d */
function crossed(a, b, c, d) {
  for (const k of /** @type {const} */ ([0, 1])) if (Math.max(a[k], b[k]) < Math.min(c[k], d[k]) || Math.max(c[k], d[k]) < Math.min(a[k], b[k])) return false;
  const [ofC, ofD, ofA, ofB] = [side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)];
  if (ofC * ofD < 0 && ofA * ofB < 0) return true;
  return (ofC === 0 && within(c, a, b)) || (ofD === 0 && within(d, a, b)) || (ofA === 0 && within(a, c, d)) || (ofB === 0 && within(b, c, d));
}

/** @param {Point} p @param {Point} a @param {Point} b */
function within(p, a, b) {
  return /** @type {const} */ ([0, 1]).every((k) => Math.min(a[k], b[k]) <= p[k] && p[k] <= Math.max(a[k], b[k]));
}
