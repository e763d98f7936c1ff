"""From a radar's range and azimuth to a point in the plane with the covariance of its error, in all known ways.

A measurement is r, b: range in m, and azimuth in rad **counter-clockwise from the x axis** (east), so that
x = r cos b, y = r sin b; `angle_from_compass` turns an azimuth clockwise from north into it. Errors are independent and
Gaussian with standard deviations sigma_r and sigma_b; v = sigma_b^2, q = sigma_r^2.

All conversions scale the raw point, z = k r (cos b, sin b), and differ in k and in the covariance. Two kinds of
"unbiased" must not be mixed. *Given the truth* p, the raw point lies short on average, E[raw] = e^(-v/2) p, which
k = e^(v/2) makes good. *Given the measurement* (nothing known before about range and azimuth) the target itself lies
short of the raw point on average, E[p] = e^(-v/2) raw: k = e^(-v/2). The second question is the one that a gate, an
assignment and a fusion of single plots ask; `mucm` answers it exactly and is the default.

How much a conversion matters depends on kappa = r sigma_b^2 / sigma_r (`nonlinearity_index`): below 0.4 even the linear
one is acceptable.

References
----------
prosov2008, eqs. (1)-(4); lerro1993; longbin1998; bordonaro2014.

Differences from the paper
--------------------------
`paper` has the factor e^v where eq. (4c) prints e^(-v): with the printed sign the ellipse lies along the line of sight
instead of across it (`paper_literal`, kept to show that). The paper joins the mean given the measurement with the
covariance given the truth, so its ellipse is up to a third too large; `mucm` takes both given the measurement.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from algorithms.errors import ParameterError

Floats = NDArray[np.float64]
ConversionName = Literal["lin", "paper", "paper_literal", "dcm", "ucm", "mucm", "ducm"]


@dataclass(frozen=True)
class Meaning:
    """What a conversion says about the point it gives.

    Attributes
    ----------
    mean, covariance : what mean and covariance are conditioned on: "truth", "measurement", "prediction", or "none"
        where they are a first-order expansion that holds for neither
    """

    summary: str
    mean: str
    covariance: str


CONVERSIONS: Mapping[ConversionName, Meaning] = {
    "lin": Meaning("plain point, covariance of first order", "none", "none"),
    "paper": Meaning("mean given the measurement to second order, debiased covariance", "measurement", "truth"),
    "paper_literal": Meaning("as paper with the misprinted sign of eq. (4c)", "measurement", "none"),
    "dcm": Meaning("debiased: bias and covariance given the truth, averaged over it", "truth", "truth"),
    "ucm": Meaning("unbiased given the truth, second moment given the measurement", "truth", "measurement"),
    "mucm": Meaning("exact mean and covariance given the measurement", "measurement", "measurement"),
    "ducm": Meaning("unbiased given the truth, covariance given an independent prediction", "truth", "prediction"),
}


class Prediction(NamedTuple):
    """Range and azimuth of a target from a source that does not contain the measurement, with their variances."""

    range_m: ArrayLike
    azimuth_rad: ArrayLike
    range_variance_m2: ArrayLike
    azimuth_variance_rad2: ArrayLike


class Converted(NamedTuple):
    """Points (..., 2) in m relative to the radar, and the covariances (..., 2, 2) of their errors in m2."""

    point: Floats
    covariance: Floats


def angle_from_compass(azimuth_rad: ArrayLike) -> Floats:
    """Turn azimuths clockwise from north into angles counter-clockwise from east within (-pi, pi], or back."""
    turned: Floats = np.pi / 2 - np.asarray(azimuth_rad, float)
    return wrapped(turned)


def wrapped(angle_rad: ArrayLike) -> Floats:
    """Turn angles into (-pi, pi]."""
    angle = np.asarray(angle_rad, float)
    within: Floats = np.pi - np.mod(np.pi - angle, 2 * np.pi)
    return within


def nonlinearity_index(range_m: ArrayLike, sigma_range_m: ArrayLike, sigma_azimuth_rad: ArrayLike) -> Floats:
    """Return kappa = r sigma_b^2 / sigma_r: the sagitta of the error arc over the range error."""
    index: Floats = np.asarray(range_m, float) * np.square(sigma_azimuth_rad) / np.asarray(sigma_range_m, float)
    return index


def cartesian_from_polar(
    range_m: ArrayLike,
    azimuth_rad: ArrayLike,
    sigma_range_m: ArrayLike,
    sigma_azimuth_rad: ArrayLike,
    conversion: ConversionName = "mucm",
    prediction: Prediction | None = None,
) -> Converted:
    """Convert measurements of any shape (...), which must fit each other.

    Parameters
    ----------
    range_m, sigma_range_m : float, m
    azimuth_rad, sigma_azimuth_rad : float, rad; counter-clockwise from x
    conversion : one of `CONVERSIONS`
    prediction : what `ducm` takes its covariance from; nothing else does

    Returns
    -------
    Converted
        Points (..., 2) relative to the radar, covariances (..., 2, 2), symmetric to the bit; NaN where an input is.

    Raises
    ------
    ParameterError
        An unknown conversion, or `ducm` without a prediction.
    """
    if conversion not in CONVERSIONS:
        raise ParameterError(
            f"There is no conversion {conversion!r}.",
            pointer="/conversion",
            remedy=f"Use one of {', '.join(CONVERSIONS)}.",
        )
    r, b, sr, sb = np.broadcast_arrays(
        *(np.asarray(a, float) for a in (range_m, azimuth_rad, sigma_range_m, sigma_azimuth_rad))
    )
    x, y, xx, yy, xy = plane_components(r, np.cos(b), np.sin(b), sr, sb, conversion, prediction)
    covariance = np.stack([np.stack([xx, xy], axis=-1), np.stack([xy, yy], axis=-1)], axis=-2)
    return Converted(np.stack([x, y], axis=-1), covariance)


def plane_components(
    r: Floats,
    c: Floats,
    s: Floats,
    sigma_range_m: ArrayLike,
    sigma_azimuth_rad: ArrayLike,
    conversion: ConversionName,
    prediction: Prediction | None = None,
) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Convert as `cartesian_from_polar` does, with each component in an array of its own.

    Blocks of trials are computed this way: several conversions share the cosine c and the sine s of the azimuth, and
    accuracies that are numbers are not blown up to arrays.

    Returns
    -------
    x, y, xx, yy, xy : as r, in m and m2
    """
    sr, sb = np.asarray(sigma_range_m, float), np.asarray(sigma_azimuth_rad, float)
    v, q = sb * sb, sr * sr
    k = _factor(conversion, v) * r
    if conversion == "lin":
        xx, yy, xy = _turned(q, r * r * v, c, s)
    elif conversion in ("paper", "paper_literal", "dcm"):
        xx, yy, xy = _debiased(r, c, s, q, v, literal=conversion == "paper_literal")
    elif conversion == "ducm":
        if prediction is None:
            raise ParameterError(
                "The decorrelated conversion takes its covariance from a prediction, and there is none.",
                pointer="/conversion",
                remedy="Use mucm for plots that belong to no track yet.",
            )
        xx, yy, xy = _predicted(q, v, prediction)
    else:
        xx, yy, xy = _given_the_measurement(r, c, s, q, v, about_truth=conversion == "ucm")
    return k * c, k * s, xx, yy, xy


