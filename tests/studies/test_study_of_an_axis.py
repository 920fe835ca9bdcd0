"""A study of an axis of a machine with routes: its units, its reduced models, its resonance, its verdict."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.network_axis import as_axis, response_of_axis
from cabledrive.reduction.quality import model_quality
from cabledrive.rig import Motion, track
from cabledrive.rig.setting import DEGREE
from cabledrive.studies.study import Goals, run_study
from cabledrive.studies.study.results_file import results_of

RADIUS = 6.366e-3
"""Of the printer's motor pulley [m]."""


@pytest.fixture(scope="module")
def printer():
    return load_drive("printer-idlers", overrides=["sensors.load_encoder=40000"])


def test_the_response_of_an_axis_ends_in_its_rigid_mass(printer):
    """Far below the first mode the load follows 1 / (J omega^2), with the file's masses summed by hand."""
    axis, omega = as_axis(printer), 2.0 * np.pi * np.array([2.0])
    masses = {body.name: body.mass for body in printer.body}
    belt = sum(span.length for span in printer.free_spans) * printer.ropes[0].mass_per_length
    idlers = [pulley for pulley in printer.pulley if pulley.name != "motor"]
    moved = masses["head"] + belt + sum(one.inertia / one.radius**2 for one in idlers)
    motor = next(one for one in printer.pulley if one.name == "motor")
    inertia = motor.inertia + printer.motor[0].inertia + moved * motor.radius**2
    found = abs(response_of_axis(axis, omega)[0])
    damped = abs(inertia * omega[0] ** 2 - 1j * omega[0] * _viscous(printer, motor.radius))
    assert found == pytest.approx(1.0 / damped, rel=2e-3)


def _viscous(machine, radius):
    turned = {one.name: radius / one.radius for one in machine.pulley}
    total = sum(one.viscous_friction * turned[one.name] ** 2 for one in machine.pulley)
    return total + machine.motor[0].viscous_friction + sum(b.damping for b in machine.body) * radius**2


def test_the_chain_of_an_axis_holds_beyond_its_first_mode(printer, measured):
    one, three = model_quality(as_axis(printer))
    measured(f"rigid {one.holds_5:.0f} Hz, chain {three.holds_5:.0f} Hz, mode {three.exact[0]:.1f} Hz")
    assert three.frequencies == pytest.approx(three.exact, rel=1e-9)
    assert one.holds_5 < 0.5 * three.exact[0] < 1.5 * three.exact[0] < three.holds_5


@pytest.mark.parametrize(("axis", "other"), [("head.x", "10.9 %"), ("beam.y", "11.2 %")])
def test_axes_that_do_not_split_are_refused_with_their_coupling(axis, other):
    with pytest.raises(InputRefused, match=f"moves the other axis by {other}"):
        run_study(load_drive("corexy"), axis=axis)


@pytest.mark.verify
def test_a_study_of_the_printer_ends_in_millimetres_that_track_confirms(printer, measured):
    goals = Goals(travel=0.02, duration=0.15, carriage_error=5e-4, draws=300, cable_draws=0)
    found = run_study(printer, (), goals)
    data = results_of(found)
    measured(data["headline"])
    assert data["verdict"] == "yes", data["headline"]
    assert data["axis"]["load"] == "head.x"
    assert "lumped plants only" in data["headline"]
    chosen = next(one for one in data["candidates"] if one["holds"])
    motion = Motion(angle=0.02 / RADIUS / DEGREE, rise=0.15, pulses=1)
    run = track(printer, controller=chosen["controller"], motion=motion, plant="model-3")
    assert run.summary["axis"]["peak_error_mm"] < chosen["worst_mm"]
    harder = run_study(printer, (), replace(goals, carriage_error=1e-6, draws=50))
    assert results_of(harder)["verdict"] != "yes"
