"""Options of a run that travel together: law, method, resolution, friction, what slack means."""

from dataclasses import dataclass
from math import isfinite

from cabledrive.mechanics.own_model import Model
from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest

SLACK = ("stop", "record", "tension-only")
FRICTION = ("stick-slip", "smoothed")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scheme:
    """How the cable is computed.

    Attributes
    ----------
    model : str or subclass of CableLaw, default "exact"
        Cable law: "exact", "weak", "weak-consistent", "linear", or one's own: a subclass of
        `cabledrive.CableLaw`, a function that makes one from the keywords `pretension` and `axial_rigidity`,
        or a law made for this cable. What cannot be compiled runs interpreted, and the result says so.
    method : {"verlet", "node-centred", "energy-conserving"}, default "verlet"
        Name of the method, see `cabledrive.simulation.methods`.
    segments : int, default 200
        Segments per span; more where carriages stand closer together.
    step : float or None, default None
        Time step [s]; None: from `cfl`. The step taken is the largest up to it that divides a recording
        interval.
    cfl : float, default 0.9
        Largest share of the stable step to take, where `step` is None.
    slack : {"stop", "record", "tension-only"}, default "stop"
        What happens where the tension falls below zero: the run stops; it is noted, and the law goes on to
        push; it is noted, and the cable carries nothing there.
    friction : {"stick-slip", "smoothed"}, default "stick-slip"
        Coulomb friction of the shafts: set-valued, or smoothed to c tanh(speed / `smoothing_speed`).
    smoothing_speed : float, default 0.1
        Angular speed over which friction is smoothed [rad/s].
    """

    model: Model = "exact"
    method: str = "verlet"
    segments: int = 200
    step: float | None = None
    cfl: float = 0.9
    slack: str = "stop"
    friction: str = "stick-slip"
    smoothing_speed: float = 0.1

    def __post_init__(self) -> None:
        _check_word("slack", self.slack, SLACK)
        _check_word("friction", self.friction, FRICTION)
        if not 0.0 < self.cfl <= 1.0:
            raise InputRefused(f"cfl = {self.cfl}: the method is stable above 0 and up to 1: choose 0.9")
        if self.step is not None and not (isfinite(self.step) and self.step > 0.0):
            raise InputRefused(
                f"step = {self.step} s must be above 0 and finite: leave it out to have one chosen"
            )
        if not (isfinite(self.smoothing_speed) and self.smoothing_speed > 0.0):
            raise InputRefused(
                f"smoothing_speed = {self.smoothing_speed} rad/s must be above 0 and finite: give one"
            )


def _check_word(name: str, value: str, words: tuple[str, ...]) -> None:
    if value not in words:
        raise InputRefused(f'{name} = "{value}" is not one of its values{nearest(str(value), words)}')
