"""What comes out of a run, and what it says about its own error."""

from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import LAWS, taut_law
from cabledrive.mechanics.mesh import Mesh, strain_energy, weight_energy
from cabledrive.mechanics.sag import parabola_sag
from cabledrive.mechanics.statics import equilibrium, rotor_stiffness
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.errors import InputRefused, NotComputed
from cabledrive.parameters.terminal import ResultCard
from cabledrive.simulation.case import Case
from cabledrive.simulation.channels import AXIAL, COLUMN, WEIGHT_ENERGY, probe_columns
from cabledrive.simulation.plan import EVENTS, MOST_EVENTS, State

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from cabledrive.simulation.error_estimate import ErrorEstimate


@dataclass(frozen=True, slots=True, kw_only=True)
class SlackEvent:
    """A span that went slack.

    Attributes
    ----------
    time : float
        When [s].
    span : {"upper", "lower"}
    position : float
        Where first, as the distance from the span's start along the pretensioned cable [m].
    tension : float
        What the taut law gives there at that step [N], just below zero.
    """

    time: float
    span: str
    position: float
    tension: float


def slack_events(case: Case, state: State) -> tuple[SlackEvent, ...]:
    """Where and when spans went slack up to the end of a run, in order, the first thousand times."""
    noted = state.events[: min(int(state.counts[EVENTS]), MOST_EVENTS)]
    return tuple(
        SlackEvent(
            time=float(step * case.grid.step),
            span=case.mesh.spans[int(span)],
            position=float(case.mesh.position[int(span), int(segment) : int(segment) + 2].mean()),
            tension=float(tension),
        )
        for step, span, segment, tension in noted
    )


def budget_error(rows: Array) -> Array:
    """Error of the energy budget at each record: energy plus losses less work, less its start [J]."""
    balance = rows[:, COLUMN["balance"]]
    error: Array = balance - balance[:1]
    return error


def energy_handled(rows: Array, energy_at_rest: float) -> float:
    """Largest energy [J] of a run: what it started with above `rest_energy`, and the work done on it."""
    if not len(rows):
        return 0.0
    start = float(np.sum(rows[0, AXIAL : WEIGHT_ENERGY + 1])) - energy_at_rest
    work = rows[:, COLUMN["torque_work"]] + rows[:, COLUMN["force_work"]]
    return max(start, 0.0) + float(np.max(work, initial=0.0))


def rest_energy(drive: Drive, mesh: Mesh, law: CableLaw) -> float:
    r"""Energy of the drive at rest under gravity, relative to the straight pretensioned cable.

    Without carriages, that of the parabola: with :math:`q = \int \tfrac12 w'^2 dx = L_e (P/H)^2/24`,
    :math:`E = T_0 q + \tfrac{K}{2 L_e} q^2 - 2 H q` for each span.

    Returns energy [J], zero or negative.
    """
    if not drive.layout.gravity:
        return 0.0
    spring = rotor_stiffness(mesh)
    if not drive.carriage and not spring and type(taut_law(law)) in LAWS.values():
        return len(mesh.spans) * _parabola_energy(drive, mesh, law)
    try:
        rest = equilibrium(mesh, law).displacement
    except (
        InputRefused,
        NotComputed,
    ):  # gravity turns the pulleys: there is no rest, so count from held ones
        rest = equilibrium(mesh, law, hold="both").displacement
    held = 0.5 * spring * float(rest[0, 0]) ** 2
    return float(np.sum(strain_energy(mesh, law, rest))) + weight_energy(mesh, rest) + held


