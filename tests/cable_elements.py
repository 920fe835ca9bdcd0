"""Finite elements of the hanging cable, for comparison: nothing here knows a wave, a string or a catenary.

The places r(s) of the cable in each span's own plane are polynomials on elements of high degree. Newton's
method on the potential energy of a Hookean cable finds the rest; second differences of the same energy at
rest, with the masses, give every small motion: in the plane of gravity (x along, y down) and out of it.
"""

from dataclasses import replace
from itertools import pairwise
from math import cos, pi, radians, sin

import numpy as np
from scipy.linalg import eigh

from cabledrive.mechanics import rest_state
from cabledrive.parameters import Cable, Carriage, Drive, Layout, Pulley

DEGREE, GRAVITY = 5, 9.81
SMALL = 1e-5
"""Radius of a pulley that sag leaves at the tangent point of a straight rope [m]."""


def _basis(degree):
    nodes = np.concatenate(
        ([-1.0], np.polynomial.legendre.Legendre.basis(degree).deriv().roots().real, [1.0])
    )
    points, weights = np.polynomial.legendre.leggauss(degree + 2)
    vandermonde = np.vander(nodes, increasing=True)
    coefficients = np.linalg.inv(vandermonde)
    value = np.vander(points, degree + 1, increasing=True) @ coefficients
    powers = np.arange(1, degree + 1)
    slope = (np.vander(points, degree, increasing=True) * powers) @ coefficients[1:]
    return nodes, weights, value, slope


class Model:
    """A drive in elements."""

    def __init__(self, drive, per_stretch=6, degree=DEGREE):
        self.drive, self.basis = drive, _basis(degree)
        self.count = 0
        self.spans = []
        length = drive.span_length
        self.distance = drive.pulley_distance
        cable = drive.cable
        stretch = self.distance / length
        self.start = []
        self.carriage = {}
        self.held_y = []
        for number, span in enumerate(drive.spans):
            sign = -1.0 if number == 0 else 1.0
            gravity = drive.layout.gravity * np.array(
                [sign * sin(drive.layout.inclination), cos(drive.layout.inclination)]
            )
            stops = [0.0, *(c.position for c in drive.carriages_on(span)), length]
            cuts = [0.0]
            for a, b in pairwise(stops):
                cuts += list(a + (b - a) * np.arange(1, per_stretch + 1) / per_stretch)
            elements, ends = [], [self._node(0.0)]
            for a, b in pairwise(cuts):
                inner = [a + (b - a) * (t + 1) / 2 for t in self.basis[0][1:]]
                nodes = [ends[-1], *(self._node(s * stretch) for s in inner)]
                ends.append(nodes[-1])
                elements.append((np.array(nodes), (b - a) / 2.0))
            self.held_y += [ends[0], ends[-1]]
            for c in drive.carriages_on(span):
                node = ends[int(np.argmin(np.abs(np.array(cuts) - c.position)))]
                self.carriage[node] = (c.mass, gravity)
                self.held_y += [node] * c.guided
            self.spans.append((elements, gravity, ends[0], ends[-1]))
        self.rigidity, self.density = cable.axial_rigidity, cable.mass_per_length

    def _node(self, x):
        self.start.append((x, 0.0))
        self.count += 1
        return self.count - 1

    def maps(self, hold_drive, hold_load):
        """Matrix from unknowns to (x, y) of all nodes: rims of a loop move as one."""
        upper, *lower = self.spans
        rims = {
            "drive": [upper[2], *(own[3] for own in lower)],
            "load": [upper[3], *(own[2] for own in lower)],
        }
        held = {2 * node for nodes in rims.values() for node in nodes}
        held |= {2 * node + 1 for node in self.held_y}
        free = [unknown for unknown in range(2 * self.count) if unknown not in held]
        names = [name for name, hold in (("drive", hold_drive), ("load", hold_load)) if not hold]
        place = {name: len(free) + number for number, name in enumerate(names)}
        matrix = np.zeros((2 * self.count, len(free) + len(place)))
        matrix[free, range(len(free))] = 1.0
        for name, column in place.items():
            matrix[[2 * node for node in rims[name]], column] = 1.0
        return matrix, place

    def assemble(self, r):
        """Energy gradient, tangent, and the stiffness out of the plane."""
        n = self.count
        force, tangent, outward = np.zeros(2 * n), np.zeros((2 * n, 2 * n)), np.zeros((n, n))
        mass = np.zeros((n, n))
        _, weights, value, slope = self.basis
        for elements, gravity, _, _ in self.spans:
            for nodes, half in elements:
                d = slope / half
                gradient = d @ r[nodes]
                size = np.hypot(gradient[:, 0], gradient[:, 1])
                unit = gradient / size[:, None]
                tension = self.rigidity * (size - 1.0)
                w = weights * half
                pull = (w * tension)[:, None] * unit
                index = (2 * nodes[:, None] + np.arange(2)).ravel()
                element = d.T @ pull - np.outer(value.T @ w, self.density * gravity)
                force[index] += element.ravel()
                across = tension / size
                block = (self.rigidity - across)[:, None, None] * unit[:, :, None] * unit[:, None, :]
                block += across[:, None, None] * np.eye(2)
                k = np.einsum("q,qi,qab,qj->iajb", w, d, block, d).reshape(index.size, index.size)
                tangent[np.ix_(index, index)] += k
                outward[np.ix_(nodes, nodes)] += np.einsum("q,qi,qj->ij", w * across, d, d)
                mass[np.ix_(nodes, nodes)] += self.density * np.einsum("q,qi,qj->ij", w, value, value)
        for node, (m, gravity) in self.carriage.items():
            force[2 * node : 2 * node + 2] -= m * gravity
            mass[node, node] += m
        return force, tangent, outward, mass

    def solve(self):
        drive = self.drive
        matrix, place = self.maps(True, drive.load_pulley.fixed)
        outer = np.zeros(matrix.shape[1])
        if drive.kind == "line" and "load" in place:
            outer[place["load"]] = drive.cable.pretension
        rest = np.array(self.start)
        if drive.layout.gravity_across:  # begin below the line, where the energy is convex
            for elements, _, _, last in self.spans:
                for nodes, _ in elements:
                    x = rest[nodes, 0] / rest[last, 0]
                    rest[nodes, 1] = 0.05 * rest[last, 0] * x * (1 - x)
            rest[self.held_y, 1] = 0.0
        for _ in range(200):
            force, tangent, _, _ = self.assemble(rest)
            left = outer - matrix.T @ force
            step = np.linalg.solve(matrix.T @ tangent @ matrix, left)
            share = 1.0
            while share > 1e-4:
                trial = rest + share * (matrix @ step).reshape(-1, 2)
                new = outer - matrix.T @ self.assemble(trial)[0]
                if np.linalg.norm(new) <= (1 - 0.2 * share) * np.linalg.norm(left) or share < 2e-4:
                    break
                share /= 2
            rest = trial
            if np.abs(step).max() < 1e-13 * self.distance:
                break
        self.rest = rest
        return self

    def frequencies(self, count):
        """Lowest frequencies [Hz] in the plane and out of it."""
        drive, motor = self.drive, self.drive.motor
        _, tangent, outward, mass = self.assemble(self.rest)
        matrix, place = self.maps(drive.drive_pulley.fixed, drive.load_pulley.fixed)
        m, k = matrix.T @ np.kron(mass, np.eye(2)) @ matrix, matrix.T @ tangent @ matrix
        for name, pulley in zip(("drive", "load"), drive.pulley, strict=True):
            if name in place:
                m[place[name], place[name]] += pulley.rim_mass
        if motor:
            rotor, square = place["drive"], drive.drive_pulley.radius**2
            if motor.joint_stiffness:
                m, k = (np.pad(own, (0, 1)) for own in (m, k))
                ends = np.ix_([rotor, len(m) - 1], [rotor, len(m) - 1])
                k[ends] += motor.joint_stiffness / square * np.array([[1.0, -1.0], [-1.0, 1.0]])
                rotor = len(m) - 1
            m[rotor, rotor] += motor.inertia / square
            k[rotor, rotor] += (motor.holding_stiffness or 0.0) / square
        inside = eigh(k, m, eigvals_only=True, subset_by_index=[0, min(count, len(m)) - 1])
        free = np.setdiff1d(np.arange(self.count), self.held_y)
        out = eigh(outward[np.ix_(free, free)], mass[np.ix_(free, free)], eigvals_only=True)[:count]
        return np.sqrt(np.maximum(inside, 0.0)) / (2 * pi), np.sqrt(out) / (2 * pi)


