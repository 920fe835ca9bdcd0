"""Motion beyond the threshold: its growth over pretension and torque, and every branch of steady motion.

Where both spans are tuned alike the branches are known in closed form, see `cabledrive.reduction.averaging`.
Under a steady load one span alone still has the closed form; both together are followed by continuation.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cabledrive.mechanics.datasheet import sags
from cabledrive.mechanics.rest import rest_state
from cabledrive.modal.tuning import resonant_pairs
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed, content_hash
from cabledrive.parameters.arrays import Array, Complex
from cabledrive.parameters.route.two_pulleys import two_pulleys_of
from cabledrive.reduction.autoparametric import at_pretension, autoparametric_model, oscillators
from cabledrive.reduction.averaging import (
    AveragedCoefficients,
    averaged_coefficients,
    averaged_rates,
    jacobian,
    steady_amplitudes,
    steady_state,
)
from cabledrive.reduction.continuation import Branch, follow_branch
from cabledrive.reduction.stretch_runs import ensemble_run
from cabledrive.reduction.stretches import in_lanes, numbers_of
from cabledrive.reduction.threshold import threshold_torque
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate
from cabledrive.studies.excited_modes import nearest_two

POINTS = 100
STEPS_PER_PERIOD = 12
SPREAD = 0.25
"""Pretensions of the map reach so far beyond the drive's own and the tuned one."""

SPOTS = 3
GROWN = 2.0
"""Where a motion has grown so many times it is seen to grow, and a spot check says something."""

SHORTEST, FEWEST, MOST, ABOVE = 1.0, 80.0, 3000.0, 1.5
"""Least time [s], least and most periods of a map; torque over its threshold that is seen to grow in it."""

REST = "a span comes to rest"
BORN = 0.1
"""A branch that cannot go on where a span moves less than this share of its largest has come to its birth."""

PRESENT = 1e-3
"""A span takes part where its amplitude is above this share of the largest."""

STEP = 0.05
TRIALS = 40
_PER_SECTION = "transverse_damping", "transverse_detuning", "feedback", "pump", "drift"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GrowthMap:
    """Largest transverse amplitude after a time, over pretension and torque."""

    drive: str  # name
    drive_hash: str
    pretension: Array  # (p,): [N]
    torque: Array  # (t,): [N m]
    growth: Array  # (t, p): largest amplitude of any section over the pluck [-]; NaN where a span went slack
    pulley: Array  # (t, p): largest q [m]; NaN likewise
    slack: NDArray[np.bool_]  # (t, p): where a span went slack on the way: the model ends there
    threshold: Array  # (p,): threshold torque [N m]
    own_pretension: float  # of the drive, like own_torque
    own_torque: float
    tuned: tuple[float, ...]  # tuned pretensions within the map [N]
    pluck: float  # half-sine, of the first section [m], half of it on the next
    duration: float  # [s]
    # torque over the threshold from which on growth is seen within the duration; None: no such threshold
    seen_from: float | None
    weighs: bool  # whether weights, which the map is without, change the tensions of which `resonance` judges


