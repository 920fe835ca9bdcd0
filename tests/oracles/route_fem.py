"""A machine of kind "route" as finite elements, from the places in its file: own kinematics, own tangents.

Points move by rotations and shifts; rows of the ends of spans and the stiffness of turning bodies are
numerical derivatives of them. Shared with the package: the drive's numbers and the tensions of its spans.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from oracles.network_fem import String, matrices
from oracles.rope_fem import Beam, HangingRope, frequencies, shear_between, with_ropes

STEP = 1e-3
STRAIGHT = 5e-7
"""Irvine's parameter up to which a rope is taken for straight."""


class Kinematics:
    """Coordinates of the bodies' moves and of the turning pulleys, and where points are."""

    def __init__(self, drive):
        self.drive = drive
        self.moves = [(body.name, move) for body in drive.body for move in body.moves]
        self.turning = [pulley.name for pulley in drive.pulley if not pulley.fixed]
        self.size, self.rotors = len(self.moves) + len(self.turning), []
        for motor in drive.motor:
            jointed = motor.joint_stiffness is not None
            self.rotors.append(self.size if jointed else self.turns(motor.pulley or drive.pulley[0].name))
            self.size += jointed
        self.bodies = {body.name: body for body in drive.body}

    def turns(self, pulley):
        """Number of the coordinate of a pulley that turns."""
        return len(self.moves) + self.turning.index(pulley)

    def point(self, at, on, q):
        """Where a point of a body is, shape (2,)."""
        at = np.array(at, dtype=float)
        while on:
            body = self.bodies[on]
            step = {move: q[i] for i, (name, move) in enumerate(self.moves) if name == on}
            if "turn" in step:
                angle, pivot = step["turn"], np.array(body.pivot)
                turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
                at = pivot + turn @ (at - pivot)
            at = at + np.array([step.get("x", 0.0), step.get("y", 0.0)])
            on = body.on
        return at

    def slope(self, at, on):
        """Derivative of a point's place, shape (2, n): of fourth order in the step."""
        rows = np.zeros((2, self.size))
        for i in range(len(self.moves)):
            e = np.eye(self.size)[i] * STEP
            near = self.point(at, on, e) - self.point(at, on, -e)
            far = self.point(at, on, 2 * e) - self.point(at, on, -2 * e)
            rows[:, i] = (8 * near - far) / (12 * STEP)
        return rows

    def turn(self, on):
        """How fast a body turns with each coordinate, shape (n,)."""
        rate = np.zeros(self.size)
        while on:
            for i, (name, move) in enumerate(self.moves):
                rate[i] += name == on and move == "turn"
            on = self.bodies[on].on
        return rate

    def rim(self, place):
        """How far the rim at a place moves a rope along with each coordinate, shape (n,)."""
        _, on, reach, name = place
        if name in self.turning:
            return reach * np.eye(self.size)[self.turns(name)]
        return reach * self.turn(on)  # a guide turns with the body that carries it

    def second(self, force, at, on):
        """Second derivative of force times place, shape (n, n)."""
        n, total = len(self.moves), np.zeros((self.size, self.size))
        unit = np.eye(self.size)

        def work(q):
            return float(force @ self.point(at, on, q))

        def mixed(i, j, h):
            a, b = h * unit[i], h * unit[j]
            return (work(a + b) - work(a - b) - work(b - a) + work(-a - b)) / (4 * h * h)

        for i in range(n):
            for j in range(n):
                total[i, j] = (4 * mixed(i, j, 10 * STEP) - mixed(i, j, 20 * STEP)) / 3
        return total


def places(drive, route):
    """Centre, carrier, radius times sense, and number among the pulleys of each step of a path."""
    pulleys = {pulley.name: pulley for pulley in drive.pulley}
    anchors = {anchor.name: anchor for anchor in drive.anchor}
    for step in route.path:
        if step[0] in "+-":
            pulley = pulleys[step[1:]]
            yield pulley.at, pulley.on, pulley.radius * (1 if step[0] == "+" else -1), pulley.name
        else:
            yield anchors[step].at, anchors[step].on, 0.0, None


def span_frames(drive):
    """Each span in the order of the file: its two places, direction, length, route."""
    for number, route in enumerate(drive.route):
        steps = list(places(drive, route))
        for first, last in pairwise([*steps, steps[0]] if route.closed else steps):
            d = complex(*last[0]) - complex(*first[0])
            sine = (first[2] - last[2]) / abs(d)
            direction = d / abs(d) * complex(np.sqrt(1 - sine**2), sine)
            yield (
                first,
                last,
                np.array([direction.real, direction.imag]),
                abs(d) * np.sqrt(1 - sine**2),
                number,
            )


