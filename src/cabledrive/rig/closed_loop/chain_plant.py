"""The lumped plant of the rig as its kernel takes it, its linear motion, a pair of motors."""

from dataclasses import dataclass, field, replace
from math import exp, inf, sqrt
from typing import Any

import numpy as np

from cabledrive.control.numbers import KALMAN, ObserverNumbers
from cabledrive.control.observers import FlankLaw, KalmanTuning, Sampling, first_memory, kalman_filter
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, held, state_space
from cabledrive.rig.closed_loop.chain_kernels import FLANKS, LEAST, MEMORY, ChainPlant, PairNumbers
from cabledrive.rig.setting import RigOptions

PER_RADIAN, SLOPE = 12.0, 50.0
"""Internal steps per radian of the fastest mode; K of smoothed friction c tanh(K w) [s/rad]."""


def chain_numbers(
    chain: LumpedChain,
    interval: float,
    options: RigOptions,
    *,
    rate: float = 0.0,
    links: tuple[float, float] = (0.0, inf),
    field: tuple[float, float] | None = None,
) -> ChainPlant:
    """A chain in links between equal angles; ``interval`` [s]; ``rate``: of the torque loop [rad/s], 0: none.

    ``links``: backlash of the first, twist of the last at which a span is slack [rad], which ends the run
    where that is forbidden; ``field``: of a stepper, as `Controller` has it.
    """
    (play, slack), ends, (torque, periods) = links, options.forbid_slack, field or (0.0, 0.0)
    plays, slacks = np.zeros(chain.size - 1), np.full(chain.size - 1, inf)
    if chain.size > 1:
        plays[0], slacks[-1] = 0.5 * play, inf if ends else slack
    numbers = ChainPlant(
        inertia=np.array(chain.inertias),
        viscous=np.array(chain.viscous),
        coulomb=np.array(chain.coulomb),
        offset=np.array(chain.offsets),
        stiffness=np.array(chain.stiffness, dtype=np.float64),
        damping=np.array(chain.damping, dtype=np.float64),
        play=plays,
        slack=slacks,
        phases=np.zeros(3),
        motors=1,
        current_rate=rate,
        step=interval,
        twist_limit=slack if ends else inf,
        smooth=SLOPE if options.smooth_friction else 0.0,
        field=torque,
        field_periods=periods,
    )
    return in_steps(numbers, interval, options.substeps)


def in_steps(p: ChainPlant, interval: float, substeps: int) -> ChainPlant:
    """The plant with internal steps that resolve its fastest mode, a stepper's field too, and damper."""
    springs, dampers = np.zeros(len(p.inertia)), p.viscous + p.smooth * p.coulomb
    links = np.arange(len(p.stiffness))
    for end in (links, np.maximum(links + 1, p.motors)):
        np.add.at(springs, end, p.stiffness)
        np.add.at(dampers, end, p.damping)
    springs[: p.motors] += p.field * p.field_periods
    fastest = max(np.sqrt(2.0 * (springs / p.inertia).max()), (dampers / p.inertia).max() / 4.0)
    steps = max(substeps, int(np.ceil(interval * PER_RADIAN * fastest)))
    return p._replace(step=interval / steps)


def linear_rates(chain: LumpedChain, current_rate: float) -> tuple[Array, Array]:
    """Rates of angles, speeds and shaft torque by these, (m, m), and by command, motor and load, (m, 3)."""
    n, (a, b) = chain.size, state_space(chain)
    system, inputs = np.zeros((2 * n + 1, 2 * n + 1)), np.zeros((2 * n + 1, 3))
    system[: 2 * n, : 2 * n], system[: 2 * n, 2 * n] = a, b[:, 0]
    system[2 * n, 2 * n], inputs[2 * n, 0] = -current_rate, current_rate
    inputs[: 2 * n, 1], inputs[: 2 * n, 2] = b[:, 0], b[:, -1]
    return system, inputs


def linear_step(chain: LumpedChain, interval: float, current_rate: float) -> Array:
    """The same after a sample instead of per second, motor slipping, shape (m, m + 3)."""
    return np.hstack(held(*linear_rates(chain, current_rate), interval))


