"""Figures and claims of the multilateration paper, each as a run that anybody can repeat (specification 8.6)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from algorithms.spec import Reference
from algorithms.studies import Claim, Found, Study, StudyEntry, StudyRun, Verdict, Word

PAPER = "chugunov2023"
# Specification 7.1: P0 = diag(500^2, 50^2, 1) for each axis, drawn around the truth.
ARTICLE = {"profile": "article", "start": {"mode": "truth", "sd": [500, 50, 1]}}

SIGMAS_M = (10, 30, 100, 300, 1000, 3000)
_GAIN = Claim("3", "the altitude raises the accuracy in the plan, most where the geometry is good", "1.5 to 2.5 times")
_COARSE = Claim("3", "an altitude error of hundreds to thousands of metres brings no substantial gain", "no gain")
_START = Claim("3", "the difference is small at the start, because the filters settle", "small, then full")
_HONEST = Claim("(27)", "the filter's own DRMS is its error in the plan", "claimed = actual")


def _judge_figure_3(run: StudyRun) -> Sequence[Verdict]:
    metric = "rms_horizontal_m"

    def gain(sigma_m: float, leg: str) -> Found:
        return run.ratio(metric, "rdf", "rdfv", leg, sigma_altitude_m=sigma_m)

    inbound, far = gain(10, "inbound"), gain(10, "out_far")
    holds = 1.5 <= inbound.value <= 2.5 and far.value < inbound.value
    first = Verdict(
        _GAIN,
        inbound.value,
        "times",
        "reproduced" if holds else "not",
        f"With 10 m the error of the inbound leg is {inbound.value:.2f} times smaller, of the outbound one "
        f"{far.value:.2f} times.",
        inbound.low,
        inbound.high,
    )
    coarse, useless = gain(300, "inbound"), gain(3000, "inbound")
    word: Word = "reproduced" if coarse.high < 1.1 else "partly" if useless.value < 1.15 else "not"
    second = Verdict(
        _COARSE,
        coarse.value,
        "times",
        word,
        f"300 m still bring {coarse.value:.2f} times on the inbound leg, because white altitude noise is averaged; "
        f"3000 m bring {useless.value:.2f} times.",
        coarse.low,
        coarse.high,
    )
    time, rdf = run.curve("bound_horizontal_m", "rdf", sigma_altitude_m=10)
    _, rdfv = run.curve("bound_horizontal_m", "rdfv", sigma_altitude_m=10)
    settled = int(np.searchsorted(time, 50.0))
    at_start, later = float(rdf[0] / rdfv[0]), float(rdf[settled] / rdfv[settled])
    third = Verdict(
        _START,
        at_start,
        "times",
        "reproduced" if at_start < 1.1 and later > 1.5 else "not",
        f"The DRMS that the model allows differs {at_start:.2f} times at the first mark, {later:.2f} times after 50 s.",
    )
    straight = run.metric("actual_over_claimed", "rdfv", "inbound", sigma_altitude_m=100)
    turning = run.metric("actual_over_claimed", "rdfv", "orbit", sigma_altitude_m=100)
    fourth = Verdict(
        _HONEST,
        turning.value,
        "times",
        "partly" if straight.value < 1.1 < turning.value else "reproduced" if turning.value <= 1.1 else "not",
        f"Actual over claimed is {straight.value:.2f} on the straight leg, {turning.value:.2f} in the orbit (100 m).",
        turning.low,
        turning.high,
    )
    return first, second, third, fourth


FIGURE_3 = Study(
    name="multilateration_figure_3",
    title="Accuracy with and without the flight altitude",
    summary="Range-difference filter without altitude (RDF) and with it (RDFV) along the reconstructed track, altitude "
    "errors from 10 m to 3 km: error in the plan by leg, gain, and how honest the filter's own claim is.",
    family="multilateration",
    paper=Reference(PAPER, "fig. 3"),
    item="figure 3",
    scenario="four_station_circuit",
    entries=(StudyEntry("rdf", "rdf", ARTICLE), StudyEntry("rdfv", "rdfv", ARTICLE)),
    sweep={"scenario.sigma_altitude_m": SIGMAS_M},
    claims=(_GAIN, _COARSE, _START, _HONEST),
    judge=_judge_figure_3,
    seed=42,
)

STUDIES = (FIGURE_3,)
