"""What comes out of a run of any machine, and what it says about its own error."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from cabledrive.answers.figures import Row
from cabledrive.answers.keys import Keys
from cabledrive.answers.result import Result
from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.cable import Rope
from cabledrive.parameters.drive_parts import Motor
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import described, meaning
from cabledrive.simulation.channels import Channel
from cabledrive.simulation.netcdf import Content, Variable, dataset_of, storable
from cabledrive.simulation.start import PLANES

if TYPE_CHECKING:
    import xarray

NOTHING = 1e-13
"""Energy handled, relative to that at rest, below which nothing moved but by round-off."""


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class SlackEvent:
    """A span that went slack."""

    time: float = meaning("when [s]")
    span: str = meaning('one of "upper", "lower"; of a machine with routes the name of the span')
    position: float = meaning(
        "where first, as the distance from the span's start along the pretensioned cable [m]"
    )
    tension: float = meaning("what the taut law gives there at that step [N], just below zero")


NO_RECORD = "the run stopped before its first record"
AUDIT = Keys(
    "number: energy_budget_error step cfl wall_time count: steps note: stopped texts: assumptions "
    "rows: slack_events{number: time position tension text: span}",
    {"energy_budget_error": NO_RECORD},
)


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class RunResult(Result):
    """A run of any machine, with its audit."""

    keys: ClassVar[Keys] = AUDIT
    _heading = "{0.provenance[drive]}"
    _shown = (
        Row("steps", "steps", form="d"),
        Row("step", "time step", "s"),
        Row("cfl", "of the stable one", "%", ".0f", 100.0),
        Row("load_angle.peak_to_peak", "load angle, peak to peak", "rad", ".6g"),
        Row("upper_midpoint.peak", "upper midpoint, peak |w|", "m", ".6g"),
        Row("lower_midpoint.peak", "lower midpoint, peak |w|", "m", ".6g"),
        Row("energy_budget_error", "energy budget error", form=".2e"),
        Row("error_estimate.load_angle.relative", "estimated error, load angle", "%", ".2g", 100.0),
        Row("error_estimate.upper_midpoint.relative", "upper midpoint", "%", ".2g", 100.0),
        Row("stopped", "stopped"),
        Row("assumptions", "note"),
        Row("warnings", "warning"),
        Row("interpreted", "interpreted, slower"),
    )
    time: Array = meaning("(records,): times of the records [s]")
    rows: Array = meaning("(records, columns): the records, one column per channel")
    channels: tuple[Channel, ...] = meaning("name, unit and meaning of each column")
    spans: tuple[str, ...] = meaning(
        "names of the spans; of a machine with routes of the pieces of rope, cut at carriages"
    )
    steps: int = meaning("steps taken")
    step: float = meaning("time step [s]")
    largest_step: float = meaning("largest stable time step [s]")
    slack_events: tuple[SlackEvent, ...] = meaning("where and when spans went slack", ())
    energy_handled: float = meaning(
        "largest energy the run had to do with [J]: initial energy above rest, plus work done on the drive"
    )
    energy_at_rest: float = meaning("what the ropes store at rest [J], whose round-off is no motion", 0.0)
    field_time: Array = meaning("(field records,): times of the whole fields [s]")
    fields: Array = meaning(
        "(field records, 3, nodes): displacements u, v, w of all nodes, piece by piece, ends in both; from "
        "rest, of loops and lines from the straight cable [m]"
    )
    assumptions: tuple[str, ...] = meaning("what was left out", ())
    provenance: dict[str, Any] = meaning("version, drive, method and settings, as plain data")
    stopped: str | None = meaning("why the run ended early, in one line; None if it did not")
    wall_time: float = meaning("how long it took [s]")
    path: Path | None = meaning("file of the result, if it was written to one", None)

    def channel(self, name: str) -> Array:
        """One column of the records.

        Parameters
        ----------
        name : str
            Of a loop one of `cabledrive.simulation.channels.CHANNELS`; of a machine with routes a coordinate
            ("head.x"), "speed of head.x", "torque on motor", "mean tension, SPAN", "w at the middle of SPAN",
            "balance", ...

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
    def cfl(self) -> float:
        """Step over the largest stable one [-]."""
        return self.step / self.largest_step

    @cached_property
    def budget_error(self) -> Array:
        """Error of the energy budget at each record [J], zero at the start."""
        balance = self.channel("balance")
        return balance - balance[:1]

    @property
    def energy_budget_error(self) -> float:
        """Largest error of the energy budget over the largest energy handled [-]; 0 if nothing moved."""
        largest = float(np.max(np.abs(self.budget_error), initial=0.0))
        return largest / self.energy_handled if self.energy_handled > NOTHING * self.energy_at_rest else 0.0

    @property
    def interpreted(self) -> str | None:
        """Why the steps were not compiled, in one line; None if they were."""
        reason: str | None = self.provenance["method"].get("interpreted")
        return reason

    @property
    def travels(self) -> bool:
        """Whether lengths and directions of spans followed the bodies."""
        return bool(self.provenance["method"].get("travels", False))

    @property
    def content(self) -> Content:
        """Everything, as a dataset or a file takes it; NetCDF takes a slash for a group."""
        variables = [
            Variable(one.name.replace("/", "_"), ("time",), self.rows[:, k], one.unit, one.meaning)
            for k, one in enumerate(self.channels)
        ]
        known = {**self.provenance, **self.summary(), "assumptions": "; ".join(self.assumptions)}
        del known["wall_time"]  # the same run gives the same file
        return Content(
            [Variable("time", ("time",), self.time, "s", "time of a record")], variables, {}, storable(known)
        )

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """Everything as one labelled dataset with units."""
        return dataset_of(self.content)

    def to_xarray(self) -> "xarray.Dataset":
        """Everything as one labelled dataset.

        Returns
        -------
        xarray.Dataset
            Each channel over `time`, with `units` and `long_name`; of a loop also
            `displacement(time, probe, plane)`, and whole fields where they were kept.
        """
        return self.dataset

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
            "stopped": self.stopped,
            "wall_time": self.wall_time,
            "cfl": self.cfl,
            "slack_events": [asdict(event) for event in self.slack_events],
            "assumptions": list(self.assumptions),
        }

    def to_dataframe(self) -> Any:
        """The records as a table.

        Returns
        -------
        pandas.DataFrame
            Index time [s]; a column for each channel, in its own unit.
        """
        from pandas import DataFrame, Index

        names = [channel.name for channel in self.channels]
        return DataFrame(self.rows[:, : len(names)], Index(self.time, name="time"), names)


