"""Frequency responses as section 4.3 measures them: a sum of sines on the virtual rig, beside the theory."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.filters import difference, zero_phase
from cabledrive.identification.frequency_response import response_by_segments
from cabledrive.identification.log_response import compensated_torque
from cabledrive.parameters import load_drive
from cabledrive.reduction.lumped_chain import LumpedChain, speed_response
from cabledrive.rig.bench.virtual_rig import VirtualRig, response_command, rig_of, run_rig
from reproduction.panel import Panel, curve

Array = NDArray[np.float64]

SEED, AMPLITUDE = 2015, 1.0
SKIPPED, USED = 3.0, 5.0
LONG_WINDOW = 2.5
FRICTION_BAND = 60.0
"""Bandwidth of the speed whose sign the friction takes [Hz]."""

BAND = (5.0, 100.0)
"""Where measurement and theory are compared [Hz]; above, the counts of the encoder drown the speed."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredResponse:
    """A response on the virtual rig beside its theory.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        [Hz].
    measured, theory : ndarray of complex, shape (n,)
        Motor speed over compensated torque [rad/s / (N m)].
    """

    frequency: Array
    measured: NDArray[np.complex128]
    theory: NDArray[np.complex128]

    @property
    def off(self) -> float:
        """Median size of the relative difference in `BAND`."""
        band = (self.frequency >= BAND[0]) & (self.frequency <= BAND[1])
        return float(np.median(np.abs(self.measured[band] / self.theory[band] - 1.0)))

    def panel(self, figure: str, title: str) -> Panel:
        """Magnitudes of both."""
        band = (self.frequency >= 1.0) & (self.frequency <= 500.0)
        return Panel(
            figure=figure,
            title=title,
            x="frequency [Hz]",
            y="speed per torque [rad/(N m s)]",
            curves=(
                curve("virtual rig", self.frequency[band], np.abs(self.measured[band])),
                curve("theory", self.frequency[band], np.abs(self.theory[band])),
            ),
            log_x=True,
            log_y=True,
        )


def measured_response(chain: LumpedChain, window: float = LONG_WINDOW) -> MeasuredResponse:
    """Response from compensated torque to motor speed, Section 4.3, on a virtual rig.

    ``chain``: the rig; ``window``: of the Hann windows [s]; those of the print, 1 s, do not part its lines.
    """
    rng = np.random.default_rng(SEED)
    rig: VirtualRig = replace(rig_of(load_drive("dissertation-3")), chain=chain, encoders={"angle": 2600})
    log = run_rig(rig, response_command(rng, amplitude=AMPLITUDE), rng)
    h = log.interval
    angle = log.channel("angle")
    slow = difference(zero_phase(angle, h, FRICTION_BAND), h)
    speed = difference(angle, h)
    torque = compensated_torque(log.channel("torque"), slow, chain.coulomb[0], chain.offsets[0])
    used = slice(round(SKIPPED / h), round((SKIPPED + USED) / h))
    found = response_by_segments(torque[used], speed[used], h, segment=window, overlap=0.2)
    kept = (found.frequency >= 1.0) & (found.frequency <= 500.0)
    frequency = found.frequency[kept]
    theory = speed_response(chain, 2 * np.pi * frequency)
    return MeasuredResponse(frequency=frequency, measured=found.response[kept], theory=theory)
