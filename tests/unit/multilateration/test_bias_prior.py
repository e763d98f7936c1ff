"""The altitude's bias before any data, a mixture of two normals: what is shown against numerical quadrature."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multilateration.bank import new_bank, straight_noise
from algorithms.multilateration.bias_prior import weigh_biases
from algorithms.toolbox.kernels import LANES

SIGMA = 100.0


def shown(bias: float, sd: float, tilt: float) -> tuple[float, float, float, float]:
    """Bias, its sd, x and its sd, of a filter with (bias, sd) and a normal prior; x leans on the bias by `tilt`."""
    bank = new_bank(4)
    bank.on[:] = 1
    bank.x[:, 9], bank.p[:, 54] = bias, sd**2
    bank.p[:, 45] = tilt * sd**2
    x, p = np.zeros((9, LANES)), np.zeros((45, LANES))
    p[0] = (tilt * sd) ** 2 + 25.0
    bank.bias[0], bank.bias[1] = bias, sd**2
    weigh_biases(SIGMA**2, bank, x, p)
    return bank.bias[0, 0], float(np.sqrt(bank.bias[1, 0])), x[0, 0], float(np.sqrt(p[0, 0]))


@pytest.mark.parametrize(("bias", "sd"), [(0.0, 100.0), (5.0, 99.0), (40.0, 70.0), (150.0, 40.0), (-260.0, 30.0)])
def test_what_is_shown_is_the_mixture(bias: float, sd: float) -> None:
    b = np.linspace(-3000, 3000, 60_001)

    def normal(variance: float) -> np.ndarray:
        return np.exp(-(b**2) / (2 * variance)) / np.sqrt(variance)

    # What the data alone say: the filter's normal without its prior.
    logs = -((b - bias) ** 2) / (2 * sd**2) + b**2 / (2 * SIGMA**2)
    weight = np.exp(logs + np.log(6 / 7 * normal(SIGMA**2 / 2) + 1 / 7 * normal(4 * SIGMA**2)))
    weight /= weight.sum()
    mean = float(weight @ b)
    spread = float(np.sqrt(weight @ (b - mean) ** 2))
    found = shown(bias, sd, tilt=2.0)
    assert found[0] == pytest.approx(mean, abs=1e-6)
    assert found[1] == pytest.approx(spread, rel=1e-9)
    # x = 2 (b - bias) + 5 m of its own.
    assert found[2] == pytest.approx(2 * (mean - bias), abs=1e-6)
    assert found[3] == pytest.approx(np.hypot(2 * spread, 5), rel=1e-9)


def test_the_mixture_is_as_wide_as_the_parameter_says() -> None:
    assert shown(0.0, SIGMA, 0.0)[1] == pytest.approx(SIGMA, rel=1e-12)


def test_straight_flight_spreads_with_the_time() -> None:
    """Its velocity as if disturbed once a second below that, and like the manoeuvre's above."""
    q = straight_noise(np.array([0.0, 0.1, 0.5, 1.0, 4.0]), 0.05)[:, 1, 1]
    assert q == pytest.approx(0.05**2 * np.array([0.0, 0.1, 0.5, 1.0, 4.0**3]))
