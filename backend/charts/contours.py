"""Lines of equal value over a grid (marching squares), as one broken line of few points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from backend.charts.figure import Trace, trace

Floats = NDArray[np.float64]

# 1, 2 and 5 in each decade; of more levels every decade has its first alone.
STEPS = (1.0, 2.0, 5.0)
MOST_LEVELS = 9


@dataclass(frozen=True)
class Line:
    """One unbroken piece of a level.

    Attributes
    ----------
    level : its value
    x, y : points along it, in the grid's unit
    """

    level: float
    x: Floats
    y: Floats


def levels_between(low: float, high: float) -> list[float]:
    """Round values above `low` and below `high`."""
    powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.ceil(np.log10(high)) + 1)
    all_of = [float(f"{p * s:.6g}") for p in powers for s in STEPS if low < p * s < high]
    few = [float(f"{p:.6g}") for p in powers if low < p < high]
    return all_of if len(all_of) <= MOST_LEVELS else few


def contour_lines(x: Floats, y: Floats, values: Floats, levels: Sequence[float]) -> list[Line]:
    """Lines along which positive values (len(y), len(x)) have these levels, interpolated in their logarithms.

    Cells with a value that is no number have no line.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(np.asarray(values, np.float64))
    return [piece for level in levels for piece in _pieces(x, y, logs - np.log(level), level)]


def contour_traces(lines: Sequence[Line], name: str, unit: str, color: str) -> list[Trace]:
    """A broken line of all levels, and the value at the middle of the longest piece of each."""
    if not lines:
        return []
    gap = np.array([np.nan])
    east = np.concatenate([part for line in lines for part in (line.x, gap)])
    north = np.concatenate([part for line in lines for part in (line.y, gap)])
    longest = {line.level: line for line in sorted(lines, key=lambda line: line.x.size)}
    named = [(one.x[one.x.size // 2], one.y[one.x.size // 2], f"{one.level:g}") for one in longest.values()]
    words = [f"{word} {unit}".strip() for _, _, word in named]
    return [
        trace("bound", east, north, name=name, mode="lines", line={"color": color, "width": 0.8}),
        trace(
            "bound",
            np.array([n[0] for n in named]),
            np.array([n[1] for n in named]),
            name=name,
            mode="text",
            text=words,
            textfont={"size": 10, "color": color},
            showlegend=False,
        ),
    ]


def _pieces(x: Floats, y: Floats, f: Floats, level: float) -> list[Line]:
    """Lines of f = 0."""
    above = f > 0
    known = np.isfinite(f)
    whole = known[:-1, :-1] & known[1:, :-1] & known[:-1, 1:] & known[1:, 1:]
    rows, columns = f.shape
    # Edges have numbers: along x first, then along y.
    along_x = np.arange(rows * (columns - 1)).reshape(rows, columns - 1)
    along_y = rows * (columns - 1) + np.arange((rows - 1) * columns).reshape(rows - 1, columns)
    cut_x, cut_y = above[:, :-1] != above[:, 1:], above[:-1] != above[1:]
    low, right, top, left = along_x[:-1], along_y[:, 1:], along_x[1:], along_y[:, :-1]
    cuts = np.stack([cut_x[:-1], cut_y[:, 1:], cut_x[1:], cut_y[:, :-1]]) & whole
    edges = np.stack([low, right, top, left])
    count = cuts.sum(axis=0)
    links: dict[int, list[int]] = {}
    two = count == 2
    pairs = edges[:, two].T[cuts[:, two].T].reshape(-1, 2).tolist()
    for i, j in np.argwhere(count == 4):
        a, b, c, d = (int(e[i, j]) for e in edges)
        # A saddle: its middle says which corners hang together.
        same = (f[i, j] + f[i + 1, j] + f[i, j + 1] + f[i + 1, j + 1] > 0) == above[i, j]
        pairs += [[a, b], [c, d]] if same else [[a, d], [b, c]]
    for a, b in pairs:
        links.setdefault(a, []).append(b)
        links.setdefault(b, []).append(a)
    chains = _chains(links)
    return [Line(level, *_places(x, y, f, np.array(chain), rows, columns)) for chain in chains]


def _chains(links: dict[int, list[int]]) -> list[list[int]]:
    """Edges in the order in which a line crosses them: open lines from their ends, then closed ones."""
    out = []
    for start in [*(e for e, to in links.items() if len(to) == 1), *links]:
        if not links[start]:
            continue
        chain, at = [start], start
        while links[at]:
            to = links[at].pop()
            links[to].remove(at)
            chain.append(to)
            at = to
        out.append(chain)
    return out


def _places(
    x: Floats, y: Floats, f: Floats, chain: NDArray[np.int64], rows: int, columns: int
) -> tuple[Floats, Floats]:
    """Where each edge of a chain is cut."""
    flat = chain < rows * (columns - 1)
    k = np.where(flat, chain, chain - rows * (columns - 1))
    width = np.where(flat, columns - 1, columns)
    i, j = k // width, k % width
    i2, j2 = np.where(flat, i, i + 1), np.where(flat, j + 1, j)
    share = f[i, j] / (f[i, j] - f[i2, j2])
    return x[j] + share * (x[j2] - x[j]), y[i] + share * (y[i2] - y[i])
