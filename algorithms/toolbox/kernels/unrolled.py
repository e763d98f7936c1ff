"""Scalar-row updates with written-out loops. Made by `algorithms.toolbox.kernels.generate`: do not edit.

A row says z = h . p + noise of variance R, where p is the position part of the state. Its update needs no inverse:

    w = P h,   S = h . w + R,   x += w nu / S,   P -= w w^T / S,   NIS += nu^2 / S,   ln L -= (nu^2 + ln S) / 2.

Rows must be mutually uncorrelated; they then may be applied one after another, in any order, and the sequence is
exactly the joint update when all rows are linearised at the same point: the innovation of a row subtracts h times
the movement that earlier rows made. P stays symmetric because only its lower triangle exists.

Arguments: x (n, LANES), p (n (n + 1) / 2, LANES) packed; start (3, LANES), the position to which `nu` refers;
h (rows, 3, LANES), nu, variance (rows, LANES), the rows; active (rows, LANES), 1 where the lane has the row and 0
where it has not (gain zero, no branch); nis and determinant (LANES,), to which nu^2 / S is added and S / R multiplied.

Where the state ends with a bias, `along` (rows, LANES) says how a row sees it (0 or 1), and start (4, LANES) holds it
too.
"""

# ruff: noqa: E501
from __future__ import annotations

from algorithms.toolbox.kernels import LANES, kernel


