"""The result of a run of a network, from its records and its last state."""

import numpy as np

from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.network.unheld import unheld_words
from cabledrive.mechanics.tension_only import taut_law
from cabledrive.parameters.hashing import content_hash
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.version import __version__
from cabledrive.simulation.labels import Content, Variable, storable
from cabledrive.simulation.network.case import NetworkCase
from cabledrive.simulation.network.plan import TALLIES
from cabledrive.simulation.network.result import NetworkResult
from cabledrive.simulation.network.state import EVENTS, MOST_EVENTS, STEPS
from cabledrive.simulation.records import Records
from cabledrive.simulation.result_of_run import loaded
from cabledrive.simulation.run import Outcome

_ASSUMPTIONS = (
    "motion about the state of rest: lengths, wraps and directions of spans stay those at rest",
    "each span has its mean tension at rest and is straight: its own weight and sag are left out",
    "torque: beyond what holds the machine at rest",
)


def network_result(case: NetworkCase, records: Records, outcome: Outcome) -> NetworkResult:
    """Result of a run, as far as it went."""
    mesh, names, state, channels = case.mesh, case.mesh.names, outcome.state, case.channels
    rows = loaded(records.arrays()[0][: outcome.records])
    columns = {channel.name: k for k, channel in enumerate(channels)}
    energies = rows[:1, columns["rope_energy"] : columns["rope_energy"] + 4].sum() if len(rows) else 0.0
    work = float(np.max(rows[:, -1 - TALLIES], initial=0.0))
    extremes = np.where(np.isfinite(state.extremes), state.extremes, 0.0)
    reach = np.abs(extremes).max(axis=0)
    # Turning a pulley passes rope on and leaves the geometry as it is: only bodies count.
    bodies = [n for n, name in enumerate(names) if "." in name and not name.startswith("slip at ")]
    along = np.einsum("kaxn,n->kax", np.abs(mesh.ends[:, :, [0, 2]][..., bodies]), reach[bodies])
    noted = state.events[: min(int(state.counts[EVENTS]), MOST_EVENTS)]
    return NetworkResult(
        time=np.arange(len(rows), dtype=np.float64) * case.grid.interval,
        rows=rows,
        channels=channels,
        spans=mesh.pieces,
        steps=int(state.counts[STEPS]),
        step=case.grid.step,
        largest_step=case.grid.largest_step,
        energy_handled=max(float(energies), 0.0) + work,
        energy_at_rest=float(np.sum(0.5 * mesh.ropes * mesh.tension**2 / mesh.rigidity * mesh.length)),
        extremes={name: (float(low), float(high)) for name, low, high in zip(names, *extremes, strict=True)},
        midpoint_peaks=dict(zip(mesh.pieces, state.peaks.tolist(), strict=True)),
        slack_events=tuple(
            {"time": float(step * case.grid.step), "span": mesh.pieces[int(piece)], "tension": float(tension)}
            for step, piece, tension in noted
        ),
        largest_motion=float((along.max(axis=(1, 2)) / mesh.length).max(initial=0.0)),
        assumptions=_ASSUMPTIONS + left_out(case.network.drive),
        doubts=tuple(unheld_words(case.network.motion, case.network.statics)),
        provenance={
            "cabledrive": __version__,
            "drive": case.network.drive.name,
            "drive_hash": content_hash(case.network.drive),
            "method": {
                "name": "verlet",
                "model": taut_law(case.laws[0]).name,
                "compiled": why_plain() is None,
                "interpreted": why_plain(),
                "segments": case.scheme.segments,
                "step": case.grid.step,
                "largest_step": case.grid.largest_step,
                "motor": case.network.motion.motor,
                "friction": case.scheme.friction,
                "slack": case.scheme.slack,
            },
            "torque": [signal.fingerprint for signal in case.torques],
        },
        stopped=outcome.stopped,
        wall_time=outcome.wall_time,
    )


def left_out(drive: RoutedDrive) -> tuple[str, ...]:
    """What the drive states and the run does not have."""
    names = [motor.pulley or "the first pulley" for motor in drive.motor if motor.offset_torque != 0.0]
    return (f"motor.offset_torque of {', '.join(names)} is left out",) if names else ()


def network_content(result: NetworkResult) -> Content:
    """All of a result, as a file takes it; NetCDF takes a slash for a group."""
    variables = [
        Variable(channel.name.replace("/", "_"), ("time",), result.rows[:, k], channel.unit, channel.meaning)
        for k, channel in enumerate(result.channels)
    ]
    known = {**result.provenance, **result.summary()}
    del known["wall_time"]  # the same run gives the same file
    known["assumptions"] = "; ".join(result.assumptions)
    time = Variable("time", ("time",), result.time, "s", "time of a record")
    return Content([time], variables, {}, storable(known))
