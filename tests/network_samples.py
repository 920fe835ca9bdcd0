"""Random networks, loops and lines that hang; machines with routes, of the tests' own files and of drives."""

from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np

import cabledrive as cd
from cabledrive.mechanics import rest_state
from cabledrive.modal import elements
from cabledrive.modal.component import Component, Fixed
from cabledrive.modal.elements import ACROSS, ALONG, Wave
from cabledrive.modal.rows import MASS, SPRING
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.parameters.route.two_pulleys import as_machine
from oracles.network_fem import String
from oracles.rope_fem import Beam, HangingRope

ROUTES = Path(__file__).parent / "parameters" / "routes"


def route(name, *overrides):
    """A machine of the tests' own files."""
    return cd.load_drive(ROUTES / f"{name}.toml", overrides=overrides).listed


def routed(text):
    """A machine with routes from its text, without the three lines that each begins with."""
    return drive_from_text(f'schema = 1\nkind = "route"\nname = "machine"\n{text}')


def evenly(tension, length):
    """Tension along a rope that changes evenly from its start to its end."""
    return lambda x: tension[0] + (tension[1] - tension[0]) * np.asarray(x) / length


def vanishing(tension, length):
    """Where that tension would vanish, from the start."""
    return tension[0] * length / (tension[0] - tension[1]) if tension[0] != tension[1] else np.inf


def random_network(rng, moving):
    """A component of 2 to 6 coordinates with dense rows, and the same for the oracle."""
    n, links = int(rng.integers(2, 7)), int(rng.integers(1, 5))
    mass = np.where(rng.random(n) < 0.25, 0.0, rng.uniform(0.05, 3.0, n))  # massless idlers among them
    spring = np.where(rng.random(n) < 0.5, 0.0, rng.uniform(0.1, 30.0, n))
    strings = []
    for _ in range(links + n):  # enough of them that each coordinate is tied
        start, end = rng.normal(size=(2, n)) * (rng.random((2, n)) < 0.6)
        if not (start.any() or end.any()):
            start = rng.normal(size=n)
        c = rng.uniform(0.5, 4.0)
        v = rng.uniform(-0.85, 0.85) * c if moving and rng.random() < 0.7 else 0.0
        ropes = 1 if moving else int(rng.integers(1, 4))
        strings.append(String(start, end, rng.uniform(0.1, 2.0), c, v, ropes))
    waves = [
        Wave(
            row_of(one.start),
            row_of(one.end),
            one.density * one.wave_speed,
            one.wave_speed / (one.wave_speed**2 - one.speed**2),
            (number, ALONG),
            one.speed / (one.wave_speed**2 - one.speed**2),
            one.ropes,
        )
        for number, one in enumerate(strings)
    ]
    fixed = [Fixed(MASS, value, ((i, 1.0),)) for i, value in enumerate(mass) if value > 0]
    fixed += [Fixed(SPRING, value, ((i, 1.0),)) for i, value in enumerate(spring) if value > 0]
    component = Component(range(n), [*waves, *fixed])
    others = np.array([one.ropes - 1 for one in strings])
    return component, strings, np.diag(mass), np.diag(spring), others


def row_of(values):
    return tuple((i, float(value)) for i, value in enumerate(values) if value)


def _with(component, ropes):
    """The component with ropes besides."""
    return Component(component.columns, [*component.waves, *ropes, *component.fixed])


def random_elastic_network(rng):
    """A random network with two or three heavy strings and tensioned beams, and the same for the oracle."""
    component, strings, mass, spring, others = random_network(rng, False)
    n, links, beams = component.columns.size, [], []
    for number in range(int(rng.integers(2, 4))):
        rows = rng.normal(size=(4, n)) * (rng.random((4, 1)) < 0.7)
        rows[0] += 0.1 * rng.normal(size=n)
        length, density = rng.uniform(0.3, 2.0), rng.uniform(0.1, 2.0)
        tension = rng.uniform(0.5, 20.0, 2) if rng.random() < 0.7 else np.full(2, rng.uniform(0.5, 20.0))
        # From a rope, through a belt, to a beam that is hardly tensioned.
        bending = 0.0 if number == 0 else float(tension[0] * length**2 * 10 ** rng.uniform(-7, 1))
        if bending > 1e-4 * tension[0] * length**2:
            tension[1] = tension[0]
        elif number > 0:
            tension[1] = tension[0] * rng.uniform(0.7, 1.4)
        ropes = int(rng.integers(1, 4))
        rows = rows if bending else rows[[0, 2]]
        own = [row_of(one) for one in rows]
        half = len(own) // 2
        hold = evenly(tension, length)
        tag = ((number, ACROSS),)
        links.append(
            elements.Rope(
                tuple(own[:half]),
                tuple(own[half:]),
                length,
                hold,
                density,
                tag,
                bend=bending,
                ropes=ropes,
                vanishes=vanishing(tension, length),
            )
        )
        beams.append(Beam(rows, length, density, bending, tuple(tension), ropes))
    return _with(component, links), strings, beams, mass, spring, others


