"""What must not change: energy, angular momentum, symmetry, rest."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.mechanics.cable_laws import LAWS
from cabledrive.parameters.carriage import Carriage
from cabledrive.parameters.drive_file import load_drive
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate

LOOP = load_drive("dissertation-2")
MOTORED = load_drive("dissertation-3")
WEIGHTLESS = replace(LOOP, layout=replace(LOOP.layout, gravity=0.0))
FORCED = Sine(amplitude=0.02, frequency=81.74)
HALF_SINE = Pluck(height=1e-3, shape="half-sine")
RUBBED = replace(
    MOTORED,
    cable=replace(MOTORED.cable, axial_damping=2.0, transverse_damping=3.0),
    pulley=tuple(replace(p, viscous_friction=1e-3, coulomb_friction=2e-3) for p in MOTORED.pulley),
    carriage=(Carriage(mass=1e-3, position=0.3, guided=False),),
    layout=replace(MOTORED.layout, inclination=0.1),
)


def run(drive, duration, *, segments=40, torque=FORCED, plucks=(HALF_SINE,), **scheme):
    return simulate(
        drive,
        duration,
        torque=torque,
        start=Start(plucks=plucks),
        scheme=Scheme(segments=segments, **scheme),
        recording=Recording(rate=2000.0),
    )


def test_a_linear_cable_keeps_its_budget_to_round_off(measured):
    """The leapfrog's own energy of a linear drive is an exact invariant, also with torque and dampings."""
    errors = {drive.name: run(drive, 0.2, model="linear").energy_budget_error for drive in (LOOP, RUBBED)}
    measured(", ".join(f"{error:.1e}" for error in errors.values()) + " of the energy handled")
    for name, error in errors.items():
        assert error < 1e-11, f"{name}: {error:.1e}"


@pytest.mark.parametrize("segments", [40, pytest.param(Scheme().segments, marks=pytest.mark.verify)])
def test_verlet_energy_error_does_not_drift_over_a_million_steps_at_the_default_resolution(
    segments, measured
):
    """Undamped forced loop, 10 s; of 40 segments 0.6 million steps."""
    result = run(LOOP, 10.0, segments=segments, torque=Sine(amplitude=0.02, frequency=60.0))
    slope, spread = drift(result.time, result.budget_error)
    change = slope * result.time[-1]
    early, late = (np.ptp(half) for half in np.array_split(result.budget_error, 2))
    measured(
        f"{result.steps:,} steps: {result.energy_budget_error:.1e} of the energy handled, late over early "
        f"{late / early:.2f}, line through it {abs(change) / spread:.2f} of its scatter"
    )
    assert result.steps > 15_000 * segments
    assert late < 1.5 * early
    assert result.energy_budget_error < 1e-6, f"{result.energy_budget_error:.1e}"
    assert abs(change) < 3.0 * spread, f"drift {change:.2e}, scatter {spread:.2e} J"


