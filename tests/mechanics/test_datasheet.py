"""The datasheet holds the printed figures of the dissertation, plain numbers for any drive, and warnings."""

from contextlib import suppress
from dataclasses import fields, replace
from functools import partial
from math import atan, exp, hypot, isfinite, pi, radians, sqrt, tanh

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from cabledrive.mechanics import derived_quantities, drive_warnings, rest_state
from cabledrive.mechanics.holding import lumped_joint_mode, span_stiffness
from cabledrive.mechanics.network import statics_of
from cabledrive.mechanics.network.span_table import span_rows
from cabledrive.mechanics.spans import lumped_cable_mode
from cabledrive.parameters import Carriage, Goal, Layout, Pulley, Sensors, load_drive, packaged_drives
from cabledrive.parameters.errors import InputRefused, NotComputed
from drive_strategies import drives
from network_samples import as_routes
from oracles.hanging_machine import catenary_sag

SHEETS = {name: derived_quantities(load_drive(name).listed) for name in packaged_drives("loop", "line")}
FIRST, SECOND, THIRD = (SHEETS[f"dissertation-{n}"] for n in (1, 2, 3))
RIG = load_drive("dissertation-3").listed


@pytest.mark.parametrize(
    ("sheet", "quantity", "value"),
    [
        (FIRST, "prestrain", 5 / (2.6e9 * 4.26e-7)),
        (FIRST, "cable_stiffness", 1107.6),
        (FIRST, "pulley_distance", 1 + 5 / 1107.6),
        (FIRST, "stretched_mass_per_length", 4.9e-4 / (1 + 5 / 1107.6)),
        (FIRST, "axial_wave_speed", sqrt(1107.6 / 4.9e-4) * (1 + 5 / 1107.6)),
        (FIRST, "transverse_wave_speed", sqrt(5 / 4.9e-4 * (1 + 5 / 1107.6))),
        (FIRST, "transverse_frequency_hz", sqrt(5 / 4.9e-4 / (1 + 5 / 1107.6)) / 2),
        (FIRST, "cable_mode_frequency_hz", sqrt(2 * 1107.6 * 2 * 0.03**2 / 7.316e-6) / (2 * pi)),
        (FIRST, "chi1", 7.316e-6 / 0.03**2 / 9.8e-4),
        (FIRST, "slack_torque", 0.3),
        (THIRD, "lumped_cable_stiffness", 850.0),
        (THIRD, "slack_torque", 0.56),
        (derived_quantities(replace(RIG, kind="line")), "slack_torque", 0.28),
        (THIRD, "chi1", 0.000642 / 0.04**2 / 3.36e-4),
        (THIRD, "chi2", 0.00235 / 0.04**2 / 3.36e-4),
        (THIRD, "motor_encoder_resolution", 2 * pi / 2600),
        (THIRD, "load_encoder_resolution", 2 * pi / 10000),
        (THIRD, "motor_encoder_counts_per_motor_turn", 500.0),
        (THIRD, "reflected_rotor_inertia", 536e-7 * 5.2**2),
    ],
)
def test_figure_is_its_formula(sheet, quantity, value):
    """To round-off."""
    assert getattr(sheet, quantity) == pytest.approx(value, rel=1e-14)


def with_small_pulleys(drive):
    """Of a micrometre, so that sag moves the points where the cable leaves them by nothing."""
    return replace(drive, pulley=tuple(replace(one, radius=1e-6) for one in drive.pulley))


@pytest.mark.parametrize("name", ["dissertation-1", "dissertation-3", "printer-belt", "ropeway"])
def test_sag_of_an_empty_level_span_is_that_of_its_catenary(name):
    """And Irvine's parameter of an even weight is (q L / H)^2 EA / H, at the tension that is there."""
    drive = with_small_pulleys(replace(load_drive(name).listed, carriage=()))
    sheet, (sag, pull) = derived_quantities(drive), catenary_sag(drive)
    assert sheet.static_sag == pytest.approx(sag, rel=1e-6)
    weight = drive.cable.mass_per_length * 9.81 * drive.span_length
    steep = 0.5 * weight / pull
    assert sheet.irvine_parameter == pytest.approx(
        (weight / pull) ** 2 * drive.cable.axial_rigidity / pull, rel=steep**2 + 1e-6
    )
    assert sheet.lowest_static_tension == pytest.approx(pull, rel=1e-6)


