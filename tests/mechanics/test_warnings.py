"""Each warning comes where its bound is crossed, and not on the other side of it."""

from dataclasses import replace
from math import pi, radians, tanh

import pytest

from cabledrive.mechanics import derived_quantities, drive_warnings
from cabledrive.parameters import Carriage, Goal, Sensors, load_drive, packaged_drives

RIG = load_drive("dissertation-3")
QUIET = replace(  # the rig with what the warnings complain of put right
    RIG, lumped=None, motor=replace(RIG.motor, torque_limit=0.5, rotor_inertia=None, backlash=0.0)
)


def changed(**tables):
    """The quiet drive with fields of its tables replaced: ``cable={"pretension": 6.0}``."""
    parts = {key: replace(getattr(QUIET, key), **fields) for key, fields in tables.items()}
    return replace(QUIET, **parts)


def with_pulleys(drive=QUIET, **fields):
    return replace(drive, pulley=[replace(pulley, **fields) for pulley in drive.pulley])


def test_sound_drive_gives_no_warning():
    assert drive_warnings(QUIET) == ()


def test_rig_of_the_dissertation_gives_the_three_of_its_errata():
    """Torque limit above 0.56 N m, 850 N/m against 438 N/m, rotor through the gear above J11."""
    slack, stiffness, rotor = drive_warnings(RIG)
    assert slack == (
        "motor.torque_limit = 2.1 N m is above 0.56 N m, the slack torque 2 r1 T0: a span can go slack; "
        "limit the torque or raise cable.pretension to 26.25 N"
    )
    assert stiffness.startswith("lumped.cable_stiffness = 850 N/m is 1.94 times EA / L = 438 N/m")
    assert rotor.startswith(
        "the rotor alone is 0.001449 kg m^2 through the gear, above motor.inertia = 0.0011"
    )


@pytest.mark.parametrize(
    "name", ["dissertation-1", "dissertation-2", "dissertation-transporter", "finger-tendon"]
)
def test_these_packaged_drives_give_no_warning(name):
    assert drive_warnings(load_drive(name)) == ()


def test_packaged_drives_that_say_so_are_warned_of():
    """The lift's ropes outweigh its sheaves; the gondola lift's rope and the camera line sag."""
    said = {name: " ".join(drive_warnings(load_drive(name))) for name in packaged_drives("loop", "line")}
    assert "the drive pulley is lighter than the cable" in said["elevator"]
    assert "the load pulley is lighter than the cable" in said["elevator"]
    assert "a span sags by 88.5 m, 8.02% of its length" in said["ropeway"]
    assert "a span sags by 1.51 m" in said["camera-line"]


def crossing(below, above):
    return [pytest.param(below, False, id="inside"), pytest.param(above, True, id="outside")]


def warned(drive, words):
    return any(words in line for line in drive_warnings(drive))


@pytest.mark.parametrize(("limit", "expected"), crossing(0.5599, 0.5601))
def test_torque_limit_above_the_slack_torque(limit, expected):
    assert warned(changed(motor={"torque_limit": limit}), "the slack torque 2 r1 T0") is expected


@pytest.mark.parametrize(("limit", "expected"), crossing(0.2799, 0.2801))
def test_torque_limit_of_a_line_above_its_slack_torque(limit, expected):
    drive = replace(changed(motor={"torque_limit": limit}), kind="line")
    assert warned(drive, "the slack torque r1 T0") is expected


def test_named_pretension_is_enough():
    """The remedy, followed, ends the warning."""
    drive = changed(motor={"torque_limit": 2.1}, cable={"pretension": 26.25, "area": 1e-6})
    assert not warned(drive, "slack torque")


@pytest.mark.parametrize(("limit", "expected"), crossing(26.3 / 438, 26.2 / 438))
def test_no_pretension_is_advised_that_strains_the_cable_beyond_its_stated_range(limit, expected):
    """2.1 N m would want 26.25 N."""
    drive = changed(motor={"torque_limit": 2.1}, cable={"strain_limit": limit})
    message = f"no cable.pretension within the cable's elastic range, up to {438 * limit:.4g} N, is enough"
    assert warned(drive, f"limit the torque: {message}") is expected
    assert warned(drive, "or raise cable.pretension to 26.25 N") is not expected


