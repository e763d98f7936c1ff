"""Boats on real marine radar, with the tracker's own defaults: one through a gap, two among land clutter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from algorithms.plot_tracking.imm_tracker import run
from algorithms.plot_tracking.parameters import ImmParameters
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.metrics.point_sets import set_distance
from backend.files.reading import NamedFile, ReadOptions, read_recording

NEAR_M = 30.0


def estimates_at(result: Result, scan: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers, instants and places (n, 2) of the confirmed tracks at a scan."""
    at = result.arrays["estimate_scan"] == scan
    a = result.arrays
    return a["estimate_track"][at], a["estimate_time_s"][at], a["estimate_state"][at, :2]


@pytest.mark.parametrize("association", ["joint", "nearest"])
def test_a_boat_is_held_from_its_first_scans_to_the_last(shared_data: Path, association: str) -> None:
    folder = shared_data / "radar_joyride"
    if not folder.is_dir():
        pytest.skip("the recordings do not lie beside the checkout")
    plots = NamedFile("joyride_plots.csv", folder / "joyride_plots.csv")
    recording, _ = read_recording([plots], options=ReadOptions(mapping={"time_s": "t_s"}))
    truth = np.genfromtxt(folder / "joyride_truth.csv", delimiter=",", names=True)
    # Accuracies of the data's note: 12 m east, 14 m north.
    result = run(
        recording, ImmParameters(sigma_east_m=12.0, sigma_north_m=14.0, association=association), LocalContext()
    )

    def true_place(time: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(time, truth["t_s"], truth[f"tgt_{a}_m"]) for a in ("east", "north")], axis=-1)

    off = np.hypot(*(np.stack([recording.east_m[:, 0], recording.north_m[:, 0]], 1) - true_place(recording.time_s)).T)
    seen = [bool((off[recording.time_s == t] < 50).any()) for t in result.arrays["scan_time_s"]]
    number, errors = None, []
    for scan in range(len(seen)):
        numbers, time, place = estimates_at(result, scan)
        if number is None and numbers.size and (np.hypot(*(place - true_place(time)).T) < 50).any():
            number = numbers[np.hypot(*(place - true_place(time)).T).argmin()]
            assert scan < 10
        if number is None:
            continue
        assert number in numbers, f"scan {scan}: the track of the boat is gone"
        error = float(np.hypot(*(place - true_place(time)).T)[numbers == number][0])
        errors.append(error)
        if all(seen[max(scan - 3, 0) : scan + 1]):
            assert error < 100, scan
    assert max(errors) < 200
    assert np.sqrt(np.mean(np.square(errors))) < 40


def autoferry(folder: Path) -> dict[str, tuple[PolarPlots, dict[int, np.ndarray]]]:
    """Plots of each scenario, and time, east, north of each target."""
    plots = np.genfromtxt(folder / "plots.csv", delimiter=",", names=True, dtype=None, encoding="utf8")
    truth = np.genfromtxt(folder / "truth.csv", delimiter=",", names=True, dtype=None, encoding="utf8")
    out = {}
    for scenario in np.unique(plots["scenario"]):
        own = plots[plots["scenario"] == scenario]
        own = own[np.argsort(own["t"], kind="stable")]
        start, count = own["t"][0], own.size
        none, unknown = np.full((count, 1), np.nan), np.full(count, -1)
        recording = PolarPlots(
            time_s=own["t"] - start, row=np.arange(1, count + 1), target=np.zeros(count, np.int64), range_m=none,
            azimuth_rad=none, elevation_rad=none, altitude_m=none, east_m=own["east_m"][:, None],
            north_m=own["north_m"][:, None], radar=np.zeros(count, np.int64), radar_east_m=np.full(count, np.nan),
            radar_north_m=np.full(count, np.nan), scan=unknown, address=unknown, callsign=unknown,
        )  # fmt: skip
        paths = {}
        for target in (1, 2):
            path = truth[(truth["scenario"] == scenario) & (truth["target"] == target)]
            path = path[np.argsort(path["t"], kind="stable")]
            paths[target] = np.stack([path["t"] - start, path["east_m"], path["north_m"]])
        out[str(scenario)] = recording, paths
    return out


