"""What comes out of a run of a loop or a line."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.mesh import Mesh, strain_energy, weight_energy
from cabledrive.mechanics.statics import equilibrium, rotor_stiffness
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.fields import described, meaning
from cabledrive.simulation.case import Case
from cabledrive.simulation.channels import (
    AXIAL,
    CHANNELS,
    COLUMN,
    WEIGHT_ENERGY,
    Channel,
    probe_columns,
)
from cabledrive.simulation.netcdf import Content, Variable
from cabledrive.simulation.result import RunResult
from cabledrive.simulation.run import Outcome
from cabledrive.simulation.start import PLANES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cabledrive.simulation.error_estimate import ErrorEstimate


def energy_handled(rows: Array, energy_at_rest: float) -> float:
    """Largest energy [J] of a run: what it started with above `rest_energy`, and the work done on it."""
    if not len(rows):
        return 0.0
    start = float(np.sum(rows[0, AXIAL : WEIGHT_ENERGY + 1])) - energy_at_rest
    work = rows[:, COLUMN["torque_work"]] + rows[:, COLUMN["force_work"]]
    return max(start, 0.0) + float(np.max(work, initial=0.0))


def rest_energy(drive: Drive, mesh: Mesh, law: CableLaw) -> float:
    """Energy [J] of the drive at rest under gravity, relative to the straight pretensioned cable."""
    if not drive.layout.gravity:
        return 0.0
    try:
        rest = equilibrium(mesh, law).displacement
    except (
        InputRefused,
        NotComputed,
    ):  # gravity turns the pulleys: there is no rest, so count from held ones
        rest = equilibrium(mesh, law, hold="both").displacement
    held = 0.5 * rotor_stiffness(mesh) * float(rest[0, 0]) ** 2
    return float(np.sum(strain_energy(mesh, law, rest))) + weight_energy(mesh, rest) + held


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SimulationResult(RunResult):
    r"""A run of a loop or a line, with its audit.

    The columns of `rows` are `cabledrive.simulation.channels.CHANNELS`, then u, v, w of each probe.
    """

    channels: tuple[Channel, ...] = CHANNELS
    probes: tuple[tuple[str, float], ...] = meaning(
        "span and distance from its start [m] of each probe; the first ones are the midpoints of the spans"
    )
    field_time: Array = meaning("(field records,): times of the whole fields [s]")
    fields: Array = meaning(
        "(field records, 3, nodes): displacements u, v, w of all nodes, round the loop from the drive rim [m]"
    )
    position: Array = meaning("(spans, n + 1): distance of the nodes of each span from its start [m]")
    extremes: dict[str, float] = meaning(
        "over all steps, recorded or not: least and largest angle of each shaft [rad], largest |v| "
        "and |w| of each midpoint [m]"
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
            n = self.position.shape[1] - 1  # span by span, the rims in both
            spans = [self.fields[:, :, k * n : (k + 1) * n + 1] for k in range(len(self.spans))]
            fields = np.stack(spans, axis=1).transpose(0, 1, 3, 2)
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

    def _own_rows(self) -> list[tuple[str, str]]:
        method, found = self.provenance["method"], self.summary()
        return [
            ("cable law", f"{method['model']}, {method['name']}"),
            ("load angle, peak to peak", f"{found['load_angle']['peak_to_peak']:.6g} rad"),
            *(
                (f"{span} midpoint, peak |w|", f"{found[f'{span}_midpoint']['peak']:.6g} m")
                for span in self.spans
            ),
        ]

    def summary(self) -> dict[str, Any]:
        """As of `RunResult`.

        Returns
        -------
        dict
        """
        extremes = self.extremes
        return {
            **super().summary(),
            "load_angle": {"peak_to_peak": extremes["load_angle_max"] - extremes["load_angle_min"]},
            "drive_angle": {"peak_to_peak": extremes["drive_angle_max"] - extremes["drive_angle_min"]},
            **{f"{span}_midpoint": {"peak": extremes[f"{span}_w_peak"]} for span in self.spans},
            "least_tension": self._least_tension(),
            "compiled": self.interpreted is None,
            "interpreted": self.interpreted,
            "error_estimate": asdict(self.error_estimate) if self.error_estimate else None,
        }

    def _least_tension(self) -> float | None:
        columns = [COLUMN[f"least_tension_{span}"] for span in self.spans]
        return float(np.min(self.rows[:, columns])) if len(self.rows) else None


def result_of(case: Case, outcome: Outcome) -> SimulationResult:
    """Result of a run, as far as it went."""
    rows, every, scheme = outcome.rows, case.recording.fields or 1, case.scheme
    fields = outcome.fields[: -(-len(rows) // every)]
    return SimulationResult(
        **outcome.common(case),
        probes=(
            *((span, 0.5 * float(case.mesh.position[0, -1])) for span in case.mesh.spans),
            *case.recording.probes,
        ),
        field_time=outcome.common(case)["time"][::every][: len(fields)],
        fields=fields,
        spans=case.mesh.spans,
        position=case.mesh.position,
        energy_handled=energy_handled(rows, rest_energy(case.machine, case.mesh, case.law)),
        slack_events=case.slack_events(outcome.state),
        extremes=_extremes(case, outcome),
        provenance=case.provenance(
            {
                "cfl": case.grid.cfl,
                "smoothing_speed": scheme.smoothing_speed if scheme.friction == "smoothed" else None,
                "segments": case.mesh.segments,
            },
            duration=case.grid.steps * case.grid.step,
            torque=case.torques[0].fingerprint,
            torque_offset=float(case.holding[0]),
        ),
    )


def _extremes(case: Case, outcome: Outcome) -> dict[str, float]:
    found, mesh, state = {}, case.mesh, outcome.state
    for k, name in enumerate(("drive", "load", "motor")):
        radius = mesh.shafts[k].radius if k < len(mesh.shafts) else mesh.shafts[0].radius
        for word, place in zip(("min", "max"), state.extremes[:, k].tolist(), strict=True):
            found[f"{name}_angle_{word}"] = place / radius if np.isfinite(place) else 0.0
    for span, (v, w) in zip(mesh.spans, state.peaks.tolist(), strict=True):
        found[f"{span}_v_peak"], found[f"{span}_w_peak"] = v, w
    return found
