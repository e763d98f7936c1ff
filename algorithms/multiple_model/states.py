"""What the multiple-model kernels share: named arrays of lanes, and the meanings of their integer codes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import LANES

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STATUS = (
    "waiting",
    "updated",
    "started",
    "coasting",
    "rejected",
    "not_nearest",
    "outside_gate",
    "unusual",
    "restarted",
)
"""What became of a measurement; `status` holds positions in this tuple."""
WAITING, UPDATED, STARTED, COASTING, REJECTED, NOT_NEAREST, OUTSIDE_GATE, UNUSUAL, RESTARTED = range(len(STATUS))

REASONS = (
    "",
    "outside the domain of the sensor's coordinates, or not finite",
    "same time as the measurement before it",
    "no measurement for longer than the track's limit: closed and started anew",
    "another plot of the scan is nearer to the prediction",
    "farther from the prediction than the gate",
    "innovation above the 99.99 % quantile",
    "numbers lost their meaning: started anew from this measurement",
    "first measurement of the target",
    "taken after a gap in a widened gate: the track may have changed to another object",
    "long interval filtered with noise of the rate form",
    "long interval split into steps of the base interval",
)
REASON_CODES = (
    "", "outside_domain", "equal_time", "gap", "not_nearest", "outside_gate", "unusual", "restarted", "first",
    "object_doubtful", "long_as_rate", "long_in_steps",
)  # fmt: skip
(
    R_NONE,
    R_DOMAIN,
    R_EQUAL,
    R_GAP,
    R_NOT_NEAREST,
    R_OUTSIDE,
    R_UNUSUAL,
    R_RESTARTED,
    R_FIRST,
    R_DOUBTFUL,
    R_RATE,
    R_STEPS,
) = range(len(REASONS))

UNUSUAL_NIS = (15.137, 18.421, 21.108)
"""99.99 % quantiles of chi-square with 1, 2 and 3 degrees of freedom."""


class Marks(NamedTuple):
    """Measurements of one target in time order: M rows, L lanes."""

    time: Floats
    group: Ints
    """(G + 1,), where each group of rows begins: plots of one scan among which one may be the target's"""
    kind: Ints
    """(M,) positions in `position_rows.SENSORS`"""
    sensor: Ints
    """(M,) whose axes; rows of one time are independent where it differs"""
    axes: Floats
    """(R, 3, 3)"""
    origin: Floats
    """(M, 3) m"""
    sd: Floats
    """(M, 3) of the coordinates"""
    z: Floats
    """(M, 3, L) coordinates"""
    y: Floats
    """(M, 3, L) m, converted"""
    valid: Ints
    """(M, L)"""
    dof: Ints
    """(M,)"""
    boost: Floats
    """(M, L) factor of every model's sigma over the interval that ends at a row; none = as the detector says"""


class Setup(NamedTuple):
    """Constants of a kernel call beside the bank of models."""

    way: int
    """position in `position_rows.MEASUREMENTS`"""
    velocity_variance: float
    acceleration_variance: float
    timeout_s: float
    gate: float
    """squared distance; infinity = every measurement is the target's"""
    widen_after_s: float
    """After so long without a measurement the gate is as wide again as before, in metres: `widen` times."""
    widen: float
    substep_above_s: float
    """Longer intervals are split into steps of the base interval; infinity = never."""
    fade: float
    """Fading memory of NIS per degree of freedom of the manoeuvre detector; 0 = there is none."""
    boost_above: float
    calm_below: float
    boost: float
    corners: Floats
    """(V, 2) m, corners of all regions one after another"""
    first_corner: Ints
    """(C,) C - 1 regions and the end"""
    heights: Floats
    """(C - 1, 2) m, lowest and highest of each region"""


class Lanes(NamedTuple):
    """What every lane remembers beside the bank's track."""

    live: Ints
    time: Floats
    number: Ints
    started: Ints
    sensor: Ints
    memory: Floats
    """faded sum of NIS per degree of freedom"""
    clip: Floats
    """(1,) largest clip of a transition power; NaN = a power did not exist"""


