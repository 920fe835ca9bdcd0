"""The datasheet holds the printed figures of the dissertation, and is plain numbers for any drive."""

import dataclasses
from contextlib import suppress
from dataclasses import replace
from math import exp, isfinite, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cabledrive.mechanics import derived_quantities, drive_warnings
from cabledrive.mechanics.datasheet import no_slip_torque
from cabledrive.mechanics.holding import lumped_joint_mode, span_stiffness
from cabledrive.mechanics.spans import lumped_cable_mode
from cabledrive.parameters import Carriage, InputRefused, Layout, NotComputed, load_drive, packaged_drives
from drive_strategies import drives
from oracles.hanging_machine import catenary_sag

SHEETS = {name: derived_quantities(load_drive(name)) for name in packaged_drives("loop", "line")}
FIRST, SECOND, THIRD = (SHEETS[f"dissertation-{n}"] for n in (1, 2, 3))
RIG = load_drive("dissertation-3")


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


@pytest.mark.parametrize("name", ["dissertation-1", "dissertation-3", "printer-belt", "ropeway"])
def test_sag_of_an_empty_level_span_is_that_of_its_catenary(name):
    """And Irvine's parameter of an even weight is (q L / H)^2 EA / H, at the tension that is there."""
    drive = replace(load_drive(name), carriage=())
    sheet, (sag, pull) = derived_quantities(drive), catenary_sag(drive)
    assert sheet.static_sag == pytest.approx(sag, rel=1e-6)
    weight = drive.cable.mass_per_length * 9.81 * drive.span_length
    stiffness = drive.cable.axial_rigidity * (1.0 + drive.cable.prestrain)
    steep = 0.5 * weight / pull
    assert sheet.irvine_parameter == pytest.approx(
        (weight / pull) ** 2 * stiffness / pull, rel=steep**2 + 1e-6
    )
    assert sheet.lowest_static_tension == pytest.approx(pull, rel=1e-6)


def extreme(table):
    """The table with each number at either end of what the drive file takes."""
    numbers = [
        f.name for f in dataclasses.fields(table) if f.metadata.get("bound") in ("positive", "nonnegative")
    ]
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


@given(drive=drives() | extreme_drives())
@settings(max_examples=300)
def test_sheet_and_warnings_of_any_drive_are_finite_and_plain(drive):
    if not 1e-24 < drive.cable.axial_rigidity < 1e24 or drive.pulley_distance > 1e23:
        with suppress(InputRefused):  # refused as no size of a machine, or far enough from where it shows
            derived_quantities(drive)
        return
    try:
        sheet = derived_quantities(drive).as_dict()
    except NotComputed:  # no state of rest is found of a rope that hardly pulls at all
        weight = drive.cable.mass_per_length * drive.span_length * drive.layout.gravity
        assert weight > 1e3 * drive.cable.pretension
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
    half = no_slip_torque(0.04, 7.0, friction, angle) / (2.0 * 0.04)
    assert (7.0 + half) == pytest.approx(exp(friction * angle) * (7.0 - half), rel=1e-9, abs=1e-12)


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
