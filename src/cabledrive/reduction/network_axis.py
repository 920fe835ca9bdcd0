r"""An axis of a machine with routes as a drive for control: its chain, friction, slack torque and sensors.

The drive is the loop round two pulleys that has the same lumped chain: with the motor pulley's radius r,
the stiffness k and damping d of its last link, spans of :math:`k/2r^2` and :math:`b_c = d/2r`, and a
tension :math:`\tau_s/2r` that vanishes at the torque :math:`\tau_s` at which the machine's first span goes
slack.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from cabledrive.mechanics.holding import FREE
from cabledrive.mechanics.network.assembly import Network, network_of, relative_turn, rotor_turn
from cabledrive.mechanics.network.motion import ALONG
from cabledrive.modal.mode import LONGITUDINAL
from cabledrive.modal.natural import straight_limit
from cabledrive.parameters import Cable, Drive, InputRefused, Layout, Lumped, Machine, Motor, Pulley
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.drive import Axis
from cabledrive.parameters.route.parts import RoutedMotor
from cabledrive.reduction.lumped_chain import first_order
from cabledrive.reduction.network_chain import MOST_CROSS, NetworkChain, modes_at_rest, network_chains
from cabledrive.reduction.two_motors import is_winched

_NO_MASS = 1e-12
"""Mass per length of the chain's cable, whose mass its inertias hold [kg/m]."""


class NoChain(InputRefused):
    """No axis of a machine with routes is a lumped chain, so that there is no controller for it."""


def as_axis(drive: Machine | Drive, axis: str | None = None) -> Drive:
    """A drive for control: as it is, or the axis of a machine whose load is named, as "head.x".

    Without a name the first that is a chain, else its two pulleys. Refused: none, or its load not at its end.
    """
    if drive.plant is not None and axis in (None, drive.plant.axis.load):
        return drive.plant
    if axis is None and is_winched(drive):
        raise NoChain(
            'kind = "route": two winches move a body, by one law, and no axis: run `cabledrive track DRIVE '
            "--draws 100` (cd.track); compare, study, export and experiment take an axis that one motor moves"
        )
    machine = drive.machine
    try:
        chains = network_chains(machine.plain)
        found = [chain for chain in chains if axis in (None, chain.load)]
        if not found:
            known = ", ".join(chain.load for chain in chains)
            raise InputRefused(f'axis = "{str(axis)[:60]}" is no axis of this machine: take {known}')
        chosen = next((chain for chain in found if chain.refusal is None), found[0])
        if chosen.refusal is not None:
            raise NoChain(f"no lumped chain: {chosen.refusal}")
        return axis_drive(chosen)
    except InputRefused as refusal:
        if axis is None and machine.two_pulleys is not None:  # whose chains leave a heavy cable out
            return machine.two_pulleys
        raise type(refusal)(f'kind = "{machine.kind}": {refusal}') from None


def axis_drive(chain: NetworkChain) -> Drive:
    """The drive for control of a chain whose load is its end."""
    machine = chain.network.drive
    held = np.abs(chain.network.statics.torques)[list(machine.driven)].tolist()
    motors = [_left_by_weight(*own) for own in zip(machine.motor, held, strict=True)]
    joint = motors[0].joint_stiffness is not None
    radius, gain = machine.pulley[machine.driven[0]].radius, abs(chain.gain)
    motion = chain.network.motion
    carriages = [f"{motion.carriage_name(number)} {ALONG}" for number in range(len(machine.carriage))]
    slides = chain.load in carriages or chain.load.endswith((".x", ".y", f".{ALONG}"))
    (viscous, coulomb), (load_viscous, load_coulomb) = _friction(chain, slides)
    inertia = sum(motor.inertia for motor in motors)
    first = chain.inertias[0]
    if not joint:  # of the inertia of the rigid joint only the sum counts
        inertia = min(inertia, 0.9 * first)
    per_load = 1.0 if slides else 1.0 / gain
    stiffness = float(chain.stiffness[-1])
    return Drive(
        name=machine.name,
        kind="loop",
        title=f"{machine.title or machine.name}: axis of {chain.load}",
        source=machine.source,
        cable=Cable(
            given_rigidity=stiffness / (2.0 * radius**2),
            mass_per_length=_NO_MASS,
            pretension=slack_torque(chain) / (2.0 * radius),
        ),
        layout=Layout(span_length=1.0),
        pulley=(
            Pulley(
                radius=radius,
                inertia=float(chain.inertias[1] if joint else first - inertia),
                viscous_friction=viscous,
                coulomb_friction=coulomb,
            ),
            Pulley(
                radius=radius * per_load,
                inertia=float(chain.inertias[-1]) * per_load**2,
                viscous_friction=load_viscous,
                coulomb_friction=load_coulomb,
            ),
        ),
        motor=_motor(motors, float(first) if joint else inertia, chain),
        lumped=Lumped(
            cable_stiffness=stiffness / (2.0 * radius**2), cable_damping=_link_damping(chain) / (2.0 * radius)
        ),
        sensors=machine.sensors,
        goal=machine.goal,
        chain_of=Axis(
            machine=machine,
            load=chain.load,
            gain=chain.gain,
            slides=slides,
            words=chain_words(chain)
            | {"slack_torque": slack_torque(chain), "slides": slides}
            | ({"held_torque": max(held)} if max(held) > 1e-9 * slack_torque(chain) else {}),
        ),
    )


