r"""Static forces in the cable: unknown in few numbers, found by Newton's method on a convex function.

Forces are linear in the unknowns: the force along at the start of each span, the force across at the start
of each section between points held across. That every span ends where its pulley is makes as many equations,
and these are the gradient of a convex function, the complementary energy. A step that is halved until the
slope along it has fallen therefore reaches the one solution.
"""

from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array

MOST_STEPS = 200
PANELS = 4
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True, slots=True)
class Piece:
    """A stretch before its forces are known; ``jump`` is the weight of the joint at its end."""

    span: int
    section: int
    start: float
    end: float
    load: Array
    jump: Array


class Statics:
    """The unknown forces, and the equations that the spans end where the pulleys are.

    ``at_torque``: steady torque on the drive pulley on top of what holds the weights [N m].
    """

    def __init__(self, drive: Drive, at_torque: float) -> None:
        self.drive = drive
        self.pull = -at_torque / drive.drive_pulley.radius  # of the upper span, more than the lower one
        self.pieces = pieces_of(drive)
        self.level = drive.layout.gravity_across > 0.0
        self.fall = np.zeros(len(drive.spans))  # of the force along, from start to end of each span
        for piece in self.pieces:
            self.fall[piece.span] += piece.load[0] * (piece.end - piece.start) + piece.jump[0]

    def solve(self) -> Array:
        """Force along and across at the start of every piece, (pieces, 2) [N]; `NotComputed`: none found."""
        drive, pull = self.drive, self.pull
        if not drive.load_pulley.fixed:
            if drive.kind == "line":
                return self._balance(np.array([drive.cable.pretension + pull + self.fall[0]]))
            return self._balance(np.array([0.0, -self.fall[0] - pull]), tied=True)
        rest = self._balance(np.full(len(drive.spans), np.nan))
        if pull == 0.0:
            return rest
        if drive.kind == "line":
            return self._balance(rest[:1, 0] + pull)
        # the drive pulley turns until its torque is that of rest and the given one
        start = [piece.start == 0.0 for piece in self.pieces]
        upper, lower = rest[start, 0]
        return self._balance(np.array([0.0, lower - upper - pull]), tied=True)

    def _balance(self, first: Array, *, tied: bool = False) -> Array:
        """Force at the start of every piece, shape (pieces, 2).

        `first` is the force along at the start of each span: given, to be found (NaN), or, where the spans
        are tied, what it is more than in the upper span, and one number to be found.
        """
        known, constant = self._integrate(first, tied)
        unknowns = known.shape[2]
        excess = np.zeros(unknowns)  # by which the pretensioned spans are longer than their cable
        longer = self.drive.span_length * self.drive.cable.prestrain
        along = unknowns - (1 + max(piece.section for piece in self.pieces) if self.level else 0)
        excess[:along] = longer * (2.0 if tied else 1.0)
        forces = np.full(unknowns, self.drive.cable.pretension)  # and half of the weight of each section
        forces[along:] = 0.0
        for piece in self.pieces if self.level else ():
            hung = piece.load[1] * (piece.end - piece.start) + piece.jump[1]
            forces[along + piece.section] += hung / 2.0
        for _ in range(MOST_STEPS):
            left, matrix = self._gradient(known, constant + known @ forces)
            step = np.asarray(np.linalg.solve(matrix, excess - left), dtype=np.float64)
            forces = self._searched(known, constant, forces, step, excess)
            scale = np.abs(forces).max(initial=0.0) + self.drive.cable.pretension
            if np.abs(step).max(initial=0.0) <= 1e-13 * scale:
                return np.asarray(constant + known @ forces)
        said = f"no state of rest within {MOST_STEPS} steps"
        raise NotComputed(f"{said}: raise cable.pretension above {self.drive.cable.pretension:.4g} N")

    def _integrate(self, first: Array, tied: bool) -> tuple[Array, Array]:
        """From the unknowns to the force at the start of each piece: matrices and constants."""
        spans = 1 if tied else int(np.isnan(first).sum())
        sections = 1 + max(piece.section for piece in self.pieces) if self.level else 0
        known = np.zeros((len(self.pieces), 2, spans + sections))
        constant = np.zeros((len(self.pieces), 2))
        force = np.zeros(2)
        for number, piece in enumerate(self.pieces):
            if piece.start == 0.0:
                force = np.array([0.0 if np.isnan(first[piece.span]) else first[piece.span], 0.0])
            elif piece.section != self.pieces[number - 1].section:
                force[1] = 0.0
            constant[number] = force
            if spans:
                known[number, 0, 0 if tied else piece.span] = 1.0
            if self.level:
                known[number, 1, spans + piece.section] = 1.0
            force = force - piece.load * (piece.end - piece.start) - piece.jump
        return known, constant

    def _searched(self, known: Array, constant: Array, forces: Array, step: Array, excess: Array) -> Array:
        """Halve the step until the slope of the energy along it has fallen."""
        slope = abs(float((excess - self._gradient(known, constant + known @ forces)[0]) @ step))
        share = 1.0
        while share > 2.0**-30:
            trial = forces + share * step
            left = self._gradient(known, constant + known @ trial)[0]
            if abs(float((excess - left) @ step)) <= (1.0 - 0.1 * share) * slope or slope == 0.0:
                return np.asarray(trial)
            share /= 2.0
        return np.asarray(forces + step)  # round-off: the last digits do not fall any more

    def _gradient(self, known: Array, start: Array) -> tuple[Array, Array]:
        """How much longer than its cable each piece reaches along, how far it falls; summed over unknowns."""
        length = np.array([piece.end - piece.start for piece in self.pieces])
        load = np.array([piece.load for piece in self.pieces])
        reach = length[:, None] * quadrature_points()
        force = start[:, :, None] - load[:, :, None] * reach[:, None, :]
        weight = length[:, None] * np.tile(WEIGHTS, PANELS) / (2.0 * PANELS)
        rigidity = self.drive.cable.axial_rigidity
        if not self.level:
            stretch = np.einsum("jp,jp->j", weight, force[:, 0]) / rigidity
            left = np.einsum("jan,ja->n", known, np.stack((stretch, 0.0 * stretch), axis=1))
            return left, np.einsum("jn,j,jm->nm", known[:, 0], length / rigidity, known[:, 0])
        size = np.hypot(force[:, 0], force[:, 1])
        unit = force / size[:, None]
        bent = unit[:, 0] - 1.0
        forward = unit[:, 0] > 0.0
        bent[forward] = -(unit[:, 1] ** 2 / (1.0 + np.abs(unit[:, 0])))[forward]
        reached = np.stack((force[:, 0] / rigidity + bent, force[:, 1] / rigidity + unit[:, 1]), axis=1)
        moved = np.einsum("jp,jap->ja", weight, reached)
        turning = np.eye(2)[None, :, :, None] - unit[:, :, None] * unit[:, None, :]
        give = np.einsum(
            "jp,jabp->jab", weight, np.eye(2)[None, :, :, None] / rigidity + turning / size[:, None, None]
        )
        left = np.einsum("jan,ja->n", known, moved)
        return left, np.einsum("jan,jab,jbm->nm", known, give, known)


def pieces_of(drive: Drive) -> list[Piece]:
    """Stretches of cable with their weights, upper span first, by position; x along the span, y down."""
    pieces = []
    section = 0
    for number, span in enumerate(drive.spans):
        uphill = -1.0 if span == "upper" else 1.0
        pull = np.array([uphill * drive.layout.gravity_along, drive.layout.gravity_across])
        start = 0.0
        for carriage in (*drive.carriages_on(span), None):
            end = carriage.position if carriage is not None else drive.span_length
            weight = carriage.mass * pull if carriage is not None else np.zeros(2)
            held = carriage is None or carriage.guided
            jump = weight * np.array([1.0, 0.0 if held else 1.0])
            load = drive.cable.mass_per_length * pull
            pieces.append(Piece(number, section, start, end, load, jump))
            section, start = section + held, end
    return pieces


def quadrature_points() -> Array:
    """Places of the quadrature on a stretch of length 1, panel after panel."""
    return ((np.arange(PANELS)[:, None] + (NODES + 1.0) / 2.0) / PANELS).ravel()
