"""The damping-aware law on chains of three, four and five inertias."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.control.kalman import KalmanTuning
from cabledrive.parameters import load_drive
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run
from cabledrive.rig.laws.controllers import law_for_chain
from cabledrive.rig.setting import Motion, RigOptions
from cabledrive.rig.trial import spec_for

COUNTS = 40_000
COUNT = 360.0 / COUNTS
MOTION = Motion(angle=45.0, rise=0.5, dwell=0.3, order=13)
TUNING = KalmanTuning(torque=1e-6, disturbance=1e-2, load_acceleration=0.1)
GIVEN = load_drive("dissertation-3")
DRIVE = replace(
    GIVEN,
    sensors=replace(GIVEN.sensors, motor_encoder=COUNTS, drive_encoder=None, load_encoder=COUNTS),
    motor=replace(GIVEN.motor, torque_limit=None),
    cable=replace(GIVEN.cable, pretension=200.0),
)
"""What carries the chain: encoders on motor and load, sampled at 5 kHz, no limit of the torque, no slack."""
CLEAN = RigOptions(ideal_sensors=True, smooth_friction=True, forbid_slack=True)
READ = RigOptions(forbid_slack=True)


def arm() -> LumpedChain:
    """Three-inertia model of an industrial robot's arm: E. Wernholt and S. Gunnarsson, motor side."""
    whole, motor, gear = 0.03291699877416, 0.17910964111956, 0.61206166914114
    return LumpedChain(
        names=("motor", "gear", "load"),
        inertias=(whole * motor, whole * gear, whole * (1.0 - motor - gear)),
        viscous=(0.00986346744839, 0.0, 0.0),
        coulomb=(0.74302635727901, 0.0, 0.0),
        offsets=(0.0, 0.0, 0.0),
        stiffness=(20.59269827430799, 20.23072060978318),
        damping=(0.06241814047290, 0.00987527995798),
        ratios=((1.0, 1.0), (1.0, 1.0)),
    )


def row(n: int) -> LumpedChain:
    """A motor, light pulleys and a heavy load behind ever softer cables."""
    return LumpedChain(
        names=("motor", *(f"pulley {i}" for i in range(2, n)), "load"),
        inertias=(1.1e-3, *(6e-4,) * (n - 2), 2.3e-3),
        viscous=(3e-3, *(0.0,) * (n - 1)),
        coulomb=(0.04, *(0.0,) * (n - 1)),
        offsets=(0.0,) * n,
        stiffness=tuple(np.linspace(60.0, 8.0, n - 1)),
        damping=tuple(np.linspace(0.05, 0.03, n - 1)),
        ratios=((1.0, 1.0),) * (n - 1),
    )


def closed(chain: LumpedChain, hertz: float, options: RigOptions, design: LumpedChain | None = None) -> Loop:
    """The law on the chain; ``design``: as the law believes it to be."""
    spec = spec_for(DRIVE, MOTION, bandwidth=hertz)
    law = law_for_chain(spec, design or chain, tuning=TUNING)
    return close_loop(DRIVE, DRIVE, law, MOTION, options, np.random.default_rng(0), plant=chain)


def peak(loop: Loop) -> float:
    done = run(loop)
    assert done.ended == len(loop.target)
    return float(np.degrees(np.abs(done.log[:, loop.chain.size - 1] - loop.target).max()))


@pytest.mark.parametrize("chain", [arm(), row(4), row(5)], ids=["arm", "four", "five"])
def test_smooth_friction_and_true_states_leave_a_ten_thousandth_of_a_degree(chain, measured):
    """35 Hz, above every chain's lowest mode; what is left is friction's turn within tanh(50 w)."""
    found = peak(closed(chain, 35.0, CLEAN))
    measured(f"{found:.1e} deg")
    assert found < 2e-4, f"observed {found:.1e} deg"


@pytest.mark.parametrize(
    "chain, hertz", [(arm(), 20.0), (row(4), 35.0), (row(5), 35.0)], ids=["arm", "four", "five"]
)
def test_two_encoders_and_stick_slip_leave_two_counts(chain, hertz, measured):
    """Motor and load encoders of 0.009 deg a count, zeros off by a third of one; the rest is observed."""
    loop = closed(chain, hertz, READ)
    found = peak(replace(loop, rig=loop.rig._replace(phases=np.array([0.3, -0.2]))))
    measured(f"{found:.4f} deg, {found / COUNT:.2f} counts")
    assert found < 2.0 * COUNT, f"observed {found:.4f} deg"


def test_leaving_the_dampers_out_costs_most_of_the_accuracy():
    """A design that believes in a tenth of the damping, on the chain as it is."""
    chain = row(4)
    believed = replace(chain, damping=tuple(0.1 * b for b in chain.damping))
    right, wrong = peak(closed(chain, 35.0, CLEAN)), peak(closed(chain, 35.0, CLEAN, believed))
    assert wrong > 20.0 * right, f"observed {wrong:.4f}, {right:.5f} deg"


def test_a_bandwidth_below_the_chains_own_modes_cannot_hold_its_friction():
    """The loop's stiffness falls with the (2n - 1)-th power of the bandwidth: 10 Hz is lost on five."""
    chain = row(5)
    assert natural_frequencies_of(chain)[0] / (2.0 * np.pi) > 10.0
    rough = replace(CLEAN, smooth_friction=False)
    low, high = (peak(closed(chain, f, rough)) for f in (10.0, 20.0))
    assert low > 1.0 > 0.2 > high, f"observed {low:.3f}, {high:.3f} deg"