def cross_motion(drive: Drive, torque: Array, interval: float) -> dict[str, Any] | None:
    """What a chain neglects along a torque where the axes of a machine couple; None where they do not.

    The machine of `modes_at_rest` under the same torque with the other axis' motors free and held, against
    that with its load at rest as well. Coulomb friction, which holds the other axis, is left out.
    ``torque``, shape (samples,): of all motors [N m]; ``interval`` [s]. Returns the other axis' coordinate,
    its largest motion and how far the load is off [m], [rad], each with motors free and held.
    """
    axis = drive.axis
    if not axis.words.get("coupled"):
        return None
    from scipy.signal import StateSpace, lsim

    other, motors = axis.words["other"], axis.words["motors"]
    network = network_of(axis.machine, motor=FREE)
    turn = motor_turn(network, motors)
    signs = dict(zip(motors, (1.0, -next(reversed(motors.values()))), strict=True))
    held, place = motor_turn(network, signs), network.motion.dense(other)[0]
    damping = network.rope_damping + network.dampers.matrix
    seen = network.motion.dense(axis.load, other)

    def motion(at_rest: Array) -> Array:
        """Motion of load and other load from rest, with rows held; (samples, 2)."""
        squares, shapes = modes_at_rest(network, at_rest)
        rates, _ = first_order(np.diag(squares), shapes.T @ damping @ shapes, np.ones(squares.size))
        force = np.append(np.zeros_like(squares), turn @ shapes)[:, None]
        output = np.hstack([seen @ shapes, np.zeros((len(seen), squares.size))])
        system = StateSpace(rates, force, output, np.zeros((len(seen), 1)))
        return np.asarray(lsim(system, torque, interval * np.arange(torque.size), interp=False)[1])

    still = motion(np.vstack([held, place]))
    both = motion(np.zeros((0, turn.size))), motion(held[None])
    return {
        "other": other,
        "motion": [float(np.abs(one[:, 1]).max()) for one in both],
        "load": [float(np.abs(one[:, 0] - still[:, 0]).max()) for one in both],
    }


def axis_notes(drive: Drive) -> tuple[str, ...]:
    """What the numbers of an exported axis of a machine with routes mean; none for any other drive."""
    if not drive.chain_of:
        return ()
    axis = drive.chain_of
    unit = "m/rad, and its angle here is its place over that" if axis.slides else "rad/rad"
    coupled = [axis.words["coupled"]] if axis.words["coupled"] else []
    return (
        f"axis {axis.load} of a machine, {axis.gain:.6g} {unit}; lumped chain, links linear",
        f"slack from {axis.words['slack_torque']:.4g} N m on either way, where the first span can be slack",
        *coupled,
    )


def axis_words(drive: Drive, **more: Any) -> dict[str, Any]:
    """What results say of an axis of a machine with routes, under "axis"; nothing of any other drive."""
    return {"axis": drive.axis.words | more} if drive.chain_of else {}


def chain_words(chain: NetworkChain) -> dict[str, Any]:
    """What a result says of the chain."""
    coupled = None  # what of the other axis the chain leaves out
    if chain.other is not None and chain.cross > MOST_CROSS:
        coupled = (
            f"{chain.load} and {chain.other} couple: the other axis' motors turn by {100 * chain.cross:.3g} "
            f"% of this one's as it vibrates, and the chain takes {chain.other} as at rest"
        )
    return {
        "load": chain.load,
        "motors": chain.motors,
        "gain": chain.gain,
        "inertias": chain.inertias.tolist(),
        "stiffness": chain.stiffness.tolist(),
        "load_row": chain.load_row.tolist(),
        "off_the_end": chain.off_the_end,
        "coupling": chain.cross,
        "other": chain.other,
        "coupled": coupled,
        "frequencies_hz": chain.frequencies.tolist(),
        "neglected": chain.neglected,
        "neglected_strings": chain.strings,
        "reason": chain.refusal,
        "sag": coupled  # whose modes are those of straight ropes that stretch evenly
        and straight_limit(chain.network, 4 * np.pi * chain.frequencies[0], kind=LONGITUDINAL),
    }


def slack_torque(chain: NetworkChain) -> float:
    """Torque of the motor against a held load at which the first span has no tension left [N m]."""
    network = chain.network
    turn, load = motor_turn(network, chain.motors), network.motion.dense(chain.load)[0]
    motion = held_motion(network, load[None, :], turn, np.zeros(1))
    return float(1.0 / np.max(np.abs(network.pull @ motion) / network.lowest_tension))


