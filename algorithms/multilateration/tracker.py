"""Run the range-difference filter over a recording: targets apart, trials side by side, in slices."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError, RecordingError
from algorithms.multilateration import lanes
from algorithms.multilateration.altitudes import Altitudes, altitudes_of
from algorithms.multilateration.bank import Choice, new_bank, with_altitude_noise
from algorithms.multilateration.blocks import Block, blocks_of, run_beside
from algorithms.multilateration.conditions import Conditions, conditions_of, given_or_default, toa_of
from algorithms.multilateration.filter_kernel import filter_marks
from algorithms.multilateration.imm_kernel import filter_marks_by_models
from algorithms.multilateration.joint_update import PRINTED_GRADIENT, PRINTED_SIGN
from algorithms.multilateration.lanes import Report, Setup, Track
from algorithms.multilateration.outputs import position_part
from algorithms.multilateration.parameters import FilterParameters, MarkParameters, MissingAltitudeParameters, Start
from algorithms.multilateration.scoring import score_marks
from algorithms.multilateration.separated import of_one_emitter, run_separated
from algorithms.multilateration.smoothing import check_size, smooth_report
from algorithms.recording import ToaMarks
from algorithms.result import Note, Result, Setting
from algorithms.scores import Scores
from algorithms.spec import RunContext
from algorithms.toolbox.kernels.symmetric import pack
from algorithms.toolbox.motion.jerk import PROCESS_NOISE

Floats = NDArray[np.float64]

# Receptions in one call of the kernel: some 50 ms, so that a cancel is seen soon.
SLICE_RECEPTIONS = 40_000
# A longer recording keeps the covariance of the position alone: that of the whole state is two thirds of a result.
FULL_COVARIANCE_MARKS = 100_000
POSITION_COVARIANCE = "Of each covariance the position's part alone is kept: the recording has more than 100,000 marks."


def run_filter(
    recording: ToaMarks,
    parameters: FilterParameters,
    context: RunContext,
    *,
    altitude: bool,
    models: Choice | None = None,
    emission_sd_m: float | None = None,
) -> Result:
    """Filter every target of a recording (specification 4-6), with or without the altitude observation, by one model or
    by two that interact.

    Raises
    ------
    RecordingError, ParameterError
        No site; a start that does not fit.
    RunCancelled
        Where the context says so.
    """

    def filtered(marks: ToaMarks, part: RunContext) -> Result:
        return _run(marks, parameters, part, altitude=altitude, models=models, emission_sd_m=emission_sd_m)

    if parameters.emitters == "separate" and "" in recording.targets and recording.toa_s.shape[2] == 1:
        return run_separated(recording, parameters, context, filtered, altitude=altitude)
    result = filtered(recording, context)
    settings = dict(result.settings) | {"emitters": given_or_default(parameters, "emitters")}
    return Result(result.arrays, result.notes, settings)


def _run(
    recording: ToaMarks,
    parameters: FilterParameters,
    context: RunContext,
    *,
    altitude: bool,
    models: Choice | None,
    emission_sd_m: float | None,
) -> Result:
    report, conditions, settings, altitudes = _filtered(
        recording, parameters, context, altitude=altitude, lean=False, models=models, emission_sd_m=emission_sd_m
    )
    notes = conditions.notes + altitudes.notes()
    if keeps_position_alone(recording) and parameters.smoothing == "none":
        notes = (*notes, Note("position_covariance", POSITION_COVARIANCE))
    arrays = _arrays(recording, report) | ({} if models is None else _of_models(report))
    arrays |= {
        "altitude_source": altitudes.source,
        "altitude_given_m": altitudes.altitude_m,
        "altitude_sigma_m": altitudes.sigma_m,
    }
    arrays |= of_one_emitter(recording)
    return Result(arrays, notes, settings)


def keeps_position_alone(recording: ToaMarks) -> bool:
    """Whether a result leaves out the covariances of velocity and acceleration."""
    return len(recording) * recording.toa_s.shape[2] > FULL_COVARIANCE_MARKS


def score_filter(
    recording: ToaMarks,
    parameters: FilterParameters,
    context: RunContext,
    *,
    altitude: bool,
    models: Choice | None = None,
    emission_sd_m: float | None = None,
) -> Scores:
    """Filter a block of simulated trials and score it against the truth."""
    report, _, _, _ = _filtered(
        recording, parameters, context, altitude=altitude, lean=True, models=models, emission_sd_m=emission_sd_m
    )
    # A mark whose noise was scaled up is a decision; one late reception would drown the mean.
    nis = np.where(report.status == lanes.DOWNWEIGHTED, np.nan, report.nis)
    return score_marks(recording, report.state, position_part(report.covariance), nis, report.dof)


def _filtered(
    recording: ToaMarks,
    parameters: FilterParameters,
    context: RunContext,
    *,
    altitude: bool,
    lean: bool,
    models: Choice | None = None,
    emission_sd_m: float | None = None,
) -> tuple[Report, Conditions, dict[str, Setting], Altitudes]:
    """Run the kernel over all targets and trials; a lean report has what scores need: no receptions, and of the
    covariance the position's. `emission_sd_m`: the emission time is a state, with so wide a prior (times c).
    """
    conditions = conditions_of(recording, parameters, profile=parameters.profile, with_altitude=altitude)
    settings = (
        conditions.settings
        | {
            "profile": given_or_default(parameters, "profile"),
            "process_noise": Setting(_process_noise(parameters), "run" if parameters.process_noise else "profile"),
            "sigma_jerk_mps3": given_or_default(parameters, "sigma_jerk_mps3"),
            "smoothing": given_or_default(parameters, "smoothing"),
        }
        | {name: given_or_default(parameters, name) for name in ("update", "printed") if hasattr(parameters, name)}
        | _altitude_settings(parameters, altitude=altitude)
        | _start_settings(parameters)
    )
    setup = filter_setup(recording, parameters, conditions, altitude=altitude)
    if emission_sd_m is not None:
        setup = setup._replace(update=lanes.RAW, emission_variance=emission_sd_m**2)
    if models is not None:
        # What starts a track knows no bias: to it the altitude is so much less certain.
        models = with_altitude_noise(models, conditions)
        setup = setup._replace(altitude_variance=models.altitude_variance + models.bias_variance)
    gathered = int(settings["start_marks"].value)
    toa = toa_of(recording, conditions)
    altitudes = altitudes_of(recording, toa, parameters if altitude else None, conditions.sigma_altitude_m)
    stations, trials = toa.shape[1:]
    is_smoothed = parameters.smoothing == "fixed_interval"
    if is_smoothed:
        check_size(recording)
    spare = (lean or keeps_position_alone(recording)) and not is_smoothed
    kept: Literal["state", "position"] = "position" if spare else "state"
    with_models = models is not None and (not lean or is_smoothed)
    whole = lanes.new_report(len(recording), stations, trials, covariance=kept, receptions=not lean, models=with_models)
    highest = np.zeros((len(recording.targets), trials), np.int64)
    step = max(1, SLICE_RECEPTIONS // max(stations, 1))
    total = max(len(recording) * trials, 1)
    done: list[int] = []

    def run(blocks: Iterator[Block]) -> None:
        now, work = lanes.new_now(stations), lanes.new_rows(stations)
        for block in blocks:
            track = started(parameters.start, recording, block.firsts, block.numbers, context, gathered)
            bank = new_bank(stations)
            for k in range(0, block.size, step):
                context.check_cancelled()
                stop = min(k + step, block.size)
                marks = block.marks(recording, toa, altitudes, k, stop)
                report = lanes.new_report(
                    stop - k, stations, marks.time.shape[1], covariance=kept, receptions=not lean, models=with_models
                )
                if models is None:
                    filter_marks(marks, setup, track, now, work, report, 0, stop - k)
                else:
                    filter_marks_by_models(marks, setup, models, track, bank, now, work, report, 0, stop - k)
                done.append(block.put(whole, report, highest, k, stop))
                context.progress(sum(done) / total)

    # Trials keep all processors busy as it is.
    run_beside(run, list(blocks_of(recording, trials)), threads=2 if trials == 1 else 1)
    if is_smoothed:
        smooth_report(recording, whole, parameters, _process_noise(parameters), models)
    # Every target counts its tracks from one; in the recording they go on from target to target.
    before = np.cumsum(highest, axis=0) - highest
    whole.track[:] = np.where(whole.track > 0, whole.track + before[recording.target], 0)
    return whole, conditions, settings, altitudes


def filter_setup(recording: ToaMarks, parameters: FilterParameters, conditions: Conditions, *, altitude: bool) -> Setup:
    """Gather the constants of a kernel call for a filter with these parameters."""
    gate_length = recording.site.gate_length_s if recording.site is not None else None
    return setup_of(
        conditions,
        sigma_jerk_mps3=parameters.sigma_jerk_mps3,
        process_noise=_process_noise(parameters),
        altitude=altitude,
        robust=parameters.profile == "robust",
        gate_length_s=gate_length or 0.0,
        gathering=parameters,
    )


def _process_noise(parameters: FilterParameters) -> str:
    return parameters.process_noise or ("paper" if parameters.profile == "article" else "white")


def _start_settings(parameters: FilterParameters) -> dict[str, Setting]:
    """Tell what a start from several marks used; the article's profile makes none."""
    names = ("start_marks", "start_window_s", "start_altitude_m", "start_altitude_sd_m")
    settings = {name: given_or_default(parameters, name) for name in names}
    if parameters.profile == "article":
        settings["start_marks"] = Setting(0, "profile")
    return settings


