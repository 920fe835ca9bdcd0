"""Where a branch of steady motion is born: a span's motion vanishes there, and continuation must stop."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cabledrive.reduction.continuation import Branch

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

REST = "a span comes to rest"
BORN = 0.1
"""A branch that cannot go on where a span moves less than this share of its largest has come to its birth."""

PRESENT = 1e-3
"""A span takes part where its amplitude is above this share of the largest."""


def until_rest(way: Branch) -> Branch:
    """The branch up to where a span's motion vanishes; beyond it come the same motions, mirrored.

    There it meets the state of rest, or that of the other span alone, and its Jacobian is singular: to step
    over it is luck.
    """
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


def birth_force(way: Branch) -> float | None:
    """Force at which the motion vanishes, from its square near there.

    ``way``: of `until_rest`.
    Returns [m/s]; None where the branch ends elsewhere.
    """
    if way.ended != REST:
        return None
    squared = np.min(np.abs([complex_state(x)[1:] for x in way.states]), axis=1) ** 2
    near = np.flatnonzero(squared < 0.05 * squared.max())
    if near.size < 4:
        return None
    return float(np.polyfit(squared[near], way.parameters[near], 3)[-1])


def real_state(state: Complex) -> Array:
    """Real parts, then imaginary parts.

    ``state``, shape (n,).
    Returns shape (2 n,).
    """
    return np.concatenate((state.real, state.imag))


def complex_state(x: Array) -> Complex:
    """Slow amplitudes from their real and imaginary parts.

    ``x``, shape (2 n,).
    Returns shape (n,).
    """
    return np.asarray(x[: x.size // 2] + 1j * x[x.size // 2 :])
