"""The machine of an axis whose lumped chain is another one, for plants at random."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, Lumped
from cabledrive.parameters.route.drive import Machine, RoutedDrive
from cabledrive.parameters.route.two_pulleys import as_machine
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.quality import distributed
from cabledrive.rig.laws.controllers import plant_chain


def machine_like(drive: Drive, chain: LumpedChain) -> Machine:
    """The machine of an axis whose lumped chain is the one given; of routes to first order."""
    return _routes_like(drive, chain) if drive.chain_of else _loop_like(drive, chain)


@lru_cache(maxsize=8)
def _chain_of(machine: Machine, load: str) -> LumpedChain:
    """The chain of an axis as its file has it."""
    return plant_chain(as_axis(machine, load), None)


def _routes_like(drive: Drive, chain: LumpedChain) -> RoutedDrive:
    """Ropes and friction before the load are scaled; load and motors, by their share, get what is more."""
    axis, machine = drive.axis, as_machine(drive.axis.machine)
    usual = _chain_of(machine, axis.load)
    gain, named, motors = abs(axis.gain), axis.load.split(".")[0], len(machine.motor)
    heavier = np.subtract(chain.inertias, usual.inertias)

    def factor(name: str, place: int) -> float:
        now, before = (getattr(own, name)[place] for own in (chain, usual))
        return float(now / before) if before > 0.0 else 1.0

    def scaled(part: Any, **by: float) -> Any:
        """A part with some of its numbers that many times what they are; those that it lacks stay away."""
        own = {name: getattr(part, name, None) for name in by}
        return replace(part, **{name: by[name] * value for name, value in own.items() if value is not None})

    def loaded(part: Any, mass: str, friction: str = "") -> Any:
        if part.name != named:
            return scaled(part, **rubs)
        own = {mass: getattr(part, mass) + float(heavier[-1]) / gain**2}
        if friction:
            own |= {friction: chain.viscous[-1] / gain**2, "coulomb_friction": chain.coulomb[-1] / gain}
        return replace(part, **own)

    def driving(motor: Any) -> Any:
        own = {"inertia": motor.inertia + float(heavier[0]) / motors}
        for name, key in (("viscous", "viscous_friction"), ("coulomb", "coulomb_friction")):
            more = getattr(chain, name)[0] / motors if getattr(usual, name)[0] == 0.0 else 0.0
            own[key] = factor(name, 0) * getattr(motor, key) + more
        return replace(scaled(motor, **joint), **own)

    stiffer = factor("stiffness", -1)
    rope = {"given_rigidity": stiffer, "youngs_modulus": stiffer, "axial_damping": factor("damping", -1)}
    viscous, coulomb = factor("viscous", 0), factor("coulomb", 0)
    rubs = {"viscous_friction": viscous, "damping": viscous, "coulomb_friction": coulomb}
    flexible = chain.size > 2
    joint = {f"joint_{name}": factor(name, 0) for name in ("stiffness", "damping") if flexible}
    return replace(
        machine,
        cable=machine.cable and scaled(machine.cable, **rope),
        route=tuple(scaled(own, **rope) for own in machine.route),
        body=tuple(loaded(own, "inertia" if own.pivot else "mass", "damping") for own in machine.body),
        pulley=tuple(loaded(own, "inertia", "viscous_friction") for own in machine.pulley),
        carriage=tuple(loaded(own, "mass") for own in machine.carriage),
        motor=tuple(map(driving, machine.motor)),
    )


def _loop_like(drive: Drive, chain: LumpedChain) -> Drive:
    """A drive whose lumped chain is the one given, its cable's stiffness and damping those of its EA."""
    first, second = drive.pulley
    gear, spans = second.radius / first.radius, len(drive.spans)
    load = replace(
        second,
        inertia=chain.inertias[-1] * gear**2,
        viscous_friction=chain.viscous[-1] * gear**2,
        coulomb_friction=chain.coulomb[-1] * gear,
    )
    motor = drive.motor
    if motor is not None:
        rigid = motor.joint_stiffness is None
        own = replace(
            motor,
            inertia=chain.inertias[0] - (first.inertia if rigid else 0.0),
            viscous_friction=chain.viscous[0] - (first.viscous_friction if rigid else 0.0),
            coulomb_friction=chain.coulomb[0] - (first.coulomb_friction if rigid else 0.0),
            offset_torque=chain.offsets[0],
        )
        if not rigid:
            own = replace(own, joint_stiffness=chain.stiffness[0], joint_damping=chain.damping[0])
            first = replace(first, inertia=chain.inertias[1])
        motor = own
    else:
        first = replace(first, inertia=chain.inertias[0])
    lumped = Lumped(
        cable_stiffness=chain.stiffness[-1] / (spans * first.radius**2),
        cable_damping=chain.damping[-1] / (spans * first.radius),
    )
    return distributed(replace(drive, pulley=(first, load), motor=motor, lumped=lumped))
