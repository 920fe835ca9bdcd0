"""Laws that go by the load: scheduled by one announced, learning its torque, identifying in the loop."""

from dataclasses import replace
from math import isclose
from typing import Any, NamedTuple

import numpy as np

from cabledrive.control.darc import Bounds, printed_bounds
from cabledrive.control.linear_laws import lq_law, lqi_law
from cabledrive.control.load_schedule import LoadSchedule, scheduled_law, with_load
from cabledrive.control.numbers import LEARNING, LawNumbers, ObserverNumbers, learning_table, start_estimates
from cabledrive.control.observers import KalmanTuning, kalman_filter, whitening
from cabledrive.control.reference import load_row_numbers
from cabledrive.control.regression import Estimates, acting_torque, estimate_load, estimate_motor
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop import Loop, Run, run
from cabledrive.rig.laws.baselines import integral_time, inverse_of, weights
from cabledrive.rig.laws.controllers import (
    Controller,
    DesignSpec,
    chain_law,
    fit_observer,
    fitted_encoders,
    place,
    tuning_by_uncertainty,
)
from cabledrive.rig.setting import Payload, control_delay, current_rate

SCHEDULED = "lqi-scheduled"
RATIO = 1.5
"""Between the loads of the two heaviest points of the grid, where its points lie farthest apart."""


def scheduled(spec: DesignSpec) -> Controller:
    """Feedback, filter and feedforward for the load that is announced, each point designed as `lqi`.

    The reference holds beside states and torque what either adds for another load of the drive's own size:
    both are linear in the load's inertia. Its last column is the load that is announced.
    """
    chain, (low, high) = spec.chain, spec.motion.payload_range
    step = (RATIO - 1.0) / high  # between the two heaviest points; the others lie nearer
    points = max(2, int(np.ceil((1.0 / low - 1.0 / high) / step)) + 1)
    schedule = LoadSchedule(low=low, high=high, points=points)
    designs = []
    for loaded in (with_load(chain, load) for load in schedule.loads):
        count, torque, _ = weights(spec, chain=loaded)
        time = integral_time(loaded, count, torque)
        designs.append(lqi_law(loaded, count, torque, time, spec.interval))
    smooth = replace(chain, coulomb=(0.0,) * chain.size)  # friction is fed forward in the step
    # States and torque of the drive's own load, what another of its size adds, and a column of ones.
    first, second = (inverse_of(spec, one) for one in (smooth, with_load(smooth, 2.0)))
    output = np.vstack((first.output, second.output - first.output, np.zeros((1, first.output.shape[1]))))
    constant = np.concatenate((first.constant, second.constant - first.constant, [1.0]))
    generator = first._replace(output=np.ascontiguousarray(output), constant=constant)
    table = spec.rows(generator)
    table[:, -1] = announced(spec.motion.payload, spec.interval, len(table))
    return Controller(
        name=SCHEDULED,
        law=scheduled_law(designs, schedule, chain.coulomb[0]),
        reference=table,
        shafts=spec.shafts,
        start=np.ones(1),
        tuning=tuning_by_uncertainty(spec, chain),
        gains=weights(spec)[2] | {"designed_for": [low, high], "designs": schedule.points},
        model=spec.number,
        generator=generator,
        schedule=schedule,
        believed=chain,
    )


def announced(payload: tuple[Payload, ...], interval: float, samples: int) -> Array:
    """The load in force at every sample as a factor, shape (samples,); ``interval``: sample time [s]."""
    announced_load = np.ones(samples)
    for one in sorted(payload, key=lambda each: each.start):
        announced_load[round(one.start / interval) :] = one.factor
    return announced_load


def with_announced_load(made: Controller, announced_load: Array) -> Controller:
    """The same scheduled law with other announcements, shape (samples,)."""
    reference = made.reference.copy()
    reference[:, -1] = announced_load
    return replace(made, reference=reference)


LOAD_LEARNING, CHANGING = "lqi-learning", "lqg-learning"
TURNING = 0.06
"""Time in which the sign of friction turns, as a share of a move."""
GATE = 3.0
"""Deviations from which an innovation is passed over."""
PARAMETERS = ("load_coulomb", "load_viscous", "load_inertia")


