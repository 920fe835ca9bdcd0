"""A motor, three light pulleys and a heavy load behind four cables: the same law, one derivation.

Encoders sit on motor and load only, 40,000 counts in a turn, their zeros unknown. The torque of the motor
needs ten derivatives of the motion, of which the dampers smooth four: a pulse of order 13 makes it without a
jump. The bandwidth has to lie above the lowest mode: the loop's stiffness falls with the ninth power of it,
and at 10 Hz friction wins.
"""

from dataclasses import replace

import numpy as np

import cabledrive as cd
from cabledrive.control.observers import KalmanTuning
from cabledrive.reduction.lumped_chain import natural_frequencies_of
from cabledrive.rig.closed_loop.loop import close_loop, run
from cabledrive.rig.laws.controllers import DesignSpec, law_for_chain
from cabledrive.rig.setting import Motion, RigOptions

chain = cd.LumpedChain(
    names=("motor", "first", "second", "third", "load"),
    inertias=(1.1e-3, 6e-4, 6e-4, 6e-4, 2.3e-3),  # kg m^2
    viscous=(3e-3, 0.0, 0.0, 0.0, 0.0),  # N m s/rad
    coulomb=(0.04, 0.0, 0.0, 0.0, 0.0),  # N m
    offsets=(0.0, 0.0, 0.0, 0.0, 0.0),
    stiffness=(60.0, 42.0, 25.0, 8.0),  # N m/rad
    damping=(0.05, 0.043, 0.037, 0.03),  # N m s/rad
    ratios=((1.0, 1.0),) * 4,
)
drive = cd.load_drive(
    "dissertation-3"
).two_pulleys  # motor, encoders and sampling; the chain stands for its mechanics
fitted = replace(drive.sensors, motor_encoder=40_000, drive_encoder=None, load_encoder=40_000)
drive = replace(drive, sensors=fitted)
motion, options = Motion(angle=45.0, rise=0.5, dwell=0.3, order=13), RigOptions(forbid_slack=True)
tuning = KalmanTuning(torque=1e-6, disturbance=1e-2, load_acceleration=0.1)
law = law_for_chain(DesignSpec(drive, motion, bandwidth=35.0), chain, tuning=tuning)
loop = close_loop(DesignSpec(drive, motion, options=options), law, np.random.default_rng(0), chain)
error = np.degrees(np.abs(run(loop).log[:, 4] - loop.target).max())

print("modes", np.round(natural_frequencies_of(chain) / (2.0 * np.pi), 1), "Hz")
print(f"peak error {error:.4f} deg, one count {360.0 / 40_000:.4f} deg")

assert error < 2.0 * 0.009, error