class Now(NamedTuple):
    """The measurement at hand."""

    dt: Floats
    region: Ints
    go: Floats
    fresh: Floats
    shown: Ints
    status: Ints
    reason: Ints
    chosen: Ints
    distance: Floats
    best: Floats
    limit: Floats
    left: Floats
    step: Floats
    stepping: Floats
    z: Floats
    y: Floats
    sd: Floats
    rows: Ints
    """which rows of the answer are needed"""
    answer: Floats
    predicted: Floats
    """(54, LANES), hypotheses"""
    block: Floats
    """(6, LANES) of the answer's position"""
    small: Floats
    """(3, 6) of one lane"""
    total: Floats
    keep: Floats
    weight: Floats
    """(H, LANES) of the predicted hypotheses"""


class Report(NamedTuple):
    """What is kept of each row; L lanes last."""

    state: Floats
    covariance: Floats
    """(M, 45, L), or (M, 6, L) of the position alone"""
    nis: Floats
    status: Ints
    reason: Ints
    track: Ints
    probability: Floats
    """(M, N, L)"""
    model_state: Floats
    """(M, N, 9, L); none in a lean report"""
    likelihood: Floats
    distance: Floats
    limit: Floats


def new_lanes() -> Lanes:
    """Lanes without a track."""
    return Lanes(
        live=np.zeros(LANES, np.int64),
        time=np.zeros(LANES),
        number=np.zeros(LANES, np.int64),
        started=np.zeros(LANES, np.int64),
        sensor=np.full(LANES, -1),
        memory=np.zeros(LANES),
        clip=np.zeros(1),
    )


def new_now(hypotheses: int, *, positions: bool = False) -> Now:
    """Room for one measurement of so many hypotheses; of the answer's covariance perhaps that of positions alone."""
    of_positions = [9 + 3 * a * (3 * a + 1) // 2 + 3 * b for a in range(3) for b in range(a + 1)]
    return Now(
        rows=np.array([*range(9), *(of_positions if positions else range(9, 54))]),
        dt=np.zeros(LANES), region=np.zeros(LANES, np.int64), go=np.zeros(LANES), fresh=np.zeros(LANES),
        shown=np.zeros(LANES, np.int64), status=np.zeros(LANES, np.int64), reason=np.zeros(LANES, np.int64),
        chosen=np.zeros(LANES, np.int64), distance=np.zeros(LANES), best=np.zeros(LANES), limit=np.zeros(LANES),
        left=np.zeros(LANES), step=np.zeros(LANES), stepping=np.zeros(LANES), z=np.zeros((3, LANES)),
        y=np.zeros((3, LANES)), sd=np.ones((3, LANES)), answer=np.zeros((54, LANES)), predicted=np.zeros((54, LANES)),
        block=np.zeros((6, LANES)), small=np.zeros((3, 6)), total=np.zeros(LANES),
        keep=np.zeros(LANES), weight=np.zeros((hypotheses, LANES)),
    )  # fmt: skip


def new_report(rows: int, models: int, lanes: int, *, lean: bool = False) -> Report:
    """Room for the report of so many rows; a lean one has what scores need."""
    full = 0 if lean else rows
    return Report(
        state=np.full((rows, 9, lanes), np.nan),
        covariance=np.full((rows, 6 if lean else 45, lanes), np.nan),
        nis=np.full((rows, lanes), np.nan),
        status=np.zeros((rows, lanes), np.int64),
        reason=np.zeros((rows, lanes), np.int64),
        track=np.zeros((rows, lanes), np.int64),
        probability=np.full((rows, models, lanes), np.nan),
        model_state=np.full((full, models, 9, lanes), np.nan),
        likelihood=np.full((full, models, lanes), np.nan),
        distance=np.full((full, lanes), np.nan),
        limit=np.full((full, lanes), np.nan),
    )