def rows(kin, place, along):
    """Motion along and across the span at one of its ends, each shape (n,)."""
    slope = kin.slope(place[0], place[1])
    return along @ slope + kin.rim(place), np.array([-along[1], along[0]]) @ slope


def weight_of(drive):
    """Gravity in the plane of the machine [m/s^2]."""
    slope = drive.layout.inclination
    return -drive.layout.gravity * np.array([np.sin(slope), np.cos(slope)])


def solid_parts(drive, kin):
    """Mass and stiffness of bodies, pulleys and motors."""
    mass, stiffness = np.zeros((kin.size, kin.size)), np.zeros((kin.size, kin.size))
    weighed = [(body.mass, body.at, body.name, np.array(body.load)) for body in drive.body]
    weighed += [(pulley.mass, pulley.at, pulley.on, np.zeros(2)) for pulley in drive.pulley]
    for kilograms, at, on, load in weighed:
        slope = kin.slope(at, on)
        mass += kilograms * slope.T @ slope
        stiffness -= kin.second(kilograms * weight_of(drive) + load, at, on)
    for body in drive.body:
        rate = kin.turn(body.name)
        mass += body.inertia * np.outer(rate, rate)
        for i, (name, _) in enumerate(kin.moves):
            stiffness[i, i] += body.stiffness * (name == body.name)
    for pulley in drive.pulley:
        if not pulley.fixed:
            i = kin.turns(pulley.name)
            mass[i, i] += pulley.inertia
    for motor, rotor in zip(drive.motor, kin.rotors, strict=True):
        mass[rotor, rotor] += motor.inertia
        stiffness[rotor, rotor] += motor.holding_stiffness or 0.0
        ends = np.ix_(*2 * ([rotor, kin.turns(motor.pulley or drive.pulley[0].name)],))
        stiffness[ends] += (motor.joint_stiffness or 0.0) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return mass, stiffness


