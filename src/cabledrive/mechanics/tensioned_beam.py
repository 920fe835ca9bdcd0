r"""Exact dynamic stiffness of a beam under tension, for a cable with bending stiffness.

Motion across, :math:`EI\,w'''' - T\,w'' + \rho\,\ddot w = 0`, has waves :math:`\cos\alpha x, \sin\alpha x,
\cosh\beta x, \sinh\beta x` with

.. math:: \alpha^2 = \frac{2\rho\omega^2}{T + S}, \qquad \beta^2 = \frac{T + S}{2 EI}, \qquad
          S = \sqrt{T^2 + 4 EI \rho\omega^2}.

Motions symmetric and antisymmetric about the middle are apart; each ties displacement and slope of the ends
to transverse force and moment by two rows. They are written in sums of one sign, so that neither short nor
slack nor long beams lose digits. `numpy` takes complex frequencies as well, for exact derivatives.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

SERIES = 12
"""Terms of the power series; below arguments of 1 what is left out is under 1e-24."""

_K = np.arange(1, SERIES + 1)
_FACTORIALS = np.cumprod(np.arange(1, 2 * SERIES + 2, dtype=float))[2 * _K]
_TERMS = 2.0 * _K / _FACTORIALS

SYMMETRIC = 0.5 * np.array([[1.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 1.0]])
ANTISYMMETRIC = 0.5 * np.array([[-1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]])
"""Displacement and slope of the far end of both motions, by those of start and end."""


def wave_numbers(omega: Any, bending: Any, tension: Any, density: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    """Wave numbers alpha of the travelling and beta of the evanescent waves [1/m].

    ``omega`` [rad/s]; ``bending`` [N m^2], ``tension`` [N], ``density`` [kg/m].
    """
    root = np.sqrt(tension**2 + 4.0 * bending * density * omega**2)
    return omega * np.sqrt(2.0 * density / (tension + root)), np.sqrt((tension + root) / (2.0 * bending))


def beam_stiffness(
    omega: Any, bending: NDArray[Any], tension: NDArray[Any], density: NDArray[Any], length: NDArray[Any]
) -> NDArray[Any]:
    """Transverse force and moment per displacement and slope of both ends, as (w, slope) at start and end.

    ``omega`` [rad/s], also complex; the others, shape (p,): [N m^2], [N], [kg/m], [m].
    Returns shape (p, 4, 4): [N/m], [N], [N m].
    """
    symmetric, antisymmetric = halves(omega, bending, tension, density, length)
    return np.asarray(
        2.0
        * (
            np.einsum("ia,pij,jb->pab", SYMMETRIC, symmetric, SYMMETRIC)
            + np.einsum("ia,pij,jb->pab", ANTISYMMETRIC, antisymmetric, ANTISYMMETRIC)
        )
    )


def halves(
    omega: Any, bending: NDArray[Any], tension: NDArray[Any], density: NDArray[Any], length: NDArray[Any]
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Stiffness of the far end in symmetric and in antisymmetric motion, shape (p, 2, 2) each."""
    alpha, beta = wave_numbers(omega, bending, tension, density)
    h = 0.5 * length
    x, y = alpha * h, beta * h
    c, s, t = np.cos(x), _sinc(x), np.tanh(y) / y
    both = alpha**2 + beta**2
    apart = _sinc_less_cosine(x) + c * _one_less_tanhc(y)
    below = beta**2 * c * t + alpha**2 * s
    mixed = bending * alpha**2 * beta**2 * apart / below
    symmetric = _pair(
        -bending * alpha**2 * beta**2 * h * s * t * both / below, mixed, bending * c * both / (h * below)
    )
    antisymmetric = _pair(
        bending * c * both / (h * apart), -bending * below / apart, bending * h * s * t * both / apart
    )
    return symmetric, antisymmetric


def _pair(force: NDArray[Any], mixed: NDArray[Any], moment: NDArray[Any]) -> NDArray[Any]:
    return np.stack((np.stack((force, mixed), -1), np.stack((mixed, moment), -1)), -2)


def _sinc(x: NDArray[Any]) -> NDArray[Any]:
    """Sine of x over x."""
    near = np.abs(x) < 1e-8
    return np.where(near, 1.0 - x**2 / 6.0, np.sin(x) / np.where(near, 1.0, x))


def _sinc_less_cosine(x: NDArray[Any]) -> NDArray[Any]:
    """Sine of x over x, less cosine, without cancellation."""
    small = np.abs(x) < 1.0
    series = np.asarray(x)[..., None] ** (2 * _K) @ (_TERMS * (-1.0) ** (_K + 1))
    return np.where(small, series, _sinc(x) - np.cos(x))


def _one_less_tanhc(y: NDArray[Any]) -> NDArray[Any]:
    """One less tanh y over y, without cancellation."""
    small = np.abs(y) < 1.0
    inside = np.where(small, y, 1.0)
    series = inside[..., None] ** (2 * _K) @ _TERMS / np.cosh(inside)
    return np.where(small, series, 1.0 - np.tanh(y) / y)
