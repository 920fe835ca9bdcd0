"""Maps of modes over figures of a machine, and the speeds at which its motion excites them."""

import math
from math import cos, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.network import statics_of
from cabledrive.parameters.drive_file import drive_from_text, packaged_text
from cabledrive.parameters.drive_parts import Order
from cabledrive.parameters.keys import varied_together
from cabledrive.parameters.route import moved
from cabledrive.studies.excitation_orders import excitation, frequency_per_speed, rates
from cabledrive.studies.mode_map import SAME, Grid, distinct, map_modes
from cabledrive.studies.motion_snapshot import Snapshot, tracked
from network_samples import as_routes
from oracles.route_fem import frequencies_of_route
from other_units import in_other_units

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
    geared, steps = cd.load_drive("dissertation-3"), Order(name="steps", pulley="drive pulley", number=200.0)
    radii = geared.pulley[1].radius / geared.pulley[0].radius
    assert frequency_per_speed(geared, steps, "load pulley") == pytest.approx(200 * radii / (2 * math.pi))


def test_a_beam_at_a_speed_leaves_the_head_on_it_at_rest():
    """A corexy whose motor b has twice the radius: the head moved by 7 %, a least square of mixed units."""
    drive = cd.load_drive("corexy")
    parts = {own.name: own for own in drive.pulley}
    first, second = parts["motor a"].radius, 2.0 * parts["motor b"].radius
    drive = varied_together(drive, {"pulley.motor b.radius": second})
    for moving, still, sign in (("beam.y", "head.x", -1.0), ("head.x", "beam.y", 1.0)):
        found = rates(drive, moving)
        assert found[still] == pytest.approx(0.0, abs=1e-9)
        assert found["motor a"] == pytest.approx(sign / first, rel=1e-4)
        assert found["motor b"] == pytest.approx(1.0 / second, rel=1e-3)
    with pytest.raises(cd.InputRefused, match=r"motor a moves with several of beam\.y, head\.x"):
        rates(drive, "motor a")


@pytest.mark.parametrize("length", [1e-5, 1e-3, 1e3])
def test_the_rates_of_a_machine_do_not_depend_on_units(length):
    """A head that moves in small units was said to strain a rope."""
    drive = cd.load_drive("corexy")
    own, other = rates(drive, "head.x"), rates(in_other_units(drive, (1.0, length, 1.0)), "head.x")
    assert {name: rate for name, rate in other.items() if "." in name} == pytest.approx(
        {name: rate for name, rate in own.items() if "." in name}, abs=1e-8
    )
    with pytest.raises(cd.InputRefused, match=r"motor a moves with several of beam\.y, head\.x"):
        rates(in_other_units(drive, (1.0, length, 1.0)), "motor a")


@pytest.mark.parametrize("by", [(10.0, 1.0, 1.0), (1.0, 1e3, 1.0), (1.0, 1.0, 1e-3)])
def test_zones_and_branches_of_a_symmetric_machine_do_not_depend_on_units(by):
    """Round-off chose between its two belts: which mode a branch is named after, and which zone is first."""
    given, (_, length, time) = cd.load_drive("corexy"), by
    order = Order(name="teeth", pulley="motor a", number=200)

    def found(drive, m=1.0, s=1.0):
        places, speed = np.linspace(0.06, 0.36, 3) * m, (0.02 * m / s, 0.3 * m / s)
        return excitation(Grid(drive, {"head.x": places}), [order], ("head.x", *speed))

    own, other = found(given), found(in_other_units(given, by), length, time)
    assert [(zone.mode, zone.place_low * length) for zone in own.zones] == [
        (zone.mode, pytest.approx(zone.place_low)) for zone in other.zones
    ]
    assert [branch.name for branch in other.branches] == [branch.name for branch in own.branches]
    for one, again in zip(own.branches, other.branches, strict=True):
        assert again.hertz * time == pytest.approx(one.hertz, rel=1e-6), one.name


