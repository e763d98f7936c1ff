// @ts-check
// The answer of a Monte Carlo run: who is more accurate on the same draws, over which swept values that holds, and
// whether the best one's claims are honest. Made from the tables `comparisons` and `metrics`, no stronger than they are.

import { FEWER_ANSWERS } from "./verdict.js";

/** @import { Row } from "./tables.js" */

const METRIC = "rms_horizontal_m";
// A claimed error within this factor of the actual one counts as honest.
const HONEST = 1.25;
// More conditions than these are counted, not listed.
const MOST_PLACES = 4;

/**
 * @typedef {{value: number, low: number | null, high: number | null}} Amount
 * @typedef {{kind: "no_truth"}
 *   | {kind: "alone", label: string, from: Amount, to: Amount, at: [string, string]}
 *   | {kind: "best", label: string, next: string, ratio: Amount, value: Amount | null}
 *   | {kind: "larger", others: {next: string, ratio: Amount}[]}
 *   | {kind: "no_difference", label: string, next: string, ratio: Amount}
 *   | {kind: "everywhere", label: string, next: string, least: Amount, most: Amount}
 *   | {kind: "even_everywhere", label: string, next: string}
 *   | {kind: "somewhere", label: string, next: string, better: number, of: number, most: Amount | null, at: string, even: Places | null, worse: Places | null}
 *   | {kind: "setting", at: string, most: Amount, even: Places | null}
 *   | {kind: "coverage", label: string, share: number, best: string, bestShare: number}
 *   | {kind: "honesty", label: string, legs: Leg[], swept: boolean}} TrialSentence
 * @typedef {{name: string, ratio: number, word: "honest" | "small" | "large"}} Leg
 * @typedef {{at: string, more: number, count: number, of: number}} Places where some cases are, and how many of them that leaves out
 */

/** Which label the name of a series belongs to: `rdfv, sigma_altitude_m = 10`. @param {string} name @param {string[]} labels */
export function ownerOf(name, labels) {
  return labels.filter((label) => name === label || name.startsWith(`${label}, `)).sort((a, b) => b.length - a.length)[0] ?? name;
}

/** @param {Row} row @param {string[]} names swept ones */
function partsOf(row, names) {
  return names.filter((name) => row[name] !== null && row[name] !== undefined).map((name) => `${name.slice(name.lastIndexOf(".") + 1)} = ${row[name]}`);
}

/** @param {Row} row @param {string[]} names swept ones */
const wordsOf = (row, names) => partsOf(row, names).join(", ");

/** What stands behind the label in the name of a series: `a = 1`, `b = 2`. @param {string} words */
const settingsOf = (words) => words.split(/, (?=[^,=]+ = )/).filter(Boolean);

/** @param {unknown} value */
const number = (value) => (typeof value === "number" ? value : null);

/**
 * @param {{metrics: Row[], comparisons: Row[], labels: string[], target?: string}} found
 * @returns {TrialSentence[]}
 */
export function trialVerdict({ metrics, comparisons, labels, target = "" }) {
  const about = (/** @type {Row} */ row) => !row.segment && String(row.target ?? "") === target;
  const errors = metrics.filter((row) => row.metric === METRIC && about(row) && number(row.value) !== null);
  if (!errors.length) return [{ kind: "no_truth" }];
  const pairs = comparisons.filter((row) => row.metric === METRIC && about(row) && number(row.ratio) !== null);
  const across = pairs.filter((row) => ownerOf(String(row.label), labels) !== ownerOf(String(row.against), labels));
  const { sentences, best } = across.length ? between(across, errors, labels) : within(pairs, errors, labels);
  const fewer = across.length ? coverageOf(metrics.filter(about), best) : null;
  const honesty = honestyOf(metrics, best, target);
  return [...sentences, fewer, honesty].filter((one) => one !== null);
}

/** Who answered another share of the marks than the best one, by the largest difference. @param {Row[]} metrics @param {string} best @returns {TrialSentence | null} */
function coverageOf(metrics, best) {
  /** @type {Map<string, number[]>} */
  const shares = new Map();
  for (const row of metrics) {
    const share = row.metric === "answered_share" ? number(row.value) : null;
    if (share !== null) shares.set(String(row.label), [...(shares.get(String(row.label)) ?? []), share]);
  }
  const means = [...shares].map(([label, list]) => ({ label, share: list.reduce((sum, one) => sum + one, 0) / list.length }));
  const bestShare = means.find((one) => one.label === best)?.share;
  if (bestShare === undefined) return null;
  const far = means.map((one) => ({ ...one, off: Math.abs(one.share - bestShare) })).sort((a, b) => b.off - a.off)[0];
  return far && far.off > FEWER_ANSWERS ? { kind: "coverage", label: far.label, share: far.share, best, bestShare } : null;
}

