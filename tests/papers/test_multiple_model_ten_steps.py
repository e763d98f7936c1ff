"""Ten steps with irregular times (specification 18.8), relative 1e-6, through the filter as a recording takes it."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multiple_model import mma2_11, mma2_122
from algorithms.multiple_model.parameters import PaperParameters
from algorithms.multiple_model.scenario import AntennaScenario, site_of
from algorithms.multiple_model.tracker import ModelSet, run_bank
from algorithms.recording import AntennaPlots
from algorithms.spec import LocalContext

# Time s, range m, bicone elevation and azimuth in degrees.
MARKS = np.array(
    [
        (0, 155821.6, -17.1312, 9.2075), (0.05, 155737.9, -16.8860, 9.2485), (0.10, 155648.8, -17.0790, 9.3176),
        (0.15, 155567.5, -16.9742, 9.1246), (1.15, 153825.3, -16.8620, 9.3735), (2.15, 152086.1, -17.0549, 9.3447),
        (3.15, 150350.1, -17.1240, 9.5001), (4.65, 147744.9, -17.1278, 9.6831), (6.15, 145157.4, -17.0513, 9.7531),
        (7.15, 143445.2, -17.2166, 10.0195), (8.15, 141743.6, -17.0806, 10.1547),
    ]
)  # fmt: skip
# Of each: structure, rule, probabilities, state of the most probable model in north, up, east.
LAST = {
    ("imm", "moment"): (
        (0.071971935, 0.50489717, 0.42313089),
        (136179.719, -1688.39095, 4.27836458, 30399.4395, -415.430515, 8.90321573, 24942.5504, 83.2282198, 21.7183005),
    ),
    ("imm", "max"): (
        (0.063971627, 0.048814059, 0.88721431),
        (136193.494, -1679.53746, 4.98839405, 30393.0755, -418.266059, 12.0080481, 24876.8477, 40.0921693, 18.384124),
    ),
    ("imm", "combined"): (
        (0.062290328, 0.04854891, 0.88916076),
        (136187.704, -1684.44617, 3.93616752, 30402.8908, -409.97713, 13.4210989, 24896.4539, 56.382018, 21.2843539),
    ),
    ("imm", "modified"): (
        (0.062202924, 0.048496598, 0.88930048),
        (136187.942, -1684.26211, 3.97024658, 30402.704, -410.093945, 13.4165075, 24895.3798, 55.5415606, 21.1613388),
    ),
    ("gpb2", "moment"): (
        (0.093161932, 0.17908728, 0.72775078),
        (136190.21, -1682.3913, 4.36954166, 30398.2679, -413.721994, 12.7705725, 24888.4401, 50.0436991, 20.1549582),
    ),
    ("gpb2", "combined"): (
        (0.0940266, 0.16640816, 0.73956524),
        (136190.244, -1682.41262, 4.32209948, 30398.3097, -413.703564, 12.8269897, 24888.1994, 49.9927453, 20.2589038),
    ),
    ("gpb1", "moment"): (
        (0.44637362, 0.32604349, 0.22758288),
        (136193.99, -1678.68993, 0, 30390.9163, -432.623727, 0, 24874.2043, 18.3397601, 0),
    ),
}  # fmt: skip
NUE = [3, 4, 5, 6, 7, 8, 0, 1, 2]


@pytest.fixture(scope="module")
def recording() -> AntennaPlots:
    count = len(MARKS)
    return AntennaPlots(
        time_s=MARKS[:, 0], row=np.arange(1, count + 1), target=np.zeros(count, np.int64),
        truth_m=np.full((count, 3), np.nan), site=site_of(AntennaScenario()), range_m=MARKS[:, 1:2],
        bicone_elevation_rad=np.radians(MARKS[:, 2:3]), bicone_azimuth_rad=np.radians(MARKS[:, 3:4]),
    )  # fmt: skip


def last(recording: AntennaPlots, chosen: ModelSet) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Probabilities, state and standard deviations after the last mark; north, up, east."""
    report = run_bank(recording, PaperParameters(), chosen, LocalContext(), lean=False).report
    diagonal = [i * (i + 1) // 2 + i for i in NUE]
    return report.probability[-1, :, 0], report.state[-1, NUE, 0], np.sqrt(report.covariance[-1, diagonal, 0])


@pytest.mark.parametrize(("structure", "rule"), list(LAST))
def test_three_models(recording: AntennaPlots, structure: str, rule: str) -> None:
    probability, state = LAST[structure, rule]
    chosen = ModelSet(mma2_122.MODELS, mma2_122.TRANSITION, 0.05, structure, rule, "max")
    p, x, _ = last(recording, chosen)
    np.testing.assert_allclose(p, probability, rtol=1e-6)
    np.testing.assert_allclose(x, state, rtol=1e-6, atol=1e-9)


def test_two_models_are_the_quiet_filter_alone(recording: AntennaPlots) -> None:
    """6.6 (h): under the combined rule a model whose own hypothesis always wins is exactly its single filter."""
    chosen = mma2_11.models_of(mma2_11.Mma211Parameters())
    p, x, _ = last(recording, chosen)
    np.testing.assert_allclose(p, (0.52489001, 0.47510999), rtol=1e-6)
    wanted = (136197.062, -1673.6545, 0, 30378.7542, -442.365686, 0, 24864.6072, 0.639363085, 0)
    np.testing.assert_allclose(x, wanted, rtol=1e-6, atol=1e-9)
    _, alone, _ = last(recording, ModelSet((("cv", 5.0),)))
    np.testing.assert_allclose(x, alone, rtol=0, atol=1e-7)


def test_one_model(recording: AntennaPlots) -> None:
    p, x, _ = last(recording, ModelSet((("ca", 20.0),)))
    assert p.tolist() == [1.0]
    wanted = (136173.681, -1695.49364, 1.69760826, 30420.1417, -396.848689, 13.7747374, 24952.0694, 98.7696798,
              26.5393639)  # fmt: skip
    np.testing.assert_allclose(x, wanted, rtol=1e-6)


@pytest.mark.parametrize(
    ("rule", "state", "sd"),
    [
        (
            "combined",
            (136187.6, -1684.5378, 3.61210352, 30403.3607, -411.391783, 12.4988426, 24895.557, 54.3240345, 19.9170684),
            (173.86493, 106.57423, 46.612819),
        ),
        (
            "moment",
            (136182.386, -1687.41323, 3.6109635, 30402.7022, -412.604233, 10.3202454, 24924.5305, 72.1558305,
             20.5350656),
            (178.8999, 101.62821, 35.816029),
        ),
    ],
)  # fmt: skip
def test_the_mean_of_all_models(recording: AntennaPlots, rule: str, state: tuple, sd: tuple) -> None:
    _, x, s = last(recording, ModelSet(mma2_122.MODELS, mma2_122.TRANSITION, 0.05, "imm", rule, "moment"))
    np.testing.assert_allclose(x, state, rtol=1e-6)
    np.testing.assert_allclose(s[3:6], sd, rtol=1e-6)
