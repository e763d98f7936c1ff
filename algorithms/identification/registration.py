"""Do two radars disagree as a whole? Accepted pairs tell a shift, a turn, a range or a time offset of one of them.

With d_i = z_1i - z_2i and its covariance C_i, a hypothesis says d_i = H_i b + noise. Generalised least squares gives
b = A^-1 g with A = sum H' C^-1 H, g = sum H' C^-1 d, and g' A^-1 g is chi-square with as many degrees of freedom as b
has components where nothing is wrong. Where the accuracies are claimed too good, or some pairs are none, all
differences are too large: so what is explained must also stand out from what is left (Fisher's F). Of the hypotheses
that are significant the one is named that leaves least, each component counted as ln 2N (Schwarz). Two radars alone
cannot tell which of them is displaced; a turn about the one or the other site differs, as far as the targets are
spread. Where another hypothesis leaves as little, the geometry cannot tell the two apart, and it is named too.

References
----------
barshalom2001, section 3.4 (least squares); specification 11.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2
from scipy.stats import f as fisher_f

from algorithms.result import Note

Floats = NDArray[np.float64]

# A hypothesis is an alarm below this probability of so large a statistic by chance.
ALARM_TAIL = 1e-4
# A rival explanation need not be an alarm of its own.
RIVAL_TAIL = 0.01
FEWEST_PAIRS = 5
# Hypotheses whose penalised rest is within this of the best explain the data as well: more is very strong evidence.
AS_GOOD = 10.0
OTHERS = -1
"""Stands for all other radars together."""
KINDS = ("shift", "azimuth", "range", "time")
UNITS = ("m", "deg", "m", "s")


@dataclass(frozen=True)
class Accepted:
    """N accepted pairs: difference (N, 2), its covariance xx yy xy (N, 3), offsets from the sites, velocities.

    A velocity is NaN where the target's is not known.
    """

    difference: Floats
    covariance: Floats
    from_first: Floats
    from_second: Floats
    velocity: Floats

    @classmethod
    def nothing(cls) -> Accepted:
        """No pairs."""
        return cls(np.empty((0, 2)), np.empty((0, 3)), *(np.empty((0, 2)) for _ in range(3)))

    def joined(self, other: Accepted) -> Accepted:
        """Put the pairs of another look after these."""
        names = ("difference", "covariance", "from_first", "from_second", "velocity")
        return Accepted(*(np.concatenate([getattr(self, n), getattr(other, n)]) for n in names))


@dataclass(frozen=True)
class Hypothesis:
    """What may be wrong with a radar, and what speaks for it.

    Attributes
    ----------
    kind : of `KINDS`
    radar, against : whose error it would be, and against whom; positions among the recording's radars, or `OTHERS`
    value, sd : (1,) or (2,): east and north m; clockwise deg; m; s
    statistic, tail : and the probability of so large a one by chance, by the chi-square law and by Fisher's, the larger
    rest : penalised rest of the sum of squares
    left : the rest without the penalty, for each degree of freedom: 1 where the hypothesis explains all
    """

    kind: int
    radar: int
    against: int
    value: Floats
    sd: Floats
    statistic: float
    tail: float
    rest: float
    left: float

    @property
    def alarm(self) -> bool:
        """Whether it cannot be chance."""
        return self.tail < ALARM_TAIL

    def polished(self, value: Floats, left: Hypothesis, n: int) -> Hypothesis:
        """Return it with the value whose undoing leaves no more of its kind: `left` is what N pairs then say."""
        dof = value.size
        gain = self.rest + self.statistic - left.rest - left.statistic
        rest = left.rest + left.statistic - dof * float(np.log(2 * n))
        return replace(
            self,
            value=value,
            sd=left.sd,
            statistic=gain,
            tail=_tail(gain, rest, dof, n),
            rest=left.rest + left.statistic,
        )

    def numbers(self) -> list[float]:
        """As a row of the array `registration`."""
        value = [*self.value.tolist(), np.nan][:2]
        sd = [*self.sd.tolist(), np.nan][:2]
        return [float(self.kind), float(self.radar), float(self.against), *value, *sd, self.statistic, self.tail]


def hypotheses_of(pairs: Accepted, first: int, second: int) -> list[Hypothesis]:
    """All hypotheses about two radars (positions among the recording's) that the pairs can test, the best first.

    `first` is `OTHERS` where the second radar is held against the mean of all others: then it alone may be wrong.
    """
    n = len(pairs.difference)
    if n < FEWEST_PAIRS:
        return []
    xx, yy, xy = pairs.covariance.T
    determinant = xx * yy - xy * xy
    weight = np.empty((n, 2, 2))
    weight[:, 0, 0], weight[:, 1, 1] = yy / determinant, xx / determinant
    weight[:, 0, 1] = weight[:, 1, 0] = -xy / determinant
    total = float((pairs.difference * (weight @ pairs.difference[:, :, None])[:, :, 0]).sum())
    out = [_tested(0, second, first, -np.broadcast_to(np.eye(2), (n, 2, 2)), pairs, weight, total)]
    for radar, against, offset, sign in (
        (first, second, pairs.from_first, 1.0),
        (second, first, pairs.from_second, -1.0),
    ):
        if radar == OTHERS:
            continue
        # Clockwise by one degree moves (e, n) by (n, -e) pi / 180.
        turned = np.radians(1.0) * np.stack([offset[:, 1], -offset[:, 0]], axis=1)
        out.append(_tested(1, radar, against, sign * turned[:, :, None], pairs, weight, total))
        sight = offset / np.linalg.norm(offset, axis=1)[:, None]
        out.append(_tested(2, radar, against, sign * sight[:, :, None], pairs, weight, total))
    moving = np.isfinite(pairs.velocity).all(axis=1)
    if moving.sum() >= max(FEWEST_PAIRS, n / 2):
        # Of pairs whose velocity is not known a wrong clock explains nothing.
        out.append(_tested(3, second, first, -np.nan_to_num(pairs.velocity)[:, :, None], pairs, weight, total))
    found = [h for h in out if h is not None]
    return sorted(found, key=lambda h: h.rest)


def _tested(
    kind: int, radar: int, against: int, effect: Floats, pairs: Accepted, weight: Floats, total: float
) -> Hypothesis | None:
    weighted = np.swapaxes(effect, 1, 2) @ weight
    a = (weighted @ effect).sum(axis=0)
    g = (weighted @ pairs.difference[:, :, None]).sum(axis=0)[:, 0]
    if np.linalg.cond(a) > 1e12:
        return None
    covariance = np.linalg.inv(a)
    value = covariance @ g
    statistic = float(g @ value)
    dof = value.size
    n = len(pairs.difference)
    left = total - statistic
    return Hypothesis(
        kind,
        radar,
        against,
        value,
        np.sqrt(np.diag(covariance)),
        statistic,
        _tail(statistic, left, dof, n),
        left + dof * float(np.log(2 * n)),
        left / (2 * n - dof),
    )


def _tail(statistic: float, left: float, dof: int, n: int) -> float:
    """Probability of explaining so much by chance, of N pairs that leave so much."""
    share = statistic / dof / (max(left, 1e-300) / (2 * n - dof))
    return max(float(chi2.sf(statistic, dof)), float(fisher_f.sf(share, dof, 2 * n - dof)))


def notes_of(hypotheses: list[Hypothesis], names: tuple[str, ...]) -> list[Note]:
    """Return the alarm in words: what disagrees, by how much, and what else would explain it."""
    if not hypotheses or not hypotheses[0].alarm:
        return []
    best = hypotheses[0]
    rivals: dict[int, Hypothesis] = {}
    for h in hypotheses[1:]:
        # The same of the other radar with the sign turned round is the same statement.
        if h.kind != best.kind and h.tail < RIVAL_TAIL and h.rest - best.rest < AS_GOOD:
            rivals.setdefault(h.kind, h)
    return [_alarm(best, names), *(_rival(h, names) for h in rivals.values())]


def _words(h: Hypothesis, names: tuple[str, ...]) -> tuple[str, str]:
    """Names of the radar and of what it was held against."""
    return names[h.radar], "the other radars" if h.against == OTHERS else f"radar {names[h.against]}"


def _alarm(h: Hypothesis, names: tuple[str, ...]) -> Note:
    of, against = _words(h, names)
    size, sd = h.value[0], h.sd[0]
    if h.kind == 0:
        return Note(
            "registration_alarm",
            f"Radar {of} places targets {size:.0f} m east and {h.value[1]:.0f} m north of {against} "
            f"(standard deviations {sd:.0f} m and {h.sd[1]:.0f} m); look at the positions of both in the site.",
        )
    if h.kind == 1:
        return Note(
            "registration_alarm",
            f"Radar {of} is turned by {size:.3f} degrees clockwise against {against} (standard deviation "
            f"{sd:.3f} degrees); take as much off its azimuths.",
        )
    if h.kind == 2:
        return Note(
            "registration_alarm",
            f"Radar {of} measures {size:.0f} m too far against {against} (standard deviation {sd:.0f} m); take "
            "as much off its ranges.",
        )
    return Note(
        "registration_alarm",
        f"The times of radar {of} are {size:.2f} s too early against {against} (standard deviation {sd:.2f} s); "
        "add as much to them.",
    )


def _rival(h: Hypothesis, names: tuple[str, ...]) -> Note:
    """Another explanation that the geometry cannot tell from the best one."""
    of, against = _words(h, names)
    size, sd = h.value[0], h.sd[0]
    if h.kind == 0:
        return Note(
            "registration_ambiguous",
            f"That radar {of} places targets {size:.0f} m east and {h.value[1]:.0f} m north of {against} "
            f"(standard deviations {sd:.0f} m and {h.sd[1]:.0f} m) would explain it as well. These targets cannot tell "
            "the two apart: it takes targets at other azimuths and ranges.",
        )
    if h.kind == 1:
        return Note(
            "registration_ambiguous",
            f"That radar {of} is turned by {size:.3f} degrees clockwise against {against} (standard deviation "
            f"{sd:.3f} degrees) would explain it as well. These targets cannot tell the two apart: it takes targets at "
            "other azimuths and ranges.",
        )
    if h.kind == 2:
        return Note(
            "registration_ambiguous",
            f"That radar {of} measures {size:.0f} m too far against {against} (standard deviation {sd:.0f} m) "
            "would explain it as well. These targets cannot tell the two apart: it takes targets at other azimuths and "
            "ranges.",
        )
    return Note(
        "registration_ambiguous",
        f"That the times of radar {of} are {size:.2f} s too early against {against} (standard deviation "
        f"{sd:.2f} s) would explain it as well. These targets cannot tell the two apart: it takes targets on other "
        "courses.",
    )
