"""Maps of modes over figures of a machine, and the speeds at which its motion excites them."""

import math

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.studies.excitation_orders import (
    Order,
    clear_speeds,
    danger_zones,
    frequency_per_speed,
    rates,
    with_critical_speeds,
)
from cabledrive.studies.mode_map import map_modes
from cabledrive.studies.varied_drive import varied

BED = {"head.x": [0.06, 0.21, 0.36], "beam.y": [0.05, 0.33]}


@pytest.fixture(scope="module")
def bed():
    return map_modes(cd.load_drive("corexy"), BED, count=2, motor="free")


def test_a_point_of_the_map_holds_the_modes_of_the_machine_in_that_pose(bed):
    drive = cd.load_drive("corexy", overrides=["head.x=0.36", "beam.y=0.05"])
    expected = cd.natural_frequencies(drive, count=2, motor="free")
    own = bed["longitudinal_hz"].sel({"head.x": 0.36, "beam.y": 0.05})
    np.testing.assert_allclose(own, expected, rtol=1e-12)
    assert bool(bed["certified"].all())
    assert bed.attrs["motor"] == "free"


def test_the_bed_of_a_corexy_is_symmetric_and_its_x_mode_is_highest_in_the_rear_corners(bed):
    """Modes of x and y [Hz] of belts that stretch evenly; strings shift y by up to 0.6 Hz."""
    x, y = (bed["coordinate_hz"].sel(coordinate=name) for name in ("head.x", "beam.y"))
    np.testing.assert_allclose(x[0], x[2], rtol=1e-6)
    np.testing.assert_allclose(x.values[:2], [[119.8, 187.1], [114.2, 143.6]], atol=0.6)
    np.testing.assert_allclose(y.values[:2], [[97.5, 111.9], [97.6, 122.4]], atol=0.6)


def test_keys_joined_move_together():
    lift = cd.load_drive("lift-2-to-1")
    found = map_modes(lift, {("car.y", "counterweight.y"): [[10.0, 30.0], [30.0, 10.0]]}, count=2)
    assert found["longitudinal_hz"].shape == (2, 2)
    np.testing.assert_array_equal(found["counterweight.y"], [30.0, 10.0])
    drive = cd.load_drive("lift-2-to-1", overrides=["car.y=30", "counterweight.y=10"])
    expected = cd.natural_frequencies(drive, count=2)
    np.testing.assert_allclose(found["longitudinal_hz"][1], expected, rtol=1e-12)


def test_keys_of_parts_are_called_by_name_and_loops_have_maps():
    drive = cd.load_drive("corexy")
    assert varied(drive, "body.head.mass", 0.5).body[1].mass == 0.5
    assert (
        varied(cd.load_drive("printer-idlers"), "motor.holding_stiffness", 7.0).motor[0].holding_stiffness
        == 7
    )
    found = map_modes(cd.load_drive("dissertation-2"), {"cable.pretension": [4.0, 6.0]}, count=1)
    assert found["transverse_hz"][1, 0] / found["transverse_hz"][0, 0] == pytest.approx(
        math.sqrt(1.5), rel=2e-3
    )
    assert "coordinate_hz" not in found


def test_a_pose_that_is_no_machine_has_a_reason_and_no_modes():
    found = map_modes(cd.load_drive("capstan-arm"), {"cable.pretension": [100.0, -1.0]}, count=1)
    assert np.isfinite(found["longitudinal_hz"].values[0, 0])
    assert np.isnan(found["longitudinal_hz"].values[1, 0])
    assert "above 0" in str(found["reason"].values[1])
    with pytest.raises(cd.InputRefused, match="no point"):
        map_modes(cd.load_drive("capstan-arm"), {"cable.pretension": [-1.0]})
    with pytest.raises(cd.InputRefused, match="twice"):
        map_modes(cd.load_drive("capstan-arm"), {"cable.pretension": [1.0], ("cable.pretension",): [[2.0]]})


def test_two_processes_find_what_one_finds():
    drive, vary = cd.load_drive("capstan-arm"), {"cable.pretension": np.linspace(50.0, 150.0, 64)}
    one, two = (map_modes(drive, vary, count=1, workers=workers) for workers in (1, 2))
    np.testing.assert_array_equal(one["longitudinal_hz"], two["longitudinal_hz"])


def test_a_lift_roped_two_to_one_turns_its_sheave_by_two_metres_of_rope_a_metre():
    lift = cd.load_drive("lift-2-to-1")
    moving = rates(lift, "car.y")
    assert moving["counterweight.y"] == pytest.approx(-1.0, abs=1e-9)
    assert abs(moving["traction sheave"]) == pytest.approx(2.0 / 0.16, rel=1e-9)
    assert moving["tension frame.y"] == pytest.approx(0.0, abs=1e-9)
    poles = Order(name="poles", pulley="traction sheave", number=20.0)
    assert frequency_per_speed(lift, poles, "car.y") == pytest.approx(20 * 2.0 / (2 * math.pi * 0.16))
    assert frequency_per_speed(lift, Order(name="rails", coordinate="car.y", length=5.0), "car.y") == 0.2
    with pytest.raises(cd.InputRefused, match="without straining"):
        rates(lift, "tension frame.y")


def test_danger_zones_hold_the_speeds_at_which_an_order_has_the_frequency_of_a_mode():
    lift = cd.load_drive("lift-2-to-1")
    found = map_modes(lift, {("car.y", "counterweight.y"): [[10.0, 30.0], [30.0, 10.0]]}, count=3)
    sheave = Order(name="sheave", pulley="traction sheave")
    mapped = with_critical_speeds(found, lift, [sheave], "car.y")
    own = mapped["critical_speed_longitudinal"].sel(order="sheave", mode=1).values
    np.testing.assert_allclose(own * 2.0 / (2 * np.pi * 0.16), found["longitudinal_hz"].values[:, 0])
    zones = danger_zones(mapped, 0.1, 3.0, 0.05)
    first = next(zone for zone in zones if zone.kind == "longitudinal" and zone.mode == 1)
    assert (first.low, first.high) == pytest.approx((own.min() * 0.95, own.max() * 1.05))
    for low, high in clear_speeds(zones, 0.1, 3.0):
        inside = np.linspace(low, high, 7)[1:-1]
        for zone in zones:
            assert not np.any((inside > zone.low) & (inside < zone.high))