def growth_map(
    drive: Machine | Drive,
    *,
    torque: float,
    load_torque: float = 0.0,
    pretensions: ArrayLike | None = None,
    torques: ArrayLike | None = None,
    duration: float | None = None,
    threads: int = 2,
) -> GrowthMap:
    """Largest motion over pretension and torque at the pulley mode's frequency, from a small unequal pluck.

    ``torque``: the drive's own, the map goes to three times it; 1e-4 of the span is plucked. The
    unstretched lengths are kept; sections vibrate in the mode of the tuned or of the own pretension that
    grows first, and of more sections the two that come nearest to resonance are taken.
    ``duration``: [s]; default: until a motion at `ABOVE` times its threshold has grown `GROWN` times,
    within the bounds of `SHORTEST`, `FEWEST` and `MOST`.
    """
    given = content_hash(drive)
    drive = two_pulleys_of(drive, "the map")
    tuned = tuple(sorted({pair.tuned_pretension for pair in resonant_pairs(drive) if pair.tuned_pretension}))
    own = drive.cable.pretension
    closest = min(tuned, key=lambda value: abs(np.log(value / own)), default=own)
    reach = min(own, closest) / (1 + SPREAD), max(own, closest) * (1 + SPREAD)
    tension = _axis(pretensions, reach, "pretensions", positive=True)
    taus = _axis(torques, (0.0, 3.0 * torque if torque > 0.0 else 1.0), "torques", positive=False)
    height = 1e-4 * drive.span_length
    nearest = min(tuned, key=lambda value: abs(value - own), default=own)
    ends = (replace(drive, cable=replace(drive.cable, pretension=value)) for value in (nearest, own))
    models = [autoparametric_model(one, load_torque=load_torque) for one in ends]
    model, seen, wanted = models[0], None, 0.0
    tops = [at_pretension(one, float(tension[-1])).transverse.max() for one in models]
    h = 2 * np.pi / max(model.natural, 0.5 * max(tops)) / STEPS_PER_PERIOD  # longer steps alias fast modes
    if model.damped:  # a torque k times the threshold pumps with k (1 - exp(-c t / 2)) Gamma / 2 at tuning
        c = averaged_coefficients(model, torque=1.0, drift=False)
        rise, growing = 2 / float(c.damping), 2 * float(np.log(GROWN / 0.7) / np.min(c.transverse_damping))
        wanted = (rise * ABOVE + growing) / (ABOVE - 1.0)  # see `growth_torque`: 0.7 of a pluck grows
    if duration is None:
        wanted = max(wanted, 2 * np.pi * FEWEST / model.natural)
        duration = max(SHORTEST, min(wanted, MOST * STEPS_PER_PERIOD * h))
    if model.damped:
        seen = (duration + growing) / (duration + rise * float(np.expm1(-duration / rise)))
    steps = int(np.ceil(duration / h))
    wave, start = np.sin(model.natural * h * np.arange(steps + 1)), height * np.array([1.0, 0.5])
    pulley, growth = np.empty((2, taus.size, tension.size))

    def integrated(column: int, rows: list[int]) -> None:
        there = (at_pretension(one, float(tension[column])) for one in models)
        first = nearest_two(min(there, key=lambda one: float(threshold_torque(one))))
        numbers = numbers_of(oscillators(first), h)
        plucks = np.tile(start[: first.coupling.size, None, None], len(rows))
        _, _, q, a, _ = ensemble_run(numbers, plucks, (wave, taus[rows], 0.0), steps + 1)
        with np.errstate(over="ignore"):  # beyond slack
            pulley[rows, column], growth[rows, column] = q[0], a.max(axis=0) / height

    means = [part.mean_tension for section in rest_state(drive).sections for part in section.stretches]
    in_lanes(integrated, ((column, range(taus.size)) for column in range(tension.size)), threads)
    slack = ~(pulley <= np.asarray(at_pretension(model, tension).slack_amplitude)[None])
    return GrowthMap(
        drive=drive.name,
        drive_hash=given,
        pretension=tension,
        torque=taus,
        growth=np.where(slack, np.nan, growth),
        pulley=np.where(slack, np.nan, pulley),
        slack=slack,
        threshold=np.min([threshold_torque(at_pretension(one, tension)) for one in models], axis=0),
        own_pretension=own,
        own_torque=torque,
        tuned=tuple(value for value in tuned if tension[0] <= value <= tension[-1]),
        pluck=height,
        duration=duration,
        seen_from=seen,
        weighs=sags(drive) or bool(np.ptp([own, *means]) > 0.01 * own),
    )


