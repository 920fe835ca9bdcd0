"""Motion of a lumped chain under a sampled torque: set-valued friction, backlash, exact sensitivities."""

from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.chain_kernels import ChainNumbers, integrate
from cabledrive.reduction.lumped_chain import LumpedChain

QUANTITIES = ("inertia", "viscous", "coulomb", "offset", "gain", "stiffness", "damping", "angle", "speed")
"""What a parameter may move: the rows of `direction`, each as long as there are inertias (or links)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FrictionLaw:
    """How Coulomb friction differs from a constant; one value per inertia."""

    excess: tuple[float, ...]  # friction at rest above Coulomb [N m]; it fades with speed (Stribeck)
    fading: tuple[float, ...]  # speed at which the excess has fallen to 1/e [rad/s]
    slope: tuple[float, ...]  # K of c tanh(K w) in (4.8) [s/rad]; 0: set-valued


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class IntegratedMotion:
    """Motion at the samples."""

    angles: Array  # (samples, n) [rad]
    speeds: Array  # (samples, n) [rad/s]
    speed_sensitivities: Array  # (samples, n, m): derivatives of the speeds by the m parameters


def direction(n: int, quantity: str, number: int = 0) -> Array:
    """Unit direction, (9 n - 2,), of one of `QUANTITIES` of inertia or link ``number``; n inertias."""
    if quantity not in QUANTITIES:
        raise InputRefused(
            f"{quantity!r} is no quantity of a lumped chain: take one of {', '.join(QUANTITIES)}"
        )
    lengths = [n - 1 if name in ("stiffness", "damping") else n for name in QUANTITIES]
    place = QUANTITIES.index(quantity)
    unit = np.zeros(sum(lengths))
    unit[sum(lengths[:place]) + number] = 1.0
    return unit


def integrate_chain(
    chain: LumpedChain,
    torque: Array,
    interval: float,
    *,
    gaps: tuple[float, ...] | None = None,
    law: FrictionLaw | None = None,
    start: Array | None = None,
    directions: Array | None = None,
    substeps: int = 1,
    hold: str = "line",
) -> IntegratedMotion:
    """Move a lumped chain from rest (or ``start``) under a torque given at samples.

    ``torque``, shape (samples,): on the first inertia [N m]; ``interval``: time between samples [s];
    ``gaps``: backlash of each link [rad, or m between rims]; ``law``: default: constant Coulomb friction;
    ``start``, shape (2n,): angles, then speeds; ``directions``, shape (9 n - 2, m): how each of m parameters
    moves the quantities of the chain, see `direction`; ``substeps``: steps per sample; ``hold``, {"line",
    "step"}: torque on straight lines between samples, or standing from sample to sample.
    Raises `NotComputed` if the motion leaves the finite numbers.
    """
    n = chain.size
    numbers = chain_numbers(chain, gaps, law, directions)
    begin = np.zeros(2 * n) if start is None else np.array(start, dtype=float)
    states = _states(numbers, torque, (float(interval), substeps, 1.0 if hold == "line" else 0.0), begin)
    if not np.all(np.isfinite(states[-1, :, 0])):
        first = int(np.argmin(np.isfinite(states[:, :, 0]).all(axis=1)))
        raise NotComputed(f"motion of {n} inertias diverged at t = {first * interval:.4g} s: raise substeps")
    return IntegratedMotion(
        angles=states[:, :n, 0], speeds=states[:, n:, 0], speed_sensitivities=states[:, n:, 1:]
    )


def _states(numbers: ChainNumbers, torque: Array, grid: tuple[float, int, float], start: Array) -> Array:
    """States at the samples, see `cabledrive.reduction.chain_kernels.integrate`."""
    moved = numbers.directions[-start.size :]
    states = np.empty((len(torque), start.size, 1 + moved.shape[1]))
    integrate(
        numbers, np.ascontiguousarray(torque, dtype=float), np.column_stack((start, moved)), grid, states
    )
    return states


def chain_numbers(
    chain: LumpedChain,
    gaps: tuple[float, ...] | None = None,
    law: FrictionLaw | None = None,
    directions: Array | None = None,
) -> ChainNumbers:
    """A lumped chain as the kernels take it, refused with a holding stiffness, which they do not have."""
    if chain.holding > 0.0:
        raise InputRefused(
            f"holding stiffness = {chain.holding:.4g} N m/rad: lumped inertias move under a torque "
            "with a motor that turns freely; leave out motor.holding_stiffness, or simulate the cable"
        )
    n = chain.size
    zeros = (0.0,) * n
    law = law or FrictionLaw(excess=zeros, fading=(1.0,) * n, slope=zeros)
    ratios = np.array(chain.ratios, dtype=float).reshape(n - 1, 2)
    body = [chain.inertias, chain.viscous, chain.coulomb, chain.offsets]
    body += [(1.0, *zeros[1:]), law.excess, law.fading, law.slope]
    link = [chain.stiffness, chain.damping, gaps if gaps is not None else zeros[1:], *ratios.T]
    return ChainNumbers(
        body=np.array(body, dtype=float),
        link=np.array(link, dtype=float).reshape(5, n - 1),
        directions=np.zeros((9 * n - 2, 0)) if directions is None else np.array(directions, dtype=float),
    )


def integrate_rigid_axis(
    values: Array,
    torque: Array,
    interval: float,
    *,
    start: float = 0.0,
    slope: float = 0.0,
    varied: bool = False,
) -> tuple[Array, Array]:
    """Move one rigid axis, a chain of one.

    ``values``, shape (4,): inertia, viscous friction, Coulomb friction, offset; ``torque``, shape (samples,)
    [N m], on straight lines between samples; ``interval`` [s]; ``start``: speed at the first sample [rad/s];
    ``slope``: K of c tanh(K w) [s/rad]; 0: set-valued friction; ``varied``: whether to find sensitivities.
    Returns ``speeds``, shape (samples,) [rad/s]; ``sensitivities``, shape (samples, 5): by the four
    parameters and the speed at the start; else (samples, 0).
    Raises `NotComputed` if the motion leaves the finite numbers.
    """
    body = np.array([*values, 1.0, 0.0, 1.0, slope], dtype=float)[:, None]
    states = _states(
        ChainNumbers(body, _NO_LINKS, _OF_AN_AXIS if varied else _STILL),
        torque,
        (float(interval), 1, 1.0),
        np.array([0.0, start]),
    )
    if not np.isfinite(states[-1, 1, 0]):
        raise NotComputed("motion of the axis diverged: the viscous friction or the inertia is no machine's")
    return states[:, 1, 0], states[:, 1, 1:]


_NO_LINKS, _STILL = np.zeros((5, 0)), np.zeros((7, 0))
_OF_AN_AXIS = np.stack([direction(1, name) for name in (*QUANTITIES[:4], "speed")], axis=1)
