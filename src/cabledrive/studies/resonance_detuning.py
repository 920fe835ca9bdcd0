"""Detuning of a drive from the instability region of a torque; tuning of each span under a steady load."""

from dataclasses import dataclass

import numpy as np

from cabledrive.reduction.autoparametric import AutoparametricModel, at_pretension
from cabledrive.reduction.averaging import averaged_coefficients
from cabledrive.reduction.threshold import growth_rates, instability_half_width, pulley_amplitude

BUILD_UP = 10.0
"""How long the torque has acted when the verdict is given [s]."""

CLOSE = 2.0
"""Within so many half-widths of the instability region a drive is close to resonance."""

RESONANT, NEAR, SAFE = "resonant", "close", "safe"


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
    c = averaged_coefficients(model, torque=torque, drift=False)
    reached = float(pulley_amplitude(c, BUILD_UP))
    amplitude = min(reached, float(model.slack_amplitude))
    width = instability_half_width(c, amplitude)
    pumping = np.abs(c.pump) * amplitude
    distance = np.abs(c.transverse_detuning + pumping**2 / (2.0 * c.forcing))
    mode = int(np.argmin(distance - CLOSE * width))
    near, half = float(distance[mode]), float(width[mode])
    verdict = RESONANT if near < half else NEAR if near < CLOSE * half else SAFE
    return InstabilityMargin(
        verdict=verdict,
        mode=mode,
        distance=near,
        half_width=half,
        growth=float(growth_rates(c, amplitude)[mode]),
        amplitude=amplitude,
        slack=reached > model.slack_amplitude,
    )