@kernel
def update_rows_9(x, p, start, h, nu, variance, active, nis, determinant):
    """Update a block of 9-component states by scalar rows, one after another, in place."""
    # Flat views: with the row length known, the compiler sees that rows do not overlap, and vectorises.
    q = p.reshape(p.size)
    y = x.reshape(x.size)
    b = start.reshape(start.size)
    for row in range(nu.shape[0]):
        row_h = h[row].reshape(3 * LANES)
        row_nu = nu[row]
        row_variance = variance[row]
        row_active = active[row]
        for lane in range(LANES):
            h0 = row_h[0 * LANES + lane]
            h1 = row_h[1 * LANES + lane]
            h2 = row_h[2 * LANES + lane]
            w0 = q[0 * LANES + lane] * h0 + q[6 * LANES + lane] * h1 + q[21 * LANES + lane] * h2
            w1 = q[1 * LANES + lane] * h0 + q[7 * LANES + lane] * h1 + q[22 * LANES + lane] * h2
            w2 = q[3 * LANES + lane] * h0 + q[8 * LANES + lane] * h1 + q[23 * LANES + lane] * h2
            w3 = q[6 * LANES + lane] * h0 + q[9 * LANES + lane] * h1 + q[24 * LANES + lane] * h2
            w4 = q[10 * LANES + lane] * h0 + q[13 * LANES + lane] * h1 + q[25 * LANES + lane] * h2
            w5 = q[15 * LANES + lane] * h0 + q[18 * LANES + lane] * h1 + q[26 * LANES + lane] * h2
            w6 = q[21 * LANES + lane] * h0 + q[24 * LANES + lane] * h1 + q[27 * LANES + lane] * h2
            w7 = q[28 * LANES + lane] * h0 + q[31 * LANES + lane] * h1 + q[34 * LANES + lane] * h2
            w8 = q[36 * LANES + lane] * h0 + q[39 * LANES + lane] * h1 + q[42 * LANES + lane] * h2
            r = row_variance[lane]
            s = r + h0 * w0 + h1 * w3 + h2 * w6
            e = row_nu[lane] - h0 * (y[0 * LANES + lane] - b[0 * LANES + lane]) - h1 * (y[3 * LANES + lane] - b[1 * LANES + lane]) - h2 * (y[6 * LANES + lane] - b[2 * LANES + lane])
            # S <= 0 can only come from a covariance that is no longer one; the lane is left as it is.
            sound = s > 0.0
            a = row_active[lane] if sound else 0.0
            g = a / (s if sound else 1.0)
            nis[lane] += e * e * g
            determinant[lane] *= 1.0 + a * (s - r) / r
            e *= g
            y[0 * LANES + lane] += w0 * e
            y[1 * LANES + lane] += w1 * e
            y[2 * LANES + lane] += w2 * e
            y[3 * LANES + lane] += w3 * e
            y[4 * LANES + lane] += w4 * e
            y[5 * LANES + lane] += w5 * e
            y[6 * LANES + lane] += w6 * e
            y[7 * LANES + lane] += w7 * e
            y[8 * LANES + lane] += w8 * e
            g0 = w0 * g
            q[0 * LANES + lane] -= g0 * w0
            g1 = w1 * g
            q[1 * LANES + lane] -= g1 * w0
            q[2 * LANES + lane] -= g1 * w1
            g2 = w2 * g
            q[3 * LANES + lane] -= g2 * w0
            q[4 * LANES + lane] -= g2 * w1
            q[5 * LANES + lane] -= g2 * w2
            g3 = w3 * g
            q[6 * LANES + lane] -= g3 * w0
            q[7 * LANES + lane] -= g3 * w1
            q[8 * LANES + lane] -= g3 * w2
            q[9 * LANES + lane] -= g3 * w3
            g4 = w4 * g
            q[10 * LANES + lane] -= g4 * w0
            q[11 * LANES + lane] -= g4 * w1
            q[12 * LANES + lane] -= g4 * w2
            q[13 * LANES + lane] -= g4 * w3
            q[14 * LANES + lane] -= g4 * w4
            g5 = w5 * g
            q[15 * LANES + lane] -= g5 * w0
            q[16 * LANES + lane] -= g5 * w1
            q[17 * LANES + lane] -= g5 * w2
            q[18 * LANES + lane] -= g5 * w3
            q[19 * LANES + lane] -= g5 * w4
            q[20 * LANES + lane] -= g5 * w5
            g6 = w6 * g
            q[21 * LANES + lane] -= g6 * w0
            q[22 * LANES + lane] -= g6 * w1
            q[23 * LANES + lane] -= g6 * w2
            q[24 * LANES + lane] -= g6 * w3
            q[25 * LANES + lane] -= g6 * w4
            q[26 * LANES + lane] -= g6 * w5
            q[27 * LANES + lane] -= g6 * w6
            g7 = w7 * g
            q[28 * LANES + lane] -= g7 * w0
            q[29 * LANES + lane] -= g7 * w1
            q[30 * LANES + lane] -= g7 * w2
            q[31 * LANES + lane] -= g7 * w3
            q[32 * LANES + lane] -= g7 * w4
            q[33 * LANES + lane] -= g7 * w5
            q[34 * LANES + lane] -= g7 * w6
            q[35 * LANES + lane] -= g7 * w7
            g8 = w8 * g
            q[36 * LANES + lane] -= g8 * w0
            q[37 * LANES + lane] -= g8 * w1
            q[38 * LANES + lane] -= g8 * w2
            q[39 * LANES + lane] -= g8 * w3
            q[40 * LANES + lane] -= g8 * w4
            q[41 * LANES + lane] -= g8 * w5
            q[42 * LANES + lane] -= g8 * w6
            q[43 * LANES + lane] -= g8 * w7
            q[44 * LANES + lane] -= g8 * w8


