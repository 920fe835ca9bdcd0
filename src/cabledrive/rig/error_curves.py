"""Peak errors of laws over rise time, angle and bandwidth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan

from cabledrive.parameters import Drive, InputRefused
from cabledrive.rig.setting import DISSERTATION_ORDER, Motion, RigOptions
from cabledrive.rig.trial import track_pulses

RISES = (0.3, 0.4, 0.5, 0.6, 0.7, 1.0)
ANGLES = (10.0, 22.5, 45.0, 67.5, 90.0)
BANDWIDTHS = (8.0, 11.0, 14.0, 18.0, 23.0, 28.0, 35.0)
LARGEST_SHOWN = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorCurve:
    """Peak errors of several laws over one quantity.

    Attributes
    ----------
    quantity : {"rise", "angle", "bandwidth"}
        [s], [deg], [Hz].
    values : tuple of float
    errors : dict of str to tuple of float
        Of each law [deg]; nan where the law refuses, ends early, or errs by more than 3 deg.
    """

    quantity: str
    values: tuple[float, ...]
    errors: dict[str, tuple[float, ...]]


def error_curves(
    drive: Drive,
    laws: Sequence[str],
    *,
    options: RigOptions | None = None,
    motion: Motion | None = None,
    plant: str | None = None,
) -> tuple[ErrorCurve, ...]:
    """Peak error of each law over rise time, angle and bandwidth, one at a time.

    ``laws``: names of controllers with a bandwidth; ``options``: default: encoders that start at the centre
    of a count; ``motion``: where the curves meet; default: 45 deg in 0.5 s, order 9 as in the dissertation.
    """
    options, motion = (
        options or RigOptions(encoder_phase="centred"),
        motion or Motion(order=DISSERTATION_ORDER),
    )

    def peak(law: str, moved: Motion, bandwidth: float | None = None) -> float:
        try:
            run = track_pulses(
                drive,
                controller=law,
                motion=moved,
                bandwidth=bandwidth,
                options=options,
                plant=plant,
                gains="dissertation",
            )
        except InputRefused:
            return nan
        error = float(run.summary["peak_error_deg"])
        return nan if run.incomplete or error > LARGEST_SHOWN else error

    over_rise = {law: tuple(peak(law, replace(motion, rise=rise)) for rise in RISES) for law in laws}
    over_angle = {law: tuple(peak(law, replace(motion, angle=angle)) for angle in ANGLES) for law in laws}
    over_hertz = {law: tuple(peak(law, motion, hertz) for hertz in BANDWIDTHS) for law in laws}
    return (
        ErrorCurve(quantity="rise", values=RISES, errors=over_rise),
        ErrorCurve(quantity="angle", values=ANGLES, errors=over_angle),
        ErrorCurve(quantity="bandwidth", values=BANDWIDTHS, errors=over_hertz),
    )
