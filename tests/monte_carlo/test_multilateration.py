"""Monte Carlo tables of the multilateration specification.

Bands: the printed 95 % interval and ours add up in variance; three standard deviations of the difference (false alarm
below 0.003 per number with both intervals as wide as printed; the seed is fixed, so a test that passes stays green).
"""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multilateration.parameters import FilterWithAltitudeParameters, Start
from algorithms.multilateration.scenario import (
    CircuitParameters,
    IncompleteParameters,
    simulate,
)
from algorithms.multilateration.tracker import run_filter
from algorithms.spec import LocalContext

LEGS = {
    "inbound": (50, 400),
    "weave": (400, 520),
    "turn": (560, 680),
    "orbit": (720, 960),
    "out_near": (960, 1200),
    "out_far": (1200, 1900),
}
# Specification 8.1: rms radial error with its 95 % half width, and the claimed DRMS.
TABLE = {
    None: ((318.7, 7.1, 329), (96.4, 2.2, 75), (16.4, 0.4, 14), (123.6, 1.4, 55), (148.9, 3.2, 153), (753, 15, 841)),
    100.0: ((171.4, 3.7, 180), (73.9, 1.4, 53), (15.8, 0.4, 14), (115.5, 1.2, 51), (145.8, 3.1, 151), (575, 11, 634)),
    10.0: ((163.6, 3.6, 173), (55.3, 0.9, 36), (9.65, 0.13, 8.1), (74.1, 0.9, 34), (136.8, 3.1, 147), (572, 11, 631)),
}
TRIALS = 100
START = Start(mode="truth", sd=(500, 50, 1))


def errors(recording, parameters, altitude):
    arrays = run_filter(recording, parameters, LocalContext(5), altitude=altitude).arrays
    e = np.hypot(*(arrays["state"][:, i] - recording.truth_m[:, j, None] for i, j in ((0, 0), (3, 1))))
    claimed = np.sqrt(arrays["covariance"][:, 0, 0] + arrays["covariance"][:, 3, 3])
    return e, claimed, arrays


@pytest.mark.slow
@pytest.mark.parametrize("sigma", list(TABLE))
def test_circuit_table_8_1(sigma) -> None:
    recording = simulate(CircuitParameters(sigma_altitude_m=sigma or 100.0), tuple(range(TRIALS)), 42)
    parameters = FilterWithAltitudeParameters(profile="article", start=START)
    e, claimed, arrays = errors(recording, parameters, sigma is not None)
    for (leg, (a, b)), (rms, half, claim) in zip(LEGS.items(), TABLE[sigma], strict=True):
        got = float(np.sqrt((e[a:b] ** 2).mean()))
        # Ours has TRIALS where the specification's had 300.
        sd = half / 1.96 * np.sqrt(1 + 300 / TRIALS)
        assert got == pytest.approx(rms, abs=3 * sd), leg
        assert float(np.sqrt((claimed[a:b] ** 2).mean())) == pytest.approx(claim, abs=0.03 * claim + 0.5), leg
    ratio = arrays["nis"][50:400].sum() / arrays["dof"][50:400].sum()
    assert ratio == pytest.approx(0.97, abs=0.03), "mean NIS per degree of freedom on the straight leg"


@pytest.mark.slow
@pytest.mark.parametrize(("altitude", "medians", "over"), [(False, (12, 443, 1855), 0.71), (True, (11, 73, 86), 0.0)])
def test_incomplete_marks_table_8_2(altitude: bool, medians: tuple[float, ...], over: float) -> None:
    recording = simulate(IncompleteParameters(), tuple(range(200)), 42)
    parameters = FilterWithAltitudeParameters(profile="article", start=START)
    e, _, _ = errors(recording, parameters, altitude)
    t = recording.time_s
    for (low, high), median in zip(((0, 400), (400, 700), (700, 1000)), medians, strict=True):
        got = float(np.median(e[(t >= low) & (t < high)]))
        # The specification's own intervals for the diverging RDF: [386, 521] and [1162, 3058].
        band = {443: (350, 560), 1855: (800, 3800)}.get(median, (0.85 * median - 0.5, 1.15 * median + 0.5))
        assert band[0] <= got <= band[1]
    share = float((np.nan_to_num(e) > 5_000).any(axis=0).mean())
    assert share == pytest.approx(over, abs=0.12 if over else 0.0)


@pytest.mark.slow
def test_the_robust_profile_costs_nothing_and_survives_outliers() -> None:
    """Clean marks: as accurate as the article's filter. 3 % of receptions late: rule 6.4(b) holds the error."""
    recording = simulate(CircuitParameters(sigma_altitude_m=100.0), tuple(range(48)), 42)
    robust = FilterWithAltitudeParameters(start=START)
    article = FilterWithAltitudeParameters(profile="article", start=START)
    e_robust, _, arrays = errors(recording, robust, True)
    e_article, _, _ = errors(recording, article, True)
    assert np.isfinite(e_robust).all(), "no track is lost in the weave, where plain gating loses every one"
    assert (arrays["track"] == 1).all()
    for leg, (a, b) in LEGS.items():
        ratio = np.sqrt((e_robust[a:b] ** 2).mean() / (e_article[a:b] ** 2).mean())
        assert ratio == pytest.approx(1.0, abs=0.05), leg
    rng = np.random.default_rng(9)
    toa = recording.toa_s + np.where(
        rng.random(recording.toa_s.shape) < 0.03, rng.uniform(0.2e-6, 20e-6, recording.toa_s.shape), 0
    )
    from dataclasses import replace

    e_late, _, _ = errors(replace(recording, toa_s=toa), robust, True)
    e_plain, _, _ = errors(replace(recording, toa_s=toa), article, True)
    near, far = slice(960, 1200), slice(1200, 1900)
    assert np.sqrt(np.nanmean(e_late[near] ** 2)) < 250, "specification: 146 m against 136 clean"
    assert np.sqrt(np.nanmean(e_late[far] ** 2)) < 1_000, "specification: 611 m against 580 clean"
    assert np.sqrt(np.nanmean(e_plain[far] ** 2)) > 10 * np.sqrt(np.nanmean(e_late[far] ** 2))