@kernel
def update_rows_3(x, p, start, h, nu, variance, active, nis, determinant):
    """Update a block of 3-component states by scalar rows, one after another, in place."""
    # Flat views: with the row length known, the compiler sees that rows do not overlap, and vectorises.
    q = p.reshape(p.size)
    y = x.reshape(x.size)
    b = start.reshape(start.size)
    for row in range(nu.shape[0]):
        row_h = h[row].reshape(3 * LANES)
        row_nu = nu[row]
        row_variance = variance[row]
        row_active = active[row]
        for lane in range(LANES):
            h0 = row_h[0 * LANES + lane]
            h1 = row_h[1 * LANES + lane]
            h2 = row_h[2 * LANES + lane]
            w0 = q[0 * LANES + lane] * h0 + q[1 * LANES + lane] * h1 + q[3 * LANES + lane] * h2
            w1 = q[1 * LANES + lane] * h0 + q[2 * LANES + lane] * h1 + q[4 * LANES + lane] * h2
            w2 = q[3 * LANES + lane] * h0 + q[4 * LANES + lane] * h1 + q[5 * LANES + lane] * h2
            r = row_variance[lane]
            s = r + h0 * w0 + h1 * w1 + h2 * w2
            e = row_nu[lane] - h0 * (y[0 * LANES + lane] - b[0 * LANES + lane]) - h1 * (y[1 * LANES + lane] - b[1 * LANES + lane]) - h2 * (y[2 * LANES + lane] - b[2 * LANES + lane])
            # S <= 0 can only come from a covariance that is no longer one; the lane is left as it is.
            sound = s > 0.0
            a = row_active[lane] if sound else 0.0
            g = a / (s if sound else 1.0)
            nis[lane] += e * e * g
            determinant[lane] *= 1.0 + a * (s - r) / r
            e *= g
            y[0 * LANES + lane] += w0 * e
            y[1 * LANES + lane] += w1 * e
            y[2 * LANES + lane] += w2 * e
            g0 = w0 * g
            q[0 * LANES + lane] -= g0 * w0
            g1 = w1 * g
            q[1 * LANES + lane] -= g1 * w0
            q[2 * LANES + lane] -= g1 * w1
            g2 = w2 * g
            q[3 * LANES + lane] -= g2 * w0
            q[4 * LANES + lane] -= g2 * w1
            q[5 * LANES + lane] -= g2 * w2


