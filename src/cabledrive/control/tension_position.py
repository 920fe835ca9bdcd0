r"""Position of a body and tension of the two lines that hold it, controlled together.

.. math:: \min_{T_{low} \le T \le T_{high}} \; |M^{-1}(J^T T + F)|^2 + \epsilon\,|T - T_p|^2

lies inside the box, on an edge or at a corner; the second term decides the internal tension where the machine
has one coordinate. Each motor makes its own line's tension follow. With the wanted tension through two lags,

.. math:: \ddot T_f = \omega_f^2\,(T_c - T_f) - 2\omega_f\dot T_f, \qquad
    \ddot e + 2\omega_i\dot e + \omega_i^2 e = c\,\tilde a, \qquad e = T - T_f,

:math:`T_f` keeps the limits of :math:`T_c`, and e is at most :math:`c\,|\tilde a|/\omega_i^2`, with
:math:`\tilde a` the acceleration along the line that neither model nor observer expected: a floor of
:math:`T_{min} + c\,|\tilde a|/\omega_i^2` for :math:`T_c` keeps T above :math:`T_{min}`.

The bound of the place: with a the acceleration of the body that the model does not expect, :math:`a_e` that
of the tensions' error, the observer with three equal poles :math:`\omega_o` leaves

.. math:: (s+\omega_o)^3\,\tilde q = s\,a,\qquad (s+\omega_o)^3\,\tilde v = s(s+3\omega_o)\,a,\qquad
    (s+\omega_o)^3\,\hat d = \omega_o^3\,a ,

and the error e of the place obeys, with :math:`F = \omega_f^2/(s+\omega_f)^2`,
:math:`P = 2\omega_p s + \omega_p^2` and :math:`B\,a = \omega_p^2\tilde q + 2\omega_p\tilde v - \hat d`,

.. math:: (s^2 + FP)\,e = (1 + FB)\,a + a_e + FB\,a_g - FN\,n ,

:math:`a_g` and n the noise of the observer's acceleration and of its place. What is bounded goes through the
integral of the answer's magnitude, white noise through that of its square.
"""

from math import exp, tanh
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import polynomial as poly
from numpy.typing import NDArray

from cabledrive.control.bound import impulse_response
from cabledrive.mechanics.compiled import njit, njit_in_place
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.two_motors import TwoMotors, line_at

PREFERENCE = 1e-8
"""Weight of the preferred tensions, over that of the largest acceleration per tension."""


@njit
def allocate(
    force: Array, mass: Array, along: Array, limits: tuple[Array, Array], preferred: Array, tension: Array
) -> None:
    """Write the tensions of a force on the body, (m,), between two limits near preferred ones, (2,) [N]."""
    low, high = limits
    a, b, c, g, h, top = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(force.size):
        u, v = along[0, j] / mass[j], along[1, j] / mass[j]
        w = force[j] / mass[j] + u * preferred[0] + v * preferred[1]
        a += u * u
        b += u * v
        c += v * v
        g -= u * w
        h -= v * w
        top = max(top, u * u, v * v)
    # Unknown is the distance from the preferred tensions: no digits are lost where they are right.
    a, c = a + PREFERENCE * top, c + PREFERENCE * top
    x0, x1 = low[0] - preferred[0], high[0] - preferred[0]
    y0, y1 = low[1] - preferred[1], high[1] - preferred[1]
    # Minimum of a x^2 / 2 + b x y + c y^2 / 2 - g x - h y over the box.
    scale = a * c - b * b
    best_x, best_y = (g * c - h * b) / scale, (a * h - b * g) / scale
    if not (x0 <= best_x <= x1 and y0 <= best_y <= y1):
        best = 1e300
        for side in range(4):
            if side < 2:
                x = x0 if side == 0 else x1
                y = min(max((h - b * x) / c, y0), y1)
            else:
                y = y0 if side == 2 else y1
                x = min(max((g - b * y) / a, x0), x1)
            cost = 0.5 * a * x * x + b * x * y + 0.5 * c * y * y - g * x - h * y
            if cost < best:
                best, best_x, best_y = cost, x, y
    tension[0], tension[1] = preferred[0] + best_x, preferred[1] + best_y