@pytest.mark.parametrize("name", ["ropeway", "camera-line", "elevator"])
def test_table_of_spans_has_the_rope_between_its_wheels_and_all_weights(name):
    """By routes, sag included; Irvine's parameter is 12 EA/T times the mean of (V/T)^2."""
    drive = load_drive(name).listed
    machine = as_routes(drive)
    for span, row in zip(drive.spans, span_rows(machine, statics_of(machine)), strict=True):
        own = [stretch for stretch in rest_state(drive).stretches if stretch.span == span]
        length = sum(stretch.length for stretch in own)
        assert row["unstretched_length"] == pytest.approx(length, rel=1e-12)
        # but for what sag takes from the wheels, or gives
        assert length == pytest.approx(drive.span_length, rel=5e-3)
        places = np.linspace(0.0, 1.0, 2001)
        forces = [stretch.force_at(stretch.start + stretch.length * places) for stretch in own]
        parts = np.array([stretch.length for stretch in own]) / drive.span_length
        pull = parts @ [np.hypot(*force).mean() for force in forces]
        shear = parts @ [np.mean(force[1] ** 2) for force in forces]
        wanted = 12.0 * drive.cable.axial_rigidity * shear / pull**3
        assert row["irvine_parameter"] == pytest.approx(wanted, rel=2e-2, abs=1e-12)


def extreme(table):
    """The table with each number at either end of what the drive file takes."""
    numbers = [f.name for f in fields(table) if f.metadata.get("bound") in ("positive", "nonnegative")]
    changes = {
        name: st.sampled_from([1e-24, 1.0, 1e24]) for name in numbers if getattr(table, name) is not None
    }
    return st.fixed_dictionaries(changes).map(lambda values: replace(table, **values))


@st.composite
def extreme_drives(draw):
    drive = draw(drives(most_carriages=0))
    parts = {key: draw(extreme(getattr(drive, key))) for key in ("cable", "motor") if getattr(drive, key)}
    layout = Layout(span_length=draw(st.sampled_from([1e-24, 1.0, 1e24])), gravity=1e24)
    carriages = (
        [Carriage(mass=1e24, position=layout.span_length / 2, guided=False)]
        if layout.span_length > 1e-24
        else []
    )
    return replace(
        drive, layout=layout, carriage=carriages, pulley=[draw(extreme(p)) for p in drive.pulley], **parts
    )


def test_a_small_pulley_close_to_a_large_one_is_wrapped_by_what_the_large_one_leaves():
    """Radii of 10 and 810 mm, 32 cm of span: the large one is wrapped by 180 deg + 2 atan(0.8/0.32)."""
    pulleys = (Pulley(radius=0.01, inertia=1e-5), Pulley(radius=0.81, inertia=1.0))
    layout = Layout(pulley_distance=0.32, gravity=0.0)
    small, large = (
        span.wrap for span in reversed(as_routes(replace(RIG, layout=layout, pulley=pulleys)).free_spans)
    )
    assert large == pytest.approx(pi + 2.0 * atan(0.8 / 0.32), rel=1e-12)
    assert small == pytest.approx(2.0 * pi - large, rel=1e-12)


@pytest.mark.parametrize("draws", [40, pytest.param(400, marks=pytest.mark.verify)])
def test_sheet_and_warnings_of_any_drive_are_finite_and_plain(draws):
    settings(max_examples=draws)(given(drive=drives() | extreme_drives())(sheet_is_finite_and_plain))()


def sheet_is_finite_and_plain(drive):
    flat = max(own.radius for own in drive.pulley) > 1e4 * drive.pulley_distance  # its span is round-off
    if not 1e-24 < drive.cable.axial_rigidity < 1e24 or drive.pulley_distance > 1e23 or flat:
        with suppress(InputRefused, NotComputed):  # as no size of a machine, or of round-off
            derived_quantities(drive)
        return
    try:
        sheet = derived_quantities(drive).as_dict()
    except NotComputed:  # no state of rest of a cable that hardly pulls at all, or that wheels would swallow
        borne = drive.cable.mass_per_length * drive.span_length + sum(own.mass for own in drive.carriage)
        borne *= drive.layout.gravity / drive.cable.pretension
        wide = max(own.radius for own in drive.pulley) >= drive.span_length
        assert wide or borne > (50.0 if drive.kind == "loop" else 1.0)
        return
    except InputRefused:  # one pulley reaches into the other
        first, last = (pulley.radius for pulley in drive.pulley)
        assert first + last > hypot(drive.pulley_distance, last - first)
        return
    assert all(isfinite(value) for key, value in sheet.items() if key != "reasons" and value is not None), (
        sheet
    )
    for line in drive_warnings(drive):
        assert line.isprintable()
        assert len(line) < 400, f"{len(line)} characters: {line}"


