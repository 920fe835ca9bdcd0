"""Steps of a network with axial damping and with slack, which its readable leapfrog does not take."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.simulation import Recording, Scheme, Sine
from cabledrive.simulation.network import simulate_network
from network_samples import as_route, without_gravity

pytestmark = pytest.mark.kernel
ROUTES = Path(__file__).parent.parent / "parameters" / "routes"
PRINTER = cd.load_drive(ROUTES / "printer.toml")


def test_a_damped_loop_as_a_route_steps_as_the_loop():
    """Axial damping, implicit in the mean speeds of nodes and rims: two kernels that share no code."""
    drive = without_gravity(cd.load_drive("dissertation-3"))
    free = replace(drive.motor, offset_torque=0.0, coulomb_friction=0.0, viscous_friction=0.0)
    drive = replace(drive, cable=replace(drive.cable, axial_damping=30.0), motor=free)
    machine = as_route(drive)
    damping = drive.cable.transverse_damping
    cable = replace(machine.cable, transverse_damping=damping, axial_damping=30.0)
    motors = tuple(replace(one, joint_damping=drive.motor.joint_damping) for one in machine.motor)
    machine = replace(machine, cable=cable, motor=motors)
    common = {"scheme": Scheme(segments=4, model="linear"), "recording": Recording(rate=10_000.0)}
    loop = cd.simulate(drive, 0.004, torque=Sine(amplitude=1.0, frequency=200.0), **common)
    route = simulate_network(machine, 0.004, torque=Sine(amplitude=-1.0, frequency=200.0), **common)
    assert route.summary()["cfl"] == pytest.approx(loop.summary()["cfl"], rel=2e-3)
    pairs = [
        (-route.channel("rotor of drive pulley"), loop.channel("motor_angle")),
        (-route.channel("load pulley"), loop.load_angle),
        (route.channel("axial_loss"), loop.channel("axial_loss")),
    ]
    for ours, theirs in pairs:
        assert np.abs(theirs).max() > 0.0
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-10 * np.abs(theirs).max())


def test_steps_that_meet_slack_do_not_depend_on_how_many_are_taken_at_once():
    """Between two records taut steps are taken together, and taken back where a span goes slack."""
    step = 5e-7
    scheme = Scheme(segments=4, slack="tension-only", step=step)
    fine, coarse = (
        simulate_network(
            PRINTER, 240 * step, torque=200.0, scheme=scheme, recording=Recording(rate=1.0 / (every * step))
        )
        for every in (1, 120)
    )
    assert fine.slack_events
    assert fine.slack_events[0]["time"] % (120 * step) > step
    for name in (*PRINTER_BODIES, "coulomb_loss"):
        np.testing.assert_allclose(fine.channel(name)[::120], coarse.channel(name), rtol=1e-12, err_msg=name)


PRINTER_BODIES = tuple(one.name for one in PRINTER.pulley if one.inertia > 0.0)
