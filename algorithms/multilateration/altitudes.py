"""Altitude of every mark: decoded, or what stands in for it where none is decoded, and how far it can be trusted.

The last decoded altitude of the emitter is held; its noise grows with the time since, as the emitter may climb. Where
that is worse than what is known of the emitter's type, or nothing was ever decoded, the table of types speaks, and
after it the class of all emitters. A mark without two receptions gets none: nothing would be learnt but what was put
in, and a lost track would never end.

The error of what stands in is common to all marks, so that many of them must not count more than one. Each is given
the variance of its source times tau / T, where T is the time since the last altitude of any source: all that fall
within tau together weigh as one. Only the altitude held has the bias of a decoded one.

References
----------
Specification 6.5, 6.6, 8.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.parameters import MissingAltitudeParameters
from algorithms.recording import ToaMarks
from algorithms.result import Note
from algorithms.spec import Parameters

Floats = NDArray[np.float64]

SOURCES = ("none", "decoded", "held", "type", "class")
NONE, DECODED, HELD, TYPE, CLASS = range(5)
# Marks at one instant: what the second says is common with the first.
SHORTEST_S = 1e-3


@dataclass(frozen=True)
class Altitudes:
    """Altitude of each mark (M, L).

    Attributes
    ----------
    altitude_m : NaN = none
    extra_m2 : by which its variance differs from a decoded one's; exactly 0 of decoded ones alone
    biased : 1 where it has the bias of a decoded altitude
    source : index into `SOURCES`
    sigma_m : its own standard deviation, without what the weighting of many adds; NaN = none
    """

    altitude_m: Floats
    extra_m2: Floats
    biased: Floats
    source: NDArray[np.int8]
    sigma_m: Floats

    def notes(self) -> tuple[Note, ...]:
        """Return how many marks have an altitude that was not decoded, by its source."""
        held, of_type, of_class = (int((self.source == source).sum()) for source in (HELD, TYPE, CLASS))
        notes = (
            Note("altitude_held", f"{held} altitudes are the last decoded ones, held with growing noise.", held),
            Note("altitude_type", f"{of_type} altitudes come from the table of emitter types.", of_type),
            Note("altitude_class", f"{of_class} altitudes are that of the class of all emitters.", of_class),
        )
        return tuple(note for note in notes if note.count)


def altitudes_of(recording: ToaMarks, toa_s: Floats, parameters: Parameters | None, sigma_m: float) -> Altitudes:
    """Decoded altitudes, completed as the parameters ask for; sigma_m is the error of a decoded one."""
    decoded = np.isfinite(recording.altitude_m)
    source = np.where(decoded, DECODED, NONE).astype(np.int8)
    altitude = recording.altitude_m
    sigma = np.where(decoded, sigma_m, np.nan)
    biased = np.ones(altitude.shape)
    extra = np.zeros(altitude.shape)
    if not isinstance(parameters, MissingAltitudeParameters):
        return Altitudes(altitude, extra, biased, source, sigma)
    if parameters.missing_altitude == "unused" or decoded.all():
        return Altitudes(altitude, extra, biased, source, sigma)
    assumed = (getattr(parameters, "start_altitude_m", np.nan), getattr(parameters, "start_altitude_sd_m", np.inf))
    altitude = altitude.copy()
    open_marks = ~decoded & (np.isfinite(toa_s).sum(axis=1) >= 2)
    prior, prior_sd, prior_source = _priors(recording, parameters, assumed)
    for rows in recording.rows_by_target():
        if not rows.size:
            continue
        time = recording.time_s[rows]
        last = _last(decoded[rows], before=False)
        there = last >= 0
        held = np.where(there, np.take_along_axis(recording.altitude_m[rows], np.maximum(last, 0), axis=0), np.nan)
        age = time[:, None] - time[np.maximum(last, 0)]
        held_sd = np.where(there, np.hypot(sigma_m, parameters.held_altitude_growth_mps * age), np.inf)
        of_prior = prior_sd[rows][:, None] < held_sd
        value = np.where(of_prior, prior[rows][:, None], held)
        sd = np.minimum(prior_sd[rows][:, None], held_sd)
        fill = open_marks[rows] & np.isfinite(sd)
        any_altitude = decoded[rows] | fill
        previous = _last(any_altitude, before=True)
        apart = np.where(previous >= 0, time[:, None] - time[np.maximum(previous, 0)], np.inf)
        weight = np.maximum(1.0, parameters.missing_altitude_time_s / np.maximum(apart, SHORTEST_S))
        more = sd**2 * weight - sigma_m**2
        altitude[rows] = np.where(fill, value, altitude[rows])
        sigma[rows] = np.where(fill, sd, sigma[rows])
        # Exactly 0 says decoded.
        extra[rows] = np.where(fill, np.where(more == 0.0, 1e-6, more), 0.0)
        source[rows] = np.where(fill, np.where(of_prior, prior_source[rows][:, None], HELD), source[rows])
        biased[rows] = np.where(fill & of_prior, 0.0, 1.0)
    return Altitudes(altitude, extra, biased, source, sigma)


def _last(there: NDArray[np.bool_], *, before: bool) -> NDArray[np.int64]:
    """(M, L) index of the last mark that is there, up to or before each; -1 = none."""
    at = np.where(there, np.arange(len(there))[:, None], -1)
    last: NDArray[np.int64] = np.maximum.accumulate(at, axis=0)
    if before:
        last = np.concatenate([np.full((1, last.shape[1]), -1), last[:-1]])
    return last


def _priors(
    recording: ToaMarks, parameters: MissingAltitudeParameters, assumed: tuple[float, float]
) -> tuple[Floats, Floats, NDArray[np.int8]]:
    """(M,) altitude, standard deviation (infinite = none) and source of what is known without any decoded altitude."""
    value = np.full(len(recording), np.nan)
    sd = np.full(len(recording), np.inf)
    source = np.full(len(recording), NONE, np.int8)
    if parameters.missing_altitude == "class":
        value[:], sd[:], source[:] = *assumed, CLASS
    if parameters.missing_altitude in ("type", "class"):
        for row in parameters.emitter_altitudes:
            if row.emitter_type in recording.emitter_types:
                mine = recording.emitter_type == recording.emitter_types.index(row.emitter_type)
                value[mine], sd[mine], source[mine] = row.altitude_m, row.sigma_m, TYPE
    return value, sd, source
