"""One closed loop put together from a drive, a law and the rig's options, and run."""

from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from cabledrive.control.numbers import ESTIMATES, ObserverNumbers, new_controller_state
from cabledrive.mechanics.compiled import why_plain
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import LumpedChain, highest_model
from cabledrive.rig import setting
from cabledrive.rig.closed_loop.cable_plant import CablePlant, axis_like, cable_plant, cable_run, run_cable
from cabledrive.rig.closed_loop.chain_kernels import (
    SUMMARY,
    ChainPlant,
    Control,
    Integers,
    LoopState,
    RigNumbers,
)
from cabledrive.rig.closed_loop.chain_plant import (
    Pair,
    chain_numbers,
    make_pair,
    pair_at_rest,
    pair_numbers,
    pair_plant,
)
from cabledrive.rig.closed_loop.loop_kernels import run_loop
from cabledrive.rig.closed_loop.own_plant import OwnPlant, run_users, user_plant
from cabledrive.rig.laws import controllers
from cabledrive.rig.laws.controllers import Controller, DesignSpec


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """Everything that a run needs."""

    spec: DesignSpec  # what the law is designed for, and runs with
    plant: ChainPlant
    chain: LumpedChain  # the chain that is the plant, at the first shaft
    observer: ObserverNumbers
    controller: Controller
    rig: RigNumbers
    target: Array  # (samples,): wanted load angle at the first shaft [rad]
    slack: float  # twist across the cable at which a span goes slack [rad]
    gear: float  # angle of the first shaft per angle of the load
    encoder_shafts: tuple[str, ...]  # shafts whose encoders are read
    # the distributed cable, where that is the plant; ``chain`` is then its lumped chain
    cable: CablePlant | None = None
    # A plant of the user's own; ``chain`` is then the drive's lumped model with its shafts
    own_plant: OwnPlant | None = None
    named: str = ""  # what the plant is where it is none of the drive's own models
    disturbed: bool = False  # whether ``plant`` has what data sheets leave out
    pair: Pair | None = None  # two motors on the first shaft, the mean of which is the motor of ``chain``

    @property
    def driven(self) -> ChainPlant:
        """The lumped plant as it runs: with two motors where there is a pair."""
        return self.plant if self.pair is None else pair_plant(self.pair, self.plant, self.rig.interval)

    @property
    def control(self) -> Control:
        """What runs the plant, as the compiled loops take it."""
        made, gone = self.controller, 10.0 * (1.0 + float(np.abs(self.target).max(initial=0.0)))
        pair = pair_numbers(self.pair, self.driven, self.observer)
        return Control(self.observer, made.law, self.rig, made.reference, self.target, gone, pair)

    @property
    def backlash(self) -> float:
        """Of the first link, from end to end [rad]."""
        return 2.0 * float(self.plant.play[0]) if len(self.plant.play) else 0.0

    def load_error(self, log: Array) -> Array:
        """Error of the load over a log, shape (samples, columns): shape (samples,) [rad], at the load."""
        return np.asarray((log[:, self.chain.size - 1] - self.target) / self.gear)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Run:
    """What a run left."""

    ended: int  # sample at which it ended
    state: LoopState
    log: Array  # (samples or 0, columns)
    # (samples, pieces): mean tension of each span, or part of it, of the distributed cable as plant [N]
    tensions: Array | None = None
    # (samples, 6): of a pair of motors: torques of both flanks, of both motors, of both flanks as observed
    # [N m]
    flanks: Array | None = None
    # what ran as plain Python, sample by sample: "controller", "plant", both, or "loop" around compiled
    # parts; why nothing is compiled where nothing is; None: everything was compiled
    interpreted: str | None = None

    @property
    def score(self) -> dict[str, float]:
        """What the run is scored by, see `SUMMARY`."""
        return dict(zip(SUMMARY, (float(value) for value in self.state.summary), strict=True))

    @property
    def failed(self) -> bool:
        """Whether the plant diverged or a span went slack, be it at the last sample."""
        return bool(self.state.discrete[1])


PLANTS: dict[str, int | None] = {f"model-{number}": number for number in (1, 2, 3, 4)} | {setting.CABLE: None}


