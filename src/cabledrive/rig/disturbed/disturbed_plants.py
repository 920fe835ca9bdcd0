"""Plants drawn with their disturbances, the same ones for every law."""

from dataclasses import fields, replace
from math import ceil, inf, pi

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.chain_kernels import ChainPlant
from cabledrive.rig.closed_loop.chain_plant import chain_numbers
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.disturbed.disturbances_file import Disturbances
from cabledrive.rig.laws.scheduled import announced, told_otherwise
from cabledrive.rig.plant_samples import sampled_chain
from cabledrive.rig.setting import Payload, RigOptions

ANNOUNCED = ("announced_error", "announced_late")
"""Drawn last, and for laws that are told the load alone: every law meets the same plants."""
STEP = 20e-6
"""Longest internal step [s]; a hundredth of a degree at 4 rad/s is forty of them."""


def disturbed_loop(
    loop: Loop, disturbances: Disturbances, options: RigOptions, generator: np.random.Generator
) -> Loop:
    """The same law and filter on one plant at random with its disturbances.

    ``loop``: nominal, on a lumped chain.
    Raises `InputRefused` if the delay to add reaches the next sample, or the plant is no lumped chain.
    """
    if loop.cable is not None or loop.own_plant is not None:
        raise InputRefused("disturbed plants are lumped chains: leave the plant out")
    chain = sampled_chain(loop.chain, generator)
    names = [one.name for one in fields(disturbances) if one.name not in ANNOUNCED]
    drawn = {name: generator.uniform(*getattr(disturbances, name)) for name in names}
    chain = replace(
        chain,
        coulomb=(*chain.coulomb[:-1], chain.coulomb[-1] + drawn["load_coulomb"]),
        viscous=(*chain.viscous[:-1], chain.viscous[-1] + drawn["load_viscous"]),
    )
    phases = generator.uniform(-0.5, 0.5, len(loop.rig.phases))
    turned = generator.uniform(0.0, 2.0 * pi, 3)
    jitter = generator.normal(0.0, 1.0, len(loop.target) + 1)
    late = loop.rig.late_part + drawn["added_delay"]
    interval = loop.rig.interval
    if late >= interval:
        raise InputRefused(
            f"added_delay = {drawn['added_delay']:.4g} s reaches the next sample, {interval:.4g} s: keep it "
            "and the drive's own part of a sample below, or raise sensors.delay by whole samples"
        )
    random = options.encoder_phase == "random" and not options.ideal_sensors
    rig = loop.rig._replace(
        phases=phases if random else loop.rig.phases,
        late_part=late,
        forces=loop.rig.forces + shock(drawn, loop.rig.forces.shape[0], interval),
    )
    if drawn["jitter"] > 0.0:
        rig = rig._replace(jitter=np.clip(drawn["jitter"] * jitter, -0.4 * interval, 0.4 * interval))
    made = loop.controller
    if disturbances.changes_load and made.schedule is not None:
        drawn |= {name: generator.uniform(*getattr(disturbances, name)) for name in ANNOUNCED}
        start = max(drawn["load_time"] + drawn["announced_late"], 0.0)
        payload = Payload(factor=drawn["load_factor"] * (1.0 + drawn["announced_error"]), start=start)
        made = told_otherwise(made, announced((payload,), interval, len(loop.target)))
    plant = disturbed_plant(loop, chain, drawn, turned)
    return replace(loop, chain=chain, rig=rig, controller=made, plant=plant, disturbed=True)


def shock(drawn: dict[str, float], samples: int, interval: float) -> np.ndarray:
    """Torque of a shock on motor and load, shape (samples, 2) [N m]; it lasts at least a sample."""
    forces = np.zeros((samples, 2))
    first = round(drawn["shock_time"] / interval)
    forces[first : first + max(1, round(drawn["shock_duration"] / interval)), 1] = drawn["shock_torque"]
    return forces


def disturbed_plant(
    loop: Loop, chain: LumpedChain, drawn: dict[str, float], turned: np.ndarray
) -> ChainPlant:
    """A plant from its chain and what was drawn.

    ``turned``, shape (3,): phases of cogging, torque ripple and eccentricity [rad].
    """
    flexible = "motor" in chain.names and "drive" in chain.names
    if drawn["backlash"] > 0.0 and not flexible:
        raise InputRefused(
            "backlash needs a flexible motor joint: give motor.joint_stiffness, or leave it out"
        )
    interval = loop.rig.interval
    return chain_numbers(
        chain,
        interval,
        current_rate=loop.plant.current_rate,
        substeps=ceil(interval / STEP),
        play=max(drawn["backlash"], loop.backlash),
        slack=loop.slack * loop.chain.stiffness[-1] / chain.stiffness[-1] if chain.size > 1 else inf,
        twist_limit=loop.plant.twist_limit,
        phases=turned,
        excess=drawn["stribeck_excess"],
        fading=drawn["stribeck_speed"],
        cogging_lines=drawn["cogging_periods"],
        ripple=drawn["torque_ripple"],
        ripple_lines=drawn["ripple_periods"],
        eccentricity=drawn["encoder_eccentricity"] * loop.gear,
        turning=1.0 / loop.gear,
        cogging=drawn["cogging"],
        softening=drawn["softening"],
        warming=drawn["warming"],
        load_factor=drawn["load_factor"],
        load_time=drawn["load_time"],
        field=loop.plant.field,
        field_periods=loop.plant.field_periods,
    )