# --- What a pulley transmits by friction


@given(friction=st.floats(0.01, 1.0), angle=st.floats(0.1, 8.0))
def test_at_the_no_slip_torque_the_tensions_stand_in_the_capstan_ratio(friction, angle):
    """T0 + d and T0 - d with r 2d = torque."""
    gripped = replace(RIG.load_pulley, capstan_friction=friction, wrap_angle=angle)
    drive = replace(RIG, pulley=(RIG.drive_pulley, gripped))
    half, tension = (
        derived_quantities(drive).no_slip_torque_load / (2.0 * gripped.radius),
        RIG.cable.pretension,
    )
    assert (tension + half) == pytest.approx(exp(friction * angle) * (tension - half), rel=1e-9, abs=1e-9)


# --- First estimates of the cable's and the joint's mode, held against the measured ones
def test_modes_of_the_rig_are_those_of_table_6_2():
    """8.27 Hz and 92.2 Hz, fitted to the response; the parameters have two to three digits."""
    assert lumped_cable_mode(RIG) / (2 * pi) == pytest.approx(8.27, rel=0.005)
    assert lumped_joint_mode(RIG) / (2 * pi) == pytest.approx(92.2, rel=0.005)


def test_estimates_bracket_the_coupled_modes():
    """Motor, drive pulley and load pulley on two springs: rigid joint and free cable shift both modes up."""
    k = 2.0 * span_stiffness(RIG) * RIG.drive_pulley.radius**2
    km = RIG.motor.joint_stiffness
    stiffness = np.array([[km, -km, 0.0], [-km, km + k, -k], [0.0, -k, k]])
    inertia = np.array([RIG.motor.inertia, RIG.drive_pulley.inertia, RIG.load_pulley.inertia])
    omega = np.sqrt(np.abs(np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(inertia, inertia)))))
    assert omega[1] < lumped_cable_mode(RIG) < 1.01 * omega[1], f"{omega}"
    assert lumped_joint_mode(RIG) < omega[2] < 1.02 * lumped_joint_mode(RIG), f"{omega}"


def test_fixed_load_pulley_leaves_the_drive_side_on_both_spans():
    drive = replace(RIG, pulley=(RIG.drive_pulley, replace(RIG.load_pulley, fixed=True)))
    inertia = RIG.motor.inertia + RIG.drive_pulley.inertia
    assert lumped_cable_mode(drive) == pytest.approx(sqrt(2 * 850.0 * 0.04**2 / inertia), rel=1e-14)


def test_line_has_one_span_and_measured_stiffness_stands_before_that_of_the_cable():
    one = lumped_cable_mode(replace(RIG, kind="line"))
    assert lumped_cable_mode(RIG) == pytest.approx(sqrt(2.0) * one, rel=1e-14)
    assert span_stiffness(RIG) == 850.0
    assert span_stiffness(replace(RIG, lumped=None)) == pytest.approx(438.0, rel=1e-14)


# --- Each warning comes where its bound is crossed, and not on the other side of it
QUIET = replace(  # the rig with what the warnings complain of put right
    RIG, lumped=None, motor=replace(RIG.motor, torque_limit=0.5, rotor_inertia=None, backlash=0.0)
)
SLIP = 0.56 * tanh(0.15 * pi)
"""Torque that half a turn at 0.3 holds [N m]."""
WRAPPED = {"wrap_angle": pi, "capstan_friction": 0.3}


def changed(**tables):
    """The quiet drive with fields of its tables replaced: ``cable={"pretension": 6.0}``."""
    parts = {key: replace(getattr(QUIET, key), **fields) for key, fields in tables.items()}
    return replace(QUIET, **parts)


