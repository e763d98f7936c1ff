"""Run a bank of models over a recording: targets apart, trials side by side, in slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.multiple_model import states
from algorithms.multiple_model.filter_kernel import filter_groups
from algorithms.multiple_model.measurements import Plots, Prepared, groups_of, prepare
from algorithms.multiple_model.parameters import MotionParameters, Region, check_rule
from algorithms.multiple_model.soundness import drop_lost, indefinite
from algorithms.multiple_model.states import Report, Setup
from algorithms.recording import Recording
from algorithms.result import Note, Setting
from algorithms.spec import RunContext
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.filters.merging import RULES
from algorithms.toolbox.filters.multiple_model import STRUCTURES, Bank, new_track, new_work
from algorithms.toolbox.filters.transition import chains_of, check_rows, check_times
from algorithms.toolbox.kernels import LANES
from algorithms.toolbox.motion.models import KINDS
from algorithms.toolbox.sensors.position_rows import MEASUREMENTS, new_rows

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Rows times hypotheses in one call of the kernel: some 50 ms, so that a cancel is seen soon.
SLICE = 20_000
# A gate widens after so many typical intervals without a plot.
COASTING_INTERVALS = 2.5
PLOTS_OF_SEVERAL = 0.05
"""Share of scans with several plots above which the nearest is chosen."""


@dataclass(frozen=True)
class ModelSet:
    """Motion models, how they change and how they are merged.

    Attributes
    ----------
    models : (kind, sigma in m/s^2 of the step form at `step_s`)
    transition : row = from
    """

    models: tuple[tuple[str, float], ...]
    transition: tuple[tuple[float, ...], ...] = ((1.0,),)
    step_s: float = 0.05
    structure: str = "imm"
    merging: str = "moment"
    output: str = "moment"
    regions: tuple[Region, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Kind and sigma: cv_0.05, ca_30; a repeated one gets _2."""
        return model_names(self.models)


@dataclass(frozen=True)
class Detector:
    """A manoeuvre detector: fading memory of NIS per degree of freedom that switches the noise of one model."""

    fade: float
    above: float
    below: float
    boost: float


@dataclass
class Filtered:
    """Reports of all rows and what was used."""

    report: Report
    prepared: Prepared
    settings: dict[str, Setting]
    notes: list[Note] = field(default_factory=list)


def model_names(models: Sequence[tuple[str, float]]) -> tuple[str, ...]:
    """Name models by kind and sigma."""
    out: list[str] = []
    for kind, sigma in models:
        name = f"{kind}_{sigma:g}"
        again = sum(1 for other in out if other == name or other.startswith(f"{name}_"))
        out.append(name if again == 0 else f"{name}_{again + 1}")
    return tuple(out)


def bank_of(chosen: ModelSet, parameters: MotionParameters) -> Bank:
    """Check a model set and prepare it for the kernel.

    Raises
    ------
    ParameterError
        A transition matrix that is none, a rule that does not fit the structure.
    """
    n = len(chosen.models)
    check_rule(chosen.structure, chosen.merging)
    columns = [check_rows(region.transition, n, f"/regions/{i}/transition") for i, region in enumerate(chosen.regions)]
    columns.append(check_rows(chosen.transition, n))
    return Bank(
        kinds=np.array([KINDS.index(kind) for kind, _ in chosen.models]),
        sigma=np.array([float(sigma) for _, sigma in chosen.models]),
        structure=STRUCTURES.index(chosen.structure),
        rule=RULES.index(chosen.merging),
        output_moment=int(chosen.output == "moment"),
        as_rate=int(parameters.noise_form == "rate"),
        rate_above_s=np.inf if parameters.noise_form == "substeps" else parameters.long_interval_s,
        chains=chains_of(columns, chosen.step_s),
    )


