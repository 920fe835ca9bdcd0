"""Machines whose ropes hang: every span by polynomials of high order about its exact elastic catenary.

Places on a rope are functions of the unstretched length from the start of a part, between two of the joints
that its carriages are; a wheel's rim moves an end along the rope's own direction there. Shared with the
package: the file's numbers and the pull along the chord at the start of each span.
"""

from dataclasses import dataclass
from math import asinh, hypot

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq, root

from oracles import rope_fem
from oracles.network_fem import shape_functions
from oracles.route_fem import Kinematics, solid_parts, span_frames, weight_of

PLANES = (0, 1), (2,)
"""Along and across, out of the plane."""
CLOSE = {"xtol": 1e-300, "rtol": 9e-16}
COUNTED = 24
"""Frequencies of each."""


@dataclass(frozen=True)
class Part:
    """A piece of rope in the frame of its chord: length at rest, force at its start, weight of a metre."""

    length: float
    force: np.ndarray
    weight: np.ndarray
    rigidity: float

    def at(self, share):
        """Direction, shape (n, 2), tension and stretch, shape (n,), at shares of the length."""
        force = self.force - np.outer(self.length * np.atleast_1d(share), self.weight)
        tension = np.hypot(*force.T)
        return force / tension[:, None], tension, 1.0 + tension / self.rigidity

    def chord(self):
        """From its start to its end."""
        points, weights = np.polynomial.legendre.leggauss(60)
        direction, _, stretch = self.at((1.0 + points) / 2.0)
        return 0.5 * self.length * (weights * stretch) @ direction


def catenary(rope, size, gravity, pull, hung, keeps):
    """Parts of a rope whose ends lie on its chord, of length ``size``, and its force at the end.

    ``gravity``, shape (2,), in the frame of the chord; ``pull``: force along it at the start; ``hung``:
    share of the chord, mass, and whether it is guided, of each carriage: what guides one bears all across.
    ``keeps``: whether parts have the lengths of a straight rope, else those that reach from end to end.
    """
    shares = np.array([*(one[0] for one in hung), 1.0])
    guided = np.array([*(one[2] for one in hung), True])
    held = np.sum(guided)
    straight = size * np.diff(shares, prepend=0.0) / (1.0 + (rope.pretension or pull) / rope.axial_rigidity)

    def parts_of(unknown):
        parts, jumps = [], iter(pull * unknown[:held])
        force = np.array([pull, next(jumps)])
        factors = np.ones(shares.size) if keeps else unknown[held:]
        for length, (_, mass, is_held) in zip(factors * straight, [*hung, (1.0, 0.0, False)], strict=True):
            parts.append(Part(length, force, rope.density * gravity, rope.axial_rigidity))
            force = force - (length * rope.density + mass) * gravity
            force[1] = next(jumps) if is_held else force[1]
        return parts, force

    def miss(unknown):
        ends = np.cumsum([part.chord() for part in parts_of(unknown)[0]], axis=0) / size
        return [*ends[guided, 1], *([] if keeps else ends[:, 0] - shares)]

    load = rope.density * size + sum(one[1] for one in hung)
    across = 0.5 * load / held * gravity[1] / pull * np.ones(held)
    found = root(miss, [*across, *([] if keeps else np.ones(shares.size))], tol=1e-13)
    assert np.max(np.abs(found.fun)) < 1e-11
    return parts_of(found.x)


def settled(drive, frame, pull, hung, keeps):
    """Along and across the chord of a span, directions in which rims move its ends, and its parts.

    Its ends lie on their wheels where it leaves them, or, if it ``keeps``, where a straight one would.
    """
    first, last, along, _, number = frame
    directions = along, along
    for _ in range(1 if keeps else 9):
        ends = [
            np.array(place[0]) - place[2] * np.array([-direction[1], direction[0]])
            for place, direction in zip((first, last), directions, strict=True)
        ]
        chord = ends[1] - ends[0]
        size = np.hypot(*chord)
        axes = np.array([chord, [-chord[1], chord[0]]]) / size
        parts, end = catenary(drive.ropes[number], size, axes @ weight_of(drive), pull, hung, keeps)
        if not keeps:
            directions = [force / np.hypot(*force) @ axes for force in (parts[0].force, end)]
    return axes, directions, parts


