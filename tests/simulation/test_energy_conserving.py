"""The energy-conserving scheme through the public door: its budget, its order, its limits."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.drive_parts import Carriage
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation import CarriageForce, Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.simulation.case import case_of
from cabledrive.simulation.plan import new_workspace

LOOP = load_drive("dissertation-2")
MOTORED = load_drive("dissertation-3")
FORCED = Sine(amplitude=0.02, frequency=81.6)
PLUCKS = (Pluck(height=1e-3, shape="half-sine"), Pluck(height=5e-4, plane="v", shape="half-sine"))
EVERYTHING = replace(
    MOTORED,
    cable=replace(MOTORED.cable, axial_damping=2.0, transverse_damping=3.0),
    pulley=tuple(replace(p, viscous_friction=1e-3, coulomb_friction=2e-3) for p in MOTORED.pulley),
    carriage=(Carriage(mass=1e-3, position=0.3, guided=False),),
    layout=replace(MOTORED.layout, inclination=0.1),
)


def run(drive, duration, *, plucks=PLUCKS, torque=FORCED, rate=2000.0, forces=(), fields=0, **scheme):
    return simulate(
        drive,
        duration,
        torque=torque,
        forces=forces,
        start=Start(plucks=plucks),
        scheme=Scheme(**({"method": "energy-conserving", "segments": 20} | scheme)),
        recording=Recording(rate=rate, fields=fields),
    )


def assert_budget(result, tolerance, measured=None):
    if measured is not None:
        measured(f"{result.energy_budget_error:.1e} of the energy handled after {result.steps:,} steps")
    assert result.energy_budget_error < tolerance, f"{result.energy_budget_error:.1e} of the energy handled"


@pytest.mark.parametrize("segments", [20, pytest.param(Scheme().segments, marks=pytest.mark.verify)])
def test_budget_of_the_undamped_forced_loop_closes_to_round_off_over_ten_seconds(segments, measured):
    result = run(LOOP, 10.0, segments=segments)
    assert_budget(result, 1e-12, measured)
    assert result.steps > 15_000 * segments
    assert result.energy_handled > 1e-4


@pytest.mark.parametrize("model", ["exact", "weak-consistent", "linear"])
@pytest.mark.parametrize("friction", ["stick-slip", "smoothed"])
def test_budget_closes_with_every_loss_and_every_input(model, friction, measured):
    """Joint, carriage on a slope with forces on it, both frictions, both dampings of the cable."""
    forces = [
        CarriageForce(signal=Sine(amplitude=0.05, frequency=50.0), plane="w"),
        CarriageForce(signal=0.02),
    ]
    torque = Sine(amplitude=0.1, frequency=30.0)
    result = run(EVERYTHING, 0.2, torque=torque, forces=forces, model=model, friction=friction)
    assert_budget(result, 1e-12, measured)
    for name in ("transverse_loss", "axial_loss", "viscous_loss", "coulomb_loss", "joint_loss"):
        assert result.channel(name)[-1] > 0.0, f"{name} is {result.channel(name)[-1]:.2e} J"


def test_budget_closes_while_spans_go_slack_and_push():
    result = run(LOOP, 0.1, torque=Sine(amplitude=3.0, frequency=81.74), slack="record")
    assert result.slack_events
    assert_budget(result, 1e-12)


def bump(x):
    return np.sin(np.pi * x / LOOP.pulley_distance) ** 4


def end_of_run(drive, *, duration=1e-3, **scheme):
    plucks = (
        Pluck(height=5e-3, shape=bump),
        Pluck(height=-2.5e-3, span="lower", plane="v", shape=bump),
    )
    torque = lambda time: 0.3 * np.sin(2.0 * np.pi * 125.0 * time) ** 4  # noqa: E731
    result = run(drive, duration, plucks=plucks, torque=torque, rate=1.0 / duration, fields=1, **scheme)
    return result.fields[-1]


@pytest.mark.parametrize("model", ["exact", "weak-consistent"])
def test_space_and_time_converge_with_order_two(model, measured):
    """All n doubled at a fixed CFL number, against Stoermer-Verlet at a fine one: errors fall fourfold."""
    segments = np.array([64, 128, 256])
    fine = end_of_run(LOOP, segments=2048, cfl=0.8, model=model, method="verlet")
    errors = [
        np.max(np.abs(end_of_run(LOOP, segments=int(n), cfl=0.8, model=model) - fine[:, :: 2048 // n]))
        for n in segments
    ]
    order = np.log2(errors[-2] / errors[-1])
    measured(f"order {order:.3f}")
    assert order == pytest.approx(2.0, abs=0.1), f"observed order {order:.3f}, errors {errors}"


def test_a_motion_turned_round_goes_back_to_where_it_came_from(measured):
    """The scheme is symmetric in time, its stored energy included."""
    start = Start(plucks=(Pluck(height=2e-2, shape="half-sine"), Pluck(height=1e-2, plane="v")))
    scheme = Scheme(method="energy-conserving", segments=20)
    case = case_of(LOOP, 0.01, start=start, scheme=scheme, recording=Recording(rate=1e5))
    steps, every = case.grid.steps, case.grid.every
    state, work = case.first_state(), new_workspace(case.plan)
    stored = state.extra[0]

    def integrate(count):
        torque, forces = case.inputs(0, count)
        rows, fields = np.zeros((count // every + 1, case.width)), np.zeros((0, 3, case.mesh.nodes))
        assert case.method.integrate(case.plan, state, work, torque, forces, every, rows, fields) == 0

    integrate(steps)
    moved = np.max(np.abs(state.x - case.displacement))
    state.x[:] -= case.plan.step * state.x_t
    state.x_t[:] *= -1.0
    integrate(steps - 1)
    error = np.max(np.abs(state.x - case.displacement))
    measured(f"back within {error:.1e} m after {1e3 * moved:.1f} mm")
    assert moved > 1e-2
    assert error < 1e-12, f"{error:.1e} m beside the start"
    assert state.extra[0] == pytest.approx(stored, abs=1e-12 * case.plan.rigidity)


@pytest.mark.parametrize(
    "option, words", [({"model": "weak"}, "weak-consistent"), ({"slack": "tension-only"}, "verlet")]
)
def test_what_has_no_energy_to_conserve_is_refused(option, words):
    with pytest.raises(InputRefused, match=words):
        run(LOOP, 0.01, **option)
