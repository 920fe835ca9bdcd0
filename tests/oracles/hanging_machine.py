"""Machines whose ropes hang: every span by polynomials of high order about its exact elastic catenary.

Places on a rope are functions of the unstretched length from the start of a part, between two of the joints
that its carriages are; a wheel's rim moves an end along the rope's own direction there. A rope that runs
passes the places: what it does is (d/dt + v d/ds) of them. Shared with the package: the file's numbers.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import asinh, hypot

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq, root

from oracles import rope_fem
from oracles.network_fem import shape_functions, with_flow
from oracles.route_fem import Kinematics, solid_parts, span_frames, weight_of

PLANES = (0, 1), (2,)
"""Along and across, out of the plane."""
CLOSE = {"xtol": 1e-300, "rtol": 9e-16}
COUNTED = 24
"""Frequencies of each."""
GAUSS = np.polynomial.legendre.leggauss(60)


@dataclass(frozen=True)
class Part:
    """A piece of rope in the frame of its chord: length at rest, force at its start, weight of a metre.

    ``flow``: its density times the square of the unstretched speed, whose momentum is no part of the force.
    """

    length: float
    force: np.ndarray
    weight: np.ndarray
    rigidity: float
    flow: float

    def at(self, share):
        """Direction, shape (n, 2), force and stretch, shape (n,), at shares of the length."""
        force = self.force - np.outer(self.length * np.atleast_1d(share), self.weight)
        size = np.hypot(*force.T)
        # the tension is the force and the flow times the stretch
        return force / size[:, None], size, (1.0 + size / self.rigidity) / (1.0 - self.flow / self.rigidity)

    def chord(self):
        """From its start to its end."""
        direction, _, stretch = self.at((1.0 + GAUSS[0]) / 2.0)
        return 0.5 * self.length * (GAUSS[1] * stretch) @ direction


def catenary(rope, flow, lengths, gravity, pull, hung, size):
    """Parts of a rope of such lengths whose ends and guided carriages lie on its chord, and its force there.

    ``gravity``, shape (2,), in the frame of the chord; ``pull``: force along it at the start; ``hung``: mass
    of each carriage and whether it is guided: what guides one bears all across. ``size``: of the chord.
    """
    guided = np.array([*(one[1] for one in hung), True])
    held = np.sum(guided)

    def parts_of(unknown):
        parts, jumps = [], iter(pull * unknown)
        force = np.array([pull, next(jumps)])
        for length, (mass, is_held) in zip(lengths, [*hung, (0.0, False)], strict=True):
            parts.append(Part(length, force, rope.density * gravity, rope.axial_rigidity, flow))
            force = force - (length * rope.density + mass) * gravity
            force[1] = next(jumps) if is_held else force[1]
        return parts, force

    def miss(unknown):
        ends = np.cumsum([part.chord() for part in parts_of(unknown)[0]], axis=0) / size
        return ends[guided, 1]

    load = rope.density * size + sum(one[0] for one in hung)
    found = root(miss, 0.5 * load / held * gravity[1] / pull * np.ones(held), tol=1e-13)
    assert np.max(np.abs(found.fun)) < 1e-11
    return parts_of(found.x)


@dataclass(frozen=True)
class Settled:
    """A span at rest: axes of its chord, directions at its ends, parts, by what it misses its end."""

    axes: np.ndarray
    directions: list
    parts: list
    tensions: tuple  # where a straight rope leaves its wheels, without the momentum that passes with it
    missing: float


def settled(drive, frame, pull, hung, fed, shorter=1.0):
    """A span between where it leaves its wheels, with rope that was fed in at its start and out at its end.

    ``shorter``: unstretched speed of a rope that runs over that of the straight machine; ``hung``: share of
    the length of the straight rope, mass, whether it is guided, of each carriage.
    """
    first, last, along, straight, number = frame
    rope = drive.ropes[number]
    cut = straight / (1.0 + (rope.pretension or 0.0) / rope.axial_rigidity)
    shares = np.array([0.0, *(one[0] for one in hung), 1.0])
    directions, stretches, speed = [along, along], 2 * [straight / cut], drive.route[number].speed
    for _ in range(60):
        turns = [np.arctan2(along[0] * d[1] - along[1] * d[0], along @ d) for d in directions]
        arcs = [
            place[2] * turn / stretch
            for place, turn, stretch in zip((first, last), turns, stretches, strict=True)
        ]
        lengths = cut * np.diff(shares)
        lengths[0] += fed[0] - arcs[0]
        lengths[-1] += arcs[1] - fed[1]
        contacts = [
            np.array(place[0]) - place[2] * np.array([-direction[1], direction[0]])
            for place, direction in zip((first, last), directions, strict=True)
        ]
        chord = contacts[1] - contacts[0]
        size = np.hypot(*chord)
        axes = np.array([chord, [-chord[1], chord[0]]]) / size
        flow = rope.density * (speed * cut / straight * shorter) ** 2
        given = axes @ weight_of(drive), pull, [one[1:] for one in hung], size
        parts, end = catenary(rope, flow, lengths, *given)
        before, stretches = directions, [parts[0].at(0.0)[2][0], parts[-1].at(1.0)[2][0]]
        ends = [np.hypot(*parts[0].force), np.hypot(*end)]
        directions = [
            force / tension @ axes for force, tension in zip((parts[0].force, end), ends, strict=True)
        ]
        if np.max(np.abs(np.subtract(before, directions))) < 1e-15:
            break
    missing = sum(part.chord()[0] for part in parts) / size - 1.0
    normal = np.array([-along[1], along[0]])
    onward = []  # tension where a straight rope leaves its wheels: of the rope between hangs on it
    for place, contact, pull, stretch in zip((first, last), contacts, ends, stretches, strict=True):
        moved = contact - np.array(place[0]) + place[2] * normal
        onward.append(pull + rope.density / stretch * weight_of(drive) @ moved)
    return Settled(axes, directions, parts, tuple(onward), missing)


def at_rest(drive):
    """Every span at rest: wheels pass the tension on, and the rope that a span has too much.

    At its ends and where a wheel is held rope goes nowhere; at a drum that nothing holds it goes until its
    pull is the pretension. Bodies stay where they are.
    """
    frames = list(span_frames(drive))
    motors = [motor.pulley or drive.pulley[0].name for motor in drive.motor]
    held = {None, *motors, *(pulley.name for pulley in drive.pulley if pulley.fixed)}
    hung, gates = [[] for _ in frames], []
    for one, (at, place) in zip(drive.carriage, drive.carriage_places, strict=True):
        hung[at] = sorted([*hung[at], (place / frames[at][3], one.mass, one.guided)])
    for number, route in enumerate(drive.route):
        own = [i for i, frame in enumerate(frames) if frame[4] == number]
        ends = [(own[-1], own[0])] if route.closed else [(None, own[0]), (own[-1], None)]
        for before, behind in (*pairwise(own), *ends):
            wheel = frames[before][1] if behind is None else frames[behind][0]
            gates += [] if wheel[3] in held else [(before, behind)]
    pulls = np.array([drive.ropes[frame[4]].pretension for frame in frames])
    strained = np.array([frame[3] / drive.ropes[frame[4]].axial_rigidity for frame in frames]) * pulls

    runs = any(route.speed for route in drive.route)

    def spans_of(unknown):
        fed = np.zeros((len(frames), 2))
        for (before, behind), share in zip(
            gates, unknown[len(frames) : len(frames) + len(gates)], strict=True
        ):
            rope = share * strained[before if behind is None else behind]
            for span, end in ((before, 1), (behind, 0)):
                if span is not None:
                    fed[span, end] = rope
        shorter = unknown[-1] if runs else 1.0
        return [
            settled(drive, *one, shorter)
            for one in zip(frames, pulls * unknown[: len(frames)], hung, fed, strict=True)
        ]

    def miss(unknown):
        found = spans_of(unknown)
        both = zip(found, frames, strained, strict=True)
        reach = [one.missing * frame[3] / own for one, frame, own in both]
        for before, behind in gates:
            pull = pulls[before if behind is None else behind]
            first = pull if before is None else found[before].tensions[1]
            last = pull if behind is None else found[behind].tensions[0]
            reach.append((first - last) / pull)
        if runs:  # the mean stretch makes of what passes unstretched the speed of the file
            parts = [part for one in found for part in one.parts]
            lengths = np.array([part.length for part in parts])
            stretch = lengths @ [part.at(0.5)[2][0] for part in parts] / np.sum(lengths)
            reach.append(unknown[-1] * stretch / (1.0 + pulls[0] / drive.ropes[0].axial_rigidity) - 1.0)
        return reach

    start = np.concatenate((np.ones(len(frames)), np.zeros(len(gates)), np.ones(int(runs))))
    found = root(miss, start, tol=1e-14)
    assert np.max(np.abs(found.fun)) < 1e-9, found.fun
    return spans_of(found.x)


def under_tensions(drive, tensions):
    """Every span at rest under the tension at its start [N], its rope as long as it reaches."""
    found = []
    for frame, tension in zip(span_frames(drive), tensions, strict=True):
        strained = frame[3] * tension / drive.ropes[frame[4]].axial_rigidity

        def span(unknown, frame=frame, tension=tension, strained=strained):
            return settled(drive, frame, tension * unknown[0], [], (0.0, strained * unknown[1]))

        def miss(unknown, span=span, tension=tension, strained=strained, frame=frame):
            one = span(unknown)
            return [np.hypot(*one.parts[0].force) / tension - 1.0, one.missing * frame[3] / strained]

        solution = root(miss, [1.0, 0.0], tol=1e-14)
        assert np.max(np.abs(solution.fun)) < 1e-9, solution.fun
        found.append(span(solution.x))
    return found


def frequencies(drive, *, tensions=None, ways=PLANES, held=(), degree=26):
    """The first natural frequencies [Hz] of each of some sets of ways, by default in and out of the plane.

    ``tensions``: at the start of each span, where bodies of the machine are free; ``held``: coordinates at
    rest.
    """
    kin = Kinematics(drive)
    values, slopes, weights, points = shape_functions(degree)
    n = kin.size + 3 * len(drive.carriage)
    rest = at_rest(drive) if tensions is None else under_tensions(drive, tensions)
    spans = list(zip(span_frames(drive), rest, strict=True))
    bubbles = np.arange(n, n + 3 * (degree - 1) * (len(spans) + len(drive.carriage)))
    total = n + bubbles.size
    unit, inner = np.eye(total), iter(bubbles.reshape(-1, degree - 1, 3))
    m, k = (np.pad(own, (0, total - kin.size)) for own in solid_parts(drive, kin))
    g = np.zeros_like(m)
    for number, (frame, rest) in enumerate(spans):
        own = sorted(
            (place, one.mass, one.guided, kin.size + 3 * i)
            for i, (one, (at, place)) in enumerate(zip(drive.carriage, drive.carriage_places, strict=True))
            if at == number
        )
        joints, parts = [], rest.parts
        for place, direction in zip(frame[:2], rest.directions, strict=True):
            moved = kin.slope(place[0], place[1]) + np.outer(direction, kin.rim(place))
            joints.append(np.pad(rest.axes @ moved, ((0, 1), (0, total - kin.size))))
        for _, mass, guided, i in own:
            joints.insert(-1, unit[i : i + 3] * [[1.0], [not guided], [not guided]])
            m += mass * joints[-2].T @ joints[-2]
        for part, near, far in zip(parts, joints[:-1], joints[1:], strict=True):
            rows = np.concatenate(([near, far], unit[next(inner)])).reshape(-1, total)
            direction, force, stretch = part.at(points)
            direction = np.pad(direction, ((0, 0), (0, 1)))
            along = direction[:, :, None] * direction[:, None, :]
            across = (force / stretch)[:, None, None] * (np.eye(3) - along)
            block = weights[:, None, None] / part.length * ((part.rigidity - part.flow) * along + across)
            stiff = np.einsum("iq,jq,qab->iajb", slopes, slopes, block, optimize=True)
            k += rows.T @ stiff.reshape(len(rows), -1) @ rows
            mass = drive.ropes[frame[4]].density * part.length * (values * weights) @ values.T
            m += rows.T @ np.kron(mass, np.eye(3)) @ rows
            passes = np.sqrt(drive.ropes[frame[4]].density * part.flow) * (values * weights) @ slopes.T
            g += rows.T @ np.kron(passes - passes.T, np.eye(3)) @ rows
    way = np.concatenate((np.zeros(kin.size), np.resize(range(3), total - kin.size)))
    free = (np.diag(m) > 0.0) & ~np.isin(range(total), held)
    found = []
    for own in (np.ix_(*[free & np.isin(way, one)] * 2) for one in ways):
        if g[own].any():
            found.append(with_flow(m[own], g[own], k[own])[:COUNTED] / (2.0 * np.pi))
            continue
        top = eigh(k[own], m[own], eigvals_only=True)[: COUNTED + 1][-1]
        found.append(rope_fem.frequencies(m[own], k[own], np.sqrt(top)) / (2.0 * np.pi))
    return found


# --- Sag at the middle [m] and horizontal tension [N] of a level span (Irvine, Cable Structures, section 2.3)


def catenary_sag(drive):
    """The elastic catenary: L_e = H L / EA + 2 H L / P arsinh(P / 2H) gives the tension H."""
    cable, length = drive.cable, drive.span_length
    weight = cable.mass_per_length * drive.layout.gravity * length
    rigidity = cable.axial_rigidity

    def too_long(tension):
        arc = 2.0 * tension * length / weight * asinh(weight / (2.0 * tension))
        return tension * length / rigidity + arc - drive.pulley_distance

    tension = brentq(too_long, 1e-9 * weight, rigidity + weight, **CLOSE)
    half = weight / (2.0 * tension)
    dip = tension * length / weight * half**2 / (hypot(1.0, half) + 1.0)
    return dip + weight * length / (8.0 * rigidity), tension
