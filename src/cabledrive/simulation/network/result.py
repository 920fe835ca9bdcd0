"""What comes out of a run of a network of spans, from its records and its last state."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.route import RoutedDrive
from cabledrive.simulation.netcdf import Content
from cabledrive.simulation.network.case import NetworkCase
from cabledrive.simulation.result import RunResult
from cabledrive.simulation.run import Outcome

LARGE_MOTION = 0.02
"""Motion of a span's end, relative to its length, above which fixed directions are doubtful."""


@described
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class NetworkResult(RunResult):
    """A run of a machine with routes, with its audit."""

    extremes: dict[str, tuple[float, float]] = meaning(
        "least and largest place of each coordinate over all steps"
    )
    midpoint_peaks: dict[str, float] = meaning(
        "largest displacement across at the middle of each span over all steps [m]"
    )
    largest_motion: float = meaning(
        "largest motion of a span's end relative to its length; directions and lengths stay those at rest"
    )
    assumptions: tuple[str, ...] = meaning("what was left out")
    wraps: tuple[dict[str, Any], ...] = meaning(
        "where bodies travel: largest friction coefficient that each pulley needed, beside the file's", ()
    )
    doubts: tuple[str, ...] = meaning("what the run assumed and did not keep to", ())

    @property
    def travels(self) -> bool:
        """Whether lengths and directions of spans followed the bodies."""
        return bool(self.provenance["method"].get("travels", False))

    @property
    def content(self) -> Content:
        """Everything, as a dataset or a file takes it."""
        found = super().content
        return found._replace(attributes=found.attributes | {"assumptions": "; ".join(self.assumptions)})

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
                    "least_tension": self._least_tension(name),
                }
                for name in self.spans
            ],
            "wraps": list(self.wraps),
            "largest_motion": self.largest_motion,
            "assumptions": list(self.assumptions),
            "warnings": list(self.warnings),
        }

    def _least_tension(self, span: str) -> float | None:
        return float(np.min(self.channel(f"least tension, {span}"))) if len(self.rows) else None


_ASSUMPTIONS = (
    "motion about the state of rest: lengths, wraps and directions of spans stay those at rest",
    "each span has its mean tension at rest and is straight: its own weight and sag are left out",
    "torque: beyond what holds the machine at rest",
)


def network_result(case: NetworkCase, outcome: Outcome) -> NetworkResult:
    """Result of a run, as far as it went."""
    mesh, names, state, rows = case.mesh, case.mesh.names, outcome.state, outcome.rows
    columns = {channel.name: k for k, channel in enumerate(case.channels)}
    energies = rows[:1, columns["rope_energy"] : columns["rope_energy"] + 4].sum() if len(rows) else 0.0
    work = float(np.max(rows[:, columns["torque_work"]], initial=0.0))
    extremes = np.where(np.isfinite(state.extremes), state.extremes, 0.0)
    reach = np.abs(extremes).max(axis=0)
    # Turning a pulley passes rope on and leaves the geometry as it is: only bodies count.
    bodies = [n for n, name in enumerate(names) if "." in name and not name.startswith("slip at ")]
    along = np.einsum("kaxn,n->kax", np.abs(mesh.ends[:, :, [0, 2]][..., bodies]), reach[bodies])
    return NetworkResult(
        **outcome.common(case),
        spans=mesh.pieces,
        energy_handled=max(float(energies), 0.0) + work,
        energy_at_rest=float(np.sum(0.5 * mesh.ropes * mesh.tension**2 / mesh.rigidity * mesh.length)),
        extremes={name: (float(low), float(high)) for name, low, high in zip(names, *extremes, strict=True)},
        midpoint_peaks=dict(zip(mesh.pieces, state.peaks[:, 1].tolist(), strict=True)),
        slack_events=case.slack_events(state),
        largest_motion=float((along.max(axis=(1, 2)) / mesh.length).max(initial=0.0)),
        assumptions=_ASSUMPTIONS + left_out(case.mesh.network.drive),
        doubts=tuple(unheld_words(case.mesh.network.motion, case.mesh.network.statics)),
        provenance=case.provenance(
            {"motor": case.mesh.network.motion.motor}, torque=[signal.fingerprint for signal in case.torques]
        ),
    )


def left_out(drive: RoutedDrive) -> tuple[str, ...]:
    """What the drive states and the run does not have."""
    names = [motor.pulley or "the first pulley" for motor in drive.motor if motor.offset_torque != 0.0]
    return (f"motor.offset_torque of {', '.join(names)} is left out",) if names else ()
