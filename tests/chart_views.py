"""Small runs and recordings, written by hand, for the tests of the charts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from algorithms.recording import AntennaPlots, DopplerPairs, PolarPlots, Recording, ToaMarks
from algorithms.result import Table
from algorithms.site import Site, Terminal
from backend.charts.view import Entry, RunView
from tests.pair_views import pair_metrics, pair_values

STATIONS = [("west", -10000.0, 0.0), ("east", 10000.0, 0.0), ("north", 0.0, 12000.0), ("middle", 0.0, 0.0)]


def site(**more: Any) -> Site:
    places = [{"name": name, "east_m": east, "north_m": north, "up_m": 10.0} for name, east, north in STATIONS]
    return Site.model_validate({"stations": places} | more)


def marks(count: int = 6, *, truth: bool = True, altitude: bool = True, targets: int = 1, **more: Any) -> ToaMarks:
    """Marks one second apart, targets in turn; the second mark lacks the station `north`."""
    k = np.arange(count)
    toa = np.full((count, 4, 1), 1e-4)
    if count > 1:
        toa[1, 2] = np.nan
    place = np.stack([1000.0 * k, 20000.0 + 100.0 * (k % targets), np.full(count, 3000.0)], axis=1)
    fields: dict[str, Any] = {
        "time_s": k.astype(float),
        "row": k + 1,
        "target": k % targets,
        "targets": tuple(f"t{i + 1}" for i in range(targets)),
        "truth_m": place if truth else np.full((count, 3), np.nan),
        "site": site(),
        "toa_s": toa,
        "altitude_m": np.full((count, 1), 3030.0 if altitude else np.nan),
        "stations": tuple(name for name, _, _ in STATIONS),
    }
    return ToaMarks(**(fields | more))


def states(recording: Recording, **more: Any) -> Table:
    """Estimates 30 m east and 40 m north of the true place (of 20 km north where that is unknown)."""
    count = len(recording)
    truth = np.nan_to_num(recording.truth_m, nan=20000.0)
    columns: dict[str, Any] = {
        "trial": np.full(count, np.nan),
        "track": recording.target + 1.0,
        "time_s": recording.time_s.copy(),
        "east_m": truth[:, 0] + 30,
        "north_m": truth[:, 1] + 40,
        "up_m": truth[:, 2] + 5,
        "velocity_east_mps": np.full(count, 200.0),
        "velocity_north_mps": np.zeros(count),
        "velocity_up_mps": np.zeros(count),
        **{f"acceleration_{axis}_mps2": np.full(count, 1.0) for axis in ("east", "north", "up")},
        "sigma_east_m": np.full(count, 60.0),
        "sigma_north_m": np.full(count, 80.0),
        "sigma_up_m": np.full(count, 100.0),
        "drms_m": np.full(count, 100.0),
        "nis": np.full(count, 3.0),
        "dof": np.full(count, 3.0),
        "status": ["updated"] * count,
        "used": ["west east middle"] * count,
        "row": recording.row.copy(),
        "target": [recording.targets[i] for i in recording.target],
        "covariance_east_north_m2": np.zeros(count),
        "altitude_bias_m": np.full(count, 25.0),
        "altitude_bias_sd_m": np.full(count, 10.0),
    }
    return Table(columns | more)


def errors(recording: Recording) -> Table:
    known = np.flatnonzero(np.isfinite(recording.truth_m).all(axis=1))
    return Table(
        {
            "trial": np.full(known.size, np.nan),
            "time_s": recording.time_s[known],
            "error_horizontal_m": np.full(known.size, 50.0),
            "row": recording.row[known],
        }
    )


def arrays(recording: ToaMarks) -> dict[str, Any]:
    """Residuals of 1, 2, 3 and 4 m of the four stations, where a mark was received."""
    received = np.isfinite(recording.toa_s)
    residual = np.broadcast_to(np.arange(1.0, 5.0)[:, None], received.shape)
    return {"row": recording.row, "used": received, "residual_m": residual}


def receivers(suspect: tuple[float, float, float, float] = (0.0, 1.0, np.nan, 0.0)) -> Table:
    """The station `east` is late, `north` is not judged."""
    return Table(
        {
            "station": [name for name, _, _ in STATIONS],
            "suspect": np.array(suspect),
            "reason": [None, "late by 1000 ns (300 m)", "too few to tell", None],
        }
    )


def receiver_delays() -> Table:
    """Every station heard in two intervals, the `east` 300 m late."""
    names = [name for name, _, _ in STATIONS for _ in range(2)]
    late = np.array([300.0 if name == "east" else 1.0 for name in names])
    columns = {"station": names, "time_s": np.tile([1.0, 4.0], len(STATIONS)), "receptions": np.full(late.size, 9.0)}
    return Table(columns | {"late_m": late, "late_sd_m": np.full(late.size, 2.0)})


def entry(label: str, index: int, tables: Mapping[str, Table], recording: Recording | None = None) -> Entry:
    held = arrays(recording) if isinstance(recording, ToaMarks) else {}
    held |= pair_values() | path_values()
    return Entry(label, index, "rdf", lambda name: tables.get(name, Table({})), lambda: held)


def path_values() -> dict[str, Any]:
    """Places of six trials at five instants of two cells, along and across a base line; the true path is straight."""
    across = np.broadcast_to(np.linspace(-3000.0, 3000.0, 5)[:, None], (2, 5, 6))
    along = np.full((2, 5, 6), 15_000.0)
    wild = np.linspace(-1.0, 1.0, 6) * np.array([5000.0, 1000.0, 500.0, 400.0, 300.0])[:, None]
    estimated = np.where(np.arange(5)[:, None] == 0, np.nan, along + wild)
    return {
        "trials/place_along_m": estimated,
        "trials/place_across_m": np.where(np.isnan(estimated), np.nan, across),
        "trials/true_place_along_m": along,
        "trials/true_place_across_m": across,
    }


def run(
    recording: Recording,
    *tables: Mapping[str, Table],
    labels: tuple[str, ...] = ("a", "b", "c"),
    algorithms: tuple[str, ...] = ("rdf",) * 3,
) -> RunView:
    """A run with one entry for each set of tables."""
    entries = (replace(entry(labels[i], i, t, recording), algorithm=algorithms[i]) for i, t in enumerate(tables))
    return RunView(recording, tuple(entries))


MODELS = (("cv_0.05", 0.75), ("ca_30", 0.25))


def model_tables(recording: Recording) -> dict[str, Table]:
    """Probabilities of two motion models at every row."""
    n = len(recording)
    columns: dict[str, Any] = {
        "trial": np.full(2 * n, np.nan),
        "track": np.ones(2 * n),
        "time_s": np.repeat(recording.time_s, 2),
        "model": [name for name, _ in MODELS] * n,
        "probability": np.tile([share for _, share in MODELS], n),
        "row": np.repeat(recording.row, 2),
    }
    return {"mode_probabilities": Table(columns)}


def trial_tables(scale: float = 1.0, swept: str = "scenario.sigma_altitude_m") -> dict[str, Table]:
    """Curves and metrics of ten trials at two swept values; at the first instant nothing is known yet."""
    count = 5
    growing = scale * np.array([np.nan, 40.0, 30.0, 20.0, 10.0] * 2)
    columns: dict[str, Any] = {
        swept: np.repeat([10.0, 100.0], count),
        "target": [None] * (2 * count),
        "time_s": np.tile(np.arange(float(count)), 2),
        "rms_horizontal_m": growing,
        "rms_horizontal_m_low": 0.9 * growing,
        "rms_horizontal_m_high": 1.1 * growing,
        "claimed_horizontal_m": 0.8 * growing,
        "lost_share": np.array([np.nan, 0.0, 0.1, 0.0, 0.0] * 2),
        "bound_horizontal_m": 0.5 * growing,
        "trials": np.full(2 * count, 10.0),
    }
    for name, factor in (("rms", 1.0), ("sd", 0.9), ("mean", -0.4), ("bound_3", 0.5), ("bound_4", 0.7)):
        columns[f"crossing_distance_{name}_m"] = factor * growing
    columns |= {f"crossing_distance_rms_m_{e}": f * growing for e, f in (("low", 0.9), ("high", 1.1))}
    columns |= {"radial_bias_m": -growing, "probability_correct": growing / (100 * scale)}
    for name, factor in (("p16", -1.2), ("median", -0.1), ("p84", 0.9)):
        columns[f"{name}_crossing_distance_error_m"] = factor * growing
    columns |= {"ospa_m": 5 * growing, "gospa_m": 9 * growing}
    columns["answered_share"] = np.array([0.0, 0.5, 0.9, 1.0, 1.0] * 2)
    columns |= {"bound_east_m": 0.5 * growing, "bound_north_m": 0.5 * growing}
    for name in ("up_m", "velocity_up_mps", "position_m"):
        columns |= {f"rms_{name}": growing, f"bound_{name}": 0.5 * growing}
        columns |= {f"rms_{name}_{e}": f * growing for e, f in (("low", 0.9), ("high", 1.1))}
    columns |= {f"mode_probability_{model}": np.where(np.isfinite(growing), share, np.nan) for model, share in MODELS}
    for statistic in ("nees", "nis"):
        known = np.isfinite(growing)
        columns |= {statistic: np.where(known, 1.5, np.nan)}
        columns |= {f"{statistic}_low": np.where(known, 0.7, np.nan), f"{statistic}_high": np.where(known, 1.4, np.nan)}
    metrics: dict[str, Any] = {
        "metric": ["rms_horizontal_m"] * 3 + ["crossing_distance_rms_m"] * 2 + ["ospa_m"] * 2 + ["rms_up_m"],
        "segment": [None, None, "orbit", "crossing", "crossing", None, None, "turn"],
        "target": [None] * 8,
        swept: np.array([10.0, 100.0, 10.0, 10.0, 100.0, 10.0, 100.0, 10.0]),
        "value": scale * np.array([20.0, 30.0, 40.0, 20.0, 30.0, 100.0, 150.0, 50.0]),
        "ci95_low": scale * np.array([19.0, 29.0, 39.0, 19.0, 29.0, 95.0, 140.0, 49.0]),
        "ci95_high": scale * np.array([21.0, np.nan, 41.0, 21.0, 31.0, 105.0, 160.0, 51.0]),
    }
    compared: dict[str, Any] = {
        "metric": ["rms_up_m", "rms_velocity_up_mps"] * 2,
        "segment": ["arc", "arc", "turn", "turn"],
        "against": ["a"] * 4,
        "target": [None] * 4,
    }
    for name, factor in (("ratio", 1.0), ("ratio_low", 0.9), ("ratio_high", 1.1)):
        compared[name] = factor * scale * np.array([1.0, 1.5, 0.5, 2.0])
    times = {swept: np.array([10.0, 100.0]), "seconds_per_trial": scale * np.array([0.1, 0.7])}
    return {
        "curves": Table(columns),
        "metrics": pair_metrics(metrics, swept),
        "comparisons": Table(compared),
        "computing_times": Table(times),
    }


def complete_run(recording: ToaMarks, **more: Any) -> RunView:
    tables = {
        "states": states(recording, **more),
        "errors": errors(recording),
        "receivers": receivers(),
        "receiver_delays": receiver_delays(),
    }
    return run(recording, tables)


def plots(count: int = 4, **more: Any) -> PolarPlots:
    """Plots at 10 km to the east of the radar."""
    none = np.full((count, 1), np.nan)
    k = np.arange(count)
    fields: dict[str, Any] = {
        "time_s": k.astype(float),
        "row": k + 1,
        "target": np.zeros(count, int),
        "range_m": np.full((count, 1), 10000.0),
        "azimuth_rad": np.full((count, 1), np.pi / 2),
        "elevation_rad": none,
        "altitude_m": none,
        "east_m": none,
        "north_m": none,
        "radar": np.zeros(count, int),
        "radar_east_m": np.full(count, np.nan),
        "radar_north_m": np.full(count, np.nan),
        "scan": np.full(count, -1),
        "address": np.full(count, -1),
        "callsign": np.full(count, -1),
    }
    return PolarPlots(**(fields | more))


def two_radars(count: int = 4) -> PolarPlots:
    """Plots of two radars in turn, all of one target 10 km to the east of the first."""
    k = np.arange(count)
    radars = [
        {"name": name, "east_m": east, "north_m": 0.0, "sigma_range_m": 50.0, "sigma_azimuth_deg": 1.0}
        for name, east in (("west", 0.0), ("east", 5_000.0))
    ]
    return plots(
        count,
        radar=k % 2,
        radars=("west", "east"),
        range_m=np.where(k % 2, 5_000.0, 10_000.0)[:, None],
        truth_m=np.tile([10_000.0, 0.0, 0.0], (count, 1)),
        site=Site.model_validate({"radars": radars}),
    )


def antenna(count: int = 4) -> AntennaPlots:
    k = np.arange(count)
    return AntennaPlots(
        time_s=k.astype(float),
        row=k + 1,
        target=np.zeros(count, int),
        range_m=np.full((count, 1), 10000.0),
        bicone_elevation_rad=np.full((count, 1), np.pi / 6),
        bicone_azimuth_rad=np.full((count, 1), np.pi / 4),
    )


FORWARD_SCATTER = Site(
    transmitters=(Terminal(name="TX", east_m=40000.0, north_m=0.0),),
    receivers=tuple(Terminal(name=n, east_m=0.0, north_m=y) for n, y in (("RX1", -150.0), ("RX2", 150.0))),
    wavelength_m=1.0,
)


def doppler(count: int = 4, *, site: bool = True) -> DopplerPairs:
    """Two receivers 300 m apart, a transmitter 40 km to the east; a target crosses at 15 km to the north."""
    k = np.arange(count)
    truth = np.stack([np.full(count, 15000.0), 200.0 * (k - 1.5), np.zeros(count)], axis=1)
    return DopplerPairs(
        truth_m=truth,
        truth_velocity_mps=np.tile([0.0, 200.0, 0.0], (count, 1)),
        site=FORWARD_SCATTER if site else None,
        time_s=k.astype(float),
        row=k + 1,
        target=np.zeros(count, int),
        doppler_hz=np.full((count, 2, 1), 5.0),
        doppler_rate_hz_s=np.full((count, 2, 1), np.nan),
        azimuth_rad=np.full((count, 1), np.pi / 2),
        elevation_rad=np.full((count, 1), np.nan),
        channels=("1", "2"),
    )


def scatter_tables(recording: Recording) -> dict[str, Table]:
    """What the forward-scatter algorithms say: one pass of all rows."""
    n = len(recording)
    time = recording.time_s
    common: dict[str, Any] = {"trial": np.full(n, np.nan), "track": np.ones(n), "time_s": time}
    ends = {"row": recording.row.copy(), "target": [None] * n}
    crossings: dict[str, Any] = {**common}
    for name, value in (("crossing_s", 1.5), ("distance_m", 15000.0), ("across_mps", 200.0)):
        crossings |= {name: value + 0.01 * np.arange(n), f"sigma_{name}": np.full(n, 0.02 * value)}
    status = ["extrapolated" if i % 2 == 0 else "fitted" for i in range(n)]
    crossings |= {"chi2": np.arange(float(n)), "dof": np.arange(n), "status": status}
    for j in (1, 2):
        crossings |= {
            f"line_{j}_centre_s": time - 0.5, f"line_{j}_centre_hz": np.full(n, 2.0),
            f"line_{j}_slope_hz_s": np.full(n, -4.0),
            f"line_{j}_zero_s": time, f"crossing_{j}_s": np.full(n, 1.5), f"kept_{j}": np.ones(n),
        }  # fmt: skip
    crossings |= {
        "omega_rad_s": np.full(n, 0.013),
        "difference_hz": np.full(n, -4.0),
        "azimuth_deg": 0.8 * (time - 1.5),
    }
    dopplers = {
        **{name: np.concatenate([values] * 2) for name, values in common.items()},
        "channel": ["1"] * n + ["2"] * n, "doppler_hz": np.full(2 * n, 5.0), "residual_hz": np.full(2 * n, 0.1),
        "used": np.arange(2 * n) % 3.0, "row": np.tile(recording.row, 2), "target": [None] * (2 * n),
    }  # fmt: skip
    return {
        "crossings": Table(crossings | ends),
        "dopplers": Table(dopplers),
        "sensitivities": Table(
            {"track": np.ones(2), "quantity": ["clock", "base"], "step": np.ones(2), "step_unit": ["ms", "%"],
             "error_m": np.array([20.0, 50.0])}
        ),
        "base_bounds": Table(
            {"distance_m": np.array([1e4, 2e4]), "crossing_known_m": np.array([100.0, 200.0]),
             "end_known_m": np.array([90.0, 180.0]), "crossing_unknown_m": np.array([150.0, 250.0]),
             "end_unknown_m": np.array([90.0, 190.0])}
        ),
    }  # fmt: skip
