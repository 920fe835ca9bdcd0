"""A study of an axis of a machine with routes: its units, its reduced models, its resonance, its verdict."""

from dataclasses import replace

import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.network_axis import as_axis
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