def drift(time, error):
    """Slope of a straight line through an error, and the scatter of blocks of a tenth of the run about it."""
    blocks = error[: error.size // 10 * 10].reshape(10, -1).mean(axis=1)
    centres = time[: error.size // 10 * 10].reshape(10, -1).mean(axis=1)
    slope, offset = np.polyfit(centres, blocks, 1)
    return slope, np.std(blocks - slope * centres - offset) + np.std(error) / 10.0


@pytest.mark.parametrize("gamma", [0.0, 2.0])
def test_axial_angular_momentum_of_a_span_decays_as_the_damping_alone_says(gamma, measured):
    """The pulleys exert no moment about the span's axis: exp(-Gamma t), whatever the torque does."""
    drive = replace(WEIGHTLESS, cable=replace(LOOP.cable, transverse_damping=gamma))
    result = simulate(
        drive,
        0.3,
        torque=Sine(amplitude=0.05, frequency=81.74),
        start=Start(
            plucks=(HALF_SINE, Pluck(height=5e-4, plane="v", shape="sine-2")),
            kicks=(Pluck(height=0.3, plane="v", shape="half-sine"), Pluck(height=-0.2, shape="sine-2")),
        ),
        scheme=Scheme(segments=20),
        recording=Recording(rate=40_000.0, fields=1),
    )
    assert result.steps == len(result.time) - 1, "every step is meant to be recorded"
    v, w = result.fields[:, 1, :21], result.fields[:, 2, :21]
    momentum = np.sum(v[:-1] * w[1:] - w[:-1] * v[1:], axis=1)  # of leapfrog, times step over mass of a node
    damped = 0.5 * gamma * result.step
    expected = momentum[0] * ((1.0 - damped) / (1.0 + damped)) ** np.arange(momentum.size)
    error = np.max(np.abs(momentum - expected)) / abs(momentum[0])
    elapsed = result.time[-1] - result.step
    apart = momentum[-1] / momentum[0] / np.exp(-gamma * elapsed) - 1.0
    measured(f"exp(-Gamma t) to {abs(apart):.1e}, the scheme's own decay to {error:.1e}")
    assert error < 1e-10, f"{error:.1e} of the momentum"
    assert momentum[-1] / momentum[0] == pytest.approx(np.exp(-gamma * elapsed), rel=1e-9)
    assert np.ptp(result.load_angle) > 1e-3


@pytest.mark.parametrize("model", LAWS)
@pytest.mark.parametrize("method", ["verlet", "node-centred"])
def test_equal_plucks_of_both_spans_leave_the_pulleys_at_rest(model, method, measured):
    """The pull of the two spans is the same at every instant; without gravity, which would part them."""
    plucks = (HALF_SINE, replace(HALF_SINE, span="lower"), Pluck(height=4e-4, plane="v"))
    plucks += (Pluck(height=4e-4, plane="v", span="lower"),)
    result = run(WEIGHTLESS, 0.1, torque=0.0, plucks=plucks, model=model, method=method)
    turned = result.extremes["load_angle_max"] - result.extremes["load_angle_min"]
    measured(f"the load pulley turned {turned:.2g} rad")
    assert turned < 1e-15, f"the load pulley turned {turned:.1e} rad"
    assert result.midpoint("upper")[:, 2].std() > 1e-4


@pytest.mark.parametrize("method", ["verlet", "node-centred"])
def test_a_mirrored_input_gives_the_mirrored_output(method, measured):
    """v -> -v, w -> -w leaves the pulleys alone; upper <-> lower with the torque turned turns the pulleys."""
    plucks = (Pluck(height=1e-3), Pluck(height=5e-4, plane="v", shape="sine-2"))
    first = run(WEIGHTLESS, 0.05, plucks=plucks, method=method)
    flipped = run(WEIGHTLESS, 0.05, plucks=tuple(replace(p, height=-p.height) for p in plucks), method=method)
    swapped = run(
        WEIGHTLESS,
        0.05,
        torque=replace(FORCED, amplitude=-FORCED.amplitude),
        plucks=(
            Pluck(height=1e-3, span="lower"),
            Pluck(height=-5e-4, plane="v", shape="sine-2", span="lower"),
        ),
        method=method,
    )
    across = np.max(np.abs(first.midpoint()[:, 1:] + flipped.midpoint()[:, 1:]))
    along = np.max(np.abs(swapped.load_angle + first.load_angle)) / np.ptp(first.load_angle)
    measured(f"v and w turned: {across:.1g} m apart; spans changed about: {along:.1e} of the load's motion")
    np.testing.assert_array_equal(first.load_angle, flipped.load_angle)
    np.testing.assert_array_equal(first.midpoint()[:, 1:], -flipped.midpoint()[:, 1:])
    np.testing.assert_allclose(swapped.load_angle, -first.load_angle, atol=1e-13 * np.ptp(first.load_angle))
    np.testing.assert_allclose(
        swapped.midpoint("lower")[:, 2], first.midpoint("upper")[:, 2], atol=1e-12 * 1e-3
    )