class Learning(NamedTuple):
    """What distinguishes the laws that learn."""

    # share of the filter's noise at the load that learning leaves; the more, the less it trusts the load's
    # inertia
    unlearnt: float
    inertia_spread: float  # deviation of the load's inertia before anything is learnt, over what is believed
    # deviation of an innovation over that of white rounding: errors of rounding last as long as a count, and
    # taken for white they pass for friction where there is none
    noise: float
    memory: float  # time after which an excited direction is forgotten [s]
    # time in which innovations that are passed over bring the covariance of the beginning back [s]
    renewal: float


KINDS = {
    LOAD_LEARNING: Learning(unlearnt=0.1, inertia_spread=0.2, noise=5.5, memory=2.0, renewal=0.01),
    CHANGING: Learning(unlearnt=1.0, inertia_spread=1.0, noise=1.0, memory=0.03, renewal=0.006),
}
"""The first for a load that stays, the second for one that changes while the machine runs."""


def load_learning(spec: DesignSpec, name: str = LOAD_LEARNING, turning: float | None = None) -> Controller:
    """Feedback about a reference with the load's friction and inertia, learnt from innovations."""
    kind, chain = KINDS[name], spec.chain
    turning = turning or TURNING * spec.motion.rise
    observer, white, tuning = _own_filter(replace(spec, bandwidth=None, best=False, adapt=True), name)
    count, torque, settings = weights(spec)
    # What lasts at the load is learnt: an integral would add the unknown zero of the load's encoder.
    base = lq_law(chain, count, torque, spec.interval)
    load = load_row_numbers(chain, observer, white, turning, spec.interval)
    generator = inverse_of(spec, chain)._replace(load=load)
    m, first = len(white), 2 * chain.size + 1
    # a filter without a motion of its error misses nothing: what each parameter asks of the states alone
    still = generator._replace(load=load._replace(transition=np.zeros_like(load.transition)))
    asked = spec.rows(still)[:, first:].reshape(spec.samples, len(PARAMETERS), first + m)
    rows = np.zeros((1 + m, max(base.rows.shape[1], m)))
    rows[0, : base.rows.shape[1]], rows[1:, :m] = base.rows[0], white
    coulomb, viscous, inertia = sum(chain.coulomb), chain.viscous[0], chain.inertias[-1]
    spread = np.array([0.5 * coulomb, viscous, kind.inertia_spread * inertia])  # deviations at the beginning
    low, high = np.array([[0.0, 0.0, -0.7 * inertia], [2.0 * coulomb, 5.0 * viscous, 3.0 * inertia]])
    share = spec.interval / m  # each sample brings m innovations
    law = LawNumbers(
        kind=LEARNING,
        matrix=base.matrix,
        rows=rows,
        learning=learning_table(np.zeros(3), low, high, spread**2 * float(spec.adapt)),
        scalars=np.array(
            [spec.interval, 1.0 - share / kind.memory, GATE, share / kind.renewal, *np.zeros(3)]
        ),
    )
    return Controller(
        name=name,
        law=law,
        reference=spec.rows(generator),
        shafts=spec.shafts,
        start=start_estimates(law),
        tuning=tuning,
        gains=settings | {"learns": list(PARAMETERS), "upper_bounds": high.tolist()},
        model=spec.number,
        generator=generator,
        load_motion=asked[:, :, : first - 1].transpose(1, 0, 2),
        believed=chain,
    )


def _own_filter(spec: DesignSpec, name: str) -> tuple[ObserverNumbers, Array, KalmanTuning]:
    """The filter from whose innovations a law learns, what makes them white, (m, m), and its tuning."""
    kind, options, chain = KINDS[name], spec.options, spec.chain
    if options.ideal_sensors or options.observer != "kalman":
        raise InputRefused(
            f"{name} learns from the innovations of the Kalman filter: leave observer and ideal_sensors out"
        )
    # friction that is to be learnt is the load's: a motor without any must not make the filter certain
    rubbing = replace(chain, coulomb=(sum(chain.coulomb), *chain.coulomb[1:]))
    tuning, fitted = tuning_by_uncertainty(spec, rubbing), fitted_encoders(spec.drive)
    tuning = replace(tuning, load_acceleration=kind.unlearnt * tuning.load_acceleration)
    places, chosen = ([place(chain, one) for one in names] for names in (fitted, spec.shafts))
    used = replace(tuning, offsets=()) if options.encoder_phase == "centred" else tuning
    counts = list(fitted.values())
    read = list(zip(places, counts, strict=True))
    observer = kalman_filter(chain, read, spec.sampling, chosen=chosen, tuning=used)
    return observer, whitening(observer, np.array(counts)) / kind.noise, tuning


