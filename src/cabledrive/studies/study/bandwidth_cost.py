r"""What a bandwidth costs: parts of the bound, torque and error that encoder counts make.

In the linear closed loop (filter at its last gains, estimates at rest, no Coulomb friction) an error of the
readings :math:`|\nu_j| \le q_j/2` moves the load by at most :math:`\tfrac{q_j}{2}\sum_k|g_j(k)|` with the
impulse response :math:`g_j`; the unknown phase of an encoder is a step of at most :math:`q_j/2`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm

from cabledrive.control.darc import darc_step
from cabledrive.control.numbers import NOMINAL, LawNumbers
from cabledrive.parameters import Drive
from cabledrive.reduction.lumped_chain import state_space
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.rig.closed_loop.loop_numbers import Array
from cabledrive.rig.setting import Motion
from cabledrive.rig.tracking import summarize
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.sampled_plants import joined_loop, make_law, rig_options, with_values

UNSTABLE = 1e3


def law_rows(law: LawNumbers, states: int) -> Array:
    """Command of a law of the chain per state, nominal estimates, no Coulomb friction, shape (2n,)."""
    frozen = law.learning[NOMINAL].copy()
    frozen[2:] = 0.0
    rest = np.zeros(states + 3)
    return np.array([darc_step(law, frozen, unit, rest).command for unit in np.eye(states)])


def closed_loop_matrix(loop: Loop) -> tuple[Array, Array]:
    """One sample of the linear closed loop, from sample to sample.

    Returns ``transition``, shape (m, m): states: plant, shaft torque, filter, its shaft torque, commands on
    their way; ``readings``, shape (m, encoders): what an error of each reading adds.
    """
    n, q, late = 2 * loop.chain.size, loop.observer.model.shape[0], loop.rig.late_samples
    size = n + 1 + q + 1 + late + 2
    count = len(loop.rig.encoders)
    every = _sample(loop, np.eye(size, size + count), np.eye(size + count)[size:])
    return every[:, :size], every[:, size:]


def _sample(loop: Loop, states: Array, errors: Array) -> Array:
    """Next states of many loops at once, one per column."""
    n, q = 2 * loop.chain.size, loop.observer.model.shape[0]
    plant, observed = states[: n + 1], states[n + 1 : n + 1 + q]
    held, commands = states[n + 1 + q], states[n + 2 + q :]
    observer, scalars = loop.observer, loop.observer.scalars
    innovation = plant[loop.rig.encoders] + errors - observer.output @ observed
    observed = observed + observer.gains[-1] @ innovation
    command = law_rows(loop.controller.law, len(observer.chosen)) @ observed[observer.chosen]
    commands = np.vstack((commands[1:], command))
    known = observer.model[:, :q] @ observed
    inputs = np.vstack((held, commands[0], commands[1]))
    known = known + observer.model[:, q : q + 3] @ inputs
    carried = scalars[2] * held + scalars[3] * commands[0] + scalars[4] * commands[1]
    early, rest = _transitions(loop)
    plant = early @ np.vstack((plant, commands[0]))
    plant = rest @ np.vstack((plant, commands[1]))
    return np.vstack((plant, known, carried, commands))


def _transitions(loop: Loop) -> tuple[Array, Array]:
    """Plant and torque loop over the delay and over the rest of a sample; last column: the command."""
    n = 2 * loop.chain.size
    a, b = state_space(loop.chain)
    rate = loop.plant.current_rate
    whole = np.zeros((n + 2, n + 2))
    whole[:n, :n] = a
    if rate > 0.0:
        whole[:n, n] = b[:, 0]
        whole[n, n], whole[n, n + 1] = -rate, rate
    else:
        whole[:n, n + 1] = b[:, 0]
    late = loop.rig.late_part
    return expm(whole * late)[: n + 1], expm(whole * (loop.rig.interval - late))[: n + 1]


def sensor_bound(loop: Loop) -> float | None:
    """Largest error of the load by counts and phases of the encoders [rad]; None if the loop is unstable."""
    transition, readings = closed_loop_matrix(loop)
    if np.abs(np.linalg.eigvals(transition)).max() > 1.0 + 1e-6:
        return None
    load, samples = loop.chain.size - 1, len(loop.target)
    state, total = readings.copy(), np.zeros(readings.shape[1])
    step, highest = np.zeros(readings.shape[1]), np.zeros(readings.shape[1])
    for _ in range(samples):
        response = state[load]
        total += np.abs(response)
        step += response
        highest = np.maximum(highest, np.abs(step))
        state = transition @ state
    bound = float(0.5 * loop.rig.counts @ (total + highest) / loop.gear)
    return bound if bound < UNSTABLE else None


FINE = 1e-9
"""Share of a count that stands for none: the filter stays as it is."""
UNMATCHED = (
    "load_inertia",
    "cable_stiffness",
    "cable_damping",
    "joint_stiffness",
    "joint_damping",
    "motor_share",
    "load_viscous_friction",
    "load_coulomb_friction",
    "backlash",
    "delay",
    "ripple_torque",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One bandwidth and what it costs."""

    model: int  # {1, 3, 4}: of the law
    bandwidth: float  # lambda/(2 pi) [Hz]
    theorem: float | None = None  # largest value of the theorem's tube, friction included [rad]
    # what the springs, dampers and the load within their bounds add, the filter in the loop: each by itself,
    # summed, or all at once, whichever is more [rad]
    unmatched: float | None = None
    # what counting and unknown encoder phases add, at the best values or at the ends that push one way [rad]
    sensors: float | None = None
    bound: float | None = None  # all of it [rad]
    torque: float | None = None  # largest of a run with encoders, their counts included [N m]
    refused: str = ""  # why it cannot be used; empty where it can


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Unmatched:
    """What springs, dampers and the load do to the error."""

    nominal: Array  # (samples,): error at the best values [rad]
    shares: dict[str, float]  # largest deviation by each quantity alone [rad]
    # (samples,): sum of these deviations at every sample, or the deviation with all quantities at the ends
    # that push one way, whichever is larger [rad]
    deviation: Array
    ends: tuple[dict[str, float], ...]  # these ends, and the opposite ones


