"""Ropes in a swaying building, against equations integrated step by step and certified modes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cabledrive as cd
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.studies.sway import sway
from command import answer, refusal


def integrated(length, tension, density, damping, omega, ends):
    """Largest motion across beside the chord of a string whose ends move, by integration along it."""

    def slopes(x, state):
        own = tension[0] + (tension[1] - tension[0]) * x / length
        return state[1] / own, -density * (omega**2 - 1j * omega * damping) * state[0]

    places = np.linspace(0.0, length, 401)
    one, other = (
        solve_ivp(
            slopes, (0, length), np.array(start, dtype=complex), t_eval=places, rtol=1e-9, atol=1e-12
        ).y[0]
        for start in ((1.0, 0.0), (0.0, 1.0))
    )
    motion = ends[0] * one + (ends[1] - ends[0] * one[-1]) / other[-1] * other
    return np.abs(motion - (ends[0] + (ends[1] - ends[0]) * places / length)).max()


@pytest.mark.parametrize("hertz", [0.21, 1.3])
def test_sway_is_that_of_the_integrated_equation(hertz):
    drive = cd.load_drive("lift-2-to-1", overrides=["car.y=31 m"])
    found = sway(drive, hertz, 0.05)
    statics = statics_of(drive)
    for number, span in enumerate(drive.free_spans):
        rope = drive.ropes[span.route]
        ends = [0.05 * (point[1] - found.bottom) / (found.top - found.bottom) for point in span.contacts]
        tension = (statics.start[number], statics.end[number])
        wanted = integrated(
            span.length, tension, rope.mass_per_length, rope.transverse_damping, 2 * np.pi * hertz, ends
        )
        own = next(one for one in found.ropes if one.name == span.name)
        assert own.amplitude == pytest.approx(wanted, rel=1e-4)


def test_first_frequencies_are_those_of_the_certified_list():
    drive = cd.load_drive("lift-2-to-1", overrides=["car.y=8 m"])
    found = cd.modes(drive, below=10.0)
    for rope in sway(drive, 0.2, 0.05).ropes:
        first = min(mode.frequency for mode in found.transverse if rope.name in (mode.span or ""))
        assert rope.frequency_hz == pytest.approx(first, rel=2e-3)  # bending stiffness is left out


def test_a_rope_is_looked_at_where_it_resonates_with_the_building():
    places = np.array([[10.0, 20.0, 30.0]])
    found = sway(cd.load_drive("lift-2-to-1"), 0.8, 0.05, {("car.y",): places})
    rope = next(own for own in found.ropes if own.name == "car bottom to pit sheave")
    resonant = rope.amplitude.argmax()
    assert rope.frequency_hz[resonant] == pytest.approx(0.8, rel=1e-6)
    assert rope.amplitude[resonant] > 10 * rope.amplitude[np.isin(found.places, places)].max()


SWAY = ("sway", "lift-2-to-1", "--building")


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (["0 Hz", "--amplitude", "50 mm"], "building"),
        (["0.2 Hz", "--amplitude", "-1 mm"], "amplitude"),
        (["0.2 Hz", "--amplitude", "50 mm", "--set", "cable.transverse_damping=0"], "transverse_damping"),
        (["0.2 Hz", "--amplitude", "50 mm", "--vary", "car.y=2m:41m"], "travel"),
    ],
)
def test_what_is_no_sway_is_refused(options, name):
    assert name in refusal(*SWAY, *options)


def test_the_command_gives_every_rope_at_every_place():
    found = answer(*SWAY, "1 Hz", "--amplitude", "50 mm", "--vary", "car.y=2m:38m:4")
    assert len(found["ropes"]) == 6
    assert all(len(rope["amplitude"]) == len(found["places"]) for rope in found["ropes"])
    assert found["warnings"]  # 2 m of a rope of 20 m
