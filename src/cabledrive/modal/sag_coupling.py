r"""What sag, which straight ropes leave out, does to modes along and across a span that meet in frequency.

Curvature :math:`\kappa` lets a motion w across stretch the rope by :math:`-\kappa w`. The n-th wave across
then couples to an even stretch by :math:`g_n = \sqrt 8\,\lambda/(\pi^2 n^2)` of the geometric mean of both
stiffnesses: where the two frequencies are equal they part by :math:`\pm g_n/2`, of first order in the sag.
"""

from collections.abc import Callable, Collection, Sequence
from math import pi, sqrt

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.hanging import irvine_parameters
from cabledrive.mechanics.network.motion import ACROSS, ALONG
from cabledrive.modal.mode import Mode
from cabledrive.parameters.arrays import Array

BEYOND = 1.5
"""Modes up to so many times the highest listed one may meet it; the others lie within the shift at rest."""


def sag_coupling_limit(
    network: Network,
    listed: Sequence[Mode],
    below: Callable[[float], list[Mode]],
    allowed: float,
    straight: Collection[int],
) -> str | None:
    """Why sag leaves a list uncertified by coupling motion along and across; None where it does not.

    ``below``: all modes below a frequency [rad/s]; ``allowed``: relative error of a frequency; ``straight``:
    spans whose sag is left out.
    """
    every = irvine_parameters(network)
    spans = {span: float(every[span]) for span in straight if sqrt(2 * every[span]) > allowed * pi**2}
    if not spans or not listed:
        return None
    highest = 2 * pi * max(mode.frequency for mode in listed)
    meets = max(_first(network, i) * sqrt(sqrt(2 * own) / pi**2 / allowed) for i, own in spans.items())
    found = below(BEYOND * min(highest, meets))
    together = [*listed, *(mode for mode in found if not _is_listed(mode, listed))]
    shifts = coupling_shifts(network, together, spans)[: len(listed)]
    worst = int(np.argmax(shifts.sum(axis=1)))
    error = float(shifts[worst].sum())
    if error <= allowed:
        return None
    span = network.drive.free_spans[list(spans)[int(np.argmax(shifts[worst]))]].name
    return (
        f"sag, which is left out, couples motion along and across span {span} and moves the mode at "
        f"{together[worst].frequency:.5g} Hz by about {error:.2g} of its frequency, more than {allowed:g}: "
        "raise the pretension"
    )


def coupling_shifts(network: Network, modes: Sequence[Mode], spans: dict[int, float]) -> Array:
    r"""Relative shift of each mode by the coupling through each span, shape (modes, spans).

    Each pair of modes by its two equations; the waves across above all of these stretch the rope as at rest,
    :math:`\lambda^2/24`. ``spans``: Irvine's parameter by the number of the span.
    """
    omega = 2 * pi * np.array([mode.frequency for mode in modes])
    found = np.zeros((len(modes), len(spans)))
    apart = 0.5 * np.abs(omega[:, None] ** 2 - omega[None, :] ** 2)
    for column, (number, irvine) in enumerate(spans.items()):
        along, across = (np.sqrt(_shares(network, modes, number, way)) for way in (ALONG, ACROSS))
        across *= _coupling(network, number, irvine, omega)
        pair = np.outer(along, across)
        pair = (pair + pair.T) * np.outer(omega, omega)
        np.fill_diagonal(pair, 0.0)
        moved = np.sqrt(apart**2 + pair**2) - apart
        found[:, column] = moved.sum(axis=1) / (2.0 * omega**2) + along**2 * irvine / 24.0
    return found


def _coupling(network: Network, number: int, irvine: float, omega: Array) -> Array:
    """The share g_n of the wave across that is nearest to each frequency, shape (modes,).

    A wave of an even number of half-waves couples as far as stretch or tension is uneven along the span.
    """
    drive, statics = network.drive, network.statics
    own = drive.free_spans[number]
    half_waves = np.maximum(1.0, np.round(omega / _first(network, number)))
    rope, tension = drive.ropes[own.route], float(statics.mean[number])
    phase = omega * own.length * np.sqrt(rope.density / rope.axial_rigidity)
    uneven = np.minimum(1.0, phase + abs(float(statics.end[number] - statics.start[number])) / tension)
    even = np.where(half_waves % 2 == 0, uneven, 1.0)
    return np.asarray(even * sqrt(8.0 * irvine) / (pi * half_waves) ** 2)


def _first(network: Network, number: int) -> float:
    """First frequency across of a span between ends at rest [rad/s]."""
    own = network.drive.free_spans[number]
    return pi / own.length * network.drive.ropes[own.route].wave_speed(float(network.statics.mean[number]))


def _shares(network: Network, modes: Sequence[Mode], number: int, way: str) -> Array:
    """Strain energy of one span in one direction, of all in a shape, over all shapes, shape (modes,)."""
    key = f"{network.drive.free_spans[number].name}, {way}"
    return np.array([mode.multiplicity * max(mode.strain_shares.get(key, 0.0), 0.0) for mode in modes])


def _is_listed(mode: Mode, listed: Sequence[Mode]) -> bool:
    """Whether a mode is one of a list, found a second time."""
    return any(
        own.kind == mode.kind
        and (own.span, own.plane, own.clamped) == (mode.span, mode.plane, mode.clamped)
        and abs(own.frequency - mode.frequency) <= 1e-9 * own.frequency
        for own in listed
    )