def frequencies(drive, pulls, *, keeps=False, ways=PLANES, held=(), degree=26):
    """The first natural frequencies [Hz] of each of some sets of ways, by default in and out of the plane.

    ``pulls``: of each span along its chord [N]; ``keeps``: as of a loop or line, whose parts keep their
    unstretched lengths and whose rims move the rope along the chord; ``held``: coordinates at rest.
    """
    kin = Kinematics(drive)
    values, slopes, weights, points = shape_functions(degree)
    n = kin.size + 3 * len(drive.carriage)
    spans = list(zip(span_frames(drive), pulls, strict=True))
    bubbles = np.arange(n, n + 3 * (degree - 1) * (len(spans) + len(drive.carriage)))
    total = n + bubbles.size
    unit, inner = np.eye(total), iter(bubbles.reshape(-1, degree - 1, 3))
    m, k = (np.pad(own, (0, total - kin.size)) for own in solid_parts(drive, kin))
    for number, (frame, pull) in enumerate(spans):
        own = sorted(
            (place / frame[3], one.mass, one.guided, kin.size + 3 * i)
            for i, (one, (at, place)) in enumerate(zip(drive.carriage, drive.carriage_places, strict=True))
            if at == number
        )
        axes, directions, parts = settled(drive, frame, pull, [one[:3] for one in own], keeps)
        joints = []
        for place, direction in zip(frame[:2], directions, strict=True):
            moved = kin.slope(place[0], place[1]) + np.outer(direction, kin.rim(place))
            joints.append(np.pad(axes @ moved, ((0, 1), (0, total - kin.size))))
        for _, mass, guided, i in own:
            joints.insert(-1, unit[i : i + 3] * [[1.0], [not guided], [not guided]])
            m += mass * joints[-2].T @ joints[-2]
        for part, near, far in zip(parts, joints[:-1], joints[1:], strict=True):
            rows = np.concatenate(([near, far], unit[next(inner)])).reshape(-1, total)
            direction, tension, stretch = part.at(points)
            direction = np.pad(direction, ((0, 0), (0, 1)))
            along = direction[:, :, None] * direction[:, None, :]
            across = (tension / stretch)[:, None, None] * (np.eye(3) - along)
            block = weights[:, None, None] / part.length * (part.rigidity * along + across)
            stiff = np.einsum("iq,jq,qab->iajb", slopes, slopes, block, optimize=True)
            k += rows.T @ stiff.reshape(len(rows), -1) @ rows
            mass = drive.ropes[frame[4]].density * part.length * (values * weights) @ values.T
            m += rows.T @ np.kron(mass, np.eye(3)) @ rows
    way = np.concatenate((np.zeros(kin.size), np.resize(range(3), total - kin.size)))
    free = (np.diag(m) > 0.0) & ~np.isin(range(total), held)
    found = []
    for own in (np.ix_(*[free & np.isin(way, one)] * 2) for one in ways):
        top = eigh(k[own], m[own], eigvals_only=True)[: COUNTED + 1][-1]
        found.append(rope_fem.frequencies(m[own], k[own], np.sqrt(top)) / (2.0 * np.pi))
    return found


# --- Sag at the middle [m] and horizontal tension [N] of a level span (Irvine, Cable Structures, section 2.3)


def parabola_sag(drive):
    """A parabola stretched by its own sag, limit of the consistent weak law: H = T0 + K/24 (q L_e / H)^2."""
    cable, length = drive.cable, drive.pulley_distance
    weight = cable.stretched_mass_per_length * drive.layout.gravity_across * length
    stiffness = (cable.axial_rigidity + cable.pretension) / 24.0 * weight**2
    highest = cable.pretension + stiffness ** (1.0 / 3.0)
    tension = brentq(lambda h: h - cable.pretension - stiffness / h**2, cable.pretension, highest, **CLOSE)
    return weight * length / (8.0 * tension), tension


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
