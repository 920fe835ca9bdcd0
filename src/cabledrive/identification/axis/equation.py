"""The equation of motion of one rigid axis: rows of a regression, and a compiled observer with its shadow."""

from dataclasses import dataclass, field
from math import pi, sqrt, tanh

import numpy as np
from scipy import ndimage, signal
from scipy.integrate import cumulative_trapezoid

from cabledrive.identification import signals
from cabledrive.mechanics.compiled import njit
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

FRICTIONS = ("coulomb", "tanh", "asymmetric", "asymmetric-offset", "stribeck", "viscous")
FILTERS = ("zero-phase", "causal", "ideal")
"""Butterworth of order 4 forwards and backwards; (4.1) with damping 1; ideal."""
PRINTED_SLOPE = 0.5
"""K of (4.8) [s/rad]: wide; b and c mean something only together with it."""
DEAD_ZONE_DEVIATIONS = 2.0
SIGN_BANDWIDTHS = 2.5
"""Bandwidth of the speed whose sign is taken, in bandwidths of the regression."""
LAG = "lag"
"""Name of the column of the time by which the torque acts later than it is logged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionModel:
    """Which friction is fitted."""

    kind: str = "coulomb"  # one of `FRICTIONS`
    slope: float = PRINTED_SLOPE  # K of c tanh(K w) [s/rad]
    fading: float = 0.0  # speed at which the excess of Stribeck friction has fallen to 1/e [rad/s]

    def __post_init__(self) -> None:
        if self.kind not in FRICTIONS:
            raise InputRefused(f'friction "{self.kind}" is unknown: take one of {", ".join(FRICTIONS)}')

    def columns(self, speed: Array, sign: Array, offset: str) -> dict[str, Array]:
        r"""Regressors beside the acceleration, by their parameter, Eqs. (4.8), (4.11), (4.12).

        .. math:: \tau = J\ddot\theta + b\dot\theta + c\,S(\dot\theta) - d

        ``sign``: direction of the speed [rad/s], both (samples,); ``offset``: name of the parameter whose
        regressor is -1, as in (4.9).
        """
        plain = {"viscous_friction": speed, "coulomb_friction": sign, offset: np.full_like(speed, -1.0)}
        if self.kind == "coulomb":
            return plain
        if self.kind == "viscous":
            return {"viscous_friction": speed, offset: plain[offset]}
        if self.kind == "tanh":
            return plain | {"coulomb_friction": np.tanh(self.slope * speed)}
        if self.kind == "stribeck":
            return plain | {"stribeck_friction": sign * np.exp(-((speed / self.fading) ** 2))}
        sides = {
            "viscous_friction_positive": np.where(speed > 0.0, speed, 0.0),
            "coulomb_friction_positive": np.maximum(sign, 0.0),
            "viscous_friction_negative": np.where(speed < 0.0, speed, 0.0),
            "coulomb_friction_negative": np.minimum(sign, 0.0),
        }
        return sides | {offset: plain[offset]} if self.kind == "asymmetric-offset" else sides


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisEquation:
    """How the regression of one axis is formed."""

    linear: bool  # whether the axis slides (mass, force) instead of turning (inertia, torque)
    bandwidth: float  # of the filter on both sides [Hz]
    filter: str = "zero-phase"  # one of `FILTERS`
    friction: FrictionModel = field(default_factory=FrictionModel)
    quantum: float = 0.0  # step of the position [rad or m]; 0: none
    kink: float = 0.0  # friction over inertia [rad/s^2 or m/s^2]: half the acceleration's jump at a turn
    lag: bool = False  # whether the rate of the torque is the last column, see `axis.timing`

    def __post_init__(self) -> None:
        if self.filter not in FILTERS:
            raise InputRefused(f'filter "{self.filter}" is unknown: take one of {", ".join(FILTERS)}')

    @property
    def offset(self) -> str:
        """Name of the constant torque or force."""
        return "offset_force" if self.linear else "offset_torque"

    @property
    def inertia(self) -> str:
        """Name of the inertia."""
        return "mass" if self.linear else "inertia"

    def filtered(self, values: Array, interval: float) -> Array:
        """One signal (samples,) through the filter of the regression, Eqs. (4.4), (4.5)."""
        if self.filter == "causal":
            return signals.causal_filter(values, interval, self.bandwidth)[0]
        if self.filter == "ideal":
            return signals.ideal_low_pass(values, interval, self.bandwidth)
        return signals.zero_phase(values, interval, self.bandwidth)

    def motion(self, position: Array, interval: float) -> tuple[Array, Array]:
        """Filtered speed and acceleration (samples,)."""
        if self.filter == "causal":
            _, speed, acceleration = signals.causal_filter(position, interval, self.bandwidth)
            return speed, acceleration
        speed = signals.difference(self.filtered(position, interval), interval)
        return speed, signals.difference(speed, interval)

    def sign_band(self, interval: float) -> float:
        """Bandwidth of the speed whose sign makes the friction [Hz]."""
        return min(SIGN_BANDWIDTHS * self.bandwidth, 0.4 / interval)

    def quick_speed(self, position: Array, interval: float) -> Array:
        """Speed whose sign makes the friction: quicker than the regression's, and with its kinks kept.

        A smoothed kink would show every turn too late: the motion that friction alone makes is taken away
        first, and put back afterwards.
        """
        band = self.sign_band(interval)
        speed = signals.difference(signals.zero_phase(position, interval, band), interval)
        if self.kink <= 0.0:
            return speed
        by_friction = cumulative_trapezoid(-self.kink * np.sign(speed), dx=interval, initial=0.0)
        moved = cumulative_trapezoid(by_friction, dx=interval, initial=0.0)
        smooth = signals.zero_phase(position - moved, interval, band)
        return signals.difference(smooth, interval) + by_friction

    def columns(
        self, position: Array, torque: Array, interval: float
    ) -> tuple[dict[str, Array], Array, Array]:
        """Regressors by their parameter, left side and speed (samples,), Eqs. (4.9), (4.10)."""
        speed, acceleration = self.motion(position, interval)
        quick, band = self.quick_speed(position, interval), self.sign_band(interval)
        zone = 0.0
        if self.quantum > 0.0 and not self.friction.kind.startswith("asymmetric"):
            # twice the deviation of the speed that the encoder's rounding makes
            sections = signals.butterworth(interval, band)
            frequency, response = signal.freqz_sos(sections, worN=2048, fs=1 / interval)
            gain = np.abs(response) ** 2 * 2 * pi * frequency
            zone = DEAD_ZONE_DEVIATIONS * self.quantum / sqrt(12) * float(np.sqrt(np.mean(gain**2)))
        sign = direction_of(quick, zone, int(0.5 / (band * interval)))
        found = {self.inertia: acceleration}
        for name, column in self.friction.columns(quick, sign, self.offset).items():
            if name == "viscous_friction":
                found[name] = speed
            else:
                found[name] = column if np.ptp(column) == 0.0 else self.filtered(column, interval)
        left = self.filtered(torque, interval)
        return found | ({LAG: signals.difference(left, interval)} if self.lag else {}), left, speed


def direction_of(speed: Array, zone: float, shortest: int = 1) -> Array:
    """Sign of the speed, zero while it rests inside the dead zone for so many samples at least."""
    inside = ndimage.binary_opening(np.abs(speed) <= zone, np.ones(max(1, shortest)))
    return np.where(inside, 0.0, np.sign(speed))


def settling(bandwidth: float, interval: float) -> int:
    """Samples at each end that a filter of a bandwidth [Hz] has not settled for."""
    return int(np.ceil(2.0 / (bandwidth * interval)))


SPARE = 1.2
"""Half gaps at which a load that was left meets the same side again: less is noise of the speed."""


@njit
def one_sample(p: Array, v: float, u: float, h: float) -> tuple[float, float, float, float, float]:
    """Speed at the end, angle gone through, mean acceleration, direction, and jump of a sensitivity.

    ``p`` holds inertia, viscous and Coulomb friction, offset, and the slope K of a smooth friction
    c tanh(K w), 0 where it jumps; the torque ``u`` stands. Where friction jumps, the speed that turns is
    followed to its zero; there the axis sticks (direction and jump 0) or goes on. A smooth friction has the
    direction tanh(K w), and the jump holds what it takes from a sensitivity.
    """
    load = u + p[3]
    if p[4] > 0.0:
        side = tanh(p[4] * v)
        falls = 0.5 * h * (p[1] + p[2] * p[4] * (1.0 - side * side)) / p[0]
        a = (load - side * p[2] - p[1] * v) / p[0] / (1.0 + falls)
        kept = (1.0 - falls) / (1.0 + falls) / (1.0 - h * p[1] / p[0])
        return v + h * a, h * (v + 0.5 * h * a), a, tanh(p[4] * (v + 0.5 * h * a)), kept
    side = 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
    if side == 0.0:
        if abs(load) <= p[2]:
            return 0.0, 0.0, 0.0, 0.0, 0.0
        side = 1.0 if load > 0.0 else -1.0
        a = (load - side * p[2]) / p[0]
        a -= 0.5 * h * a * p[1] / p[0]
        return h * a, 0.5 * h * h * a, a, side, 1.0
    a = (load - side * p[2] - p[1] * v) / p[0]
    a -= 0.5 * h * a * p[1] / p[0]
    end = v + h * a
    if end * side >= 0.0:
        return end, h * (v + 0.5 * h * a), a, side, 1.0
    first = -v / a
    gone = 0.5 * first * v
    if abs(load) <= p[2]:
        return 0.0, gone, -v / h, 0.0, 0.0
    other = 1.0 if load > 0.0 else -1.0
    after = (load - other * p[2]) / p[0]
    rest = h - first
    return rest * after, gone + 0.5 * rest * rest * after, (rest * after - v) / h, other, after / a


@njit
def observe(p: Array, gains: Array, torque: Array, angle: Array, start: Array, out: Array) -> None:
    """Innovation, predicted speed, acceleration, direction and jump of a sensitivity at every sample.

    ``torque[k]`` stands from sample k to the next; ``gains`` correct angle and speed by the innovation, the
    third of them is the interval. ``out`` has the rows innovation, speed, acceleration, direction, jump.
    """
    x, v, h = start[0], start[1], gains[2]
    for k in range(angle.size):
        e = angle[k] - x
        x += gains[0] * e
        v += gains[1] * e
        end, gone, a, side, jump = one_sample(p, v, torque[k], h)
        out[0, k] = e
        out[1, k] = v
        out[2, k] = a
        out[3, k] = side
        out[4, k] = jump
        x += gone
        v = end


@njit
def answers(p: Array, gains: Array, torques: Array, jump: Array, out: Array) -> None:
    """What small disturbing torques would add to the predicted angle, both of shape (m, samples)."""
    h = gains[2]
    decay = 1.0 - h * p[1] / p[0]
    for c in range(torques.shape[0]):
        x, v = 0.0, 0.0
        for k in range(jump.size):
            out[c, k] = x
            v -= gains[1] * x
            x -= gains[0] * x
            if jump[k] == 0.0:
                x += 0.5 * h * v
                v = 0.0
            else:
                new = jump[k] * decay * v + h * torques[c, k] / p[0]
                x += 0.5 * h * (v + new)
                v = new


@njit
def loosen(net: Array, speed: Array, gap: float, h: float, contact: int, added: Array) -> None:
    """Torque that backlash adds: all that accelerates an axis while its load is loose, then its return.

    The load coasts until the play ends and is left again where the motor is accelerated away from it; what
    the motor alone got is taken back over ``contact`` samples.
    """
    added[:] = 0.0
    apart, load, side, last, surplus = 0.0, 0.0, 0.0, 1.0, 0.0
    half = 0.5 * gap
    for k in range(net.size):
        if side != 0.0 and side * net[k] < 0.0:
            side, load, surplus = 0.0, speed[k], 0.0
        if side == 0.0:
            added[k] += net[k]
            surplus += net[k]
            apart += h * (speed[k] - load)
            if -last * apart >= half or last * apart > SPARE * half:
                side = 1.0 if apart > 0.0 else -1.0
                last = side
                apart = side * half
                for later in range(k + 1, min(k + 1 + contact, net.size)):
                    added[later] -= surplus / contact


@njit
def shadow(p: Array, gains: Array, torque: Array, angle: Array, speed: Array, out: Array) -> None:
    """A rigid axis under the torque and a soft servo along the angle: where it goes, and what acts on it.

    ``gains`` are torque per angle and torque per speed, and the interval; ``out``: angle and torque.
    """
    x, v = angle[0], speed[0]
    for k in range(angle.size):
        out[0, k] = x
        out[1, k] = torque[k] + gains[0] * (angle[k] - x) + gains[1] * (speed[k] - v)
        end, gone, _a, _side, _jump = one_sample(p, v, out[1, k], gains[2])
        x += gone
        v = end