@kernel
def update_rows_10(x, p, start, h, along, nu, variance, active, nis, determinant):
    """Update a block of 10-component states, the last a bias, by scalar rows, one after another, in place."""
    # Flat views: with the row length known, the compiler sees that rows do not overlap, and vectorises.
    q = p.reshape(p.size)
    y = x.reshape(x.size)
    b = start.reshape(start.size)
    for row in range(nu.shape[0]):
        row_h = h[row].reshape(3 * LANES)
        row_along = along[row]
        row_nu = nu[row]
        row_variance = variance[row]
        row_active = active[row]
        for lane in range(LANES):
            h0 = row_h[0 * LANES + lane]
            h1 = row_h[1 * LANES + lane]
            h2 = row_h[2 * LANES + lane]
            h3 = row_along[lane]
            w0 = q[0 * LANES + lane] * h0 + q[6 * LANES + lane] * h1 + q[21 * LANES + lane] * h2 + q[45 * LANES + lane] * h3
            w1 = q[1 * LANES + lane] * h0 + q[7 * LANES + lane] * h1 + q[22 * LANES + lane] * h2 + q[46 * LANES + lane] * h3
            w2 = q[3 * LANES + lane] * h0 + q[8 * LANES + lane] * h1 + q[23 * LANES + lane] * h2 + q[47 * LANES + lane] * h3
            w3 = q[6 * LANES + lane] * h0 + q[9 * LANES + lane] * h1 + q[24 * LANES + lane] * h2 + q[48 * LANES + lane] * h3
            w4 = q[10 * LANES + lane] * h0 + q[13 * LANES + lane] * h1 + q[25 * LANES + lane] * h2 + q[49 * LANES + lane] * h3
            w5 = q[15 * LANES + lane] * h0 + q[18 * LANES + lane] * h1 + q[26 * LANES + lane] * h2 + q[50 * LANES + lane] * h3
            w6 = q[21 * LANES + lane] * h0 + q[24 * LANES + lane] * h1 + q[27 * LANES + lane] * h2 + q[51 * LANES + lane] * h3
            w7 = q[28 * LANES + lane] * h0 + q[31 * LANES + lane] * h1 + q[34 * LANES + lane] * h2 + q[52 * LANES + lane] * h3
            w8 = q[36 * LANES + lane] * h0 + q[39 * LANES + lane] * h1 + q[42 * LANES + lane] * h2 + q[53 * LANES + lane] * h3
            w9 = q[45 * LANES + lane] * h0 + q[48 * LANES + lane] * h1 + q[51 * LANES + lane] * h2 + q[54 * LANES + lane] * h3
            r = row_variance[lane]
            s = r + h0 * w0 + h1 * w3 + h2 * w6 + h3 * w9
            e = row_nu[lane] - h0 * (y[0 * LANES + lane] - b[0 * LANES + lane]) - h1 * (y[3 * LANES + lane] - b[1 * LANES + lane]) - h2 * (y[6 * LANES + lane] - b[2 * LANES + lane]) - h3 * (y[9 * LANES + lane] - b[3 * LANES + lane])
            # S <= 0 can only come from a covariance that is no longer one; the lane is left as it is.
            sound = s > 0.0
            a = row_active[lane] if sound else 0.0
            g = a / (s if sound else 1.0)
            nis[lane] += e * e * g
            determinant[lane] *= 1.0 + a * (s - r) / r
            e *= g
            y[0 * LANES + lane] += w0 * e
            y[1 * LANES + lane] += w1 * e
            y[2 * LANES + lane] += w2 * e
            y[3 * LANES + lane] += w3 * e
            y[4 * LANES + lane] += w4 * e
            y[5 * LANES + lane] += w5 * e
            y[6 * LANES + lane] += w6 * e
            y[7 * LANES + lane] += w7 * e
            y[8 * LANES + lane] += w8 * e
            y[9 * LANES + lane] += w9 * e
            g0 = w0 * g
            q[0 * LANES + lane] -= g0 * w0
            g1 = w1 * g
            q[1 * LANES + lane] -= g1 * w0
            q[2 * LANES + lane] -= g1 * w1
            g2 = w2 * g
            q[3 * LANES + lane] -= g2 * w0
            q[4 * LANES + lane] -= g2 * w1
            q[5 * LANES + lane] -= g2 * w2
            g3 = w3 * g
            q[6 * LANES + lane] -= g3 * w0
            q[7 * LANES + lane] -= g3 * w1
            q[8 * LANES + lane] -= g3 * w2
            q[9 * LANES + lane] -= g3 * w3
            g4 = w4 * g
            q[10 * LANES + lane] -= g4 * w0
            q[11 * LANES + lane] -= g4 * w1
            q[12 * LANES + lane] -= g4 * w2
            q[13 * LANES + lane] -= g4 * w3
            q[14 * LANES + lane] -= g4 * w4
            g5 = w5 * g
            q[15 * LANES + lane] -= g5 * w0
            q[16 * LANES + lane] -= g5 * w1
            q[17 * LANES + lane] -= g5 * w2
            q[18 * LANES + lane] -= g5 * w3
            q[19 * LANES + lane] -= g5 * w4
            q[20 * LANES + lane] -= g5 * w5
            g6 = w6 * g
            q[21 * LANES + lane] -= g6 * w0
            q[22 * LANES + lane] -= g6 * w1
            q[23 * LANES + lane] -= g6 * w2
            q[24 * LANES + lane] -= g6 * w3
            q[25 * LANES + lane] -= g6 * w4
            q[26 * LANES + lane] -= g6 * w5
            q[27 * LANES + lane] -= g6 * w6
            g7 = w7 * g
            q[28 * LANES + lane] -= g7 * w0
            q[29 * LANES + lane] -= g7 * w1
            q[30 * LANES + lane] -= g7 * w2
            q[31 * LANES + lane] -= g7 * w3
            q[32 * LANES + lane] -= g7 * w4
            q[33 * LANES + lane] -= g7 * w5
            q[34 * LANES + lane] -= g7 * w6
            q[35 * LANES + lane] -= g7 * w7
            g8 = w8 * g
            q[36 * LANES + lane] -= g8 * w0
            q[37 * LANES + lane] -= g8 * w1
            q[38 * LANES + lane] -= g8 * w2
            q[39 * LANES + lane] -= g8 * w3
            q[40 * LANES + lane] -= g8 * w4
            q[41 * LANES + lane] -= g8 * w5
            q[42 * LANES + lane] -= g8 * w6
            q[43 * LANES + lane] -= g8 * w7
            q[44 * LANES + lane] -= g8 * w8
            g9 = w9 * g
            q[45 * LANES + lane] -= g9 * w0
            q[46 * LANES + lane] -= g9 * w1
            q[47 * LANES + lane] -= g9 * w2
            q[48 * LANES + lane] -= g9 * w3
            q[49 * LANES + lane] -= g9 * w4
            q[50 * LANES + lane] -= g9 * w5
            q[51 * LANES + lane] -= g9 * w6
            q[52 * LANES + lane] -= g9 * w7
            q[53 * LANES + lane] -= g9 * w8
            q[54 * LANES + lane] -= g9 * w9


