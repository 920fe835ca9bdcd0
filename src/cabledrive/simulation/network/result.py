"""What comes out of a run of a network of spans, from its records and its last state."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.mechanics.cable_laws import taut_law
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.schema import content_hash
from cabledrive.parameters.terminal import ResultCard
from cabledrive.parameters.version import __version__
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.netcdf import Content, Variable, storable
from cabledrive.simulation.network.case import NetworkCase
from cabledrive.simulation.network.plan import EVENTS, MOST_EVENTS, STEPS, TALLIES
from cabledrive.simulation.records import Records
from cabledrive.simulation.run import Outcome, loaded

if TYPE_CHECKING:
    import xarray


LARGE_MOTION = 0.02
"""Motion of a span's end, relative to its length, above which fixed directions are doubtful."""
NOTHING = 1e-13
"""Energy handled, relative to that at rest, below which nothing moved but by round-off."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class NetworkResult(ResultCard):
    """A run of a machine with routes, with its audit.

    Attributes
    ----------
    time : ndarray, shape (records,)
        [s].
    rows : ndarray, shape (records, columns)
    channels : tuple of Channel
        Name, unit and meaning of each column.
    spans : tuple of str
        Names of the pieces of rope, cut at carriages.
    steps : int
    step, largest_step : float
        Time step and the largest stable one [s].
    energy_handled : float
        Largest energy the run had to do with [J].
    energy_at_rest : float
        What the ropes store at rest [J], whose round-off is no motion.
    extremes : dict
        Least and largest place of each coordinate over all steps.
    midpoint_peaks : dict
        Largest displacement across at the middle of each span over all steps [m].
    slack_events : tuple of dict
        Time [s], span and tension [N] where a span went slack.
    largest_motion : float
        Largest motion of a span's end relative to its length; directions and lengths stay those at rest.
    assumptions : tuple of str
        What was left out.
    provenance : dict
    stopped : str or None
        Why the run ended early.
    wall_time : float
        [s].
    wraps : tuple of dict
        Where bodies travel: largest friction coefficient that each pulley needed, beside the file's.
    doubts : tuple of str
        What the run assumed and did not keep to.
    path : Path or None
    """

    time: Array
    rows: Array
    channels: tuple[Channel, ...]
    spans: tuple[str, ...]
    steps: int
    step: float
    largest_step: float
    energy_handled: float
    energy_at_rest: float
    extremes: dict[str, tuple[float, float]]
    midpoint_peaks: dict[str, float]
    slack_events: tuple[dict[str, Any], ...]
    largest_motion: float
    assumptions: tuple[str, ...]
    provenance: dict[str, Any]
    stopped: str | None
    wall_time: float
    wraps: tuple[dict[str, Any], ...] = ()
    doubts: tuple[str, ...] = ()
    path: Path | None = None

    def channel(self, name: str) -> Array:
        """One column of the records.

        Parameters
        ----------
        name : str
            A coordinate ("head.x"), "speed of head.x", "torque on motor", "mean tension, SPAN",
            "w at the middle of SPAN", "balance", ...

        Returns
        -------
        ndarray, shape (records,)

        Raises
        ------
        InputRefused
            If there is no such column.
        """
        names = [channel.name for channel in self.channels]
        if name not in names:
            raise InputRefused(f'channel "{name[:60]}" is none of {len(names)}: see .channels')
        return np.asarray(self.rows[:, names.index(name)])

    @property
    def travels(self) -> bool:
        """Whether lengths and directions of spans followed the bodies."""
        return bool(self.provenance["method"].get("travels", False))

    @property
    def energy_budget_error(self) -> float:
        """Largest error of the energy budget over the largest energy handled; 0 if nothing moved."""
        balance = self.channel("balance")
        worst = float(np.max(np.abs(balance - balance[:1]), initial=0.0))
        return worst / self.energy_handled if self.energy_handled > NOTHING * self.energy_at_rest else 0.0

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """Everything as one labelled dataset with units."""
        from cabledrive.simulation.netcdf import dataset_of

        return dataset_of(network_content(self))

    def to_xarray(self) -> "xarray.Dataset":
        """Everything as one labelled dataset.

        Returns
        -------
        xarray.Dataset
            Each channel over `time`, with `units` and `long_name`.
        """
        return self.dataset

    @property
    def warnings(self) -> tuple[str, ...]:
        """What makes the result doubtful."""
        found = list(self.doubts)
        if self.largest_motion > LARGE_MOTION:
            found.append(
                f"ends of a span move by {100 * self.largest_motion:.3g} % of its length: lengths and "
                f"directions stay those at rest, which holds up to about {100 * LARGE_MOTION:.3g} %"
            )
        return tuple(found)

    def _card(self) -> list[tuple[str, str]]:
        rows = [
            (
                "steps",
                f"{self.steps} of {self.step:.4g} s, {100 * self.step / self.largest_step:.0f} % of stable",
            ),
            ("energy budget error", f"{self.energy_budget_error:.2e}"),
            ("slack events", str(len(self.slack_events))),
        ]
        rows += [("stopped", self.stopped)] if self.stopped else []
        return [("NetworkResult", f"{self.provenance['drive']}, {self.steps * self.step:.6g} s"), *rows]

    def summary(self) -> dict[str, Any]:
        """What the command answers with: plain data, SI.

        Returns
        -------
        dict
            No NaN and no infinity in it; what needs a record is None where a run stopped before the first.
        """
        return {
            "energy_budget_error": self.energy_budget_error if len(self.rows) else None,
            "steps": self.steps,
            "step": self.step,
            "cfl": self.step / self.largest_step,
            "slack_events": list(self.slack_events),
            "coordinates": {
                name: {"least": low, "largest": high, "peak_to_peak": high - low}
                for name, (low, high) in self.extremes.items()
            },
            "spans": [
                {
                    "name": name,
                    "midpoint_peak": self.midpoint_peaks.get(name),
                    "least_tension": self._least_tension(name),
                }
                for name in self.spans
            ],
            "wraps": list(self.wraps),
            "largest_motion": self.largest_motion,
            "assumptions": list(self.assumptions),
            "warnings": list(self.warnings),
            "stopped": self.stopped,
            "wall_time": self.wall_time,
        }

    def _least_tension(self, span: str) -> float | None:
        return float(np.min(self.channel(f"least tension, {span}"))) if len(self.rows) else None


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