FAR = 1e12
"""Beyond any tension [N]: what would be allocated without limits."""
RESHAPED = 1e-6
"""Part of the span between the limits by which a wanted tension is moved before it counts as reshaped."""


class TensionGains(NamedTuple):
    """Gains of the law and the machine as it is believed to be."""

    machine: TwoMotors
    low: Array  # (2,): least tension asked for [N]
    high: Array  # (2,): largest [N]
    preferred: Array  # (2,): where the body leaves a choice [N]
    position: float  # bandwidth of the position [rad/s]
    filter: float  # omega_f [rad/s]
    tension: float  # omega_i [rad/s]
    observer: float  # bandwidth of the observer of the body [rad/s]
    sliding: float  # speed of a drum below which its friction is smoothed [rad/s]
    interval: float  # sample time [s]


def first_state(gains: TensionGains, tension: Array) -> Array:
    """State of a machine that rests at q = 0 under tensions [N], shape (3 m + 9,).

    Place, speed and disturbing acceleration of the body; both lags of either tension [N]; angles of the drums
    [rad]; whether the last command was reshaped; tensions wanted [N].
    """
    m = gains.machine.mass.size
    return np.concatenate([np.zeros(3 * m), tension, tension, np.zeros(3), tension])


@njit_in_place
def step_in_place(
    gains: TensionGains,
    state: Array,
    measurement: Array,
    reference: Array,
    command: Array,
    space: tuple[Array, Array],
) -> None:
    """One sample: the observer takes in the measurement, tensions are allocated, each motor follows its own.

    ``measurement``, (4,): angles of the drums [rad], tensions [N]; ``reference``, (3 m + 2,): wanted place,
    speed, acceleration, lead of either tension [N]. Changes ``state`` and writes the torques ``command`` (2,)
    [N m]; ``space``: (2, m) for the directions of the lines, (3 m + 22,).
    """
    machine, (along, work) = gains.machine, space
    m, interval = machine.mass.size, gains.interval
    q, v, d = state[:m], state[m : 2 * m], state[2 * m : 3 * m]
    lag, filtered = state[3 * m : 3 * m + 2], state[3 * m + 2 : 3 * m + 4]
    force, got = work[:m], work[m : 2 * m]
    rest = work[3 * m :]
    stiffness, tension, bend, wanted = rest[:2], rest[2:4], rest[4:6], rest[6:8]
    shortfall, free, low, high = rest[8:10], rest[10:12], rest[12:14], rest[14:16]
    below, above = rest[16:18], rest[18:20]
    observe(gains, state, measurement, along, work)
    for j in range(m):
        asked = reference[2 * m + j] + gains.position**2 * (reference[j] - q[j])
        asked += 2.0 * gains.position * (reference[m + j] - v[j]) - d[j]
        force[j] = machine.mass[j] * asked + resisting(machine, j, reference[m + j]) - machine.force[j]
        pull = along[0, j] * tension[0] + along[1, j] * tension[1]
        got[j] = (machine.force[j] - pull - resisting(machine, j, v[j])) / machine.mass[j] + d[j]
    for i in range(2):
        lead = reference[3 * m + i]
        shortfall[i], low[i], high[i] = gains.preferred[i] - lead, gains.low[i] - lead, gains.high[i] - lead
        below[i], above[i] = low[i] - FAR, high[i] + FAR
    allocate(force, machine.mass, along, (low, high), shortfall, wanted)
    free[0], free[1] = wanted[0], wanted[1]
    if not (low[0] < wanted[0] < high[0] and low[1] < wanted[1] < high[1]):  # what no limit would change
        allocate(force, machine.mass, along, (below, above), shortfall, free)
    reshaped, kept = 0.0, 1.0 - exp(-gains.filter * interval)
    for i in range(2):
        if abs(free[i] - wanted[i]) > RESHAPED * (high[i] - low[i]):
            reshaped = 1.0
        asked = wanted[i] + reference[3 * m + i]
        rate = gains.filter * (lag[i] - filtered[i])
        bent = gains.filter * (gains.filter * (asked - lag[i]) - rate)
        r, speed, expected, planned = machine.drum[i], 0.0, bend[i], 0.0
        for j in range(m):
            speed += along[i, j] * v[j]
            expected += along[i, j] * got[j]
            planned += along[i, j] * reference[m + j]
        turn = (measurement[i] - state[3 * m + 4 + i]) / interval
        error_rate = rate - stiffness[i] * (speed + r * turn)
        bent += 2.0 * gains.tension * error_rate + gains.tension**2 * (filtered[i] - tension[i])
        turning = -planned / r
        torque = machine.inertia[i] * (bent / stiffness[i] - expected) / r + r * tension[i]
        torque += machine.turning_viscous[i] * turn
        torque += machine.turning_coulomb[i] * tanh(turning / gains.sliding)
        command[i] = min(max(torque, -machine.limit[i]), machine.limit[i])
        lag[i] += kept * (asked - lag[i])
        filtered[i] += kept * (lag[i] - filtered[i])
        state[3 * m + 4 + i] = measurement[i]
        state[3 * m + 7 + i] = asked
    state[3 * m + 6] = reshaped
    for j in range(m):
        q[j] += interval * (v[j] + 0.5 * interval * got[j])
        v[j] += interval * got[j]


