"""Feedback and feedforward distinguished: every baseline with every feedforward, tuned by one rule.

The rule: of a few settings of its one number, each pair of law and feedforward gets the one with the smallest
worst error over draws that are set apart for tuning, of those that leave a third of the torque limit unused.
Figures come from other draws. Filter, encoders and draws are the same for all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cabledrive.control.own_controller import ControllerProtocol
from cabledrive.parameters import Drive, InputRefused, NotComputed
from cabledrive.rig.closed_loop.loop import Loop, close_loop
from cabledrive.rig.closed_loop.loop_numbers import SUMMARY
from cabledrive.rig.disturbances import torque_limit
from cabledrive.rig.laws.baselines import BASELINES, lqg
from cabledrive.rig.laws.best_gains import best_chain_law, best_gains
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.own_law import own_law
from cabledrive.rig.plant_samples import PlantSamples, run_samples
from cabledrive.rig.setting import Motion, RigOptions

SETTINGS: dict[str, tuple[float, ...]] = {
    "pd": (2.0, 5.0, 8.0, 11.0, 15.0, 20.0, 30.0),
    "pid": (0.5, 1.0, 1.5, 2.0, 2.5, 3.0),
    "lqg": (0.02, 0.05, 0.2, 0.5, 1.0, 2.0, 4.0),
    "dob": (2.0, 5.0, 8.0, 11.0, 15.0, 20.0),
    "shaper": (2.0, 5.0, 8.0, 11.0, 15.0, 20.0),
}
TUNING_SEED, TORQUE_SHARE = 1_000_003, 2.0 / 3.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Compared:
    """One law with one feedforward over draws.

    Attributes
    ----------
    law, feedforward : str
    setting : float
        Bandwidth [Hz]; of lqg the torque that weighs as one count [N m]; nan: a controller of the user's own,
        which has none.
    draws : Draws
    """

    law: str
    feedforward: str
    setting: float
    draws: PlantSamples


def controller(name: str, spec: DesignSpec, setting: float | None = None) -> Controller:
    """A baseline, or the damping-aware law with the package's gains, at a setting."""
    if name not in BASELINES:
        return best_chain_law(spec if setting is None else replace(spec, bandwidth=setting), name)
    if name == "lqg":
        return lqg(spec) if setting is None else lqg(spec, setting)
    return BASELINES[name](spec if setting is None else replace(spec, bandwidth=setting))


def loops_of(spec: DesignSpec, motion: Motion, options: RigOptions) -> Callable[[Controller], Loop]:
    """Puts any of the laws into the same loop: one plant, one filter, one set of encoders.

    Returns from Controller to Loop.
    Raises `InputRefused` later, for a law that takes other shafts.
    """
    first = replace(best_chain_law(spec, "darc-4-damped"), tuning=best_gains(spec).tuning)
    base = close_loop(spec.drive, spec.drive, first, motion, options, np.random.default_rng(0))

    def put(made: Controller) -> Loop:
        if made.shafts != first.shafts:
            raise InputRefused(
                f'controller "{made.name}": shafts = {made.shafts}, but all laws compared take the states of '
                f"{', '.join(first.shafts)}: take these"
            )
        scalars = base.observer.scalars.copy()
        scalars[8] = made.tuning.cancels
        return replace(base, controller=made, observer=base.observer._replace(scalars=scalars))

    return put


def tuned(
    name: str,
    spec: DesignSpec,
    put: Callable[[Controller], Loop],
    options: RigOptions,
    *,
    draws: int = 8,
    settings: Sequence[float] | None = None,
) -> float:
    """The setting with the smallest worst error over the draws for tuning that leaves torque to spare.

    ``put``: from `loops_of`.
    Raises `NotComputed` if no setting does.
    """
    offered = tuple(settings or SETTINGS[name])
    most = TORQUE_SHARE * torque_limit(spec.drive)
    best, least, refused = None, np.inf, ""
    for setting in offered:
        try:
            law = controller(name, spec, setting)
        except NotComputed as failure:  # of this setting; another may do
            refused = f" ({failure})"
            continue
        found = run_samples(put(law), options, draws, TUNING_SEED)
        worst = float(found.degrees("peak").max())
        torque = float(found.scores[:, SUMMARY.index("peak_torque")].max())
        if not found.failed and torque <= most and worst < least:
            best, least = setting, worst
    if best is None:
        tried = ", ".join(f"{setting:g}" for setting in offered)
        raise NotComputed(
            f"no setting of {name} among {tried} ran to its end on every drawn plant below {most:.4g} N m"
            f"{refused}: offer others"
        )
    return best


def compared(
    drive: Drive,
    names: Sequence[str | ControllerProtocol],
    feedforwards: Sequence[str],
    draws: int,
    seed: int,
    spec: DesignSpec,
    motion: Motion,
    *,
    options: RigOptions | None = None,
    settings: dict[tuple[str, str], float] | None = None,
) -> list[Compared]:
    """Every law with every feedforward over the same draws.

    ``names``: of baselines, or controllers of the user's own, which run as they are. ``settings``:
    settings by law and feedforward; tuned where one is missing.
    """
    options, known = options or RigOptions(forbid_slack=False), settings or {}
    spec = replace(spec, drive=drive)
    put, found = loops_of(spec, motion, options), []
    for name in names:
        for kind in feedforwards:
            one = replace(spec, feedforward=kind)
            if not isinstance(name, str):
                made = own_law(name, one)
                result = run_samples(put(made), options, draws, seed)
                found.append(Compared(law=made.name, feedforward=kind, setting=float("nan"), draws=result))
                continue
            setting = known.get((name, kind))
            setting = tuned(name, one, put, options) if setting is None else setting
            result = run_samples(put(controller(name, one, setting)), options, draws, seed)
            found.append(Compared(law=name, feedforward=kind, setting=setting, draws=result))
    return found
