"""Write `hypothesis.py`: prediction, update and merging of nine-component hypotheses with every small loop written out.

A hypothesis is one array (54, LANES): nine means, then the packed lower triangle of the covariance. Everything that one
function reads or writes stands in two or three arrays, because the compiler checks each pair of arrays for an overlap
before it puts lanes side by side, and gives up when there are many: with one array for each quantity the update took
four times as long.

Run `python -m algorithms.toolbox.kernels.generate_hypothesis` after a change here; a test holds the file against this
text.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

N = 9
PLACES = (0, 3, 6)
PAIRS = [(i, j) for i in range(N) for j in range(i + 1)]
SIZE = N + len(PAIRS)

HEAD = '''# ruff: noqa: E501
"""Arithmetic of hypotheses, written out. Made by `algorithms.toolbox.kernels.generate_hypothesis`: do not edit.

A hypothesis s (54, LANES) holds x vx ax  y vy ay  z vz az and then the packed lower triangle of the covariance.

* `predict_9(s, c)`: F P F^T + Q for three equal axes, x' = F x + known part (`motion.models`). c (16, LANES) =
  interval; a b c d e g of F1 = [[1, a, b], [0, c, d], [0, e, g]]; lower triangle of Q1; known acceleration.
* `update_9(s, r)`: three uncorrelated scalar rows z = h . p + noise, linearised at the state, one after another:
  w = P h, S = h . w + R, x += w nu / S, P -= w w^T / S. r (23, LANES) = h of the three rows, innovations, variances,
  1 where the lane has the row; then it writes NIS, the product of S and the position where rows are linearised.
* `merge_K_9(s, w, out)`: mean = sum w x, covariance = sum w (P + d d^T), d = x - mean, of s (K, 54, LANES);
  `add_9(s, w, out)` adds one hypothesis to the covariance of `out`, whose mean stands already.