NETWORK = Keys(
    "map: coordinates{number: least largest peak_to_peak} rows: spans{text: name number: midpoint_peak "
    "least_tension} wraps{text: pulley number: needed_friction friction} number: largest_motion "
    "error_estimate texts: warnings",
    {
        "error_estimate": "not asked for by --error-estimate",
        "midpoint_peak": "motion across is left out",
        "least_tension": NO_RECORD,
        "friction": "no capstan_friction in the file",
    },
    {"error_estimate": "any"},
    also=(AUDIT,),
)


def neglected(ropes: Iterable[Rope], motors: Iterable[Motor]) -> tuple[str, ...]:
    """What a file states and no run has."""
    stiff = max((rope.bending_stiffness or 0.0 for rope in ropes), default=0.0)
    bends = f"ropes bend freely: their bending stiffness of up to {stiff:.4g} N m^2 is left out"
    found = {bends: stiff, "motor.backlash is left out": any(motor.backlash for motor in motors)}
    return tuple(words for words, stated in found.items() if stated)


LARGE_MOTION = 0.02
"""Motion of a span's end, relative to its length, above which fixed directions are doubtful."""


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class NetworkResult(RunResult):
    """A run of a machine with routes, with its audit."""

    keys: ClassVar[Keys] = NETWORK
    extremes: dict[str, tuple[float, float]] = meaning(
        "least and largest place of each coordinate over all steps"
    )
    positions: tuple[Array, ...] = meaning(
        "distances of the nodes of each piece from its start [m]; none where bodies travel", ()
    )
    midpoint_peaks: dict[str, float] = meaning(
        "largest displacement across at the middle of each span over all steps [m]"
    )
    largest_motion: float = meaning(
        "largest motion of a span's end relative to its length; directions and lengths stay those at rest"
    )
    wraps: tuple[dict[str, Any], ...] = meaning(
        "where bodies travel: largest friction coefficient that each pulley needed, beside the file's", ()
    )
    doubts: tuple[str, ...] = meaning("what the run assumed and did not keep to", ())
    error_estimate: dict[str, Any] | None = meaning(
        "discretisation error by channel, if it was asked for: its size, relative size and order", None
    )

    @property
    def content(self) -> Content:
        """Everything, as a dataset or a file takes it."""
        found = super().content
        if not len(self.field_time):
            return found
        pieces = [name for name, own in zip(self.spans, self.positions, strict=True) for _ in own]
        names, where = ("field_time", "node", "plane"), "distance of a node from its piece's start"
        found.coordinates.append(Variable(names[0], names[:1], self.field_time, "s", "time of a whole field"))
        found.coordinates.append(Variable("position", ("node",), np.concatenate(self.positions), "m", where))
        fields = self.fields.transpose(0, 2, 1)
        found.variables.append(Variable("field", names, fields, "m", "displacement of all nodes"))
        words = {"plane": ("plane", list(PLANES)), "node_piece": ("node", pieces)}
        return found._replace(words=words)

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

    def summary(self) -> dict[str, Any]:
        """As of `RunResult`.

        Returns
        -------
        dict
        """
        some = len(self.rows) > 0
        return {
            **super().summary(),
            "coordinates": {
                name: {"least": low, "largest": high, "peak_to_peak": high - low}
                for name, (low, high) in self.extremes.items()
            },
            "spans": [
                {
                    "name": name,
                    "midpoint_peak": self.midpoint_peaks.get(name),
                    "least_tension": float(np.min(self.channel(f"least tension, {name}"))) if some else None,
                }
                for name in self.spans
            ],
            "wraps": list(self.wraps),
            "largest_motion": self.largest_motion,
            "error_estimate": self.error_estimate,
            "warnings": list(self.warnings),
        }