def _altitude_variance(conditions: Conditions, parameters: MarkParameters) -> float:
    """m^2, of a decoded altitude; as (13) prints it, that of an arrival."""
    if getattr(parameters, "printed", "") == "variance":
        return float(conditions.variance.mean())
    return conditions.sigma_altitude_m**2


def _update_of(parameters: MarkParameters) -> int:
    """Code of the update for the kernel: a misprint replaces the extended filter's."""
    printed = {"sign": PRINTED_SIGN, "gradient": PRINTED_GRADIENT}.get(getattr(parameters, "printed", ""))
    update = getattr(parameters, "update", "ekf")
    return printed if printed is not None and update == "ekf" else lanes.UPDATES.index(update)


def _altitude_settings(parameters: MarkParameters, *, altitude: bool) -> dict[str, Setting]:
    """Tell what stands in for altitudes that are not decoded."""
    wanted = getattr(parameters, "missing_altitude", None)
    if not altitude or wanted is None:
        return {}
    names = list(MissingAltitudeParameters.model_fields)
    settings = {name: given_or_default(parameters, name) for name in (names[:1] if wanted == "unused" else names)}
    if "emitter_altitudes" in settings:
        table = settings["emitter_altitudes"]
        settings["emitter_altitudes"] = Setting([row.model_dump() for row in table.value], table.source)
    return settings


