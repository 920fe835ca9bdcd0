"""Which laws are compared on a drive, which of them is best, and how that is decided."""

from collections.abc import Sequence
from functools import lru_cache

from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.parameters.fields import nearest
from cabledrive.rig.disturbed.disturbances_file import Disturbances, standard_disturbances
from cabledrive.rig.laws.controllers import DesignSpec
from cabledrive.rig.laws.fitting import load_count, load_gear
from cabledrive.rig.laws.indirect import NAME as INDIRECT
from cabledrive.rig.laws.load_learning import CHANGING
from cabledrive.rig.laws.load_learning import NAME as LOAD_LEARNING
from cabledrive.rig.laws.registry import CONTROLLERS, main_laws
from cabledrive.rig.laws.scheduled import NAME as SCHEDULED
from cabledrive.rig.laws.stepper import OPEN_LOOPS
from cabledrive.rig.ranking.scores import Scores, rank, scored
from cabledrive.rig.setting import RigOptions
from cabledrive.rig.tuning import TunedLaw, law_as_tuned, tuned

BEST = "best"
LEARNS = (INDIRECT, LOAD_LEARNING, CHANGING)
"""Laws whose first pulse is for learning, where there are more."""
BEST_DRAWS = 20
COMPARED = RigOptions(forbid_slack=False)
"""Options of a comparison: random encoder phases, Kalman filter, spans that may go slack and go on."""


def offered(drive: Drive, disturbances: Disturbances) -> tuple[str, ...]:
    """Laws that are compared where none are named, simplest first; two more where the load changes.

    Two more for a stepper as well, the open loops that it is without an encoder.
    """
    *fixed, learning = main_laws(drive)
    steppers = OPEN_LOOPS if drive.motor is not None and drive.motor.holding_stiffness else ()
    changing = (SCHEDULED, CHANGING) if disturbances.changes_load else ()
    return (*steppers, *fixed, *changing, learning)


def checked_names(names: Sequence[str]) -> tuple[str, ...]:
    """Names of laws, each once.

    Raises `InputRefused` if one is unknown or given twice, or there is none.
    """
    for place, name in enumerate(names):
        if name not in CONTROLLERS:
            raise InputRefused(
                f"controller = {name!r} is not known{nearest(name, CONTROLLERS)}: see docs/control"
            )
        if name in names[:place]:
            raise InputRefused(f"controller {name} is given twice: name each once")
    if not names:
        raise InputRefused("controllers: none are named: name at least one, such as lqi,darc-4-damped")
    return tuple(names)


def one_count(drive: Drive) -> float:
    """One count of the load's encoder, else of the one nearest to it, at the load [rad]."""
    return load_count(drive) / load_gear(drive)


def goal_of(drive: Drive) -> float:
    """Error that is to be kept: the drive's own goal, or one count of the load's encoder [rad]."""
    own = drive.goal.tracking_error if drive.goal is not None else None
    return one_count(drive) if own is None else own


@lru_cache(maxsize=8)
def best_law(spec: DesignSpec) -> tuple[TunedLaw, tuple[tuple[str, Scores | None], ...]]:
    """The law with feedback that ranks first on a drive, tuned, and what each reached on the first plants.

    ``spec``: with its motion.
    Raises `NotComputed` if no law can be tuned.
    """
    assert spec.motion is not None
    disturbances, goal = standard_disturbances(spec.drive), goal_of(spec.drive)
    several = spec.motion.pulses > 1
    found: list[tuple[tuple[float, float], TunedLaw]] = []
    reached: list[tuple[str, Scores | None]] = []
    for name in offered(spec.drive, disturbances):
        if name in OPEN_LOOPS:  # no controller, as which "best" is exported and studied
            continue
        try:
            one = tuned(name, spec, disturbances)
            law = law_as_tuned(name, one.bandwidth, one.filter, spec)
            scores = scored(law, spec, disturbances, COMPARED, 0, range(BEST_DRAWS)) if one.accepted else None
        except (NotComputed, InputRefused):
            scores = None
        reached.append((name, scores))
        if scores is not None:
            found.append((rank(scores, goal, learns=several and name in LEARNS), law))
    if not found:
        raise NotComputed("no law of the comparison can be tuned on this drive: name one, such as pd")
    return min(found, key=lambda pair: pair[0])[1], tuple(reached)
