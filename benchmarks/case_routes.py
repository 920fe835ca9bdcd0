"""Machines with routes: modes of a CoreXY, its map over the bed, a ropeway, a loop as a route in time."""

import os
import time
from dataclasses import replace

import numpy as np
from harness import side_by_side, table

import cabledrive as cd
from cabledrive.parameters import Drive, Machine
from cabledrive.parameters.route.parts import Rope, Route, RoutedCarriage, RoutedPulley, RouteLayout
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start
from cabledrive.studies.mode_map import map_modes

TITLE = "Machines with routes"
SIZES = (25, 50, 100, 200)
MODES, GRID, CORES = 50, 30, 2
SECONDS, RECORDS = 1.0, 1000.0


def report() -> str:
    return f"{corexy()}\n\n{bed()}\n\n{ropeways()}\n\n{in_time()}"


def corexy() -> str:
    drive = cd.load_drive("corexy")
    timing = side_by_side({"modes": lambda: cd.modes(drive, below=300.0)})["modes"]
    number = timing.result.certificate.count
    return f"CoreXY, {number} modes to 300 Hz, certified: {1e3 * timing.median:.1f} ms ± {timing.spread:.0%}."


def bed() -> str:
    drive, one = cd.load_drive("corexy"), os.sched_getaffinity(0)
    vary = {"head.x": np.linspace(0.06, 0.36, GRID), "beam.y": np.linspace(0.05, 0.33, GRID)}
    os.sched_setaffinity(0, range(CORES))  # the harness keeps to one core
    start = time.perf_counter()
    map_modes(drive, vary, workers=CORES)
    seconds = time.perf_counter() - start
    os.sched_setaffinity(0, one)
    return f"Map of {GRID} x {GRID} positions on {CORES} cores: {seconds:.1f} s on the wall."


def ropeways() -> str:
    """First longitudinal modes; the rope without and with its bending stiffness."""
    rows = []
    for sheaves in SIZES:
        machines = {bends: ropeway(sheaves, bends) for bends in (False, True)}
        times = side_by_side(
            {
                bends: lambda own=own: cd.natural_frequencies(own, count=MODES)
                for bends, own in machines.items()
            },
            rounds=5,
        )
        shown = [f"{times[bends].median:.2f} s ± {times[bends].spread:.0%}" for bends in (False, True)]
        rows.append([str(sheaves), str(sheaves // 2), *shown])
    return table(["sheaves", "cabins", f"first {MODES} modes", "rope with bending stiffness"], rows)


def ropeway(sheaves: int, bends: bool) -> Machine:
    """The packaged ropeway, longer: a tower of five sheaves every 220 m on a convex line, a cabin for two."""
    drive = cd.load_drive("ropeway-towers")
    towers, template = sheaves // 5, next(own for own in drive.pulley if own.name.startswith("tower"))
    length = 220.0 * (towers + 1)
    drive_wheel, back = (own for own in drive.pulley if not own.name.startswith("tower"))
    pulleys = [drive_wheel, replace(back, at=(length, 0.0))]
    for tower in range(towers):
        for place in range(5):
            x = length - 220.0 * (tower + 1) + 1.2 - 0.6 * place
            y = 8.0 + 8.0 * (1.0 - (2.0 * x / length - 1.0) ** 2)
            pulleys.append(replace(template, name=f"tower {tower + 1} {place + 1}", at=(x, y)))
    cabins = sheaves // 2
    path = ("+drive", "+return", *(f"+{own.name}" for own in pulleys[2:]))
    rope = (
        drive.cable if bends else replace(drive.cable, type="", bending_stiffness=None, given_rigidity=100e6)
    )
    return replace(
        drive,
        pulley=tuple(pulleys),
        body=(replace(drive.body[0], at=(length, 0.0)),),
        carriage=tuple(
            RoutedCarriage(route="rope", mass=750.0, guided=False, position=2 * length * (i + 0.37) / cabins)
            for i in range(cabins)
        ),
        route=(replace(drive.route[0], path=path),),
        cable=rope,
    )


def in_time() -> str:
    """A loop, plucked and driven, beside the same written as a route: process time of 1 s of motion."""
    loop = cd.load_drive("dissertation-2").two_pulleys
    loop = replace(loop, layout=replace(loop.layout, gravity=0.0))
    route, rows = written_as_route(loop), []
    starts = {
        "loop": (loop, Start(plucks=(Pluck(height=1e-3),))),
        "route": (route, Start(plucks=(Pluck(height=1e-3, span="drive to load"),))),
    }
    for segments in (200, 40):
        given = {
            "torque": Sine(amplitude=0.02, frequency=81.7),
            "scheme": Scheme(segments=segments),
            "recording": Recording(rate=RECORDS),
        }
        times = side_by_side(
            {
                name: lambda drive=drive, start=start, given=given: cd.simulate(
                    drive, SECONDS, start=start, **given
                )
                for name, (drive, start) in starts.items()
            },
            rounds=9,
        )
        shown = [
            f"{1e3 * times[name].median:.0f} ms ± {times[name].spread:.0%}" for name in ("loop", "route")
        ]
        ratio = times["route"].median / times["loop"].median
        rows.append([str(segments), *shown, f"{ratio:.2f}"])
    return table(["segments per span", "loop", "as a route", "ratio"], rows)


def written_as_route(loop: Drive) -> Machine:
    """The two pulleys of a loop as a machine with one closed route, without gravity."""
    names = ("drive", "load")
    return Machine(
        name=loop.name,
        cable=Rope(
            given_rigidity=loop.cable.axial_rigidity,
            mass_per_length=loop.cable.mass_per_length,
            pretension=loop.cable.pretension,
            transverse_damping=loop.cable.transverse_damping,
        ),
        layout=RouteLayout(gravity=0.0),
        pulley=tuple(
            RoutedPulley(
                name=name,
                at=(i * loop.pulley_distance, 0.0),
                radius=own.radius,
                inertia=own.inertia,
                viscous_friction=own.viscous_friction,
                coulomb_friction=own.coulomb_friction,
            )
            for i, (name, own) in enumerate(zip(names, loop.pulley, strict=True))
        ),
        route=(Route(name="cable", path=("-drive", "-load"), closed=True),),
    )
