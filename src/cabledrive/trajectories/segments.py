"""Reference motions: moves and rests one after another, with every derivative in closed form."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.trajectories.limits import check_order, derivative_jump, peak_factor, smooth_rise

SHORTEST_RISE = 1e-9
"""Below it powers of the rise time leave the range of a double [s]."""
MOST_PULSES = 10_000


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """A smooth move from rest to rest."""

    start: float = meaning("when it begins [s]")
    duration: float = meaning("how long it takes [s]")
    distance: float = meaning("how far it goes, signed [rad or m]")


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """Moves one after another, with rests between them."""

    moves: tuple[Move, ...] = meaning("in order of time, not overlapping")
    duration: float = meaning("whole length, rests included [s]")
    order: int = meaning(
        "odd order of the rise; its (order - 1) / 2 first derivatives rest at both ends of each move", 9
    )
    initial: float = meaning("where it begins [rad or m]", 0.0)

    def __post_init__(self) -> None:
        check_order(self.order)

    def __call__(self, time: Array, derivatives: int = 0) -> Array:
        """Position and derivatives.

        Parameters
        ----------
        time : array_like, shape (p,)
            Instants [s].
        derivatives : int, default 0
            Highest derivative wanted.

        Returns
        -------
        ndarray, shape (derivatives + 1, p)
            In rad (or m), per s, per s^2 and so on.
        """
        time = np.asarray(time, dtype=float)
        out = np.zeros((derivatives + 1, time.size))
        out[0] = self.initial
        for move in self.moves:
            rise = smooth_rise((time - move.start) / move.duration, self.order, derivatives)
            out += move.distance * rise / move.duration ** np.arange(derivatives + 1)[:, None]
        return out

    def peak(self, derivative: int) -> float:
        """Largest absolute value of a derivative over the whole motion.

        Parameters
        ----------
        derivative : int
            1: speed, 2: acceleration, and so on.

        Returns
        -------
        float
            In rad (or m) per s to that power.
        """
        factor = peak_factor(self.order, derivative)
        return max((factor * abs(m.distance) / m.duration**derivative for m in self.moves), default=0.0)

    @property
    def jump(self) -> float:
        """Largest jump of derivative number (order + 1) / 2, the first that does not rest at the ends."""
        n = check_order(self.order)
        factor = derivative_jump(self.order)
        return max((factor * abs(m.distance) / m.duration ** (n + 1) for m in self.moves), default=0.0)


def pulse(angle: float, rise: float, dwell: float, *, pulses: int = 1, order: int = 9) -> Trajectory:
    """Rotate there, rest, rotate back, rest, Eq. (6.8); any number of times.

    Parameters
    ----------
    angle : float
        Amplitude theta_f [rad].
    rise : float
        Rise time t_f [s].
    dwell : float
        Rest after each move, Delta t [s].
    pulses : int, default 1
        How many.
    order : int, default 9
        Odd order of the rise.

    Returns
    -------
    Trajectory
        Of duration ``2 pulses (rise + dwell)``.

    Raises
    ------
    InputRefused
        If a time is not positive (the dwell: negative), the angle not finite, or there is no pulse.
    """
    if pulses < 1:
        raise InputRefused(f"pulses = {pulses} must be at least 1: ask for one")
    if pulses > MOST_PULSES:
        raise InputRefused(f"pulses = {pulses} are too many, {MOST_PULSES} at most: ask for fewer")
    positions = [angle, 0.0] * pulses
    return waypoints([0.0, *positions], rise=rise, dwell=dwell, order=order)


def waypoints(
    positions: Sequence[float],
    *,
    rise: float | Sequence[float],
    dwell: float | Sequence[float],
    order: int = 9,
) -> Trajectory:
    """Visit positions one after another, resting at each.

    Parameters
    ----------
    positions : sequence of float, length n + 1
        Where to start, and where to go [rad or m].
    rise : float or sequence of float, length n
        Duration of each move [s].
    dwell : float or sequence of float, length n
        Rest after each move [s].
    order : int, default 9
        Odd order of the rise.

    Returns
    -------
    Trajectory

    Raises
    ------
    InputRefused
        If there is no move, a time is not positive (a dwell: negative), or a number is not finite.
    """
    steps = len(positions) - 1
    if steps < 1:
        raise InputRefused(
            f"positions: {len(positions)} given, at least 2 are needed: the start and one to go to"
        )
    rises, dwells = _per_move(rise, steps, "rise"), _per_move(dwell, steps, "dwell")
    bounds = {
        "rise": (rises, SHORTEST_RISE, "above 0, a nanosecond at least"),
        "dwell": (dwells, 0.0, "not below 0"),
    }
    for name, (values, least, words) in bounds.items():
        wrong = [v for v in values if not isfinite(v) or v < least]
        if wrong:
            raise InputRefused(
                f"{name} = {wrong[0]:.9g} s must be finite and {words}: give a time in seconds"
            )
    if not all(isfinite(position) for position in positions):
        raise InputRefused("positions must be finite: give numbers in rad or m")
    moves, time = [], 0.0
    for here, there, duration, rest in zip(positions, positions[1:], rises, dwells, strict=False):
        moves.append(Move(start=time, duration=duration, distance=there - here))
        time += duration + rest
    return Trajectory(moves=tuple(moves), duration=time, order=order, initial=float(positions[0]))


def _per_move(value: float | Sequence[float], moves: int, name: str) -> list[float]:
    values = [float(value)] * moves if isinstance(value, (int, float)) else [float(v) for v in value]
    if len(values) != moves:
        raise InputRefused(f"{name}: {len(values)} values for {moves} moves: give one, or one for each move")
    return values
