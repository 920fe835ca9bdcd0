"""What comes out of a run of a loop or a line."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from cabledrive.answers.keys import Keys
from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.fields import described, meaning
from cabledrive.simulation.channels import CHANNELS, COLUMN, Channel, probe_columns
from cabledrive.simulation.netcdf import Content, Variable
from cabledrive.simulation.result import AUDIT, NO_RECORD, RunResult
from cabledrive.simulation.start import PLANES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cabledrive.simulation.error_estimate import ErrorEstimate


LOOP = Keys(
    "object: load_angle{number: peak_to_peak} drive_angle{number: peak_to_peak} "
    "upper_midpoint{number: peak}? lower_midpoint{number: peak}? error_estimate number: least_tension "
    "flag: compiled note: interpreted",
    {"error_estimate": "not asked for by --error-estimate", "least_tension": NO_RECORD},
    {"error_estimate": "any"},
    (AUDIT,),
)


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SimulationResult(RunResult):
    r"""A run of a loop or a line, with its audit.

    The columns of `rows` are `cabledrive.simulation.channels.CHANNELS`, then u, v, w of each probe.
    """

    keys: ClassVar[Keys] = LOOP
    channels: tuple[Channel, ...] = CHANNELS
    probes: tuple[tuple[str, float], ...] = meaning(
        "span and distance from its start [m] of each probe; the first ones are the midpoints of the spans"
    )
    position: Array = meaning("(spans, n + 1): distance of the nodes of each span from its start [m]")
    extremes: dict[str, float] = meaning(
        "over all steps, recorded or not: least and largest angle of each shaft [rad], largest "
        "absolute v and w of each midpoint [m]"
    )
    error_estimate: "ErrorEstimate | None" = meaning("discretisation error, if it was asked for", None)

    def probe(self, number: int) -> Array:
        """Displacements of a probe.

        Parameters
        ----------
        number : int
            Which one, from 0; the midpoints of the spans come first.

        Returns
        -------
        ndarray, shape (records, 3)
            u, v, w [m].
        """
        return self.rows[:, probe_columns(number)]

    def midpoint(self, span: str = "upper") -> Array:
        """Displacements of the midpoint of a span.

        Parameters
        ----------
        span : {"upper", "lower"}, default "upper"

        Returns
        -------
        ndarray, shape (records, 3)
            u, v, w [m].
        """
        return self.probe(self.spans.index(span))

    @property
    def load_angle(self) -> Array:
        """Angle of the load pulley at each record [rad]."""
        return self.channel("load_angle")

    @property
    def drive_angle(self) -> Array:
        """Angle of the drive pulley at each record [rad]."""
        return self.channel("drive_angle")

    @property
    def content(self) -> Content:
        """Everything, as a dataset or a file takes it."""
        (time, *_), channels, _, known = super().content
        missing = tuple({"upper", "lower"} - set(self.spans))
        places = np.array([place for _, place in self.probes])
        of_span = "from its span's start"
        numbers = [
            time,
            Variable("position", ("span", "node"), self.position, "m", f"distance of a node {of_span}"),
            Variable("probe_position", ("probe",), places, "m", f"distance of a probe {of_span}"),
        ]
        probes = np.stack([self.probe(number) for number in range(len(self.probes))], axis=1)
        budget = "error of the energy budget, 0 at the start"
        found = [
            *(one for one in channels if not (missing and one.name.endswith(missing))),
            Variable("budget_error", ("time",), self.budget_error, "J", budget),
            Variable("displacement", ("time", "probe", "plane"), probes, "m", "displacement of the probes"),
        ]
        if len(self.field_time):
            kept = self.fields.reshape(*self.fields.shape[:2], *self.position.shape)
            fields = kept.transpose(0, 2, 3, 1)
            names = ("field_time", "span", "node", "plane")
            numbers.append(Variable(names[0], names[:1], self.field_time, "s", "time of a whole field"))
            found.append(Variable("field", names, fields, "m", "displacement of all nodes"))
        words = {
            "span": ("span", list(self.spans)),
            "plane": ("plane", list(PLANES)),
            "probe_span": ("probe", [span for span, _ in self.probes]),
        }
        if self.error_estimate is None:
            del known["error_estimate"]
        return Content(numbers, found, words, known)

    def plot(self) -> "Figure":
        """Draw load angle and midpoints over time.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from matplotlib import pyplot

        figure, (above, below) = pyplot.subplots(2, 1, sharex=True, layout="constrained")
        above.plot(self.time, np.degrees(self.load_angle))
        above.set_ylabel("load angle [deg]")
        above.set_title(self.provenance["drive"])
        for span in self.spans:
            below.plot(self.time, 1e3 * self.midpoint(span)[:, 2], label=f"{span} span")
        below.set_xlabel("time [s]")
        below.set_ylabel("w at midspan [mm]")
        below.legend()
        return figure

    def summary(self) -> dict[str, Any]:
        """As of `RunResult`.

        Returns
        -------
        dict
        """
        extremes = self.extremes
        tensions = [COLUMN[f"least_tension_{span}"] for span in self.spans]
        return {
            **super().summary(),
            "load_angle": {"peak_to_peak": extremes["load_angle_max"] - extremes["load_angle_min"]},
            "drive_angle": {"peak_to_peak": extremes["drive_angle_max"] - extremes["drive_angle_min"]},
            **{f"{span}_midpoint": {"peak": extremes[f"{span}_w_peak"]} for span in self.spans},
            "least_tension": float(np.min(self.rows[:, tensions])) if len(self.rows) else None,
            "compiled": self.interpreted is None,
            "interpreted": self.interpreted,
            "error_estimate": asdict(self.error_estimate) if self.error_estimate else None,
        }
