"""A controller of the user's own, made ready for a drive, a motion and the rig's sensors."""

from typing import Any

import numpy as np

from cabledrive.control.linear_laws import feedforward_generator
from cabledrive.control.numbers import OWN, LawNumbers
from cabledrive.control.observers import QUIET
from cabledrive.control.own_controller import OwnController, checked_controller
from cabledrive.control.reference import ReferenceNumbers, flat_output, reference_numbers
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import highest_model
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.laws.baselines import FEEDFORWARDS, feedforward_table
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.fitting import place


def own_law(given: Any, spec: DesignSpec) -> Controller:
    """The user's controller with its reference along the motion.

    ``given``: an object of `cabledrive.control.ControllerProtocol`.
    Raises `InputRefused` if it does not fit: its name, shafts, sample time, or settings of packaged laws.
    """
    own = checked_controller(given)
    _check(own, spec)
    number = highest_model(spec.drive)
    chain = spec.model(number)
    shafts = own.shafts or (("motor", "drive", "load") if chain.size == 3 else ("motor", "load"))
    if "drive" in shafts and chain.size == 2 and "motor" in shafts:
        raise InputRefused(
            f'controller "{own.name}": shafts = {shafts}, but motor and drive pulley of {spec.drive.name} '
            "turn as one: take motor and load, or give motor.joint_stiffness"
        )
    gains = {"measures": own.measures, "follows": own.follows}
    if own.follows == "inverse":
        gains["feedforward"] = FEEDFORWARDS[spec.feedforward]
    return Controller(
        name=own.name,
        law=LawNumbers(OWN, np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((5, 0)), np.zeros(7)),
        reference=np.ascontiguousarray(_reference(own, spec, shafts)),
        shafts=shafts,
        start=np.zeros(0),
        tuning=QUIET,
        gains=gains,
        model=number,
        damped=True,
        own=own,
        generator=_generator(own, spec, shafts),
    )


def _reference(own: OwnController, spec: DesignSpec, shafts: tuple[str, ...]) -> Array:
    """What the controller follows, shape (samples, columns)."""
    chain = spec.model(highest_model(spec.drive))
    wanted = spec.wanted(2 * chain.size)
    if own.follows == "motion":
        return wanted.T
    table = feedforward_table(spec, chain, wanted)
    places = [place(chain, shaft) for shaft in shafts]
    return table[:, [*places, *(chain.size + i for i in places), 2 * chain.size]]


def _generator(own: OwnController, spec: DesignSpec, shafts: tuple[str, ...]) -> ReferenceNumbers | None:
    """What makes the rows of `_reference` sample by sample; none where friction needs a shaft left out."""
    chain = spec.model(highest_model(spec.drive))
    n = chain.size
    if own.follows == "motion":
        return reference_numbers(np.eye(2 * n + 1))
    if "motor" not in shafts and chain.coulomb[0] > 0.0:
        return None
    rigid = spec.feedforward == "rigid"
    flat = None if rigid else flat_output(chain, damped=spec.feedforward == "damped")
    whole = feedforward_generator(chain, flat, spec.interval)
    places = [place(chain, shaft) for shaft in shafts]
    kept = [*places, *(n + i for i in places), 2 * n]
    return whole._replace(
        output=np.ascontiguousarray(whole.output[kept]),
        constant=whole.constant[kept],
        places=np.array(
            [[kept.index(column) for column in one] for one in whole.places.tolist()], dtype=np.int64
        ).reshape(-1, 2),
    )


def _check(own: OwnController, spec: DesignSpec) -> None:
    if own.sample_time is not None and abs(own.sample_time - spec.interval) > 1e-9 * spec.interval:
        raise InputRefused(
            f'controller "{own.name}": sample_time = {own.sample_time:.6g} s is not that of the rig, '
            f"{spec.interval:.6g} s: design it for that, or change sensors.sample_rate"
        )
    if spec.bandwidth is not None:
        raise InputRefused(
            f'bandwidth = {spec.bandwidth:.4g} Hz is a setting of the packaged laws; "{own.name}" has gains '
            "of its own: leave it out"
        )
    if not spec.adapt:
        raise InputRefused(f'adapt = False is a setting of the packaged laws: leave it out for "{own.name}"')
