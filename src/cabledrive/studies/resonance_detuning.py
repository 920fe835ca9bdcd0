"""Detuning of a drive from the instability region of a torque, and whether what acts reaches it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from cabledrive.answers.figures import figure
from cabledrive.answers.result import Result
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.fields import LARGEST
from cabledrive.reduction.threshold import NEAR, RESONANT, SAFE, InstabilityMargin
from cabledrive.studies.excitation_orders import frequency_per_speed
from cabledrive.studies.pair_thresholds import NearPair

FAR = 0.5
"""Of twice the frequency ratio from one: the averaged equations describe no detuning beyond."""
NO_EXCITATION = "no excitation given"
"""Nothing is said of what excites the machine, so that there is nothing to judge."""
OF_A_MOTION = {"safe": SAFE, "dangerous": RESONANT, "unknown": "unknown"}
"""The verdict of a planned motion, where that is all that excites a machine."""
SHOWN = "Internal resonance"
"""Heading of the figures of a result."""
SLACK = "the spans go slack before any torque does this"
STATE_ONE = "state one by --torque, --motion or [excitation]"


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class ResonanceSummary(Result):
    """What there is to say about the internal resonance of a machine; None: see ``missing``."""

    _table = "pairs"

    frequency_ratio: float | None = figure(
        "1", "Frequency ratio, first transverse mode of a span over pulley mode", SHOWN, default=None
    )
    detuning: float | None = figure("1", "Detuning, ratio - 1/2", SHOWN, default=None)
    tuned_pretension: float | None = figure("N", "Tuned pretension, ratio 1/2", SHOWN, default=None)
    threshold_torque: float | None = figure(
        "N m", "Threshold torque, at the tuned pretension if there is one", SHOWN, default=None
    )
    verdict: str  # {"resonant", "close", "safe", "unknown", "no excitation given"}
    pulley_frequency: float | None = figure(
        "Hz", "Pulley mode", SHOWN, key="pulley_frequency_hz", default=None
    )
    # of the verdict; where no excitation is given, on a loop or a line of the other figures
    torque: float | None = figure("N m", "Torque of these figures", SHOWN, STATE_ONE)
    threshold_here: float | None = figure(
        "N m",
        "Threshold torque, as given",
        SHOWN,
        SLACK,
        key="threshold_torque_at_own_pretension",
        default=None,
    )
    growth_torque: float | None = figure(
        "N m", "Tenfold growth in 1 s, tuned", SHOWN, SLACK, key="tenfold_growth_torque", default=None
    )
    # below which friction keeps the pulley mode from growing
    coulomb_onset: float | None = figure(
        "N m", "No growth below, by Coulomb friction", SHOWN, SLACK, key="coulomb_onset_torque", default=None
    )
    # of the pulley mode and of others near resonance, lowest threshold first
    pairs: tuple[NearPair, ...] = ()
    reasons: tuple[str, ...]  # of the verdict
    missing: dict[str, str]  # why a number does not exist, by its name
    motor: str  # how the rotors are held
    instability: InstabilityMargin | None = None  # of a loop or a line
    split: dict[str, float | None] = field(default_factory=dict)  # tuned under a steady load, by span [N]
    # with routes: the span of the ratio, nearest to 1:2; whether the list of modes is complete and straight
    # ropes are a model of them; what the pairs do not hold, and why their modes are not certified
    nearest_span: str | None = None
    certified: bool | None = None
    left_out: tuple[str, ...] = ()


UNKNOWN = "unknown"
CLOSE_SHARE = 0.5
"""Share of the lowest threshold from which a torque is called close."""


@dataclass(frozen=True, slots=True)
class ActingTorque:
    """A torque that acts on the first motor's pulley without a planned motion."""

    amplitude: float | None  # [N m]; None: nobody says
    # name of an order with the frequencies that it reaches [Hz]; None: it may act at any frequency
    bands: tuple[tuple[str, float, float], ...] | None = None

    def reaches(self, hertz: float) -> str | None:
        """How it comes to act at a frequency [Hz]: the name of an order, or "" for any; None: it does not."""
        if self.bands is None:
            return ""
        return next((name for name, low, high in self.bands if low <= hertz <= high), None)


