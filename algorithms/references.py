"""The literature that algorithms, scenarios and docstrings cite by key."""

from __future__ import annotations

REFERENCES: dict[str, str] = {
    "chugunov2023": (
        "Trajectory filtering algorithm in multi-position passive radars with additional flight altitude "
        "observation. Proceedings of the Russian Higher School Academy of Sciences, 2023, no. 4 (61), pp. "
        "77-90. DOI 10.17212/1727-2769-2023-4-77-90"
    ),
    "trudymai2023": ("Radar tracking based on a multiple model approach. Trudy MAI, 2023, no. 129 (in Russian)."),
    "blom1988": (
        "H. A. P. Blom, Y. Bar-Shalom. The interacting multiple model algorithm for systems with Markovian switching "
        "coefficients. IEEE Trans. AC 33 (8), 1988, pp. 780-783."
    ),
    "julier1997": (
        "S. J. Julier, J. K. Uhlmann. A new extension of the Kalman filter to nonlinear systems. Proc. SPIE 3068, 1997."
    ),
    "bell1993": (
        "B. M. Bell, F. W. Cathey. The iterated Kalman filter update as a Gauss-Newton method. IEEE Trans. AC 38 (2), "
        "1993, pp. 294-297."
    ),
    "arasaratnam2009": (
        "I. Arasaratnam, S. Haykin. Cubature Kalman filters. IEEE Trans. AC 54 (6), 2009, pp. 1254-1269."
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
    "scatter2014": (
        "Algorithm of estimating the target coordinates in forward-scattering multistatic radar system. 2014 (in "
        "Russian)."
    ),
    "prosov2008": (
        "A. V. Prosov. Analysis of the effect of linearisation errors of radar measurements on the reliability of "
        "associating data from spatially separated radars. 2008 (in Russian)."
    ),
    "schuhmacher2008": (
        "D. Schuhmacher, B.-T. Vo, B.-N. Vo. A consistent metric for performance evaluation of multi-object filters. "
        "IEEE Trans. SP 56 (8), 2008, pp. 3447-3457."
    ),
    "rahmathullah2017": (
        "A. S. Rahmathullah, A. F. Garcia-Fernandez, L. Svensson. Generalized optimal sub-pattern assignment metric. "
        "20th International Conference on Information Fusion, 2017."
    ),
    "plots2006": ("Radar data processing algorithm for manoeuvring targets. 2006 (in Russian)."),
    "lerro1993": (
        "D. Lerro, Y. Bar-Shalom. Tracking with debiased consistent converted measurements versus EKF. IEEE Trans. "
        "AES 29 (3), 1993, pp. 1015-1022."
    ),
    "longbin1998": (
        "M. Longbin, S. Xiaoquan, Z. Yiyu, S. Z. Kang, Y. Bar-Shalom. Unbiased converted measurements for tracking. "
        "IEEE Trans. AES 34 (3), 1998, pp. 1023-1027."
    ),
    "bordonaro2014": (
        "S. Bordonaro, P. Willett, Y. Bar-Shalom. Decorrelated unbiased converted measurement Kalman filter. IEEE "
        "Trans. AES 50 (2), 2014, pp. 1431-1444."
    ),
    "murty1968": (
        "K. G. Murty. An algorithm for ranking all the assignments in order of increasing cost. Operations Research "
        "16 (3), 1968, pp. 682-687."
    ),
    "crouse2016": (
        "D. F. Crouse. On implementing 2D rectangular assignment algorithms. IEEE Trans. AES 52 (4), 2016, "
        "pp. 1679-1696."
    ),
}