def test_a_rope_that_no_pretension_within_its_range_straightens_gets_no_such_advice():
    """The gondola lift: 2.4 MN, where its rope bears 650 kN."""
    assert warned(load_drive("ropeway"), "range, up to 650000 N, is enough to straighten it")
    assert warned(
        load_drive("camera-line"), "a cable.pretension of 3.33e+03 N would be enough to straighten it"
    )


@pytest.mark.parametrize(("limit", "expected"), crossing(7 / 438 * 1.001, 7 / 438 * 0.999))
def test_prestrain_beyond_the_stated_elastic_range(limit, expected):
    assert warned(changed(cable={"strain_limit": limit}), "(cable.strain_limit)") is expected


@pytest.mark.parametrize(("pretension", "expected"), crossing(0.0199 * 438, 0.0201 * 438))
def test_prestrain_beyond_two_percent_where_nothing_is_stated(pretension, expected):
    assert warned(changed(cable={"pretension": pretension}), "a rule of thumb") is expected


@pytest.mark.parametrize(("ratio", "expected"), crossing(0.0099, 0.0101))
def test_sag_above_a_hundredth_of_the_span(ratio, expected):
    """A slack stiffness keeps Irvine's parameter small: the sag alone is reported."""
    soft = changed(cable={"youngs_modulus": 1e3}, motor={"joint_stiffness": None, "torque_limit": None})
    gravity = soft.layout.gravity * ratio / derived_quantities(soft).sag_ratio
    drive = replace(soft, layout=replace(soft.layout, gravity=gravity))
    assert derived_quantities(drive).irvine_parameter < 1.0
    assert warned(drive, "a span sags by") is expected


@pytest.mark.parametrize(("irvine", "expected"), crossing(0.99, 1.01))
def test_irvine_parameter_above_one(irvine, expected):
    """It goes with the square of the weight; at 1 the sag of a stiff cable is far below L/100."""
    stiff = changed(
        cable={"youngs_modulus": 3e12}, sensors={"sample_rate": None}, motor={"joint_stiffness": None}
    )
    gravity = stiff.layout.gravity * (irvine / derived_quantities(stiff).irvine_parameter) ** 0.5
    drive = replace(stiff, layout=replace(stiff.layout, gravity=gravity))
    assert derived_quantities(drive).sag_ratio < 0.01
    assert warned(drive, "Irvine parameter") is expected


@pytest.mark.parametrize(("factor", "expected"), crossing(1.01, 0.99))
@pytest.mark.parametrize("number", [0, 1])
def test_pulley_lighter_than_the_cable(number, factor, expected):
    pulleys = list(QUIET.pulley)
    cable = 2 * QUIET.cable.mass_per_length * QUIET.span_length
    pulleys[number] = replace(pulleys[number], inertia=factor * cable * 0.04**2)
    drive = replace(QUIET, pulley=pulleys, sensors=None)
    name = ("drive", "load")[number]
    assert warned(drive, f"the {name} pulley is lighter than the cable") is expected


def test_motor_on_a_rigid_joint_counts_for_the_drive_pulley():
    pulleys = (replace(QUIET.drive_pulley, inertia=1e-9), QUIET.load_pulley)
    drive = replace(QUIET, pulley=pulleys, motor=replace(QUIET.motor, joint_stiffness=None))
    assert not warned(drive, "lighter than the cable")


@pytest.mark.parametrize(
    ("stiffness", "expected"),
    [(438 * 1.19, False), (438 * 1.21, True), (438 * 0.81, False), (438 * 0.79, True)],
)
def test_measured_stiffness_more_than_20_percent_from_that_of_the_cable(stiffness, expected):
    drive = replace(QUIET, lumped=replace(RIG.lumped, cable_stiffness=stiffness))
    assert warned(drive, "lumped.cable_stiffness") is expected


