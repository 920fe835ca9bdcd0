"""Names, dimensions, units and meanings of what a result holds: the same in memory and on disk."""

import json
from typing import Any, NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.channels import CHANNELS
from cabledrive.simulation.result import SimulationResult

PLANES = ["u", "v", "w"]


class Variable(NamedTuple):
    """One array with what it takes to read it."""

    name: str
    dimensions: tuple[str, ...]
    values: Array
    unit: str
    meaning: str


class Content(NamedTuple):
    """All that a result holds: numbers that are coordinates, other numbers, words, and what is known."""

    coordinates: list[Variable]
    variables: list[Variable]
    words: dict[str, tuple[str, list[str]]]
    attributes: dict[str, Any]


def content_of(result: SimulationResult) -> Content:
    """All of a result of a loop or a line."""
    return Content(coordinates(result), variables(result), words(result), attributes(result))


def coordinates(result: SimulationResult) -> list[Variable]:
    """Coordinates that are numbers."""
    places = np.array([place for _, place in result.probes])
    found = [
        Variable("time", ("time",), result.time, "s", "time of a record"),
        Variable(
            "position", ("span", "node"), result.position, "m", "distance of a node from its span's start"
        ),
        Variable("probe_position", ("probe",), places, "m", "distance of a probe from its span's start"),
    ]
    if len(result.field_time):
        found.append(Variable("field_time", ("field_time",), result.field_time, "s", "time of a whole field"))
    return found


def words(result: SimulationResult) -> dict[str, tuple[str, list[str]]]:
    """Coordinates that are words: name to dimension and values."""
    return {
        "span": ("span", list(result.spans)),
        "plane": ("plane", PLANES),
        "probe_span": ("probe", [span for span, _ in result.probes]),
    }


def variables(result: SimulationResult) -> list[Variable]:
    """All arrays of a result but its coordinates."""
    missing = [span for span in ("upper", "lower") if span not in result.spans]
    found = [
        Variable(channel.name, ("time",), result.channel(channel.name), channel.unit, channel.meaning)
        for channel in CHANNELS
        if not any(channel.name.endswith(span) for span in missing)
    ]
    found.append(
        Variable(
            "budget_error", ("time",), result.budget_error, "J", "error of the energy budget, 0 at the start"
        )
    )
    probes = np.stack([result.probe(number) for number in range(len(result.probes))], axis=1)
    found.append(
        Variable("displacement", ("time", "probe", "plane"), probes, "m", "displacement of the probes")
    )
    if len(result.field_time):
        found.append(
            Variable(
                "field",
                ("field_time", "span", "node", "plane"),
                by_span(result),
                "m",
                "displacement of all nodes",
            )
        )
    return found


def by_span(result: SimulationResult) -> Array:
    """Whole fields span by span, the rims in both, (field records, spans, n + 1, 3): displacements [m]."""
    n = result.position.shape[1] - 1
    spans = [result.fields[:, :, k * n : (k + 1) * n + 1] for k in range(len(result.spans))]
    return np.stack(spans, axis=1).transpose(0, 1, 3, 2)


def attributes(result: SimulationResult) -> dict[str, Any]:
    """What is known of a result as a whole but any time of day: the same run gives the same file."""
    whole = {**result.provenance, **result.summary()}
    del whole["wall_time"]
    if whole["error_estimate"] is None:
        del whole["error_estimate"]
    return storable(whole)


def storable(known: dict[str, Any]) -> dict[str, Any]:
    """What is known, as numbers and text that a file takes."""
    return {
        key: value
        if isinstance(value, int | float | str) and value is not True and value is not False
        else json.dumps(value)
        for key, value in known.items()
    }
