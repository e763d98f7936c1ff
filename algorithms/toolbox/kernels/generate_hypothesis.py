"""Write `hypothesis.py`: prediction, update and merging of hypotheses with every small loop written out.

A hypothesis is one array (54, LANES): nine means, then the packed lower triangle of the covariance. Everything that one
function reads or writes stands in two or three arrays, because the compiler checks each pair of arrays for an overlap
before it puts lanes side by side, and gives up when there are many: with one array for each quantity the update took
four times as long. Models of velocity know their acceleration: of theirs six components are random, and the functions
that end in 6 leave the other rows of the covariance, which are zero, alone.

Run `python -m algorithms.toolbox.kernels.generate_hypothesis` after a change here; a test holds the file against this
text.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

N = 9
PLACES = (0, 3, 6)
COMPONENTS = {6: [0, 1, 3, 4, 6, 7], 9: list(range(N))}
"""What is random in models of velocity and in the others."""
SIZE = N + N * (N + 1) // 2

HEAD = '''# ruff: noqa: E501
"""Arithmetic of hypotheses, written out. Made by `algorithms.toolbox.kernels.generate_hypothesis`: do not edit.

A hypothesis s (54, LANES) holds x vx ax  y vy ay  z vz az and then the packed lower triangle of the covariance. Names
end in how many components are random: 6 in models that know their acceleration, whose other rows are not touched.

* `predict_6(s, c, out)`, `predict_9`, `predict_turn_9`: F P F^T + Q for three equal axes, x' = F x + known part
  (`motion.models`). c (16, LANES) = interval; a b c d e g of F1 = [[1, a, b], [0, c, d], [0, e, g]]; lower triangle of
  Q1; known acceleration. Constant velocity and acceleration use a and b only. `out` is another array than s.
* `update_6(s, r, out)`, `update_9`: three uncorrelated scalar rows z = h . p + noise, linearised at the state, as one
  after another: w = P h, S = h . w + R, x += w nu / S, P -= w w^T / S; P is read and written once, earlier rows enter
  w by what they subtract. r (23, LANES) = h of the three rows, innovations, variances, 1 where the lane has the row;
  written are NIS, the product of S, the least variance of a position, the least of the others, and the sum of means
  and variances, which is finite where all of them are. `out` is another array than s.
* `merge_K_6(s, w, out)`, `merge_K_9`: mean = sum w x, covariance = sum w (P + d d^T), d = x - mean, of s (K, 54,
  LANES); `add_9(s, w, out)` adds one hypothesis to the covariance of `out`, whose mean stands already.
