"""Which assumptions of the theorems did not hold in a run of the rig."""

from cabledrive.control.numbers import DARC
from cabledrive.parameters import Drive
from cabledrive.reduction.models import lumped_model
from cabledrive.rig.closed_loop.loop import Loop, Run
from cabledrive.rig.closed_loop.loop_numbers import WENT_SLACK
from cabledrive.rig.setting import RigOptions

FLEXIBLE: dict[int, tuple[str, ...]] = {1: (), 2: ("joint",), 3: ("cable",), 4: ("joint", "cable")}


def broken_assumptions(loop: Loop, drive: Drive, actual: Drive, options: RigOptions, done: Run) -> list[str]:
    """Assumptions of the theorem that did not hold in a run.

    Parameters
    ----------
    loop : Loop
    drive, actual : Drive
        As the law believes it to be, as it is.
    options : RigOptions
    done : Run

    Returns
    -------
    list of str
    """
    made, broken = loop.controller, []
    if not options.ideal_sensors:
        broken.append("states come from encoders")
    if loop.rig.late_samples or loop.rig.late_part > 0.0:
        broken.append(f"delay of {1e3 * actual.sensors.delay:.4g} ms" if actual.sensors else "delay")
    lacks = set(FLEXIBLE[plant_model(loop)]) - set(FLEXIBLE[made.model])
    if lacks:
        broken.append(f"the {' and the '.join(sorted(lacks))} of the plant bend, those of the law do not")
    if not made.damped and any(loop.chain.damping):
        broken.append("damping of the plant's joint or cable is neglected")
    if unmatched(drive, actual):
        broken.append("unmatched: what the cable drives differs from what the law believes")
    if done.state.summary[5] > 0:
        broken.append("torque at its limit")
    if loop.rig.forces.any() and loop.rig.forces[:, 1].any():
        broken.append("disturbance at the load")
    if done.state.summary[6] > 0:
        broken.append("a sensor failed")
    if loop.kinks.play > 0.0:
        broken.append("free play in the gearhead")
    if done.state.summary[9] > 0 or done.state.discrete[2] == WENT_SLACK:
        broken.append("a span went slack")
    if loop.cable is not None:
        broken.append("the cable has mass: the law leaves its own modes out")
    if made.law.kind == DARC and loop.chain.coulomb[-1] > 0.0 and loop.chain.size > 1:
        broken.append("Coulomb friction at the load")
    return broken


def unmatched(drive: Drive, actual: Drive) -> bool:
    """Whether anything but the motor's inertia, friction and offset differs between two drives.

    Parameters
    ----------
    drive, actual : Drive

    Returns
    -------
    bool
    """
    ours, theirs = lumped_model(drive), lumped_model(actual)
    return (
        ours.inertias[1:] != theirs.inertias[1:]
        or ours.stiffness != theirs.stiffness
        or ours.damping != theirs.damping
    )


def plant_model(loop: Loop) -> int:
    """Number of the model that is the plant.

    Parameters
    ----------
    loop : Loop

    Returns
    -------
    int
    """
    joint, cable = "drive" in loop.chain.names and loop.chain.size > 1, "load" in loop.chain.names
    joint = joint and loop.chain.names[0] == "motor"
    return 1 + joint + 2 * cable
