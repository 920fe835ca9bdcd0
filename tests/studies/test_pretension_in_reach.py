"""No advice asks for a pretension that the cable cannot bear."""

from dataclasses import replace

import pytest

from cabledrive.mechanics.warnings import ELASTIC_RULE, largest_pretension
from cabledrive.parameters import load_drive
from cabledrive.studies.resonance import resonance
from cabledrive.studies.resonance_remedies import remedies
from resonance_samples import damped

TORQUE = 0.01


def with_strain_limit(drive, limit):
    return replace(drive, cable=replace(drive.cable, strain_limit=limit))


def raised(drive):
    return next(one for one in remedies(drive, TORQUE) if one.change == "raise pretension")


@pytest.mark.parametrize("limit", [None, 0.004])
def test_the_largest_pretension_strains_the_cable_to_the_end_of_its_range(limit):
    drive = with_strain_limit(damped(2.0, 5.0), limit)
    strained = largest_pretension(drive) / drive.cable.axial_rigidity
    assert strained == pytest.approx(ELASTIC_RULE if limit is None else limit)


def test_a_pretension_is_raised_within_the_elastic_range_only():
    """A drive that a higher pretension makes safe, with a range that ends above it, and just below it."""
    drive = damped(2.0, 5.0)
    free = raised(drive).value
    strain = free / drive.cable.axial_rigidity
    assert raised(with_strain_limit(drive, 1.01 * strain)).value == pytest.approx(free, rel=1e-3)
    short = raised(with_strain_limit(drive, 0.99 * strain))
    assert short.value is None
    assert f"elastic range, up to {0.99 * free:.4g} N" in short.text


def test_a_tuned_pretension_beyond_the_elastic_range_is_said_to_be_out_of_reach():
    """A lift: an empty span would be tuned at 467 kN; its rope bears 246 kN."""
    lift = load_drive("elevator")
    words = "above its elastic range"
    reason = next(reason for reason in resonance(lift).reasons if words in reason)
    assert "up to 2.46e+05 N" in reason
    assert not any(words in reason for reason in resonance(load_drive("dissertation-2")).reasons)
