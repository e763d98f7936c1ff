"""Add up what an algorithm made of a batch of trials: for each trial over groups of instants, for each instant over
the batch.

A group is everything, one leg of the scenario, or one target. Instants of one trial are correlated, so the trial is
the unit of every confidence interval: the sums of each trial are kept until the statistics have seen them.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.scores import Floats, Ints, SampleKind, Scores
from algorithms.spec import Leg


@dataclass(frozen=True)
class Counted:
    """What a tally says about itself (see `algorithms.scores.Tally`)."""

    metric: str
    unit: str
    root: bool
    curve: bool
    compared: bool
    chi_square: bool
    share: bool
    per_trial: bool
    spread: bool = False


@dataclass(frozen=True)
class Sampled:
    """What a sample says about itself."""

    name: str
    unit: str
    curve: bool
    per_trial: bool
    kind: SampleKind = "size"


@dataclass(frozen=True)
class Layout:
    """What the axes of sums mean; the same for all batches of one algorithm and cell."""

    counted: tuple[Counted, ...]
    sampled: tuple[Sampled, ...]
    groups: tuple[tuple[str, str], ...]
    """(segment, target); ("", "") is everything."""
    targets: tuple[str, ...]

    @property
    def curves(self) -> tuple[int, ...]:
        """Positions of the tallies that are wanted at each instant."""
        return tuple(i for i, c in enumerate(self.counted) if c.curve)


@dataclass(frozen=True)
class Sums:
    """Sums of some batches of trials: N trials, B sums over batches, G groups, Q tallies, C with curves, T instants.

    Attributes
    ----------
    numerator, denominator : (Q, G, N)
    curve : (3, B, C, T), sums over some batches of numerator, denominator and squared numerator
    nodes : (B, 2) over which: number of the first batch, and of how many (see `fold`)
    samples : one for each sample, (K, N) float32 at the instants `kept`, or (1, N) where there is one value a trial
    time_s, target : (T,)
    kept : (K,) instants of which single values are kept
    membership : (G, T) which instants belong to a group
    """

    layout: Layout
    numerator: Floats
    denominator: Floats
    curve: Floats
    nodes: Ints
    samples: tuple[NDArray[np.float32], ...]
    time_s: Floats
    target: Ints
    kept: Ints
    membership: NDArray[np.bool_]

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Plain arrays for an .npz file."""
        out: dict[str, NDArray[Any]] = {
            "layout": np.frombuffer(json.dumps(asdict(self.layout)).encode(), np.uint8),
            "numerator": self.numerator,
            "denominator": self.denominator,
            "curve": self.curve,
            "nodes": self.nodes,
            "time_s": self.time_s,
            "target": self.target,
            "kept": self.kept,
            "membership": self.membership,
        }
        return out | {f"sample/{i}": values for i, values in enumerate(self.samples)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Sums:
        """Rebuild what `to_arrays` gave."""
        raw = json.loads(bytes(arrays["layout"]).decode())
        layout = Layout(
            tuple(Counted(**c) for c in raw["counted"]),
            tuple(Sampled(**s) for s in raw["sampled"]),
            tuple((segment, target) for segment, target in raw["groups"]),
            tuple(raw["targets"]),
        )
        return cls(
            layout=layout,
            numerator=arrays["numerator"],
            denominator=arrays["denominator"],
            curve=arrays["curve"],
            nodes=arrays["nodes"],
            samples=tuple(arrays[f"sample/{i}"] for i in range(len(layout.sampled))),
            time_s=arrays["time_s"],
            target=arrays["target"],
            kept=arrays["kept"],
            membership=arrays["membership"],
        )


def sums_of(scores: Scores, legs: Sequence[Leg], keep_every: int = 1, batch: int = 0) -> Sums:
    """Add up the scores of one batch, the `batch`-th; single values are kept of every `keep_every`-th instant."""
    groups = _groups(scores, legs)
    tallies = scores.tallies
    lanes = tallies[0].numerator.shape[-1]
    numerator = np.zeros((len(tallies), len(groups), lanes))
    denominator = np.zeros_like(numerator)
    for q, tally in enumerate(tallies):
        for g, (segment, target, rows) in enumerate(groups):
            if not tally.per_trial:
                numerator[q, g] = tally.numerator[rows].sum(axis=0)
                denominator[q, g] = tally.denominator[rows].sum(axis=0)
            elif not segment and not target:
                numerator[q, g], denominator[q, g] = tally.numerator, tally.denominator
    drawn = [t for t in tallies if t.curve and not t.per_trial]
    curve = np.zeros((3, 1, len(drawn), scores.time_s.size))
    for c, tally in enumerate(drawn):
        curve[0, 0, c] = tally.numerator.sum(axis=1)
        curve[1, 0, c] = tally.denominator.sum(axis=1)
        curve[2, 0, c] = np.einsum("tl,tl->t", tally.numerator, tally.numerator)
    kept = np.arange(0, scores.time_s.size, max(keep_every, 1))
    samples = tuple(
        np.ascontiguousarray(s.values[None, :] if s.values.ndim == 1 else s.values[kept], np.float32)
        for s in scores.samples
    )
    layout = Layout(
        tuple(
            Counted(
                metric=t.metric,
                unit=t.unit,
                root=t.root,
                curve=t.curve and not t.per_trial,
                compared=t.compared,
                chi_square=t.chi_square,
                share=t.share,
                per_trial=t.per_trial,
                spread=t.spread,
            )
            for t in tallies
        ),
        tuple(Sampled(s.name, s.unit, s.curve, s.values.ndim == 1, s.kind) for s in scores.samples),
        tuple((segment, target) for segment, target, _ in groups),
        scores.targets,
    )
    membership = np.zeros((len(groups), scores.time_s.size), np.bool_)
    for g, (_, _, rows) in enumerate(groups):
        membership[g, rows] = True
    nodes = np.array([[batch, 1]])
    return Sums(layout, numerator, denominator, curve, nodes, samples, scores.time_s, scores.target, kept, membership)


def joined(parts: Sequence[Sums]) -> Sums:
    """Put the sums of consecutive batches together; curves are added up as far as `fold` goes."""
    first = parts[0]
    nodes: list[Node] = []
    for part in parts:
        for node in nodes_of(part):
            fold(nodes, node)
    return Sums(
        layout=first.layout,
        numerator=np.concatenate([p.numerator for p in parts], axis=2),
        denominator=np.concatenate([p.denominator for p in parts], axis=2),
        curve=np.stack([node.curve for node in nodes], axis=1),
        nodes=np.array([[node.first, node.count] for node in nodes]),
        samples=tuple(np.concatenate(values, axis=1) for values in zip(*(p.samples for p in parts), strict=True)),
        time_s=first.time_s,
        target=first.target,
        kept=first.kept,
        membership=first.membership,
    )


@dataclass(frozen=True)
class Node:
    """Sums (3, C, T) over `count` batches from number `first` on; count is a power of two that divides first."""

    first: int
    count: int
    curve: Floats


def nodes_of(sums: Sums) -> list[Node]:
    """Return the sums over batches one by one."""
    return [Node(int(first), int(count), sums.curve[:, b]) for b, (first, count) in enumerate(sums.nodes)]


def fold(nodes: list[Node], node: Node) -> None:
    """Append a sum to those of earlier batches, and add up what belongs together, as a binary counter carries.

    Neighbours are added only where both are halves of one node of the tree of all batches. Whoever adds first, worker
    or server, and wherever the tasks are cut, the same pairs are added, so the last bit of a sum is the same.
    """
    nodes.append(node)
    while len(nodes) > 1:
        left, right = nodes[-2:]
        if not (left.count == right.count and right.first == left.first + left.count):
            return
        if left.first % (2 * left.count):
            return
        nodes[-2:] = [Node(left.first, 2 * left.count, left.curve + right.curve)]


def _groups(scores: Scores, legs: Sequence[Leg]) -> list[tuple[str, str, Any]]:
    """(segment, target, rows) of every group; a slice where the rows follow each other."""
    out: list[tuple[str, str, Any]] = [("", "", slice(None))]
    time = scores.time_s
    for leg in legs:
        first, stop = np.searchsorted(time, [leg.start_s, leg.stop_s])
        out.append((leg.name, "", slice(int(first), int(stop))))
    if len(scores.targets) > 1:
        out += [("", name, np.flatnonzero(scores.target == i)) for i, name in enumerate(scores.targets)]
    return out