@pytest.mark.parametrize(("factor", "expected"), crossing(1.01, 0.99))
def test_joint_mode_below_the_cable_mode(factor, expected):
    sheet = derived_quantities(QUIET)
    softer = (sheet.cable_mode_frequency_hz / sheet.joint_mode_frequency_hz) ** 2 * 135.0 * factor
    assert warned(changed(motor={"joint_stiffness": softer}), "the motor joint's mode") is expected


@pytest.mark.parametrize(("inertia", "expected"), crossing(0.00145, 0.001449))
def test_rotor_through_the_gear_above_the_motor(inertia, expected):
    """536 g cm^2 through 5.2 are 1.4493e-3 kg m^2."""
    assert warned(changed(motor={"inertia": inertia, "rotor_inertia": 536e-7}), "the rotor alone") is expected


def test_rotor_that_is_all_of_the_motor_is_no_mistake():
    """As of a stepper on the pulley's shaft, to the last bit of the conversion."""
    motor = {"inertia": 536e-7 * 5.2 * 5.2, "rotor_inertia": 536e-7}
    assert not warned(changed(motor=motor), "the rotor alone")


@pytest.mark.parametrize(("backlash", "expected"), crossing(0.99, 1.01))
def test_backlash_above_the_tracking_goal(backlash, expected):
    drive = replace(changed(motor={"backlash": radians(backlash)}), goal=Goal(tracking_error=radians(1.0)))
    assert warned(drive, "motor.backlash") is expected
    assert not warned(replace(drive, goal=None), "motor.backlash")


@pytest.mark.parametrize(("counts", "expected"), crossing(3601, 3599))
def test_encoder_coarser_than_the_tracking_goal(counts, expected):
    drive = replace(changed(sensors={"load_encoder": counts}), goal=Goal(tracking_error=radians(0.1)))
    assert warned(drive, "one count of sensors.load_encoder") is expected


@pytest.mark.parametrize(("share", "expected"), crossing(0.99, 1.01))
def test_torque_limit_above_what_the_capstan_holds(share, expected):
    """Half a turn at 0.3 holds 0.56 N m * tanh(0.15 pi)."""
    drive = with_pulleys(
        changed(motor={"torque_limit": share * 0.56 * tanh(0.15 * pi)}), wrap_angle=pi, capstan_friction=0.3
    )
    assert warned(drive, "of pulley.0, which slips") is expected
    assert warned(drive, "of pulley.1, which slips") is expected


def test_larger_load_pulley_is_asked_for_more_torque_and_holds_more():
    """Both grow with its radius: what counts is the force along the cable."""
    pulleys = [
        replace(QUIET.drive_pulley),
        replace(QUIET.load_pulley, radius=0.08, wrap_angle=pi, capstan_friction=0.3),
    ]
    held = replace(changed(motor={"torque_limit": 0.99 * 0.56 * tanh(0.15 * pi)}), pulley=pulleys)
    assert not warned(held, "slips")
    slipping = replace(changed(motor={"torque_limit": 1.01 * 0.56 * tanh(0.15 * pi)}), pulley=pulleys)
    assert warned(slipping, "of pulley.1, which slips")


@pytest.mark.parametrize(("mass", "expected"), crossing(0.99, 1.01))
def test_weight_on_a_slope_that_slackens_a_span(mass, expected):
    """Straight up, fixed ends, the carriage 0.3 L from the bottom: below it 0.7 m g is lost; T0 = 7 N."""
    cable = replace(QUIET.cable, mass_per_length=1e-12)
    carriage = Carriage(mass=mass * 7.0 / (9.81 * 0.7), position=0.3)
    layout = replace(QUIET.layout, inclination=pi / 2)
    held = with_pulleys(replace(QUIET, kind="line", motor=None), fixed=True)
    drive = replace(held, cable=cable, carriage=[carriage], layout=layout)
    assert warned(drive, "a span hangs slack at rest") is expected


@pytest.mark.parametrize(("factor", "expected"), crossing(10.1, 9.9))
def test_sample_rate_below_ten_times_the_highest_lumped_mode(factor, expected):
    rate = factor * derived_quantities(QUIET).joint_mode_frequency_hz
    assert warned(replace(QUIET, sensors=Sensors(sample_rate=rate)), "sensors.sample_rate") is expected