INDIRECT = "darc-indirect"
SPREADS = {3: (0.2, 0.05, 0.05), 2: (0.06, 0.05)}
"""Relative half widths within which the inertias, motor to load, are believed, by their number."""
LEAST_SPREAD = 0.02
CERTAIN, DAMPING_CERTAIN, SIGNIFICANT, MOTOR_CERTAIN = 0.02, 0.3, 3.0, 0.05
"""Half widths over values with which stiffness, damping and the motor's inertia and friction are known, and
friction of the load over its error."""
CABLE = ("beta", "gamma", "load_coulomb", "load_viscous")
MOTOR = ("inertia", "viscous_friction", "coulomb_friction", "offset_torque")
SEED = 20


class Learnt(NamedTuple):
    """What one pulse gave."""

    load: Estimates  # of the cable and the load's friction, over the load's inertia
    motor: Estimates  # of whole inertia and friction

    @property
    def excited(self) -> bool:
        """Whether the load's equation holds and shows the cable's stiffness: from less, nothing is learnt."""
        return self.load.known(CERTAIN, 0) and self.load.believed

    @property
    def motor_excited(self) -> bool:
        """Whether inertia and friction are known."""
        return self.motor.known(np.inf, 1) and self.motor.known(MOTOR_CERTAIN, 0, 2)

    @property
    def words(self) -> dict[str, Any]:
        """What was learnt, with 95 % intervals, and whether it was used; None where nothing is known.

        Friction of the load is over its inertia [rad/s^2], [1/s]; motor values are those of the whole drive.
        """
        found: dict[str, Any] = {}
        for name, value, low, high in zip(CABLE, self.load.values, *self.load.intervals, strict=True):
            found |= {name: _known(value), f"{name}_low": _known(low), f"{name}_high": _known(high)}
        found |= {"misfit": _known(self.load.misfit), "used": self.excited}
        found["motor_used"] = self.excited and self.motor_excited
        if not self.excited and self.load.believed:
            found["used_reason"] = "the motion is too small to identify the cable's stiffness to 2 %"
        elif not self.excited:
            found["used_reason"] = (
                f"the residual of the load's equation is {self.load.misfit:.3g} times what rounding to "
                "counts leaves: the load does not obey it"
            )
        for name, value, low, high in zip(MOTOR, self.motor.values, *self.motor.intervals, strict=True):
            found[name] = {"value": _known(value), "low": _known(low), "high": _known(high)}
        return found


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def learn(loop: Loop, early: Run, pause: int) -> Learnt:
    """What readings and commands of the first pulse say of cable and motor."""
    shafts, drive, chain = loop.controller.shafts, loop.spec.drive, loop.spec.model(loop.controller.model)
    if loop.encoder_shafts != shafts or not np.all(loop.rig.counts > 0.0):
        raise InputRefused(
            f"{INDIRECT} learns from the counts of the encoders of {', '.join(shafts)}, and reads "
            f"{len(loop.encoder_shafts)} encoders here: fit those, leave ideal sensors out"
        )
    first = 2 * loop.chain.size + 1
    readings, command = np.split(early.log[:pause, first : first + len(shafts) + 1], [len(shafts)], axis=1)
    counts, interval, generator = loop.rig.counts, loop.rig.interval, np.random.default_rng(SEED)
    delay, rate = control_delay(drive), current_rate(drive)
    torque = acting_torque(command[:, 0], interval, delay=delay, current_rate=rate)
    load = estimate_load(readings[:, -2:], counts[-2:], interval, generator)
    inertias = np.array([chain.inertias, SPREADS[chain.size]])
    motor = estimate_motor(readings, torque, counts, inertias, interval, generator)
    return Learnt(load=load, motor=motor)


