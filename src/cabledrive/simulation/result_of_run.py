"""The result of a run, from its records and its last state."""

from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.simulation.audit import energy_handled, rest_energy, slack_events
from cabledrive.simulation.case import Case
from cabledrive.simulation.plan import RADIUS
from cabledrive.simulation.records import Records
from cabledrive.simulation.result import SimulationResult
from cabledrive.simulation.run import Outcome

MOST_LOADED = 1_000_000_000  # bytes


def result_of(case: Case, records: Records, outcome: Outcome) -> SimulationResult:
    """Result of a run, as far as it went."""
    rows, fields = records.arrays()
    rows = loaded(rows[: outcome.records])
    every = case.recording.fields or 1
    time: Array = np.arange(len(rows), dtype=np.float64) * case.grid.interval
    fields = fields[: -(-len(rows) // every)]
    return SimulationResult(
        time=time,
        rows=rows,
        probes=(
            *((span, 0.5 * float(case.mesh.position[0, -1])) for span in case.mesh.spans),
            *case.recording.probes,
        ),
        field_time=np.array(time[::every][: len(fields)]),
        fields=loaded(fields),
        spans=case.mesh.spans,
        position=case.mesh.position,
        steps=int(outcome.state.counts[0]),
        step=case.grid.step,
        cfl=case.grid.cfl,
        energy_handled=energy_handled(rows, rest_energy(case.drive, case.mesh, case.law)),
        slack_events=slack_events(case, outcome.state),
        extremes=_extremes(case, outcome),
        provenance=_provenance(case),
        stopped=outcome.stopped,
        wall_time=outcome.wall_time,
    )


def loaded(array: Array) -> Array:
    """Moderate records in memory; larger ones stay in their file, which lives as long as it is mapped."""
    return np.array(array) if array.nbytes <= MOST_LOADED else array


def _extremes(case: Case, outcome: Outcome) -> dict[str, float]:
    found = {}
    for k, shaft in enumerate(("drive", "load", "motor")):
        for side, word in enumerate(("min", "max")):
            place = float(outcome.state.extremes[2 * k + side])
            found[f"{shaft}_angle_{word}"] = (
                place / float(case.plan.shaft[RADIUS, k]) if np.isfinite(place) else 0.0
            )
    for number, span in enumerate(case.mesh.spans):
        found[f"{span}_v_peak"] = float(outcome.state.extremes[6 + 2 * number])
        found[f"{span}_w_peak"] = float(outcome.state.extremes[7 + 2 * number])
    return found


def _provenance(case: Case) -> dict[str, Any]:
    scheme = case.scheme
    return {
        "cabledrive": case.fingerprint["cabledrive"],
        "drive": case.drive.name,
        "drive_hash": case.fingerprint["drive_hash"],
        "method": {
            "name": scheme.method,
            "model": case.law_name,
            "compiled": case.interpreted is None,
            "interpreted": case.interpreted,
            "segments": case.mesh.segments,
            "step": case.grid.step,
            "largest_step": case.grid.largest_step,
            "cfl": case.grid.cfl,
            "friction": scheme.friction,
            "smoothing_speed": scheme.smoothing_speed if scheme.friction == "smoothed" else None,
            "slack": scheme.slack,
        },
        "duration": case.grid.steps * case.grid.step,
        "torque": case.torque.fingerprint,
        "torque_offset": case.offset,
    }
