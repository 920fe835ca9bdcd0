r"""Heavy strings and tensioned beams in segments, each with the exact stiffness of its waves.

A beam whose tension changes along it has even tension on short lengths, by the mean of 1/T on each: a wave
is longer than they are, and feels the mean compliance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
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
from cabledrive.modal.network.segments import LONGEST_PHASE, Segments, joined

_WAVES = ("near", "give", "far")


@dataclass(frozen=True, eq=False, kw_only=True)
class StringSegments(Segments):
    """Segments of heavy strings.

    Attributes
    ----------
    strings : list of StringPieces
        Of each link.
    """

    strings: list[StringPieces]

    def stiffness(self, omega: complex) -> NDArray[Any]:
        """By the series of each."""
        waves = [transfer(pieces, omega) for pieces in self.strings]
        near, give, far = (np.concatenate([getattr(own, key) for own in waves]) for key in _WAVES)
        start, mixed, end = (1.0 + near) / give, -1.0 / give, (1.0 + far) / give
        return np.stack((np.stack((start, mixed), -1), np.stack((mixed, end), -1)), -2)

    def inside(
        self, own: NDArray[np.intp], omega: float, ends: NDArray[Any], share: Array, way: int
    ) -> NDArray[Any]:
        """By the series of the link that has the segments."""
        number = int(np.searchsorted(self.first, own[0], "right")) - 1 if own.size else 0
        return string_shape(self.strings[number], omega, ends, own - self.first[number], share)


@dataclass(frozen=True, eq=False, kw_only=True)
class BeamSegments(Segments):
    """Segments of tensioned beams.

    Attributes
    ----------
    beams : ndarray, shape (4, p)
        EI [N m^2], tension [N], density [kg/m] and length [m].
    """

    beams: Array

    def stiffness(self, omega: complex) -> NDArray[Any]:
        """By the waves of each."""
        return beam_stiffness(omega, *self.beams)

    def inside(
        self, own: NDArray[np.intp], omega: float, ends: NDArray[Any], share: Array, way: int
    ) -> NDArray[Any]:
        """By the waves of each."""
        return beam_shape(self.beams[:, own], omega, ends, share)


def string_segments(
    links: Sequence[ElasticLink], octaves: Sequence[int], first: int
) -> tuple[StringSegments, int]:
    """Heavy strings in segments; parameters as of `cabledrive.modal.network.cutting.segments_of`."""
    strings = [_string_pieces(link.element, number) for link, number in zip(links, octaves, strict=True)]
    lengths = [link.element.length / link.element.stretch for link in links]
    places = [np.append(own.start, end) / end for own, end in zip(strings, lengths, strict=True)]
    common, after = joined(links, places, first)
    return StringSegments(**common, strings=strings), after


def beam_segments(
    links: Sequence[ElasticLink], octaves: Sequence[int], first: int
) -> tuple[BeamSegments, int]:
    """Tensioned beams in segments; parameters as of `cabledrive.modal.network.cutting.segments_of`."""
    places = [_beam_places(link.element, number) for link, number in zip(links, octaves, strict=True)]
    common, after = joined(links, places, first)
    beams = np.hstack([_beams(link.element, own) for link, own in zip(links, places, strict=True)])
    return BeamSegments(**common, beams=beams), after


def string_shape(
    pieces: StringPieces, omega: float, ends: NDArray[Any], number: NDArray[np.intp], share: Array
) -> NDArray[Any]:
    """Displacement inside the pieces of a heavy string, shape (q,).

    ``ends``, shape (q, 2): displacement of start and end of each; ``number``, ``share``, shape (q,): piece
    and place in it.
    """
    waves = transfer(pieces, omega)
    both = np.zeros((2, waves.give.size), dtype=ends.dtype)
    both[0, number] = ends[:, 0]
    both[1, number] = (ends[:, 1] - (1.0 + waves.near[number]) * ends[:, 0]) / waves.give[number]
    series = displacement_series(pieces, omega, both)[:, number]
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


def _beam_places(own: Element, octave: int) -> Array:
    """Ends of the segments as shares of a beam, up to 2^octave rad of phase."""
    steps = tension_steps(own)
    slowest = min(own.start_tension, own.end_tension)
    alpha, _ = wave_numbers(own.frequency(2.0**octave), own.bending, slowest, own.density / own.stretch)
    parts = np.ceil(alpha * own.length * np.diff(steps) / LONGEST_PHASE)
    inner = [a + (b - a) * np.arange(n) / n for (a, b), n in zip(pairwise(steps), parts, strict=True)]
    return np.concatenate((*inner, [1.0]))


def _string_pieces(own: Element, octave: int) -> StringPieces:
    """Pieces of a heavy string that serve up to 2^octave rad of phase."""
    unstretched = own.length / own.stretch
    stretch = RestingStretch(
        span="",
        start=0.0,
        end=unstretched,
        force=(own.start_tension, 0.0),
        load=((own.start_tension - own.end_tension) / unstretched, 0.0),
        axial_rigidity=own.axial_rigidity,
    )
    return string_pieces((stretch,), np.zeros(1), own.density, own.frequency(2.0**octave))


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


def _beams(own: Element, places: Array) -> Array:
    """Properties of the segments of a beam, shape (4, p); each length has the tension of its travel time."""
    steps = tension_steps(own)
    ends = own.start_tension + (own.end_tension - own.start_tension) * steps
    even = np.array([own.tension]) if steps.size == 2 else 0.5 * (ends[:-1] + ends[1:])
    middle = 0.5 * (places[:-1] + places[1:])
    even = even[np.searchsorted(steps, middle) - 1]
    density = np.full(even.size, own.density / own.stretch)
    return np.stack((np.full(even.size, own.bending), even, density, own.length * np.diff(places)))