def system(drive, tensions):
    """Strings, beams, hanging ropes, mass and stiffness of a machine."""
    kin = Kinematics(drive)
    n = kin.size + 5 * len(drive.carriage)  # along, across, out of plane, and two slopes
    mass, stiffness = (np.pad(own, (0, n - kin.size)) for own in solid_parts(drive, kin))
    gravity, own = weight_of(drive), slice(0, kin.size)
    strings, beams, hanging, reached = [], [], [], {}
    frames = list(span_frames(drive))
    for span, (first, last, along, length, number) in enumerate(frames):
        rope, route = drive.ropes[number], drive.route[number]
        start, end = tensions[span]
        flow = rope.density / (1 + 0.5 * (start + end) / rope.axial_rigidity) * route.speed**2
        for place, pull in ((first, start - flow), (last, flow - end)):  # a rope that runs presses less
            stiffness[own, own] -= kin.second(route.ropes * pull * along, place[0], place[1])
        ends = [np.zeros((3, n)), np.zeros((3, n))]
        for row, place in zip(ends, (first, last), strict=True):
            row[0, own], row[1, own] = rows(kin, place, along)
        slopes = [np.zeros((2, n)) for _ in range(2)]  # of the ends, across and out of plane
        for row, place in zip(slopes, (first, last), strict=True):
            row[0, own] = kin.turn(place[1]) * (place[3] is None)
        before = reached.get(number, 0.0)
        reached[number] = before + length
        cuts = [(0.0, ends[0], slopes[0])]
        names = [one.name for one in drive.route]
        for index, carriage in enumerate(drive.carriage):
            at = carriage.position - before
            if (names.index(carriage.route) if carriage.route else 0) == number and 0 < at < length:
                row = np.zeros((3, n))
                directions = 1 if carriage.guided else 3
                row[range(directions), range(kin.size + 5 * index, kin.size + 5 * index + directions)] = 1.0
                mass += carriage.mass * row.T @ row
                slope = np.zeros((2, n))
                if not carriage.guided:
                    slope[[0, 1], [kin.size + 5 * index + 3, kin.size + 5 * index + 4]] = 1.0
                cuts.append((at, row, slope))
        cuts = [*sorted(cuts, key=lambda cut: cut[0]), (length, ends[1], slopes[1])]
        tension = 0.5 * (start + end)
        assert start == end or not drive.carriage  # the taper is of whole spans
        growth = (end - start) / tension
        for (low, left, turn), (high, right, turned) in pairwise(cuts):
            stretch = 1 + tension / rope.axial_rigidity
            unstretched, steep = (high - low) / stretch, (end - start) / length
            weight = rope.density / stretch * gravity @ np.array([-along[1], along[0]])
            sags = (weight * length / tension) ** 2 * rope.axial_rigidity / tension > STRAIGHT
            if sags:
                assert not drive.carriage
                assert not rope.bending_stiffness
                shear = shear_between((start, end), weight, length)
                given = rope.density, rope.axial_rigidity, 0.0, (start, end), shear, weight, route.ropes
                hanging.append(HangingRope(np.vstack((left[:2], right[:2])), length, *given))
            for way in range(2 if sags else 0, 3):
                if way and rope.bending_stiffness:
                    beyond = [
                        lift_off(drive, frames, span, at_start, rope.bending_stiffness / pull)
                        if place[3] is not None and at == edge
                        else 0.0
                        for place, at_start, at, edge, pull in (
                            (first, True, low, 0.0, start),
                            (last, False, high, length, end),
                        )
                    ]
                    beams.append(
                        Beam(
                            np.array([left[way], turn[way - 1], right[way], turned[way - 1]]),
                            high - low + sum(beyond),
                            rope.density / stretch,
                            rope.bending_stiffness,
                            (start - steep * beyond[0], end + steep * beyond[1]),
                            route.ropes,
                        )
                    )
                    continue
                rigidity = rope.axial_rigidity if way == 0 else tension / stretch
                speed = np.sqrt(rigidity / rope.density) / unstretched
                strings.append(
                    String(
                        left[way],
                        right[way],
                        rope.density * unstretched,
                        speed,
                        speed=route.speed / stretch / unstretched,
                        ropes=route.ropes,
                        taper=growth if way else 0.0,
                    )
                )
    tied = sum(s.start**2 + s.end**2 for s in strings)
    tied = tied + sum((b.rows**2).sum(axis=0) for b in [*beams, *hanging])
    used = np.flatnonzero(np.diag(mass) + np.diag(stiffness) + tied)
    strings = [replace(string, start=string.start[used], end=string.end[used]) for string in strings]
    # What the numerical derivatives leave of motion at right angles to a slide is round-off.
    clean = [np.where(np.abs(beam.rows) > 1e-9, beam.rows, 0.0) for beam in beams]
    beams = [replace(beam, rows=rows[:, used]) for beam, rows in zip(beams, clean, strict=True)]
    hanging = [replace(one, rows=one.rows[:, used]) for one in hanging]
    square = np.ix_(used, used)
    return strings, beams, hanging, mass[square], stiffness[square]


def lift_off(drive, frames, span, at_start, square):
    """Length beyond the tangent point after which a stiff rope lies on its pulley; ``square``: EI/T."""
    number = frames[span][4]
    own = [i for i, frame in enumerate(frames) if frame[4] == number]
    place = frames[span][0 if at_start else 1]
    other = own.index(span) + (-1 if at_start else 1)
    if not drive.route[number].closed and other in (-1, len(own)):
        return np.sqrt(square)  # a drum
    lines = [frames[own[other % len(own)]][2], frames[span][2]]
    first, last = lines if at_start else lines[::-1]
    turned = np.angle(complex(*last) / complex(*first)) * np.sign(place[2]) % (2 * np.pi)
    return min(np.sqrt(square), 0.5 * turned * abs(place[2]))


def frequencies_of_route(drive, tensions, degree, below):
    """Natural frequencies [Hz] up to about ``below``; ``tensions`` of each span's ends [N]."""
    strings, beams, hanging, mass, stiffness = system(drive, tensions)
    size, top = mass.shape[0], 2 * np.pi * below
    held = [beam for beam in beams if not beam.rows.any()]
    moved = [beam for beam in beams if beam.rows.any()]
    mass, _, stiffness = matrices(strings, mass, stiffness, degree)
    mass, stiffness = with_ropes(mass, stiffness, moved, size, elements=1, degree=8)
    mass, stiffness = with_ropes(mass, stiffness, hanging, size, elements=3, degree=degree)
    found = [frequencies(mass, stiffness, top)]
    for beam in held:
        inside = (own[4:, 4:] for own in beam.matrices(2, 8))
        found.append(np.repeat(frequencies(*inside, top), beam.ropes))
    return np.sort(np.concatenate(found)) / (2 * np.pi)
