"""What the columns of a foreign CSV may mean, told from their names: a suggestion, never applied by itself."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from algorithms.recording import KINDS, Kind
from backend.files.cells import NumberStyle, read_numbers
from backend.files.native_columns import NAMES, QUANTITIES, TOA_COLUMN, kinds_of
from backend.files.options import ColumnSource
from backend.files.selection import TIME_WORDS
from backend.files.truth_columns import TRUTH_QUANTITIES
from backend.files.units import UNITS, native_unit

# Words by which programs call a quantity. The first native name that a kind has and nothing else serves yet is taken.
_WORDS: dict[str, tuple[str, ...]] = {
    "time_s": ("time", "t", "timestamp", "tod", "utc", "datetime", "date", "epoch", "toy", "timeofday", "unixtime"),
    "range_m": ("range", "rho", "distance", "dist", "slantrange", "r"),
    "azimuth_deg": ("azimuth", "az", "theta", "bearing", "brg", "azm"),
    "elevation_deg": ("elevation", "el", "elev"),
    "altitude_m": ("altitude", "alt", "fl", "flightlevel", "modec", "baroaltitude", "height", "h"),
    "east_m": ("east", "x", "e", "easting"),
    "north_m": ("north", "y", "n", "northing"),
    "latitude_deg": ("plotlatitude", "plotlat"),
    "longitude_deg": ("plotlongitude", "plotlon"),
    "radar_east_m": ("radareast", "owneast", "ownx", "radarx"),
    "radar_north_m": ("radarnorth", "ownnorth", "owny", "radary"),
    "bicone_elevation_deg": ("biconeelevation", "biconeel"),
    "bicone_azimuth_deg": ("biconeazimuth", "biconeaz"),
    **{f"doppler_{c}_hz": (f"doppler{c}", f"fd{c}", f"f{c}") for c in ("1", "2", "11", "12", "21", "22")},
    "scan": ("scan", "turn", "rotation", "scannumber"),
    "radar": ("radar", "sensor", "site", "sic"),
    "address": ("address", "icao", "icao24", "modes", "modesaddress", "hex"),
    "callsign": ("callsign", "ident", "flight"),
    "mode_3a": ("mode3a", "squawk", "ssr"),
    "target": ("target", "aircraft", "track", "trackid", "targetid", "icao", "icao24", "id"),
    "emitter_type": ("emittertype", "emitter"),
    "true_latitude_deg": ("truelatitude", "truelat", "latitude", "lat", "gpslat", "gnsslat"),
    "true_longitude_deg": ("truelongitude", "truelon", "longitude", "lon", "lng", "gpslon", "gnsslon"),
    "true_height_m": ("trueheight", "geoaltitude", "gpsheight", "gnssheight", "ellipsoidheight"),
    "true_east_m": ("trueeast", "truthx", "truex"),
    "true_north_m": ("truenorth", "truthy", "truey"),
    "true_up_m": ("trueup", "truthz", "truez"),
}
_RECEPTION_WORDS = ("toa", "arrival", "rx", "recv", "receiver", "station", "timeofarrival")
# How units are written in a name: `rho_nm`, `Range [NM]`, `time (ms)`.
_UNIT_WORDS: dict[str, str] = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "nsec": "ns", "µs": "us",
    "degree": "deg", "degrees": "deg", "radians": "rad", "meter": "m", "meters": "m", "metre": "m", "metres": "m",
    "feet": "ft", "nmi": "NM", "kt": "kn", "knots": "kn",
}  # fmt: skip
_DIMENSION_UNITS = {(n.lower(), u.dimension): n for n, u in UNITS.items()}


@dataclass(frozen=True)
class NativeColumn:
    """A native column that a kind has, and the units that a source of it may be in (none for names and counters)."""

    name: str
    units: tuple[str, ...]


@dataclass(frozen=True)
class Suggestion:
    """A kind and the mapping that would make a recording of it; columns that are native already are not in it."""

    kind: Kind | None
    mapping: Mapping[str, ColumnSource]


def native_columns(kind: Kind) -> tuple[NativeColumn, ...]:
    """Columns of a kind in the order in which they are asked for; `toa_<station>_ns` stands for one per station."""
    own = [NativeColumn("time_s", (*units_for("time_s"), *TIME_WORDS))]
    if kind == "toa_marks":
        own.append(NativeColumn("toa_<station>_ns", units_for("toa_x_ns")))
    own += [NativeColumn(q.name, () if q.whole else units_for(q.name)) for q in QUANTITIES[kind]]
    own += [NativeColumn(n.name, ()) for n in NAMES[kind]]
    return (*own, *(NativeColumn(q.name, units_for(q.name)) for q in TRUTH_QUANTITIES))


def units_for(name: str) -> tuple[str, ...]:
    """Units of the dimension of a native column, its own first."""
    own = native_unit(name)
    return (own, *(n for n, u in UNITS.items() if u.dimension == UNITS[own].dimension and n != own))


def suggest(names: Sequence[str], rows: Sequence[Sequence[str]], kind: Kind | None) -> Suggestion:
    """Guess the meaning of columns from their names, and angles in radians from their values.

    Parameters
    ----------
    names, rows : the line of names and some rows of cells
    kind : where the user named it
    """
    best = Suggestion(kind, {})
    for candidate in (kind,) if kind is not None else tuple(KINDS):
        mapping = _mapping(names, rows, candidate)
        offered = (*mapping, *(n for n in names if n not in {s.column for s in mapping.values()}))
        fits = candidate in kinds_of(offered) and "time_s" in offered
        if fits and (best.kind is None or kind is not None or len(mapping) > len(best.mapping)):
            best = Suggestion(candidate, mapping)
    return best


def in_other_unit(names: Iterable[str], known: Iterable[str]) -> list[tuple[str, str]]:
    """Columns that are called as a native one but for another unit of its dimension, such as `altitude_ft`, with it."""
    natives = {_words(native): native for native in known}
    by_word = {plain: (native, native_unit(native)) for (plain, unit), native in natives.items() if unit}
    out = []
    for name in names:
        plain, word = _words(name)
        native, own = by_word.get(plain, ("", ""))
        unit = _DIMENSION_UNITS.get((_UNIT_WORDS.get(word, word).lower(), UNITS[own].dimension)) if native else None
        if unit is not None and unit != own:
            out.append((name, native))
    return out


def _mapping(names: Sequence[str], rows: Sequence[Sequence[str]], kind: Kind) -> dict[str, ColumnSource]:
    known = [c.name for c in native_columns(kind)]
    taken = {n for n in names if n in known or (kind == "toa_marks" and TOA_COLUMN.fullmatch(n))}
    out: dict[str, ColumnSource] = {}
    words = {name: _words(name) for name in names if name and name not in taken}
    for native in known:
        if native in taken or native not in _WORDS:
            continue
        for spelled in _WORDS[native]:
            found = next((n for n, (plain, _) in words.items() if plain == spelled and n not in taken), None)
            if found is not None:
                values = [row[names.index(found)] for row in rows if len(row) == len(names)]
                out[native] = ColumnSource(column=found, unit=_unit(native, found, words[found][1], values))
                taken.add(found)
                break
    if kind == "polar_plots" and not set(kinds_of((*out, *taken))):
        # Where nothing else was measured, places are what was.
        for native in ("latitude_deg", "longitude_deg"):
            if f"true_{native}" in out:
                out[native] = out.pop(f"true_{native}")
    if kind == "toa_marks":
        for name, (plain, unit) in words.items():
            station = _station(plain)
            if name not in taken and station is not None and f"toa_{station}_ns" not in names:
                native = f"toa_{station}_ns"
                out.setdefault(native, ColumnSource(column=name, unit=_unit(native, name, unit, ())))
    return out


def _words(name: str) -> tuple[str, str]:
    """Return the name without its unit, as one lower-case word, and the unit's word (or nothing)."""
    spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    tokens = [t for t in re.split(r"[^\w/µ]+|_", spaced.lower()) if t]
    last = tokens[-1] if len(tokens) > 1 else ""
    is_unit = last in _UNIT_WORDS or any(last == n for n, _ in _DIMENSION_UNITS)
    return ("".join(tokens[:-1]), last) if is_unit else ("".join(tokens), "")


def _station(plain: str) -> str | None:
    for word in _RECEPTION_WORDS:
        if plain.startswith(word) and len(plain) > len(word):
            return plain[len(word) :]
    return None


def _unit(native: str, name: str, word: str, values: Sequence[str]) -> str | None:
    """Return the unit where it is not the native one."""
    if not any(native.endswith(s) for s in ("_s", "_m", "_deg", "_hz", "_ns", "_mps")):
        return None
    own = native_unit(native)
    if native == "altitude_m" and _words(name)[0] in ("fl", "flightlevel"):
        return "FL"
    found = _DIMENSION_UNITS.get((_UNIT_WORDS.get(word, word).lower(), UNITS[own].dimension))
    if found is None and UNITS[own].dimension == "angle" and len(values) > 1:
        numbers = read_numbers(values, NumberStyle()).values
        if np.isfinite(numbers).any() and np.nanmax(np.abs(numbers)) <= 2 * np.pi and np.nanstd(numbers) > 0:
            # Twenty rows of an antenna that turns would hold larger numbers if they were degrees.
            found = "rad" if len(values) >= 10 and native == "azimuth_deg" else None
    return None if found == own else found