/** Rows of one pair seen from `label`: its error over that of the other one, and the other way round. @param {Row} row @param {string} label @param {string[]} labels */
function seenFrom(row, label, labels) {
  const own = ownerOf(String(row.label), labels) === label;
  const [ratio, low, high] = [number(row.ratio), number(row.ratio_low), number(row.ratio_high)];
  const verdict = String(row.verdict);
  const inverse = (/** @type {number | null} */ value) => (value ? 1 / value : null);
  return {
    next: String(own ? row.against : row.label),
    name: String(own ? row.label : row.against),
    // How many times larger the error of the other one is.
    times: own ? { value: inverse(ratio) ?? NaN, low: inverse(high), high: inverse(low) } : { value: ratio ?? NaN, low, high },
    result: verdict === "no_difference" ? "even" : (verdict === "smaller") === own ? "better" : "worse",
  };
}

/** Algorithm against algorithm. @param {Row[]} rows @param {Row[]} errors @param {string[]} labels */
function between(rows, errors, labels) {
  const known = labels.filter((label) => rows.some((row) => [row.label, row.against].some((name) => ownerOf(String(name), labels) === label)));
  const of = (/** @type {string} */ label) => rows.filter((row) => [row.label, row.against].some((name) => ownerOf(String(name), labels) === label)).map((row) => ({ row, ...seenFrom(row, label, labels) }));
  const score = (/** @type {string} */ label) => of(label).reduce((sum, one) => sum + (one.result === "better" ? 1 : one.result === "worse" ? -1 : 0) + (one.times.value > 1 ? 1e-3 : -1e-3), 0);
  const best = known.map((label) => ({ label, score: score(label) })).sort((a, b) => b.score - a.score)[0]?.label ?? labels[0] ?? "";
  /** @type {TrialSentence[]} */
  const sentences = [];
  const others = known.filter((label) => label !== best);
  const seen = others.map((other) => ({ other, list: of(best).filter((one) => ownerOf(one.next, labels) === other) }))
    .sort((a, b) => smallest(a.list) - smallest(b.list));
  for (const { other, list } of seen) {
    const [one, ...more] = list;
    if (!one) continue;
    if (!more.length) {
      const row = errors.find((found) => found.label === best);
      const value = row ? { value: Number(row.value), low: number(row.ci95_low), high: number(row.ci95_high) } : null;
      sentences.push(one.result === "even" ? { kind: "no_difference", label: best, next: other, ratio: one.times } : { kind: "best", label: best, next: other, ratio: one.times, value });
      continue;
    }
    sentences.push(overCases(list.map((each) => ({ ...each, cell: conditionsOf(each.row, best, other, labels) })), best, other));
  }
  return { sentences: shortened(sentences), best };
}

/**
 * One against another over all cases of a sweep: how often and by how much, and where not.
 * @param {{times: Amount, result: string, cell: string[]}[]} list @param {string} label @param {string} next @returns {TrialSentence}
 */
function overCases(list, label, next) {
  const of = (/** @type {string} */ result) => list.filter((one) => one.result === result);
  const better = of("better").sort((a, b) => a.times.value - b.times.value);
  const [least, most] = [better[0], better[better.length - 1]];
  if (of("even").length === list.length) return { kind: "even_everywhere", label, next };
  if (least && most && better.length === list.length) return { kind: "everywhere", label, next, least: least.times, most: most.times };
  const [even, worse] = ["even", "worse"].map((result) => placesOf(of(result).map((one) => one.cell), list.map((one) => one.cell)));
  return { kind: "somewhere", label, next, better: better.length, of: list.length, most: most?.times ?? null, at: most?.cell.join(", ") ?? "", even: even ?? null, worse: worse ?? null };
}

/**
 * Where some of all cases are, by the fewest conditions that hold for these cases alone.
 * @param {string[][]} some @param {string[][]} all conditions of each case @returns {Places | null}
 */
export function placesOf(some, all) {
  if (!some.length) return null;
  const key = (/** @type {string[]} */ cell) => cell.join(", ");
  const inside = new Set(some.map(key));
  const alone = [...new Set(some.flat())].filter((part) => all.every((cell) => !cell.includes(part) || inside.has(key(cell))));
  let left = some;
  /** @type {string[]} */
  const chosen = [];
  while (left.length && chosen.length < MOST_PLACES) {
    const gain = (/** @type {string} */ part) => left.filter((cell) => cell.includes(part)).length;
    const next = alone.reduce((one, part) => (gain(part) > (one ? gain(one) : 0) ? part : one), "");
    if (!next) break;
    chosen.push(next);
    left = left.filter((cell) => !cell.includes(next));
  }
  const rest = left.length <= 2 && chosen.length + left.length <= MOST_PLACES ? left.map(key) : [];
  return { at: joined([...alone.filter((part) => chosen.includes(part)), ...rest]), more: rest.length ? 0 : left.length, count: some.length, of: all.length };
}

