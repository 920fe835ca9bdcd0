"""Machines made to break the solver: a list is certified and right, says that it is not, or is refused."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from machines import LINE, MOTOR, drive, machine, pulley, some_cable, spread
from transfer_roots import exact_roots

import cabledrive as cd
from cabledrive.modal.tuning import tuned_pretension
from cabledrive.parameters import packaged_drives
from command import refused
from drive_strategies import drives
from network_samples import route, routed
from other_units import in_other_units
from rewritten import backwards, mirrored


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


@pytest.mark.parametrize(
    "by",
    [
        (1.0, 1e-2, 1.0),
        pytest.param((0.064, 1.5e-3, 29.0), marks=pytest.mark.verify),
        pytest.param((2e2, 40.0, 1e-2), marks=pytest.mark.verify),
    ],
)
@pytest.mark.parametrize("name", packaged_drives())
def test_modes_do_not_depend_on_units(name, by):
    """With every mass, length and time so many times as large the modes are the same by its own time."""
    given = cd.load_drive(name).listed
    own, other = cd.modes(given, count=6), cd.modes(in_other_units(given, by), count=6)
    words = [
        [(m.kind, m.multiplicity, m.family, m.span, m.plane) for m in found.modes] for found in (own, other)
    ]
    assert words[1] == words[0]
    times = [m.frequency * by[2] for m in other.modes]
    assert times == pytest.approx([m.frequency for m in own.modes], rel=1e-6)
    assert other.certified == own.certified


@pytest.mark.parametrize("name", ["lift-2-to-1", "printer-idlers"])
def test_modes_of_spans_that_sound_alike_are_listed_in_the_order_of_the_spans(name):
    """Round-off decided which of two spans of one frequency is listed first, and units changed it."""
    given = cd.load_drive(name)
    own, other = (
        cd.modes(one, count=8).transverse for one in (given, in_other_units(given, (10.0, 1.0, 1.0)))
    )
    assert [(mode.span, mode.plane) for mode in other] == [(mode.span, mode.plane) for mode in own]


@pytest.mark.parametrize("name", packaged_drives())
def test_modes_do_not_depend_on_the_way_a_route_is_followed(name):
    """A ropeway was refused: of its coefficients those of round-off alone had their say in the scales."""
    given = cd.load_drive(name).machine.plain
    own, other = cd.modes(given, count=6), cd.modes(backwards(given), count=6)
    assert [mode.frequency for mode in other.modes] == pytest.approx(
        [mode.frequency for mode in own.modes], rel=1e-8
    )
    assert (other.certified, other.rigid_body_modes) == (own.certified, own.rigid_body_modes)


@pytest.mark.parametrize("name", ["capstan-arm", "dissertation-1"])
def test_of_parts_that_move_alike_a_mode_is_named_after_the_first(name):
    """Round-off decided between two idlers, or two pulleys, and another way of writing them changed it."""
    given = cd.load_drive(name).machine.plain
    own, *others = (
        [mode.family for mode in cd.modes(one, count=6).longitudinal]
        for one in (given, mirrored(given), backwards(given))
    )
    assert others == [own, own]


@pytest.mark.parametrize("contrast", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("kind", ["loop", "line"])
@pytest.mark.parametrize("carriages", [400, pytest.param(10_000, marks=pytest.mark.verify)])
def test_strings_of_carriages_are_certified(kind, contrast, carriages, measured):
    """Spans and masses from alike to a million to one; of 10,000 so far apart not all may be proven."""
    modes = cd.modes(string_of_carriages(carriages, contrast, kind), count=15)
    count, below = modes.certificate.count, modes.certificate.below
    measured(f"{count} modes below {below:.4g} Hz {'' if modes.certified else 'not '}certified")
    assert modes.certified or (modes.certified_reason and (carriages, contrast) == (10_000, 1e6))
    found = np.array([mode.frequency for mode in modes.modes])
    assert np.all(np.diff(found) >= -1e-12 * found[1:])
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


@pytest.mark.parametrize("inertia", [6.4e-13, 6.447e-13, 6.5e-15])
def test_a_slow_mode_whose_rate_drowns_in_round_off_is_right_or_refused(inertia):
    """A wheel almost without inertia on a weak spring, and one of 1 kg m^2 on a belt of 2 kg."""
    spring = 3.0 * inertia
    stiff = cd.Drive(
        name="stiff",
        kind="loop",
        cable=cd.Cable(youngs_modulus=1167289.0, area=0.0078125, mass_per_length=1.0, pretension=1.0),
        layout=cd.Layout(span_length=1.0, gravity=0.0),
        pulley=(cd.Pulley(radius=1.0, inertia=inertia), cd.Pulley(radius=1.0, inertia=1.0)),
        motor=cd.Motor(inertia=inertia, holding_stiffness=spring),
    )
    try:
        lowest = cd.modes(stiff, count=1).modes[0].frequency
    except cd.NotComputed:
        return
    assert lowest == pytest.approx(np.sqrt(spring / 3.0) / (2 * np.pi), rel=1e-6)


@pytest.mark.parametrize("askew", [1e-9, 1e-8, 1e-6, 1e-5, 3e-5])
def test_a_clamp_askew_to_the_rail_by_a_rounded_figure_leaves_the_travel_free(askew):
    """A slope of 1e-4 would hold the head at some millihertz, which drowns in round-off."""
    for name, clamp, x, y in (
        ("printer-idlers", "left clamp", 0.18, 6.366e-3),
        ("corexy", "head left a", 0.15, 0.194),
    ):
        exact, rounded = (
            cd.modes(
                cd.load_drive(name, overrides=[f"anchor.{clamp}.at=[{x}, {y + off!r}]"]).listed,
                below=200.0,
                motor="free",
            )
            for off in (0.0, askew)
        )
        assert rounded.rigid_body_modes == exact.rigid_body_modes
        first, second = ([m.frequency for m in own.longitudinal] for own in (exact, rounded))
        assert second == pytest.approx(first, rel=1e-5)


UNEVEN = """
[cable]
axial_rigidity = 162412
mass_per_length = 0.151308
pretension = 632.126
[[body]]
name = "arm"
at = [0.268720681, 0.064513305]
moves = "turn"
pivot = [0.268720681, 0.064513305]
inertia = 0.00122347
stiffness = 13.5923
[[pulley]]
name = "crank"
at = [0.5525, 0.0556]
radius = 0.0840608
inertia = 0.172
[[pulley]]
name = "tensioner"
on = "arm"
at = [0.365720681, 0.058513305]
radius = 0.0310384
inertia = 0.000466058
[[pulley]]
name = "accessory"
at = [0, 0]
radius = 0.0215485
inertia = 0.000214039
[[pulley]]
name = "alternator"
at = [0.1, -0.15]
radius = 0.03
inertia = 0.000251118
[[route]]
name = "belt"
path = ["+crank", "-tensioner", "+accessory", "+alternator"]
closed = true
"""


def test_a_belt_of_which_some_spans_are_straight_at_a_frequency_is_as_stable_as_at_rest():
    """Few of its modes were listed, and more refused: its curvature was taken for stiffness far below."""
    machine = routed(UNEVEN)
    few, more = (cd.natural_frequencies(machine, count=count) for count in (2, 6))
    assert more[:2] == pytest.approx(few, rel=1e-9)


def test_modes_of_equal_spans_tied_by_hardly_anything_are_of_one_span_each():
    """Two strands of a printer ring at one frequency: each shape of that mode is of one of them."""
    places = [("beam left b", 0.0120001), ("beam right a", 0.4079999)]
    machine = cd.load_drive(
        "corexy",
        overrides=["cable.pretension=6", *(f"pulley.{name}.at=[{x}, 0.188]" for name, x in places)],
    ).listed
    double = next(
        mode for mode in cd.modes(machine, below=80.0, motor="free").modes if mode.multiplicity == 2
    )
    spans = {"front right a to beam right a", "front left b to beam left b"}
    assert {one.span for one in double.single} == spans
    for one in double.single:
        assert one.strain_by_span[one.span, "across"] == pytest.approx(1.0, abs=1e-6)
        at = np.linspace(0.0, 0.18, 7)
        assert np.abs(one.displacement(one.span, "across", at)).max() > 0.5


def test_a_span_as_long_as_a_file_may_say_rings_at_the_tone_of_a_string():
    """c / (2 L_e) at 1e20 m: the count squares no small number away."""
    loop = cd.load_drive("dissertation-2").listed
    steel = replace(loop.cable, youngs_modulus=200e9, area=6e-7, mass_per_length=4.7e-3, pretension=60.0)
    loop = replace(loop, cable=steel, layout=replace(loop.layout, span_length=1e20, gravity=0.0))
    found = cd.modes(loop, count=1)
    lowest = min(mode.frequency for mode in found.transverse)
    expected = loop.cable.transverse_wave_speed / (2 * loop.pulley_distance)
    assert found.certified
    assert lowest == pytest.approx(expected, rel=1e-9)


# --- What `modes` and what is made of them refuse: each row a call, and what its one line names
LOOP = cd.load_drive("dissertation-1").listed
HELD = replace(LOOP, pulley=tuple(replace(pulley, fixed=True) for pulley in LOOP.pulley))
LIMITS = [
    *(({"below": below}, ["below = "]) for below in (0.0, -1.0, np.nan, np.inf)),
    *(({"below": below}, ["lower it to about"]) for below in (1e7, 1e30)),
    *(({"below": below}, ["must lie between"]) for below in (1e308, 1e-300, 5e-324)),
    *(({"count": count}, ["count = ", "1 and 20000"]) for count in (0, 10**6)),
]
HOLDING = [
    ({"motor": "stuck"}, ["free, held or holding"]),
    ({"motor": "holding"}, ["motor.holding_stiffness"]),
    ({"hold": ["carriage 1"]}, ['did you mean "carriage 0"']),
    ({"hold": ["motor"]}, ['motor = "held"']),
]
CHAINS = [
    ({"rigidity": np.array([1.0, -3.0, 1.0])}, ["segment 1", "rigidity", "-3 N", "positive"]),
    ({"density": np.array([1.0, 2.0])}, ["density", "2 values", "3 segments"]),
    ({"lengths": np.array([0.1, np.nan, 0.1])}, ["segment 1", "length", "nan m", "finite"]),
    ({"grounds": np.array([0.0, 0.0, -1.0, 0.0])}, ["joint 2", "grounds", "-1 N/m"]),
    ({"pendants": (replace(MOTOR, joint=4),)}, ["pendant 0", "joint = 4", "0 to 3"]),
    ({"pendants": (MOTOR, replace(MOTOR, mass=0.0))}, ["pendant 1", "mass", "0 kg", "positive"]),
]
ROWS = [
    *((lambda given=given: cd.modes(LOOP, **given), named) for given, named in LIMITS),
    *(
        (lambda given=given: cd.modes(cd.load_drive("linear-axis").listed, **given), named)
        for given, named in HOLDING
    ),
    *((lambda given=given: cd.modes(replace(LINE, **given)), named) for given, named in CHAINS),
    (lambda: cd.modes(LINE, motor="held"), ["about drives"]),
    (lambda: cd.modes(LINE, hold=["joint 0"]), ["about drives"]),
    (lambda: cd.modes(LINE, at_torque=1.0), ["about drives"]),
    (lambda: cd.modes(route("serpentine", "route.belt.speed=60")), ["reaches the wave speed"]),
    (lambda: cd.modes(route("serpentine", "route.belt.speed=60", "layout.gravity=9.81")), ["54.04 m/s"]),
    (lambda: tuned_pretension(HELD), ["no pulley turns"]),
]


@pytest.mark.parametrize(("call", "named"), ROWS)
def test_what_has_no_modes_is_refused_in_one_line_that_names_it(call, named):
    refused(call, *named)
