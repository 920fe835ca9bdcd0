"""What the user gives as plant: a lumped chain, or an object of the plant protocol."""

from typing import Any

import numpy as np

from cabledrive.mechanics.holding import released
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, highest_model, lumped_model, reflected
from cabledrive.rig.closed_loop.own_plant import OwnPlant, checked_plant
from cabledrive.rig.laws.fitting import fitted_encoders, load_gear
from cabledrive.rig.setting import RigOptions


def models_of(drive: Drive) -> tuple[LumpedChain, ...]:
    """The lumped models of a drive under torque control, in angles of its first shaft."""
    numbers = (1, 2, 3, 4) if highest_model(drive) == 4 else (1, 3)
    return tuple(reflected(lumped_model(released(drive), number))[0] for number in numbers)


def user_plant(drive: Drive, given: Any, options: RigOptions) -> tuple[LumpedChain, OwnPlant | None, str]:
    """The lumped chain that names the shafts, the plant where it is no lumped chain, and its name.

    Raises `InputRefused` if the plant does not fit the drive's encoders, gear or the options.
    """
    if isinstance(given, LumpedChain):
        chain = _at_first_shaft(drive, given)
        return chain, None, f"lumped chain of {chain.size} inertias: {', '.join(chain.names)}"
    plant = checked_plant(given)
    if options.smooth_friction:
        raise InputRefused(
            f'smooth_friction is about the packaged plants; "{plant.name}" has its own friction: leave it out'
        )
    for chain in models_of(drive):
        if chain.names == plant.shafts:
            return chain, plant, plant.name
    known = " or ".join(str(chain.names) for chain in models_of(drive) if chain.size > 1)
    raise InputRefused(
        f'plant "{plant.name}": shafts = {plant.shafts} are those of no model of {drive.name}: take {known}'
    )


def _at_first_shaft(drive: Drive, given: LumpedChain) -> LumpedChain:
    """The chain in angles of its first shaft; as given where it is so already."""
    if given.holding > 0.0:
        raise InputRefused(
            f"plant.holding = {given.holding:.4g} N m/rad: under torque control the motor turns freely: set 0"
        )
    chain, gears = reflected(given)
    gear = load_gear(drive)
    if not (np.isclose(gears[-1], 1.0, rtol=1e-9) or np.isclose(gears[-1], gear, rtol=1e-9)):
        raise InputRefused(
            f"plant.ratios make {gears[-1]:.6g} turns of the first shaft a turn of the load, r2 / r1 of the "
            f"drive is {gear:.6g}: give that, or all in angles of the first shaft"
        )
    of_a_model = chain.names in [one.names for one in models_of(drive)]
    if not of_a_model and (chain.names[-1] != "load" or chain.names[0] not in ("motor", "drive")):
        raise InputRefused(
            f"plant.names = {chain.names} must begin with motor and end with load: name them so"
        )
    if chain.size > 2 and "drive" in fitted_encoders(drive) and "drive" not in chain.names:
        raise InputRefused(
            f"plant.names = {chain.names} lack the drive pulley, whose encoder is read: name it drive"
        )
    return chain
