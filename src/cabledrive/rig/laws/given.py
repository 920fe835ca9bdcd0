"""A controller of the user's own, and the law of a controller.json, made ready for the rig."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from cabledrive.control.linear_laws import feedforward_generator
from cabledrive.control.load_schedule import LoadSchedule
from cabledrive.control.numbers import DARC, HIGH, LOW, OWN, LawNumbers, start_estimates
from cabledrive.control.own_controller import checked_controller
from cabledrive.control.reference import reference_numbers
from cabledrive.control.reference_kernels import reference_table
from cabledrive.parameters import InputRefused, content_hash
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.laws.baselines import FEEDFORWARDS, feedforward_table, inverse_of
from cabledrive.rig.laws.controller_file import ControllerFile
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law, motion_numbers, place
from cabledrive.rig.laws.load_learning import KINDS, announced, load_learning, told_otherwise
from cabledrive.rig.laws.registry import CONTROLLERS


def own_law(given: Any, spec: DesignSpec) -> Controller:
    """The user's controller with its reference along the motion."""
    own = checked_controller(given)
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
    chain, shafts = spec.chain, own.shafts or spec.shafts
    if "drive" in shafts and chain.size == 2 and "motor" in shafts:
        raise InputRefused(
            f'controller "{own.name}": shafts = {shafts}, but motor and drive pulley of {spec.drive.name} '
            "turn as one: take motor and load, or give motor.joint_stiffness"
        )
    gains, n, generator = {"measures": own.measures, "follows": own.follows}, chain.size, None
    if own.follows == "motion":
        reference, generator = spec.wanted(2 * n).T, reference_numbers(np.eye(2 * n + 1))
    else:
        gains["feedforward"] = FEEDFORWARDS[spec.feedforward]
        places = [place(chain, shaft) for shaft in shafts]
        kept = [*places, *(n + i for i in places), 2 * n]
        reference = feedforward_table(spec, chain, spec.wanted(2 * n))[:, kept]
        if "motor" in shafts or chain.coulomb[0] == 0.0:  # else friction needs a shaft that is left out
            whole = feedforward_generator(chain, inverse_of(spec, chain), spec.interval)
            columns = [[kept.index(column) for column in one] for one in whole.places.tolist()]
            generator = whole._replace(
                output=np.ascontiguousarray(whole.output[kept]),
                constant=whole.constant[kept],
                places=np.array(columns, dtype=np.int64).reshape(-1, 2),
            )
    return Controller(
        name=own.name,
        law=LawNumbers(OWN, np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((5, 0)), np.zeros(7)),
        reference=np.ascontiguousarray(reference),
        shafts=shafts,
        gains=gains,
        model=spec.number,
        own=own,
        generator=generator,
    )


def law_from_file(found: ControllerFile, spec: DesignSpec) -> Controller:
    """The law of a file with its reference along another motion; tables along the motion are made anew."""
    if content_hash(spec.drive) != found.drive_hash:
        raise InputRefused(
            f"was made for another drive, hash {found.drive_hash[:12]}, not {content_hash(spec.drive)[:12]}: "
            "give the drive.toml beside it, and what differs as the plant"
        ).at(found.path)
    if spec.bandwidth is not None or not spec.adapt:
        raise InputRefused("holds its own gains: leave bandwidth and adaptation out").at(found.path)
    if spec.feedforward != "damped":
        raise InputRefused("holds a law with the damped inverse: leave feedforward out").at(found.path)
    spec = replace(spec, feedback=found.feedback, best=False)
    if found.reference is None:
        raise InputRefused("has no generator of its reference: run the study again").at(found.path)
    given = replace(
        spec, bandwidth=found.bandwidth
    )  # the packaged law of that name, for what a run says of it
    if found.name.endswith("-damped"):  # without the trial runs that chose its gains
        made = chain_law(given, int(found.name.split("-")[1]), damped=True)
    elif found.name in KINDS:
        made = load_learning(given, found.name, found.reference.load.turning)
    else:
        made = CONTROLLERS[found.name](given)
    hertz = {} if found.bandwidth is None else {"bandwidth_hz": found.bandwidth}
    rate = None if found.bandwidth is None or found.law.kind != DARC else 2.0 * pi * found.bandwidth
    gains = {"file": found.path} | hertz
    changed = replace(made, law=found.law, start=start_estimates(found.law), gains=gains, bandwidth=rate)
    motion = motion_numbers(spec.drive, spec.motion)
    table = reference_table(found.reference, motion, spec.interval, spec.samples)
    made = replace(changed, reference=table, generator=found.reference)
    if made.schedule is None:
        return made
    low, high = (float(end) for end in made.law.learning[[LOW, HIGH], 0])
    for one in spec.motion.payload:  # that the motion announces
        if not low <= one.factor <= high:
            raise InputRefused(
                f"payload = {one.factor:.4g} times the load is outside what it is designed for, {low:.4g} to "
                f"{high:.4g}: announce less, or design it anew with a wider payload_range"
            ).at(found.path)
    schedule = LoadSchedule(low=low, high=high, points=len(made.law.rows))
    told = announced(spec.motion.payload, spec.interval, len(table))
    return told_otherwise(replace(made, schedule=schedule), told)


def with_filter(loop: Loop, found: ControllerFile) -> Loop:
    """A loop with the filter and the torque limit of a file."""
    if loop.options.ideal_sensors or loop.options.observer != "kalman":
        raise InputRefused("brings its own Kalman filter: leave observer and ideal_sensors out").at(
            found.path
        )
    if abs(found.sample_time - loop.rig.interval) > 1e-9 * found.sample_time:
        raise InputRefused(
            f"samples every {found.sample_time:.6g} s, the rig every {loop.rig.interval:.6g} s"
        ).at(found.path)
    if found.encoders != loop.encoder_shafts:
        raise InputRefused(f"reads the encoders of {found.encoders}, the rig {loop.encoder_shafts}").at(
            found.path
        )
    limit = min(found.torque_limit, loop.rig.torque_limit)
    return replace(loop, observer=found.observer, rig=loop.rig._replace(torque_limit=limit))