@kernel
def update_rows_4(x, p, start, h, along, nu, variance, active, nis, determinant):
    """Update a block of 4-component states, the last a bias, by scalar rows, one after another, in place."""
    # Flat views: with the row length known, the compiler sees that rows do not overlap, and vectorises.
    q = p.reshape(p.size)
    y = x.reshape(x.size)
    b = start.reshape(start.size)
    for row in range(nu.shape[0]):
        row_h = h[row].reshape(3 * LANES)
        row_along = along[row]
        row_nu = nu[row]
        row_variance = variance[row]
        row_active = active[row]
        for lane in range(LANES):
            h0 = row_h[0 * LANES + lane]
            h1 = row_h[1 * LANES + lane]
            h2 = row_h[2 * LANES + lane]
            h3 = row_along[lane]
            w0 = q[0 * LANES + lane] * h0 + q[1 * LANES + lane] * h1 + q[3 * LANES + lane] * h2 + q[6 * LANES + lane] * h3
            w1 = q[1 * LANES + lane] * h0 + q[2 * LANES + lane] * h1 + q[4 * LANES + lane] * h2 + q[7 * LANES + lane] * h3
            w2 = q[3 * LANES + lane] * h0 + q[4 * LANES + lane] * h1 + q[5 * LANES + lane] * h2 + q[8 * LANES + lane] * h3
            w3 = q[6 * LANES + lane] * h0 + q[7 * LANES + lane] * h1 + q[8 * LANES + lane] * h2 + q[9 * LANES + lane] * h3
            r = row_variance[lane]
            s = r + h0 * w0 + h1 * w1 + h2 * w2 + h3 * w3
            e = row_nu[lane] - h0 * (y[0 * LANES + lane] - b[0 * LANES + lane]) - h1 * (y[1 * LANES + lane] - b[1 * LANES + lane]) - h2 * (y[2 * LANES + lane] - b[2 * LANES + lane]) - h3 * (y[3 * LANES + lane] - b[3 * LANES + lane])
            # S <= 0 can only come from a covariance that is no longer one; the lane is left as it is.
            sound = s > 0.0
            a = row_active[lane] if sound else 0.0
            g = a / (s if sound else 1.0)
            nis[lane] += e * e * g
            determinant[lane] *= 1.0 + a * (s - r) / r
            e *= g
            y[0 * LANES + lane] += w0 * e
            y[1 * LANES + lane] += w1 * e
            y[2 * LANES + lane] += w2 * e
            y[3 * LANES + lane] += w3 * e
            g0 = w0 * g
            q[0 * LANES + lane] -= g0 * w0
            g1 = w1 * g
            q[1 * LANES + lane] -= g1 * w0
            q[2 * LANES + lane] -= g1 * w1
            g2 = w2 * g
            q[3 * LANES + lane] -= g2 * w0
            q[4 * LANES + lane] -= g2 * w1
            q[5 * LANES + lane] -= g2 * w2
            g3 = w3 * g
            q[6 * LANES + lane] -= g3 * w0
            q[7 * LANES + lane] -= g3 * w1
            q[8 * LANES + lane] -= g3 * w2
            q[9 * LANES + lane] -= g3 * w3