SHEAVE = Order(name="sheave", pulley="traction sheave")


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.verify) for seed in range(1, 10))]
)
def test_no_mode_of_finite_elements_lies_near_the_order_at_a_clear_speed(seed, measured):
    """Places between those of the map; finite elements of the file, a mode at each within the margin.

    The packaged lift with limp ropes, other masses and another sheave.
    """
    rng = np.random.default_rng(seed)
    limp = 'axial_rigidity = "1.4 MN"\nmass_per_length = "0.22 kg/m"'
    drive = drive_from_text(packaged_text("lift-2-to-1").replace('type = "8x19-8mm"', limp))
    ranges = {
        "body.car.mass": (1300.0, 2300.0),
        "body.counterweight.mass": (1500.0, 2000.0),
        "body.tension frame.mass": (200.0, 500.0),
        "pulley.traction sheave.radius": (0.14, 0.18),
    }
    lift = varied_together(drive, {key: rng.uniform(*ends) for key, ends in ranges.items()})
    found = excitation(Grid(lift, {"car.y": np.linspace(5.0, 35.0, 7)}), [SHEAVE], ("car.y", 0.02, 0.8))
    rate = found.orders["sheave"]
    modes = []
    for place in (7.3, 18.1, 33.4):
        here = moved(lift, {"car.y": place})
        statics = statics_of(here)
        tensions = list(zip(statics.start, statics.end, strict=True))
        below = frequencies_of_route(here, tensions, 12, found.covered)
        modes.append(below[(below > 1e-3) & (below < found.covered)])
    every = np.concatenate(modes)
    measured(f"{every.size} modes below {found.covered:.3g} Hz; clear: {found.clear}")
    assert every.size >= 6
    assert found.clear
    for low, high in found.clear:
        for speed in np.linspace(low, high, 50):
            assert np.all(np.abs(rate * speed - every) > 0.9 * found.margin * every), speed
    touched = [f for f in every if f <= 0.75 * rate]
    for hertz in touched:
        assert any(zone.low <= hertz / rate <= zone.high for zone in found.zones), hertz


def test_zones_name_ropes_and_places_and_reach_as_far_as_the_order():
    lift = cd.load_drive("lift-2-to-1")
    found = excitation(Grid(lift, {"car.y": np.linspace(5.0, 35.0, 7)}), [SHEAVE], ("car.y", 0.2, 1.0))
    assert found.covered >= found.orders["sheave"] * 1.0 * 1.05
    assert found.clear == (pytest.approx((0.2, 0.2902), abs=1e-4),), "not 0.742 to 1 m/s"
    named = {zone.mode.partition(",")[0] for zone in found.zones}
    assert {"car pulley to traction sheave", "car bottom to pit sheave"} < named
    assert all(zone.place_low <= zone.place_high for zone in found.zones)
    heavy = [zone.weight for zone in found.zones]
    assert heavy == sorted(heavy, reverse=True)
    poles = Order(name="poles", pulley="traction sheave", number=6.0)
    sixth = excitation(Grid(lift, {"car.y": [10.0, 20.0]}), [SHEAVE, poles], ("car.y", 0.2, 0.6))
    assert max(z.weight for z in sixth.zones if z.order == "poles") <= 1.0 / 6.0
    assert sixth.clear == ()


def test_an_order_whose_frequency_per_speed_changes_over_the_map_is_refused():
    """A line of a camera on two winches runs the faster for a metre sideways the lower the camera hangs."""
    winches, drum = cd.load_drive("camera-winches"), Order(name="drum", pulley="left winch")
    speed = ("camera.x", 0.5, 2.0)
    near = excitation(Grid(winches, {"camera.x": [21.5, 22.5]}), [drum], speed)
    assert near.orders["drum"] == pytest.approx(1.0 / (2 * math.pi * 0.1), rel=0.01)
    with pytest.raises(cd.InputRefused, match=r"order drum: 1\.58\d* to 1\.7\d* Hz"):
        excitation(Grid(winches, {"camera.x": [8.0, 22.0]}), [drum], speed)


# --- Modes followed from pose to pose: through a crossing, a veering, and where no step is small enough
KEYS = (("left", "w", -1, 1), ("right", "w", -1, 1), ("right", "w", -1, 2))


def snapshot(shape, across):
    """Three modes with these shapes, shape (points, 3), and frequencies; one longitudinal mode."""
    return Snapshot(
        network=None,
        along=(SimpleNamespace(frequency=1.0),),
        along_shape=np.ones((1, 1)),
        along_sign=np.ones(1),
        keys=KEYS,
        pieces=((0,),) * 3,
        across=tuple(SimpleNamespace(frequency=one) for one in across),
        shape=shape,
        across_sign=np.ones(3),
    )


def turned(angle):
    """Two coupled modes whose shapes have turned into each other, and one that nothing changes."""
    c, s = cos(angle), sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def test_modes_that_cross_keep_their_shapes_and_not_their_numbers():
    first, swapped = np.eye(3), np.eye(3)[:, [1, 0, 2]] * [1.0, -1.0, 1.0]

    def between(place):
        return snapshot(first if place < 0.6 else swapped, (1.0 + 0.1 * place, 2.0 - 0.1 * place, 3.0))

    found, doubts = tracked([between(0.0), between(1.0)], between)
    assert doubts == []
    assert [own.frequency for own in found[1].across] == [1.9, 1.1, 3.0]
    np.testing.assert_array_equal(found[1].shape, first)  # signs as well
    assert found[1].across_sign.tolist() == [-1.0, 1.0, 1.0]


