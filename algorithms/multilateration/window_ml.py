"""Maximum likelihood over a sliding window: a polynomial of time through all marks of the last minute or two.

The unknowns are a position and its derivatives at the newest mark, on each axis alone (order 1: constant velocity).
All marks of the window enter with their range differences and altitudes at once, linearised at the polynomial itself
(Gauss-Newton with the damping of Levenberg and Marquardt), so nothing of an earlier linearisation is kept:

    one mark, w = 1/sigma^2:  A = sum w (u - m)(u - m)^T,  g = sum w (u - m)(e - n),   m, n weighted means
    all marks, f = (1, tau, tau^2/2):  information_(ai)(bj) = sum f_i f_j A_ab,  gradient_ai = sum f_i g_a

On straight legs it beats the filters; in a turn a polynomial of order 1 errs by kilometres. With `manoeuvre` =
`shorten` the window is halved until its cost passes the chi-square test, down to ten seconds.

Differences from the paper: it does not have the method. From the specification (6.3): the rule that shortens.

References
----------
Specification 6.3; more1978.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from algorithms.multilateration import lanes
from algorithms.multilateration.conditions import Conditions, conditions_of, given_or_default, toa_of
from algorithms.multilateration.fixes import solve_recording
from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import OUTPUTS
from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.scoring import score_marks
from algorithms.multilateration.tables import tabulate
from algorithms.multilateration.window_rows import window_normal
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.scores import Scores
from algorithms.spec import Algorithm, PartOfRun, Reference, RunContext, parameter
from algorithms.toolbox.kernels.symmetric import pack
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Weak belief about the derivatives, so that a window of one mark has a solution: m/s, m/s2.
DERIVATIVE_SD = (lanes.START_VELOCITY_SD_MPS, lanes.START_ACCELERATION_SD_MPS2)
STEPS = 8
CONVERGED_M = 0.1
SHORTEST_S = 10.0
PASSES = 0.999
LARGEST_CONDITION = 1e14
TINY = 1e-12


class WindowMlParameters(AltitudeParameters):
    """Parameters of the maximum likelihood over a window."""

    altitude: Literal["none", "white"] = parameter(
        "white",
        title="Altitude",
        group="measurement",
        choices={"none": "not used", "white": "an observation with the error above"},
    )
    """Whether a decoded altitude is used."""
    window_s: float = parameter(60.0, title="Window", unit="s", symbol="W", group="motion", gt=0, le=600)
    """How old a mark may be that still counts."""
    order: Literal[1, 2] = parameter(
        1, title="Order", group="motion", choices={"1": "constant velocity", "2": "constant acceleration"}
    )
    """Of the polynomial in time."""
    manoeuvre: Literal["shorten", "keep"] = parameter(
        "shorten",
        title="In a manoeuvre",
        group="motion",
        choices={
            "shorten": "the window is halved until the flight in it is straight enough",
            "keep": "the window stays as it is",
        },
    )
    """What happens where the marks do not lie on one polynomial."""


class _Marks(NamedTuple):
    """Marks of one target: instants (M,), c times the arrivals (M, S, L), altitudes (M, L), usable (M, L)."""

    time: Floats
    toa: Floats
    altitude: Floats
    usable: Bools


def run(recording: ToaMarks, parameters: WindowMlParameters, context: RunContext) -> Result:
    """Fit the window before every mark of every target.

    Raises
    ------
    RecordingError, ParameterError
        No site, or WGS-84 without an origin.
    """
    with_altitude = parameters.altitude == "white"
    conditions = conditions_of(recording, parameters, with_altitude=with_altitude)
    toa = toa_of(recording, conditions)
    altitude = recording.altitude_m if with_altitude else np.full_like(recording.altitude_m, np.nan)
    arrays: dict[str, NDArray[Any]] = solve_recording(
        recording, conditions, toa, altitude, PartOfRun(context, 0.0, 0.1)
    )
    del arrays["roots_m"]
    done = 0
    for number, rows in enumerate(recording.rows_by_target()):
        # One trial after another: sums over several would round differently with their number.
        for trial in range(altitude.shape[1] if rows.size else 0):
            one = slice(trial, trial + 1)
            mine = {name: a[..., one] if a.ndim > 1 else a for name, a in arrays.items()}
            _track(
                recording,
                conditions,
                parameters,
                toa[rows][..., one],
                altitude[rows][:, one],
                mine,
                rows,
                number,
                context,
            )
            done += rows.size
            context.progress(0.1 + 0.9 * done / max(altitude.size, 1))
    names = ("altitude", "window_s", "order", "manoeuvre")
    return Result(
        arrays, conditions.notes, conditions.settings | {name: given_or_default(parameters, name) for name in names}
    )


def score(recording: ToaMarks, parameters: WindowMlParameters, context: RunContext) -> Scores:
    """Fit simulated marks and score the tracks against the truth."""
    arrays = run(recording, parameters, context).arrays
    return score_marks(recording, arrays["state"], arrays["covariance"], arrays["nis"], arrays["dof"])


def _track(
    recording: ToaMarks,
    conditions: Conditions,
    parameters: WindowMlParameters,
    toa_s: Floats,
    altitude: Floats,
    arrays: dict[str, NDArray[Any]],
    rows: NDArray[np.int64],
    number: int,
    context: RunContext,
) -> None:
    """Fit all marks of a target, in place of the fixes that `arrays` holds."""
    fixes = arrays["state"][rows][:, [0, 3, 6]].copy()
    possible = arrays["status"][rows] != lanes.IMPOSSIBLE_TOA
    heard = np.isfinite(toa_s)
    usable = possible & ((heard.sum(axis=1) >= 2) | np.isfinite(altitude))
    middle = np.where(heard, toa_s, 0.0).sum(axis=(1, 2)) / np.maximum(heard.sum(axis=(1, 2)), 1)
    marks = _Marks(recording.time_s[rows] + middle, SPEED_OF_LIGHT_MPS * toa_s, altitude, usable)
    trials = altitude.shape[1]
    size = 3 * (parameters.order + 1)
    theta = np.full((trials, size), np.nan)
    last = np.full(trials, np.nan)
    before = 0.0
    for k, row in enumerate(rows):
        if k % 16 == 0:
            context.check_cancelled()
        now = float(marks.time[k])
        theta[~(now - last <= lanes.GAP_S)] = np.nan
        _carry(theta, now - before)
        before = now
        fresh = np.isnan(theta[:, 0]) & np.isfinite(fixes[k, 0])
        theta[fresh] = 0.0
        theta[fresh, :: parameters.order + 1] = fixes[k][:, fresh].T
        last[usable[k] & np.isfinite(theta[:, 0])] = now
        result = _fit(marks, k, theta, parameters, conditions)
        _report(arrays, int(row), number, theta, result, fresh, usable[k], conditions)


def _carry(theta: Floats, t: float) -> None:
    """Move the polynomials on to a later instant."""
    n = theta.shape[1] // 3
    for a in range(3):
        if n == 3:
            theta[:, 3 * a] += t * theta[:, 3 * a + 1] + 0.5 * t * t * theta[:, 3 * a + 2]
            theta[:, 3 * a + 1] += t * theta[:, 3 * a + 2]
        else:
            theta[:, 2 * a] += t * theta[:, 2 * a + 1]


class _Fit(NamedTuple):
    covariance: Floats
    """(L, 3, 3) of the position"""
    cost: Floats
    dof: NDArray[np.int64]
    sound: Bools


def _fit(marks: _Marks, k: int, theta: Floats, parameters: WindowMlParameters, conditions: Conditions) -> _Fit:
    """Fit the window that ends with mark k, from `theta` (L, n), which becomes the solution."""
    begin = int(np.searchsorted(marks.time, marks.time[k] - parameters.window_s))
    tau = marks.time[begin : k + 1] - marks.time[k]
    window = np.full(theta.shape[0], parameters.window_s)
    part = _Marks(tau, marks.toa[begin : k + 1], marks.altitude[begin : k + 1], marks.usable[begin : k + 1])
    start = theta.copy()
    while True:
        fit = _minimise(part, theta, window, conditions)
        if parameters.manoeuvre == "keep":
            return fit
        limit = np.array([_limit(max(int(dof), 1)) for dof in fit.dof])
        again = fit.sound & (fit.dof > 0) & (fit.cost > limit) & (window > SHORTEST_S)
        if not again.any():
            return fit
        window = np.where(again, np.maximum(window / 2, SHORTEST_S), window)
        theta[again] = start[again]


@cache
def _limit(dof: int) -> float:
    """Cost that a straight flight exceeds with one minus `PASSES`."""
    return float(chi2.ppf(PASSES, dof))


def _minimise(part: _Marks, theta: Floats, window: Floats, conditions: Conditions) -> _Fit:
    n = theta.shape[1]
    damping = np.full(theta.shape[0], 1e-6)
    going = np.isfinite(theta[:, 0])
    theta_now = np.where(going[:, None], theta, 1.0)
    info, grad, cost, dof = _normal(part, theta_now, window, conditions)
    moving = going.copy()
    for _ in range(STEPS):
        scaled = info * (1 + damping[:, None, None] * np.eye(n))
        step = _solved(scaled, grad)
        moving &= np.linalg.norm(step[:, :: n // 3], axis=1) > CONVERGED_M
        if not moving.any():
            break
        trial = theta_now + np.where(moving[:, None], step, 0.0)
        new = _normal(part, trial, window, conditions)
        better = moving & (new[2] <= cost)
        theta_now[better] = trial[better]
        for old, fresh in ((info, new[0]), (grad, new[1]), (cost, new[2])):
            old[better] = fresh[better]
        damping = np.where(better, damping / 10, damping * 100)
    size = np.maximum(np.sqrt(np.einsum("lii->li", info)), TINY)
    unit = info / (size[:, :, None] * size[:, None, :])
    sound = going & (np.linalg.cond(unit) < LARGEST_CONDITION)
    covariance = np.full((theta.shape[0], n, n), np.nan)
    covariance[sound] = np.linalg.inv(info[sound])
    theta[:] = np.where(going[:, None], theta_now, np.nan)
    places = np.arange(0, n, n // 3)
    return _Fit(covariance[:, places][:, :, places], cost, dof, sound)


def _solved(a: Floats, b: Floats) -> Floats:
    size = np.maximum(np.sqrt(np.einsum("lii->li", a)), TINY)
    unit = a / (size[:, :, None] * size[:, None, :]) + 1e-15 * np.eye(a.shape[1])
    x: Floats = np.linalg.solve(unit, (b / size)[:, :, None])[:, :, 0] / size
    return x


def _normal(
    part: _Marks, theta: Floats, window: Floats, conditions: Conditions
) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
    """Information (L, n, n), gradient (L, n), cost (L,), degrees of freedom (L,) of the window."""
    trials, size = theta.shape
    n = size // 3
    info, grad = np.empty((trials, size, size)), np.empty((trials, size))
    cost, count = np.empty(trials), np.empty(trials, np.int64)
    weight = 1.0 / conditions.variance
    for trial in range(trials):
        cost[trial], count[trial] = window_normal(
            part.time, np.ascontiguousarray(part.toa[:, :, trial]), np.ascontiguousarray(part.altitude[:, trial]),
            np.ascontiguousarray(part.usable[:, trial]), window[trial], theta[trial], conditions.stations, weight,
            1.0 / conditions.sigma_altitude_m**2, conditions.earth, info[trial], grad[trial],
        )  # fmt: skip
    for i in range(1, n):
        for axis in range(3):
            q = axis * n + i
            belief = 1.0 / DERIVATIVE_SD[i - 1] ** 2
            info[:, q, q] += belief
            grad[:, q] -= belief * theta[:, q]
            cost = cost + belief * theta[:, q] ** 2
    return info, grad, cost, count - 3


def _report(
    arrays: dict[str, NDArray[Any]],
    row: int,
    number: int,
    theta: Floats,
    fit: _Fit,
    fresh: Bools,
    usable: Bools,
    conditions: Conditions,
) -> None:
    """Write what became of a mark."""
    n = theta.shape[1] // 3
    sd2 = fit.covariance[:, 0, 0] + fit.covariance[:, 1, 1]
    far = np.linalg.norm(theta[:, [0, n]] - conditions.middle[:2], axis=1)
    radius = np.linalg.norm(conditions.stations - conditions.middle, axis=1).max()
    shown = fit.sound & (sd2 <= (lanes.CLAIM_SHARE_OF_RANGE * np.maximum(far, radius)) ** 2)
    state = np.zeros((9, shown.size))
    for a in range(3):
        state[3 * a : 3 * a + n] = theta[:, a * n : a * n + n].T
    arrays["state"][row] = np.where(shown, state, np.nan)
    arrays["covariance"][row] = np.where(shown, pack(np.moveaxis(fit.covariance, 0, 2)), np.nan)
    arrays["track"][row] = np.where(shown, number + 1, 0)
    status, reason = arrays["status"][row], arrays["reason"][row]
    wrong = status == lanes.IMPOSSIBLE_TOA
    status[~wrong] = np.where(shown, np.where(usable, lanes.UPDATED, lanes.COAST), lanes.NOT_INITIALISED)[~wrong]
    status[fresh & shown & ~wrong] = lanes.INITIALISED
    reason[shown & usable & ~wrong] = lanes.R_NONE
    reason[~shown & np.isfinite(theta[:, 0]) & ~wrong] = lanes.R_CLAIM
    used = shown & usable & ~wrong
    arrays["used"][row] &= used
    arrays["altitude_used"][row] &= used
    arrays["residual_m"][row] = np.where(used, arrays["residual_m"][row], np.nan)
    arrays["nis"][row] = np.where(shown & (fit.dof > 0), fit.cost, np.nan)
    arrays["dof"][row] = np.where(shown, np.maximum(fit.dof, 0), 0)


ALGORITHM = Algorithm(
    name="window_ml",
    title="Maximum likelihood over a window",
    summary="A polynomial through the marks of the last minute. The most accurate where flight is straight, for "
    "comparison; slow, and without a gate.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=WindowMlParameters,
    outputs=OUTPUTS,
    charts=("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receiver_delays", "receptions"),
    references=(Reference("more1978"), Reference("chugunov2023")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
