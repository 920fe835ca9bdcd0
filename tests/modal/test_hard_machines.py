"""Machines made to break the solver: every list is certified and right, or says that it is not."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from machines import drive, machine, pulley, some_cable, spread
from transfer_roots import exact_roots

import cabledrive as cd
from drive_strategies import drives


def string_of_carriages(number, contrast, kind):
    rng = np.random.default_rng(number)
    cable, length = some_cable(rng), 100.0
    mass = cable.mass_per_length * length / number
    carriages = []
    spans = ("upper", "lower")[: 2 if kind == "loop" else 1]
    for span in spans:
        places = np.cumsum([spread(rng, contrast) for _ in range(number // len(spans) + 1)])
        for place in length * places[:-1] / places[-1]:
            carriages.append(
                cd.Carriage(mass=mass * spread(rng, contrast), span=span, position=place, guided=False)
            )
    return drive(kind, cable, length, [pulley(10 * mass), pulley(7 * mass)], carriages)


@pytest.mark.parametrize("contrast", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("kind", ["loop", "line"])
@pytest.mark.parametrize("carriages", [400, pytest.param(10_000, marks=pytest.mark.verify)])
def test_strings_of_carriages_are_certified(kind, contrast, carriages, measured):
    """Spans and masses from alike to a million to one; of 10,000 so far apart not all may be proven."""
    modes = cd.modes(string_of_carriages(carriages, contrast, kind), count=15)
    count, below = modes.certificate.count, modes.certificate.below
    measured(f"{count} modes below {below:.4g} Hz {'' if modes.certified else 'not '}certified")
    assert modes.certified or (modes.certified_reason and (carriages, contrast) == (10_000, 1e6))
    assert np.all(np.diff([mode.frequency for mode in modes.modes]) >= 0)
    assert sum(mode.multiplicity for mode in modes.modes if mode.frequency < below) == count
    assert len(modes.longitudinal) == 15


@pytest.mark.parametrize("seed", range(10))
def test_contrasts_of_a_million_million_are_certified_or_say_they_are_not(seed, measured):
    """Far beyond the claim: forty digits lie where the certificate says, or the mode is not proven."""
    loop = machine(np.random.default_rng(seed), contrast=1e12)
    modes = cd.modes(loop, count=10)
    roots = exact_roots(loop, 12)
    off = {
        mode: min(abs(2 * np.pi * mode.frequency / float(root) - 1) for root in roots)
        for mode in modes.longitudinal
    }
    proven = [error for mode, error in off.items() if mode.proven]
    measured(f"{len(proven)} of {len(off)} modes proven, relative error {max(proven, default=0.0):.1e}")
    assert modes.certified == all(mode.proven for mode in modes.modes)
    for mode, error in off.items():
        allowed = 3.0 * modes.certificate.enclosure
        assert error < allowed or not mode.proven, f"relative error {error:.1e} at {mode.frequency} Hz"


def test_any_drive_that_can_be_written_down_is_certified_or_says_why_not(measured):
    """Every figure anywhere between 1e-12 and 1e12: a certified list, one that is not, or one clear line."""
    outcomes = Counter()

    @settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])
    @given(machine=drives())
    def check(machine):
        try:
            modes = cd.modes(machine, count=5)
        except (cd.InputRefused, cd.NotComputed):
            outcomes["refused"] += 1
            return
        outcomes["certified" if modes.certified else "said not to be certified"] += 1
        listed = sum(m.multiplicity for m in modes.modes if m.frequency < modes.certificate.below)
        assert not modes.certified or listed == modes.certificate.count
        assert all(np.isfinite(mode.frequency) and mode.frequency > 0 for mode in modes.modes)

    check()
    measured(", ".join(f"{number} {outcome}" for outcome, number in sorted(outcomes.items())))


def test_a_slow_mode_whose_rate_drowns_in_round_off_is_refused():
    """A wheel of 1245 km, held by a spring, and one of 1 m on a belt of 2 kg that moves with both."""
    stiff = cd.Drive(
        name="stiff",
        kind="loop",
        cable=cd.Cable(youngs_modulus=1167289.0, area=0.0078125, mass_per_length=1.0, pretension=1.0),
        layout=cd.Layout(span_length=1.0, gravity=0.0),
        pulley=(cd.Pulley(radius=1245433.0, inertia=1.0), cd.Pulley(radius=1.0, inertia=1.0)),
        motor=cd.Motor(inertia=1.0, holding_stiffness=3.0),
    )
    with pytest.raises(cd.NotComputed, match="could not be refined"):
        cd.modes(stiff, count=1)


def test_a_span_as_long_as_a_file_may_say_rings_at_the_tone_of_a_string():
    """c / (2 L_e) at 1e20 m: the count squares no small number away."""
    loop = cd.load_drive("dissertation-2")
    steel = replace(loop.cable, youngs_modulus=200e9, area=6e-7, mass_per_length=4.7e-3, pretension=60.0)
    loop = replace(loop, cable=steel, layout=replace(loop.layout, span_length=1e20))
    found = cd.modes(loop, count=1)
    lowest = min(mode.frequency for mode in found.transverse)
    expected = loop.cable.transverse_wave_speed / (2 * loop.pulley_distance)
    assert found.certified
    assert lowest == pytest.approx(expected, rel=1e-9)