@njit_in_place
def observe(gains: TensionGains, state: Array, measurement: Array, along: Array, work: Array) -> None:
    """Correct place, speed and disturbance of the body by the measurement; write dL/dq ``along``, (2, m).

    Into ``work``: c [N/m], T [N], and the part of the lines' accelerations that their turning makes [m/s^2].
    """
    machine, m = gains.machine, gains.machine.mass.size
    q, v, d = state[:m], state[m : 2 * m], state[2 * m : 3 * m]
    innovation, rest = work[2 * m : 3 * m], work[3 * m :]
    stiffness, tension, bend, left = rest[:2], rest[2:4], rest[4:6], rest[20:22]
    for i in range(2):
        length, free, _ = line_at(machine, i, q, along[i])
        tension[i] = measurement[2 + i]
        paid = machine.unwound[i] - machine.drum[i] * measurement[i]
        left[i] = paid + tension[i] * free / machine.rigidity[i] - length
    solve_lines(along, left, innovation)
    w, h = gains.observer, gains.interval
    z = exp(-w * h)
    for j in range(m):  # three equal poles
        q[j] += (1.0 - z**3) * innovation[j]
        v[j] += 1.5 * (1.0 - z) ** 2 * (1.0 + z) / h * innovation[j]
        d[j] += (1.0 - z) ** 3 / h**2 * innovation[j]
    for i in range(2):
        _, free, span = line_at(machine, i, q, along[i])
        stiffness[i] = machine.rigidity[i] / free
        total, own = 0.0, 0.0
        for j in range(m):
            total += (machine.frame[0, j] * v[j]) ** 2 + (machine.frame[1, j] * v[j]) ** 2
            own += along[i, j] * v[j]
        bend[i] = (total - own * own) / span


@njit
def solve_lines(along: Array, left: Array, move: Array) -> None:
    """Move of the body, shape (m,), that changes both lengths by ``left``; of one coordinate the best."""
    if move.size == 1:
        size = along[0, 0] ** 2 + along[1, 0] ** 2
        move[0] = (along[0, 0] * left[0] + along[1, 0] * left[1]) / size
        return
    scale = along[0, 0] * along[1, 1] - along[0, 1] * along[1, 0]
    move[0] = (along[1, 1] * left[0] - along[0, 1] * left[1]) / scale
    move[1] = (along[0, 0] * left[1] - along[1, 0] * left[0]) / scale