def learnt_chain(chain: LumpedChain, found: Learnt) -> LumpedChain:
    """The chain after learning; what has not been excited stays, inertias of load and drive as believed.

    Friction of the load is taken where it stands out of its error, and off the whole friction.
    """
    motor, inertia = found.motor, chain.inertias[-1]
    if found.excited:
        beta, gamma, coulomb, viscous = (found.load.values * inertia).tolist()
        stuck, slowed = (found.load.values > SIGNIFICANT * found.load.errors)[2:]
        damping = gamma if found.load.known(DAMPING_CERTAIN, 1) else chain.damping[-1]
        chain = replace(
            chain,
            stiffness=(*chain.stiffness[:-1], beta),
            damping=(*chain.damping[:-1], damping),
            coulomb=(*chain.coulomb[:-1], coulomb if stuck else 0.0),
            viscous=(*chain.viscous[:-1], viscous if slowed else 0.0),
        )
    own = float(motor.values[0]) - sum(chain.inertias[1:])
    if found.motor_excited and own > 0.0:
        _, viscous, coulomb, offset = (float(v) for v in motor.values)
        # what the other shafts are said to have may be more than all that was learnt
        viscous = max(viscous - sum(chain.viscous[1:]), 0.0)
        coulomb = max(coulomb - sum(chain.coulomb[1:]), 0.0)
        chain = replace(
            chain,
            inertias=(own, *chain.inertias[1:]),
            viscous=(viscous, *chain.viscous[1:]),
            coulomb=(coulomb, *chain.coulomb[1:]),
            offsets=(offset, *chain.offsets[1:]),
        )
    return chain


def learnt_bounds(chain: LumpedChain, found: Learnt) -> Bounds:
    """Bounds of p2 to p5 by the intervals that were learnt, at least 2 % wide; as printed where none were."""
    printed = printed_bounds(chain, flexible_joint=chain.size > 2)
    if not found.motor_excited or not isclose(sum(chain.coulomb), float(found.motor.values[2])):
        return printed
    half = np.diff(found.motor.intervals, axis=0)[0] / 2.0
    half = np.maximum(half, LEAST_SPREAD * np.abs(printed.nominal))
    return Bounds(nominal=printed.nominal, low=printed.nominal - half, high=printed.nominal + half)


def made_anew(made: Controller) -> bool:
    """Whether a law is made anew after the first pulse, by what that has shown."""
    return made.name == INDIRECT and made.own is None


def run_indirect(loop: Loop) -> tuple[Loop, Run, Learnt | None]:
    """Run one pulse, learn, make all anew in the dwell, run the rest; the last loop, and what was learnt."""
    pause = loop.rig.first_end
    early = run(loop, last=min(pause, len(loop.target)))
    if early.failed or pause >= len(loop.target):
        return loop, early, None
    if pause == len(loop.target) - 1:
        return loop, _rest(loop, early, pause), None
    found, spec = learn(loop, early, pause), loop.spec
    if found.excited:  # law, reference and filter, at its settled gain, for what was learnt
        first, number = loop.controller, loop.controller.model
        chain = learnt_chain(spec.model(number), found)
        same = replace(spec, bandwidth=float(first.gains["bandwidth_hz"]))
        bounds = learnt_bounds(chain, found)
        made = chain_law(same, number, damped=True, tuning=first.tuning, chain=chain, bounds=bounds)
        gains = first.gains | made.gains | {"beta": float(found.load.values[0])}
        made = replace(made, name=INDIRECT, gains=gains)
        fitted = fitted_encoders(spec.drive, None if made.filter_model is None else made.shafts)
        sampling, chains = replace(spec, plant=None).sampling, (chain, loop.chain)
        observer = fit_observer(made, chains, fitted, loop.spec.options, sampling, settled=True)
        loop = replace(loop, controller=made, observer=observer)
        early.state.controller.parameters[:4] = made.start
    return loop, _rest(loop, early, pause), found


def _rest(loop: Loop, early: Run, pause: int) -> Run:
    late = run(loop, state=early.state, first=pause)
    log = early.log.copy()
    log[pause:] = late.log[pause:]
    for before, after in ((early.tensions, late.tensions), (early.flanks, late.flanks)):
        if before is not None and after is not None:
            after[:pause] = before[:pause]
    return replace(late, log=log)