def acting_torque(drive: Machine, torque: float | None) -> ActingTorque | None:
    """The torque [N m] of the verdict: as given, else that of [excitation]; None where there is neither."""
    if torque is not None:
        if not 0.0 <= torque <= LARGEST:
            raise InputRefused(f"torque = {torque:.9g} N m must lie between 0 and {LARGEST:g} N m")
        return ActingTorque(torque)
    stated = drive.excitation
    if stated is None:
        return None
    ripple, limit = stated.torque_ripple, drive.motors[0].torque_limit if drive.motors else None
    amplitude = None if ripple is None or limit is None else ripple * limit
    if not stated.orders:
        return ActingTorque(amplitude)
    coordinate, low, high = stated.range
    bands = []
    for order in stated.listed:
        rate = frequency_per_speed(drive, order, coordinate)
        if order.pulley is not None:  # a rail's joints push a body, not the motor
            bands.append((order.name, rate * low, rate * high))
    return ActingTorque(amplitude, tuple(bands))


def verdict_of(
    acting: ActingTorque | None, thresholds: Sequence[tuple[float, float | None]]
) -> tuple[str, tuple[str, ...]]:
    """The verdict on a torque with its reasons; ``thresholds``: frequency [Hz], torque [N m] of pairs."""
    excited = [(torque, hertz) for hertz, torque in thresholds if torque is not None]
    if not excited:
        return (NO_EXCITATION if acting is None else SAFE), ("no listed pair is excited by the first motor",)
    lowest, at = min(excited)
    from_there = f"from {lowest:.4g} N m of steady torque at {at:.4g} Hz on, transverse modes grow"
    if acting is None:
        return NO_EXCITATION, (f"{STATE_ONE}; {from_there}",)
    reached = [(torque, hertz) for torque, hertz in excited if acting.reaches(hertz) is not None]
    if not reached:
        bands = ", ".join(f"{name} {low:.4g} to {high:.4g} Hz" for name, low, high in acting.bands or ())
        return SAFE, (f"no order reaches the longitudinal frequency of a pair: {bands or 'none turns'}",)
    lowest, at = min(reached)
    by = acting.reaches(at)
    source = f"order {by}" if by else "a torque"
    words = f"{source} at {at:.4g} Hz grows transverse modes from {lowest:.4g} N m on"
    if acting.amplitude is None:
        return UNKNOWN, (f"{words}; its amplitude is not given: add excitation.torque_ripple",)
    words = f"{words}; the amplitude is {acting.amplitude:.4g} N m"
    if acting.amplitude >= lowest and acting.amplitude > 0.0:
        return RESONANT, (words,)
    return (NEAR if acting.amplitude >= CLOSE_SHARE * lowest > 0.0 else SAFE), (words,)


REACH = 1.0
"""Largest relative change of pretension and inertia that is tried."""

FAILED = "tried without success"

TRIALS = 48


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """One change that was tried to make the verdict safe."""

    change: str  # {"raise pretension", "lower pretension", "add inertia", "add damping", "limit torque"}
    # new pretension [N], inertia to add at the load pulley [kg m^2], viscous friction to add there
    # [N m s/rad], or largest torque [N m]; None where no value within reach is enough
    value: float | None
    text: str  # in words

    @property
    def enough(self) -> bool:
        """Whether this change alone makes the verdict safe."""
        return self.value is not None and (self.change != "limit torque" or self.value > 0.0)


def first_safe(
    trial: Callable[[float], Any], safe: Callable[[Any], bool], trials: int = TRIALS
) -> float | None:
    """Smallest share of the reach at which the drive is safe, refined by halving."""
    shares = [REACH * (i / trials) ** 2 for i in range(trials + 1)]
    for low, high in pairwise(shares):
        if safe(trial(high)):
            for _ in range(trials // 2):
                if high - low < 1e-3 * high:
                    break
                middle = 0.5 * (low + high)
                low, high = (low, middle) if safe(trial(middle)) else (middle, high)
            return high
    return None
