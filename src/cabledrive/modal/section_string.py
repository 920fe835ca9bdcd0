r"""Transverse modes of one section under its tension at rest, counted by the phase of the wave.

From the held start the wave turns by the angle :math:`\Phi(\omega)` of :math:`(\sigma z, q)`, piece by piece
and at every hanging mass. It grows with the frequency; the end is at rest where it is a whole number of half
turns. Hence, by Sturm's oscillation theorem,

.. math:: J(\omega) = \lfloor\Phi(\omega)/\pi\rfloor

modes lie below :math:`\omega`: the count of Wittrick and Williams, with the phases of the pieces and the
signs of the joints in one number.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from math import atan2, ceil, floor, hypot, log2, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.heavy_string import StringPieces, displacement_series, string_pieces, transfer
from cabledrive.mechanics.rest import RestingSection

Array = NDArray[np.float64]

LEAST_PHASE = 8.0
"""Phase up to which the first pieces of a string serve [rad]: its first two modes, and counts below them."""
_QUICK_STEPS = 6


@dataclass(frozen=True, slots=True, eq=False)
class SectionMotion:
    """Motion of one section across: waves from the start of each piece, and a part that is constant on it.

    Attributes
    ----------
    pieces : StringPieces
    omega : float
        [rad/s].
    waves : ndarray, shape (2, n)
        Displacement and transverse force of the waves at the start of each piece.
    shift : ndarray, shape (n,)
        Displacement common to the whole piece.
    """

    pieces: StringPieces
    omega: float
    waves: Array
    shift: Array

    def inside(self, shares: Array) -> Array:
        """Displacement inside the pieces.

        ``shares``, shape (p,): places as shares of the piece.
        Returns shape (n, p).
        """
        series = displacement_series(self.pieces, self.omega, self.waves)
        powers = np.asarray(shares)[None, :] ** np.arange(series.shape[0])[:, None]
        return np.asarray(series.T @ powers + self.shift[:, None])

    def at(self, positions: Array) -> Array:
        """Displacement at positions of the section.

        ``positions``, shape (p,): unstretched, from the pulley where the span starts [m].
        Returns shape (p,).
        """
        pieces = self.pieces
        piece = np.clip(np.searchsorted(pieces.start, positions, "right") - 1, 0, pieces.start.size - 1)
        share = (positions - pieces.start[piece]) / pieces.length[piece]
        series = displacement_series(pieces, self.omega, self.waves)[:, piece]
        powers = share[None, :] ** np.arange(series.shape[0])[:, None]
        return np.asarray(np.sum(series * powers, axis=0) + self.shift[piece])

    def scaled(self, factor: float) -> "SectionMotion":
        """The same motion, larger."""
        return SectionMotion(self.pieces, self.omega, factor * self.waves, factor * self.shift)

    @property
    def starts(self) -> Array:
        """Displacement at the start of each piece."""
        return np.asarray(self.waves[0] + self.shift)

    @property
    def mass(self) -> float:
        """Modal mass [kg] per square of the displacement's unit."""
        return self.product(self)

    def product(self, other: "SectionMotion") -> float:
        """Integral of two motions over the mass, the cable's by quadrature of the exact shapes.

        ``other``: on the same pieces.
        Returns [kg] times both units of displacement.
        """
        places, weights = _quadrature()
        here = self.inside((places + 1.0) / 2.0)
        there = here if other is self else other.inside((places + 1.0) / 2.0)
        cable = self.pieces.density * float(self.pieces.length @ ((here * there) @ weights)) / 2.0
        return cable + float(self.pieces.mass[:-1] @ (self.starts[1:] * other.starts[1:]))


@cache
def _quadrature() -> tuple[Array, Array]:
    """Places and weights of Gauss' rule of twelve points over -1 to 1 [-], shape (12,) each."""
    places, weights = np.polynomial.legendre.leggauss(12)
    return places, weights


def combined(motions: list[SectionMotion], factors: Array) -> SectionMotion:
    """Sum of motions of one section at one frequency.

    ``factors``: one for each.
    """
    waves = sum(factor * motion.waves for factor, motion in zip(factors, motions, strict=True))
    shift = sum(factor * motion.shift for factor, motion in zip(factors, motions, strict=True))
    return SectionMotion(motions[0].pieces, motions[0].omega, np.asarray(waves), np.asarray(shift))