"""

from __future__ import annotations

from algorithms.toolbox.kernels import LANES, bare
'''


def _at(array: str, place: int) -> str:
    return f"{array}[{place} * LANES + lane]"


def _p(i: int, j: int) -> int:
    """Place of P[i, j] in a hypothesis."""
    row, column = max(i, j), min(i, j)
    return N + row * (row + 1) // 2 + column


def _function(signature: str, meaning: str, flat: Iterable[tuple[str, str]], body: Iterable[str]) -> str:
    lines = ["@bare", f"def {signature}:", f'    """{meaning}"""']
    lines += [f"    {short} = {name}.reshape({name}.size)" for short, name in flat]
    lines += ["    for lane in range(LANES):", *("        " + line for line in body)]
    return "\n".join(lines) + "\n"


def prediction() -> str:
    """Source of `predict_9`."""
    body = [f"tau = {_at('u', 0)}", *(f"{c} = {_at('u', i + 1)}" for i, c in enumerate("abcdeg"))]
    for axis, i in enumerate(PLACES):
        body += [
            f"push = {_at('u', 13 + axis)}",
            f"v = {_at('q', i + 1)}",
            f"k = {_at('q', i + 2)}",
            f"{_at('q', i)} += a * v + b * k + 0.5 * tau * tau * push",
            f"{_at('q', i + 1)} = c * v + d * k + tau * push",
            f"{_at('q', i + 2)} = e * v + g * k + push",
        ]
    for i in PLACES:
        for j in (j for j in PLACES if j <= i):
            name = {(r, c): f"m{r}{c}" if i != j else f"m{max(r, c)}{min(r, c)}" for r in range(3) for c in range(3)}
            stored = [(r, c) for r in range(3) for c in range(3) if i != j or c <= r]
            body += [f"m{r}{c} = {_at('q', _p(i + r, j + c))}" for r, c in stored]
            body += [f"n0{c} = {name[0, c]} + a * {name[1, c]} + b * {name[2, c]}" for c in range(3)]
            body += [f"n1{c} = c * {name[1, c]} + d * {name[2, c]}" for c in range(3)]
            body += [f"n2{c} = e * {name[1, c]} + g * {name[2, c]}" for c in range(3)]
            for r, c in stored:
                right = (f"n{r}0 + a * n{r}1 + b * n{r}2", f"c * n{r}1 + d * n{r}2", f"e * n{r}1 + g * n{r}2")[c]
                noise = f" + {_at('u', 7 + r * (r + 1) // 2 + c)}" if i == j else ""
                body.append(f"{_at('q', _p(i + r, j + c))} = {right}{noise}")
    return _function("predict_9(s, c)", "Predict in place.", (("q", "s"), ("u", "c")), body)


def update() -> str:
    """Source of `update_9`: three loops over the lanes, as one of three times the length is not vectorised."""
    lines = [
        "@bare",
        "def update_9(s, r):",
        '    """Update in place; write NIS and det S."""',
        "    q = s.reshape(s.size)",
        "    u = r.reshape(r.size)",
        "    for lane in range(LANES):",
        *(f"        {_at('u', 20 + a)} = {_at('q', j)}" for a, j in enumerate(PLACES)),
        f"        {_at('u', 18)} = 0.0",
        f"        {_at('u', 19)} = 1.0",
    ]
    for row in range(3):
        body = [f"h{a} = {_at('u', 3 * row + a)}" for a in range(3)]
        terms = ([f"{_at('q', _p(i, j))} * h{a}" for a, j in enumerate(PLACES)] for i in range(N))
        body += [f"w{i} = " + " + ".join(each) for i, each in enumerate(terms)]
        moved = " - ".join(f"h{a} * ({_at('q', j)} - {_at('u', 20 + a)})" for a, j in enumerate(PLACES))
        body += [
            f"v = {_at('u', 12 + row)} + " + " + ".join(f"h{a} * w{j}" for a, j in enumerate(PLACES)),
            f"a = {_at('u', 15 + row)}",
            "g = a / v",
            f"e = {_at('u', 9 + row)} - {moved}",
            f"{_at('u', 18)} += e * e * g",
            f"{_at('u', 19)} *= 1.0 + a * (v - 1.0)",
            "e *= g",
        ]
        for i in range(N):
            body += [f"{_at('q', i)} += w{i} * e", f"g{i} = w{i} * g"]
            body += [f"{_at('q', _p(i, j))} -= g{i} * w{j}" for j in range(i + 1)]
        lines += ["    for lane in range(LANES):", *("        " + line for line in body)]
    return "\n".join(lines) + "\n"


def merging(count: int) -> str:
    """Source of `merge_K_9`."""
    body = [f"w{k} = {_at('u', k)}" for k in range(count)]
    for i in range(N):
        body += [f"x{k} = {_at('q', k * SIZE + i)}" for k in range(count)]
        body += ["c = " + " + ".join(f"w{k} * x{k}" for k in range(count)), f"{_at('t', i)} = c"]
        body += [f"d{k}{i} = x{k} - c" for k in range(count)]
    for i in range(N):
        body += [f"e{k} = w{k} * d{k}{i}" for k in range(count)]
        for j in range(i + 1):
            terms = (f"w{k} * {_at('q', k * SIZE + _p(i, j))} + e{k} * d{k}{j}" for k in range(count))
            body.append(f"{_at('t', _p(i, j))} = " + " + ".join(terms))
    flat = (("q", "s"), ("u", "w"), ("t", "out"))
    return _function(f"merge_{count}_9(s, w, out)", f"Merge {count} hypotheses.", flat, body)


def addition() -> str:
    """Source of `add_9`."""
    body = ["w0 = u[lane]", *(f"d{i} = {_at('q', i)} - {_at('t', i)}" for i in range(N))]
    body += [f"{_at('t', _p(i, j))} += w0 * ({_at('q', _p(i, j))} + d{i} * d{j})" for i, j in PAIRS]
    flat = (("q", "s"), ("u", "w"), ("t", "out"))
    return _function("add_9(s, w, out)", "Add one hypothesis to a covariance.", flat, body)


def source() -> str:
    """Return the whole text of `hypothesis.py`."""
    return HEAD + "".join("\n\n" + t for t in (prediction(), update(), *(merging(k) for k in (2, 3, 4)), addition()))


if __name__ == "__main__":
    Path(__file__).with_name("hypothesis.py").write_text(source(), encoding="utf-8")
