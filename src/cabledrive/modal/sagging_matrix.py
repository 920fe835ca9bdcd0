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

import numpy as np
from numpy.typing import NDArray

from cabledrive.mechanics.chain import Chain, split_at_antinodes
from cabledrive.mechanics.heavy_string import StringPieces, string_pieces, transfer
from cabledrive.mechanics.labelled_chain import LabelledChain
from cabledrive.mechanics.rest import RestingStretch
from cabledrive.mechanics.stiffness_matrix import dynamic_stiffness, free_joints, links
from cabledrive.modal.section_string import SectionString

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SaggingPart:
    """One section in pieces, with the slope of the resting cable."""

    pieces: StringPieces
    sine: Array  # (2, n) at both ends of each piece
    fall: Array  # a = -(sin theta)' / rho
    tension: NDArray[np.intp]  # which h pulls each piece
    firsts: NDArray[np.intp]  # the first piece under each h
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
        self._joined = [
            _joined(number, chain, joints, self.pulls)
            for number, ((chain, _), joints) in enumerate(zip(self.chains, self.along, strict=True))
        ]
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
        tension = np.array(pulls)[pieces.stretch]
        firsts = np.flatnonzero(np.diff(tension, prepend=-1))
        return SaggingPart(pieces, sine, fall, tension, firsts, pieces.length.size - 1)

    def _segments(self, stretch: RestingStretch) -> tuple[int, NDArray[np.intp]]:
        """Chain, and those of its segments that lie on a stretch."""
        for number, (_, places) in enumerate(self.chains):
            if (stretch.span, stretch.start) in places:
                return number, places[stretch.span, stretch.start]
        raise KeyError(stretch)

    def scaled(self, omega: Array) -> tuple[Array, Array]:
        """The matrix with rows and columns scaled by the roots of masses and links, at several frequencies.

        ``omega``, shape (k,) [rad/s].
        Returns ``matrix``, shape (k, size, size); ``scale``, shape (k, size): what rows and columns were
        scaled by.
        """
        matrix = np.zeros((omega.size, self.size, self.size))
        scale = np.ones((omega.size, self.size))
        omega = omega[:, None]
        springs = [self._add_along(number, omega, matrix, scale) for number in range(len(self.chains))]
        node = self.first_across
        for part in self.parts:
            self._add_across(part, node, omega, matrix, scale)
            node += part.nodes
        for pull, (number, segment) in enumerate(self.pulls):
            link = springs[number][:, segment]  # of the mean tension: without the cable's inertia along
            here = self.first_pull + pull
            matrix[:, here, here] -= 1.0 / link
            scale[:, here] = np.sqrt(np.abs(link))
        matrix *= scale[:, :, None]
        matrix *= scale[:, None, :]
        return matrix, scale

    def _add_along(self, number: int, omega: Array, matrix: Array, scale: Array) -> Array:
        """Joints of one chain; the spring of a segment under an h of its own becomes a row."""
        chain, _ = self.chains[number]
        stiffness = dynamic_stiffness(chain, omega)
        link = stiffness.link.copy()
        springs = chain.rigidity / chain.lengths / omega
        joined, free, first = self._joined[number], self.along[number], int(self.offsets[number])
        link[:, joined.pulled] -= springs[:, joined.pulled]
        here = first + np.arange(free.size)
        matrix[:, here, here] = (stiffness.ground + link @ joined.ends)[:, free]
        rows, columns = first + joined.pairs
        matrix[:, rows, columns] = matrix[:, columns, rows] = -(link @ joined.between)
        pulls = self.first_pull + joined.pulls
        matrix[:, pulls[:, None], here] = joined.stretch
        matrix[:, here[:, None], pulls] = joined.stretch.T
        scale[:, here] = 1.0 / np.sqrt(stiffness.ground_rate[:, free])
        return np.asarray(springs)

    def _add_across(self, part: SaggingPart, first: int, omega: Array, matrix: Array, scale: Array) -> None:
        """Nodes of one section, and what its tensions do to them."""
        pieces = part.pieces
        waves = transfer(pieces, omega[:, 0])
        link = 1.0 / (waves.give * omega)
        near, far = waves.near * link, waves.far * link
        nodes = first + np.arange(part.nodes)
        matrix[:, nodes, nodes] = (far + link - omega * pieces.mass)[:, :-1] + (near + link)[:, 1:]
        matrix[:, nodes[:-1], nodes[1:]] = matrix[:, nodes[1:], nodes[:-1]] = -link[:, 1:-1]
        half = pieces.density * pieces.length / 2.0
        scale[:, nodes] = 1.0 / np.sqrt(half[:-1] + half[1:] + pieces.mass[:-1])
        start = -part.fall / omega * near - part.sine[0]
        end = -part.fall / omega * far + part.sine[1]
        pull, firsts = self.first_pull + part.tension, part.firsts
        for value, rows in ((start[:, 1:], pull[1:]), (end[:, :-1], pull[:-1])):
            matrix[:, rows, nodes] += value  # each node stands once in each of the two sums
            matrix[:, nodes, rows] += value
        own = (part.fall / omega) ** 2 * (omega * pieces.density * pieces.length + near + far)
        matrix[:, pull[firsts], pull[firsts]] += np.add.reduceat(own, firsts, axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Joined:
    """How the links of a chain join its joints that move.

    Attributes
    ----------
    ends : ndarray, shape (links, joints)
        1 at both ends of a link; none where it joins a joint with itself.
    pairs : ndarray of int, shape (2, pairs)
        Two joints that links join, among those that move.
    between : ndarray, shape (links, pairs)
        1 where a link joins the pair.
    pulls, pulled : ndarray of int, shape (p,)
        Tensions h of their own on this chain, and the links whose spring they are.
    stretch : ndarray, shape (p, joints that move)
        Elongation of these links for a unit displacement.
    """

    ends: Array
    pairs: NDArray[np.intp]
    between: Array
    pulls: NDArray[np.intp]
    pulled: NDArray[np.intp]
    stretch: Array


def _joined(number: int, chain: Chain, free: NDArray[np.intp], pulls: list[tuple[int, int]]) -> Joined:
    left, right = links(chain)
    joints = chain.masses.size + len(chain.pendants)
    stretch = np.zeros((left.size, joints))
    each = np.arange(left.size)
    np.add.at(stretch, (each, right), 1.0)
    np.add.at(stretch, (each, left), -1.0)
    moves = np.isin(left, free) & np.isin(right, free) & (left != right)
    ordered = np.sort(np.stack((left, right)), axis=0)
    pairs, which = np.unique(ordered[:, moves], axis=1, return_inverse=True)
    between = np.zeros((left.size, pairs.shape[1]))
    between[np.flatnonzero(moves), which.ravel()] = 1.0
    mine = np.array([[pull, link] for pull, (of, link) in enumerate(pulls) if of == number], dtype=np.intp)
    own, pulled = mine.reshape(-1, 2).T
    elongation = stretch[np.ix_(pulled, free)]
    return Joined(np.abs(stretch), np.searchsorted(free, pairs), between, own, pulled, elongation)


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
