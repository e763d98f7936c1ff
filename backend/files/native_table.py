"""The native columns of a recording: its rows in the units of docs/formats.md, to be written in any form."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from algorithms.recording import (
    AntennaPlots,
    DopplerPairs,
    Floats,
    Ints,
    PolarPlots,
    Recording,
    ToaMarks,
    TruthTracks,
)
from algorithms.result import Column, Table
from algorithms.texts import Texts
from backend.files.units import UNITS, native_unit

# Decimals of the short form in the file's unit: 1e-6 ns, 1e-12 degrees, 1e-9 of anything else.
_SHORT_DECIMALS = {"ns": 6, "deg": 12}

NativeColumn = tuple[str, Floats | Ints, tuple[str, ...] | None]
"""Name, values in SI or codes, and the names of the codes."""


def native_table(recording: Recording, *, trial: int = 0) -> Table:
    """Return one trial of a recording of any kind, with its truth where it has one, as a table.

    Values are in the units of the columns' names; NaN and None stand for nothing. `row` is no column: rows are
    numbered by their place.
    """
    return _table(native_columns_of(recording, trial))


def truth_table(tracks: TruthTracks) -> Table:
    """Return true paths as a table that is read as the truth of a recording."""
    return _table(truth_columns_of(tracks))


def _table(native: Iterable[NativeColumn]) -> Table:
    columns: dict[str, Column] = {}
    for name, values, names in native:
        if names is not None:
            # A code of -1 names nothing.
            columns[name] = Texts.coded(np.where(values < 0, len(names), values), [*names, None])
        elif values.dtype == np.int64:
            columns[name] = np.where(values < 0, np.nan, values)
        else:
            columns[name] = in_unit(name, values.astype(np.float64))
    return Table(columns)


def native_columns_of(recording: Recording, trial: int) -> Iterator[NativeColumn]:
    """Yield the columns that hold anything."""
    yield "time_s", recording.time_s, None
    yield from _names("target", recording.target, recording.targets)
    if isinstance(recording, ToaMarks):
        for i, station in enumerate(recording.stations):
            yield f"toa_{station}_ns", recording.toa_s[:, i, trial], None
        yield from _present("altitude_m", recording.altitude_m[:, trial])
        yield from _names("emitter_type", recording.emitter_type, recording.emitter_types)
    elif isinstance(recording, PolarPlots):
        yield from _polar(recording, trial)
    elif isinstance(recording, AntennaPlots):
        yield "range_m", recording.range_m[:, trial], None
        yield "bicone_elevation_deg", recording.bicone_elevation_rad[:, trial], None
        yield "bicone_azimuth_deg", recording.bicone_azimuth_rad[:, trial], None
    elif isinstance(recording, DopplerPairs):
        for i, channel in enumerate(recording.channels):
            yield f"doppler_{channel}_hz", recording.doppler_hz[:, i, trial], None
        for i in (0, 1):
            yield from _present(f"doppler_rate_{i + 1}_hz_s", recording.doppler_rate_hz_s[:, i, trial])
        yield from _present("azimuth_deg", recording.azimuth_rad[:, trial])
        yield from _present("elevation_deg", recording.elevation_rad[:, trial])
    if recording.has_truth:
        for i, axis in enumerate(("east", "north", "up")):
            yield f"true_{axis}_m", recording.truth_m[:, i], None
        for i, axis in enumerate(("east", "north", "up")):
            yield from _present(f"true_velocity_{axis}_mps", recording.truth_velocity_mps[:, i])


def truth_columns_of(tracks: TruthTracks) -> Iterator[NativeColumn]:
    """Yield the columns of true paths, target by target in order of time."""
    yield "time_s", tracks.time_s, None
    yield from _names("target", tracks.target, tracks.targets)
    for i, axis in enumerate(("east", "north", "up")):
        yield f"true_{axis}_m", tracks.position_m[:, i], None
    for i, axis in enumerate(("east", "north", "up")):
        yield from _present(f"true_velocity_{axis}_mps", tracks.velocity_mps[:, i])


def _polar(plots: PolarPlots, trial: int) -> Iterator[NativeColumn]:
    yield from _names("radar", plots.radar, plots.radars)
    if (plots.scan >= 0).any():
        yield "scan", plots.scan, None
    measured = {
        "range_m": plots.range_m,
        "azimuth_deg": plots.azimuth_rad,
        "east_m": plots.east_m,
        "north_m": plots.north_m,
        "elevation_deg": plots.elevation_rad,
        "altitude_m": plots.altitude_m,
    }
    for name, values in measured.items():
        yield from _present(name, values[:, trial])
    yield from _present("radar_east_m", plots.radar_east_m)
    yield from _present("radar_north_m", plots.radar_north_m)
    yield from _names("address", plots.address, plots.addresses)
    yield from _names("callsign", plots.callsign, plots.callsigns)
    yield from _names("mode_3a", plots.mode_3a, plots.modes_3a)


def _present(name: str, values: Floats) -> Iterator[NativeColumn]:
    if np.isfinite(values).any():
        yield name, values, None


def _names(name: str, codes: Ints, names: tuple[str, ...]) -> Iterator[NativeColumn]:
    if any(names):
        yield name, codes, names


def in_unit(name: str, values: Floats) -> Floats:
    """Return values in the unit of the column's name, as the shortest decimal that reads back as the same number."""
    word = native_unit(name)
    unit = UNITS[word]
    if unit.factor == unit.divisor == 1.0:
        return values
    converted = values * unit.divisor / unit.factor
    short = np.round(converted, _SHORT_DECIMALS[word])
    return np.where(unit.to_si(short) == values, short, converted)