@njit
def resisting(machine: TwoMotors, j: int, speed: float) -> float:
    """Friction of the body's own motion, its sign smoothed over a millimetre or milliradian per second."""
    return machine.viscous[j] * speed + machine.coulomb[j] * tanh(1e3 * speed)


Coefficients = NDArray[np.floating[Any]]
DEVIATIONS = 5.0
"""Within which noise is taken to lie."""
_STEPS, _DECAYS = 4000, 16.0


class PlaceAnswers(NamedTuple):
    """Integrals of the answers of the place to an acceleration and to noise."""

    unexpected: float  # of the magnitude of e per a [s^2]
    tension: float  # likewise per a_e [s^2]
    place: float  # likewise per n [-]
    noisy_place: float  # root of the integral of the square, per n [s^-1/2]
    noisy_acceleration: float  # likewise per a_g [s^3/2]


def place_answers(position: float, lag: float, observer: float) -> PlaceAnswers:
    """Integrals of the answers; bandwidths of position, lags and observer [rad/s]."""
    wp, wf, wo = position, lag, observer
    lags, seen = poly.polypow([wf, 1.0], 2), poly.polypow([wo, 1.0], 3)
    loop = poly.polyadd(poly.polymul([0.0, 0.0, 1.0], lags), wf**2 * np.array([wp**2, 2.0 * wp]))
    believed = np.array([-(wo**3), wp**2 + 6.0 * wp * wo, 2.0 * wp])
    # What noise n of the place makes of place, speed and disturbance, with the weights of the feedback.
    noisy = (
        wp**2 * np.array([wo**3, 3.0 * wo**2, 3.0 * wo])
        + 2.0 * wp * np.array([0.0, wo**3, 3.0 * wo**2])
        + np.array([0.0, 0.0, wo**3])
    )
    whole = poly.polymul(loop, seen)
    slowest = float(np.abs(poly.polyroots(whole).real).min())
    time = np.linspace(0.0, _DECAYS / slowest, _STEPS)

    def magnitude(above: Coefficients, below: Coefficients) -> float:
        return float(np.trapezoid(np.abs(_impulse(above, below, time)), time))

    def energy(above: Coefficients, below: Coefficients) -> float:
        return float(np.sqrt(np.trapezoid(_impulse(above, below, time) ** 2, time)))

    return PlaceAnswers(
        unexpected=magnitude(poly.polyadd(poly.polymul(lags, seen), wf**2 * believed), whole),
        tension=magnitude(lags, loop),
        place=magnitude(wf**2 * noisy, whole),
        noisy_place=energy(wf**2 * noisy, whole),
        noisy_acceleration=energy(wf**2 * believed, whole),
    )


def _impulse(above: Coefficients, below: Coefficients, time: Array) -> Array:
    """Answer to an impulse of a transfer function, coefficients of rising powers, at equal instants."""
    from scipy.linalg import expm

    order, lead = len(below) - 1, below[-1]
    matrix = np.diag(np.ones(order - 1), 1)
    matrix[-1] = -below[:-1] / lead
    row = np.zeros(order)
    row[: len(above)] = above / lead
    return impulse_response(expm(matrix * time[1]), np.eye(order)[-1], row, len(time))


def place_bound(answers: PlaceAnswers, interval: float, largest: Array, noise: Array) -> Array:
    """Bound (m,) [m] by ``largest`` (3, m): a, a_e, rounding, and ``noise`` (2, m): n, a_g of a sample."""
    bounded = np.array(answers[:3]) @ largest
    noisy = np.hypot(answers.noisy_place * noise[0], answers.noisy_acceleration * noise[1])
    return np.asarray(bounded + DEVIATIONS * np.sqrt(interval) * noisy)
