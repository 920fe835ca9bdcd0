"""Steady motion under a torque: every branch of it, and where a branch is born.

Where both spans are tuned alike the branches are known in closed form, see `cabledrive.reduction.averaging`.
Under a steady load one span alone still has the closed form; both together are followed by continuation.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import (
    AveragedCoefficients,
    averaged_coefficients,
    averaged_rates,
    jacobian,
    steady_amplitudes,
    steady_state,
)
from cabledrive.reduction.continuation import Branch, follow_branch

Complex = NDArray[np.complex128]

REST = "a span comes to rest"
BORN = 0.1
"""A branch that cannot go on where a span moves less than this share of its largest has come to its birth."""

PRESENT = 1e-3
"""A span takes part where its amplitude is above this share of the largest."""


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
    parts = {name: getattr(way, name)[:last] for name in ("states", "parameters", "growth")}
    return replace(way, **parts, special=special, ended=REST)


def real_state(state: Complex) -> Array:
    """Real parts, then imaginary parts, shape (2 n,); ``state``, shape (n,)."""
    return np.concatenate((state.real, state.imag))


def complex_state(x: Array) -> Complex:
    """Slow amplitudes from their real and imaginary parts, shape (n,); ``x``, shape (2 n,)."""
    return np.asarray(x[: x.size // 2] + 1j * x[x.size // 2 :])


STEP = 0.05
TRIALS = 40
_PER_SECTION = (
    *("transverse_detuning", "feedback", "pump", "drift", "passive", "back_third", "third", "offset"),
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyBranch:
    """Steady motions of one kind over the torque."""

    spans: tuple[str, ...]  # those that vibrate
    torque: Array  # (n,): amplitude of the torque, in the order of the branch [N m]
    pulley: Array  # (n,): amplitude of the pulley mode q [m]
    amplitude: Array  # (2, n): of upper and lower span [m]
    growth: Array  # (n,): largest growth rate of a disturbance, of whatever span [1/s]; negative: stable
    # folds, hopf_points: torques [N m]
    folds: tuple[float, ...]
    hopf_points: tuple[float, ...]
    # torque at which it leaves the state of rest, or that of one span alone, where it does [N m]
    onset: float | None
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
    drive: Drive,
    torque: float,
    rng: np.random.Generator,
    *,
    load_torque: float = 0.0,
    forcing: float | None = None,
) -> tuple[SteadyBranch, ...]:
    """Branches of steady motion of one span, then both, followed down and up to three ``torque`` [N m]."""
    model = autoparametric_model(drive, load_torque=load_torque)
    if model.coupling.size != 2:
        raise NotComputed(
            f"{model.coupling.size} sections of cable vibrate: branches can be followed for two"
        )
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
    squares = {
        name: np.full((times, times), getattr(c, name)[j, j], dtype=float) for name in ("cubic", "static")
    }
    return c._replace(**rows, **squares)


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
        rate = averaged_rates(c, state, second=False)
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
        return real_state(
            averaged_rates(part._replace(force=np.array(f + 0j)), complex_state(x), second=False)
        )

    def _slope(x: Array, f: float) -> Array:
        return jacobian(part._replace(force=np.array(f + 0j)), complex_state(x))

    how: dict[str, Any] = {"limits": (1e-3 * force, 3 * force), "step": STEP, "scale": scale, "most": 1500}
    down, up = (
        until_rest(follow_branch(_residual, _slope, real_state(state[kept]), force, upwards=upwards, **how))
        for upwards in (False, True)
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