def _parabola_energy(drive: Drive, mesh: Mesh, law: CableLaw) -> float:
    tension = parabola_sag(drive).horizontal_tension
    length = drive.pulley_distance
    stretch = length * (float(np.abs(mesh.weight_w).max()) / mesh.spacing[0] * length / tension) ** 2 / 24.0
    stored = law.pretension * stretch + 0.5 * law.stiffness / length * stretch**2
    return stored - 2.0 * tension * stretch


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SimulationResult(ResultCard):
    r"""A run with its audit.

    Attributes
    ----------
    time : ndarray, shape (records,)
        Times of the records [s].
    rows : ndarray, shape (records, columns)
        The records, one column per `cabledrive.simulation.channels.CHANNELS`, then u, v, w of each probe.
    probes : tuple of (str, float)
        Span and distance from its start [m] of each probe; the first ones are the midpoints of the spans.
    field_time : ndarray, shape (field records,)
        Times of the whole fields [s].
    fields : ndarray, shape (field records, 3, nodes)
        Displacements u, v, w of all nodes, round the loop from the drive rim [m].
    spans : tuple of str
        Names of the spans.
    position : ndarray, shape (spans, n + 1)
        Distance of the nodes of each span from its start [m].
    steps : int
        Steps taken.
    step : float
        Time step [s].
    cfl : float
        Step over the largest stable one [-].
    energy_handled : float
        Largest energy the run had to do with [J]: initial energy above rest, plus work done on the drive.
    slack_events : tuple of SlackEvent
        Where and when spans went slack.
    extremes : dict
        Over all steps, recorded or not: least and largest angle of each shaft [rad], largest \|v\| and \|w\|
        of each midpoint [m].
    provenance : dict
        Version, drive, method and settings, as plain data.
    stopped : str or None
        Why the run ended early, in one line; None if it did not.
    wall_time : float
        How long it took [s].
    error_estimate : ErrorEstimate or None
        Discretisation error, if it was asked for.
    path : Path or None
        File of the result, if it was written to one.
    """

    time: Array
    rows: Array
    probes: tuple[tuple[str, float], ...]
    field_time: Array
    fields: Array
    spans: tuple[str, ...]
    position: Array
    steps: int
    step: float
    cfl: float
    energy_handled: float
    slack_events: tuple[SlackEvent, ...]
    extremes: dict[str, float]
    provenance: dict[str, Any]
    stopped: str | None
    wall_time: float
    error_estimate: "ErrorEstimate | None" = None
    path: Path | None = None

    def channel(self, name: str) -> Array:
        """One column of the records.

        Parameters
        ----------
        name : str
            Its name in `cabledrive.simulation.channels.CHANNELS`.

        Returns
        -------
        ndarray, shape (records,)
        """
        return self.rows[:, COLUMN[name]]

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

    @cached_property
    def budget_error(self) -> Array:
        """Error of the energy budget at each record [J], zero at the start."""
        balance = self.channel("balance")
        return balance - balance[:1]

    @property
    def energy_budget_error(self) -> float:
        """Largest error of the energy budget over the largest energy handled [-]; 0 if nothing moved."""
        largest = float(np.max(np.abs(self.budget_error), initial=0.0))
        return largest / self.energy_handled if self.energy_handled > 0.0 else 0.0

    @cached_property
    def dataset(self) -> "xarray.Dataset":
        """Everything as one labelled dataset with units; read from the file as needed if there is one."""
        from cabledrive.simulation.netcdf import content_of, dataset_of

        return dataset_of(content_of(self))

    def to_xarray(self) -> "xarray.Dataset":
        """Everything as one labelled dataset.

        Returns
        -------
        xarray.Dataset
            `load_angle(time)` and all other channels, `displacement(time, probe, plane)`, whole fields where
            they were kept; every array with `units` and `long_name`.
        """
        return self.dataset

    def plot(self) -> "Figure":
        """Draw load angle and midpoints over time.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return result_figure(self)

    @property
    def interpreted(self) -> str | None:
        """Why the steps were not compiled, in one line; None if they were."""
        reason: str | None = self.provenance["method"].get("interpreted")
        return reason

    def _card(self) -> list[tuple[str, str]]:
        method, found = self.provenance["method"], self.summary()
        budget = found["energy_budget_error"]
        rows = [
            ("cable law", f"{method['model']}, {method['name']}"),
            ("steps", f"{self.steps} of {self.step:.4g} s, {100.0 * self.cfl:.0f} % of the stable one"),
            ("load angle, peak to peak", f"{found['load_angle']['peak_to_peak']:.6g} rad"),
            *(
                (f"{span} midpoint, peak |w|", f"{found[f'{span}_midpoint']['peak']:.6g} m")
                for span in self.spans
            ),
            ("energy budget error", "no record" if budget is None else f"{budget:.2e}"),
            ("slack events", str(len(self.slack_events))),
        ]
        flags = {"stopped": self.stopped, "interpreted": self.interpreted}
        rows += [(name, words) for name, words in flags.items() if words]
        title = f"{self.provenance['drive']}, {self.steps * self.step:.6g} s, {len(self.rows)} records"
        return [("SimulationResult", title), *rows]

    def summary(self) -> dict[str, Any]:
        """What the command answers with: plain data, SI.

        Returns
        -------
        dict
            No NaN and no infinity in it; what needs a record is None where a run stopped before the first.
        """
        extremes = self.extremes
        return {
            "energy_budget_error": self.energy_budget_error if len(self.rows) else None,
            "steps": self.steps,
            "step": self.step,
            "cfl": self.cfl,
            "slack_events": [asdict(event) for event in self.slack_events],
            "load_angle": {"peak_to_peak": extremes["load_angle_max"] - extremes["load_angle_min"]},
            "drive_angle": {"peak_to_peak": extremes["drive_angle_max"] - extremes["drive_angle_min"]},
            **{f"{span}_midpoint": {"peak": extremes[f"{span}_w_peak"]} for span in self.spans},
            "least_tension": self._least_tension(),
            "stopped": self.stopped,
            "compiled": self.interpreted is None,
            "interpreted": self.interpreted,
            "error_estimate": asdict(self.error_estimate) if self.error_estimate else None,
            "wall_time": self.wall_time,
        }

    def _least_tension(self) -> float | None:
        columns = [COLUMN[f"least_tension_{span}"] for span in self.spans]
        return float(np.min(self.rows[:, columns])) if len(self.rows) else None


def result_figure(result: SimulationResult) -> "Figure":
    """Load angle, and w of the midpoint of each span, over time."""
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(2, 1, sharex=True, layout="constrained")
    above.plot(result.time, np.degrees(result.load_angle))
    above.set_ylabel("load angle [deg]")
    above.set_title(result.provenance["drive"])
    for span in result.spans:
        below.plot(result.time, 1e3 * result.midpoint(span)[:, 2], label=f"{span} span")
    below.set_xlabel("time [s]")
    below.set_ylabel("w at midspan [mm]")
    below.legend()
    return figure