def random_hanging_network(rng):
    """A random network with one to three hanging ropes, some of them stiff, and the same for the oracle."""
    component, strings, mass, spring, others = random_network(rng, False)
    n, links, ropes = component.columns.size, [], []
    for number in range(int(rng.integers(1, 4))):
        length, density = rng.uniform(0.3, 2.0), rng.uniform(0.1, 2.0)
        mean = rng.uniform(0.5, 20.0)
        tension = (mean, mean * rng.uniform(0.7, 1.4))
        bending = mean * length**2 * 10 ** rng.uniform(-5, -1) if rng.random() < 0.4 else 0.0
        load, shear = mean / length * rng.normal(size=2) * 10 ** rng.uniform(-3, -1)
        rigidity = mean * 10 ** rng.uniform(0.5, 3.5)
        ends = 3 if bending else 2
        rows = rng.normal(size=(2 * ends, n)) * (rng.random((2 * ends, 1)) < 0.7)
        rows[0] += 0.1 * rng.normal(size=n)
        count = int(rng.integers(1, 4))
        own = (rows, length, density, rigidity, bending, tension, shear * length, load, count)
        ropes.append(HangingRope(*own))
        links.append(rope_of(ropes[-1], number))
    return _with(component, links), strings, ropes, mass, spring, others


def rope_of(own, number=0):
    """The element of a hanging rope of the oracle."""
    half = len(own.rows) // 2
    rows = [row_of(one) for one in own.rows]

    def direction(x):
        slope = own.slope(x)
        return 1.0 / np.sqrt(1.0 + slope**2), slope / np.sqrt(1.0 + slope**2)

    return elements.Rope(
        tuple(rows[:half]),
        tuple(rows[half:]),
        own.length,
        own.taut_at,
        own.density / own.stretch,
        ((number, ALONG), (number, ACROSS)),
        np.inf,  # its tension changes by less than half
        direction=direction,
        pull=own.rigidity * own.stretch,
        bend=own.bending,
        ropes=own.ropes,
    )


def as_routes(drive, **options):
    """A drive with two pulleys as if its file listed routes: without names and angles of its own."""
    return (as_machine(drive, **options) if options else drive.machine).plain


def as_route(drive):
    """So without gravity."""
    return as_routes(without_gravity(drive))


def without_gravity(drive):
    """The drive in free fall, where strings are straight."""
    return replace(drive, layout=replace(drive.layout, gravity=0.0))


PRINTER_SPANS = np.array([0.18, 0.40, 4.732e-3, 0.18])
"""Lengths of the belt of `printer.toml` from head to motor, lower idler, upper idler and head [m]."""


def printer_belt(counts, lumped=False):
    """Mass and stiffness of that belt as a ring of elements, so many a span, and where spans start: by hand.

    Its coordinate is the motion of the belt; ``lumped``: half of the mass of each element at either end.
    """
    rigidity, density, stretch = 19.4e3, 8.3e-3, 1.0 + 30.0 / 19.4e3
    starts = np.concatenate(([0], np.cumsum(counts)))
    n, own = starts[-1], np.eye(2) / 2.0 if lumped else np.array([[2, 1], [1, 2]]) / 6.0
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    for start, count, length in zip(starts, counts, PRINTER_SPANS / stretch, strict=False):
        for node in range(start, start + count):
            pair = np.ix_(*[[node, (node + 1) % n]] * 2)
            stiffness[pair] += rigidity * count / length * np.array([[1, -1], [-1, 1]])
            mass[pair] += density * length / count * own
    mass[starts[:4], starts[:4]] += [0.35, (1.6e-7 + 54e-7) / 6.366e-3**2, 3e-8 / 4e-3**2, 3e-8 / 4e-3**2]
    return mass, stiffness, starts


def hanging_drive(rng, *, vertical=False, heaviest=1.0, most=2, deepest=0.2):
    """Line or loop, small pulleys, any slope, load, carriages; ``deepest``: sag over length of a section."""
    while True:
        kind = str(rng.choice(["loop", "line"]))
        tension, length = 10 ** rng.uniform(1, 4), 10 ** rng.uniform(-0.5, 2)
        weight = 10 ** rng.uniform(-3, -0.7) * tension
        slope = float(rng.choice([-90.0, 90.0])) if vertical else float(rng.uniform(-75, 75))
        carriages = tuple(
            cd.Carriage(
                mass=weight / 9.81 * rng.uniform(0.1, heaviest),
                span=str(rng.choice(["upper", "lower"] if kind == "loop" else ["upper"])),
                position=length * (i + rng.uniform(0.2, 0.8)) / 3,
                guided=bool(rng.integers(2)),
            )
            for i in range(rng.integers(0, most + 1))
        )
        rim = weight / 9.81 * 10 ** rng.uniform(-0.5, 2) * 1e-5**2
        drive = cd.Drive(
            schema=1,
            name="machine",
            kind=kind,
            cable=cd.Cable(
                youngs_modulus=1e9,
                area=tension * 10 ** rng.uniform(2, 3.3) / 1e9,
                mass_per_length=weight / 9.81 / length,
                pretension=tension,
            ),
            layout=cd.Layout(span_length=length, inclination=radians(slope), gravity=9.81),
            pulley=(
                cd.Pulley(radius=1e-5, inertia=rim),
                cd.Pulley(radius=1e-5, inertia=rim * 10 ** rng.uniform(-1, 1), fixed=bool(rng.integers(2))),
            ),
            carriage=carriages,
        )
        rest = rest_state(drive)
        taut = rest.lowest_tension > 0.05 * tension
        if taut and max(section.sag_ratio for section in rest.sections) < deepest:
            return drive
