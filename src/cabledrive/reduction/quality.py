"""How good a model of few inertias is: frequencies and response beside the distributed cable's."""

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cabledrive.mechanics.holding import LOAD_PULLEY, released
from cabledrive.mechanics.network import network_of
from cabledrive.mechanics.network.assembly import network_response, rotor_turn
from cabledrive.modal import natural_frequencies
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.parameters.route.two_pulleys import AxisDrive, as_machine
from cabledrive.reduction.lumped_chain import (
    highest_model,
    lumped_model,
    natural_frequencies_of,
    rim_spring,
    speed_response,
)
from cabledrive.reduction.network_axis import as_axis, response_of_axis

LOWEST_HZ, HIGHEST_HZ, POINTS, POINTS_OF_AXIS = 0.05, 2000.0, 6000, 1500


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelQuality:
    """One model beside the distributed cable."""

    model: int
    frequencies: tuple[float, ...]  # its undamped natural frequencies [Hz]
    exact: tuple[float, ...]  # as many of the distributed drive [Hz]
    holds_1: float  # up to where its response from motor torque to load angle is right to 1 % [Hz]
    holds_5: float  # the same to 5 % [Hz]


def with_measured_stiffness(drive: Drive) -> Drive:
    """The distributed drive whose EA / L is the stiffness that the models have."""
    stiffness, damping = (value / len(drive.spans) for value in rim_spring(drive))
    length = drive.span_length
    cable = replace(drive.cable.with_rigidity(stiffness * length), axial_damping=damping * length)
    return replace(drive, cable=cable, lumped=None)


def distributed_response(drive: Drive, omega: Array, *, angle_of: str = "load") -> Complex:
    """Response from motor torque to an angle of the linear distributed drive, friction viscous.

    ``drive``: without carriages; stiffness and damping of its cable as the models have them; ``omega``, shape
    (m,) [rad/s], not zero; ``angle_of``, {"load", "motor"}: the motor's is the drive pulley's where there is
    none, or its joint is rigid.
    Returns shape (m,) [rad/(N m)].
    """
    if isinstance(drive, AxisDrive):
        return response_of_axis(drive, omega, angle_of=angle_of)
    level = replace(drive.layout, gravity=0.0)
    network = network_of(as_machine(replace(with_measured_stiffness(drive), layout=level)))
    turn, load = rotor_turn(network.motion, 0), network.motion.unit(LOAD_PULLEY)
    return network_response(network, omega, turn, (turn if angle_of == "motor" else load)[None])[:, 0]


def model_response(drive: Drive, model: int, omega: Array) -> Complex:
    """Response from motor torque to load angle [rad/(N m)] of one of the Models 1 to 4; ``omega`` [rad/s]."""
    chain = lumped_model(drive, model)
    angle = speed_response(chain, omega, speed_of=chain.size - 1) / (1j * omega)
    rigid_cable = "load" not in chain.names
    ratio = drive.drive_pulley.radius / drive.load_pulley.radius if rigid_cable else 1.0
    return np.asarray(angle * ratio, dtype=np.complex128)


def model_quality(drive: Drive) -> tuple[ModelQuality, ...]:
    """Every model that the drive's data allow, beside its distributed cable.

    Of an axis of a machine with routes: the chain of the machine as its file gives it.
    """
    if isinstance(drive, AxisDrive):
        drive = released(as_axis(drive.machine, drive.load))
    hertz = np.geomspace(LOWEST_HZ, HIGHEST_HZ, POINTS_OF_AXIS if isinstance(drive, AxisDrive) else POINTS)
    omega = 2.0 * pi * hertz
    exact = distributed_response(drive, omega)
    models = (1, 2, 3, 4) if highest_model(drive) == 4 else (1, 3)
    found = []
    for model in models:
        own = natural_frequencies_of(lumped_model(drive, model)) / (2.0 * pi)
        error = np.abs(model_response(drive, model, omega) / exact - 1.0)
        beside = _beside(drive, model, own)
        found.append(
            ModelQuality(
                model=model,
                frequencies=tuple(float(f) for f in own),
                exact=beside,
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


def _beside(drive: Drive, model: int, own: Array) -> tuple[float, ...]:
    """Exact frequencies for a model's: Model 2 has the joint's mode, others count from the lowest."""
    if own.size == 0:
        return ()
    skipped = 1 if model == 2 else 0
    if isinstance(drive, AxisDrive):  # not the modes of another axis
        exact = np.array(drive.words["frequencies_hz"])
    else:
        exact = natural_frequencies(with_measured_stiffness(drive), count=own.size + skipped)
    return tuple(float(f) for f in exact[skipped : skipped + own.size])
