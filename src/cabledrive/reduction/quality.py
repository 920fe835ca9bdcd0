"""How good a model of few inertias is: frequencies and response beside the distributed cable's."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cabledrive.mechanics.holding import FREE, released
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.response import network_response
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import Drive, Lumped, Machine
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.reduction import lumped_chain as chains
from cabledrive.reduction.network_axis import as_axis, motor_turn

LOWEST_HZ, HIGHEST_HZ, POINTS = 0.05, 2000.0, 6000


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelQuality:
    """One model beside the distributed cable."""

    model: int
    frequencies: tuple[float, ...]  # its undamped natural frequencies [Hz]
    exact: tuple[float, ...]  # as many of the distributed drive [Hz]
    holds_1: float  # up to where its response from motor torque to load angle is right to 1 % [Hz]
    holds_5: float  # the same to 5 % [Hz]


def distributed(drive: Drive) -> Machine:
    """The machine with its spans: of a chain of routes as in its file, else with the EA / L of the models."""
    if drive.chain_of:
        return drive.chain_of.machine
    stiffness, damping = (value / len(drive.spans) for value in chains.rim_spring(drive))
    length = drive.span_length
    cable = replace(drive.cable.with_rigidity(stiffness * length), axial_damping=damping * length)
    return replace(drive, cable=cable, lumped=None).machine


def machine_like(drive: Drive, chain: chains.LumpedChain) -> Machine:
    """Two pulleys whose lumped chain is the one given, its cable's stiffness and damping those of its EA."""
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


def exact_frequencies(drive: Drive, count: int) -> Array:
    """Lowest natural frequencies of the distributed machine along a drive's axis, at most ``count`` [Hz]."""
    known = drive.axis.words.get("frequencies_hz")  # not the modes of another axis
    return np.array(known[:count]) if known else natural_frequencies(distributed(drive), count=count)


def distributed_response(drive: Drive, omega: Array, *, angle_of: str = "load") -> Complex:
    """Response from motor torque to an angle of the linear distributed drive, friction viscous, rotor free.

    ``drive``: stiffness and damping of its cable as the models have them; ``omega``, shape (m,) [rad/s], not
    zero; ``angle_of``, {"load", "motor"}: the motor's is the drive pulley's where there is none, or its joint
    is rigid; that of a load that slides is its place over the gain.
    Returns shape (m,) [rad/(N m)].
    """
    level, axis = replace(drive, layout=replace(drive.layout, gravity=0.0)), drive.axis
    network = network_of(distributed(level), motor=FREE)
    # The torque is that of all motors together, their angle the mean of theirs: one row for both.
    turn, load = (
        motor_turn(network, axis.words["motors"]),
        network.motion.dense(axis.load)[0] / axis.per_angle,
    )
    return network_response(network, omega, turn, (turn if angle_of == "motor" else load)[None])[:, 0]


def model_response(drive: Drive, model: int, omega: Array) -> Complex:
    """Response from motor torque to load angle [rad/(N m)] of one of the Models 1 to 4; ``omega`` [rad/s]."""
    chain = chains.lumped_model(drive, model)
    angle = chains.speed_response(chain, omega, speed_of=chain.size - 1) / (1j * omega)
    rigid_cable = "load" not in chain.names
    ratio = drive.drive_pulley.radius / drive.load_pulley.radius if rigid_cable else 1.0
    return np.asarray(angle * ratio, dtype=np.complex128)


def model_quality(drive: Drive) -> tuple[ModelQuality, ...]:
    """Every model that the drive's data allow, beside its distributed cable.

    Of an axis of a machine with routes: the chain of the machine as its file gives it.
    """
    drive = released(as_axis(drive.axis.machine, drive.axis.load))
    hertz = np.geomspace(LOWEST_HZ, HIGHEST_HZ, POINTS)
    omega = 2.0 * pi * hertz
    exact = distributed_response(drive, omega)
    models = (1, 2, 3, 4) if chains.highest_model(drive) == 4 else (1, 3)
    found = []
    for model in models:
        own = chains.natural_frequencies_of(chains.lumped_model(drive, model)) / (2.0 * pi)
        error = np.abs(model_response(drive, model, omega) / exact - 1.0)
        skipped = 1 if model == 2 else 0  # Model 2 has the joint's mode, others count from the lowest
        exact_hz = exact_frequencies(drive, own.size + skipped)[skipped:] if own.size else ()
        found.append(
            ModelQuality(
                model=model,
                frequencies=tuple(float(f) for f in own),
                exact=tuple(float(f) for f in exact_hz),
                holds_1=_until(hertz, error, 0.01),
                holds_5=_until(hertz, error, 0.05),
            )
        )
    return tuple(found)


def _until(hertz: Array, error: Array, tolerance: float) -> float:
    """Frequency below which an error stays within a tolerance."""
    beyond = np.flatnonzero(error > tolerance)
    if not beyond.size:
        return float(hertz[-1])
    return float(hertz[max(beyond[0] - 1, 0)])
