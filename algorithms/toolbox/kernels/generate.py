"""Write `unrolled.py`: the scalar-row update with every small loop written out.

For a state of n components whose position stands at 0, n_axis, 2 n_axis the text says, lane by lane,

    w_i = sum_a P[i, a n_axis] h_a,   S = R + sum_a h_a w_{a n_axis},   e = nu - h . (x - start),
    x_i += w_i e / S,   P[i, j] -= w_i w_j / S.

Written as loops over i and j around a loop over lanes, the compiler checks for overlapping arrays 45 times a row and
keeps nothing in registers; written out inside one loop over lanes a row needs a fifth of the time.

Run `python -m algorithms.toolbox.kernels.generate` after a change here; a test holds the file against this text.
"""

from __future__ import annotations

from pathlib import Path

FORMS = {
    "update_rows_9": (9, 3, False),
    "update_rows_3": (3, 1, False),
    "update_rows_10": (10, 3, True),
    "update_rows_4": (4, 1, True),
}
"""Name of the function: components of the state, components per axis, whether the last one is a bias that rows see."""

HEAD = '''"""Scalar-row updates with written-out loops. Made by `algorithms.toolbox.kernels.generate`: do not edit.

A row says z = h . p + noise of variance R, where p is the position part of the state. Its update needs no inverse:

    w = P h,   S = h . w + R,   x += w nu / S,   P -= w w^T / S,   NIS += nu^2 / S,   ln L -= (nu^2 + ln S) / 2.

Rows must be mutually uncorrelated; they then may be applied one after another, in any order, and the sequence is
exactly the joint update when all rows are linearised at the same point: the innovation of a row subtracts h times
the movement that earlier rows made. P stays symmetric because only its lower triangle exists.

Arguments: x (n, LANES), p (n (n + 1) / 2, LANES) packed; start (3, LANES), the position to which `nu` refers;
h (rows, 3, LANES), nu, variance (rows, LANES), the rows; active (rows, LANES), 1 where the lane has the row and 0
where it has not (gain zero, no branch); nis and determinant (LANES,), to which nu^2 / S is added and S / R multiplied.

Where the state ends with a bias, `along` (rows, LANES) says how a row sees it (0 or 1), and start (4, LANES) holds it
too.
"""

# ruff: noqa: E501
from __future__ import annotations

from algorithms.toolbox.kernels import LANES, kernel
'''


def _element(i: int, j: int) -> str:
    """Return the packed element P[i, j] of a lane."""
    row, column = max(i, j), min(i, j)
    return f"q[{row * (row + 1) // 2 + column} * LANES + lane]"


def row_update(name: str, n: int, n_axis: int, biased: bool) -> str:
    """Return the source text of one update function."""
    places = [a * n_axis for a in range(3)] + ([n - 1] if biased else [])
    kind = f"{n}-component states, the last a bias," if biased else f"{n}-component states"
    lines = [
        "@kernel",
        f"def {name}(x, p, start, h, {'along, ' if biased else ''}nu, variance, active, nis, determinant):",
        f'    """Update a block of {kind} by scalar rows, one after another, in place."""',
        "    # Flat views: with the row length known, the compiler sees that rows do not overlap, and vectorises.",
        "    q = p.reshape(p.size)",
        "    y = x.reshape(x.size)",
        "    b = start.reshape(start.size)",
        "    for row in range(nu.shape[0]):",
        "        row_h = h[row].reshape(3 * LANES)",
        *(["        row_along = along[row]"] if biased else []),
        "        row_nu = nu[row]",
        "        row_variance = variance[row]",
        "        row_active = active[row]",
        "        for lane in range(LANES):",
    ]
    body = [
        *(f"h{a} = row_h[{a} * LANES + lane]" for a in range(3)),
        *(["h3 = row_along[lane]"] if biased else []),
        *(f"w{i} = " + " + ".join(f"{_element(i, j)} * h{a}" for a, j in enumerate(places)) for i in range(n)),
        "r = row_variance[lane]",
        "s = r + " + " + ".join(f"h{a} * w{j}" for a, j in enumerate(places)),
        "e = row_nu[lane] - "
        + " - ".join(f"h{a} * (y[{j} * LANES + lane] - b[{a} * LANES + lane])" for a, j in enumerate(places)),
        "# S <= 0 can only come from a covariance that is no longer one; the lane is left as it is.",
        "sound = s > 0.0",
        "a = row_active[lane] if sound else 0.0",
        "g = a / (s if sound else 1.0)",
        "nis[lane] += e * e * g",
        "determinant[lane] *= 1.0 + a * (s - r) / r",
        "e *= g",
        *(f"y[{i} * LANES + lane] += w{i} * e" for i in range(n)),
    ]
    for i in range(n):
        body.append(f"g{i} = w{i} * g")
        body += [f"{_element(i, j)} -= g{i} * w{j}" for j in range(i + 1)]
    return "\n".join([*lines, *("            " + line for line in body)]) + "\n"


def source() -> str:
    """Return the whole text of `unrolled.py`."""
    return HEAD + "".join("\n\n" + row_update(name, *form) for name, form in FORMS.items())


if __name__ == "__main__":
    Path(__file__).with_name("unrolled.py").write_text(source(), encoding="utf-8")
