"""Studies of the multilateration paper through the pipeline that users run: the verdict of every claim."""

from __future__ import annotations

import pytest

from algorithms.multilateration.paper_printed import _judge_shared, _judge_units
from tests.study_claims import claims_of


def test_the_printed_sign_is_positive_feedback() -> None:
    """Erratum E1: 327 km after ten marks, from 152 m."""
    found = claims_of("multilateration_printed_sign", 8)
    assert found["(19): not"]["value"] > 1e5


@pytest.mark.slow
def test_the_printed_gradient_and_what_formulas_decide() -> None:
    found = claims_of("multilateration_printed_gradient", 16)
    assert found["(26): not"]["value"] > 20e3
    # Table 8.5: 593 and 1223 m.
    assert found["2: shown"]["value"] == pytest.approx(1223 / 593, rel=2e-3)
    assert found["text: not"]["ci95_low"] == pytest.approx(0.6321, abs=5e-5)
    assert found["text: not"]["ci95_high"] == pytest.approx(0.6827, abs=5e-5)


@pytest.mark.slow
def test_the_printed_variance_takes_the_altitude_for_thirty_times_better_than_it_is() -> None:
    """Erratum E3: six times the claim in the turn near the stations, where the right variance has 1.2."""
    found = claims_of("multilateration_printed_variance", 16)
    assert 4 < found["(13): not"]["value"] < 10
    # E5: a pseudo-inverse of seconds and metres drops the whole correction; T2: without what the differences share the
    # claim against the last station is too small.
    assert found["(8), (13), (17): shown"]["value"] == pytest.approx(146, abs=0.5)
    assert found["(13): shown"]["value"] == pytest.approx(761 / 657, rel=2e-3)


def test_what_a_formula_decides_about_the_covariance() -> None:
    units, shared = _judge_units(), _judge_shared()
    assert "10^21" in units.reason
    assert "0.000 m off" in units.reason
    assert "146 m of a correction of 146 m" in units.reason
    # Table 8.5: 620 m at 100 km on azimuth 90 with an altitude of 100 m, whatever the differences are taken against.
    assert "761 m against the last station, 749 m and 620 m against the first; with it 620 m" in shared.reason


@pytest.mark.slow
def test_figures_4_to_7() -> None:
    """Table 8.2: 0.71 of the runs beyond 5 km against none, medians 9 to 24 times smaller."""
    found = claims_of("multilateration_figures_4_to_7", 200)
    assert set(found) == {"4: partly", "5: shown", "6: reproduced", "7: reproduced", "conclusion: reproduced"}
    assert found["5: shown"]["value"] <= 0.4
    assert found["conclusion: reproduced"]["value"] == pytest.approx(0.71, abs=0.15)
    assert 9 <= found["7: reproduced"]["value"] <= 24


@pytest.mark.slow
def test_a_biased_altitude() -> None:
    """Table 8.4: the weave with 10 m and a bias of 300 m is four times worse than without altitude."""
    found = claims_of("multilateration_altitude_bias", 48)
    assert set(found) == {"conclusion: reproduced", "(13): partly", "(13): shown"}
    assert found["(13): partly"]["value"] == pytest.approx(95 / 380, rel=0.25)
    assert found["(13): shown"]["value"] > 1.5


@pytest.mark.slow
def test_stronger_filters() -> None:
    """Table 8.3: every leg of every row within 8 %."""
    assert set(claims_of("multilateration_stronger_filters", 480)) == {"8.3: reproduced"}
