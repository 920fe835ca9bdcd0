"""Kernels for many parameter sets at once, and along a planned motion.

Row r of lane l of block b stands at ``(b * rows + r) * LANES + l``. Constant distances between rows let the
compiler work on several lanes per instruction.

A leapfrog step with the stiffness 4 sin^2(w h / 2) / h^2 in place of w^2 turns by exactly w h.
"""

import numpy as np

from cabledrive.mechanics.compiled import njit

# mypy: allow-untyped-defs


LANES = 64

# Rows of the averaged equations: coefficients, then state, then what was largest.
DAMP, TUNE, FORCE_RE, FORCE_IM, DECAY, TUNE_1, TUNE_2, BACK_1, BACK_2, PUMP_1, PUMP_2 = range(11)
BARE_11, BARE_12, BARE_21, BARE_22, QUARTER_11, QUARTER_12, QUARTER_21, QUARTER_22 = range(11, 19)
DRIFT_1, DRIFT_2, DRIFT_KEPT, PASSIVE_1, PASSIVE_2, PASSIVE_KEPT = range(19, 25)
Q_RE, Q_IM, A_RE, A_IM, B_RE, B_IM, DRIFT, PASSIVE = range(25, 33)
MOST_Q, MOST_A, MOST_B = range(33, 36)
AVERAGED_ROWS = 36

# Rows of the oscillators.
QQ, QP, PQ, PP, AA_1, AB_1, BA_1, BB_1, AA_2, AB_2, BA_2, BB_2 = range(12)
PUSH_1, PUSH_2, LIFT_1, LIFT_2, CUBE_11, CUBE_12, CUBE_21, CUBE_22 = range(12, 20)
THRUST, RIGID_THRUST, TURN_COS, TURN_SIN, CROSS, RIGID_DECAY, RIGID_CROSS, STEP = range(20, 28)
PLACE, RATE, SPEED, A, A_RATE, B, B_RATE, COS, SIN = range(28, 37)
TOP_Q, TOP_A, TOP_B = range(37, 40)
OSCILLATOR_ROWS = 40


@njit
def first_order_rates(damp, tune, fr, fi, decay, t1, t2, back1, back2, k1, k2, e11, e12, e21, e22,
                      n11, n12, n21, n22, qr, qi, ar, ai, br, bi):  # fmt: skip
    """Real form of the averaged equations for two sections in one plane."""
    a2, b2 = ar * ar + ai * ai, br * br + bi * bi
    asr, asi = ar * ar - ai * ai, 2.0 * ar * ai
    bsr, bsi = br * br - bi * bi, 2.0 * br * bi
    sr, si = back1 * asr + back2 * bsr, back1 * asi + back2 * bsi
    dqr = -damp * qr - tune * qi - si - fr
    dqi = -damp * qi + tune * qr + sr - fi
    w1, w2 = t1 + e11 * a2 + e12 * b2, t2 + e21 * a2 + e22 * b2
    p1r, p1i = k1 * qr + n11 * asr + n12 * bsr, k1 * qi + n11 * asi + n12 * bsi
    p2r, p2i = k2 * qr + n21 * asr + n22 * bsr, k2 * qi + n21 * asi + n22 * bsi
    dar = -decay * ar - w1 * ai - (p1i * ar - p1r * ai)
    dai = -decay * ai + w1 * ar + (p1r * ar + p1i * ai)
    dbr = -decay * br - w2 * bi - (p2i * br - p2r * bi)
    dbi = -decay * bi + w2 * br + (p2r * br + p2i * bi)
    return dqr, dqi, dar, dai, dbr, dbi


