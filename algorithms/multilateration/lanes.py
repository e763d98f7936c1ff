"""What the range-difference filter reads, remembers and reports, lane by lane.

Everything that a lane remembers between marks is in `Track`, so a recording can be cut into slices anywhere.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.gathered import Gathered, new_gathered
from algorithms.toolbox.kernels import LANES

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STATUS = (
    "updated",
    "initialised",
    "reinitialised",
    "downweighted",
    "altitude_only",
    "ambiguous",
    "coast",
    "not_initialised",
    "rejected_time",
    "impossible_toa",
    "residual_gate",
    "singular",
)
(UPDATED, INITIALISED, REINITIALISED, DOWNWEIGHTED, ALTITUDE_ONLY, AMBIGUOUS, COAST, NOT_INITIALISED) = range(8)
(REJECTED_TIME, IMPOSSIBLE_TOA, RESIDUAL_GATE, SINGULAR) = range(8, 12)

REASONS = (
    "",
    "fewer than two receptions and no altitude",
    "a start needs four receptions, or three and an altitude",
    "no position explains the times of arrival",
    "the residual exceeds the gate",
    "the claimed error exceeds 20 % of the range",
    "no update for 60 s",
    "innovations inconsistent over 20 marks",
    "prediction and fix differ by more than 5 sigma",
    "two positions explain the mark",
    "times of arrival differ by more than the stations' distance allows",
    "the mark is older than the one before it",
    "the state is no longer finite",
    "innovation beyond 3 sigma: its noise was scaled up",
    "the covariance was no longer positive definite and was repaired",
    "too few marks yet for a start from several",
    "the same two stations all the time: no place along their hyperbola",
    "several positions still explain the marks together",
    "the marks together still leave an error above 20 % of the range",
    "the marks together fit no straight flight at constant speed",
    "started from several marks together",
    "one reception was left out: the others agree without it",
    "the altitude was left out: the receptions agree without it",
    "one reception was left out: it cannot have come from where the others did",
    "one reception was left out: those of its station were impossible a moment ago",
    "the position lies below the ground or above 40 km",
)
# Words may be put better; these names stay.
REASON_CODES = (
    "",
    "too_few_receptions",
    "no_start_from_one_mark",
    "no_solution",
    "residual",
    "claim_too_large",
    "gap",
    "inconsistent",
    "far_from_fix",
    "two_positions",
    "impossible_spread",
    "older_than_before",
    "not_finite",
    "noise_scaled",
    "covariance_repaired",
    "too_few_marks",
    "same_pair",
    "several_positions",
    "poor_geometry",
    "not_straight",
    "several_marks",
    "reception_left_out",
    "altitude_left_out",
    "impossible_reception",
    "doubtful_reception",
    "impossible_height",
)
(R_NONE, R_FEW, R_NO_START, R_NO_SOLUTION, R_RESIDUAL, R_CLAIM, R_GAP, R_INCONSISTENT, R_FIX) = range(9)
(R_TWO, R_SPREAD, R_OLD, R_SINGULAR, R_SCALED, R_REPAIRED) = range(9, 15)
(R_TOO_FEW, R_SAME_PAIR, R_SEVERAL, R_POOR, R_NOT_STRAIGHT, R_TOGETHER) = range(15, 21)
(R_LEFT_RECEPTION, R_LEFT_ALTITUDE, R_LEFT_IMPOSSIBLE, R_LEFT_DOUBTFUL, R_HEIGHT) = range(21, 26)

GAP_S = 60.0
STALE_S = 20.0
VELOCITY_UNKNOWN_MPS = 50.0
RESTART_SIGMA = 5.0
START_VELOCITY_SD_MPS = 300.0
START_ACCELERATION_SD_MPS2 = 10.0
# How straight a flight is taken to be, from whose marks a track is started.
STRAIGHT_ACCELERATION_SD_MPS2 = 0.5
# A height that is known no better than this does not help to solve a single mark.
KNOWN_ALTITUDE_SD_M = 500.0
SCALE_FROM_SIGMA = 3.0
CLAIM_SHARE_OF_RANGE = 0.2
WINDOW_MARKS = 20
INCONSISTENT_RATIO = 10.0
# From this average on a track is called inconsistent, though it goes on.
DOUBTFUL_RATIO = 3.0
# Smallest eigenvalue that a repaired covariance is given.
EIGENVALUE_FLOOR = 1e-9
# One wild mark must not restart a track: its share in the average is limited (it takes eight of twenty).
WINDOW_CAP = 25.0
RIVAL_COST_GAP = 9.0
RELINEARISATIONS = 3
# How a mark enters the estimate; `raw` keeps the emission time as a state.
UPDATES = ("ekf", "iekf", "ukf", "ckf", "raw")
(EKF, IEKF, UKF, CKF, RAW) = range(5)


class Marks(NamedTuple):
    """Measurements of a block: time (M, L) s, toa (M, S, L) s, altitude (M, L) m."""

    time: Floats
    toa: Floats
    altitude: Floats
    altitude_extra: Floats
    """(M, L) m^2, by which the altitude's variance differs from a decoded one's: 0 of a decoded altitude"""
    altitude_biased: Floats
    """(M, L) 1 where the altitude has the bias of a decoded one"""


def decoded_marks(time: Floats, toa: Floats, altitude: Floats) -> Marks:
    """Marks whose altitudes are all decoded."""
    return Marks(time, toa, altitude, np.zeros(altitude.shape), np.ones(altitude.shape))


class Setup(NamedTuple):
    """What stays the same for all marks."""

    stations: Floats
    """(S, 3) m"""
    variance: Floats
    """(S,) m^2, of c TOA"""
    spread_limit: Floats
    """(S, S) m, largest possible |c (TOA_i - TOA_j)|"""
    middle: Floats
    """(3,) m, centre of the stations"""
    radius_of_site: float
    altitude_variance: float
    earth: Floats
    earth_centre: Floats
    earth_radius: float
    sigma_jerk: float
    noise_form: int
    use_altitude: bool
    robust: bool
    residual_gate_m: float
    gate_centre_s: float
    """Half the gate's length: where an emission is assumed before the first solution."""
    gather_time_s: float
    """Marks older than this do not help to start a track."""
    gather_altitude: float
    gather_altitude_variance: float
    """Altitude that is assumed for a start where none is decoded."""
    update: int
    """Index into `UPDATES`."""
    emission_variance: float
    """m^2, of c times the emission time before the mark, where it is a state"""


