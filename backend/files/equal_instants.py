"""Rows of Doppler frequencies at one instant become one row: an epoch is what all receivers measured then.

Rows that complete each other, such as those of the files of two receivers, are joined. Where two rows hold the same
Doppler, the second is rejected, or all are averaged where the user asks for it. A row that is put into another is
listed like one that repeats another: it is no row of the recording any more.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from algorithms.recording import DopplerPairs, Floats
from backend.files.merging import RowFiles, kept_rows
from backend.files.reader import Part
from backend.files.report import Findings


def one_row_an_instant(part: Part, files: RowFiles, equal_times: str, findings: Findings) -> Part:
    """Join the rows (sorted by time) of one instant and target; `equal_times` is `reject` or `average`."""
    recording = part.recording
    if not isinstance(recording, DopplerPairs):
        return part
    doppler, rate = recording.doppler_hz.copy(), recording.doppler_rate_hz_s.copy()
    azimuth, elevation = recording.azimuth_rad.copy(), recording.elevation_rad.copy()
    keep = np.ones(len(recording), bool)
    averaged = 0
    for first, *others in _instants(recording):
        together = [first]
        known = np.isfinite(doppler[first, :, 0])
        row = int(recording.row[first])
        for position in others:
            there = np.isfinite(doppler[position, :, 0])
            number = int(recording.row[position])
            keep[position] = False
            file = files.name(number)
            if not (known & there).any():
                findings.reject(
                    number,
                    "joined_row",
                    f"measured at the instant of row {row}, what that one lacks: joined to it",
                    file=file,
                )
            elif equal_times == "average":
                findings.reject(
                    number, "averaged_row", f"measured at the instant of row {row}: averaged with it", file=file
                )
                averaged += 1
            else:
                findings.reject(
                    number, "second_doppler", "another row of the same instant has other Dopplers", file=file
                )
                continue
            together.append(position)
            known |= there
        for values in (doppler, rate, elevation):
            values[first] = _mean(values[together])
        directions = azimuth[together]
        if np.isfinite(directions).sum() > 1:
            azimuth[first] = np.angle(np.nanmean(np.exp(1j * directions))) % (2 * np.pi)
        else:
            azimuth[first] = _mean(directions)
    if averaged:
        text = (
            "Dopplers that were measured again at the same instant were averaged; such a mean has less noise than told."
        )
        findings.warn("dopplers_averaged", text, averaged)
    if keep.all():
        return part
    joined = replace(
        recording, doppler_hz=doppler, doppler_rate_hz_s=rate, azimuth_rad=azimuth, elevation_rad=elevation
    )
    return kept_rows(replace(part, recording=joined), keep)


def _instants(recording: DopplerPairs) -> Iterator[list[int]]:
    """Positions of the rows of each instant and target that has several."""
    same = np.diff(recording.time_s, prepend=-np.inf, append=np.inf) == 0
    groups: dict[tuple[float, int], list[int]] = {}
    for position in np.flatnonzero(same[:-1] | same[1:]).tolist():
        groups.setdefault((float(recording.time_s[position]), int(recording.target[position])), []).append(position)
    return (group for group in groups.values() if len(group) > 1)


def _mean(values: Floats) -> Floats:
    """Mean over the rows of what is there; one value alone stays as it is, to the last bit."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    total = np.where(known, values, 0).sum(axis=0)
    mean: Floats = np.where(count > 1, total / np.maximum(count, 1), np.where(count == 1, total, np.nan))
    return mean