@njit
def integrate_averaged(cells, first, last, steps, h):
    """Runge-Kutta steps of fourth order on blocks `first` to `last` of the averaged equations."""
    for block in range(first, last):
        o = block * AVERAGED_ROWS * LANES
        for _ in range(steps):
            for lane in range(LANES):
                i = o + lane
                damp, tune = cells[i + DAMP * LANES], cells[i + TUNE * LANES]
                fr, fi = cells[i + FORCE_RE * LANES], cells[i + FORCE_IM * LANES]
                decay = cells[i + DECAY * LANES]
                b1, b2 = cells[i + BACK_1 * LANES], cells[i + BACK_2 * LANES]
                k1, k2 = cells[i + PUMP_1 * LANES], cells[i + PUMP_2 * LANES]
                e11, e12 = cells[i + BARE_11 * LANES], cells[i + BARE_12 * LANES]
                e21, e22 = cells[i + BARE_21 * LANES], cells[i + BARE_22 * LANES]
                n11, n12 = cells[i + QUARTER_11 * LANES], cells[i + QUARTER_12 * LANES]
                n21, n22 = cells[i + QUARTER_21 * LANES], cells[i + QUARTER_22 * LANES]
                g1, g2 = cells[i + DRIFT_1 * LANES], cells[i + DRIFT_2 * LANES]
                s1, s2 = cells[i + PASSIVE_1 * LANES], cells[i + PASSIVE_2 * LANES]
                d, p = cells[i + DRIFT * LANES], cells[i + PASSIVE * LANES]
                dk, pk = cells[i + DRIFT_KEPT * LANES], cells[i + PASSIVE_KEPT * LANES]
                qr, qi = cells[i + Q_RE * LANES], cells[i + Q_IM * LANES]
                ar, ai = cells[i + A_RE * LANES], cells[i + A_IM * LANES]
                br, bi = cells[i + B_RE * LANES], cells[i + B_IM * LANES]
                t1, t2 = cells[i + TUNE_1 * LANES], cells[i + TUNE_2 * LANES]
                u1, u2 = t1 + g1 * d + s1 * p, t2 + g2 * d + s2 * p
                d, p = d * dk, p * pk
                v1, v2 = t1 + g1 * d + s1 * p, t2 + g2 * d + s2 * p
                d, p = d * dk, p * pk
                w1, w2 = t1 + g1 * d + s1 * p, t2 + g2 * d + s2 * p
                x0, x1, x2, x3, x4, x5 = first_order_rates(
                    damp, tune, fr, fi, decay, u1, u2, b1, b2, k1, k2, e11, e12, e21, e22, n11, n12, n21, n22,
                    qr, qi, ar, ai, br, bi)  # fmt: skip
                m = 0.5 * h
                y0, y1, y2, y3, y4, y5 = first_order_rates(
                    damp, tune, fr, fi, decay, v1, v2, b1, b2, k1, k2, e11, e12, e21, e22, n11, n12, n21, n22,
                    qr + m * x0, qi + m * x1, ar + m * x2, ai + m * x3, br + m * x4, bi + m * x5)  # fmt: skip
                x0, x1, x2, x3, x4, x5 = (
                    x0 + 2 * y0, x1 + 2 * y1, x2 + 2 * y2, x3 + 2 * y3, x4 + 2 * y4, x5 + 2 * y5)  # fmt: skip
                y0, y1, y2, y3, y4, y5 = first_order_rates(
                    damp, tune, fr, fi, decay, v1, v2, b1, b2, k1, k2, e11, e12, e21, e22, n11, n12, n21, n22,
                    qr + m * y0, qi + m * y1, ar + m * y2, ai + m * y3, br + m * y4, bi + m * y5)  # fmt: skip
                x0, x1, x2, x3, x4, x5 = (
                    x0 + 2 * y0, x1 + 2 * y1, x2 + 2 * y2, x3 + 2 * y3, x4 + 2 * y4, x5 + 2 * y5)  # fmt: skip
                y0, y1, y2, y3, y4, y5 = first_order_rates(
                    damp, tune, fr, fi, decay, w1, w2, b1, b2, k1, k2, e11, e12, e21, e22, n11, n12, n21, n22,
                    qr + h * y0, qi + h * y1, ar + h * y2, ai + h * y3, br + h * y4, bi + h * y5)  # fmt: skip
                sixth = h / 6.0
                qr, qi = qr + sixth * (x0 + y0), qi + sixth * (x1 + y1)
                ar, ai = ar + sixth * (x2 + y2), ai + sixth * (x3 + y3)
                br, bi = br + sixth * (x4 + y4), bi + sixth * (x5 + y5)
                cells[i + Q_RE * LANES], cells[i + Q_IM * LANES] = qr, qi
                cells[i + A_RE * LANES], cells[i + A_IM * LANES] = ar, ai
                cells[i + B_RE * LANES], cells[i + B_IM * LANES] = br, bi
                cells[i + DRIFT * LANES], cells[i + PASSIVE * LANES] = d, p
                cells[i + MOST_Q * LANES] = max(cells[i + MOST_Q * LANES], qr * qr + qi * qi)
                cells[i + MOST_A * LANES] = max(cells[i + MOST_A * LANES], ar * ar + ai * ai)
                cells[i + MOST_B * LANES] = max(cells[i + MOST_B * LANES], br * br + bi * bi)