def setup_of(
    conditions: Conditions,
    *,
    sigma_jerk_mps3: float,
    process_noise: str,
    altitude: bool,
    robust: bool,
    gate_length_s: float = 0.0,
    gathering: FilterParameters | None = None,
) -> Setup:
    """Gather the constants of a kernel call."""
    gathering = gathering or FilterParameters()
    return Setup(
        stations=conditions.stations,
        variance=conditions.variance,
        spread_limit=conditions.spread_limit,
        middle=conditions.middle,
        radius_of_site=float(np.linalg.norm(conditions.stations - conditions.middle, axis=1).max()),
        altitude_variance=_altitude_variance(conditions, gathering),
        earth=conditions.earth,
        earth_centre=conditions.earth_centre,
        earth_radius=conditions.earth_radius,
        sigma_jerk=sigma_jerk_mps3,
        noise_form=PROCESS_NOISE.index(process_noise),
        use_altitude=altitude,
        robust=robust,
        residual_gate_m=conditions.residual_gate_m,
        gate_centre_s=gate_length_s / 2,
        gather_time_s=gathering.start_window_s,
        gather_altitude=gathering.start_altitude_m,
        gather_altitude_variance=gathering.start_altitude_sd_m**2,
        update=_update_of(gathering),
        emission_variance=0.0,
    )