def evaluate(
    drive: Drive,
    motion: Motion,
    quantities: Mapping[str, Quantity],
    model: int,
    hertz: float,
    torque: float | None,
) -> tuple[Candidate, dict[str, float]]:
    """The parts of the bound at one bandwidth [Hz], among them what each quantity adds [rad]."""
    law = make_law(drive, motion, quantities, model, hertz)
    ideal = joined_loop(drive, drive, law, motion, torque, options=rig_options(drive, ideal=True))
    real = joined_loop(drive, drive, law, motion, torque)
    fine = real.rig._replace(counts=FINE * real.rig.counts, phases=np.zeros_like(real.rig.phases))
    smooth = replace(real, rig=fine)
    nominal = summarize(ideal, run(ideal), drive, drive, motion, rig_options(drive, ideal=True), 0)
    seen = summarize(real, run(real), drive, drive, motion, rig_options(drive), 0)
    empty = Candidate(model=model, bandwidth=hertz)
    incomplete = nominal.incomplete or seen.incomplete
    sensors = sensor_bound(real)
    if incomplete or nominal.bound is None or sensors is None:
        why = incomplete or "the loop with encoders and filter is unstable"
        return replace(empty, refused=why), {}
    found = unmatched_part(smooth, drive, quantities)
    if found is None:
        return replace(
            empty, refused="for some parameters within their bounds the drive diverges, or a span goes slack"
        ), {}
    for values in found.ends:
        cost = sensor_bound(with_values(real, drive, values, None))
        if cost is None:
            why = "for some parameters within their bounds the loop with encoders and filter is unstable"
            return replace(empty, refused=why), {}
        sensors = max(sensors, cost)
    excess = np.maximum(np.abs(found.nominal) - nominal.bound, 0.0)
    unmatched = found.deviation + excess
    peak = float(seen.summary["peak_torque"])
    saturated = seen.summary["saturated_fraction"] > 0.0
    return Candidate(
        model=model,
        bandwidth=hertz,
        theorem=float(nominal.bound.max()),
        unmatched=float(unmatched.max()),
        sensors=sensors,
        bound=float((nominal.bound + unmatched).max()) + sensors,
        torque=peak,
        refused=f"the torque reaches its limit of {peak:.4g} N m" if saturated else "",
    ), found.shares


def unmatched_part(loop: Loop, drive: Drive, quantities: Mapping[str, Quantity]) -> Unmatched | None:
    """How far springs, dampers and the load can move the error within their bounds; None if a run ended."""
    nominal = _error(loop, drive, {})
    if nominal is None:
        return None
    open_names = [n for n in UNMATCHED if n in quantities and quantities[n].low != quantities[n].high]
    moved: dict[str, tuple[Array, Array]] = {}
    for name in open_names:
        outer, best = quantities[name].outer, quantities[name].value
        low, high = (nominal if value == best else _error(loop, drive, {name: value}) for value in outer)
        if low is None or high is None:
            return None
        moved[name] = low - nominal, high - nominal
    largest = {name: np.abs(both).max(axis=0) for name, both in moved.items()}
    deviation = np.sum([np.zeros(len(nominal)), *largest.values()], axis=0)
    ends = _pushing_one_way(quantities, moved, int(np.argmax(deviation)))
    for values in ends:
        joint = _error(loop, drive, values)
        if joint is None:
            return None
        deviation = np.maximum(deviation, np.abs(joint - nominal))
    shares = {name: float(each.max()) for name, each in largest.items()}
    return Unmatched(nominal=nominal, shares=shares, deviation=deviation, ends=ends)


def _error(loop: Loop, drive: Drive, values: Mapping[str, float]) -> Array | None:
    """Error of the load over time with other values [rad]; None where the run failed."""
    moved = with_values(loop, drive, values, None)
    done = run(moved)
    return None if done.failed else moved.load_error(done.log)


def _pushing_one_way(
    quantities: Mapping[str, Quantity], moved: Mapping[str, tuple[Array, Array]], sample: int
) -> tuple[dict[str, float], ...]:
    """All quantities at the ends that push the error up at a sample, and all at the others; of none, none."""
    up = {name: int(high[sample] > low[sample]) for name, (low, high) in moved.items()}
    return tuple(
        {name: quantities[name].outer[abs(end - side)] for name, end in up.items()} for side in (0, 1) if up
    )