"""

from __future__ import annotations

from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.flat import flat
from algorithms.toolbox.kernels.fused import fma
'''


def _at(array: str, place: int) -> str:
    return f"{array}[{place} * LANES + lane]"


def _p(i: int, j: int) -> int:
    """Place of P[i, j] in a hypothesis."""
    row, column = max(i, j), min(i, j)
    return N + row * (row + 1) // 2 + column


def _sum(pairs: Iterable[tuple[str, str]], start: str = "") -> str:
    """Text of start + a b + c d + ..., each product fused into the sum."""
    text = start
    for a, b in pairs:
        text = f"fma({a}, {b}, {text})" if text else f"{a} * {b}"
    return text


def _function(signature: str, meaning: str, flat: Iterable[tuple[str, str]], *loops: Iterable[str]) -> str:
    lines = ["@bare", f"def {signature}:", f'    """{meaning}"""']
    lines += [f"    {short} = flat({name})" for short, name in flat]
    for body in loops:
        lines += ["    for lane in range(LANES):", *("        " + line for line in body)]
    return "\n".join(lines) + "\n"


VELOCITY = (((0, 1.0), (1, "a")), ((1, 1.0),))
ACCELERATION = (((0, 1.0), (1, "a"), (2, "b")), ((1, 1.0), (2, "a")), ((2, 1.0),))
TURN = (((0, 1.0), (1, "a"), (2, "b")), ((1, "c"), (2, "d")), ((1, "e"), (2, "g")))
"""Rows of F1: column and entry of what is not zero."""


def _row(entries: Sequence[tuple[int, float | str]], values: Sequence[str]) -> str:
    """Text of one row of F1 times three numbers."""
    (first, factor), *rest = entries
    start = values[first] if factor == 1.0 else f"{factor} * {values[first]}"
    return _sum(((str(f), values[c]) for c, f in rest), start)


def prediction(name: str, matrix: Sequence[Sequence[tuple[int, float | str]]]) -> str:
    """Source of one prediction."""
    used = sorted({f for entries in matrix for _, f in entries if isinstance(f, str)})
    body = [f"{f} = {_at('u', 1 + 'abcdeg'.index(f))}" for f in used]
    n = len(matrix)
    known = n == 2
    if known:
        body.append("h = 0.5 * a * a")
    for axis, i in enumerate(PLACES):
        body += [f"x{r} = {_at('q', i + r)}" for r in range(n)]
        moved = [_row(matrix[r], ("x0", "x1", "x2")) for r in range(n)]
        if known:
            body.append(f"k = {_at('u', 13 + axis)}")
            moved = [f"fma(h, k, {moved[0]})", f"fma(a, k, {moved[1]})", "k"]
        body += [f"{_at('o', i + r)} = {text}" for r, text in enumerate(moved)]
    for i in PLACES:
        for j in (j for j in PLACES if j <= i):
            name_ = {(r, c): f"m{r}{c}" if i != j else f"m{max(r, c)}{min(r, c)}" for r in range(n) for c in range(n)}
            stored = [(r, c) for r in range(n) for c in range(n) if i != j or c <= r]
            body += [f"m{r}{c} = {_at('q', _p(i + r, j + c))}" for r, c in stored]
            for r in range(n):
                body += [f"n{r}{c} = " + _row(matrix[r], [name_[k, c] for k in range(n)]) for c in range(n)]
            for r, c in stored:
                noise = f" + {_at('u', 7 + r * (r + 1) // 2 + c)}" if i == j else ""
                text = _row(matrix[c], [f"n{r}{k}" for k in range(n)])
                body.append(f"{_at('o', _p(i + r, j + c))} = {text}{noise}")
    flat = (("q", "s"), ("u", "c"), ("o", "out"))
    return _function(f"{name}(s, c, out)", "Predict into another hypothesis.", flat, body)


def update(size: int) -> str:
    """Source of one update."""
    parts = COMPONENTS[size]
    body: list[str] = []
    for k in range(3):
        h = [f"h{a}" for a in range(3)]
        body += [f"h{a} = {_at('u', 3 * k + a)}" for a in range(3)]
        body += [f"w{k}{i} = " + _sum(zip(h, (_at("q", _p(i, j)) for j in PLACES), strict=True)) for i in parts]
        body.append(f"e = {_at('u', 9 + k)}")
        for m in range(k):
            body.append("c = " + _sum(zip(h, (f"w{m}{j}" for j in PLACES), strict=True)))
            body += [f"e -= d{m} * c", f"c *= -g{m}"]
            body += [f"w{k}{i} = fma(c, w{m}{i}, w{k}{i})" for i in parts]
        body += [
            "v = " + _sum(zip(h, (f"w{k}{j}" for j in PLACES), strict=True), _at("u", 12 + k)),
            f"a = {_at('u', 15 + k)}",
            f"g{k} = a / v",
            f"d{k} = e * g{k}",
            f"nis = e * d{k}" if k == 0 else f"nis = fma(e, d{k}, nis)",
            "det = fma(a, v - 1.0, 1.0)" if k == 0 else "det *= fma(a, v - 1.0, 1.0)",
        ]
    body += [f"{_at('u', 18)} = nis", f"{_at('u', 19)} = det", "total = 0.0"]
    for i in parts:
        body += [
            "x = " + _sum(((f"w{k}{i}", f"d{k}") for k in range(3)), _at("q", i)),
            f"{_at('o', i)} = x",
            *(f"f{k} = -w{k}{i} * g{k}" for k in range(3)),
        ]
        body += [
            f"{_at('o', _p(i, j))} = " + _sum(((f"f{k}", f"w{k}{j}") for k in range(3)), _at("q", _p(i, j)))
            for j in parts
            if j < i
        ]
        body += [
            "v = " + _sum(((f"f{k}", f"w{k}{i}") for k in range(3)), _at("q", _p(i, i))),
            f"{_at('o', _p(i, i))} = v",
            "total += x + v",
        ]
        least = "low" if i % 3 == 0 else "least"
        body.append(f"{least} = v" if i in (0, 1) else f"{least} = min({least}, v)")
    body += [f"{_at('u', 20)} = low", f"{_at('u', 21)} = least", f"{_at('u', 22)} = total"]
    if size < N:
        body += [f"{_at('o', i)} = {_at('q', i)}" for i in range(N) if i not in parts]
    flat = (("q", "s"), ("u", "r"), ("o", "out"))
    return _function(f"update_{size}(s, r, out)", "Update into another hypothesis.", flat, body)


def merging(count: int, size: int) -> str:
    """Source of one merging: a loop for the means and one for each axis, as a longer one is not vectorised."""
    parts = COMPONENTS[size]
    weights = [f"w{k} = {_at('u', k)}" for k in range(count)]
    means = list(weights)
    for i in parts:
        terms = [(f"w{k}", _at("q", k * SIZE + i)) for k in range(count)]
        means.append(f"{_at('t', i)} = " + _sum(terms))
    loops = [means]
    for axis in PLACES:
        rows = [i for i in parts if axis <= i < axis + 3]
        body = list(weights)
        for i in (i for i in parts if i < axis + 3):
            body.append(f"c = {_at('t', i)}")
            body += [f"d{k}{i} = {_at('q', k * SIZE + i)} - c" for k in range(count)]
        for i in rows:
            body += [f"e{k} = w{k} * d{k}{i}" for k in range(count)]
            for j in (j for j in parts if j <= i):
                terms = [(f"w{k}", _at("q", k * SIZE + _p(i, j))) for k in range(count)]
                terms += [(f"e{k}", f"d{k}{j}") for k in range(count)]
                body.append(f"{_at('t', _p(i, j))} = " + _sum(terms))
        loops.append(body)
    flat = (("q", "s"), ("u", "w"), ("t", "out"))
    return _function(f"merge_{count}_{size}(s, w, out)", f"Merge {count} hypotheses.", flat, *loops)


def addition() -> str:
    """Source of `add_9`."""
    body = ["w0 = u[lane]", *(f"d{i} = {_at('q', i)} - {_at('t', i)}" for i in range(N))]
    for i in range(N):
        body.append(f"e = w0 * d{i}")
        for j in range(i + 1):
            terms = [("w0", _at("q", _p(i, j))), ("e", f"d{j}")]
            body.append(f"{_at('t', _p(i, j))} = " + _sum(terms, _at("t", _p(i, j))))
    flat = (("q", "s"), ("u", "w"), ("t", "out"))
    return _function("add_9(s, w, out)", "Add one hypothesis to a covariance.", flat, body)


def source() -> str:
    """Return the whole text of `hypothesis.py`."""
    texts = [prediction("predict_6", VELOCITY), prediction("predict_9", ACCELERATION)]
    texts += [prediction("predict_turn_9", TURN), *(update(size) for size in COMPONENTS)]
    texts += [merging(k, size) for k in (2, 3, 4) for size in COMPONENTS]
    return HEAD + "".join("\n\n" + text for text in (*texts, addition()))


if __name__ == "__main__":
    Path(__file__).with_name("hypothesis.py").write_text(source(), encoding="utf-8")