/** The first of several rivals is told in full, the others after it by their names and ratios, or by counts of cases, alone. @param {TrialSentence[]} sentences */
function shortened(sentences) {
  /** @type {{next: string, ratio: Amount}[]} */
  const others = [];
  const kept = sentences.filter((one, i) => {
    if (one.kind !== "best" || i === 0) return true;
    others.push({ next: one.next, ratio: one.ratio });
    return false;
  });
  /** @type {TrialSentence[]} */
  const larger = others.length ? [{ kind: "larger", others }] : [];
  const counted = (/** @type {Places | null} */ places) => places && { ...places, at: "" };
  return [...kept.map((one, i) => (i && one.kind === "somewhere" ? { ...one, even: counted(one.even), worse: counted(one.worse) } : one)), ...larger];
}

/** @param {{times: Amount}[]} list */
function smallest(list) {
  return Math.min(...list.map((one) => one.times.value));
}

/** Under what two algorithms are compared in a row. @param {Row} row @param {string} best @param {string} other @param {string[]} labels */
function conditionsOf(row, best, other, labels) {
  const swept = partsOf(row, Object.keys(row).filter((name) => name.startsWith("scenario.")));
  const own = [row.label, row.against].flatMap((name) => {
    const owner = ownerOf(String(name), labels);
    const settings = settingsOf(String(name).slice(owner.length + 2));
    return owner === other ? settings.map((one) => `${one} (${other})`) : owner === best ? settings : [];
  });
  return [...swept, ...own];
}

/** One algorithm alone: its settings against each other, or its error over the swept values. @param {Row[]} pairs @param {Row[]} errors @param {string[]} labels */
function within(pairs, errors, labels) {
  const label = labels[0] ?? "";
  const swept = Object.keys(errors[0] ?? {}).filter((name) => name.includes("."));
  const sorted = [...errors].sort((a, b) => Number(a.value) - Number(b.value));
  const [first, last] = [sorted[0], sorted[sorted.length - 1]];
  const amount = (/** @type {Row | undefined} */ row) => ({ value: Number(row?.value), low: number(row?.ci95_low), high: number(row?.ci95_high) });
  /** @type {TrialSentence[]} */
  const sentences = [{ kind: "alone", label, from: amount(first), to: amount(last), at: [wordsOf(first ?? {}, swept), wordsOf(last ?? {}, swept)] }];
  const inScenario = swept.some((name) => name.startsWith("scenario."));
  if (pairs.length && first && !inScenario) {
    const at = wordsOf(first, swept);
    const name = `${label}, ${at}`;
    // Every pair is seen from the best setting, as if it were a label of its own.
    const own = pairs.filter((row) => row.label === name || row.against === name)
      .map((row) => seenFrom(row, name, [String(row.label), String(row.against)])).map((one) => ({ ...one, cell: settingsOf(one.next.slice(label.length + 2)) }));
    const most = own.map((one) => one.times).sort((one, other) => other.value - one.value)[0];
    if (most) sentences.push({ kind: "setting", at, most, even: placesOf(own.filter((one) => one.result === "even").map((one) => one.cell), own.map((one) => one.cell)) });
  }
  return { sentences, best: label };
}

/** Actual over claimed error by leg; of several swept values the one farthest from 1. @param {Row[]} metrics @param {string} label @param {string} target @returns {TrialSentence | null} */
function honestyOf(metrics, label, target) {
  const rows = metrics.filter((row) => row.metric === "actual_over_claimed" && row.label === label && (number(row.value) ?? 0) > 0);
  // Legs are of all targets together; of one target alone only the whole is known.
  const legs = target ? [] : rows.filter((row) => row.segment && !row.target);
  const used = legs.length ? legs : rows.filter((row) => !row.segment && String(row.target ?? "") === target);
  /** @type {Map<string, number>} */
  const worst = new Map();
  for (const row of used) {
    const [name, ratio] = [String(row.segment ?? ""), Number(row.value)];
    const known = worst.get(name);
    if (known === undefined || Math.abs(Math.log(ratio)) > Math.abs(Math.log(known))) worst.set(name, ratio);
  }
  if (!worst.size) return null;
  const list = [...worst].map(([name, ratio]) => /** @type {Leg} */ ({ name, ratio, word: ratio > HONEST ? "small" : ratio < 1 / HONEST ? "large" : "honest" }));
  return { kind: "honesty", label, legs: list, swept: used.length > worst.size };
}

/** Conditions as a list; where all are values of the same name it stands once. @param {string[]} list */
export function joined(list) {
  const parts = list.map((one) => /^([^,=]+) = ([^,]+)$/.exec(one));
  const names = new Set(parts.map((part) => part?.[1]));
  return list.length > 1 && names.size === 1 && parts[0] ? `${parts[0][1]} = ${parts.map((part) => part?.[2]).join(", ")}` : list.join("; ");
}