def _axis(given: ArrayLike | None, span: tuple[float, float], name: str, *, positive: bool) -> Array:
    axis = np.linspace(*span, POINTS) if given is None else np.asarray(given, dtype=float)
    good = axis.ndim == 1 and axis.size > 0 and bool(np.all(np.isfinite(axis)))
    if not good or np.any(axis < 0.0) or (positive and np.any(axis <= 0.0)):
        bound = "positive" if positive else "not negative"
        raise InputRefused(f"{name}: a list of finite numbers, {bound}, is needed: give one or more")
    return np.sort(axis)


class SpotCheck(NamedTuple):
    """One point of a map by the exact loop."""

    pretension: float  # [N]
    torque: float  # [N m]
    growth: float  # of the map [-]
    exact: float | None  # of the exact loop [-]; None where a span went slack there


def spot_checks(drive: Machine | Drive, growth: GrowthMap, rng: np.random.Generator) -> tuple[SpotCheck, ...]:
    """Run the exact loop at `SPOTS` random taut points of a map, most of them inside the instability region.

    Without weight and Coulomb friction; none where spans do not vibrate in their first mode.
    """
    drive = two_pulleys_of(drive, "a spot check")
    model = autoparametric_model(drive)
    plain = drive.closed and not drive.carriage and all(mode.number == 1 for mode in model.modes)
    taut = np.argwhere(~growth.slack)
    if not plain or taut.size == 0:
        return ()
    shuffled = rng.permutation(taut)
    grown = growth.growth[tuple(shuffled.T)] > GROWN
    inside = shuffled[grown][: SPOTS - SPOTS // 3]
    chosen = np.concatenate((inside, shuffled[~grown]))[:SPOTS]
    return tuple(_checked(drive, growth, model.natural, int(t), int(p)) for t, p in chosen)


def _checked(drive: Drive, growth: GrowthMap, natural: float, row: int, column: int) -> SpotCheck:
    tension, torque = float(growth.pretension[column]), float(growth.torque[row])
    smooth = tuple(replace(pulley, coulomb_friction=0.0) for pulley in drive.pulley)
    motor = drive.motor and replace(drive.motor, coulomb_friction=0.0, offset_torque=0.0)
    cable, layout = replace(drive.cable, pretension=tension), replace(drive.layout, gravity=0.0)
    bare = replace(drive, cable=cable, layout=layout, pulley=smooth, motor=motor)
    heights = {"upper": growth.pluck, "lower": 0.5 * growth.pluck}
    plucks = tuple(Pluck(height=height, span=span, shape="half-sine") for span, height in heights.items())
    result = simulate(
        bare.machine,
        growth.duration,
        torque=Sine(amplitude=torque, frequency=natural / (2 * np.pi)),
        start=Start(plucks=plucks),
        scheme=Scheme(segments=50),
        recording=Recording(rate=8 * natural / (2 * np.pi)),
    )
    largest = max(float(np.max(np.abs(result.midpoint(span)[:, 2]))) for span in heights)
    exact = largest / growth.pluck if result.stopped is None else None
    return SpotCheck(tension, torque, float(growth.growth[row, column]), exact)


def until_rest(way: Branch) -> Branch:
    """The branch up to where a span's motion vanishes; beyond it come the same motions, mirrored."""
    across = np.array([complex_state(x)[1:] for x in way.states])
    mirrored = np.flatnonzero(np.any((across[1:] * across[:-1].conj()).real < 0.0, axis=1))
    least = np.min(np.abs(across), axis=1)
    last = int(mirrored[0]) + 1 if mirrored.size else len(least)
    if not mirrored.size and not (way.ended.startswith("cannot") and least[-1] < BORN * np.max(least)):
        return way
    special = tuple(
        point
        for point in way.special
        if np.min(np.abs(complex_state(point.state)[1:])) > PRESENT * np.max(least)
        and np.argmin(np.linalg.norm(way.states - point.state, axis=1)) < last
    )
    parts = {name: getattr(way, name)[:last] for name in ("states", "parameters")}
    return replace(way, **parts, special=special, ended=REST)


def real_state(state: Complex) -> Array:
    """Real parts, then imaginary parts, shape (2 n,); ``state``, shape (n,)."""
    return np.concatenate((state.real, state.imag))


def complex_state(x: Array) -> Complex:
    """Slow amplitudes from their real and imaginary parts, shape (n,); ``x``, shape (2 n,)."""
    return np.asarray(x[: x.size // 2] + 1j * x[x.size // 2 :])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyBranch:
    """Steady motions of one kind over the torque."""

    spans: tuple[str, ...]  # those that vibrate
    torque: Array  # (n,): amplitude of the torque, in the order of the branch [N m]
    pulley: Array  # (n,): amplitude of the pulley mode q [m]
    amplitude: Array  # (2, n): of upper and lower span [m]
    growth: Array  # (n,): largest growth rate of a disturbance, of whatever span [1/s]; negative: stable
    folds: tuple[float, ...]  # torques [N m], like hopf_points
    hopf_points: tuple[float, ...]
    onset: float | None  # torque at which it leaves the state of rest, or that of one span alone [N m]
    ended: str  # why the branch ends, see `cabledrive.reduction.continuation.Branch`

    @property
    def complete(self) -> bool:
        """Whether it was followed as far as asked."""
        return "cannot" not in self.ended

    def at(self, torque: float) -> Array:
        """Amplitudes [m] and growth rate [1/s] where the branch passes a torque [N m], shape (passes, 4)."""
        first = np.flatnonzero(np.diff((self.torque > torque).astype(int)))
        share = (torque - self.torque[first]) / (self.torque[first + 1] - self.torque[first])
        rows = np.array([self.pulley, *self.amplitude, self.growth])
        return np.asarray((rows[:, first] + share * (rows[:, first + 1] - rows[:, first])).T)


def steady_branches(
    drive: Machine,
    torque: float,
    rng: np.random.Generator,
    *,
    load_torque: float = 0.0,
    forcing: float | None = None,
) -> tuple[SteadyBranch, ...]:
    """Branches of steady motion of one span, then both, followed down and up to three ``torque`` [N m]."""
    model = autoparametric_model(drive, load_torque=load_torque)
    if (many := model.coupling.size) != 2:
        raise NotComputed(f"{many} sections of cable vibrate: branches can be followed for two")
    c = averaged_coefficients(model, torque=torque, forcing=forcing, drift=False)
    if float(c.damping) <= 0.0 and float(np.abs(c.detuning)) < 1e-9 * model.natural:
        raise NotComputed(
            "the pulley mode is undamped at its own frequency, no motion is steady: damp a pulley"
        )
    c = c._replace(force=np.abs(c.force) + 0j)
    per_torque = float(c.force.real) / torque
    found = [_branch(c, state, per_torque) for state in _single_states(c)]
    for state in _joint_states(c, rng):
        place = np.append(torque, np.abs(state))[:, None]
        both = [one for one in found if len(one.spans) == 2]
        points = [np.array([one.torque, one.pulley, *one.amplitude]) for one in both]
        if not any(np.min(np.max(np.abs(own / place - 1.0), axis=0)) < STEP for own in points):
            found.append(_branch(c, state, per_torque))
    return tuple(found)


def _single_states(c: AveragedCoefficients) -> list[Complex]:
    """One span alone, by the closed form."""
    states = []
    for j, twice in enumerate((_section(c, 0, 2), _section(c, 1, 2))):
        squared = steady_amplitudes(twice, "one")
        if squared.size:
            state = np.zeros(3, dtype=complex)
            state[0], state[1 + j], _ = steady_state(twice, float(squared[-1]), "one")
            states.append(state)
    return states


def _section(c: AveragedCoefficients, j: int, times: int) -> AveragedCoefficients:
    """Section j alone, or as if it were there twice."""
    rows = {name: np.repeat(getattr(c, name)[j : j + 1], times) for name in _PER_SECTION}
    cubic, static = (np.full((times, times), one[j, j], dtype=float) for one in (c.cubic, c.static))
    return c._replace(**rows, cubic=cubic, static=static)


def _joint_states(c: AveragedCoefficients, rng: np.random.Generator) -> list[Complex]:
    """Steady states in which both spans move, by Newton's method from random starts."""
    size = np.sqrt(float(np.abs(c.force)) / float(np.abs(c.feedback[0])))
    pinned = np.max(np.abs(-0.5 * c.transverse_damping + 1j * c.transverse_detuning) / np.abs(c.pump))
    scale = np.array([2 * pinned, size, size])
    found: list[Complex] = []
    for _ in range(TRIALS):
        state = scale * (rng.standard_normal(3) + 1j * rng.standard_normal(3))
        settled = _newton(c, state)
        if settled is None or np.min(np.abs(settled[1:])) < PRESENT * np.max(np.abs(settled[1:])):
            continue
        if not any(np.allclose(np.abs(settled), np.abs(other), rtol=1e-6) for other in found):
            found.append(settled)
    return found


def _newton(c: AveragedCoefficients, state: Complex) -> Complex | None:
    for _ in range(40):
        rate = averaged_rates(c, state)
        if np.max(np.abs(rate)) < 1e-12 * np.max(np.abs(state)):
            return state if np.max(np.abs(state[1:])) > 1e-9 else None
        change: Array = np.asarray(np.linalg.solve(jacobian(c, state), real_state(rate)), dtype=float)
        state = np.asarray(state - complex_state(change), dtype=complex)
        if not np.all(np.isfinite(change)) or np.max(np.abs(state)) > 1.0:
            return None
    return None


def _branch(c: AveragedCoefficients, state: Complex, per_torque: float) -> SteadyBranch:
    """The branch through a steady state, both ways; one span alone without the unknowns of the other."""
    moving = np.abs(state[1:]) > PRESENT * np.max(np.abs(state[1:]))
    kept = np.append(True, moving)
    part = c if moving.all() else _section(c, int(np.argmax(moving)), 1)
    force = float(c.force.real)
    scale = np.append(np.tile(np.abs(state[kept]), 2), force)

    def _residual(x: Array, f: float) -> Array:
        return real_state(averaged_rates(part._replace(force=np.array(f + 0j)), complex_state(x)))

    def _slope(x: Array, f: float) -> Array:
        return jacobian(part._replace(force=np.array(f + 0j)), complex_state(x))

    start, limits = np.append(real_state(state[kept]), force), (1e-3 * force, 3 * force)
    down, up = (
        until_rest(follow_branch(_residual, _slope, start, limits=limits, step=step, scale=scale))
        for step in (-STEP, STEP)
    )
    states = np.concatenate((down.states[::-1], up.states[1:]))
    forces = np.concatenate((down.parameters[::-1], up.parameters[1:]))
    full = np.zeros((forces.size, 3), dtype=complex)
    full[:, kept] = [complex_state(x) for x in states]
    points = [*down.special, *up.special]
    special = {
        kind: tuple(sorted(point.parameter / per_torque for point in points if point.kind == kind))
        for kind in ("fold", "hopf")
    }
    births = []  # where the motion vanishes, from its square near there
    for way in (down, up):
        squared = np.min(np.abs([complex_state(x)[1:] for x in way.states]), axis=1) ** 2
        near = np.flatnonzero(squared < 0.05 * squared.max())
        if way.ended == REST and near.size >= 4:
            births.append(float(np.polyfit(squared[near], way.parameters[near], 3)[-1]) / per_torque)
    return SteadyBranch(
        spans=tuple(name for name, moves in zip(("upper", "lower"), moving, strict=True) if moves),
        torque=forces / per_torque,
        pulley=np.abs(full[:, 0]),
        amplitude=np.abs(full[:, 1:]).T,
        growth=np.array([float(np.max(np.linalg.eigvals(jacobian(c, state)).real)) for state in full]),
        folds=special["fold"],
        hopf_points=special["hopf"],
        onset=births[0] if births else None,
        ended=f"down: {down.ended}; up: {up.ended}",
    )