def run_bank(
    recording: Plots,
    parameters: MotionParameters,
    chosen: ModelSet,
    context: RunContext,
    *,
    lean: bool,
    detector: Detector | None = None,
    boost: Floats | None = None,
) -> Filtered:
    """Filter every target of a recording; `boost` (M, L) raises the models' noise over the interval before each row.

    Raises
    ------
    RecordingError, ParameterError
        No site; a model set that cannot be; intervals for which the transition matrix has no power.
    RunCancelled
        Where the context says so.
    """
    prepared = prepare(recording, parameters)
    bank = bank_of(chosen, parameters)
    trials = prepared.valid.shape[1]
    n = len(chosen.models)
    whole = states.new_report(len(recording), n, trials, lean=lean)
    offset = np.zeros(trials, np.int64)
    out = Filtered(whole, prepared, dict(prepared.settings), list(prepared.notes))
    nearest = _nearest(recording, parameters, prepared)
    out.settings |= _settings(parameters, nearest=nearest)
    clip = check_intervals(recording, bank)
    done, total = 0, max(len(recording) * trials, 1)
    context.check_cancelled()
    context.progress(0.0)
    for target in range(len(recording.targets)):
        rows = recording.rows_of(target)
        if rows.size == 0:
            continue
        group = groups_of(recording, rows, prepared.sensor, by_scan=nearest)
        setup = _setup(parameters, chosen, nearest, recording.time_s[rows], group, int(prepared.dof[0]), detector)
        for first in range(0, trials, LANES):
            part = slice(first, min(first + LANES, trials))
            marks = prepared.marks(recording, rows, part, group, boost)
            lanes = part.stop - part.start
            report = states.new_report(rows.size, n, lanes, lean=lean)
            track, work, state = new_track(n), new_work(n, bank.structure), states.new_lanes()
            scratch, now = new_rows(), states.new_now(len(work.s), positions=lean and not chosen.regions)
            step = max(1, SLICE // len(work.s))
            for g in range(0, len(group) - 1, step):
                context.check_cancelled()
                stop = min(g + step, len(group) - 1)
                filter_groups(marks, setup, bank, track, state, work, scratch, now, report, g, stop)
                done += int(group[stop] - group[g]) * lanes
                context.progress(min(done / total, 1.0))
            report.track[report.track > 0] += np.broadcast_to(offset[part], report.track.shape)[report.track > 0]
            chosen_rows = slice(None) if rows.size == len(recording) else rows
            for ours, theirs in zip(whole, report, strict=True):
                if ours.shape[0]:
                    ours[chosen_rows, ..., part] = theirs
            offset[part] = np.maximum(offset[part], report.track.max(axis=0, initial=0))
            clip = max(clip, float(state.clip[0]))
    out.notes += drop_lost(whole)
    if not lean:
        out.notes += indefinite(whole)
    _add_notes(out, parameters, clip)
    context.progress(1.0)
    return out


def _nearest(recording: Plots, parameters: MotionParameters, prepared: Prepared) -> bool:
    if parameters.association != "auto":
        return parameters.association == "nearest"
    several = rows = 0
    for target in range(len(recording.targets)):
        group = groups_of(recording, recording.rows_of(target), prepared.sensor, by_scan=True)
        several += int((np.diff(group) > 1).sum())
        rows += max(len(group) - 1, 0)
    return rows > 0 and several > PLOTS_OF_SEVERAL * rows


def _settings(parameters: MotionParameters, *, nearest: bool) -> dict[str, Setting]:
    names = ("measurement", "noise_form", "start_velocity_sd_mps", "start_acceleration_sd_mps2", "track_timeout_s")
    out = {n: Setting(getattr(parameters, n), "run" if n in parameters.model_fields_set else "default") for n in names}
    out["association"] = Setting(
        "nearest" if nearest else "all", "default" if parameters.association == "auto" else "run"
    )
    return out


def check_intervals(recording: Recording, bank: Bank) -> float:
    """Return the largest clip of the powers that a recording's intervals need, before anything is filtered.

    Raises
    ------
    ParameterError
        A transition matrix has no power for one of them.
    """
    found = [np.diff(np.unique(recording.time_s[recording.rows_of(t)])) for t in range(len(recording.targets))]
    intervals = np.concatenate(found) if found else np.empty(0)
    return check_times(bank.chains, intervals[intervals > 0])


def _setup(
    parameters: MotionParameters,
    chosen: ModelSet,
    nearest: bool,
    time: Floats,
    group: Ints,
    dof: int,
    detector: Detector | None,
) -> Setup:
    typical = float(np.median(np.diff(time[group[:-1]]))) if len(group) > 2 else np.inf
    corners = [np.array(region.corners, float).reshape(-1, 2) for region in chosen.regions]
    ends = np.cumsum([0, *(len(c) for c in corners)])
    return Setup(
        way=MEASUREMENTS.index(parameters.measurement),
        velocity_variance=parameters.start_velocity_sd_mps**2,
        acceleration_variance=parameters.start_acceleration_sd_mps2**2,
        timeout_s=parameters.track_timeout_s,
        gate=gate_threshold(1 - parameters.gate_probability, dof) if nearest else np.inf,
        widen_after_s=COASTING_INTERVALS * typical,
        widen=parameters.coasting_gate,
        substep_above_s=parameters.long_interval_s if parameters.noise_form == "substeps" else np.inf,
        fade=detector.fade if detector else 0.0,
        boost_above=detector.above if detector else np.inf,
        calm_below=detector.below if detector else 0.0,
        boost=detector.boost if detector else 1.0,
        corners=np.concatenate([*corners, np.empty((0, 2))]),
        first_corner=ends,
        heights=np.array([(r.lowest_up_m, r.highest_up_m) for r in chosen.regions], float).reshape(-1, 2),
    )


def _add_notes(out: Filtered, parameters: MotionParameters, clip: float) -> None:
    if np.isnan(clip) or clip > 1e-4:
        raise ParameterError(
            "The transition matrix has no power for the interval that refused measurements left.",
            pointer="/transition",
            remedy="Make the chance to stay larger than one half.",
            code="transition_root",
        )
    if clip > 0:
        out.settings["transition_clip"] = Setting(float(f"{clip:.3g}"), "default")
        out.notes.append(
            Note(
                "transition_clip",
                "a power of the transition matrix for a part of its interval held small negative entries, which were "
                "set to zero; the setting transition_clip is the largest",
            )
        )
    reason = out.report.reason
    for code, text in (
        (states.R_RATE, "intervals longer than long_interval_s were filtered with noise of the rate form"),
        (states.R_STEPS, "intervals longer than long_interval_s were split into steps of the base interval"),
        (states.R_GAP, "tracks were closed after a gap longer than track_timeout_s and started anew"),
        (states.R_RESTARTED, "tracks were started anew because their numbers lost their meaning"),
        (states.R_DOUBTFUL, "plots were taken after a gap in a widened gate: the track may follow another object"),
    ):  # fmt: skip
        count = int((reason == code).sum())
        if count:
            out.notes.append(Note(states.REASON_CODES[code], text, count))