def close_loop(
    spec: DesignSpec,
    controller: Controller,
    generator: np.random.Generator,
    plant: str | LumpedChain | OwnPlant | Any = None,
) -> Loop:
    """Put a loop together; ``plant``: one of `PLANTS`, the highest model by default, or one of the user's."""
    motion, options, plant_drive = spec.motion, spec.options, spec.actual
    interval = setting.sample_interval(plant_drive)
    named_plant = plant if isinstance(plant, str) else None
    if named_plant is not None and named_plant not in PLANTS:
        raise InputRefused(f"plant = {plant!r} is not known: take one of {', '.join(PLANTS)}")
    cable, plant_model = named_plant == setting.CABLE, PLANTS.get(named_plant or "")
    chain, own_plant, named = controllers.plant_chain(plant_drive, plant_model), None, ""
    if plant is not None and not isinstance(plant, str):
        chain, own_plant, named = user_plant(plant_drive, plant, options)
    own = controller.filter_model if not options.ideal_sensors and options.observer == "kalman" else None
    design = controller.filter_chain or controllers.plant_chain(spec.drive, own or highest_model(spec.drive))
    rate = setting.current_rate(plant_drive)
    late_samples, late_part = spec.sampling.late
    fitted = controllers.fitted_encoders(plant_drive, None if own is None else controller.shafts)
    shafts, counts = tuple(fitted), np.array(list(fitted.values()))
    samples = len(controller.reference)
    gear, stepper = controllers.load_gear(plant_drive), controller.field is not None
    late = np.maximum(interval * np.arange(samples, dtype=np.float64) - controller.late, 0.0)
    target = gear * motion.trajectory(late)[0]
    if stepper and (cable or named or options.pair or options.smooth_friction):
        said = f"{controller.name} is one stepper on a lumped chain with set-valued friction"
        raise InputRefused(f"{said}: leave --pair, --smooth-friction and the plant out")
    every = list(controllers.fitted_encoders(plant_drive))  # drawn for each, read or not
    phases = generator.uniform(-0.5, 0.5, len(every))[[every.index(name) for name in shafts]]
    if options.encoder_phase == "centred" or options.ideal_sensors:
        phases = np.zeros(len(phases))
    jitter = generator.normal(0.0, options.jitter, samples + 1) if options.jitter else np.zeros(0)
    rig = RigNumbers(
        interval=interval,
        encoders=np.array([controllers.place(chain, shaft) for shaft in shafts], dtype=np.int64),
        counts=np.zeros(len(counts)) if options.ideal_sensors else counts,
        phases=phases,
        torque_limit=inf if stepper else setting.torque_limit(plant_drive),
        late_samples=late_samples,
        late_part=late_part,
        jitter=np.clip(jitter, -0.4 * interval, 0.4 * interval),
        forces=setting.stepped_in(options.disturbances, ("motor", "load"), interval, samples),
        first_end=round(2.0 * (motion.rise + motion.dwell) / interval),
        dropout=_dropout(options, interval, shafts),
    )
    play = controllers.joint_backlash(plant_drive, chain)
    slack = controllers.slack_twist(plant_drive, chain)
    links = (play, slack) if own_plant is None else (0.0, float("inf"))  # nothing is known of an own one's
    loop = Loop(
        spec=spec,
        observer=controllers.fit_observer(controller, (design, chain), fitted, options, spec.sampling),
        controller=controller,
        rig=rig,
        target=target,
        gear=gear,
        encoder_shafts=shafts,
        cable=cable_plant(plant_drive, chain, interval, options) if cable else None,
        own_plant=own_plant,
        named=named,
        chain=chain,
        slack=slack,
        plant=chain_numbers(chain, interval, options, rate=rate, links=links, field=controller.field),
    )
    if not options.pair:
        return loop
    other = plant is not None or controller.own is not None
    return replace(loop, pair=make_pair(loop, design, spec.sampling, generator, other=other))


def _dropout(options: setting.RigOptions, interval: float, names: tuple[str, ...]) -> Integers:
    """Encoder that gives NaN (-1: none), first and last sample at which it does, shape (3,)."""
    if options.blind is None:
        return np.array([-1, 0, 0], dtype=np.int64)
    shaft, start, end = options.blind
    if shaft not in names:
        raise InputRefused(f"encoder dropout {shaft!r} is not fitted: take one of {', '.join(names)}")
    return np.array([names.index(shaft), round(start / interval), round(end / interval)], dtype=np.int64)


