"""What goes into an algorithm: measurements in time order, of one kind, with their site and truth.

Measurement arrays carry the *trial* axis last: L trials of one scenario side by side; an uploaded recording is
a block with L = 1. Everything is in SI units and radians. Absent values are NaN.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from algorithms.site import Site

Kind = Literal["toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CLUTTER = "clutter"
"""Name of the target that false plots belong to where a recording says which are false."""
# In an .npz file the arrays of true paths stand beside those of the rows, under this prefix.
_TRACKS = "truth_tracks/"
_TRACK_ARRAYS = ("time_s", "target", "position_m", "velocity_mps")


@dataclass(frozen=True, kw_only=True)
class TruthTracks:
    """Where targets truly went, whole: also where nothing measured them, and where no row can be told its target.

    Attributes
    ----------
    time_s : (K,) float, s on the recording's clock, rising within each target
    target : (K,) int, index into `targets`, rising
    position_m : (K, 3) float, m, true ENU position
    velocity_mps : (K, 3) float, m/s; NaN where it was not given
    targets : names of their own; a target of the recording is the same one where the names are equal
    """

    time_s: Floats
    target: Ints
    position_m: Floats
    velocity_mps: Floats
    targets: tuple[str, ...] = ("",)

    @classmethod
    def of(
        cls, time_s: Floats, target: Ints, position_m: Floats, velocity_mps: Floats, targets: tuple[str, ...]
    ) -> TruthTracks | None:
        """Put points into order and leave out those without a position; None where nothing remains."""
        known = np.flatnonzero(np.isfinite(position_m).all(axis=1))
        order = known[np.lexsort((time_s[known], target[known]))]
        if not order.size:
            return None
        return cls(
            time_s=time_s[order],
            target=target[order],
            position_m=position_m[order],
            velocity_mps=velocity_mps[order],
            targets=targets,
        )

    def __len__(self) -> int:
        """Return the number of points."""
        return int(self.time_s.shape[0])

    def points_of(self, target: int) -> Ints:
        """Positions of the points of one target, in time order."""
        return np.arange(*np.searchsorted(self.target, (target, target + 1)))


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Fields that every kind has. M rows in time order.

    Attributes
    ----------
    time_s : (M,) float, s from `start_utc` (for marks: the start of the reception gate)
    row : (M,) int, number of the row in the source (first data row = 1; a simulated one counts from 1 too)
    target : (M,) int, index into `targets`; all zero and `targets == ("",)` where the source names none
    targets : names of the emitters / targets
    truth_m : (M, 3) float, m, true ENU position at the instant of the measurement; NaN where unknown
    truth_velocity_mps : (M, 3) float, m/s, or NaN
    truth_tracks : the true paths as they were given, whether or not rows could be told their positions; or None
    site : where the stations stand; None until the user gives one
    start_utc : ISO 8601 with Z, or None
    """

    kind: ClassVar[Kind]

    time_s: Floats
    row: Ints
    target: Ints
    targets: tuple[str, ...] = ("",)
    truth_m: Floats = field(default_factory=lambda: np.empty((0, 3)))
    truth_velocity_mps: Floats = field(default_factory=lambda: np.empty((0, 3)))
    truth_tracks: TruthTracks | None = None
    site: Site | None = None
    start_utc: str | None = None

    def __post_init__(self) -> None:
        m = self.time_s.shape[0]
        for name in ("truth_m", "truth_velocity_mps"):
            if getattr(self, name).shape[0] != m:
                object.__setattr__(self, name, np.full((m, 3), np.nan))

    def __len__(self) -> int:
        """Return the number of rows."""
        return int(self.time_s.shape[0])

    @property
    def has_truth(self) -> bool:
        """Whether any row has a true position."""
        return bool(np.isfinite(self.truth_m).all(axis=1).any())

    def rows_of(self, target: int) -> Ints:
        """Positions (not row numbers) of the rows of one target, in time order."""
        return np.flatnonzero(self.target == target)

    def rows_by_target(self) -> list[Ints]:
        """`rows_of` every target, found in one pass."""
        order = np.argsort(self.target, kind="stable")
        bounds = np.searchsorted(self.target, np.arange(1, len(self.targets)), sorter=order)
        return np.split(order, bounds)

    def take(self, positions: Ints) -> Self:
        """Return the same recording with only these rows; the true paths stay whole."""
        arrays = {
            f.name: getattr(self, f.name)[positions]
            for f in fields(self)
            if isinstance(getattr(self, f.name), np.ndarray)
        }
        return replace(self, **arrays)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Plain arrays for an .npz file; the rest travels as JSON in the member `meta`."""
        arrays = {f.name: getattr(self, f.name) for f in fields(self) if isinstance(getattr(self, f.name), np.ndarray)}
        apart = {"site", "truth_tracks", *arrays}
        meta: dict[str, Any] = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in apart}
        if self.truth_tracks is not None:
            arrays |= {_TRACKS + n: getattr(self.truth_tracks, n) for n in _TRACK_ARRAYS}
            meta["truth_targets"] = self.truth_tracks.targets
        meta["kind"] = self.kind
        meta["site"] = self.site.to_json() if self.site is not None else None
        arrays["meta"] = np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8)
        return arrays


@dataclass(frozen=True, kw_only=True)
class ToaMarks(Recording):
    """Times of arrival of pulses at the stations of a multilateration site.

    Attributes
    ----------
    toa_s : (M, S, L) float, s, offset from `time_s`; NaN = not received. Offsets, never epoch seconds: a float64
        epoch second resolves 238 ns = 71 m.
    altitude_m : (M, L) float, m, decoded altitude of the emitter; NaN = none
    stations : names of the S columns, in the order of `site.stations` once a site is known
    emitter_type : (M,) int, index into `emitter_types`, -1 = none
    """

    kind: ClassVar[Kind] = "toa_marks"

    toa_s: Floats
    altitude_m: Floats
    stations: tuple[str, ...]
    emitter_type: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    emitter_types: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.emitter_type.shape[0] != self.time_s.shape[0]:
            object.__setattr__(self, "emitter_type", np.full(self.time_s.shape[0], -1, np.int64))


@dataclass(frozen=True, kw_only=True)
class PolarPlots(Recording):
    """Plots of scanning radars.

    Attributes
    ----------
    range_m, azimuth_rad, elevation_rad, altitude_m : (M, L) float; azimuth clockwise from north; NaN = none
    east_m, north_m : (M, L) float, m, relative to the radar, where the source gives Cartesian plots; else NaN
    radar : (M,) int, index into `radars`
    radar_east_m, radar_north_m : (M,) float, position of a moving radar, NaN = the site's
    scan : (M,) int, -1 = none
    address, callsign, mode_3a : (M,) int, index into `addresses`, `callsigns`, `modes_3a`, -1 = none
    """

    kind: ClassVar[Kind] = "polar_plots"

    range_m: Floats
    azimuth_rad: Floats
    elevation_rad: Floats
    altitude_m: Floats
    east_m: Floats
    north_m: Floats
    radar: Ints
    radar_east_m: Floats
    radar_north_m: Floats
    scan: Ints
    address: Ints
    callsign: Ints
    radars: tuple[str, ...] = ("",)
    addresses: tuple[str, ...] = ()
    callsigns: tuple[str, ...] = ()
    mode_3a: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    modes_3a: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.mode_3a.shape[0] != self.time_s.shape[0]:
            object.__setattr__(self, "mode_3a", np.full(self.time_s.shape[0], -1, np.int64))


@dataclass(frozen=True, kw_only=True)
class AntennaPlots(Recording):
    """Range and bicone angles of an antenna: range_m, bicone_elevation_rad, bicone_azimuth_rad, (M, L)."""

    kind: ClassVar[Kind] = "antenna_plots"

    range_m: Floats
    bicone_elevation_rad: Floats
    bicone_azimuth_rad: Floats


@dataclass(frozen=True, kw_only=True)
class DopplerPairs(Recording):
    """Doppler frequencies of a forward-scatter site.

    Attributes
    ----------
    doppler_hz : (M, C, L) float, Hz, one column per channel of `channels`; NaN = not measured
    doppler_rate_hz_s : (M, 2, L) float, Hz/s; NaN = none
    azimuth_rad, elevation_rad : (M, L) float; NaN = none
    channels : "1", "2" or "11", "12", "21", "22" (transmitter, receiver)
    """

    kind: ClassVar[Kind] = "doppler_pairs"

    doppler_hz: Floats
    doppler_rate_hz_s: Floats
    azimuth_rad: Floats
    elevation_rad: Floats
    channels: tuple[str, ...]


KINDS: dict[Kind, type[Recording]] = {k.kind: k for k in (ToaMarks, PolarPlots, AntennaPlots, DopplerPairs)}


def recording_from_arrays(arrays: Mapping[str, NDArray[Any]]) -> Recording:
    """Rebuild a recording from what `Recording.to_arrays` gave."""
    meta = json.loads(bytes(arrays["meta"]).decode())
    kind = KINDS[meta.pop("kind")]
    site = meta.pop("site")
    given: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in meta.items()}
    targets = given.pop("truth_targets", None)
    if targets is not None:
        tracks = {n: np.asarray(arrays[_TRACKS + n]) for n in _TRACK_ARRAYS}
        given["truth_tracks"] = TruthTracks(**tracks, targets=targets)
    given |= {k: np.asarray(v) for k, v in arrays.items() if k != "meta" and not k.startswith(_TRACKS)}
    return kind(**given, site=Site.model_validate(site) if site is not None else None)
