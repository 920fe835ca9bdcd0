"""The law of a study in closed loop: made from what is known, run on this plant or that."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cabledrive.control.darc import Bounds
from cabledrive.parameters import Drive
from cabledrive.reduction.lumped_chain import FLEXIBLE_JOINT
from cabledrive.rig.closed_loop.loop import Loop, close_loop, plant_chain
from cabledrive.rig.closed_loop.other_plants import with_plant
from cabledrive.rig.disturbances import joint_backlash
from cabledrive.rig.laws.controllers import Controller, chain_law
from cabledrive.rig.laws.fitting import fitted_encoders
from cabledrive.rig.setting import Motion, RigOptions
from cabledrive.rig.trial import spec_for
from cabledrive.studies.study.machine import Quantity, drive_with

RIPPLE_ORDER = 12.0
"""Periods per radian where none is drawn."""
MOTOR_SIDE = ("viscous_friction", "coulomb_friction", "offset_torque")


def projection_bounds(quantities: Mapping[str, Quantity], drive: Drive, model: int) -> Bounds:
    """Bounds of the estimates p2 to p5 from what is known.

    ``drive``: with the best values; ``model``, {1, 3, 4}: of the law.
    """
    near = quantities["near_inertia"]
    low, high = near.outer
    if FLEXIBLE_JOINT[model]:
        share = quantities["motor_share"]
        low, high = low * share.outer[0], high * share.outer[1]
    elif model == 1:
        gear = drive.load_pulley.radius / drive.drive_pulley.radius
        load = quantities["load_inertia"].outer
        low, high = low + load[0] / gear**2, high + load[1] / gear**2
    chain = plant_chain(drive, model)
    nominal = np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])
    lows, highs = np.array([[low, high], *(quantities[name].outer for name in MOTOR_SIDE)]).T
    return Bounds(nominal=nominal, low=np.minimum(lows, nominal), high=np.maximum(highs, nominal))


def make_law(
    drive: Drive, motion: Motion, quantities: Mapping[str, Quantity], model: int, hertz: float
) -> Controller:
    """The damped law of the chain, its projection bounds from what is known, at a bandwidth.

    ``drive``: with the best values; ``model``, {1, 3, 4}; ``hertz``: lambda/(2 pi) [Hz].
    """
    spec = spec_for(drive, motion, bandwidth=hertz, feedback=near_encoder(drive))
    bounds = projection_bounds(quantities, drive, model)
    return chain_law(spec, model, f"darc-{model}-damped", damped=True, bounds=bounds)


def near_encoder(drive: Drive) -> str:
    """Encoder that stands for the motor's angle where the law knows one only."""
    return "motor" if "motor" in fitted_encoders(drive) else "drive"


def joined_loop(
    drive: Drive,
    plant: Drive,
    law: Controller,
    motion: Motion,
    torque: float | None,
    *,
    options: RigOptions | None = None,
    cable: bool = False,
) -> Loop:
    """The law on a plant, with the torque limit of the goals.

    ``drive``, ``plant``: as believed, as it is; ``torque``: largest torque of the goals [N m]; ``cable``:
    whether the plant is the distributed nonlinear cable.
    """
    loop = close_loop(
        drive, plant, law, motion, options or rig_options(plant), np.random.default_rng(0), cable=cable
    )
    limit = loop.rig.torque_limit if torque is None else min(torque, loop.rig.torque_limit)
    return replace(loop, rig=loop.rig._replace(torque_limit=float(limit)))


def rig_options(drive: Drive, *, ideal: bool = False) -> RigOptions:
    """How the rig of a study differs from an ideal one: encoders with random phases, stick-slip, delay.

    ``ideal``: true states instead of encoders and filter.
    """
    return RigOptions(feedback=near_encoder(drive), ideal_sensors=ideal, forbid_slack=True)


def with_values(loop: Loop, drive: Drive, values: Mapping[str, float], phases: np.ndarray | None) -> Loop:
    """The same law on another plant, its encoders at other phases, its delay longer by whole samples.

    Ripple of the motor's torque goes with the angle that is wanted, which the motor keeps nearly.

    ``drive``: with the best values; ``values``: quantities of the plant; ``phases``: of the encoders that are
    read, from -1/2 to 1/2; None: as they are.
    """
    options = rig_options(drive, ideal=bool(np.all(loop.rig.counts == 0.0)))
    plant = drive_with(drive, values)
    chain = plant_chain(plant, None)
    play = 0.0 if loop.cable is not None else joint_backlash(plant, chain)
    fresh = with_plant(loop, chain, options, play)
    rig = fresh.rig if phases is None else fresh.rig._replace(phases=phases)
    if "delay" in values:
        known = rig.late_samples * rig.interval + rig.late_part
        more = round((values["delay"] - known) / rig.interval)
        rig = rig._replace(late_samples=max(rig.late_samples + more, 0))
    if values.get("ripple_torque"):
        order, phase = values.get("ripple_order", RIPPLE_ORDER), values.get("ripple_phase", 0.0)
        ripple = values["ripple_torque"] * np.sin(order * loop.target[: len(rig.forces)] + phase)
        rig = rig._replace(forces=rig.forces + np.column_stack((ripple, np.zeros_like(ripple))))
    return replace(fresh, rig=rig)
