"""Runs of the rig: with the gains and the pulse of the dissertation unless others are given; of carriages."""

from dataclasses import replace

import numpy as np

from cabledrive.control.transporter import frozen_poles
from cabledrive.parameters import Motor
from cabledrive.reduction.transporter import frozen_frequencies, transporter_of
from cabledrive.rig import Motion, RigOptions, carriage
from cabledrive.rig import track as track_anew
from cabledrive.rig.closed_loop.loop import close_loop
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.setting import DISSERTATION_ORDER, sample_interval
from cabledrive.rig.tuning import design as design_law


def track(drive, *, motion=None, gains="dissertation", **choices):
    """Run a law with the gains and the pulse of the dissertation."""
    motion = motion or Motion()
    if motion.order is None:
        motion = replace(motion, order=DISSERTATION_ORDER)
    return track_anew(drive, motion=motion, gains=gains, **choices)


def loop_of(law, drive, motion, options=None, plant=None, **choices):
    """A loop around a law, given or designed by its name without a word of the rig's options."""
    made = design_law(law, DesignSpec(drive, motion, **choices)) if isinstance(law, str) else law
    spec = DesignSpec(drive, motion, options=options or RigOptions())
    return close_loop(spec, made, np.random.default_rng(0), plant)


# --- A transporter large enough to carry a load, and what is left of its motion
SPREADS = {
    "payload_mass": 0.10,
    "line_length": 0.05,
    "axial_rigidity": 0.05,
    "coulomb": 0.06,
    "viscous": 0.06,
    "rail_friction": 0.2,
    "carriage_mass": 0.02,
}
"""Relative half widths of a drawn plant; its offset is up to 0.3 N."""


def scaled_transporter(drive):
    """A span of 1.5 m, 10 N, a carriage of 0.5 kg at 0.25 m, the motor of configuration 3."""
    motor = Motor(inertia=0.0011, viscous_friction=0.0031, coulomb_friction=0.0376, torque_limit=2.1)
    damping = 5e-4 * drive.cable.axial_rigidity
    return replace(
        drive,
        cable=replace(drive.cable, pretension=10.0, axial_damping=damping),
        layout=replace(drive.layout, span_length=1.5),
        carriage=(replace(drive.carriage[0], mass=0.5, position=0.25),),
        motor=motor,
        sensors=replace(drive.sensors, sample_rate=5000.0),
    )


def drawn(plant, generator):
    """A random plant about another."""
    moved = {n: getattr(plant, n) * (1.0 + s * generator.uniform(-1.0, 1.0)) for n, s in SPREADS.items()}
    return plant._replace(**moved, offset=float(generator.uniform(-0.3, 0.3)))


def residual_motion(drive, law, *, runs=8, seed=0, among=False, gust=0.0):
    """Largest distance from the place of rest at once and two seconds later, shape (2, runs) [m]."""
    move = carriage.CarriageMove(gust=(gust, 1.0, 1.5))
    plant = transporter_of(drive, payload_mass=move.payload_mass, line_length=move.line_length)
    found = []
    for i, generator in enumerate(np.random.default_rng(seed).spawn(runs)):
        actual = drawn(plant, generator) if among else plant
        run = carriage.move_carriage(drive, law, move=move, plant=actual, seed=seed + i)
        found.append((run.residual(), run.residual(later=2.0)))
    return np.array(found).T


def along_the_way(drive, law, *, positions=41, rigidity=1.0):
    """Largest real part of a pole [1/s] and frequencies [Hz] of the frozen plant at places along the way."""
    move, interval = carriage.CarriageMove(), sample_interval(drive)
    design = transporter_of(drive, payload_mass=move.payload_mass, line_length=move.line_length)
    plant = design._replace(axial_rigidity=rigidity * design.axial_rigidity)
    places = np.linspace(
        design.start - carriage.MARGIN, design.start + move.distance + carriage.MARGIN, positions
    )
    made = carriage.made_law(drive, design, law, move)
    largest = [np.abs(frozen_poles(made, plant, float(x), interval)).max() for x in places]
    hertz = np.array([frozen_frequencies(plant, float(x)) for x in places]) / (2.0 * np.pi)
    return np.log(largest) / interval, hertz