def followed(result: Result, paths: dict[int, np.ndarray]) -> dict[int, list[tuple[int, int, float]]]:
    """Scan, track and error of each target wherever a track is near it; a track is one target's at a time."""
    out: dict[int, list[tuple[int, int, float]]] = {1: [], 2: []}
    for scan in range(result.arrays["scan_time_s"].size):
        numbers, time, place = estimates_at(result, scan)
        if not numbers.size:
            continue
        d = np.stack([np.hypot(*(place.T - [np.interp(time, p[0], p[1]), np.interp(time, p[0], p[2])]))
                      for p in paths.values()])  # fmt: skip
        d = np.where(d < NEAR_M, d, np.inf)
        # A target keeps its track while that is near; the nearer target has the first choice else.
        held = {t: out[t][-1][1] if out[t] else 0 for t in paths}
        for t in sorted(paths, key=lambda t: (held[t] not in numbers[np.isfinite(d[t - 1])], d[t - 1].min())):
            mine = d[t - 1]
            keep = np.flatnonzero((numbers == held[t]) & np.isfinite(mine))
            i = int(keep[0]) if keep.size else int(mine.argmin())
            if np.isfinite(mine[i]):
                out[t].append((scan, int(numbers[i]), float(mine[i])))
                d[:, i] = np.inf
    return out


def gospa(result: Result, paths: dict[int, np.ndarray]) -> float:
    values = []
    for scan, now in enumerate(result.arrays["scan_time_s"]):
        _, _, place = estimates_at(result, scan)
        true = np.array([[np.interp(now, p[0], p[1]), np.interp(now, p[0], p[2])] for p in paths.values()])
        values.append(set_distance(np.zeros(len(place), np.int64), place, true, 1, cut_m=50.0).gospa_m[0])
    return float(np.mean(values))


def test_two_boats_in_land_clutter(shared_data: Path) -> None:
    folder = shared_data / "radar_autoferry"
    if not folder.is_dir():
        pytest.skip("the recordings do not lie beside the checkout")
    # Two are unseen for long.
    late = {("scenario4", 1): 32, ("scenario6", 1): 46}
    shares = {("scenario6", 1): 0.8, ("scenario3", 1): 0.7}
    changes, false, squares = 0, 0, []
    for scenario, (recording, paths) in autoferry(folder).items():
        given = {"sigma_east_m": 6.6, "sigma_north_m": 6.6, "max_speed_mps": 25.0}
        result = run(recording, ImmParameters(**given), LocalContext())
        nearest = run(recording, ImmParameters(**given, association="nearest"), LocalContext())
        print(f"{scenario}: GOSPA joint {gospa(result, paths):.1f} m, nearest {gospa(nearest, paths):.1f} m")
        scans = result.arrays["scan_time_s"].size
        own: set[int] = set()
        ids: dict[int, list[int]] = {}
        for target, found in followed(result, paths).items():
            key = (scenario, target)
            begin = found[0][0]
            assert begin <= late.get(key, 10), key
            assert len(found) / (scans - begin) >= shares.get(key, 0.9), key
            assert found[-1][0] >= scans - 3, key
            numbers = [n for _, n, _ in found]
            ids[target] = [n for i, n in enumerate(numbers) if i == 0 or n != numbers[i - 1]]
            changes += len(ids[target]) - 1
            squares += [e**2 for _, _, e in found]
            own |= set(numbers)
        assert not set(ids[1]) & set(ids[2]), "ids were exchanged"
        false += len(set(result.arrays["estimate_track"].tolist()) - own)
    print(f"changes {changes}, false {false}, rms {np.sqrt(np.mean(squares)):.2f} m")
    assert changes <= 6
    assert false <= 75
    assert np.sqrt(np.mean(squares)) <= 12.5
