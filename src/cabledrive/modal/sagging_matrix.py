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
from cabledrive.mechanics.heavy_string import StringPieces, string_pieces, transfer
from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.mechanics.rest import RestingStretch
from cabledrive.mechanics.stiffness_matrix import dynamic_stiffness, free_joints
from cabledrive.modal.section_string import SectionString

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SaggingPart:
    """One section in pieces, with the slope of the resting cable."""

    pieces: StringPieces
    sine: Array  # (2, n) at both ends of each piece
    fall: Array  # a = -(sin theta)' / rho
    tension: NDArray[np.intp]  # which h pulls each piece
    nodes: int  # joints that move


class SaggingMatrix:
    """The matrix of the plane of gravity up to one frequency, Eq. (M.13).

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
        self.chains = [_cut(labelled, top) for labelled in chains]
        self.strings = strings
        self.rigid_body_modes = sum(labelled.chain.rigid_body_modes for labelled in chains)
        self.parts: list[SaggingPart] = []
        self.pulls: list[tuple[int, int]] = []  # chain and segment of every h
        for string in strings:
            self.parts.append(self._part(string, top))
        self.along = [free_joints(chain) for chain, _ in self.chains]
        self.offsets = np.cumsum([0, *(joints.size for joints in self.along)])
        self.first_across = int(self.offsets[-1])
        self.first_pull = self.first_across + sum(part.nodes for part in self.parts)
        self.size = self.first_pull + len(self.pulls)

    def _part(self, string: SectionString, top: float) -> SaggingPart:
        """Cut a section where its chain is cut, and again for the waves across."""
        stretches, masses, pulls = [], [], []
        ends = [*string.masses, 0.0]
        for stretch, mass in zip(string.section.stretches, ends, strict=True):
            number, segments = self._segments(stretch)
            chain = self.chains[number][0]
            places = stretch.start + np.concatenate(([0.0], np.cumsum(chain.lengths[segments])))
            places[-1] = stretch.end
            for k, segment in enumerate(segments):
                stretches.append(_between(stretch, float(places[k]), float(places[k + 1])))
                masses.append(mass if k == len(segments) - 1 else 0.0)
                pulls.append(len(self.pulls))
                self.pulls.append((number, int(segment)))
        pieces = string_pieces(tuple(stretches), np.array(masses), string.density, top)
        sine = np.empty((2, pieces.length.size))
        for i, number in enumerate(pieces.stretch):
            force = stretches[number].force_at(pieces.start[i] + np.array([0.0, pieces.length[i]]))
            sine[:, i] = force[1] / np.hypot(*force)
        fall = (sine[0] - sine[1]) / (pieces.density * pieces.length)
        return SaggingPart(pieces, sine, fall, np.array(pulls)[pieces.stretch], pieces.length.size - 1)

    def _segments(self, stretch: RestingStretch) -> tuple[int, NDArray[np.intp]]:
        """Chain, and those of its segments that lie on a stretch."""
        for number, (_, places) in enumerate(self.chains):
            if (stretch.span, stretch.start) in places:
                return number, places[stretch.span, stretch.start]
        raise KeyError(stretch)

    def scaled(self, omega: float) -> tuple[Array, Array]:
        """The matrix with rows and columns scaled by the roots of masses and links.

        ``omega`` [rad/s].
        Returns ``matrix``, shape (size, size); ``scale``, shape (size,): what rows and columns were scaled
        by.
        """
        matrix = np.zeros((self.size, self.size))
        scale = np.ones(self.size)
        links = [self._add_along(number, omega, matrix, scale) for number in range(len(self.chains))]
        node = self.first_across
        for part in self.parts:
            self._add_across(part, node, omega, matrix, scale)
            node += part.nodes
        for pull, (number, segment) in enumerate(self.pulls):
            link = float(links[number][segment])  # of the mean tension: without the cable's inertia along
            here = self.first_pull + pull
            matrix[here, here] -= 1.0 / link
            scale[here] = sqrt(abs(link))
        matrix *= scale[:, None]
        matrix *= scale
        return matrix, scale

    def _add_along(self, number: int, omega: float, matrix: Array, scale: Array) -> Array:
        """Joints of one chain; the spring of a segment under an h of its own becomes a row."""
        chain, _ = self.chains[number]
        stiffness = dynamic_stiffness(chain, omega)
        link = stiffness.link.copy()
        mine = [(pull, segment) for pull, (other, segment) in enumerate(self.pulls) if other == number]
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
        free = self.along[number]
        here = slice(int(self.offsets[number]), int(self.offsets[number + 1]))
        matrix[here, here] = full[np.ix_(free, free)]
        pulls = self.first_pull + np.array([pull for pull, _ in mine], dtype=np.intp)
        matrix[pulls, here] = rows[:, free]
        matrix[here, pulls] = rows[:, free].T
        scale[here] = 1.0 / np.sqrt(stiffness.ground_rate[free])
        return np.asarray(springs)

    def _add_across(self, part: SaggingPart, first: int, omega: float, matrix: Array, scale: Array) -> None:
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
        pull = self.first_pull + part.tension
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
