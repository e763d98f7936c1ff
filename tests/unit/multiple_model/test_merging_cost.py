"""Operations of merging by rule, and the textbook's filter beside ours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multiple_model import mma2_122
from algorithms.multiple_model.merging_cost import merging_operations
from algorithms.multiple_model.parameters import PaperParameters
from algorithms.multiple_model.scenario import AeroballisticParameters, simulate
from algorithms.multiple_model.textbook import largest_difference_m
from algorithms.multiple_model.tracker import run_bank
from algorithms.recording import AntennaPlots
from algorithms.spec import LocalContext

THREE = mma2_122.models_of(mma2_122.Mma2Parameters())


@pytest.fixture(scope="module")
def arc() -> AntennaPlots:
    return simulate(AeroballisticParameters(rate_hz=1.0), tuple(range(48)), 3)


@pytest.mark.parametrize(("rule", "operations"), [("moment", 1782), ("combined", 600), ("modified", 388), ("max", 0)])
def test_expected_operations_are_the_specification_s(arc: AntennaPlots, rule: str, operations: float) -> None:
    """Section 7, scenario A at 1 Hz. The standard error of 48 trials is some 5 operations."""
    chosen = replace(THREE, merging=rule)
    report = run_bank(arc, PaperParameters(), chosen, LocalContext(), lean=True).report
    found = merging_operations(arc, chosen, report.probability)
    assert found is not None
    assert np.isnan(found[0]).all()
    assert np.nanmean(found) == pytest.approx(operations, abs=25)


def test_one_mark_by_hand(arc: AntennaPlots) -> None:
    """P(1 s) diag(p) of specification 18.4: rows of 3, 2 and 3 hypotheses of which combined merges the last alone."""
    two = replace(arc, time_s=np.array([0.0, 1.0]), **{
        name: getattr(arc, name)[:2] for name in ("row", "target", "truth_m", "truth_velocity_mps", "range_m",
                                                  "bicone_elevation_rad", "bicone_azimuth_rad")
    })  # fmt: skip
    p = np.tile(np.array([0.90, 0.07, 0.03])[None, :, None], (2, 1, 1))
    for rule, operations in (("moment", 3 * 594), ("combined", 594), ("modified", 378), ("max", 0)):
        found = merging_operations(two, replace(THREE, merging=rule), p)
        assert found is not None
        assert found[1, 0] == operations, rule
    assert merging_operations(two, replace(THREE, structure="gpb2"), p) is None


def test_the_textbook_s_filter_is_ours() -> None:
    assert 0 < largest_difference_m() < 1e-6
