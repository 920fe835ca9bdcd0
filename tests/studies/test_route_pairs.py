"""Pairs near internal resonance of machines with routes, against those of a loop."""

from dataclasses import replace
from math import pi

import pytest

import cabledrive as cd
from cabledrive.parameters.drive_file import drive_from_text, packaged_text
from cabledrive.studies.pair_thresholds import coupled_pairs
from cabledrive.studies.route_pairs import route_resonance
from command import answer, refusal
from network_samples import as_route
from resonance_samples import damped_loop


def test_thresholds_of_a_loop_as_a_route_are_those_of_the_loop():
    """Of the first order in torque: the loop's 1:2 thresholds add the share of the third harmonic."""
    loop = damped_loop()
    route = as_route(loop)
    route = replace(
        route,
        cable=replace(route.cable, transverse_damping=2.0, axial_damping=0.02),
        pulley=tuple(replace(pulley, viscous_friction=2e-5) for pulley in route.pulley),
    )
    found = route_resonance(route)
    pulley = 2 * pi * found.longitudinal_hz
    expected = [pair for pair in coupled_pairs(loop, pulley) if pair.kind == "1:2" and pair.numbers == (1, 1)]
    own = [
        p for p in found.pairs if p.plane == "w" and abs(p.longitudinal_hz / found.longitudinal_hz - 1) < 1e-9
    ]
    assert len(own) == len(expected) == 2
    for one, other in zip(own, expected, strict=True):
        assert one.transverse_hz[0] == pytest.approx(other.transverse_hz[0], rel=1e-4)
        assert one.detuning_hz == pytest.approx(other.detuning_hz, abs=2e-3)
        assert one.threshold_torque == pytest.approx(other.threshold_torque, rel=0.02)


def test_verdict_changes_at_the_lowest_threshold():
    drive = cd.load_drive("serpentine")
    found = cd.resonance(drive)
    assert found.threshold_torque == min(p.threshold_torque for p in found.pairs if p.threshold_torque)
    above, below = (cd.resonance(drive, torque=share * found.threshold_torque) for share in (1.01, 0.3))
    assert (above.verdict, below.verdict) == ("resonant", "safe")
    assert found.detuning == found.frequency_ratio - 0.5
    with pytest.raises(cd.InputRefused, match="load torque"):
        cd.resonance(drive, load_torque=1.0)


def test_both_planes_of_a_span_between_held_ends_have_one_threshold():
    pairs = route_resonance(cd.load_drive("serpentine")).pairs
    by_plane = {pair.plane: pair.threshold_torque for pair in pairs if pair.span == "accessory to crank"}
    assert by_plane["v"] == pytest.approx(by_plane["w"], rel=1e-9)


def test_the_command_lists_pairs_with_spans_and_refuses_what_a_route_has_not():
    found = answer("resonance", "serpentine", "--torque", "10 N m")
    assert found["verdict"] in ("safe", "close", "resonant")
    assert found["pairs"][0]["kind"] == "1:2"
    assert found["pairs"][0]["span"] == "accessory to crank"
    assert found["detuning"] == pytest.approx(found["frequency_ratio"] - 0.5)
    assert "speed" in refusal("resonance", "serpentine", "--set", "route.belt.speed=5")
    assert answer("resonance", "serpentine")["verdict"] == "no excitation given"


LIFT = (
    packaged_text("lift-2-to-1")
    + """
[excitation]
torque_ripple = 0.5
orders = ["sheave=traction sheave*NUMBER", "rails=car.y/5m"]
speed = "car.y=0.2m/s:1m/s"
"""
)


@pytest.mark.parametrize(("number", "verdict"), [(1, "safe"), (6, "resonant")])
def test_an_order_excites_the_pairs_whose_frequency_it_reaches(number, verdict):
    """At 1 m/s of the car, 2 m/s of the rope, the sheave of 0.16 m turns 1.989 times a second."""
    found = route_resonance(drive_from_text(LIFT.replace("NUMBER", str(number))))
    assert found.verdict == verdict
    excited = [pair.longitudinal_hz for pair in found.pairs if pair.threshold_torque is not None]
    assert any(hertz <= number * 2.0 / (2 * pi * 0.16) for hertz in excited) == (verdict == "resonant")
    assert found.torque == pytest.approx(400.0)


def test_orders_without_a_ripple_have_no_amplitude_to_judge():
    text = LIFT.replace("NUMBER", "6").replace("torque_ripple = 0.5\n", "")
    assert route_resonance(drive_from_text(text)).verdict == "unknown"
