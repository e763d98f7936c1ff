"""The literature that algorithms, scenarios and docstrings cite by key."""

from __future__ import annotations

REFERENCES: dict[str, str] = {
    "chugunov2023": (
        "Trajectory filtering algorithm in multi-position passive radars with additional flight altitude "
        "observation. Proceedings of the Russian Higher School Academy of Sciences, 2023, no. 4 (61), pp. "
        "77-90. DOI 10.17212/1727-2769-2023-4-77-90"
    ),
    "barshalom2001": (
        "Y. Bar-Shalom, X. R. Li, T. Kirubarajan. Estimation with Applications to Tracking and Navigation. Wiley, 2001."
    ),
    "bowring1976": (
        "B. R. Bowring. Transformation from spatial to geographical coordinates. Survey Review 23 (181), "
        "1976, pp. 323-327."
    ),
    "more1978": (
        "J. J. More. The Levenberg-Marquardt algorithm: implementation and theory. Lecture Notes in "
        "Mathematics 630, 1978."
    ),
    "smith1987": (
        "J. O. Smith, J. S. Abel. Closed-form least-squares source location estimation from range-difference "
        "measurements. IEEE Trans. ASSP 35 (12), 1987, pp. 1661-1669."
    ),
    "schaefer2021": (
        "M. Schaefer, M. Strohmeier, M. Leonardi, V. Lenders. LocaRDS: A Localization Reference Data Set. "
        "Sensors 21 (16), 5516, 2021."
    ),
    "tichavsky1998": (
        "P. Tichavsky, C. H. Muravchik, A. Nehorai. Posterior Cramer-Rao bounds for discrete-time nonlinear "
        "filtering. IEEE Trans. SP 46 (5), 1998, pp. 1386-1396."
    ),
}
