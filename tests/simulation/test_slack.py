"""A span that goes slack is found at its time and place, and then what was asked for happens."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from cabledrive.parameters.carriage import Carriage
from cabledrive.parameters.drive_file import load_drive
from cabledrive.parameters.errors import InputRefused
from cabledrive.simulation import (
    Constant,
    Pluck,
    Recording,
    Sampled,
    Scheme,
    Sine,
    Start,
    simulate,
)

LOOP = load_drive("dissertation-2")
WEIGHTLESS = replace(LOOP, layout=replace(LOOP.layout, gravity=0.0))
HELD = replace(WEIGHTLESS, pulley=(LOOP.pulley[0], replace(LOOP.pulley[1], fixed=True)))
SLACK_TORQUE = 2.0 * LOOP.drive_pulley.radius * LOOP.cable.pretension


def stopped(drive, duration, **options):
    result = simulate(drive, duration, scheme=Scheme(segments=40), **options)
    assert result.stopped is not None
    return result


@pytest.mark.parametrize(("sign", "span"), [(1.0, "upper"), (-1.0, "lower")])
def test_a_slow_torque_slackens_a_span_at_twice_radius_times_pretension(sign, span, measured):
    """Load pulley held, torque raised over many periods of the drive: slack at 2 r T0, within 1 %."""
    ramp = Sampled(values=[0.0, sign * 2.0 * SLACK_TORQUE], rate=1.0 / 4.0)
    result = stopped(HELD, 4.0, torque=ramp, recording=Recording(rate=500.0))
    event = result.slack_events[0]
    torque = abs(ramp.at(np.array([event.time]))[0])
    measured(f"{event.span} span at {torque / SLACK_TORQUE:.4f} times 2 r T0")
    assert event.span == span
    assert torque == pytest.approx(SLACK_TORQUE, rel=0.01)
    assert event.tension == pytest.approx(0.0, abs=1e-3)


def test_a_sudden_torque_slackens_the_span_when_the_drive_pulley_has_turned_far_enough(measured):
    """One inertia with a third of the cable on two springs K / Le, step torque: within 1 %."""
    torque = 1.2 * SLACK_TORQUE
    law_stiffness = HELD.cable.axial_rigidity + HELD.cable.pretension
    spring = 2.0 * law_stiffness / HELD.pulley_distance
    pulley = HELD.drive_pulley
    cable = HELD.cable.mass_per_length * HELD.span_length
    omega = np.sqrt(spring / (pulley.inertia / pulley.radius**2 + 2.0 * cable / 3.0))
    farthest = torque / pulley.radius / spring

    def mean_tension(time):
        turned = farthest * (1.0 - np.cos(omega * time))
        return HELD.cable.pretension - law_stiffness * turned / HELD.pulley_distance

    expected = brentq(mean_tension, 0.0, np.pi / omega)
    event = stopped(HELD, 0.5, torque=Constant(torque)).slack_events[0]
    measured(f"{event.span} span at {event.time / expected:.4f} times the expected instant")
    assert event.span == "upper"
    assert event.time == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("model", ["exact", "weak", "weak-consistent"])
def test_a_cable_that_only_pulls_never_pushes_and_keeps_its_budget(model):
    result = simulate(
        HELD,
        0.3,
        torque=Constant(1.2 * SLACK_TORQUE),
        scheme=Scheme(segments=40, slack="tension-only", model=model),
    )
    assert result.stopped is None
    assert result.slack_events
    assert result.channel("least_tension_upper").min() == 0.0
    assert result.energy_budget_error < 5e-3, f"{result.energy_budget_error:.1e}"


def test_a_cable_that_snaps_taut_again_and_again_gains_no_energy():
    """Ten times the slack torque at the pulley mode's frequency: half the stable step would gain 5 % here."""
    torque = Sine(amplitude=10.0 * SLACK_TORQUE, frequency=81.7)
    result = simulate(WEIGHTLESS, 0.3, torque=torque, scheme=Scheme(segments=50, slack="tension-only"))
    assert len(result.slack_events) > 100
    assert result.energy_budget_error < 0.02, f"{result.energy_budget_error:.1e}"


def test_slack_of_a_line_and_of_a_span_with_a_carriage_is_placed_where_it_happens():
    """A carriage thrown along the span slackens the cable ahead of it: place between carriage and pulley."""
    drive = replace(WEIGHTLESS, carriage=(Carriage(mass=0.01, position=0.25),))
    drive = replace(drive, pulley=tuple(replace(p, fixed=True) for p in drive.pulley))
    result = stopped(drive, 0.1, start=Start(kicks=(Pluck(height=8.0, plane="u", shape=_at_the_carriage),)))
    event = result.slack_events[0]
    assert event.span == "upper"
    assert event.position > 0.25


def _at_the_carriage(x):
    return np.maximum(0.0, 1.0 - np.abs(x / 0.2511285662 - 1.0) * 30.0)


def test_a_start_that_is_slack_already_is_refused():
    squeezed = Pluck(height=-0.02, plane="u", shape="sine-2")
    with pytest.raises(InputRefused, match=r"the upper span is slack at x = .* lower the pluck"):
        simulate(WEIGHTLESS, 0.01, start=Start(plucks=(squeezed,)))
    allowed = Scheme(segments=40, slack="tension-only")
    result = simulate(WEIGHTLESS, 0.01, start=Start(plucks=(squeezed,)), scheme=allowed)
    assert result.slack_events[0].time == 0.0