class Track(NamedTuple):
    """What every lane remembers; index 0 = the track, 1 = its rival while two positions explain the marks."""

    x: Floats
    """(2, 9, LANES)"""
    p: Floats
    """(2, 45, LANES) packed"""
    cost: Floats
    """(2, LANES), NIS + ln det(S / R) summed since the split: minus twice the log-likelihood but for a constant"""
    time: Floats
    gate: Floats
    last_update: Floats
    live: Ints
    rival: Ints
    number: Ints
    started: Ints
    """How many tracks this lane has had."""
    suspect: Ints
    window: Floats
    """(WINDOW_MARKS, LANES), NIS / dof"""
    window_fill: Ints
    doubt: Ints
    """(S, LANES), how little a station is believed: grows with each reception that cannot be of the others' pulse"""
    gathered: Gathered


class Report(NamedTuple):
    """What is kept of each mark; L lanes last."""

    time: Floats
    state: Floats
    covariance: Floats
    """(M, 45, L) packed, or (M, 6, L), of the position alone"""
    nis: Floats
    dof: NDArray[np.int32]
    status: NDArray[np.int8]
    reason: NDArray[np.int8]
    track: NDArray[np.int32]
    used: NDArray[np.bool_]
    altitude_used: NDArray[np.bool_]
    residual: Floats
    start_error: Floats
    probability: Floats
    """(M, 2, L), of the interacting models; no rows where there are none"""
    bias: Floats
    """(M, 2, L) m: the altitude's bias and its standard deviation"""


class Now(NamedTuple):
    """The mark at hand: one value a lane, made once and filled anew for each mark."""

    toa: Floats
    """(S, LANES) m, c times the times of arrival"""
    used: Floats
    """(S, LANES), 1 where received"""
    altitude: Floats
    has_altitude: Floats
    altitude_extra: Floats
    altitude_biased: Floats
    spread_left: Ints
    """1 + the station whose reception cannot be that of the others' pulse and is left out, -1 - the one whose reception
    is left out because others of it were impossible lately; 0 = none
    """
    receptions: Ints
    """How many stations heard the mark."""
    possible: Ints
    elapsed: Floats
    """s since the state"""
    at: Floats
    """(3, LANES) m, where the mark is linearised"""
    go: Floats
    """1 where the mark updates the lane"""
    iterate: Ints
    """1 where it is linearised again at its own solution"""
    status: Ints
    reason: Ints
    dof: Ints
    nis: Floats
    scale: Floats
    rival_go: Floats
    """`go` of the second hypotheses"""
    first_nis: Floats
    first_scale: Floats
    """What the first hypothesis made of the mark, while the second is measured."""
    determinant: Floats
    """Product of S / R over the rows: what the likelihood needs besides NIS."""
    took: Ints
    """1 where the mark entered the estimate"""
    shown: Floats
    """1 where there is an estimate to show, else NaN"""
    fix_position: Floats
    fix_covariance: Floats
    fix_cost: Floats
    work: Floats
    """(3, S): one lane's receptions for the one-mark solution"""
    flight: Floats
    flight_covariance: Floats
    """(8,) and (36,): one lane's solution from several marks"""


