r"""Elements of a component, cut into segments that have no mode of their own.

Each segment has a stiffness E of the motions of its ends. The joints between segments are coordinates of the
component; up to the frequency for which they were cut no segment between held ends has a mode, so that the
count of Eq. (N.6) is that of the matrix alone. The derivative of E by the frequency is that of its formula at
a complex frequency, exact to round-off.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.network.motion import Array
from cabledrive.modal.network.elastic_links import ElasticLink

LONGEST_PHASE = 1.5
"""Phase of the longest segment [rad]: held, it has its first mode beyond pi."""

_COMPLEX = 1e-20
"""Imaginary part, relative, of the frequency at which derivatives are taken."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Segments(ABC):
    """The segments of all elements of one kind of a component.

    Attributes
    ----------
    links : tuple of ElasticLink
    first : ndarray of int, shape (links + 1,)
        Where the segments of each link begin.
    places : list of ndarray
        Ends of the segments of each link as shares of it.
    local : sparse array, shape (p 2 unknowns, n)
        Motion of both ends of each segment by the coordinates.
    """

    links: tuple[ElasticLink, ...]
    first: NDArray[np.intp]
    places: list[Array]
    local: Any
    _kept: dict[float, tuple[Array, Array]] = field(default_factory=dict)

    @abstractmethod
    def stiffness(self, omega: complex) -> NDArray[Any]:
        """Stiffness of one rope of each segment [N/m], shape (p, 2 unknowns, 2 unknowns); omega [rad/s]."""

    @abstractmethod
    def inside(
        self, own: NDArray[np.intp], omega: float, ends: NDArray[Any], share: Array, way: int
    ) -> NDArray[Any]:
        """Displacement inside segments, shape (q,).

        ``own``, shape (q,): their numbers; ``ends``, shape (q, 2 unknowns): motion of their ends; ``share``,
        shape (q,): place in each; ``way``: 0 along, else across.
        """

    def both(self, omega: float) -> tuple[Array, Array]:
        """Stiffness over the frequency and minus its derivative, shape (p, 2 unknowns, 2 unknowns) each."""
        if omega not in self._kept:
            self._kept.clear()
            stiffness = self.ropes[:, None, None] * self.stiffness(omega * (1.0 + 1j * _COMPLEX))
            value, slope = stiffness.real / omega, stiffness.imag / (_COMPLEX * omega)
            self._kept[omega] = value, (value - slope) / omega
        return self._kept[omega]

    @property
    def ropes(self) -> NDArray[np.intp]:
        """Parallel ropes of each segment, shape (p,)."""
        return np.repeat([link.ropes for link in self.links], np.diff(self.first))

    def matrix(self, omega: float) -> Array:
        """Stiffness over the frequency in the coordinates, shape (n, n)."""
        from scipy.sparse import bsr_array

        values = self.both(omega)[0]
        count = values.shape[0]
        blocks = bsr_array((values, np.arange(count), np.arange(count + 1)))
        return np.asarray((self.local.T @ blocks @ self.local).toarray())

    def energies(self, omega: float, x: NDArray[Any]) -> tuple[Array, float]:
        """Four times the strain energy of each link that is covered, and 2/omega^2 times the kinetic energy.

        ``x``, shape (n, k): motion of the coordinates; mean over its columns.
        """
        forms = self.forms(omega, self.ends(x))
        stiff, rate = (np.einsum("pkk->p", form).real / x.shape[1] for form in forms)
        kinetic = float(np.sum(rate - stiff / omega)) / 2.0
        strain = np.add.reduceat(omega * stiff + omega**2 * rate, self.first[:-1])
        return strain, kinetic

    def forms(self, omega: float, moved: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Quadratic forms of stiffness over the frequency and of its rate, shape (p, k, k) each.

        ``moved``, shape (p, 2 unknowns, k): motion of the ends of each segment.
        """
        energy, rate = (np.einsum("pik,pij,pjl->pkl", moved.conj(), own, moved) for own in self.both(omega))
        return energy, rate

    def ends(self, x: NDArray[Any]) -> NDArray[Any]:
        """Motion of the ends of each segment, shape (p, 2 unknowns, k); ``x``, shape (n, k)."""
        return np.asarray((self.local @ x).reshape(int(self.first[-1]), -1, x.shape[1]))

    def displacement(
        self, number: int, omega: float, x: NDArray[Any], positions: Array, way: int
    ) -> NDArray[Any]:
        """Displacement at places of one link, shape (k, q).

        ``number``: of the link; ``x``, shape (n, k): motion of the coordinates; ``positions``, shape (q,):
        from the start of its element [m]; ``way``: 0 along, else across.
        """
        places, share = self.places[number], positions / self.links[number].element.length
        segment = np.clip(np.searchsorted(places, share, "right") - 1, 0, places.size - 2)
        inside = (share - places[segment]) / np.diff(places)[segment]
        own = self.first[number] + segment
        ends = self.ends(x)[own]
        return np.array([self.inside(own, omega, ends[:, :, k], inside, way) for k in range(x.shape[1])])


def octave(link: ElasticLink, omega: float) -> int:
    """Which of the sets of segments serves up to a frequency [rad/s]: those of 2^octave rad of phase."""
    number = 1
    while link.element.frequency(2.0**number) < omega:
        number += 1
    return number


def joined(links: Sequence[ElasticLink], places: Sequence[Array], first: int) -> tuple[dict[str, Any], int]:
    """What `Segments` hold of elements of one kind; their joints are coordinates behind the component's own.

    ``places``: ends of the segments of each link as shares of it; ``first``: coordinate of the first joint.
    Returns the attributes by name, and the coordinate after the last joint.
    """
    from scipy.sparse import csr_array

    unknowns = links[0].unknowns
    begins = np.concatenate(([0], np.cumsum([own.size - 1 for own in places])))
    entries: list[tuple[Array, Array, Array]] = []
    joint = first
    for link, own, begin in zip(links, places, begins[:-1], strict=True):
        entries.append(_entries(link, own.size - 1, 2 * unknowns * begin, joint))
        joint += (own.size - 2) * unknowns
    row, column, value = (np.concatenate(part) for part in zip(*entries, strict=True))
    local = csr_array(
        (value, (row.astype(np.intp), column.astype(np.intp))), shape=(2 * unknowns * int(begins[-1]), joint)
    )
    return {"links": tuple(links), "first": begins, "places": list(places), "local": local}, joint


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
