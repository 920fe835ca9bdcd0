r"""Motion in the plane of gravity of a drive that sags: strings and the cable's length, coupled.

On a sagged section a transverse motion z lengthens the cable by :math:`\int\sin\theta\,z'\,ds`. The mean
tension h that this makes on a stretch pulls the ends together and bends the string,

.. math:: \frac{h}{\kappa} = u_b - u_a + \int\sin\theta\,z'\,ds, \qquad
          (R z')' + \rho_0\omega^2 z + h\,(\sin\theta)' = 0,

with :math:`\kappa = EA/l`, which is taken out of the links of Eq. (M.1) along the cable. Where
:math:`(\sin\theta)' = -\rho_0 a` the second has the solution :math:`z = a h/\omega^2`, as if the piece fell
freely; the rest are the waves of Eq. (M.11).
With h among the unknowns the matrix of the machine is

.. math:: \begin{pmatrix} \hat K_u & 0 & A^T \\ 0 & \hat K_z & c^T \\ A & c & -1/\hat\kappa + e \end{pmatrix},

and each h adds one negative eigenvalue to the count of Wittrick and Williams (Haynsworth's inertia of a
bordered matrix). One level span between held ends gives the equation of Irvine and Caughey,
:math:`\tan\frac\alpha2 = \frac\alpha2 - \frac{4}{\lambda^2}\big(\frac\alpha2\big)^3`.

See H. M. Irvine and T. K. Caughey, "The linear theory of free vibrations of a suspended cable", Proceedings
of the Royal Society A 341, 299-315, 1974; U. Starossek, "Dynamic stiffness matrix of sagging cable", Journal
of Engineering Mechanics 117(12), 2815-2829, 1991.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain, split_at_antinodes
from cabledrive.mechanics.dynamic_stiffness import dynamic_stiffness, free_joints
from cabledrive.mechanics.heavy_string import StringPieces, string_pieces, transfer
from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.mechanics.rest_state import RestingStretch
from cabledrive.modes.section_string import SectionMotion, SectionString, combined
from cabledrive.modes.solver import ENCLOSURE

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PlaneMode:
    """One mode of the plane of gravity.

    Attributes
    ----------
    omega : float
        [rad/s].
    proven : bool
        Whether counts on both sides of the enclosure prove it.
    along : float
        Share of the kinetic energy in the motion along the cable [-].
    shares : ndarray, shape (sections,)
        Share in the motion across of each section [-].
    parts : tuple of SectionMotion
        Motion of each section, of unit modal mass.
    """

    omega: float
    proven: bool
    along: float
    shares: Array
    parts: tuple[SectionMotion, ...]


def localised(cluster: list[PlaneMode]) -> list[PlaneMode]:
    """Modes of one frequency, combined anew so that each moves as few sections as can be.

    Their shapes may be combined at will; the combinations that make the sum over the sections of section
    number times share stationary are the same whatever the start, and are the sections themselves where these
    ring alone.

    Parameters
    ----------
    cluster : list of PlaneMode
        Of unit modal mass.

    Returns
    -------
    list of PlaneMode
        As many.
    """
    if len(cluster) == 1:
        return cluster
    sections = range(len(cluster[0].parts))
    products = [[[a.parts[i].product(b.parts[i]) for b in cluster] for a in cluster] for i in sections]
    weighted = sum((number + 1.0) * np.array(product) for number, product in enumerate(products))
    turns = np.linalg.eigh(weighted)[1]
    found = []
    for turn in turns.T:
        parts = tuple(combined([mode.parts[i] for mode in cluster], turn) for i in sections)
        shares = np.array([part.mass for part in parts])
        along = float(turn**2 @ [mode.along for mode in cluster])
        proven = all(mode.proven for mode in cluster)
        found.append(PlaneMode(cluster[0].omega, proven, along, shares, parts))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One section in pieces, with the slope of the resting cable."""

    pieces: StringPieces
    sine: Array  # (2, n) at both ends of each piece
    fall: Array  # a = -(sin theta)' / rho
    tension: NDArray[np.intp]  # which h pulls each piece
    nodes: int  # joints that move