class Rows(NamedTuple):
    """The rows of the mark at hand: S contrasts and the altitude."""

    h: Floats
    nu: Floats
    variance: Floats
    active: Floats
    start: Floats
    """(3, LANES) m, the predicted position, to which `nu` refers"""
    position: Floats
    covariance: Floats
    """A bare position and its packed covariance: the update in small, to learn NIS before the noise is settled."""
    nis: Floats
    sums: Floats
    """(6 LANES,): workspace of the contrasts"""


def new_now(stations: int) -> Now:
    """Room for one mark."""
    return Now(
        toa=np.zeros((stations, LANES)),
        used=np.zeros((stations, LANES)),
        altitude=np.zeros(LANES),
        has_altitude=np.zeros(LANES),
        altitude_extra=np.zeros(LANES),
        altitude_biased=np.zeros(LANES),
        spread_left=np.zeros(LANES, np.int64),
        receptions=np.zeros(LANES, np.int64),
        possible=np.zeros(LANES, np.int64),
        elapsed=np.zeros(LANES),
        at=np.zeros((3, LANES)),
        go=np.zeros(LANES),
        iterate=np.zeros(LANES, np.int64),
        status=np.zeros(LANES, np.int64),
        reason=np.zeros(LANES, np.int64),
        dof=np.zeros(LANES, np.int64),
        nis=np.zeros(LANES),
        scale=np.ones(LANES),
        rival_go=np.zeros(LANES),
        first_nis=np.zeros(LANES),
        first_scale=np.ones(LANES),
        determinant=np.ones(LANES),
        took=np.zeros(LANES, np.int64),
        shown=np.zeros(LANES),
        fix_position=np.zeros((2, 3)),
        fix_covariance=np.zeros((2, 6)),
        fix_cost=np.zeros(2),
        work=np.zeros((3, stations)),
        flight=np.zeros(8),
        flight_covariance=np.zeros(36),
    )


def new_rows(stations: int) -> Rows:
    """Room for the rows of one mark."""
    n = stations + 1
    return Rows(
        h=np.zeros((n, 3, LANES)),
        nu=np.zeros((n, LANES)),
        variance=np.ones((n, LANES)),
        active=np.zeros((n, LANES)),
        start=np.zeros((3, LANES)),
        position=np.zeros((3, LANES)),
        covariance=np.zeros((6, LANES)),
        nis=np.zeros(LANES),
        sums=np.zeros(6 * LANES),
    )


def new_track(stations: int = 0, gathered: int = 0) -> Track:
    """Lanes without a track, with room for so many marks of a start from several."""
    p = np.zeros((2, 45, LANES))
    for i in range(9):
        p[:, i * (i + 1) // 2 + i] = 1.0  # idle lanes stay harmless
    return Track(
        x=np.zeros((2, 9, LANES)),
        p=p,
        cost=np.zeros((2, LANES)),
        time=np.zeros(LANES),
        gate=np.full(LANES, -np.inf),
        last_update=np.zeros(LANES),
        live=np.zeros(LANES, np.int64),
        rival=np.zeros(LANES, np.int64),
        number=np.zeros(LANES, np.int64),
        started=np.zeros(LANES, np.int64),
        suspect=np.zeros(LANES, np.int64),
        window=np.zeros((WINDOW_MARKS, LANES)),
        window_fill=np.zeros(LANES, np.int64),
        doubt=np.zeros((stations, LANES), np.int64),
        gathered=new_gathered(stations, gathered),
    )


def new_report(
    marks: int,
    stations: int,
    lanes: int,
    *,
    covariance: Literal["state", "position"] = "state",
    receptions: bool = True,
    models: bool = False,
) -> Report:
    """Room for the report of so many marks, with the covariance of the whole state or of the position alone, and with
    what became of single receptions and of starts in vain or without it; `models` = with what interacting models say.
    """
    rows = marks if receptions else 0
    return Report(
        time=np.full((marks, lanes), np.nan),
        state=np.full((marks, 9, lanes), np.nan),
        covariance=np.full((marks, 45 if covariance == "state" else 6, lanes), np.nan),
        nis=np.full((marks, lanes), np.nan),
        dof=np.zeros((marks, lanes), np.int32),
        status=np.full((marks, lanes), NOT_INITIALISED, np.int8),
        reason=np.zeros((marks, lanes), np.int8),
        track=np.zeros((marks, lanes), np.int32),
        used=np.zeros((rows, stations, lanes), np.bool_),
        altitude_used=np.zeros((marks, lanes), np.bool_),
        residual=np.full((rows, stations, lanes), np.nan),
        start_error=np.full((rows, lanes), np.nan),
        probability=np.full((marks if models else 0, 2, lanes), np.nan),
        bias=np.full((marks if models else 0, 2, lanes), np.nan),
    )
