"""Stronger filters on the paper's track, row by row against the reference (specification 8.3).

The settings are the reference's: the article's filter (EKF) with the noise of (6), two interacting models with those of
6.2, and the smoothed article's filter (RTS); all start around the truth. Its numbers come of 100 trials, so five in a
hundred of them are more than 6 % off by chance alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from algorithms.multilateration.paper import ARTICLE, PAPER
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict, Word

LEGS = ("inbound", "weave", "orbit", "out_near", "out_far")
# Specification 8.6.
TOLERANCE = 0.08
SMOOTHED = ARTICLE | {"smoothing": "fixed_interval"}


class Row(NamedTuple):
    """A row of the table: its claim, whose estimate it is, and what the reference has, m."""

    claim: Claim
    label: str
    sigma_altitude_m: float
    expected_m: tuple[float, ...]


def _row(says: str, label: str, sigma_altitude_m: float, *expected_m: float) -> Row:
    return Row(Claim("8.3", says, ", ".join(f"{e:g}" for e in expected_m) + " m"), label, sigma_altitude_m, expected_m)


ROWS = (
    _row("one model, no altitude", "RDF", 100, 312, 97, 122, 152, 760),
    _row("two models, no altitude", "RDF IMM", 100, 223, 81, 68, 70, 364),
    _row("one model, smoothed, no altitude", "RDF RTS", 100, 124, 54, 25, 64, 390),
    _row("one model, altitude of 100 m", "RDFV", 100, 166, 74, 114, 149, 579),
    _row("two models, altitude of 100 m", "RDFV IMM", 100, 107, 59, 63, 68, 278),
    _row("one model, smoothed, altitude of 100 m", "RDFV RTS", 100, 62, 45, 24, 62, 286),
    _row("two models, altitude of 10 m", "RDFV IMM", 10, 101, 39, 43, 56, 225),
)


def _judge(run: StudyRun) -> Sequence[Verdict]:
    verdicts = []
    for row in ROWS:
        found = [run.metric("rms_horizontal_m", row.label, leg, sigma_altitude_m=row.sigma_altitude_m) for leg in LEGS]
        ratios = [f.value / e for f, e in zip(found, row.expected_m, strict=True)]
        worst = max(range(len(LEGS)), key=lambda i: abs(ratios[i] - 1))
        off = abs(ratios[worst] - 1)
        word: Word = "reproduced" if off <= TOLERANCE else "partly" if off <= 2 * TOLERANCE else "not"
        inbound, weave, orbit, near, far = (f.value for f in found)
        expected = row.expected_m[worst]
        verdicts.append(
            Verdict(
                row.claim, ratios[worst], "times", word,
                f"Here {inbound:.0f}, {weave:.0f}, {orbit:.0f}, {near:.0f}, {far:.0f} m (inbound, weave, orbit, out "
                f"near, out far); the largest difference is {off * 100:.0f} %.",
                found[worst].low / expected, found[worst].high / expected,
            )
        )  # fmt: skip
    return tuple(verdicts)


STRONGER = Study(
    name="multilateration_stronger_filters",
    title="Stronger filters on the paper's track",
    summary="One model, two interacting ones and one smoothed afterwards, without an altitude and with one of 100 m or "
    "10 m: the error of each leg beside that of the reference.",
    family="multilateration",
    paper=Reference(PAPER, "conclusion"),
    item="table 8.3 of the reference",
    scenario="four_station_circuit",
    entries=(
        StudyEntry("rdf", "RDF", ARTICLE),
        StudyEntry("mlat_imm", "RDF IMM", {"start": ARTICLE["start"], "altitude": "none"}),
        StudyEntry("rdf", "RDF RTS", SMOOTHED),
        StudyEntry("rdfv", "RDFV", ARTICLE),
        StudyEntry("mlat_imm", "RDFV IMM", {"start": ARTICLE["start"], "altitude": "white"}),
        StudyEntry("rdfv", "RDFV RTS", SMOOTHED),
    ),
    sweep={"scenario.sigma_altitude_m": (100, 10)},
    claims=tuple(row.claim for row in ROWS),
    judge=_judge,
    trials=480,
    seed=500,
)

STUDIES = (STRONGER,)
