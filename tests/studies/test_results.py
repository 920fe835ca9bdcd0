"""Every result that a function of the package gives shows itself, is a table and is drawn."""

import inspect
import typing
from dataclasses import dataclass, is_dataclass
from functools import cache

import numpy as np
import pytest

import cabledrive as cd
from cabledrive import identification, mechanics, modal, reduction, rig, simulation, studies
from cabledrive.answers.figures import Row, figure, shown
from cabledrive.answers.keys import Keys
from cabledrive.answers.result import Result
from cabledrive.app.schemas import schema_of
from cabledrive.control import OwnController
from cabledrive.report.blocks import listed, table_text
from cabledrive.rig import BodyMotion, OwnPlant
from rig_runs import scaled_transporter

NO_RESULTS = (OwnController, OwnPlant, reduction.LumpedChain)
ROOMS = (cd, mechanics, modal, simulation, reduction, identification, rig, studies)
EXPORTED = [getattr(room, name) for room in ROOMS for name in room.__all__]
FUNCTIONS = [one for one in EXPORTED if inspect.isfunction(one)]
LOOP, ROUTED = cd.load_drive("dissertation-3").listed, cd.load_drive("corexy")


TIME = np.linspace(0.0, 4.0, 4001)


@cache
def log():
    """A log of 4 s."""
    return cd.experiment(LOOP).part(0.0, 4.0)


SMALL = {
    "Drive": lambda: LOOP,
    "Machine": lambda: ROUTED,
    "DerivedQuantities": lambda: cd.derived_quantities(LOOP),
    "Modes": lambda: cd.modes(LOOP, count=2),
    "ResonanceSummary": lambda: cd.resonance(LOOP),
    "ResonanceSummary of routes": lambda: cd.resonance(cd.load_drive("serpentine")),
    "SimulationResult": lambda: cd.simulate(LOOP, 1e-3),
    "SimulationResult of routes": lambda: cd.simulate(ROUTED, 1e-4),
    "Tracking": lambda: cd.track(LOOP, controller="pd"),
    "Tracking of a body": lambda: cd.track(
        cd.load_drive("camera-winches"), motion=BodyMotion(moves={"camera.x": 1.0})
    ),
    "Comparison": lambda: cd.compare(LOOP, controllers=["pd"], draws=1),
    "Log": log,
    "FrequencyResponse": lambda: cd.response(log(), "torque", "angle"),
    "Identification": lambda: cd.identify(log()),
    "RestState": lambda: mechanics.rest_state(LOOP),
    "DecayEstimate": lambda: reduction.damping_from_decay(TIME, np.exp(-TIME) * np.cos(90.0 * TIME), 14.3),
    "CarriageRun": lambda: rig.move_carriage(
        scaled_transporter(cd.load_drive("dissertation-transporter").listed)
    ),
}
LONGER = {
    "PrinterShaper",
    "PlannedMotion",
    "ResponseFit",
    "SpanTensions",
    "StudyResult",
    "SweepResult",
}  # from files or long runs, which are not repeated here


def given(function):
    """Dataclasses that a function says it returns."""
    hint = function.__annotations__.get("return")
    return [one for one in (typing.get_args(hint) or (hint,)) if inspect.isclass(one) and is_dataclass(one)]


def test_every_exported_result_has_a_card_a_table_and_a_drawing():
    results = {one for function in FUNCTIONS for one in given(function) if not issubclass(one, NO_RESULTS)}
    assert [one.__name__ for one in results if not issubclass(one, Result)] == []
    assert {one.__name__ for one in results} <= SMALL.keys() | LONGER


@pytest.mark.parametrize("name", SMALL)
def test_a_result_shows_its_figures_its_table_and_its_curves(name):
    found = SMALL[name]()
    name = name.split()[0]
    assert type(found).__name__ == name
    table, card = found.to_dataframe(), found._repr_html_()
    assert table.size
    assert name in card
    assert all(value in card for _, value in found.figures if "<" not in value and "&" not in value)
    assert found.plot().axes


def test_a_comparison_runs_as_many_plants_as_it_was_asked():
    assert len(cd.compare(LOOP, controllers=["pd"], draws=2).laws[0].scores.peak) == 2


@dataclass(frozen=True, kw_only=True, repr=False)
class Pulled(Result):
    """A result of one figure."""

    force: float = figure("N", "pull of the rope", "Rope")


def test_a_figure_of_a_result_is_one_line_and_seen_wherever_results_are():
    row, pulled = Row("pull", "pull of the rope", "N", ".1f"), Pulled(force=1500.0)
    assert schema_of(Keys("*", of=Pulled))["required"] == ["force"]
    assert Keys("*", of=Pulled)(pulled) == {"force": 1500.0}
    assert "pull of the rope  1.5" in repr(pulled)
    assert "pull of the rope" in pulled._repr_html_()
    assert schema_of(Keys("", figures=(row,)))["properties"]["pull"]["type"] == ["number", "null"]
    assert table_text(listed("", (row,), [{"pull": 1500.0}])) == "pull of the rope [N]\n              1500.0"
    assert shown((row,), {"pull": 1500.0}) == [("pull of the rope", "1500.0 N")]