def held_motion(network: Network, rows: Array, force: Array, held: Array) -> Array:
    """Coordinates at rest under a force, (n,), where rows of them, (k, n), are held at some places, (k,).

    Of two axes the other one is free to move and does not: least squares leave it where it is.
    """
    bordered = np.block([[network.static_stiffness, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    return np.asarray(np.linalg.lstsq(bordered, np.append(force, held), rcond=1e-12)[0][: force.size])


def motor_turn(network: Network, motors: dict[str, float], *, rotors: bool = True) -> Array:
    """Row of the motor angle of an axis, shape (n,): the mean of its motors', or of the pulleys they drive.

    ``motors``: sign by pulley.
    """
    names, turn = [pulley.name for pulley in network.drive.pulley], rotor_turn if rotors else relative_turn
    turns = (sign * turn(network.motion, names.index(name)) for name, sign in motors.items())
    return np.asarray(network.motion.dense(*turns).mean(axis=0))


def _left_by_weight(motor: RoutedMotor, held: float) -> RoutedMotor:
    """A motor with what is left of its torque by what it holds at rest [N m], either way."""
    limit = motor.torque_limit
    if limit is None or held <= 1e-9 * limit:
        return motor
    if held >= limit:
        said = f"motor.torque_limit = {limit:.4g} N m of {motor.pulley or 'the first pulley'}: it has to hold"
        raise InputRefused(f"{said} {held:.4g} N m at rest, by weights or the pull of its rope: raise it")
    return replace(motor, torque_limit=limit - held)


def _motor(motors: list[RoutedMotor], inertia: float, chain: NetworkChain) -> Motor:
    """All motors of an axis as one; each takes the same torque, so the weakest one limits it."""
    first, machine = motors[0], chain.network.drive
    own = {
        name: [getattr(motor, name) for motor in motors if getattr(motor, name) is not None]
        for name in Motor.__dataclass_fields__
    }
    least: dict[str, Any] = {name: min(values) if values else None for name, values in own.items()}
    total = {name: float(sum(values)) for name, values in own.items()}
    shared = ("torque_limit", "torque_per_volt")
    signs = [chain.motors[machine.pulley[number].name] for number in machine.driven]
    return Motor(
        inertia=inertia,
        offset_torque=float(sum(sign * m.offset_torque for sign, m in zip(signs, motors, strict=True))),
        joint_stiffness=float(chain.stiffness[0]) if first.joint_stiffness is not None else None,
        gear_ratio=first.gear_ratio,
        holding_stiffness=total["holding_stiffness"] or None,
        backlash=max(own["backlash"]),
        **{name: total[name] for name in ("viscous_friction", "coulomb_friction", "joint_damping")},
        **{name: least[name] and len(motors) * least[name] for name in shared},
        **{name: least[name] for name in ("speed_limit", "current_bandwidth")},
    )


def _friction(chain: NetworkChain, slides: bool) -> tuple[tuple[float, float], tuple[float, float]]:
    """Viscous and Coulomb friction of the rest at the motor and of the load at its angle, by rigid motion."""
    network, machine, motion = chain.network, chain.network.drive, chain.network.motion
    rigid = chain.shapes[:, 0] / float(motor_turn(network, chain.motors) @ chain.shapes[:, 0])
    own = motion.unit(chain.load)
    scale = abs(chain.gain) if slides else 1.0  # load angle of a slide: its place over the gain
    found = [
        (body.damping, body.coulomb_friction, motion.unit(f"{body.name}.{move}"))
        for body in machine.body
        for move in body.moves
    ]
    found += [
        (pulley.viscous_friction, pulley.coulomb_friction, relative_turn(motion, number))
        for number, pulley in enumerate(machine.pulley)
        if not pulley.fixed
    ]
    total = np.zeros((2, 2))  # of the rest and of the load; motors have their own
    for viscous, coulomb, row in found:
        at_load = row == own
        moved = scale if at_load else abs(float((motion.dense(row) @ rigid)[0]))
        total[int(at_load)] += viscous * moved**2, coulomb * moved
    (viscous, coulomb), (load_viscous, load_coulomb) = total.tolist()
    return (viscous, coulomb), (load_viscous, load_coulomb)


def _link_damping(chain: NetworkChain) -> float:
    """Damper of the last link that loses in the first mode what the ropes lose in it [N m s/rad]."""
    stiffness = np.zeros((chain.inertias.size, chain.inertias.size))
    for i, k in enumerate(chain.stiffness):
        stiffness[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    root = 1.0 / np.sqrt(chain.inertias)
    vectors = np.linalg.eigh(root[:, None] * stiffness * root)[1] * root[:, None]
    stretch = float(vectors[-1, 1] - vectors[-2, 1])  # of the last link in the first mode [rad]
    shape = chain.shapes[:, 1]
    return float(shape @ chain.network.rope_damping @ shape) / stretch**2
