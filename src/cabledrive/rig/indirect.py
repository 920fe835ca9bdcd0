"""The law that identifies in the loop: one pulse to learn the cable from, then everything anew."""

from dataclasses import replace

import numpy as np

from cabledrive.control.kalman import EAGER, QUIET
from cabledrive.control.load_equation import LoadEstimate, estimate_load
from cabledrive.parameters import Drive, Lumped
from cabledrive.rig.controllers import BEST_HZ, Controller, Wish, chain_law
from cabledrive.rig.loop import Loop, Run, close_loop, run
from cabledrive.rig.other_plants import on_the_plant_of
from cabledrive.rig.setting import Motion, RigOptions

NAME = "darc-indirect"


def indirect(wish: Wish) -> Controller:
    """The law before anything has been learnt: damping-aware Model 4.

    Parameters
    ----------
    wish : Wish

    Returns
    -------
    Controller
    """
    if wish.best and wish.bandwidth is None:
        return chain_law(replace(wish, bandwidth=BEST_HZ), 4, NAME, damped=True, tuning=EAGER)
    return chain_law(wish, 4, NAME, damped=True)


def learnt_drive(drive: Drive, found: LoadEstimate) -> Drive:
    """A drive whose cable has the stiffness and damping that were found, its load inertia as believed.

    Parameters
    ----------
    drive : Drive
    found : LoadEstimate

    Returns
    -------
    Drive
    """
    radius = drive.drive_pulley.radius
    inertia = drive.load_pulley.inertia * (radius / drive.load_pulley.radius) ** 2
    spans = len(drive.spans)
    stiffness = found.beta * inertia / (spans * radius**2)
    damping = max(found.gamma, 0.0) * inertia / (spans * radius)
    return replace(drive, lumped=Lumped(cable_stiffness=stiffness, cable_damping=damping))


def run_indirect(
    wish: Wish,
    actual: Drive,
    loop: Loop,
    motion: Motion,
    options: RigOptions,
    *,
    plant_model: int | None,
) -> tuple[Loop, Run, LoadEstimate | None]:
    """Run one pulse, learn, rebuild in the dwell, and run the rest.

    Parameters
    ----------
    wish : Wish
    actual : Drive
        As it is.
    loop : Loop
        With the law of `indirect`.
    motion : Motion
    options : RigOptions
    plant_model : {1, 2, 3, 4}, optional

    Returns
    -------
    loop : Loop
        The last one.
    done : Run
    found : LoadEstimate or None
        What was learnt; None if the run ended before.
    """
    pause = loop.rig.first_end
    early = run(loop, last=min(pause, len(loop.target)))
    if early.ended < pause or motion.pulses == 1:
        return loop, early if early.ended < pause else _rest(loop, early, pause), None
    found = learnt(loop, early, pause)
    rebuilt = loop
    if found.excited:
        believed = learnt_drive(wish.drive, found)
        later = chain_law(replace(wish, drive=believed, bandwidth=_bandwidth(wish)), 4, NAME, damped=True)
        made = replace(later, tuning=QUIET, gains=later.gains | {"beta": found.beta})
        generator = np.random.default_rng(0)  # phases are those of the first loop
        fresh = close_loop(believed, actual, made, motion, options, generator, plant_model=plant_model)
        rebuilt = on_the_plant_of(fresh, loop)
    return rebuilt, _rest(rebuilt, early, pause), found


def learnt(loop: Loop, early: Run, pause: int) -> LoadEstimate:
    """What the readings of the first pulse say of the cable.

    Parameters
    ----------
    loop : Loop
    early : Run
    pause : int
        Samples that have been run.

    Returns
    -------
    LoadEstimate
    """
    first = 2 * loop.chain.size + 1
    shafts = loop.encoder_shafts
    near = shafts.index("drive") if "drive" in shafts else 0
    readings = early.log[:pause, first : first + len(shafts)]
    return estimate_load(readings[:, near], readings[:, -1], loop.rig.interval)


def _bandwidth(wish: Wish) -> float | None:
    return BEST_HZ if wish.best and wish.bandwidth is None else wish.bandwidth


def _rest(loop: Loop, early: Run, pause: int) -> Run:
    late = run(loop, state=early.state, first=pause)
    log = early.log.copy()
    log[pause:] = late.log[pause:]
    tensions = late.tensions
    if tensions is not None and early.tensions is not None:
        tensions[:pause] = early.tensions[:pause]
    return Run(ended=late.ended, state=late.state, log=log, tensions=tensions)
