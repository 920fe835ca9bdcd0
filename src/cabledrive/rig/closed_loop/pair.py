"""A pair of motors on one shaft, preloaded against each other, as a loop takes it: its law, its plants."""

from dataclasses import dataclass, replace
from math import exp, inf, sqrt
from typing import Any

import numpy as np

from cabledrive.control.flank_torque import FlankLaw, first_memory
from cabledrive.control.numbers import KALMAN, ObserverNumbers
from cabledrive.control.observers import KalmanTuning, Sampling, kalman_filter
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop_numbers import Array, RigNumbers
from cabledrive.rig.closed_loop.pair_kernels import DIFFERENCE, LEAST, MEMORY, SHAFT, PairNumbers, PairPlant
from cabledrive.rig.setting import RigOptions

PRELOAD_SHARE, MARGIN_SHARE = 0.25, 0.2
"""Preload where none is given, over the torque limit of one motor; margin over the preload."""
DAMPING = 0.7
"""Damping ratio that the law gives the difference of the motors."""
SLOWER = 0.5
"""Rate of the preload's lags, over the frequency of a motor on its joint."""
INTERNAL_STEPS = 10
SPREADS = (0.1, 0.05, 0.5, 0.2)
"""Half widths of what is drawn: stiffness, inertia, friction of motor a against motor b; backlash."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Skew:
    """How the motors of a pair differ from each other, and what its start and its encoders were.

    Attributes
    ----------
    stiffness, inertia, friction : float, default 0.0
        Of motor a more, of motor b less than their mean, as a share.
    backlash : float, default 0.0
        Of both gears beyond that of the file, as a share.
    held : float, default 0.0
        Part of the friction that held the preload off its value at the start, from -1 to 1.
    phase : float, default 0.0
        Of the second motor's encoder, in counts.
    """

    stiffness: float = 0.0
    inertia: float = 0.0
    friction: float = 0.0
    backlash: float = 0.0
    held: float = 0.0
    phase: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pair:
    """Two motors on one shaft.

    Attributes
    ----------
    law : FlankLaw
    joint : tuple of int
        See `PairNumbers`.
    backlash : float
        Of each gear, from end to end, as the file has it [rad].
    current_rate : float
        Of the torque loops [rad/s]; 0: none.
    skew : Skew
    """

    law: FlankLaw
    joint: tuple[int, int]
    backlash: float
    current_rate: float
    skew: Skew


def doubled(drive: Drive) -> Drive:
    """The drive with a second motor and gear like its own on the drive pulley.

    As long as both flanks are closed the mean of both motors is a motor of twice the size without backlash.
    Raises `InputRefused` where there is no backlash, no joint, or the motor's encoder is missing.
    """
    motor, sensors = drive.motor, drive.sensors
    if motor is None or motor.backlash <= 0.0:
        raise InputRefused(
            "pair: motor.backlash is 0: a second motor is preloaded against backlash: give it, such as "
            'backlash = "1 deg"'
        )
    if motor.joint_stiffness is None:
        raise InputRefused(
            "pair: motor.joint_stiffness is missing: the flanks close by the bending of both gears: give "
            'it, such as joint_stiffness = "135 N m/rad"'
        )
    if sensors is None or sensors.motor_encoder is None:
        raise InputRefused("pair: sensors.motor_encoder is missing: both motors are read: give its counts")
    twice: dict[str, Any] = {
        key: None if getattr(motor, key) is None else 2.0 * getattr(motor, key)
        for key in (
            "inertia", "viscous_friction", "coulomb_friction", "offset_torque", "joint_stiffness",
            "joint_damping", "torque_limit",
        )
    }  # fmt: skip
    return replace(drive, motor=replace(motor, **twice, rotor_inertia=None))


def make_pair(
    design: LumpedChain,
    drive: Drive,
    observer: ObserverNumbers,
    rig: RigNumbers,
    shafts: tuple[str, ...],
    options: RigOptions,
    sampling: Sampling,
    generator: np.random.Generator,
    *,
    other: bool,
) -> Pair:
    """The law of the preload and its sensors.

    ``design``: chain of the filter, its motor that of both; ``drive``: doubled; ``shafts``: whose encoders
    are read; ``other``: whether plant or controller is the user's own, or the plant the distributed cable.
    Raises `InputRefused` for a preload that the motors cannot hold, or a law that sees no joint.
    """
    motor = drive.motor
    assert motor is not None
    if other:
        raise InputRefused(
            "pair: its plant is the lumped chain and its law of position a packaged one: leave --plant and "
            "a controller of your own out"
        )
    knows = observer.kind == KALMAN and design.names[:2] == ("motor", "drive")
    if not knows and shafts[:2] != ("motor", "drive"):
        raise InputRefused(
            "pair: this law's filter does not know the joint of the motors, and its encoders do not show it: "
            "take a law of the whole chain, such as lqi"
        )
    stiffness = 0.5 * float(motor.joint_stiffness or 0.0)
    inertia, coulomb = 0.5 * motor.inertia, 0.5 * motor.coulomb_friction
    viscous = 0.5 * (motor.viscous_friction + motor.joint_damping)
    limit = inf if motor.torque_limit is None else 0.5 * motor.torque_limit
    preload = options.preload
    if preload is None:
        if not np.isfinite(limit):
            raise InputRefused("preload is not given, and motor.torque_limit neither: give one of the two")
        preload = PRELOAD_SHARE * limit
    if not 2.0 * coulomb < preload < limit:
        raise InputRefused(
            f"preload = {preload:.4g} N m must lie above {2.0 * coulomb:.4g} N m, twice the friction of a "
            f"motor, and below {limit:.4g} N m, its torque limit: choose it between them"
        )
    single = LumpedChain(
        names=("motor",),
        inertias=(inertia,),
        viscous=(viscous,),
        coulomb=(0.0,),
        offsets=(0.0,),
        holding=stiffness,
    )
    # Half the difference of two roundings has half the variance of one.
    counts = [float(rig.counts[0]) / sqrt(2.0) if rig.counts[0] > 0.0 else 1e-9]
    found = kalman_filter(
        single, [0], counts, sampling, chosen=[0], tuning=KalmanTuning(offsets=()), settled=True
    )
    natural = sqrt(stiffness / inertia)
    law = FlankLaw(
        observer=found,
        stiffness=stiffness,
        play=0.5 * motor.backlash,
        limit=limit,
        preload=preload,
        margin=MARGIN_SHARE * preload,
        remaining=exp(-SLOWER * natural * rig.interval),
        damper=max(2.0 * DAMPING * natural * inertia - viscous, 0.0),
        coulomb=max(coulomb, 1e-9),
    )
    random = options.encoder_phase == "random" and not options.ideal_sensors
    phase, held = generator.uniform(-0.5, 0.5), generator.uniform(-1.0, 1.0)
    return Pair(
        law=law,
        joint=(0, 1) if knows else (-1, -1),
        backlash=motor.backlash,
        current_rate=sampling.current_rate,
        skew=Skew(phase=phase if random else 0.0, held=held if random else 0.0),
    )


def drawn_pair(pair: Pair, generator: np.random.Generator) -> Pair:
    """A pair whose motors differ, with another start and another phase of the second encoder."""
    stiffness, inertia, friction, backlash = (
        spread * generator.uniform(-1.0, 1.0) for spread in SPREADS
    )  # fmt: skip
    skew = Skew(
        stiffness=stiffness,
        inertia=inertia,
        friction=friction,
        backlash=backlash,
        held=generator.uniform(-1.0, 1.0),
        phase=generator.uniform(-0.5, 0.5),
    )
    return replace(pair, skew=skew)


def pair_plant(pair: Pair, chain: LumpedChain, interval: float, twist_limit: float) -> PairPlant:
    """The plant: ``chain`` with its motor as the sum of both."""
    skew, apart = pair.skew, np.array([1.0, -1.0])

    def halves(whole: float, share: float = 0.0) -> Array:
        return 0.5 * whole * (1.0 + share * apart)

    return PairPlant(
        inertia=halves(chain.inertias[0], skew.inertia),
        viscous=halves(chain.viscous[0]),
        coulomb=halves(chain.coulomb[0], skew.friction),
        offset=halves(chain.offsets[0]),
        stiffness=halves(chain.stiffness[0], skew.stiffness),
        damping=halves(chain.damping[0]),
        play=np.full(2, 0.5 * pair.backlash * (1.0 + skew.backlash)),
        inertias=np.array(chain.inertias[1:]),
        shaft_viscous=np.array(chain.viscous[1:]),
        shaft_coulomb=np.array(chain.coulomb[1:]),
        offsets=np.array(chain.offsets[1:]),
        links=np.array(chain.stiffness[1:]),
        link_damping=np.array(chain.damping[1:]),
        current_rate=pair.current_rate,
        step=interval / INTERNAL_STEPS,
        twist_limit=twist_limit,
    )


def pair_numbers(pair: Pair, chain: LumpedChain, interval: float, twist_limit: float) -> PairNumbers:
    """The pair as its compiled loop takes it."""
    plant = pair_plant(pair, chain, interval, twist_limit)
    return PairNumbers(
        plant=plant,
        law=pair.law,
        phase=pair.skew.phase,
        start=float(_start(pair, plant)[2:].sum()) * 0.5,
        joint=np.array(pair.joint, dtype=np.int64),
    )


def pair_at_rest(pair: Pair, chain: LumpedChain, interval: float, late_samples: int) -> tuple[float, Array]:
    """Mean angle of the motors [rad], and what the loop keeps behind the states of the chain, at rest."""
    torque, _, first, second = _start(pair, pair_plant(pair, chain, interval, inf))
    kept = np.zeros(MEMORY)
    kept[DIFFERENCE], kept[SHAFT] = 0.5 * (first + second), pair.law.preload
    kept[LEAST - 2 : LEAST + 2] = torque
    return 0.5 * (first - second), np.concatenate([kept, first_memory(pair.law, late_samples)])


def _start(pair: Pair, plant: PairPlant) -> Array:
    """Torque of either flank that friction left at rest, twice [N m]; turn of each motor against it [rad]."""
    torque = pair.law.preload + pair.skew.held * float(plant.coulomb.min())
    turned = plant.play + torque / plant.stiffness
    return np.array([torque, torque, *turned])