class SectionString:
    """A section of cable as a string under its own tension.

    Parameters
    ----------
    section : RestingSection
        Taut everywhere.
    masses : ndarray, shape (stretches - 1,)
        What hangs between its stretches [kg].
    density : float
        Mass per unstretched length [kg/m].
    """

    def __init__(self, section: RestingSection, masses: Array, density: float) -> None:
        self.section, self.masses, self.density = section, masses, density
        self._pieces: dict[int, StringPieces] = {}
        self._found: dict[float, float] = {}

    @cached_property
    def travel_time(self) -> float:
        """Time that a wave takes from end to end [s]."""
        return sqrt(self.density) * sum(stretch.travel_time for stretch in self.section.stretches)

    def pieces(self, omega: float) -> StringPieces:
        """The string in pieces that serve up to a frequency.

        ``omega`` [rad/s].
        """
        octave = ceil(2.0 * log2(max(omega * self.travel_time, LEAST_PHASE)))
        if octave not in self._pieces:
            top = 2.0 ** (octave / 2.0) / self.travel_time
            masses = np.append(self.masses, 0.0)
            self._pieces[octave] = string_pieces(self.section.stretches, masses, self.density, top)
        return self._pieces[octave]

    def phase(self, omega: float) -> float:
        """Angle by which the wave turns from end to end, growing with the frequency.

        ``omega`` [rad/s].
        Returns [rad].
        """
        pieces = self.pieces(omega)
        waves = transfer(pieces, omega)
        scale = omega * sqrt(self.density * float(pieces.tension[0].mean()))
        angle, z, q = 0.0, 0.0, 1.0
        columns = (waves.near, waves.give, waves.inertia, waves.far, omega**2 * pieces.mass)
        for near, give, inertia, far, mass in zip(*(column.tolist() for column in columns), strict=True):
            z, q = z + near * z + give * q, inertia * z + q + far * q
            angle = _lifted(atan2(scale * z, q), angle)
            if mass:
                q -= mass * z
                angle = _lifted(atan2(scale * z, q), angle)
            size = hypot(scale * z, q)
            z, q = z / size, q / size
        return angle

    def count(self, omega: float) -> int:
        """Modes below a frequency in one plane, Eq. (M.12).

        ``omega`` [rad/s].
        """
        return floor(self.phase(omega) / pi) if omega > 0.0 else 0

    def frequency(self, number: float) -> float:
        """One natural frequency; between two of them for a number that is not whole.

        ``number``: from 1.
        Returns [rad/s].
        """
        if number in self._found:
            return self._found[number]
        target, omega = number * pi, number * pi / self.travel_time
        if number - 1 in self._found:  # its neighbour lies as far from a uniform string
            omega += self._found[number - 1] - (number - 1) * pi / self.travel_time
        for _ in range(_QUICK_STEPS):  # without masses the phase is all but omega times the travel time
            step = (target - self.phase(omega)) / self.travel_time
            omega += step
            if abs(step) <= 1e-14 * omega:
                break
        else:
            omega = self._bracketed(target)
        self._found[number] = omega
        return omega

    def _bracketed(self, target: float) -> float:
        from scipy.optimize import brentq

        high = target / self.travel_time * (1.0 + 1e-3)  # a mass lowers it, a gradient hardly changes it
        while self.phase(high) < target:
            high *= 1.1
        low = 0.98 * high
        while self.phase(low) >= target:
            low /= 2.0
        return float(brentq(lambda omega: self.phase(omega) - target, low, high, xtol=1e-300, rtol=1e-15))

    def motion(self, omega: float) -> "SectionMotion":
        """Motion at a natural frequency, of unit modal mass.

        ``omega`` [rad/s].
        """
        pieces = self.pieces(omega)
        waves = transfer(pieces, omega)
        motion = np.zeros((2, pieces.length.size))
        z, q = 0.0, 1.0
        for i in range(pieces.length.size):
            motion[:, i] = z, q
            z, q = (
                z + waves.near[i] * z + waves.give[i] * q,
                waves.inertia[i] * z + q + waves.far[i] * q,
            )
            q -= omega**2 * pieces.mass[i] * z
        found = SectionMotion(pieces, omega, motion, np.zeros(motion.shape[1]))
        return found.scaled(1.0 / sqrt(found.mass))


def _lifted(angle: float, last: float) -> float:
    """The angle next above the last one; a step back by round-off is none."""
    step = (angle - last) % (2.0 * pi)
    return last + (step if step < 2.0 * pi - 1e-9 else 0.0)
