"""Models 1 to 4 of a drive: which of motor joint and cable is rigid, which is a spring."""

from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain

FLEXIBLE_JOINT = {1: False, 2: True, 3: False, 4: True}
FLEXIBLE_CABLE = {1: False, 2: False, 3: True, 4: True}


def rim_spring(drive: Drive) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] of all spans together, 2 k and 2 b_c / r of (6.11) for a loop.

    ``[lumped]``, where given: what was measured; else EA / L and the cable's own axial damping.
    """
    cable, radius = drive.cable, drive.drive_pulley.radius
    stiffness = cable.axial_rigidity / drive.span_length
    damping = cable.axial_damping / drive.span_length
    if drive.lumped is not None:
        if drive.lumped.cable_stiffness is not None:
            stiffness = drive.lumped.cable_stiffness
        if drive.lumped.cable_damping is not None:
            damping = drive.lumped.cable_damping / radius
    spans = len(drive.spans)
    return spans * stiffness, spans * damping


def highest_model(drive: Drive) -> int:
    """The most detailed model that the drive's data allow. Returns 4 with a flexible motor joint, else 3."""
    return 4 if drive.motor is not None and drive.motor.joint_stiffness is not None else 3


def lumped_model(drive: Drive, model: int | None = None) -> LumpedChain:
    """One of the Models 1 to 4 of a drive, Eqs. (6.9), (6.10), (6.11), (6.13), for any two radii.

    Parameters
    ----------
    drive : Drive
    model : {1, 2, 3, 4}, optional
        1: rigid joint and cable; 2: flexible joint; 3: flexible cable; 4: both. Default: `highest_model`.

    Returns
    -------
    LumpedChain
        Inertias in the order motor (with the drive pulley where the joint is rigid), drive, load; the motor
        on its holding stiffness where the drive has one.

    Raises
    ------
    InputRefused
        If the drive lacks what the model needs, or carries masses on its cable.
    """
    model = highest_model(drive) if model is None else model
    _check(drive, model)
    drive_pulley, load = drive.drive_pulley, drive.load_pulley
    ratio = drive_pulley.radius / load.radius
    flexible_joint, flexible_cable = FLEXIBLE_JOINT[model], FLEXIBLE_CABLE[model]
    names, rows = ["drive"], [_shaft(drive_pulley)]
    if drive.motor is not None:
        motor = (*_shaft(drive.motor), drive.motor.offset_torque)
        rows[0] = (*rows[0], 0.0)
        if flexible_joint:
            names, rows = ["motor", "drive"], [motor, rows[0]]
        else:
            names, rows = ["motor"], [tuple(a + b for a, b in zip(motor, rows[0], strict=True))]
    rows = [(*row, 0.0)[:4] for row in rows]
    j, b, c = _shaft(load)
    if flexible_cable:
        names.append("load")
        rows.append((j, b, c, 0.0))
    else:
        turned = (j * ratio**2, b * ratio**2, c * ratio, 0.0)
        rows[-1] = tuple(a + t for a, t in zip(rows[-1], turned, strict=True))
    links = []
    if flexible_joint:
        assert drive.motor is not None
        assert drive.motor.joint_stiffness is not None
        links.append((drive.motor.joint_stiffness, drive.motor.joint_damping, (1.0, 1.0)))
    if flexible_cable:
        links.append((*rim_spring(drive), (drive_pulley.radius, load.radius)))
    columns = list(zip(*rows, strict=True))
    return LumpedChain(
        names=tuple(names),
        inertias=columns[0],
        viscous=columns[1],
        coulomb=columns[2],
        offsets=columns[3],
        stiffness=tuple(link[0] for link in links),
        damping=tuple(link[1] for link in links),
        ratios=tuple(link[2] for link in links),
        holding=(drive.motor.holding_stiffness or 0.0) if drive.motor is not None else 0.0,
    )


def _shaft(part: object) -> tuple[float, ...]:
    return tuple(getattr(part, name) for name in ("inertia", "viscous_friction", "coulomb_friction"))


def _check(drive: Drive, model: int) -> None:
    if model not in FLEXIBLE_JOINT:
        raise InputRefused(f"model = {model} is none of 1, 2, 3, 4: choose one of them")
    if FLEXIBLE_JOINT[model] and (drive.motor is None or drive.motor.joint_stiffness is None):
        raise InputRefused(
            f"model {model} needs motor.joint_stiffness [N m/rad]: give it, or take model {model - 1}"
        )
    if drive.carriage:
        raise InputRefused(
            f"the lumped models do not support carriages, the drive has {len(drive.carriage)}: use `study` "
            "(guided carriage) or `simulate`"
        )
    fixed = [name for name, pulley in zip(("drive", "load"), drive.pulley, strict=True) if pulley.fixed]
    if fixed:
        raise InputRefused(
            f"the lumped models need two rotating pulleys, the {fixed[0]} pulley is fixed: use `simulate`"
        )