@njit
def integrate_oscillators(cells, first, last, steps):
    """Steps of the oscillators on blocks `first` to `last`: half a kick, exact flow, half a kick."""
    for block in range(first, last):
        o = block * OSCILLATOR_ROWS * LANES
        for n in range(steps + 1):
            share = 0.5 if n == 0 or n == steps else 1.0
            moves = 0.0 if n == steps else 1.0
            for lane in range(LANES):
                i = o + lane
                q, p, v = cells[i + PLACE * LANES], cells[i + RATE * LANES], cells[i + SPEED * LANES]
                a, ad = cells[i + A * LANES], cells[i + A_RATE * LANES]
                b, bd = cells[i + B * LANES], cells[i + B_RATE * LANES]
                c, s = cells[i + COS * LANES], cells[i + SIN * LANES]
                h = share * cells[i + STEP * LANES]
                cells[i + TOP_Q * LANES] = max(cells[i + TOP_Q * LANES], abs(q))
                cells[i + TOP_A * LANES] = max(cells[i + TOP_A * LANES], abs(a))
                cells[i + TOP_B * LANES] = max(cells[i + TOP_B * LANES], abs(b))
                a2, b2 = a * a, b * b
                force = cells[i + THRUST * LANES] * s - cells[i + CROSS * LANES] * v
                force -= cells[i + PUSH_1 * LANES] * a2 + cells[i + PUSH_2 * LANES] * b2
                rigid = cells[i + RIGID_THRUST * LANES] * s - cells[i + RIGID_DECAY * LANES] * v
                rigid -= cells[i + RIGID_CROSS * LANES] * p
                stiff = cells[i + LIFT_1 * LANES] * q
                stiff += cells[i + CUBE_11 * LANES] * a2 + cells[i + CUBE_12 * LANES] * b2
                ad -= h * stiff * a
                stiff = cells[i + LIFT_2 * LANES] * q
                stiff += cells[i + CUBE_21 * LANES] * a2 + cells[i + CUBE_22 * LANES] * b2
                bd -= h * stiff * b
                p += h * force
                v += h * rigid
                q0, p0 = cells[i + QQ * LANES] * q, cells[i + PQ * LANES] * q
                q0 += cells[i + QP * LANES] * p
                p0 += cells[i + PP * LANES] * p
                a0, ad0 = cells[i + AA_1 * LANES] * a, cells[i + BA_1 * LANES] * a
                a0 += cells[i + AB_1 * LANES] * ad
                ad0 += cells[i + BB_1 * LANES] * ad
                b0, bd0 = cells[i + AA_2 * LANES] * b, cells[i + BA_2 * LANES] * b
                b0 += cells[i + AB_2 * LANES] * bd
                bd0 += cells[i + BB_2 * LANES] * bd
                tc, ts = cells[i + TURN_COS * LANES], cells[i + TURN_SIN * LANES]
                cells[i + PLACE * LANES], cells[i + RATE * LANES] = q + moves * (q0 - q), p + moves * (p0 - p)
                cells[i + A * LANES], cells[i + A_RATE * LANES] = (
                    a + moves * (a0 - a),
                    ad + moves * (ad0 - ad),
                )
                cells[i + B * LANES], cells[i + B_RATE * LANES] = (
                    b + moves * (b0 - b),
                    bd + moves * (bd0 - bd),
                )
                cells[i + SPEED * LANES] = v
                cells[i + COS * LANES], cells[i + SIN * LANES] = c * tc - s * ts, s * tc + c * ts


# mypy: allow-untyped-defs


@njit
def exact_stiffness(squared, h):
    """Stiffness with which a leapfrog of step h turns at the frequency of `squared`; negative ones stay."""
    if squared <= 0.0:
        return squared
    half = 0.5 * h * np.sqrt(squared)
    return (2.0 * np.sin(half) / h) ** 2


@njit
def transitions(across, lift, q, gamma, h, edges, out):
    """Transition matrices of Eq. (A.32) from edge to edge, of (a, rate / w), shape (edges - 1, 2, 2)."""
    loss = 0.5 * h * gamma
    for block in range(edges.size - 1):
        w0, w1 = across[edges[block]], across[edges[block + 1] - 1]
        for column in range(2):
            a = 1.0 if column == 0 else 0.0
            b = 0.0 if column == 0 else w0
            for n in range(edges[block], edges[block + 1]):
                stiff = exact_stiffness(across[n] ** 2 + lift[n] * q[n], h)
                b = ((1.0 - loss) * b - h * stiff * a) / (1.0 + loss)
                a += h * b
            out[block, 0, column] = a
            out[block, 1, column] = b / w1
