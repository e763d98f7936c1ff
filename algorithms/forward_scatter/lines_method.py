"""The closed form on one pass: one pair of Dopplers, or two pairs put together.

Where both sides have two terminals, the answer of the receivers' pair and that of the transmitters' pair are weighted
with 1/s^4 and 1/(a - s)^4, after which the error of each grows.

References
----------
specification 4, 7 (two transmitters, 2 x 2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter import outputs, sequence
from algorithms.forward_scatter.conditions import Pair, dopplers_of
from algorithms.forward_scatter.motion import UNKNOWNS
from algorithms.forward_scatter.piece import Arrays, Piece

Floats = NDArray[np.float64]

_STATUS = np.array(
    [
        outputs.INSUFFICIENT,
        outputs.NO_LINE,
        outputs.NO_CROSSING,
        outputs.INVALID,
        outputs.EXTRAPOLATED,
        outputs.CROSSED,
    ]
)


@dataclass(frozen=True)
class Answer:
    """Status (K, L) in the words of `outputs`, theta (K, 5, L), its covariance (K, 5, 5, L)."""

    status: NDArray[np.int64]
    theta: Floats
    covariance: Floats


def follow_pair(piece: Piece, pair: Pair, options: sequence.Options) -> sequence.Answers:
    """Go through a pass with one pair of Dopplers."""
    f = dopplers_of(pair, piece.doppler)
    rate = np.full_like(f, np.nan)
    if piece.doppler.shape[1] == 2:
        rate = np.ascontiguousarray(piece.rate[:, [pair.lower[0], pair.upper[0]]])
    out = sequence.answers(*f.shape[::2])
    sigma = options.sigma / np.sqrt(len(pair.lower))
    sequence.follow(piece.time, f, rate, options._replace(b=pair.b, sigma=float(sigma)), out)
    return out


def answer_of(out: sequence.Answers, pair: Pair, a: float) -> Answer:
    """In the unknowns of the frame: the distance of a transmitters' pair counts from the transmitters."""
    k, _, lanes = out.theta.shape
    theta = np.zeros((k, UNKNOWNS, lanes))
    theta[:, :3] = out.theta
    covariance = np.zeros((k, UNKNOWNS, UNKNOWNS, lanes))
    covariance[:, :3, :3] = out.covariance
    if pair.mirrored:
        theta[:, 1] = a - theta[:, 1]
        covariance[:, 1, [0, 2]] *= -1
        covariance[:, [0, 2], 1] *= -1
    return Answer(_STATUS[out.status], theta, covariance)


def joined(answers: Sequence[Answer], a: float) -> Answer:
    """Weight the receivers' and the transmitters' answer with 1/s^4 and 1/(a - s)^4; one alone where one is missing."""
    if len(answers) == 1:
        return answers[0]
    first, second = answers
    valid = [np.isin(one.status, outputs.ANSWERED) for one in answers]
    with np.errstate(invalid="ignore", divide="ignore"):
        w1 = np.where(valid[0], 1.0 / np.where(valid[0], first.theta[:, 1], 1.0) ** 4, 0.0)
        w2 = np.where(valid[1], 1.0 / np.where(valid[1], a - second.theta[:, 1], 1.0) ** 4, 0.0)
        share = np.where(w1 + w2 > 0, w1 / (w1 + w2), 1.0)
    theta = np.where((share == 1)[:, None], first.theta, second.theta)
    covariance = np.where((share == 1)[:, None, None], first.covariance, second.covariance)
    both = valid[0] & valid[1]
    mixed = share[:, None] * first.theta + (1 - share[:, None]) * second.theta
    spread = share[:, None, None] ** 2 * first.covariance + (1 - share[:, None, None]) ** 2 * second.covariance
    theta = np.where(both[:, None], mixed, theta)
    covariance = np.where(both[:, None, None], spread, covariance)
    return Answer(np.where(valid[0], first.status, second.status), theta, covariance)


def put_answer(piece: Piece, arrays: Arrays, answer: Answer) -> None:
    """Write the answer of a pass into the result."""
    piece.put(arrays, "status", answer.status)
    piece.put(arrays, "theta", answer.theta)
    piece.put(arrays, "theta_covariance", answer.covariance)