def with_pulleys(drive=QUIET, **fields):
    return replace(drive, pulley=[replace(pulley, **fields) for pulley in drive.pulley])


def warned(drive, words):
    return any(words in line for line in drive_warnings(drive))


def test_a_rotor_heavier_than_its_motor_is_named_on_machines_with_routes_too():
    """54 g cm^2 without a gear: a rotor of 55 g cm^2 is none of its parts, one of 54 is all of it."""
    for rotor, named in ((55e-7, True), (54e-7, False)):
        belt = load_drive("printer-idlers", overrides=[f"motor.rotor_inertia={rotor}"])
        assert any("the rotor alone" in line for line in drive_warnings(belt)) is named


def test_rig_of_the_dissertation_gives_the_three_of_its_errata():
    """Torque limit above 0.56 N m, 850 N/m against 438 N/m, rotor through the gear above J11."""
    slack, stiffness, rotor = drive_warnings(RIG)
    assert slack == (
        "the motor's torque_limit = 2.1 N m is above 0.56 N m, the slack torque 2 r1 T0: a span can go "
        "slack; limit the torque or raise the pretension to 26.25 N"
    )
    assert stiffness.startswith("lumped.cable_stiffness = 850 N/m is 1.94 times EA / L = 438 N/m")
    assert rotor.startswith(
        "the rotor alone is 0.001449 kg m^2 through the gear, above the motor's inertia, 0.0011"
    )


def test_a_motor_of_two_pulleys_as_routes_holds_its_whole_inertia():
    """Its pulley has none of its own: what is found of it by parts has half of the motor's, the motor all."""
    machine = load_drive("printer-belt").machine.plain
    first, last = machine.pulley
    motor = replace(machine.motor[0], rotor_inertia=0.8 * machine.motor[0].inertia, gear_ratio=1.0)
    machine = replace(machine, pulley=(replace(first, inertia=0.0), last), motor=(motor,))
    assert machine.two_pulleys is not None
    assert not warned(machine, "the rotor alone")


@pytest.mark.parametrize("name", SHEETS)
def test_what_is_odd_about_two_pulleys_is_said_of_both_forms_of_their_file(name):
    """Word for word but for a measured stiffness, which a file of routes cannot give."""
    drive = load_drive(name).listed
    said = [line for line in drive_warnings(drive) if not line.startswith("lumped.")]
    assert list(drive_warnings(drive.machine.plain)) == said


def limited(torque, **fields):
    return replace(changed(motor={"torque_limit": torque}), **fields)


def heavier(drive, figure, wanted):
    """The drive under the gravity that gives a figure of its datasheet a value."""

    def under(share):
        return replace(drive, layout=replace(drive.layout, gravity=share * drive.layout.gravity))

    def off(share):
        return getattr(derived_quantities(under(share)), figure) / wanted - 1.0

    return under(brentq(off, 1e-3, 1e5, rtol=1e-6))


def sagging(ratio):
    """A slack stiffness keeps Irvine's parameter small: the sag alone is reported."""
    soft = changed(cable={"youngs_modulus": 1e3}, motor={"joint_stiffness": None, "torque_limit": None})
    drive = heavier(soft, "sag_ratio", ratio)
    assert derived_quantities(drive).irvine_parameter < 1.0
    return drive


def stiffened(irvine):
    """At 1 the sag of a stiff cable is far below L/100."""
    stiff = changed(
        cable={"youngs_modulus": 3e12}, sensors={"sample_rate": None}, motor={"joint_stiffness": None}
    )
    drive = heavier(stiff, "irvine_parameter", irvine)
    assert derived_quantities(drive).sag_ratio < 0.01
    return drive


def lighter(factor, number):
    """One pulley as heavy as the cable times a factor."""
    pulleys, cable = list(QUIET.pulley), 2 * QUIET.cable.mass_per_length * QUIET.span_length
    pulleys[number] = replace(pulleys[number], inertia=factor * cable * 0.04**2)
    return replace(QUIET, pulley=pulleys, sensors=None)


def measured_stiffness(factor):
    return replace(QUIET, lumped=replace(RIG.lumped, cable_stiffness=438 * factor))


