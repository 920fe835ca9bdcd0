"""Each warning comes where its bound is crossed, and not on the other side of it."""

from dataclasses import replace
from functools import partial
from math import pi, radians, tanh

import pytest
from scipy.optimize import brentq

from cabledrive.mechanics import derived_quantities, drive_warnings
from cabledrive.parameters import Carriage, Goal, Sensors, load_drive

RIG = load_drive("dissertation-3")
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
    (lambda limit: changed(cable={"strain_limit": limit}), 7.007 / 438, 6.993 / 438, "(cable.strain_limit)"),
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
    (played, 0.99, 1.01, "motor.backlash"),
    (counted, 3601, 3599, "one count of sensors.load_encoder"),
    (slipping, 0.99, 1.01, "of pulley.0, which slips"),
    (slipping, 0.99, 1.01, "of pulley.1, which slips"),
    (larger_load, 0.99, 1.01, "of pulley.1, which slips"),
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