def started(
    start: Start,
    recording: ToaMarks,
    firsts: NDArray[np.int64],
    trials: NDArray[np.int64],
    context: RunContext,
    gathered: int = 0,
) -> Track:
    """Lanes before the first mark: empty, or with the given state at the first mark's time.

    `firsts` are the positions of the lanes' first marks in the recording, `trials` their trials; `gathered` is how many
    marks are kept for a start from several.
    """
    track = lanes.new_track(len(recording.stations), gathered)
    if start.mode == "auto":
        return track
    covariance = start_covariance(start)
    root, packed = np.linalg.cholesky(covariance), pack(covariance)
    for lane, (first, trial) in enumerate(zip(firsts, trials, strict=True)):
        drawn = root @ context.random(int(trial)).standard_normal(9) if start.mode == "truth" else 0.0
        track.x[0, :, lane] = _start_state(start, recording, int(first)) + drawn
        track.p[0, :, lane] = packed
        track.time[lane] = track.last_update[lane] = recording.time_s[first]
        track.live[lane] = track.number[lane] = track.started[lane] = 1
    return track


def _start_state(start: Start, recording: ToaMarks, first: int) -> Floats:
    """(9,): the state that is given, or the truth at this mark."""
    if start.mode == "given":
        return np.array(start.state, float)
    state = np.stack([recording.truth_m[first], recording.truth_velocity_mps[first], np.zeros(3)], axis=1)
    if not np.isfinite(state).all():
        raise RecordingError(
            "a start around the truth needs true position and velocity at the first mark",
            pointer="/start/mode",
            remedy="use a scenario, or `auto` for an uploaded recording",
            code="truth_missing",
        )
    return state.ravel()


def start_covariance(start: Start) -> Floats:
    """(9, 9): covariance of a start that is given or drawn around the truth."""
    if start.covariance is not None:
        covariance = np.array(start.covariance)
        if not np.allclose(covariance, covariance.T, rtol=1e-9, atol=0) or np.linalg.eigvalsh(covariance)[0] <= 0:
            raise ParameterError(
                "the start covariance is not symmetric positive definite",
                pointer="/start/covariance",
                remedy="give a covariance matrix, or standard deviations in `sd`",
                code="start_covariance",
            )
        return covariance
    assert start.sd is not None
    sd = np.array(start.sd)
    return np.diag(np.tile(sd, 3) ** 2 if sd.size == 3 else sd**2)


def _arrays(recording: ToaMarks, report: Report) -> dict[str, NDArray[np.generic]]:
    return {
        "row": recording.row,
        "target": recording.target,
        "time_s": report.time,
        "state": report.state,
        "covariance": report.covariance,
        "track": report.track,
        "status": report.status,
        "reason": report.reason,
        "nis": report.nis,
        "dof": report.dof,
        "used": report.used,
        "altitude_used": report.altitude_used,
        "residual_m": report.residual,
        "start_error_m": report.start_error,
    }


def _of_models(report: Report) -> dict[str, NDArray[np.generic]]:
    return {
        "mode_probability": report.probability,
        "altitude_bias_m": report.bias[:, 0],
        "altitude_bias_sd_m": report.bias[:, 1],
    }