def test_modes_that_turn_into_each_other_are_followed_in_smaller_steps():
    """A turn by 0.45 pi between two poses looks like an exchange; half-way it is none."""
    asked = []

    def between(place):
        asked.append(place)
        return snapshot(turned(0.45 * pi * place), (1.0, 2.0, 3.0))

    found, doubts = tracked([between(0.0), between(1.0)], between)
    assert doubts == []
    assert len(asked) > 2
    np.testing.assert_allclose(np.abs(np.diag(found[1].shape)), [cos(0.45 * pi)] * 2 + [1.0])


def test_modes_that_jump_are_named_as_ambiguous():
    def between(place):
        return snapshot(turned(0.0 if place < 0.5 else pi / 4.0), (1.0, 2.0, 3.0))

    _, doubts = tracked([between(0.0), between(1.0)], between)
    assert len(doubts) == 2
    assert "mode 1 of left (w) between poses 1 and 2" in doubts


def test_modes_nearer_than_a_share_of_their_frequency_are_one():
    """At 1e-4 and at 1e4 Hz alike."""
    for hertz in (1e-4, 1e4):
        near, far = (1.0 + 0.5 * SAME) * hertz, (1.0 + 3.0 * SAME) * hertz
        alike = {"kinetic_shares": {}, "kind": "longitudinal", "family": "loop"}
        found = [SimpleNamespace(frequency=one, **alike) for one in (hertz, near, far)]
        listed = distinct(None, SimpleNamespace(modes=found), 10.0 * hertz)["modes"]
        assert [one.hertz for one in listed] == [hertz, far]


# --- Modes followed along a figure, of any machine


@pytest.mark.parametrize(
    "name, key, values",
    [
        ("linear-axis", "carriage.0.position", np.linspace(0.2, 1.8, 7)),
        ("printer-belt", "carriage.0.mass", np.geomspace(0.1, 1.0, 5)),
    ],
)
def test_a_loop_and_its_machine_with_routes_are_followed_alike(name, key, values, measured):
    drive = cd.load_drive(name, overrides=["layout.gravity=0"]).listed
    longer = 1.0 + drive.cable.prestrain if key.endswith("position") else 1.0
    one = cd.frequency_against(drive, key, values, modes=4)
    other = cd.frequency_against(as_routes(drive), key, values * longer, modes=4)
    off = float(np.abs(other.frequency.values / one.frequency.values - 1.0).max())
    measured(f"{off:.1e}")
    assert off < 1e-9, off
    assert list(other.crossing_kind.values) == list(one.crossing_kind.values)
    assert other.crossing_value.values == pytest.approx(one.crossing_value.values * longer, rel=1e-4)


def test_the_curves_of_a_machine_with_routes_are_its_listed_modes_and_as_symmetric_as_it():
    drive, values = cd.load_drive("corexy"), np.linspace(0.06, 0.36, 5)
    found = cd.frequency_against(drive, "head.x", values, modes=3)
    for value in values:
        listed = cd.natural_frequencies(varied_together(drive, {"head.x": value}), count=3)[:3]
        np.testing.assert_allclose(np.sort(found.frequency.sel(value=value).values)[:3], listed, rtol=1e-11)
    np.testing.assert_allclose(found.frequency, found.frequency[:, ::-1], rtol=1e-3)
    running = cd.load_drive("corexy", overrides=["route.0.speed=1"])
    with pytest.raises(cd.InputRefused, match="runs"):
        cd.frequency_against(running, "head.x", values)


def test_curves_of_the_straight_cable_say_where_sag_moves_a_mode(measured):
    """Where it hangs, the list of `modes` has the mode elsewhere by what the warning says."""
    drive = cd.load_drive("camera-line")
    tension = drive.cable.pretension
    found = cd.frequency_against(drive, "cable.pretension", [0.8 * tension, 4.0 * tension], modes=1)
    slackest = varied_together(drive, {"cable.pretension": 0.8 * tension})
    hanging = cd.modes(slackest, count=1).longitudinal[0].frequency
    moved = abs(float(found.frequency[0, 0]) / hanging - 1.0)
    measured(f"{moved:.2g}")
    assert f"sag moves a mode by {moved:.2g}" in found.warning
    assert (
        cd.frequency_against(
            cd.load_drive("linear-axis").listed, "cable.pretension", [700.0], modes=2
        ).warning
        == ""
    )
