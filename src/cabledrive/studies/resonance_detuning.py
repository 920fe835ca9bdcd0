"""Detuning of a drive from the instability region of a torque; tuning of each span under a steady load."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.reduction.autoparametric import AutoparametricModel, at_pretension
from cabledrive.reduction.averaging import AveragedCoefficients, averaged_coefficients
from cabledrive.reduction.threshold import growth_rates, instability_half_width, pulley_amplitude

Array = NDArray[np.float64]

BUILD_UP = 10.0
"""How long the torque has acted when the verdict is given [s]."""

CLOSE = 2.0
"""Within so many half-widths of the instability region a drive is close to resonance."""

FAR = 0.5
"""Of twice the frequency ratio from one: the averaged equations describe no detuning beyond."""
RESONANT, NEAR, SAFE = "resonant", "close", "safe"
NO_EXCITATION = "no excitation given"
"""Nothing is said of what excites the machine, so that there is nothing to judge."""
OF_A_MOTION = {"safe": SAFE, "dangerous": RESONANT, "unknown": "unknown"}
"""The verdict of a planned motion, where that is all that excites a machine."""
STATE_ONE = "state one by --torque, --motion or [excitation]"


@dataclass(frozen=True, slots=True, kw_only=True)
class InstabilityMargin:
    """Detuning of a drive from the instability region of a torque.

    Attributes
    ----------
    verdict : {"resonant", "close", "safe"}
    mode : int
        The transverse mode, of those of the model, that decides.
    distance, half_width : float
        Detuning from the middle of the instability region and its half-width [rad/s].
    growth : float
        Growth rate of a vanishing motion [1/s].
    amplitude : float
        Pulley mode's amplitude q under the torque [m].
    slack : bool
        Whether that amplitude is where a span goes slack.
    """

    verdict: str
    mode: int
    distance: float
    half_width: float
    growth: float
    amplitude: float
    slack: bool


def split_tunings(model: AutoparametricModel) -> dict[str, float | None]:
    """Pretension at which each span's own mode has half the pulley mode's frequency under the steady load.

    ``model``: of a drive with a load torque.
    Returns mean tension of the spans [N], by span; None where no pretension within a factor of 20 does it.
    """
    from scipy.optimize import brentq

    found: dict[str, float | None] = {}
    for number, mode in enumerate(model.modes):
        low = max(0.05 * model.pretension, 1.0001 * float(np.max(np.abs(model.tension_offset))))
        high = 20.0 * model.pretension

        def _above(tension: float, number: int = number) -> float:
            return float(at_pretension(model, tension).transverse[number]) - 0.5 * model.natural

        inside = _above(low) < 0.0 < _above(high)
        key = mode.span if mode.span not in found else f"{mode.span} from {mode.section[0]:.4g} m"
        found[key] = float(brentq(_above, low, high, xtol=1e-12)) if inside else None
    return found


def instability_margin(model: AutoparametricModel, torque: float) -> InstabilityMargin:
    """Detuning of a drive from the instability region of a torque that has acted for `BUILD_UP`.

    ``torque`` [N m].
    Returns of the transverse mode that is relatively nearest to its instability region.
    """
    c, reached, amplitude, distance, width = _against_regions(model, torque)
    mode = int(np.argmin(distance - CLOSE * width))
    near, half = float(distance[mode]), float(width[mode])
    return InstabilityMargin(
        verdict=str(_verdict(near, half)),
        mode=mode,
        distance=near,
        half_width=half,
        growth=float(growth_rates(c, amplitude)[mode]),
        amplitude=float(amplitude),
        slack=bool(reached > model.slack_amplitude),
    )


def far_from_tuning(model: AutoparametricModel, found: InstabilityMargin) -> str:
    """Where a safe mode stands that is too far from 1:2 for a detuning; nothing where it is not."""
    ratio = float(model.transverse[found.mode] / model.natural)
    far = found.verdict == SAFE and abs(2.0 * ratio - 1.0) > FAR
    return f"has {ratio:.4g} times its frequency, far from 1:2" if far else ""


def verdicts(model: AutoparametricModel, torque: ArrayLike) -> NDArray[np.str_]:
    """Verdict of `instability_margin` on each lane of a model.

    ``torque``, shape (lanes,): amplitude [N m].
    Returns shape (lanes,).
    """
    *_, distance, width = _against_regions(model, torque)
    mode = np.argmin(distance - CLOSE * width, axis=0)[None]
    near, half = (np.take_along_axis(values, mode, axis=0)[0] for values in (distance, width))
    return _verdict(near, half)


def _against_regions(
    model: AutoparametricModel, torque: ArrayLike
) -> tuple[AveragedCoefficients, Array, Array, Array, Array]:
    """Coefficients, amplitude q that the torque reaches and where slack ends it, detuning, half-width."""
    c = averaged_coefficients(model, torque=torque, drift=False)
    reached = pulley_amplitude(c, BUILD_UP)
    amplitude = np.minimum(reached, model.slack_amplitude)
    pumping = np.abs(c.pump) * amplitude
    distance = np.abs(c.transverse_detuning + pumping**2 / (2.0 * c.forcing))
    return c, reached, amplitude, distance, instability_half_width(c, amplitude)


def _verdict(distance: ArrayLike, half_width: ArrayLike) -> NDArray[np.str_]:
    inside, close = np.less(distance, half_width), np.less(distance, CLOSE * np.asarray(half_width))
    return np.where(inside, RESONANT, np.where(close, NEAR, SAFE))
