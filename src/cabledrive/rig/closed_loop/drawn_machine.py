"""The machine of an axis whose lumped chain is another one, for plants at random."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from cabledrive.mechanics.network.motion import ALONG
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route.drive import Machine, RoutedDrive
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.reduction.network_axis import as_axis
from cabledrive.reduction.quality import drive_like
from cabledrive.rig.laws.controllers import plant_chain


def machine_like(drive: Drive, chain: LumpedChain) -> Machine:
    """The machine of an axis whose lumped chain is the one given; of routes to first order."""
    return _routes_like(drive, chain) if drive.chain_of else drive_like(drive, chain)


_ROUND_OFF = 1e-9


@lru_cache(maxsize=8)
def _more(chain: LumpedChain, usual: LumpedChain, name: str) -> list[float]:
    """What one chain has more than another, round-off left out."""
    now, before = np.array([getattr(chain, name), getattr(usual, name)])
    return np.where(np.abs(now - before) > _ROUND_OFF * before.max(), now - before, 0.0).tolist()


def _routes_like(drive: Drive, chain: LumpedChain) -> RoutedDrive:
    """Ropes and joints are scaled; load and motors, by their share, get what there is more of the rest.

    What motors have not to give of less friction is taken from all that rubs before the load.
    """
    axis, machine = drive.axis, drive.axis.machine.machine
    usual, gain, motors = plant_chain(as_axis(machine, axis.load), None), abs(axis.gain), len(machine.motor)
    more = {name: _more(chain, usual, name) for name in ("inertias", "viscous", "coulomb")}

    def factor(name: str, place: int) -> float:
        now, before = (getattr(own, name)[place] for own in (chain, usual))
        return float(now / before) if before > 0.0 else 1.0

    def scaled(part: Any, **by: float) -> Any:
        """A part with some of its numbers that many times what they are; those that it lacks stay away."""
        own = {name: getattr(part, name, None) for name in by}
        return replace(part, **{name: by[name] * value for name, value in own.items() if value is not None})

    def kept(name: str, key: str) -> float:
        """Factor of friction that motors cannot make less by themselves."""
        least = min(getattr(own, key) for own in machine.motor) + more[name][0] / motors
        return 1.0 if least >= 0.0 else factor(name, 0)

    friction = {name: kept(name, f"{name}_friction") for name in ("viscous", "coulomb")}
    rubs = {"viscous_friction": friction["viscous"], "damping": friction["viscous"]}
    rubs |= {"coulomb_friction": friction["coulomb"]}

    def loaded(part: Any, name: str, mass: str, viscous: str = "") -> Any:
        if name != axis.load.removesuffix(f" {ALONG}").split(".")[0]:
            return scaled(part, **rubs)
        own = {mass: getattr(part, mass) + more["inertias"][-1] / gain**2}
        if viscous:
            own |= {viscous: chain.viscous[-1] / gain**2, "coulomb_friction": chain.coulomb[-1] / gain}
        elif max(abs(more["viscous"][-1]), abs(more["coulomb"][-1])) > 0.0:
            raise InputRefused(f"{axis.load}: a carriage has no friction to vary: make it a body")
        return replace(part, **own)

    def driving(motor: Any) -> Any:
        own = {"inertia": motor.inertia + more["inertias"][0] / motors}
        for name, by in friction.items():
            now = getattr(motor, f"{name}_friction")
            own[f"{name}_friction"] = by * now + (more[name][0] / motors if by == 1.0 else 0.0)
        return replace(scaled(motor, **joint), **own)

    between = more["inertias"][1] / motors if chain.size > 2 else 0.0
    pulleys = list(machine.pulley)
    for number in machine.driven:
        pulleys[number] = replace(pulleys[number], inertia=pulleys[number].inertia + between)
    stiffer = factor("stiffness", -1)
    rope = {"given_rigidity": stiffer, "youngs_modulus": stiffer, "axial_damping": factor("damping", -1)}
    joint = {f"joint_{name}": factor(name, 0) for name in ("stiffness", "damping") if chain.size > 2}
    names = [own.name or f"carriage {number}" for number, own in enumerate(machine.carriage)]
    return replace(
        machine,
        cable=machine.cable and scaled(machine.cable, **rope),
        route=tuple(scaled(own, **rope) for own in machine.route),
        body=tuple(
            loaded(own, own.name, "inertia" if own.pivot else "mass", "damping") for own in machine.body
        ),
        pulley=tuple(loaded(own, own.name, "inertia", "viscous_friction") for own in pulleys),
        carriage=tuple(map(loaded, machine.carriage, names, ["mass"] * len(names))),
        motor=tuple(map(driving, machine.motor)),
    )