PRELOAD_SHARE, MARGIN_SHARE = 0.25, 0.2
"""Preload where none is given, over the torque limit of one motor; margin over the preload."""
DAMPING = 0.7
"""Damping ratio that the law gives the difference of the motors."""
SLOWER = 0.5
"""Rate of the preload's lags, over the frequency of a motor on its joint."""
INTERNAL_STEPS = 5
SPREADS = {"stiffness": 0.1, "inertia": 0.05, "friction": 0.5, "backlash": 0.2}
"""Half widths of what is drawn: of motor a against motor b; of the backlash."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pair:
    """Two motors on one shaft."""

    law: FlankLaw
    joint: tuple[int, int]  # see `PairNumbers`
    backlash: float  # of each gear, from end to end, as the file has it [rad]
    current_rate: float  # of the torque loops [rad/s]; 0: none
    held: float  # part of the friction that held the preload off its value at the start, from -1 to 1
    phase: float  # of the second motor's encoder, in counts
    # of `SPREADS`: what motor a has more, motor b less than their mean, and the backlash of both more than
    # that of the file, as shares
    apart: dict[str, float] = field(default_factory=lambda: dict.fromkeys(SPREADS, 0.0))


def doubled(drive: Drive) -> Drive:
    """The drive with a second motor and gear like its own: as one of twice the size without backlash."""
    motor, sensors = drive.motor, drive.sensors
    if motor is None or motor.backlash <= 0.0:
        said = "pair: motor.backlash is 0: a second motor is preloaded against backlash"
        raise InputRefused(f'{said}: give it, such as backlash = "1 deg"')
    if motor.joint_stiffness is None:
        said = "pair: motor.joint_stiffness is missing: the flanks close by the bending of both gears"
        raise InputRefused(f'{said}: give it, such as joint_stiffness = "135 N m/rad"')
    if sensors is None or sensors.motor_encoder is None:
        raise InputRefused("pair: sensors.motor_encoder is missing: both motors are read: give its counts")
    keys = (
        *("inertia", "viscous_friction", "coulomb_friction", "offset_torque"),
        *("joint_stiffness", "joint_damping", "torque_limit"),
    )
    twice: dict[str, Any] = {key: 2.0 * one for key in keys if (one := getattr(motor, key)) is not None}
    return replace(drive, motor=replace(motor, **twice, rotor_inertia=None))


def make_pair(
    loop: Any, design: LumpedChain, sampling: Sampling, generator: np.random.Generator, *, other: bool
) -> Pair:
    """The law of the preload and its sensors, for a loop without them; ``design``: chain of its filter."""
    motor, options, rig = loop.spec.actual.motor, loop.spec.options, loop.rig
    if other:
        said = "pair: its plant is the lumped chain and its law of position a packaged one"
        raise InputRefused(f"{said}: leave --plant and a controller of your own out")
    knows = loop.observer.kind == KALMAN and design.names[:2] == ("motor", "drive")
    if not knows and loop.encoder_shafts[:2] != ("motor", "drive"):
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
    read = [(0, float(rig.counts[0]) / sqrt(2.0) if rig.counts[0] > 0.0 else 1e-9)]
    found = kalman_filter(single, read, sampling, chosen=[0], tuning=KalmanTuning(offsets=()), settled=True)
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
        coulomb=coulomb,
    )
    random = options.encoder_phase == "random" and not options.ideal_sensors
    phase, held = generator.uniform(-0.5, 0.5), generator.uniform(-1.0, 1.0)
    return Pair(
        law=law,
        joint=(0, 1) if knows else (-1, -1),
        backlash=motor.backlash,
        current_rate=sampling.current_rate,
        phase=phase if random else 0.0,
        held=held if random else 0.0,
    )


def drawn_pair(pair: Pair, generator: np.random.Generator) -> Pair:
    """A pair whose motors differ, with another start and another phase of the second encoder."""
    drawn = {name: spread * generator.uniform(-1.0, 1.0) for name, spread in SPREADS.items()}
    held, phase = generator.uniform(-1.0, 1.0), generator.uniform(-0.5, 0.5)
    return replace(pair, apart=drawn, held=held, phase=phase)


def pair_plant(pair: Pair, plant: ChainPlant, interval: float) -> ChainPlant:
    """The plant with its motor and first link as two of half the size, by so much apart."""
    apart, signs = pair.apart, np.array([1.0, -1.0])

    def halves(whole: Array, share: float = 0.0) -> Array:
        return np.concatenate((0.5 * whole[0] * (1.0 + share * signs), whole[1:]))

    play = np.full(2, 0.5 * pair.backlash * (1.0 + apart["backlash"]))
    made = plant._replace(
        inertia=halves(plant.inertia, apart["inertia"]),
        viscous=halves(plant.viscous),
        coulomb=halves(plant.coulomb, apart["friction"]),
        offset=halves(plant.offset),
        stiffness=halves(plant.stiffness, apart["stiffness"]),
        damping=halves(plant.damping),
        play=np.concatenate((play, plant.play[1:])),
        slack=np.concatenate((np.full(2, inf), plant.slack[1:])),
        motors=2,
        current_rate=pair.current_rate,
    )
    return in_steps(made, interval, INTERNAL_STEPS)


def pair_numbers(pair: Pair | None, plant: ChainPlant, observer: ObserverNumbers) -> PairNumbers:
    """Law and sensors, without a record; ``plant``: of the pair; None: one motor."""
    if pair is None:  # what is not there is zero, its observer any
        law = FlankLaw(observer, *np.zeros(8).tolist())
        return PairNumbers(law, 0.0, 0.0, np.zeros(2, dtype=np.int64), np.zeros((0, 6)))
    start = 0.5 * float(_turned(pair, plant).sum())
    return PairNumbers(pair.law, pair.phase, start, np.array(pair.joint), np.zeros((0, 6)))


def pair_at_rest(pair: Pair, plant: ChainPlant, late_samples: int) -> Array:
    """State in which a run begins: angles, speeds, torques, and what the loop keeps behind them."""
    n, turned = len(plant.inertia), _turned(pair, plant)
    kept = np.zeros(2 * n - 1 + MEMORY)
    kept[:2], kept[2 * n : 2 * n + 2] = turned * (1.0, -1.0), pair.law.preload * np.array([1.0, -1.0])
    for place in (FLANKS, LEAST):
        kept[2 * n - 1 + place : 2 * n + 1 + place] = _held(pair, plant)
    return np.concatenate((kept, first_memory(pair.law, late_samples)))


def _held(pair: Pair, plant: ChainPlant) -> float:
    """Torque of either flank that friction left at rest [N m]."""
    return pair.law.preload + pair.held * float(plant.coulomb[:2].min())


def _turned(pair: Pair, plant: ChainPlant) -> Array:
    """Turn of each motor against its flank at rest [rad]."""
    return plant.play[:2] + _held(pair, plant) / plant.stiffness[:2]
