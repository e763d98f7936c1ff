"""Whether a polygon is one: three distinct corners, not all on a line, and edges that meet only at common corners.

What lies inside a polygon that crosses itself depends on who reads it (even-odd or winding), so such a one is refused
and not read in one of the two ways.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

Corner = tuple[float, float]

# Sine of the angle below which three corners lie on one line: rounding of a cross product reaches 4e-16.
_FLAT = 1e-14


def fault_of(corners: Sequence[Corner]) -> str:
    """Say in words what is wrong with the corners (m) of a polygon, which are numbered from 1; empty where nothing is.

    A corner that repeats the one before it, as the last one that repeats the first does, is no fault.
    """
    known = [i for i, corner in enumerate(corners) if corner != corners[i - 1]]
    distinct = len({corners[i] for i in known})
    if distinct < 3:
        return f"its polygon has {max(distinct, min(len(corners), 1))} distinct corners and needs three"
    first, second = corners[known[0]], corners[known[1]]
    if all(_side(first, second, corners[i]) == 0 for i in known):
        return "all corners of its polygon lie on one line: its area is zero"
    edges = [(i, known[(k + 1) % len(known)]) for k, i in enumerate(known)]
    for (k, one), (m, other) in combinations(enumerate(edges), 2):
        neighbours = m - k in (1, len(edges) - 1)
        meet = _folded if neighbours else _meet
        if meet(*(corners[i] for i in one), *(corners[i] for i in other)):
            return (
                f"the edge from corner {one[0] + 1} to {one[1] + 1} of its polygon crosses or touches "
                f"the edge from corner {other[0] + 1} to {other[1] + 1}"
            )
    return ""


def _side(a: Corner, b: Corner, c: Corner) -> int:
    """Return on which side of the line from a to b the point c lies: 1 left, -1 right, 0 on it."""
    u, v, x, y = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
    cross = u * y - v * x
    return 0 if abs(cross) <= _FLAT * (abs(u * y) + abs(v * x)) else (1 if cross > 0 else -1)


def _folded(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    """Return whether neighbouring edges a-b and c-d, which share a corner, go back over each other."""
    shared, one, other = (b, a, d) if b == c else (a, b, c)
    ahead = (one[0] - shared[0]) * (other[0] - shared[0]) + (one[1] - shared[1]) * (other[1] - shared[1])
    return _side(shared, one, other) == 0 and ahead > 0


def _meet(a: Corner, b: Corner, c: Corner, d: Corner) -> bool:
    """Return whether edges a-b and c-d have a point in common."""
    for k in (0, 1):
        if max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]):
            return False
    sides = _side(a, b, c), _side(a, b, d), _side(c, d, a), _side(c, d, b)
    if sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0:
        return True
    on = zip(sides, (c, d, a, b), ((a, b), (a, b), (c, d), (c, d)), strict=True)
    return any(side == 0 and _within(point, *edge) for side, point, edge in on)


def _within(p: Corner, a: Corner, b: Corner) -> bool:
    return min(a[0], b[0]) <= p[0] <= max(a[0], b[0]) and min(a[1], b[1]) <= p[1] <= max(a[1], b[1])
