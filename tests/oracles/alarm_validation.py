"""Transverse motion of the full nonlinear model along a planned motion, from rest and from a floor."""

import itertools
from dataclasses import dataclass

import numpy as np

from cabledrive.simulation import Recording, Scheme, Start
from cabledrive.simulation.case import case_of
from cabledrive.simulation.channels import width_of
from cabledrive.simulation.methods import integrate_steps
from cabledrive.simulation.network.mesh import passed_words
from cabledrive.simulation.plan import DONE, copy_state, new_workspace
from cabledrive.simulation.prepared import reached

V, W = 1, 2
RECORDS_PER_PERIOD = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class TrueMotion:
    """Largest displacements of the full model along a motion.

    ``driven``: from equilibrium, by the motion alone [m]; ``grown``: from equilibrium with the floor put on
    it, what the floor's other modes add taken off [m]; ``slack``: whether a run ended because a span lost its
    tension; ``stands``: whether so little rope passes that the model holds.
    """

    driven: float
    grown: float
    slack: bool
    stands: bool

    @property
    def largest(self):
        """The larger of both [m]."""
        return max(self.driven, self.grown)


def true_motion(drive, motion, *, floor, modes, highest, rng, starts=(0.0, 0.35), segments=100):
    """Largest transverse displacement of the full nonlinear model along a motion.

    The run starts at equilibrium with the drive pulley held. At some instants every stretch gets the floor in
    each of its lowest sines and both planes, with random phases.

    ``motion``: its pretension, carriages and load torque stand still; ``floor`` [m]; ``modes``: number of
    sines of each stretch that get the floor; ``highest``: highest frequency of interest, for the records
    [Hz]; ``rng``: of the phases; ``starts``: instants as shares of the motion; ``segments``: per span.
    """
    case = case_of(
        drive.machine,
        float(motion.time[-1]),
        torque=lambda t: np.interp(t, motion.time, motion.torque),
        start=Start(from_equilibrium=True, hold="drive"),
        scheme=Scheme(segments=segments),
        recording=Recording(rate=RECORDS_PER_PERIOD * highest, fields=1),
    )
    rest, end, stretches = case.first_state().x.copy(), case.grid.records, _stretches(case.mesh)
    state, done, driven, slack = case.first_state(), 0, 0.0, False
    begun = []
    for record in (*sorted(int(share * end) for share in starts), end):
        moved, slack = _advance(case, state, done, record, rest)
        driven = max(driven, float(np.abs(moved).max(initial=0.0)))
        if slack:
            break
        done = record
        begun.append((record, copy_state(state)))
    stands = not any(passed_words(case.mesh, np.abs(reached(state)).max(axis=0)))
    grown = 0.0
    for record, state in begun[: len(starts)]:
        placed, speed = _floor(case, stretches, floor, modes, rng)
        state.x[V:] += placed
        state.x_t[V:] += speed
        moved, ended = _advance(case, state, record, end, rest)
        grown = max(grown, _above_floor(case, stretches, moved, modes, floor) + floor)
        slack = slack or ended
    return TrueMotion(driven=driven, grown=grown, slack=slack, stands=stands)


def _stretches(mesh):
    """Span and pretensioned ends of every part between neighbouring supports."""
    found = []
    for span, own, (first, last) in zip(mesh.pieces, mesh.positions, mesh.nodes, strict=True):
        rails = own[~mesh.sways[first : last + 1]]
        found += [(span, a, b) for a, b in itertools.pairwise(rails)]
    return found


def _sines(case, stretches, modes, swaying=False):
    """Nodes inside each stretch, its lowest sines there, shape (modes, nodes), and their wave numbers."""
    mesh = case.mesh
    for span, start, end in stretches:
        x, first = mesh.positions[mesh.pieces.index(span)], mesh.nodes[mesh.pieces.index(span), 0]
        nodes = first + np.arange(x.size)
        inside = (x > start + 1e-9) & (x < end - 1e-9) & (mesh.sways[nodes] | (not swaying))
        kappa = np.arange(1, modes + 1) * np.pi / (end - start)
        yield nodes[inside], np.sin(kappa[:, None] * (x[inside] - start)), kappa


def _floor(case, stretches, floor, modes, rng):
    """Displacement and speed of the floor in the planes v and w, half a step apart as they may be."""
    place, speed = np.zeros((2, case.nodes)), np.zeros((2, case.nodes))
    law_speed = np.sqrt(case.laws[0].pretension / case.mesh.density[0])
    for nodes, sines, kappa in _sines(case, stretches, modes, swaying=True):
        for shape, number in zip(sines, kappa, strict=True):
            for plane in range(2):
                phase = rng.uniform(0, 2 * np.pi)
                place[plane, nodes] += floor * np.cos(phase) * shape
                speed[plane, nodes] -= floor * np.sin(phase) * number * law_speed * shape
    return place, speed


def _advance(case, state, first, last, rest):
    """Move the state in place from record to record; v and w at each, and whether it went slack.

    From the curve at rest, which rims take along.
    """
    every, width = case.grid.every, case.nodes
    if last <= first:
        return np.zeros((0, 2, width)), False
    rows, fields = np.zeros((last - first, width_of(case.plan))), np.full((last - first, 3, width), np.nan)
    torque, forces = case.inputs(first * every, (last - first) * every)
    given = case.plan, state, new_workspace(case.plan)
    code = integrate_steps(case.scheme.method, given, (torque, forces), every, (rows, fields))
    moved = fields[:, V:] - rest[V:]
    for own, (begin, end) in zip(case.mesh.positions, case.mesh.nodes, strict=True):
        here = slice(begin, end + 1)
        rails = np.flatnonzero(~case.mesh.sways[here])
        chord = np.stack([np.interp(own, own[rails], at) for at in moved[:, 1, here][:, rails]])
        moved[:, 1, here] -= chord
    return moved[np.isfinite(moved).all(axis=(1, 2))], code != DONE


def _above_floor(case, stretches, moved, modes, floor):
    """Largest displacement with the floor's size taken off every sine of every stretch."""
    largest = 0.0
    for nodes, sines, _ in _sines(case, stretches, max(modes, 2)):
        part = moved[:, :, nodes]
        amplitude = part @ np.linalg.pinv(sines)
        left = part - amplitude @ sines
        shrunk = np.sign(amplitude) * np.maximum(np.abs(amplitude) - floor, 0.0)
        largest = max(largest, float(np.abs(shrunk @ sines + left).max(initial=0.0)))
    return largest
