"""What comes out of a run of a network of spans."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cabledrive.mechanics.cable_law import Array
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.result_card import ResultCard
from cabledrive.simulation.channels import Channel

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
        from cabledrive.simulation.dataset import dataset_of
        from cabledrive.simulation.network.result_of_run import network_content

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
