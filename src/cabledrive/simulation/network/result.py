"""What comes out of a run of a machine with routes."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from cabledrive.parameters.fields import described, meaning
from cabledrive.simulation.netcdf import Content
from cabledrive.simulation.result import RunResult

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
            "assumptions": list(self.assumptions),
            "warnings": list(self.warnings),
        }
