"""A closed loop of the damping-aware law on a lumped chain of any length, without a drive file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from cabledrive.control.darc import darc_numbers
from cabledrive.control.darc_gains import Bounds, DarcGains
from cabledrive.control.difference import ideal_states
from cabledrive.control.flat_output import flat_output
from cabledrive.control.kalman import KalmanTuning, Sampling, kalman_filter
from cabledrive.control.observer_numbers import ObserverNumbers
from cabledrive.control.reference import flat_reference
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop import Loop
from cabledrive.rig.closed_loop.loop_numbers import RigNumbers
from cabledrive.rig.closed_loop.loop_plants import plant_parts
from cabledrive.rig.laws.controllers import Controller
from cabledrive.rig.setting import RigOptions
from cabledrive.trajectories import Trajectory


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainRig:
    """Sensors and sampling of a lumped chain.

    Attributes
    ----------
    interval : float
        Sample time [s].
    encoders : tuple of int
        Inertias that are read, the load's last; none: the law sees true states.
    counts : tuple of float
        One count of each [rad].
    phases : tuple of float
        Where in its count each starts, from -1/2 to 1/2.
    torque_limit : float
        [N m].
    """

    interval: float
    encoders: tuple[int, ...] = ()
    counts: tuple[float, ...] = ()
    phases: tuple[float, ...] = ()
    torque_limit: float = float("inf")


def share_bounds(chain: LumpedChain, share: float) -> Bounds:
    """Bounds of the motor's inertia, friction and offset, all by one share; the offset by the Coulomb torque.

    ``share``: relative half width [-].
    """
    nominal = np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])
    half = share * np.array([*np.abs(nominal[:3]), max(nominal[2], abs(nominal[3]))])
    return Bounds(nominal=nominal, low=nominal - half, high=nominal + half)


def chain_loop(
    plant: LumpedChain,
    trajectory: Trajectory,
    rig: ChainRig,
    bandwidth: float,
    *,
    design: LumpedChain | None = None,
    tuning: KalmanTuning | None = None,
    share: float = 0.1,
    adaptation: float = 0.1,
    smooth_friction: bool = False,
) -> Loop:
    """The damping-aware law of a lumped chain of n inertias on that chain, or on another plant.

    ``plant``: links between equal angles; ``trajectory``: of the last inertia, with n + 1 continuous
    derivatives for a torque without jumps; ``bandwidth``: lambda/(2 pi) [Hz]; ``design``: as the law believes
    the chain to be; default: the plant itself; ``share``: relative half width of the bounds of the motor's
    parameters; ``adaptation``: factor on the adaptation gain of (6.37); ``smooth_friction``: c tanh(50 w) at
    the motor instead of stick-slip.
    Raises `InputRefused` if encoders, counts and phases are not of one number, or the load is not read.
    """
    believed = plant if design is None else design
    _check(rig, believed.size)
    made = _controller(believed, trajectory, rig, bandwidth, share, adaptation)
    if tuning is not None:
        made = replace(made, tuning=tuning)
    samples = len(made.reference)
    numbers = RigNumbers(
        interval=rig.interval,
        encoders=np.array(rig.encoders or (plant.size - 1,), dtype=np.int64),
        counts=np.array(rig.counts or (0.0,)),
        phases=np.array(rig.phases or (0.0,)),
        torque_limit=rig.torque_limit,
        late_samples=0,
        late_part=0.0,
        jitter=np.zeros(0),
        forces=np.zeros((samples, 2)),
        first_end=samples,
        blind=np.array([-1, 0, 0], dtype=np.int64),
    )
    options = RigOptions(smooth_friction=smooth_friction, forbid_slack=False)
    time = np.asarray(rig.interval * np.arange(samples), dtype=np.float64)
    return Loop(
        observer=_observer(believed, rig, made.tuning),
        controller=made,
        rig=numbers,
        target=trajectory(time)[0],
        gear=1.0,
        encoder_shafts=tuple(plant.names[i] for i in rig.encoders),
        **plant_parts(plant, rig.interval, 0.0, options, 0.0, float("inf")),
    )


def _controller(
    chain: LumpedChain,
    trajectory: Trajectory,
    rig: ChainRig,
    bandwidth: float,
    share: float,
    adaptation: float,
) -> Controller:
    samples = round(trajectory.duration / rig.interval) + 1
    time = np.asarray(rig.interval * np.arange(samples), dtype=np.float64)
    flat = flat_output(chain)
    reference = flat_reference(flat, trajectory(time, 2 * chain.size), rig.interval)
    gains = DarcGains(
        bandwidth=2.0 * pi * bandwidth, sliding_rate=2.0 * pi * bandwidth, adaptation_share=adaptation
    )
    bounds = share_bounds(chain, share)
    law = darc_numbers(flat, gains, bounds, reference, rig.interval, friction_by_reference=True, desired=True)
    return Controller(
        name="damped law of a chain",
        law=law,
        reference=reference,
        shafts=chain.names,
        start=bounds.nominal,
        tuning=KalmanTuning(),
        gains={"bandwidth_hz": bandwidth},
        model=4,
        damped=True,
        bandwidth=gains.bandwidth,
        flat=flat,
    )


def _observer(chain: LumpedChain, rig: ChainRig, tuning: KalmanTuning) -> ObserverNumbers:
    chosen: Sequence[int] = range(chain.size)
    if not rig.encoders:
        return ideal_states(chain.size, rig.interval, chosen=chosen)
    walks = tuple(count**2 / 6.0 for count in rig.counts[:-1])
    tuning = replace(tuning, offsets=walks)
    sampling = Sampling(interval=rig.interval)
    return kalman_filter(chain, rig.encoders, rig.counts, sampling, chosen=chosen, tuning=tuning)


def _check(rig: ChainRig, size: int) -> None:
    numbers = {len(rig.encoders), len(rig.counts), len(rig.phases)}
    if len(numbers) > 1:
        raise InputRefused(
            f"{len(rig.encoders)} encoders, {len(rig.counts)} counts and {len(rig.phases)} phases: give "
            "as many of each"
        )
    if rig.encoders and rig.encoders[-1] != size - 1:
        raise InputRefused(
            f"the last encoder reads inertia {rig.encoders[-1] + 1} of {size}: let it read the load, "
            "whose angle is controlled"
        )
