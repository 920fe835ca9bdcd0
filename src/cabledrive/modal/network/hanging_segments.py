r"""Hanging ropes in segments: polynomials whose inner ones are condensed to modes between held ends.

On each segment u and w of Eq. (N.13) are polynomials of degree P. With the motion of the ends at rest, and
the modes :math:`\phi_j` between held ends, of frequencies :math:`\omega_j` and inertia :math:`m_j` against
the former,

.. math:: E(\omega) = K - \omega^2 M - \sum \frac{\omega^4\,m_j m_j^T}{\omega_j^2 - \omega^2},
          \qquad \text{Eq. (N.14)}

as Craig and Bampton (1968). On so short segments what the polynomials leave out is round-off.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import ceil, log
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial, legendre
from numpy.typing import NDArray

from cabledrive.mechanics.network.hanging import HangingElement
from cabledrive.mechanics.network.motion import Array
from cabledrive.mechanics.tensioned_beam import wave_numbers
from cabledrive.modal.network.elastic_links import ElasticLink
from cabledrive.modal.network.segments import LONGEST_PHASE, Segments, joined

DEGREE = 11
"""Of the polynomials."""

_ROUND_OFF = 1e-16

STEEPER = 2.0
"""Ratio of the tensions at the ends of a segment, at most."""

LAYER = 4.0
"""Length of the segment at the end of a beam over sqrt(EI/T); each further one is twice as long."""


class Shapes(NamedTuple):
    """Polynomials on -1..1 at the points of a Gauss rule; those of the ends first.

    Attributes
    ----------
    along, along_rate : ndarray, shape (points, n)
        Motion along, and its derivative.
    across, across_rate, across_bend : ndarray, shape (points, n)
        Motion across, and its derivatives.
    """

    along: Array
    along_rate: Array
    across: Array
    across_rate: Array
    across_bend: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class HangingSegments(Segments):
    """Segments of hanging ropes.

    Attributes
    ----------
    strain : ndarray, shape (p, 2 unknowns, 2 unknowns)
        Its square is K of Eq. (N.14) [N/m]; without it, slow motions of stiff ropes were lost in round-off.
    mass : ndarray, shape (p, 2 unknowns, 2 unknowns)
        M [kg].
    square : ndarray, shape (p, i)
        Squares of the frequencies between held ends [1/s^2].
    inertia : ndarray, shape (p, i, 2 unknowns)
        m_j [kg^1/2].
    waves : ndarray, shape (p, n, 2 unknowns + i)
        Polynomials of the motion of the ends at rest, and of the modes between held ends.
    across : ndarray, shape (p, 2 unknowns + i, 2 unknowns + i)
        Four times the work of the forces across the chord, as a form of the same; that along it is the rest.
    """

    strain: Array
    mass: Array
    square: Array
    inertia: Array
    waves: Array
    across: Array

    def stiffness(self, omega: complex) -> NDArray[Any]:
        """Eq. (N.14)."""
        square = omega**2
        give = square**2 / (self.square - square)
        inner = _products(self.inertia, give[:, :, None] * self.inertia)
        rest = _products(self.strain, self.strain)
        return np.asarray(rest - square * self.mass - inner)

    def forms(self, omega: float, moved: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """As of `Segments`, by squares."""
        strained = self.strain @ moved
        inertia = self.inertia @ moved
        rest, whole = _products(strained, strained), _products(moved, self.mass @ moved)
        give = omega**2 / (self.square - omega**2)
        first = _products(inertia, give[:, :, None] * inertia)
        second = _products(inertia, (give**2)[:, :, None] * inertia)
        energy = rest / omega - omega * whole - omega * first
        rate = rest / omega**2 + whole + 3.0 * first + 2.0 * second
        ropes = self.ropes[:, None, None]
        return ropes * energy, ropes * rate

    def inside(
        self, own: NDArray[np.intp], omega: float, ends: NDArray[Any], share: Array, way: int
    ) -> NDArray[Any]:
        """By the polynomials."""
        k = self.links[0].unknowns
        values = polynomials(2.0 * share - 1.0, k == 3)
        rows = values.across if way else values.along
        motion = self._with_inner(omega, ends[:, :, None], own)[:, :, 0]
        return np.asarray(np.einsum("qn,qnm,qm->q", rows, self.waves[own], motion))

    def energies(self, omega: float, x: NDArray[Any]) -> tuple[Array, float]:
        """As of `Segments`; along and across apart by the work that is done in each direction."""
        total, kinetic = super().energies(omega, x)
        motion = self._with_inner(omega, self.ends(x), np.arange(self.square.shape[0]))
        work = np.einsum("pik,pij,pjk->p", motion.conj(), self.across, motion).real / x.shape[1] * self.ropes
        across = np.add.reduceat(work, self.first[:-1])
        return np.stack((total - across, across), -1).ravel(), kinetic

    def _with_inner(self, omega: float, ends: NDArray[Any], own: NDArray[np.intp]) -> NDArray[Any]:
        """Motion of the ends and of the modes between held ends, shape (q, 2 unknowns + i, k)."""
        give = omega**2 / (self.square[own] - omega**2)
        inner = give[:, :, None] * np.einsum("qja,qak->qjk", self.inertia[own], ends)
        return np.concatenate((ends, inner), axis=1)


def _products(near: NDArray[Any], far: NDArray[Any]) -> NDArray[Any]:
    """Products of the columns of two arrays of shape (p, i, k), shape (p, k, k)."""
    return np.asarray(near.conj().swapaxes(1, 2) @ far)


def hanging_segments(
    links: Sequence[ElasticLink], octaves: Sequence[int], first: int
) -> tuple[HangingSegments, int]:
    """Hanging ropes in segments; parameters as of `cabledrive.modal.network.cutting.segments_of`."""
    elements = [_hanging(link) for link in links]
    places = [cut_places(own, number) for own, number in zip(elements, octaves, strict=True)]
    common, after = joined(links, places, first)
    parts = [_segments(own, ends) for own, ends in zip(elements, places, strict=True)]
    whole: dict[str, Any] = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return HangingSegments(**common, **whole), after


def _hanging(link: ElasticLink) -> HangingElement:
    assert isinstance(link.element, HangingElement)
    return link.element


def cut_places(own: HangingElement, octave: int) -> Array:
    """Ends of the segments as shares of the element, up to 2^octave rad of phase."""
    marks = {0.0, 1.0}
    length = LAYER * own.bending_length
    while own.bending and length < 0.5 * own.length:
        marks |= {length / own.length, 1.0 - length / own.length}
        length = 2.0 * length + LAYER * own.bending_length
    near, far = own.tension_at(np.array([0.0, own.length])).tolist()
    steps = ceil(abs(log(far / near)) / log(STEEPER))
    for i in range(1, steps):
        marks.add((near * (far / near) ** (i / steps) - near) / (far - near))
    top, density = own.frequency(2.0**octave), own.density / own.stretch
    number = top * np.sqrt(density / min(near, far))
    if own.bending:
        number = float(wave_numbers(top, own.bending, min(near, far), density)[0])
    found = []
    for a, b in pairwise(sorted(marks)):
        count = max(1, ceil(number * own.length * (b - a) / LONGEST_PHASE))
        found.append(a + (b - a) * np.arange(count) / count)
    return np.concatenate((*found, [1.0]))


def _segments(own: HangingElement, places: Array) -> dict[str, Any]:
    """What `HangingSegments` hold of one element."""
    k, lengths = own.motions, own.length * np.diff(places)
    nodes, weights, shapes = _gauss(k == 3)
    x = own.length * places[:-1, None] + 0.5 * lengths[:, None] * (1.0 + nodes)
    tension, slope = own.tension_at(x), own.slope(x)[:, :, None]
    turn = 2.0 / lengths[:, None, None] * shapes.across_rate
    tilt = slope * turn
    stretch = 2.0 / lengths[:, None, None] * shapes.along_rate + tilt
    measure = 0.5 * lengths[:, None] * weights
    # Along the rope it is shorter by the lift-off, across it is longer: each has its own length.
    longer = own.length / own.along
    pull = np.sqrt(measure * own.axial_rigidity * own.stretch * longer)[:, :, None]
    hold = np.sqrt(measure * tension * own.stretch / (1.0 + tension / own.axial_rigidity))[:, :, None]
    strains = [pull * stretch, hold * turn]
    if own.bending:
        bend = (2.0 / lengths[:, None, None]) ** 2 * shapes.across_bend
        strains.append(np.sqrt(measure * own.bending)[:, :, None] * bend)
    fields = np.concatenate(strains, axis=1)
    density = np.sqrt(measure * own.density / own.stretch)[:, :, None]
    moved = np.concatenate((density * shapes.along / np.sqrt(longer), density * shapes.across), axis=1)
    taut = fields[:, nodes.size :]
    mixed = _products(pull * stretch, pull * tilt)
    across = _products(taut, taut) + 0.5 * (mixed + mixed.swapaxes(1, 2))
    return _condensed(fields, _products(moved, moved), across, lengths, 2 * k)


def _condensed(fields: Array, mass: Array, across: Array, lengths: Array, ends: int) -> dict[str, Any]:
    """The motion of the ends at rest, and modes between held ends, of polynomials.

    ``fields``, shape (p, points, n): strains whose square is the stiffness; ``mass``, ``across``, shape
    (p, n, n): inertia, and twice the work across; ``ends``: polynomials of the ends.
    """
    inner = slice(ends, mass.shape[1])
    # Inertia over stiffness: slow waves across keep their digits beside fast ones along the rope.
    turned, factor = np.linalg.qr(fields[:, :, inner])
    inverse = np.linalg.inv(factor)
    reduced = inverse.swapaxes(1, 2) @ mass[:, inner, inner] @ inverse
    give, vectors = np.linalg.eigh(0.5 * (reduced + reduced.swapaxes(1, 2)))
    give = np.maximum(give, _ROUND_OFF * give[:, -1:])
    waves = np.zeros_like(mass)
    waves[:, :ends, :ends] = np.eye(ends)
    waves[:, inner, :ends] = -inverse @ (turned.swapaxes(1, 2) @ fields[:, :, :ends])
    waves[:, inner, ends:] = inverse @ vectors / np.sqrt(give)[:, None, :]
    if ends == 6:  # the polynomials count slopes times the length
        waves[:, :, [2, 5]] *= lengths[:, None, None]
    whole = _products(waves, mass @ waves)
    return {
        "strain": np.linalg.qr(fields @ waves[:, :, :ends], mode="r"),
        "mass": whole[:, :ends, :ends],
        "square": 1.0 / give,
        "inertia": whole[:, inner, :ends],
        "waves": waves,
        "across": 2.0 * _products(waves, across @ waves),
    }


@cache
def _bases(beam: bool) -> tuple[list[Polynomial], ...]:
    """Polynomials on -1..1 by the fields of `Shapes`; those of the ends in the order of their motions."""
    zero = Polynomial([0.0])
    near, far = Polynomial([0.5, -0.5]), Polynomial([0.5, 0.5])
    bubbles = [legendre.Legendre.basis(k).integ(lbnd=-1).convert(kind=Polynomial) for k in range(1, DEGREE)]
    bubbles = [own * np.sqrt(k + 0.5) for k, own in enumerate(bubbles, 1)]
    none = [zero] * len(bubbles)
    if not beam:
        along = [near, zero, far, zero, *bubbles, *none]
        return _with_rates(along, [zero, near, zero, far, *none, *bubbles])
    held = [(own * np.sqrt(k + 0.5)) for k, own in enumerate(_twice_held(), 2)]
    ends = [
        Polynomial([0.5, -0.75, 0.0, 0.25]),
        Polynomial([0.25, -0.25, -0.25, 0.25]) * 0.5,  # slope times the length, which is 2 here
        Polynomial([0.5, 0.75, 0.0, -0.25]),
        Polynomial([-0.25, -0.25, 0.25, 0.25]) * 0.5,
    ]
    along = [near, zero, zero, far, zero, zero, *bubbles, *[zero] * len(held)]
    return _with_rates(along, [zero, *ends[:2], zero, *ends[2:], *none, *held])


def _with_rates(along: list[Polynomial], across: list[Polynomial]) -> tuple[list[Polynomial], ...]:
    """Polynomials with their derivatives, by the fields of `Shapes`."""
    rates = [[own.deriv(order) for own in across] for order in (1, 2)]
    return along, [own.deriv() for own in along], across, *rates


def _twice_held() -> list[Polynomial]:
    """Polynomials without displacement and slope at both ends: Legendre's, integrated twice."""
    found = []
    for k in range(2, DEGREE - 1):
        once = legendre.Legendre.basis(k).integ(lbnd=-1)
        found.append(once.integ(lbnd=-1).convert(kind=Polynomial))
    return found


def polynomials(places: Array, beam: bool) -> Shapes:
    """All polynomials at places on -1..1, shape (q,)."""
    return Shapes(*(np.stack([own(places) for own in part], axis=-1) for part in _bases(beam)))


@cache
def _gauss(beam: bool) -> tuple[Array, Array, Shapes]:
    """Points and weights of the Gauss rule over a segment, and all polynomials at the points."""
    nodes, weights = legendre.leggauss(DEGREE + 6)
    return nodes, weights, polynomials(nodes, beam)