class SaggingPlane:
    """The plane of gravity up to one frequency, Eq. (M.13).

    Parameters
    ----------
    chains : sequence of LabelledChain
        What moves along the cable.
    strings : sequence of SectionString
        Sections whose sag counts; the others are straight here.
    top : float
        Highest angular frequency [rad/s].
    """

    def __init__(
        self, chains: tuple[LabelledChain, ...], strings: tuple[SectionString, ...], top: float
    ) -> None:
        self._chains = [_cut(labelled, top) for labelled in chains]
        self.strings = strings
        self.rigid_body_modes = sum(labelled.chain.rigid_body_modes for labelled in chains)
        self._parts: list[_Part] = []
        self._pulls: list[tuple[int, int]] = []  # chain and segment of every h
        self._counts: dict[float, int] = {}
        for string in strings:
            self._parts.append(self._part(string, top))
        self._along = [free_joints(chain) for chain, _ in self._chains]
        self._offsets = np.cumsum([0, *(joints.size for joints in self._along)])
        self._first_across = int(self._offsets[-1])
        self._first_pull = self._first_across + sum(part.nodes for part in self._parts)
        self._size = self._first_pull + len(self._pulls)

    def count(self, omega: float) -> int:
        """Modes of the plane below a frequency, along and across, without the rigid-body mode.

        Parameters
        ----------
        omega : float
            [rad/s].

        Returns
        -------
        int
        """
        if omega <= 0.0:
            return 0
        if omega not in self._counts:
            from scipy.linalg.lapack import dsytrf

            factors, pivots, _ = dsytrf(self._scaled(omega)[0], lower=1)
            negative = _negative_blocks(np.diag(factors), pivots)
            self._counts[omega] = max(negative - len(self._pulls) - self.rigid_body_modes, 0)
        return self._counts[omega]

    def frequency(self, number: int, low: float, high: float) -> tuple[float, bool]:
        """One natural frequency, by the eigenvalue that passes zero there and by counts where that is rough.

        Parameters
        ----------
        number : int
            From 1, the rigid-body mode left out.
        low, high : float
            Frequencies between which the count reaches that number [rad/s].

        Returns
        -------
        omega : float
            [rad/s].
        proven : bool
            Whether counts on both sides of the enclosure prove it.
        """
        low = max((omega for omega, count in self._counts.items() if count < number), default=low)
        high = min((omega for omega, count in self._counts.items() if count >= number), default=high)
        while high - low > 0.05 * high:
            middle = (low + high) / 2.0
            low, high = (low, middle) if self.count(middle) >= number else (middle, high)
        low, high = self._by_eigenvalue(number, low, high)
        while high - low > 2.0 * ENCLOSURE * high:
            middle = (low + high) / 2.0
            if not low < middle < high:
                break
            low, high = (low, middle) if self.count(middle) >= number else (middle, high)
        return (low + high) / 2.0, high - low <= 2.0 * ENCLOSURE * high

    def _by_eigenvalue(self, number: int, low: float, high: float) -> tuple[float, float]:
        """A narrow interval around a root of one eigenvalue, where counts confirm it; else the given one."""
        from scipy.optimize import brentq

        place = number - 1 + len(self._pulls) + self.rigid_body_modes

        def eigenvalue(omega: float) -> float:
            return float(np.linalg.eigvalsh(self._scaled(omega)[0])[place])

        if not eigenvalue(low) > 0.0 >= eigenvalue(high):
            return low, high
        root = brentq(eigenvalue, low, high, xtol=1e-300, rtol=4e-15)
        for room in (0.9 * ENCLOSURE, 20.0 * ENCLOSURE, 1e-9):
            inner, outer = root * (1.0 - room), root * (1.0 + room)
            if self.count(inner) < number <= self.count(outer):
                return inner, outer
        return low, high

    def motions(self, number: int, count: int, omega: float, proven: bool) -> list[PlaneMode]:
        """The modes of one natural frequency: the eigenvectors that belong to their numbers.

        Parameters
        ----------
        number : int
            Of the first, from 1.
        count : int
            How many share the frequency.
        omega : float
            [rad/s].
        proven : bool
            Passed on.

        Returns
        -------
        list of PlaneMode
        """
        matrix, scale = self._scaled(omega)
        first = number - 1 + len(self._pulls) + self.rigid_body_modes
        vectors = np.linalg.eigh(matrix)[1][:, first : first + count]
        return localised([self._motion(scale * vector, omega, proven) for vector in vectors.T])

    def _motion(self, x: Array, omega: float, proven: bool) -> PlaneMode:
        """The motion of unit modal mass that has these unknowns."""
        parts, node = [], self._first_across
        for part in self._parts:
            ends = np.concatenate(([0.0], x[node : node + part.nodes], [0.0]))
            node += part.nodes
            waves = transfer(part.pieces, omega)
            shift = part.fall * x[self._first_pull + part.tension] / omega
            start, end = ends[:-1] - shift, ends[1:] - shift
            force = (end - start - waves.near * start) / waves.give
            parts.append(SectionMotion(part.pieces, omega, np.stack((start, force)), shift))
        along = sum(self._along_mass(i, x) for i in range(len(self._chains)))
        across = np.array([part.mass for part in parts])
        total = along + across.sum()
        unit = tuple(part.scaled(1.0 / sqrt(total)) for part in parts)
        return PlaneMode(omega, proven, along / total, across / total, unit)

    def _along_mass(self, number: int, x: Array) -> float:
        chain, _ = self._chains[number]
        joints = np.zeros(chain.masses.size + (chain.pendant is not None))
        joints[self._along[number]] = x[self._offsets[number] : self._offsets[number + 1]]
        masses = chain.masses if chain.pendant is None else np.append(chain.masses, chain.pendant[1])
        near, far = (
            joints[: chain.lengths.size],
            np.roll(joints[: chain.masses.size], -1)[: chain.lengths.size],
        )
        cable = chain.density * chain.lengths / 3.0
        return float(masses @ joints**2 + cable @ (near**2 + near * far + far**2))

    def _part(self, string: SectionString, top: float) -> _Part:
        """Cut a section where its chain is cut, and again for the waves across."""
        stretches, masses, pulls = [], [], []
        ends = [*string.masses, 0.0]
        for stretch, mass in zip(string.section.stretches, ends, strict=True):
            number, segments = self._segments(stretch)
            chain = self._chains[number][0]
            places = stretch.start + np.concatenate(([0.0], np.cumsum(chain.lengths[segments])))
            places[-1] = stretch.end
            for k, segment in enumerate(segments):
                stretches.append(_between(stretch, float(places[k]), float(places[k + 1])))
                masses.append(mass if k == len(segments) - 1 else 0.0)
                pulls.append(len(self._pulls))
                self._pulls.append((number, int(segment)))
        pieces = string_pieces(tuple(stretches), np.array(masses), string.density, top)
        sine = np.empty((2, pieces.length.size))
        for i, number in enumerate(pieces.stretch):
            force = stretches[number].force_at(pieces.start[i] + np.array([0.0, pieces.length[i]]))
            sine[:, i] = force[1] / np.hypot(*force)
        fall = (sine[0] - sine[1]) / (pieces.density * pieces.length)
        return _Part(pieces, sine, fall, np.array(pulls)[pieces.stretch], pieces.length.size - 1)

    def _segments(self, stretch: RestingStretch) -> tuple[int, NDArray[np.intp]]:
        """Chain, and those of its segments that lie on a stretch."""
        for number, (_, places) in enumerate(self._chains):
            if (stretch.span, stretch.start) in places:
                return number, places[stretch.span, stretch.start]
        raise KeyError(stretch)

    def _scaled(self, omega: float) -> tuple[Array, Array]:
        """The matrix with rows and columns scaled by the roots of masses and links, and these scales."""
        matrix = np.zeros((self._size, self._size))
        scale = np.ones(self._size)
        links = [self._add_along(number, omega, matrix, scale) for number in range(len(self._chains))]
        node = self._first_across
        for part in self._parts:
            self._add_across(part, node, omega, matrix, scale)
            node += part.nodes
        for pull, (number, segment) in enumerate(self._pulls):
            link = float(links[number][segment])  # of the mean tension: without the cable's inertia along
            here = self._first_pull + pull
            matrix[here, here] -= 1.0 / link
            scale[here] = sqrt(abs(link))
        matrix *= scale[:, None]
        matrix *= scale
        return matrix, scale

    def _add_along(self, number: int, omega: float, matrix: Array, scale: Array) -> Array:
        """Joints of one chain; the spring of a segment under an h of its own becomes a row."""
        chain, _ = self._chains[number]
        stiffness = dynamic_stiffness(chain, omega)
        link = stiffness.link.copy()
        mine = [(pull, segment) for pull, (other, segment) in enumerate(self._pulls) if other == number]
        springs = chain.rigidity / chain.lengths / omega
        for _, segment in mine:
            link[segment] -= springs[segment]
        size = stiffness.ground.size
        full = np.diag(stiffness.ground)
        for left, right, value in zip(stiffness.left, stiffness.right, link, strict=True):
            full[left, left] += value
            full[right, right] += value
            full[left, right] -= value
            full[right, left] -= value
        rows = np.zeros((len(mine), size))
        for row, (_, segment) in enumerate(mine):
            rows[row, stiffness.left[segment]] -= 1.0
            rows[row, stiffness.right[segment]] += 1.0
        free = self._along[number]
        here = slice(int(self._offsets[number]), int(self._offsets[number + 1]))
        matrix[here, here] = full[np.ix_(free, free)]
        pulls = self._first_pull + np.array([pull for pull, _ in mine], dtype=np.intp)
        matrix[pulls, here] = rows[:, free]
        matrix[here, pulls] = rows[:, free].T
        scale[here] = 1.0 / np.sqrt(stiffness.ground_rate[free])
        return np.asarray(springs)

    def _add_across(self, part: _Part, first: int, omega: float, matrix: Array, scale: Array) -> None:
        """Nodes of one section, and what its tensions do to them."""
        pieces = part.pieces
        waves = transfer(pieces, omega)
        link = 1.0 / (waves.give * omega)
        near, far = waves.near * link, waves.far * link
        count = pieces.length.size
        diagonal = np.zeros(count + 1)
        diagonal[:-1] += near + link
        diagonal[1:] += far + link - omega * pieces.mass
        nodes = first + np.arange(part.nodes)
        matrix[nodes, nodes] = diagonal[1:-1]
        matrix[nodes[:-1], nodes[1:]] = matrix[nodes[1:], nodes[:-1]] = -link[1:-1]
        mass = np.zeros(count + 1)
        half = pieces.density * pieces.length / 2.0
        mass[:-1] += half
        mass[1:] += half + pieces.mass
        scale[nodes] = 1.0 / np.sqrt(mass[1:-1])
        start = -part.fall / omega * near - part.sine[0]
        end = -part.fall / omega * far + part.sine[1]
        pull = self._first_pull + part.tension
        for place, value, shift in ((nodes, start[1:], 1), (nodes, end[:-1], 0)):
            rows = pull[shift : shift + part.nodes]
            np.add.at(matrix, (rows, place), value)
            np.add.at(matrix, (place, rows), value)
        own = (part.fall / omega) ** 2 * (omega * pieces.density * pieces.length + near + far)
        np.add.at(matrix, (pull, pull), own)


