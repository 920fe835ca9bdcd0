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
    from matplotlib.figure import Figure

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
SIMULATED = Keys(
    "number: energy_budget_error step cfl wall_time count: steps note: stopped texts: assumptions warnings "
    "rows: slack_events{number: time position tension text: span} flag: compiled note: interpreted "
    "object: load_angle{number: peak_to_peak}? drive_angle{number: peak_to_peak}? "
    "upper_midpoint{number: peak}? lower_midpoint{number: peak}? "
    "map: coordinates{number: least largest peak_to_peak} rows: spans{text: name number: midpoint_peak "
    "least_tension} wraps{text: pulley number: needed_friction friction} "
    "number: least_tension largest_motion error_estimate",
    {
        "energy_budget_error": NO_RECORD,
        "error_estimate": "not asked for by --error-estimate",
        "midpoint_peak": "motion across is left out",
        "least_tension": NO_RECORD,
        "friction": "no capstan_friction in the file",
    },
    {"error_estimate": "any"},
)

LARGE_MOTION = 0.02
"""Motion of a span's end, relative to its length, above which fixed directions are doubtful."""


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SimulationResult(Result):
    """A run of any machine, with its audit."""

    keys: ClassVar[Keys] = SIMULATED
    _heading = "{0.provenance[drive]}"
    _shown = (
        Row("steps", "steps", form="d"),
        Row("step", "time step", "s"),
        Row("cfl", "of the stable one", "%", ".0f", 100.0),
        Row("energy_budget_error", "energy budget error", form=".2e"),
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
    extremes: dict[str, tuple[float, float]] = meaning(
        "least and largest place of each coordinate, of a loop or a line of each shaft, over all steps, "
        "recorded or not"
    )
    positions: tuple[Array, ...] = meaning(
        "distances of the nodes of each span from its start [m]; none where bodies travel", ()
    )
    probes: tuple[tuple[str, float], ...] = meaning(
        "span and distance from its start [m] of each recorded point; the middles of the spans come first", ()
    )
    midpoint_peaks: dict[str, float] = meaning(
        "largest displacement across at the middle of each span over all steps [m]", factory=dict
    )
    largest_motion: float = meaning(
        "largest motion of a span's end by bodies, relative to its length; directions and lengths stay those "
        "at rest",
        0.0,
    )
    wraps: tuple[dict[str, Any], ...] = meaning(
        "where bodies travel: largest friction coefficient that each pulley needed, beside the file's", ()
    )
    doubts: tuple[str, ...] = meaning("what the run assumed and did not keep to", ())
    error_estimate: dict[str, Any] | None = meaning(
        "discretisation error by channel, if it was asked for: its size, relative size and order; "
        '"segments": of the runs compared',
        None,
    )
    field_time: Array = meaning("(field records,): times of the whole fields [s]")
    fields: Array = meaning(
        "(field records, 3, nodes): displacements u, v, w of all nodes, piece by piece, ends in both; from "
        "rest, of loops and lines from the straight cable [m]"
    )
    resting: Array = meaning(
        "(3, nodes): displacements at rest, counted as those of `fields` [m]",
        factory=lambda: np.zeros((3, 0)),
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
            A coordinate, as "head.x" and "speed of head.x", of a loop "load_angle" and "load_speed"; "torque
            on motor", "mean tension, SPAN", "w at the middle of SPAN", "balance", ...

        Returns
        -------
        ndarray, shape (records,)

        Raises
        ------
        InputRefused
            If there is no such column.
        """
        if name not in self.names:
            raise InputRefused(f'channel "{name[:60]}" is none of {len(self.names)}: see .channels')
        return np.asarray(self.rows[:, self.names.index(name)])

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

    @cached_property
    def names(self) -> list[str]:
        """Names of the columns."""
        return [channel.name for channel in self.channels]

    @property
    def _points(self) -> range:
        """Columns of the recorded points, three for each."""
        first = self.names.index(f"u at the middle of {self.spans[0]}") if self.probes else 0
        return range(first, first + 3 * len(self.probes))

    def probe(self, number: int) -> Array:
        """Displacements of a recorded point.

        Parameters
        ----------
        number : int
            Which one of `probes`, from 0; the middles of the spans come first.

        Returns
        -------
        ndarray, shape (records, 3)
            u, v, w [m].
        """
        return self.rows[:, self._points[3 * number : 3 * number + 3]]

    def midpoint(self, span: str = "upper") -> Array:
        """Displacements of the middle of a span.

        Parameters
        ----------
        span : str, default "upper"
            One of `spans`.

        Returns
        -------
        ndarray, shape (records, 3)
            u, v, w [m].
        """
        return self.probe(self.spans.index(span))

    @property
    def load_angle(self) -> Array:
        """Angle of the load pulley of a loop or a line at each record [rad]."""
        return self.channel("load_angle")

    @property
    def drive_angle(self) -> Array:
        """Angle of the drive pulley of a loop or a line at each record [rad]."""
        return self.channel("drive_angle")

    def least_tension(self, span: str) -> Array:
        """Least tension along a span at each record.

        Parameters
        ----------
        span : str
            One of `spans`.

        Returns
        -------
        ndarray, shape (records,)
            In N.
        """
        return self.channel(f"least tension, {span}")

    @property
    def content(self) -> Content:
        """Everything, as a dataset or a file takes it; NetCDF takes a slash for a group."""
        found = [
            Variable(one.name.replace("/", "_"), ("time",), self.rows[:, k], one.unit, one.meaning)
            for k, one in enumerate(self.channels)
            if k not in self._points
        ]
        budget = "error of the energy budget, 0 at the start"
        found.append(Variable("budget_error", ("time",), self.budget_error, "J", budget))
        numbers, words = [Variable("time", ("time",), self.time, "s", "time of a record")], dict[str, Any]()
        if self.probes:
            places = np.array([place for _, place in self.probes])
            shown = np.stack([self.probe(number) for number in range(len(self.probes))], axis=1)
            where = "distance of a probe from its span's start"
            numbers.append(Variable("probe_position", ("probe",), places, "m", where))
            names = ("time", "probe", "plane")
            found.append(Variable("displacement", names, shown, "m", "displacement of the probes"))
            words["plane"] = ("plane", list(PLANES))
            words["probe_span"] = ("probe", [span for span, _ in self.probes])
        if len(self.field_time):
            names, where = ("field_time", "node", "plane"), "distance of a node from its span's start"
            numbers.append(Variable(names[0], names[:1], self.field_time, "s", "time of a whole field"))
            numbers.append(Variable("position", ("node",), np.concatenate(self.positions), "m", where))
            fields = self.fields.transpose(0, 2, 1)
            found.append(Variable("field", names, fields, "m", "displacement of all nodes"))
            both = zip(self.spans, self.positions, strict=True)
            words["node_span"] = ("node", [name for name, own in both for _ in own])
        known = {**self.provenance, **self.summary(), "assumptions": "; ".join(self.assumptions)}
        known["extremes"] = known.pop("coordinates")  # which is a name of the format
        del known["wall_time"]  # the same run gives the same file
        if self.error_estimate is None:
            del known["error_estimate"]
        return Content(numbers, found, words, storable(known))

    def to_xarray(self) -> "xarray.Dataset":
        """Everything as one labelled dataset.

        Returns
        -------
        xarray.Dataset
            Each channel over `time`, with `units` and `long_name`; `displacement(time, probe, plane)` of the
            recorded points, and whole fields where they were kept.
        """
        return dataset_of(self.content)

    def summary(self) -> dict[str, Any]:
        """What the command answers with: plain data, SI.

        Returns
        -------
        dict
            No NaN and no infinity in it; what needs a record is None where a run stopped before the first.
        """
        some, peaks = len(self.rows) > 0, self.midpoint_peaks
        least = {span: float(np.min(self.least_tension(span))) for span in self.spans if some}
        angles = [name for name in ("load_angle", "drive_angle") if name in self.extremes]
        return {
            "energy_budget_error": self.energy_budget_error if some else None,
            "steps": self.steps,
            "step": self.step,
            "stopped": self.stopped,
            "wall_time": self.wall_time,
            "cfl": self.cfl,
            "slack_events": [asdict(event) for event in self.slack_events],
            "assumptions": list(self.assumptions),
            **{name: {"peak_to_peak": float(np.ptp(self.extremes[name]))} for name in angles},
            **{f"{span}_midpoint": {"peak": peaks[span]} for span in ("upper", "lower") if span in peaks},
            "coordinates": {
                name: {"least": low, "largest": high, "peak_to_peak": high - low}
                for name, (low, high) in self.extremes.items()
            },
            "spans": [
                {"name": name, "midpoint_peak": peaks.get(name), "least_tension": least.get(name)}
                for name in self.spans
            ],
            "least_tension": min(least.values(), default=None),
            "wraps": list(self.wraps),
            "largest_motion": self.largest_motion,
            "error_estimate": self.error_estimate,
            "warnings": list(self.warnings),
            "compiled": self.interpreted is None,
            "interpreted": self.interpreted,
        }

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

    def to_dataframe(self) -> Any:
        """The records over time [s], a column for each channel, in its own unit."""
        from pandas import DataFrame, Index

        return DataFrame(self.rows, Index(self.time, name="time"), self.names)

    def plot(self) -> "Figure":
        """Draw the coordinate that moves most, and the middles of the spans, or their tensions, over time."""
        from matplotlib import pyplot

        figure, (above, below) = pyplot.subplots(2, 1, sharex=True, layout="constrained")
        most = max(self.extremes, key=lambda name: np.ptp(self.extremes[name]))
        most = "load_angle" if "load_angle" in self.names else most
        unit = self.channels[self.names.index(most)].unit
        above.plot(self.time, self.channel(most) if unit == "m" else np.degrees(self.channel(most)))
        above.set_ylabel(f"{most.replace('_', ' ')} [{'m' if unit == 'm' else 'deg'}]")
        above.set_title(self.provenance["drive"])
        for span in self.spans:
            shown = 1e3 * self.midpoint(span)[:, 2] if self.probes else self.least_tension(span)
            below.plot(self.time, shown, label=span)
        below.set_ylabel("w at midspan [mm]" if self.probes else "least tension [N]")
        below.set_xlabel("time [s]")
        below.legend()
        return figure


def neglected(ropes: Iterable[Rope], motors: Iterable[Motor]) -> tuple[str, ...]:
    """What a file states and no run has."""
    stiff = max((rope.bending_stiffness or 0.0 for rope in ropes), default=0.0)
    bends = f"ropes bend freely: their bending stiffness of up to {stiff:.4g} N m^2 is left out"
    found = {bends: stiff, "motor.backlash is left out": any(motor.backlash for motor in motors)}
    return tuple(words for words, stated in found.items() if stated)
