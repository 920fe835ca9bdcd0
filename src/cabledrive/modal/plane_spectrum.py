"""All modes in the plane of gravity up to a frequency, window by window."""

from dataclasses import dataclass
from math import ceil, pi

import numpy as np

from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.mechanics.rest import RestingSection
from cabledrive.mechanics.rest_forces import PANELS, WEIGHTS, quadrature_points
from cabledrive.modal.plane_mode import PlaneMode
from cabledrive.modal.sagging_matrix import SaggingMatrix
from cabledrive.modal.sagging_plane import Group, SaggingPlane
from cabledrive.modal.section_string import SectionString
from cabledrive.modal.solver import MULTIPLE

LEAST_SHIFT = 1e-9
"""Relative shift of a frequency by sag below which a section counts as straight."""

SHIFT_OF_SHIFT = 1e-6
"""The same as a share of lambda^2, where the sag is larger."""

MOST_SAGGING_JOINTS = 120
"""Joints of a machine up to which the plane of gravity is solved."""


def sag_parameter(section: RestingSection) -> float:
    r"""Irvine's parameter of a section at rest, for any weights on it: 12 EA/T times the mean of sin^2.

    .. math:: \lambda^2 = \frac{12\,EA}{\bar T}\,\overline{\sin^2\theta}

    A level cable without weights has the usual :math:`(\rho_0 g l/T)^2\,EA/T`.
    """
    places, weights = quadrature_points(), np.tile(WEIGHTS, PANELS) / (2.0 * PANELS)
    square = tension = 0.0
    for stretch in section.stretches:
        along, across = stretch.force_at(stretch.start + stretch.length * places)
        share = stretch.length / (section.end - section.start)
        square += share * float(weights @ (across**2 / (along**2 + across**2)))
        tension += share * stretch.mean_tension
    return 12.0 * section.stretches[0].axial_rigidity / tension * square


def straight_above(string: SectionString) -> float:
    r"""Frequency above which sag moves no mode of a section by more than `LEAST_SHIFT`.

    The n-th mode moves by :math:`4\lambda^2/(n\pi)^4` of its frequency at most.

    Returns half way between two modes of the string [rad/s]; 0 where the section is straight.
    """
    irvine = sag_parameter(string.section)
    number = (4.0 * irvine / max(LEAST_SHIFT, SHIFT_OF_SHIFT * irvine)) ** 0.25 / pi
    if number < 1.0:
        return 0.0
    return string.frequency(ceil(number) + 2 * string.masses.size + 0.5)


@dataclass(frozen=True, slots=True, eq=False)
class InPlane:
    """A mode in the plane of gravity.

    Attributes
    ----------
    sections : tuple of int
        Sections that may take part.
    mode : PlaneMode or None
        With sag; None for a straight string of one section.
    omega : float
        [rad/s].
    """

    sections: tuple[int, ...]
    mode: PlaneMode | None
    omega: float

    @property
    def along(self) -> bool:
        """Whether the motion is mainly along the cable."""
        return self.mode is not None and self.mode.along > 0.5

    @property
    def proven(self) -> bool:
        """Whether counts on both sides prove it."""
        return self.mode is None or self.mode.proven


class PlaneSpectrum:
    """Modes in the plane of gravity, each section straight above a frequency of its own.

    Parameters
    ----------
    chains : tuple of LabelledChain
        What moves along the cable.
    strings : dict of int to SectionString
        The taut sections by number.
    """

    def __init__(self, chains: tuple[LabelledChain, ...], strings: dict[int, SectionString]) -> None:
        self._chains, self._strings = chains, strings
        self._straight = {number: straight_above(string) for number, string in strings.items()}
        self._done = 0.0
        self._found: list[InPlane] = []
        self.complete = True

    def below(self, omega: float) -> list[InPlane]:
        """All modes below a frequency, ascending; those along the cable only while a section sags.

        ``omega`` [rad/s].
        """
        while self._done < omega:
            self._extend(omega)
        return [mode for mode in self._found if mode.omega < omega]

    def _extend(self, omega: float) -> None:
        """One more window: up to the next section that becomes straight, or twice as far as before."""
        low = self._done
        slowest = min(pi / string.travel_time for string in self._strings.values())
        edges = [edge for edge in self._straight.values() if edge > low]
        high = min([max(2.0 * low, 3.26 * slowest), *edges])
        if not edges:
            high = max(omega, 2.0 * low)
        sagging = tuple(number for number, edge in self._straight.items() if edge >= high)
        window = [
            InPlane((number,), None, string.frequency(n))
            for number, string in self._strings.items()
            if number not in sagging
            for n in range(string.count(low) + 1, string.count(high) + 1)
        ]
        if sagging:
            plane = SaggingPlane(SaggingMatrix(self._chains, tuple(self._strings[n] for n in sagging), high))
            first, last = plane.count(low), plane.count(high)
            window += [InPlane(sagging, mode, mode.omega) for mode in _modes(plane, first, last, low, high)]
        self._found += sorted(window, key=lambda mode: mode.omega)
        self._done = high


def _modes(plane: SaggingPlane, first: int, last: int, low: float, high: float) -> list[PlaneMode]:
    """Modes of a window, those of one frequency together."""
    roots = plane.frequencies(first + 1, last, low, high)
    groups, start = [], 0
    while start < len(roots):
        stop = start + 1
        while stop < len(roots) and roots[stop][0] - roots[start][0] <= MULTIPLE * roots[start][0]:
            stop += 1
        proven = all(root[1] for root in roots[start:stop])
        groups.append(Group(first + 1 + start, stop - start, roots[start][0], proven))
        start = stop
    return plane.motions(groups)
