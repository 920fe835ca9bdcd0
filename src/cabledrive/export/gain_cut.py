"""What it costs that a target's filter has its last gain from the first sample on."""

from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from cabledrive.control.observer_numbers import BY_LOAD
from cabledrive.control.reference_kernels import reference_table
from cabledrive.control.reference_numbers import MotionNumbers
from cabledrive.rig.closed_loop.loop import Loop, run


@dataclass(frozen=True, slots=True, kw_only=True)
class GainCut:
    """The loss along the standard pulse on the lumped plant.

    ``samples``: gains left out; ``peak``, ``rms``: error of the load with the last gain alone, over that with
    the whole schedule; None where the two are one.
    """

    samples: int
    peak: float | None
    rms: float | None

    @property
    def data(self) -> dict[str, Any]:
        """As a controller.json holds it."""
        return {
            "gains_left_out": self.samples,
            "peak_error_ratio": self.peak,
            "rms_error_ratio": self.rms,
            "tried_on": "standard pulse, lumped plant",
        }

    @property
    def note(self) -> str:
        """In words."""
        if self.peak is None or self.rms is None:
            return "the filter has one gain: nothing of its schedule is left out"
        return (
            f"{self.samples} gains that lead to the last one are left out: along the standard pulse on the "
            f"lumped plant the peak error is {self.peak:.6g} times, the rms error {self.rms:.6g} times that "
            "with all of them"
        )


def gain_cut(loop: Loop, motion: MotionNumbers) -> GainCut | None:
    """Run a loop with its schedule of gains and with the last one alone; None where a run does not end."""
    gains = loop.observer.gains
    if len(gains) < 2 or loop.observer.kind == BY_LOAD:
        return GainCut(samples=0, peak=None, rms=None)
    made = loop.controller
    if made.generator is not None and made.generator.load.columns:
        table = reference_table(made.generator, motion, loop.rig.interval, len(made.reference))
        made = replace(made, reference=table)
    settled = replace(
        loop, controller=made, observer=loop.observer._replace(gains=gains[-1:].copy())
    )  # fmt: skip
    whole, cut = (run(one, log=False) for one in (loop, settled))
    if min(whole.ended, cut.ended) < len(loop.target):
        return None
    before, after = whole.state.summary, cut.state.summary
    return GainCut(
        samples=len(gains) - 1,
        peak=float(after[0] / before[0]),
        rms=sqrt(after[3] / before[3]),
    )
