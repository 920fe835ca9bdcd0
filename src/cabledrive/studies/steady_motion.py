"""Steady motion under a torque: every branch of it, where a steady load splits the spans as well.

Where both spans are tuned alike the branches are known in closed form, see `cabledrive.reduction.branches`. A
steady load pulls one span and relaxes the other; then one span alone still has the closed form, both together
are followed by continuation, Eq. (A.29).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.parameters import Drive, NotComputed
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.averaging import AveragedCoefficients, averaged_coefficients, averaged_rates
from cabledrive.reduction.branches import jacobian, steady_amplitudes, steady_state
from cabledrive.reduction.continuation import Branch, follow_branch

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEP = 0.05
TRIALS = 60
PRESENT = 1e-3
"""A span takes part where its amplitude is above this share of the largest."""

_PER_SECTION = (
    "transverse_detuning",
    "feedback",
    "pump",
    "drift",
    "passive",
    "back_third",
    "third",
    "offset",
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SteadyBranch:
    """Steady motions of one kind over the torque.

    Attributes
    ----------
    spans : tuple of str
        Those that vibrate.
    torque : ndarray, shape (n,)
        Amplitude of the torque, in the order of the branch [N m].
    pulley : ndarray, shape (n,)
        Amplitude of the pulley mode q [m].
    amplitude : ndarray, shape (2, n)
        Of upper and lower span [m].
    growth : ndarray, shape (n,)
        Largest growth rate of a disturbance, of whatever span [1/s]; negative: stable.
    folds, hopf_points : tuple of float
        Torques [N m].
    onset : float or None
        Torque at which the branch leaves the state of rest, where it does [N m].
    ended : str
        Why the branch ends, see `cabledrive.reduction.continuation.Branch`.
    """

    spans: tuple[str, ...]
    torque: Array
    pulley: Array
    amplitude: Array
    growth: Array
    folds: tuple[float, ...]
    hopf_points: tuple[float, ...]
    onset: float | None
    ended: str

    def at(self, torque: float) -> Array:
        """Where the branch passes a torque, between its points.

        Parameters
        ----------
        torque : float
            [N m].

        Returns
        -------
        ndarray, shape (passes, 4)
            Amplitudes of pulley mode, upper and lower span [m]; growth rate [1/s].
        """
        first = np.flatnonzero(np.diff(np.sign(self.torque - torque)) != 0)
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
    """Every branch of steady motion that exists under some torque, followed down and up to three times it.

    Parameters
    ----------
    drive : Drive
        A loop of two plain spans.
    torque : float
        Amplitude at which steady motions are sought [N m].
    rng : numpy.random.Generator
        For the starts of the search.
    load_torque : float, default 0.0
        Steady torque on the load pulley [N m]; it pulls the upper span and relaxes the lower one.
    forcing : float, optional
        Omega [rad/s]; the pulley mode's own unless given.

    Returns
    -------
    tuple of SteadyBranch
        First of single spans, then of both.

    Raises
    ------
    NotComputed
        If the drive has not two vibrating sections.
    """
    model = autoparametric_model(drive, load_torque=load_torque)
    if model.coupling.size != 2:
        raise NotComputed(
            f"{model.coupling.size} sections of cable vibrate: branches are followed where there are two"
        )
    c = averaged_coefficients(model, torque=torque, forcing=forcing, drift=False)
    c = c._replace(force=np.abs(c.force) + 0j)
    per_torque = float(c.force.real) / torque
    found = [_branch(c, state, per_torque) for state in _single_states(c)]
    for state in _joint_states(c, rng):
        amplitudes = np.abs(state)
        seen = any(_passes(branch, torque, amplitudes) for branch in found if len(branch.spans) == 2)
        if not seen:
            found.append(_branch(c, state, per_torque))
    return tuple(found)


def _single_states(c: AveragedCoefficients) -> list[Complex]:
    """One span alone, by the closed form."""
    states = []
    for j in range(2):
        twice = _section(c, j, 2)
        squared = steady_amplitudes(twice, "one")
        if squared.size:
            pulley, across, _ = steady_state(twice, float(squared[-1]), "one")
            state = np.zeros(3, dtype=complex)
            state[[0, 1 + j]] = pulley, across
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
        change: Array = np.asarray(np.linalg.solve(jacobian(c, state), _real(rate)), dtype=float)
        state = np.asarray(state - _complex(change), dtype=complex)
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
        return _real(averaged_rates(part._replace(force=np.array(f + 0j)), _complex(x), second=False))

    def _slope(x: Array, f: float) -> Array:
        return jacobian(part._replace(force=np.array(f + 0j)), _complex(x))

    ways = [
        follow_branch(
            _residual,
            _slope,
            _real(state[kept]),
            force,
            limits=(1e-3 * force, 3 * force),
            step=STEP,
            scale=scale,
            upwards=upwards,
            most=1500,
        )
        for upwards in (False, True)
    ]
    return _joined(c, ways, kept, per_torque)


def _joined(
    c: AveragedCoefficients, ways: list[Branch], kept: NDArray[np.bool_], per_torque: float
) -> SteadyBranch:
    size = float(np.max(np.abs(_complex(ways[0].states[0])[1:])))
    leaves = [
        point.parameter / per_torque
        for way in ways
        for point in way.special
        if point.kind == "fold" and np.max(np.abs(_complex(point.state)[1:])) < PRESENT * size
    ]
    (down, ended_down), (up, ended_up) = (_until_rest(way) for way in ways)
    states = np.concatenate((ways[0].states[:down][::-1], ways[1].states[1:up]))
    force = np.concatenate((ways[0].parameters[:down][::-1], ways[1].parameters[1:up]))
    full = np.zeros((force.size, 3), dtype=complex)
    full[:, kept] = [_complex(x) for x in states]
    growth = [float(np.max(np.linalg.eigvals(jacobian(c, state)).real)) for state in full]
    names = ("upper", "lower")
    special = {
        kind: tuple(
            sorted(
                {
                    round(point.parameter / per_torque, 15)
                    for way, last in zip(ways, (down, up), strict=True)
                    for point in way.special
                    if point.kind == kind and np.max(np.abs(_complex(point.state)[1:])) > PRESENT * size
                    if _before(way, last, point.state)
                }
            )
        )
        for kind in ("fold", "hopf")
    }
    return SteadyBranch(
        spans=tuple(name for name, moves in zip(names, kept[1:], strict=True) if moves),
        torque=force / per_torque,
        pulley=np.abs(full[:, 0]),
        amplitude=np.abs(full[:, 1:]).T,
        growth=np.array(growth),
        folds=special["fold"],
        hopf_points=special["hopf"],
        onset=leaves[0] if leaves else None,
        ended=f"down: {ended_down}; up: {ended_up}",
    )


def _until_rest(way: Branch) -> tuple[int, str]:
    """Number of points before the branch passes through the state of rest, and why it ends there.

    Beyond it come the same motions half a period later.
    """
    across = np.array([_complex(x)[1:] for x in way.states])
    turned = np.flatnonzero(np.sum(across[1:] * across[:-1].conj(), axis=1).real < 0.0)
    return (int(turned[0]) + 1, "rest") if turned.size else (len(way.states), way.ended)


def _before(way: Branch, last: int, state: Array) -> bool:
    """Whether a special point lies on the first points of a branch."""
    nearest = int(np.argmin(np.linalg.norm(way.states - state, axis=1)))
    return nearest < last


def _passes(branch: SteadyBranch, torque: float, amplitudes: Array) -> bool:
    """Whether a branch passes near a state."""
    points = np.array([branch.torque, branch.pulley, *branch.amplitude])
    place = np.append(torque, amplitudes)
    return bool(np.min(np.max(np.abs(points / place[:, None] - 1.0), axis=0)) < STEP)


def _real(state: Complex) -> Array:
    return np.concatenate((state.real, state.imag))


def _complex(x: Array) -> Complex:
    return np.asarray(x[: x.size // 2] + 1j * x[x.size // 2 :])