def loop_at_rest(loop: Loop) -> LoopState:
    """State in which a run begins."""
    seen, made = 2 * loop.chain.size + 1, loop.controller
    start, lumped = np.zeros(seen), loop.cable is None and loop.own_plant is None
    if loop.cable is not None:
        start = np.concatenate((start, loop.cable.start))
    if loop.own_plant is not None:
        start = np.concatenate((start, np.asarray(loop.own_plant.initial_state, dtype=np.float64)))
    if loop.pair is not None:
        start = pair_at_rest(loop.pair, loop.driven, loop.rig.late_samples)
    memory = np.array(() if made.own is None else made.own.initial_state, dtype=np.float64)
    count, late = len(loop.rig.encoders), loop.rig.late_samples
    return LoopState(
        x=start,
        shafts=np.zeros(seen) if lumped else start[:seen],  # other plants keep them up to date
        discrete=np.zeros(2, dtype=np.int64),
        controller=new_controller_state(loop.observer, made.law, count, late, made.start, memory),
        readings=np.zeros(count),
        terms=np.zeros((4, len(start))),
        work=np.zeros(len(start)) if lumped else start,
        summary=np.zeros(len(SUMMARY)),
    )


def run(
    loop: Loop, *, log: bool = True, state: LoopState | None = None, first: int = 0, last: int | None = None
) -> Run:
    """Run a loop from rest, or on from where another ended, to the ``last`` sample or the motion's end."""
    controller, samples = loop.controller, len(loop.target)
    state = loop_at_rest(loop) if state is None else state
    end = samples if last is None else last
    # States, readings, command, slip, sigma, estimates, regressor, states of the law.
    width = 2 * loop.chain.size + 1 + len(loop.rig.encoders) + 3 + 2 * ESTIMATES + len(loop.observer.chosen)
    kept = np.zeros((samples if log else 0, width))
    pieces = 0 if loop.cable is None else len(loop.cable.case.mesh.pieces)
    plain, tensions, borne = why_plain(), np.zeros((len(kept), pieces)), np.zeros((len(kept), 6))
    cable = None if loop.cable is None else cable_run(loop.cable, state, tensions)
    made, span = loop.control, (first, end)
    made = made._replace(pair=made.pair._replace(record=borne))
    if controller.own is not None or loop.own_plant is not None:
        ended, plain = run_users(loop, cable or loop.plant, made, span, state, kept)
    elif cable is not None:
        ended = int(run_cable(cable, made, span, state, kept))
    else:
        ended = int(run_loop(loop.driven, made, span, state, kept))
    return Run(
        ended=ended,
        state=state,
        log=kept,
        tensions=None if cable is None else tensions,
        flanks=None if loop.pair is None else borne,
        interpreted=plain,
    )


def with_plant(loop: Loop, chain: LumpedChain, play: float | None = None) -> Loop:
    """The same law and filter on another chain, or the cable like it; ``play``: of the first link [rad]."""
    check_drawable(loop)
    interval, rate = loop.rig.interval, loop.plant.current_rate
    slack = loop.slack
    if np.isfinite(slack):
        slack *= loop.chain.stiffness[-1] / chain.stiffness[-1]
    play = loop.backlash if play is None else play
    links, field = (play, slack), loop.controller.field
    plant = chain_numbers(chain, interval, loop.spec.options, rate=rate, links=links, field=field)
    cable = loop.cable
    if cable is not None:
        like = axis_like(cable.drive, chain)
        cable = cable_plant(cable.drive, chain, interval, loop.spec.options, like)
    return replace(loop, cable=cable, chain=chain, plant=plant, slack=slack)


def check_drawable(loop: Loop) -> None:
    """Refuse to vary a plant whose parameters are not known."""
    if loop.own_plant is not None:
        said = f'plant "{loop.own_plant.name}" is your own, and its parameters are not known'
        raise InputRefused(f"{said}: draws take the drive's models, lumped chains and the cable")
    if loop.disturbed:
        raise InputRefused("the plant carries disturbances already: draw from the loop without them")