def _cut(labelled: LabelledChain, top: float) -> tuple[Chain, dict[tuple[str, float], NDArray[np.intp]]]:
    """The chain with every segment below 2 rad, and the segments that each stretch became."""
    chain = labelled.chain
    joints = np.arange(chain.masses.size)
    while np.any(top * chain.travel_times > 2.0):
        chain, new = split_at_antinodes(chain, top)
        joints = new[joints]
    ends = np.append(joints, chain.lengths.size) if chain.closed else joints
    places = {
        (stretch.span, stretch.start): np.arange(ends[i], ends[i + 1])
        for i, stretch in enumerate(labelled.stretches)
    }
    return chain, places


def _between(stretch: RestingStretch, start: float, end: float) -> RestingStretch:
    force = stretch.force_at(np.array([start]))[:, 0]
    return RestingStretch(
        span=stretch.span,
        start=start,
        end=end,
        force=(float(force[0]), float(force[1])),
        load=stretch.load,
        axial_rigidity=stretch.axial_rigidity,
    )


def _negative_blocks(diagonal: Array, pivots: NDArray[np.intp]) -> int:
    """Negative eigenvalues from the factors of Bunch and Kaufman: a block of two has one of each sign."""
    single = pivots > 0
    return int(np.sum(diagonal[single] < 0.0)) + int(np.sum(~single)) // 2