def jointed(factor):
    sheet = derived_quantities(QUIET)
    softer = (sheet.cable_mode_frequency_hz / sheet.joint_mode_frequency_hz) ** 2 * 135.0 * factor
    return changed(motor={"joint_stiffness": softer})


def played(degrees):
    return replace(changed(motor={"backlash": radians(degrees)}), goal=Goal(tracking_error=radians(1.0)))


def counted(counts):
    return replace(changed(sensors={"load_encoder": counts}), goal=Goal(tracking_error=radians(0.1)))


def held_upright(mass):
    """Straight up, fixed ends, the carriage 0.3 L from the bottom: below it 0.7 m g is lost; T0 = 7 N."""
    cable = replace(QUIET.cable, mass_per_length=1e-12)
    carriage = Carriage(mass=mass * 7.0 / (9.81 * 0.7), position=0.3)
    held = with_pulleys(replace(QUIET, kind="line", motor=None), fixed=True)
    layout = replace(QUIET.layout, inclination=pi / 2)
    return replace(held, cable=cable, carriage=[carriage], layout=layout)


def sampled(factor):
    rate = factor * derived_quantities(QUIET).joint_mode_frequency_hz
    return replace(QUIET, sensors=Sensors(sample_rate=rate))


def slipping(share):
    return with_pulleys(limited(share * SLIP), **WRAPPED)


def larger_load(share):
    """It is asked for more torque and holds more: what counts is the force along the cable."""
    return limited(
        share * SLIP, pulley=[QUIET.drive_pulley, replace(QUIET.load_pulley, radius=0.08, **WRAPPED)]
    )


def bent(factor):
    """A hinged beam under 7 N: pi^2 EI / (2 T L^2) is 1e-4 at the bound."""
    stiffness = factor * 2e-4 / pi**2 * 7.0 * QUIET.span_length**2
    return changed(cable={"bending_stiffness": stiffness})


CROSSINGS = [
    (limited, 0.5599, 0.5601, "the slack torque 2 r1 T0"),
    (partial(limited, kind="line"), 0.2799, 0.2801, "the slack torque r1 T0"),
    (lambda limit: changed(cable={"strain_limit": limit}), 7.007 / 438, 6.993 / 438, "(strain_limit)"),
    (lambda strain: changed(cable={"pretension": 438 * strain}), 0.0199, 0.0201, "a rule of thumb"),
    (sagging, 0.0099, 0.0101, "a span sags by"),
    (stiffened, 0.99, 1.01, "Irvine parameter"),
    (partial(lighter, number=0), 1.01, 0.99, "the drive pulley is lighter than the cable"),
    (partial(lighter, number=1), 1.01, 0.99, "the load pulley is lighter than the cable"),
    (measured_stiffness, 1.19, 1.21, "lumped.cable_stiffness"),
    (measured_stiffness, 0.81, 0.79, "lumped.cable_stiffness"),
    (jointed, 1.01, 0.99, "the motor joint's mode"),
    # 536 g cm^2 through 5.2 are 1.4493e-3 kg m^2
    (
        lambda inertia: changed(motor={"inertia": inertia, "rotor_inertia": 536e-7}),
        0.00145,
        0.001449,
        "the rotor alone",
    ),
    (played, 0.99, 1.01, "a backlash of"),
    (counted, 3601, 3599, "one count of sensors.load_encoder"),
    (slipping, 0.99, 1.01, "of the drive pulley, which slips"),
    (slipping, 0.99, 1.01, "of the load pulley, which slips"),
    (larger_load, 0.99, 1.01, "of the load pulley, which slips"),
    (held_upright, 0.99, 1.01, "a span hangs slack at rest"),
    (sampled, 10.1, 9.9, "sensors.sample_rate"),
    (lambda strength: changed(cable={"strength": strength}), 21.1, 20.9, "safety factor"),
    (lambda radius: changed(cable={"least_radius": radius}), 0.0399, 0.0401, "smallest radius"),
    (bent, 0.99, 1.01, "limp cable"),
]


@pytest.mark.parametrize(("drive", "inside", "outside", "words"), CROSSINGS)
def test_a_warning_comes_where_its_bound_is_crossed_and_not_before(drive, inside, outside, words):
    assert not warned(drive(inside), words)
    assert warned(drive(outside), words)