def on_small_pulleys(drive):
    """The drive on pulleys so small that sag leaves the rope at the tangent point of a straight one."""
    shares = [(SMALL / pulley.radius) ** 2 for pulley in drive.pulley]
    pulleys = (
        replace(pulley, radius=SMALL, inertia=share * pulley.inertia)
        for pulley, share in zip(drive.pulley, shares, strict=True)
    )
    motor = drive.motor
    if motor:
        scaled = ("inertia", "joint_stiffness", "holding_stiffness")
        own = {name: shares[0] * getattr(motor, name) for name in scaled if getattr(motor, name) is not None}
        motor = replace(motor, **own)
    return replace(drive, pulley=tuple(pulleys), motor=motor)


def random_machine(rng, *, vertical=False, heaviest=1.0, most=2, deepest=0.2):
    """Lines and loops with any slope, load, carriages; ``deepest``: sag over the length of a section."""
    while True:
        kind = str(rng.choice(["loop", "line"]))
        tension, length = 10 ** rng.uniform(1, 4), 10 ** rng.uniform(-0.5, 2)
        weight = 10 ** rng.uniform(-3, -0.7) * tension
        slope = float(rng.choice([-90.0, 90.0])) if vertical else float(rng.uniform(-75, 75))
        carriages = tuple(
            Carriage(
                mass=weight / GRAVITY * rng.uniform(0.1, heaviest),
                span=str(rng.choice(["upper", "lower"] if kind == "loop" else ["upper"])),
                position=length * (i + rng.uniform(0.2, 0.8)) / 3,
                guided=bool(rng.integers(2)),
            )
            for i in range(rng.integers(0, most + 1))
        )
        rim = weight / GRAVITY * 10 ** rng.uniform(-0.5, 2) * SMALL**2
        drive = Drive(
            schema=1,
            name="machine",
            kind=kind,
            cable=Cable(
                youngs_modulus=1e9,
                area=tension * 10 ** rng.uniform(2, 3.3) / 1e9,
                mass_per_length=weight / GRAVITY / length,
                pretension=tension,
            ),
            layout=Layout(span_length=length, inclination=radians(slope), gravity=GRAVITY),
            pulley=(
                Pulley(radius=SMALL, inertia=rim),
                Pulley(radius=SMALL, inertia=rim * 10 ** rng.uniform(-1, 1), fixed=bool(rng.integers(2))),
            ),
            carriage=carriages,
        )
        rest = rest_state(drive)
        taut = rest.lowest_tension > 0.05 * tension
        if taut and max(section.sag_ratio for section in rest.sections) < deepest:
            return drive
