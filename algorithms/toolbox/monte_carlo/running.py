"""Running statistics of a Monte Carlo run: blocks of trials go in, in their order, metrics and curves come out.

All algorithms of a comparison see the same draws, so trial i of one is paired with trial i of another: products of
their sums are kept as well, and the interval of a difference is that of the paired difference. What is kept does not
grow with the number of trials, but for the samples, of which only so many instants are kept as fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from algorithms.result import Metric
from algorithms.scores import Floats, SampleKind
from algorithms.toolbox.monte_carlo.batches import BATCH
from algorithms.toolbox.monte_carlo.intervals import (
    Moments,
    interval_of_ratio,
    interval_of_spread,
    quantiles_with_intervals,
    student,
)
from algorithms.toolbox.monte_carlo.sums import Node, Sampled, Sums, fold, nodes_of

QUANTILES: dict[SampleKind, dict[str, float]] = {
    "size": {"median": 0.5, "p75": 0.75, "p90": 0.9, "p99": 0.99, "max": 1.0},
    # One standard deviation of a normal distribution to either side.
    "signed": {"p16": 0.158655, "median": 0.5, "p84": 0.841345},
    "drawn": {},
}
CURVE_QUANTILES = ("median", "p90", "p16", "p84")
# So many trials are drawn one by one.
DRAWN_TRIALS = 20


@dataclass(frozen=True)
class Comparison:
    """One algorithm against another on the same draws.

    `difference` is the metric of `first` minus that of `second`, `ratio` the first over the second, each with its 95 %
    interval; `verdict` is smaller, larger, or no_difference that this number of trials can show.
    """

    first: int
    second: int
    metric: str
    unit: str
    segment: str
    target: str
    difference: float
    low: float
    high: float
    ratio: float
    ratio_low: float
    ratio_high: float
    trials: int
    verdict: str


class Running:
    """Statistics of one scenario cell over its algorithms (entries)."""

    def __init__(self, entries: int, *, samples: bool = True) -> None:
        """Without `samples` single values are forgotten: there are no quantiles then."""
        self._entries = entries
        self._with_samples = samples
        self._first: list[Sums] = []
        self._own: list[Floats] = []
        self._pairs: dict[tuple[int, int], Floats] = {}
        self._nodes: list[list[Node]] = []
        self._samples: list[list[list[NDArray[np.float32]]]] = []
        self._settled: dict[int, tuple[list[Metric], dict[str, Floats]]] = {}
        self.trials = 0

    def add(self, parts: Sequence[Sums]) -> None:
        """Add consecutive trials: the sums of every entry over the same draws."""
        self._settled.clear()
        if not self._first:
            self._first = list(parts)
            self._own = [np.zeros((5, *p.numerator.shape[:2])) for p in parts]
            self._nodes = [[] for _ in parts]
            self._samples = [[[] for _ in p.layout.sampled] for p in parts]
        lanes = parts[0].numerator.shape[2]
        # Batch by batch, so that the sums do not depend on how many batches came together.
        for begin in range(0, lanes, BATCH):
            cut = slice(begin, min(begin + BATCH, lanes))
            for e, part in enumerate(parts):
                n, d = part.numerator[:, :, cut], part.denominator[:, :, cut]
                self._own[e] += np.stack([n.sum(2), d.sum(2), (n * n).sum(2), (n * d).sum(2), (d * d).sum(2)])
            self._add_pairs(parts, cut)
        for e, part in enumerate(parts):
            for node in nodes_of(part):
                fold(self._nodes[e], node)
            if self._with_samples:
                for i, values in enumerate(part.samples):
                    drawn = part.layout.sampled[i].kind == "drawn"
                    room = max(DRAWN_TRIALS - self.trials, 0) if drawn else lanes
                    self._samples[e][i].append(values[:, :room])
        self.trials += lanes

    def _add_pairs(self, parts: Sequence[Sums], cut: slice) -> None:
        for first in range(self._entries):
            for second in range(first + 1, self._entries):
                shared = self.shared_metrics(first, second)
                if not shared:
                    continue
                a, b = parts[first], parts[second]
                rows = []
                for i, j in shared:
                    na, da = a.numerator[i, :, cut], a.denominator[i, :, cut]
                    nb, db = b.numerator[j, :, cut], b.denominator[j, :, cut]
                    rows.append([(na * nb).sum(1), (na * db).sum(1), (da * nb).sum(1), (da * db).sum(1)])
                new = np.array(rows)
                old = self._pairs.get((first, second))
                self._pairs[first, second] = new if old is None else old + new

    def shared_metrics(self, first: int, second: int) -> list[tuple[int, int]]:
        """Positions of the compared metrics that two entries have in common, over the same groups."""
        a, b = self._first[first].layout, self._first[second].layout
        if a.groups != b.groups:
            return []
        other = {c.metric: j for j, c in enumerate(b.counted) if c.compared}
        return [(i, other[c.metric]) for i, c in enumerate(a.counted) if c.compared and c.metric in other]

    def moments(self, entry: int, q: int, g: int) -> Moments:
        """Sums of one metric in one group."""
        n, d, nn, nd, dd = self._own[entry][:, q, g]
        return Moments(self.trials, n, d, nn, nd, dd)

    def settle(self) -> None:
        """Compute what takes time as soon as the last trials are added, and keep it until it is asked for."""
        for entry in range(self._entries):
            self._values(entry)
        # Sorting and counting let other threads run, and after the last trials all processors are free.
        with ThreadPoolExecutor(2) as threads:
            curves = [threads.submit(self.curves, entry) for entry in range(self._entries)]
            metrics = [self.metrics(entry, each=threads.map) for entry in range(self._entries)]
            self._settled = {entry: (metrics[entry], curves[entry].result()) for entry in range(self._entries)}

    def metrics(self, entry: int, *, quantiles: bool = True, each: Callable[..., Any] = map) -> list[Metric]:
        """All metrics of an entry with their intervals, group by group; `each` may take several groups at once."""
        if quantiles and entry in self._settled:
            return self._settled[entry][0]
        first = self._first[entry]
        samples = list(zip(first.layout.sampled, self._values(entry), strict=True)) if quantiles else []
        wanted = [
            (g, sampled, values)
            for g, (segment, target) in enumerate(first.layout.groups)
            for sampled, values in samples
            if not (sampled.per_trial and (segment or target))
        ]
        found: list[list[Metric]] = [[] for _ in first.layout.groups]
        for (g, *_), some in zip(wanted, each(lambda one: self._quantiles(entry, *one), wanted), strict=True):
            found[g] += some
        out: list[Metric] = []
        for g, (segment, target) in enumerate(first.layout.groups):
            for q, c in enumerate(first.layout.counted):
                if c.per_trial and (segment or target):
                    continue
                m = self.moments(entry, q, g)
                if c.spread:
                    value, low, high = interval_of_spread(m, self.moments(entry, q - 1, g).ratio)
                else:
                    value, low, high = interval_of_ratio(m, root=c.root, share=c.share)
                n = round(m.d)
                out.append(_metric(c.metric, value, c.unit, n, low, high, segment, target))
            out += found[g]
        return out

    def _quantiles(self, entry: int, g: int, sampled: Sampled, values: NDArray[np.float32]) -> list[Metric]:
        """Quantiles of one group with their intervals."""
        chosen = values if sampled.per_trial else values[self._kept_of(entry, g)]
        wanted = QUANTILES[sampled.kind]
        found = quantiles_with_intervals(chosen, tuple(wanted.values()))
        segment, target = self._first[entry].layout.groups[g]
        return [
            _metric(f"{name}_{sampled.name}", value, sampled.unit, n, low, high, segment, target)
            for name, (value, low, high, n) in zip(wanted, found, strict=True)
        ]

    def curves(self, entry: int, *, quantiles: bool = True) -> dict[str, Floats]:
        """Columns over the instants: each metric with a curve, its interval or chi-square bounds, and quantiles."""
        if quantiles and entry in self._settled:
            return self._settled[entry][1]
        first = self._first[entry]
        sums = np.add.reduce([node.curve for node in self._nodes[entry]])
        out: dict[str, Floats] = {}
        with np.errstate(invalid="ignore", divide="ignore"):
            for c, q in enumerate(first.layout.curves):
                declared = first.layout.counted[q]
                n, d, nn = sums[:, c]
                ratio = np.where(d > 0, n / d, np.nan)
                if declared.spread:
                    mean = sums[0, c - 1] / d
                    ratio = np.where(d > 0, np.maximum(ratio - mean * mean, 0.0), np.nan)
                value = np.sqrt(ratio) if declared.root else ratio
                out[declared.metric] = value
                stem = declared.metric
                if declared.chi_square:
                    # The bounds take long to find, and at most instants the degrees of freedom are the same.
                    few, place = np.unique(d, return_inverse=True)
                    low, high = (stats.chi2.ppf(share, few)[place] for share in (0.025, 0.975))
                    out[f"{stem}_low"] = np.where(d > 0, low / d, np.nan)
                    out[f"{stem}_high"] = np.where(d > 0, high / d, np.nan)
                elif declared.root and declared.compared:
                    # At one instant each trial counts once or not at all, so d is a number of trials.
                    variance = np.maximum(nn / d - ratio**2, 0) / (d - 1)
                    half = student(self.trials) * np.sqrt(variance)
                    out[f"{stem}_low"] = np.where(d > 1, np.sqrt(np.maximum(ratio - half, 0)), np.nan)
                    out[f"{stem}_high"] = np.where(d > 1, np.sqrt(ratio + half), np.nan)
        if quantiles:
            for sampled, values in zip(first.layout.sampled, self._values(entry), strict=True):
                if sampled.curve and not sampled.per_trial:
                    # Of a sorted row the finite values stand in front.
                    rows = np.sort(values, axis=1)
                    count = np.isfinite(values).sum(axis=1)
                    shares = QUANTILES[sampled.kind]
                    for name in (one for one in CURVE_QUANTILES if one in shares):
                        out[f"{name}_{sampled.name}"] = column = np.full(first.time_s.size, np.nan)
                        some = np.flatnonzero(count)
                        at = shares[name] * (count[some] - 1)
                        low = at.astype(np.int64)
                        here = rows[some, low]
                        column[first.kept[some]] = here + (at - low) * (
                            rows[some, np.minimum(low + 1, count[some] - 1)] - here
                        )
        return out

    def comparisons(self) -> list[Comparison]:
        """Every pair of entries by every metric that both are compared by."""
        out: list[Comparison] = []
        for (first, second), sums in self._pairs.items():
            layout = self._first[first].layout
            for k, (i, j) in enumerate(self.shared_metrics(first, second)):
                for g, (segment, target) in enumerate(layout.groups):
                    c = layout.counted[i]
                    if c.per_trial and (segment or target):
                        continue
                    found = _compared(self.moments(first, i, g), self.moments(second, j, g), sums[k, :, g], c.root)
                    if found is not None:
                        out.append(Comparison(first, second, c.metric, c.unit, segment, target, *found))
        return out

    def consistency(self, entry: int) -> list[dict[str, object]]:
        """Whether NEES and NIS stay within the chi-square bounds of so many trials, group by group.

        The verdict goes by the share of instants within their 95 % bounds: honest from 85 %; mixed where more than 15 %
        lie on either side; otherwise optimistic (above: errors larger than claimed) or pessimistic. Instants of one
        trial are correlated, so no bound holds for their mean.
        """
        first = self._first[entry]
        curves = self.curves(entry, quantiles=entry in self._settled)
        out: list[dict[str, object]] = []
        for q, c in enumerate(first.layout.counted):
            if not c.chi_square or not c.curve:
                continue
            value, low, high = curves[c.metric], curves[f"{c.metric}_low"], curves[f"{c.metric}_high"]
            for g, (segment, target) in enumerate(first.layout.groups):
                rows = self._rows_of(entry, g)
                known = rows[np.isfinite(value[rows])]
                if not known.size:
                    continue
                above = float((value[known] > high[known]).mean())
                below = float((value[known] < low[known]).mean())
                verdict = "optimistic" if above > below else "pessimistic"
                if above + below <= 0.15:
                    verdict = "honest"
                elif min(above, below) > 0.15:
                    verdict = "mixed"
                out.append(
                    {
                        "statistic": c.metric,
                        "segment": segment,
                        "target": target,
                        "value": self.moments(entry, q, g).ratio,
                        "bound_low": float(np.median(low[known])),
                        "bound_high": float(np.median(high[known])),
                        "inside_share": 1 - above - below,
                        "above_share": above,
                        "instants": int(known.size),
                        "verdict": verdict,
                    }
                )
        return out

    def sample_arrays(self, entry: int) -> dict[str, NDArray[np.float32]]:
        """Kept values by the name of their sample, (K, N)."""
        sampled = self._first[entry].layout.sampled
        return {s.name: values for s, values in zip(sampled, self._values(entry), strict=True)}

    def axes(self, entry: int) -> Sums:
        """Sums of the first trials: they say what the axes mean."""
        return self._first[entry]

    def _values(self, entry: int) -> list[NDArray[np.float32]]:
        """Kept values of all trials so far; joined once and for all."""
        for i, parts in enumerate(self._samples[entry]):
            if len(parts) > 1:
                self._samples[entry][i] = [np.concatenate(parts, axis=1)]
        return [parts[0] for parts in self._samples[entry]]

    def _rows_of(self, entry: int, g: int) -> NDArray[np.int64]:
        first = self._first[entry]
        return np.flatnonzero(first.membership[g])

    def _kept_of(self, entry: int, g: int) -> NDArray[np.bool_]:
        first = self._first[entry]
        return first.membership[g][first.kept]


def _metric(metric: str, value: float, unit: str, n: int, low: float, high: float, segment: str, target: str) -> Metric:
    def known(number: float) -> float | None:
        return float(number) if np.isfinite(number) else None

    return Metric(metric, known(value), unit, n, known(low), known(high), segment, target)


def _compared(
    a: Moments, b: Moments, cross: Floats, root: bool
) -> tuple[float, float, float, float, float, float, int, str] | None:
    """Paired difference and ratio of two ratios, by linearisation (see `intervals`)."""
    if a.trials < 2 or not (a.d > 0 and b.d > 0):
        return None
    ra, rb = a.ratio, b.ratio
    n_ab, nd_ab, dn_ab, dd_ab = cross
    # Covariance of the two ratios over the same trials.
    covariance = (n_ab - rb * nd_ab - ra * dn_ab + ra * rb * dd_ab) / (a.d * b.d) * a.trials / (a.trials - 1)
    va, vb = a.variance, b.variance
    x, y = (np.sqrt(ra), np.sqrt(rb)) if root else (ra, rb)
    # d sqrt(R) = dR / (2 sqrt(R)).
    ga = 1 / (2 * x) if root and x > 0 else 1.0
    gb = 1 / (2 * y) if root and y > 0 else 1.0
    variance = max(ga * ga * va + gb * gb * vb - 2 * ga * gb * covariance, 0.0)
    half = student(a.trials) * np.sqrt(variance)
    difference = float(x - y)
    verdict = "no_difference" if abs(difference) <= half else "smaller" if difference < 0 else "larger"
    nan = float("nan")
    ratio = ratio_low = ratio_high = nan
    if x > 0 and y > 0:
        ratio = float(x / y)
        spread = (ga / x) ** 2 * va + (gb / y) ** 2 * vb - 2 * ga * gb / (x * y) * covariance
        log_half = student(a.trials) * np.sqrt(max(spread, 0.0))
        ratio_low, ratio_high = float(ratio * np.exp(-log_half)), float(ratio * np.exp(log_half))
    low, high = float(difference - half), float(difference + half)
    return difference, low, high, ratio, ratio_low, ratio_high, a.trials, verdict