def polar_statistic(
    point: ArrayLike, range_m: ArrayLike, azimuth_rad: ArrayLike, sigma_range_m: ArrayLike, sigma_azimuth_rad: ArrayLike
) -> Floats:
    """Return the squared normalised distance of points (..., 2) from measurements in polar axes, without conversion.

    This is -2 ln of the exact likelihood of a point, less its constant: what `polar` means where a method offers it
    beside the conversions.
    """
    p = np.asarray(point, float)
    along = (np.asarray(range_m, float) - np.hypot(p[..., 0], p[..., 1])) / np.asarray(sigma_range_m, float)
    off = wrapped(np.asarray(azimuth_rad, float) - np.arctan2(p[..., 1], p[..., 0])) / np.asarray(
        sigma_azimuth_rad, float
    )
    statistic: Floats = along * along + off * off
    return statistic


def _factor(conversion: ConversionName, v: Floats) -> Floats:
    factor: Floats
    if conversion == "lin":
        factor = np.ones_like(v)
    elif conversion in ("paper", "paper_literal"):
        factor = 1 - v / 2
    elif conversion == "dcm":
        factor = np.exp(-v / 2) - np.expm1(-v)
    elif conversion == "mucm":
        factor = np.exp(-v / 2)
    else:
        factor = np.exp(v / 2)
    return factor


_Symmetric = tuple[Floats, Floats, Floats]
"""xx, yy and xy of a symmetric matrix."""


def _turned(along: Floats, across: Floats, c: Floats, s: Floats) -> _Symmetric:
    """Variances along and across the line of sight, in the axes of the plane."""
    cc, ss = c * c, s * s
    return along * cc + across * ss, along * ss + across * cc, (along - across) * (s * c)


def _debiased(r: Floats, c: Floats, s: Floats, q: Floats, v: Floats, *, literal: bool) -> _Symmetric:
    """Covariance of the raw point given the truth, averaged over the truth given the measurement; eqs. (4)."""
    # Differences of two hyperbolic functions as products: the differences lose all digits where v is small.
    fade = np.exp(-2 * v)
    cosh2_cosh1 = fade * 2 * np.sinh(1.5 * v) * np.sinh(0.5 * v)
    sinh2_sinh1 = fade * 2 * np.cosh(1.5 * v) * np.sinh(0.5 * v)
    rr = r * r
    even = rr * cosh2_cosh1 + q * (fade * np.cosh(2 * v) + cosh2_cosh1)
    odd = rr * sinh2_sinh1 + q * (fade * np.sinh(2 * v) + sinh2_sinh1)
    cc, ss = c * c, s * s
    growth, far = np.expm1(-v if literal else v), np.exp(-4 * v)
    xy = (s * c) * (far * q * (1 - growth) - rr * (far * growth))
    return cc * even + ss * odd, ss * even + cc * odd, xy


def _given_the_measurement(r: Floats, c: Floats, s: Floats, q: Floats, v: Floats, *, about_truth: bool) -> _Symmetric:
    """Second moment of z - p given the measurement, in closed form without a difference of nearly equal terms."""
    h = -np.expm1(-2 * v) / 2
    shrunk = np.expm1(-v) ** 2
    # ucm: e^v - 1 + (e^(-2v) - 1)/2 = (1 - e^(-v))^2 (e^v + 1/2).
    bend = shrunk * (np.exp(v) + 0.5) if about_truth else shrunk / 2
    rr = r * r
    return _turned(rr * bend + q * (1 - h), (rr + q) * h, c, s)


def _predicted(q: Floats, v: Floats, prediction: Prediction) -> _Symmetric:
    """Covariance of z given a prediction that does not contain the measurement."""
    r0, b0, range_variance, azimuth_variance = (np.asarray(a, float) for a in prediction)
    m = r0 * r0 + range_variance
    fade = np.exp(-2 * azimuth_variance)
    c2, s2 = fade * np.cos(2 * b0), fade * np.sin(2 * b0)
    same = m * np.expm1(v) + q * np.exp(v)
    turned = m * np.expm1(-v) + q * np.exp(-v)
    return (same + c2 * turned) / 2, (same - c2 * turned) / 2, s2 * turned / 2
