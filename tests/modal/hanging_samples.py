"""Random machines with sagging spans, and the same as one divided cable."""

from itertools import pairwise

import numpy as np

from cabledrive.mechanics.network import statics_of
from cabledrive.parameters.route import RoutedDrive, parts
from oracles.route_fem import Kinematics, places

GRAVITY = 9.81


def random_machine(rng, steepest):
    """A rope from an anchor over one to three wheels to a drum with a motor or to a body on springs.

    ``steepest``: slope of the sag at the ends of the longest span, about.
    """
    wheels = int(rng.integers(1, 4))
    steps = rng.uniform(20.0, 60.0, wheels + 1)
    x = np.concatenate(([0.0], np.cumsum(steps)))
    y = 0.25 * x[-1] * rng.uniform(0.2, 1.0) * np.sin(np.pi * x / x[-1]) + rng.uniform(-0.2, 0.2) * x
    density = rng.uniform(0.5, 3.0)
    pull = density * GRAVITY * steps.max() / (2.0 * steepest)
    rigidity = pull * 10 ** rng.uniform(1.5, 3.5)
    radii = rng.uniform(0.05, 0.5, wheels + 1)
    drum = bool(rng.random() < 0.5)
    rope_mass = density * steps.mean()
    pulleys = [
        parts.RoutedPulley(
            name=f"wheel {i}",
            at=(x[i], y[i]),
            radius=radii[i],
            inertia=rng.uniform(0.05, 3.0) * rope_mass * radii[i] ** 2,
        )
        for i in range(1, wheels + 1)
    ]
    end = (x[-1], y[-1])
    last = parts.RoutedPulley(name="drum", at=end, radius=radii[0], inertia=0.1 * rope_mass * radii[0] ** 2)
    body = parts.Body(
        name="load",
        at=end,
        moves=("x", "y"),
        mass=rng.uniform(0.2, 5.0) * rope_mass,
        stiffness=rigidity / steps.mean() * rng.uniform(0.1, 2.0),
    )
    carriages = ()
    if rng.random() < 0.5:  # inside the first span
        carriages = (
            parts.RoutedCarriage(
                mass=rng.uniform(0.02, 0.3) * rope_mass,
                guided=False,
                position=rng.uniform(0.25, 0.75) * steps[0],
            ),
        )
    return RoutedDrive(
        name="random",
        cable=parts.Rope(given_rigidity=rigidity, mass_per_length=density, pretension=pull),
        layout=parts.RouteLayout(gravity=GRAVITY),
        body=() if drum else (body,),
        pulley=((last, *pulleys) if drum else tuple(pulleys)),
        anchor=(parts.Anchor(name="left", at=(0.0, 0.0)),)
        + (() if drum else (parts.Anchor(name="end", at=end, on="load"),)),
        carriage=carriages,
        motor=(parts.RoutedMotor(inertia=rng.uniform(0.05, 2.0) * rope_mass * radii[0] ** 2),)
        if drum
        else (),
        route=(
            parts.Route(
                name="rope",
                path=("left", *(f"-{wheel.name}" for wheel in pulleys), "-drum" if drum else "end"),
            ),
        ),
    )


def divided(drive):
    """Spans, mass and stiffness for `oracles.hanging_machine`: body and wheels carry no other."""
    kin, statics = Kinematics(drive), statics_of(drive)
    rotor = drive.motor[0].inertia if drive.motor else 0.0
    wheels = [pulley.inertia + rotor * (pulley.name == "drum") for pulley in drive.pulley]
    mass = np.diag([*(drive.body[0].mass for _ in kin.moves), *wheels])
    stiffness = np.diag([*(drive.body[0].stiffness for _ in kin.moves), *(0.0 for _ in wheels)])
    ends = []
    for at, on, reach, name in places(drive, drive.route[0]):
        turn = np.zeros(kin.size)
        if name:
            turn[len(kin.moves) + kin.turning.index(name)] = reach
        ends.append({"": (np.array(at), reach), "_rows": kin.slope(at, on), "_turn": turn})
    spans, first = [], drive.free_spans[0].length
    for number, (start, end) in enumerate(pairwise(ends)):
        hung = [
            (carriage.position / first, np.array([0.0, -carriage.mass * GRAVITY]), carriage.mass)
            for carriage in (drive.carriage if number == 0 else ())
        ]
        spans.append(
            {
                "rigidity": drive.cable.axial_rigidity,
                "density": drive.cable.density,
                "gravity": (0.0, -GRAVITY),
                "chord": end[""][0] - start[""][0],
                "pull": float(statics.start[number]),
                **{f"start{key}": value for key, value in start.items()},
                **{f"end{key}": value for key, value in end.items()},
                "hung": hung,
            }
        )
    return spans, mass, stiffness
