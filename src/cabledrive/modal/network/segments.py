r"""Heavy strings and tensioned beams of a component, cut into segments that have no mode of their own.

Each segment has an exact stiffness E of its ends, two rows of a string, four of a beam. The joints between
segments are coordinates of the component; up to the frequency for which they were cut no segment between
held ends has a mode, so that the count of Eq. (N.6) is that of the matrix alone. The derivative of E by the
frequency is that of its formula at a complex frequency, exact to round-off.

A beam whose tension changes along it has even tension on short lengths, by the mean of 1/T on each: a wave
is longer than they are, and feels the mean compliance.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.heavy_string import StringPieces, displacement_series, string_pieces, transfer
from cabledrive.mechanics.network.elements import SHORTEST, Element
from cabledrive.mechanics.network.motion import Array
from cabledrive.mechanics.rest import RestingStretch
from cabledrive.mechanics.tensioned_beam import ANTISYMMETRIC, SYMMETRIC, beam_stiffness, wave_numbers
from cabledrive.modal.network.elastic_links import ElasticLink

LONGEST_PHASE = 1.5
"""Phase of the longest segment [rad]: held, it has its first mode beyond pi."""

_WAVES = ("near", "give", "far")

_COMPLEX = 1e-20
"""Imaginary part, relative, of the frequency at which derivatives are taken."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Segments:
    """The segments of all beams of a component, or of all its heavy strings.

    Attributes
    ----------
    links : tuple of ElasticLink
    first : ndarray of int, shape (links + 1,)
        Where the segments of each link begin.
    places : list of ndarray
        Ends of the segments of each link as shares of it.
    local : sparse array, shape (p 2 unknowns, n)
        Motion of both ends of each segment by the coordinates.
    beams : ndarray, shape (4, p)
        EI [N m^2], tension [N], density [kg/m] and length [m] of the segments of beams; else empty.
    strings : list of StringPieces
        Segments of each heavy string; else empty.
    """

    links: tuple[ElasticLink, ...]
    first: NDArray[np.intp]
    places: list[Array]
    local: Any
    beams: Array
    strings: list[StringPieces]
    _kept: dict[float, tuple[Array, Array]] = field(default_factory=dict)

    def both(self, omega: float) -> tuple[Array, Array]:
        """Stiffness over the frequency and minus its derivative, shape (p, 2 unknowns, 2 unknowns) each."""
        if omega not in self._kept:
            self._kept.clear()
            ropes = np.repeat([link.ropes for link in self.links], np.diff(self.first))
            stiffness = ropes[:, None, None] * self._stiffness(omega * (1.0 + 1j * _COMPLEX))
            value, slope = stiffness.real / omega, stiffness.imag / (_COMPLEX * omega)
            self._kept[omega] = value, (value - slope) / omega
        return self._kept[omega]

    def _stiffness(self, omega: complex) -> NDArray[Any]:
        if not self.strings:
            return beam_stiffness(omega, *self.beams)
        waves = [transfer(pieces, omega) for pieces in self.strings]
        near, give, far = (np.concatenate([getattr(own, key) for own in waves]) for key in _WAVES)
        start, mixed, end = (1.0 + near) / give, -1.0 / give, (1.0 + far) / give
        return np.stack((np.stack((start, mixed), -1), np.stack((mixed, end), -1)), -2)

    def matrix(self, omega: float) -> Array:
        """Stiffness over the frequency in the coordinates, shape (n, n)."""
        from scipy.sparse import bsr_array

        values = self.both(omega)[0]
        count = values.shape[0]
        blocks = bsr_array((values, np.arange(count), np.arange(count + 1)))
        return np.asarray((self.local.T @ blocks @ self.local).toarray())

    def forms(self, omega: float, x: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Stiffness and rate of each segment for the columns of x, shape (p, k, k) each.

        ``x``, shape (n, k): motion of the coordinates.
        """
        values, rates = self.both(omega)
        moved = (self.local @ x).reshape(*values.shape[:2], -1)
        energy, rate = (np.einsum("pik,pij,pjl->pkl", moved.conj(), own, moved) for own in (values, rates))
        return energy, rate

    def displacement(self, number: int, omega: float, x: NDArray[Any], positions: Array) -> NDArray[Any]:
        """Displacement at places of one link, shape (k, q).

        ``number``: of the link; ``x``, shape (n, k): motion of the coordinates; ``positions``, shape (q,):
        from the start of its element [m].
        """
        own = slice(self.first[number], self.first[number + 1])
        places, share = self.places[number], positions / self.links[number].element.length
        segment = np.clip(np.searchsorted(places, share, "right") - 1, 0, places.size - 2)
        inside = (share - places[segment]) / np.diff(places)[segment]
        ends = (self.local @ x).reshape(self.first[-1], -1, x.shape[1])[own]
        if self.strings:
            pieces = self.strings[number]
            shapes = [string_shape(pieces, omega, column, segment, inside) for column in ends.T]
        else:
            beams = self.beams[:, own][:, segment]
            shapes = [beam_shape(beams, omega, column.T[segment], inside) for column in ends.T]
        return np.array(shapes)


def string_shape(
    pieces: StringPieces, omega: float, ends: NDArray[Any], number: NDArray[np.intp], share: Array
) -> NDArray[Any]:
    """Displacement inside the pieces of a heavy string, shape (q,).

    ``ends``, shape (2, p): displacement of start and end of each; ``number``, ``share``, shape (q,): piece
    and place in it.
    """
    waves = transfer(pieces, omega)
    force = (ends[1] - (1.0 + waves.near) * ends[0]) / waves.give
    series = displacement_series(pieces, omega, np.stack((ends[0], force)))[:, number]
    powers = share[None, :] ** np.arange(series.shape[0])[:, None]
    return np.asarray(np.sum(series * powers, axis=0))


def beam_shape(beams: Array, omega: float, ends: NDArray[Any], share: Array) -> NDArray[Any]:
    """Displacement inside beams, the sum of the waves that meet displacement and slope of their ends.

    ``beams``, shape (4, q): as of `Segments`; ``ends``, shape (q, 4); ``share``, shape (q,): place in each.
    Returns shape (q,).
    """
    alpha, beta = wave_numbers(omega, *beams[:3])
    h, x = 0.5 * beams[3], (share - 0.5) * beams[3]
    c, s, t = np.cos(alpha * h), np.sin(alpha * h), np.tanh(beta * h)
    near, far = np.exp(-beta * (h + x)), np.exp(-beta * (h - x))
    fade = 1.0 + np.exp(-2.0 * beta * h)
    even, odd = (far + near) / fade, (far - near) / fade  # cosh and sinh over the cosh of the end
    w, slope = (ends @ SYMMETRIC.T).T
    first = (beta * t * w - slope) * np.cos(alpha * x) + (alpha * s * w + c * slope) * even
    first = first / (beta * c * t + alpha * s)
    w, slope = (ends @ ANTISYMMETRIC.T).T
    second = (beta * w - t * slope) * np.sin(alpha * x) + (s * slope - alpha * c * w) * odd
    return np.asarray(first + second / (beta * s - alpha * c * t))


def octave(link: ElasticLink, omega: float) -> int:
    """Which of the sets of segments serves up to a frequency [rad/s]: those of 2^octave rad of phase."""
    number = 1
    while link.element.frequency(2.0**number) < omega:
        number += 1
    return number


def cut_points(link: ElasticLink, octave: int) -> tuple[Array, StringPieces | None]:
    """Ends of the segments as shares of the element, and those of a heavy string.

    ``octave``: up to 2^octave rad of phase.
    """
    own = link.element
    top = own.frequency(2.0**octave)
    if own.bending:
        steps = tension_steps(own)
        slowest = min(own.start_tension, own.end_tension)
        alpha, _ = wave_numbers(top, own.bending, slowest, own.density / own.stretch)
        parts = np.ceil(alpha * own.length * np.diff(steps) / LONGEST_PHASE)
        inner = [a + (b - a) * np.arange(n) / n for (a, b), n in zip(pairwise(steps), parts, strict=True)]
        return np.concatenate((*inner, [1.0])), None
    unstretched = own.length / own.stretch
    stretch = RestingStretch(
        span="",
        start=0.0,
        end=unstretched,
        force=(own.start_tension, 0.0),
        load=((own.start_tension - own.end_tension) / unstretched, 0.0),
        axial_rigidity=own.axial_rigidity,
    )
    pieces = string_pieces((stretch,), np.zeros(1), own.density, top)
    return np.append(pieces.start, unstretched) / unstretched, pieces


def tension_steps(own: Element) -> Array:
    """Ends of the lengths of even tension of a beam, as shares of it; the same at all frequencies."""
    count = own.tension_steps
    if count == 1:
        return np.array([0.0, 1.0])
    ratio = own.end_tension / own.start_tension
    inner = (ratio ** (np.arange(1, count) / count) - 1.0) / (ratio - 1.0)
    # How far a rope bends at its ends depends on the tension there: the first lengths are short.
    bend = own.bending_length / own.length
    end = min(2.0 * SHORTEST * bend, 0.25)
    inner = inner[(inner > end + SHORTEST * bend) & (inner < 1.0 - end - SHORTEST * bend)]
    return np.array([0.0, end, *inner, 1.0 - end, 1.0])


def segments_of(links: Sequence[ElasticLink], octaves: Sequence[int], first: int) -> tuple[Segments, int]:
    """The segments of elements of one kind; their joints are coordinates behind those of the component.

    ``octaves``: as of `cut_points`, of each; ``first``: coordinate of the first joint.
    Returns them, and the coordinate after the last joint.
    """
    cuts = [cut_points(link, number) for link, number in zip(links, octaves, strict=True)]
    begins = np.concatenate(([0], np.cumsum([places.size - 1 for places, _ in cuts])))
    size = first + sum((places.size - 2) * links[0].unknowns for places, _ in cuts)
    entries: list[tuple[Array, Array, Array]] = []
    joint = first
    for link, (places, _), begin in zip(links, cuts, begins[:-1], strict=True):
        entries.append(_entries(link, places.size - 1, 2 * link.unknowns * begin, joint))
        joint += (places.size - 2) * link.unknowns
    row, column, value = (np.concatenate(part) for part in zip(*entries, strict=True))
    from scipy.sparse import csr_array

    shape = (2 * links[0].unknowns * int(begins[-1]), size)
    return Segments(
        links=tuple(links),
        first=begins,
        places=[places for places, _ in cuts],
        local=csr_array((value, (row.astype(np.intp), column.astype(np.intp))), shape=shape),
        beams=np.hstack(
            [_beams(link.element, places) for link, (places, _) in zip(links, cuts, strict=True)]
        ),
        strings=[strings for _, strings in cuts if strings is not None],
    ), size


def _entries(link: ElasticLink, count: int, row: int, joint: int) -> tuple[Array, Array, Array]:
    """Rows, columns and values of the motion of the ends of one link's segments.

    ``count``: of segments; ``row``: its first row; ``joint``: coordinate of its first joint.
    """
    k = link.unknowns
    start, end = link.end_rows
    near, far = np.nonzero(start), np.nonzero(end)
    ones = np.arange((count - 1) * k)
    after = row + 2 * k * (ones // k) + k + ones % k  # end of a segment, and the start of the next
    return (
        np.concatenate((row + near[0], row + 2 * k * (count - 1) + k + far[0], after, after + k)),
        np.concatenate((near[1], far[1], joint + ones, joint + ones)),
        np.concatenate((start[near], end[far], np.ones(2 * ones.size))),
    )


def _beams(own: Element, places: Array) -> Array:
    """Properties of the segments of a beam; each length of even tension has that of its travel time."""
    if not own.bending:
        return np.zeros((4, 0))
    steps = tension_steps(own)
    ends = own.start_tension + (own.end_tension - own.start_tension) * steps
    even = np.array([own.tension]) if steps.size == 2 else 0.5 * (ends[:-1] + ends[1:])
    middle = 0.5 * (places[:-1] + places[1:])
    even = even[np.searchsorted(steps, middle) - 1]
    density = np.full(even.size, own.density / own.stretch)
    return np.stack((np.full(even.size, own.bending), even, density, own.length * np.diff(places)))
