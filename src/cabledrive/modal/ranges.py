r"""Where the models of ropes hold, and what a user must know of a list of modes.

Curvature :math:`\kappa` lets a motion w across stretch the rope by :math:`-\kappa w`. The n-th wave across
then couples to an even stretch by :math:`g_n = \sqrt 8\,\lambda/(\pi^2 n^2)` of the geometric mean of both
stiffnesses: where the two frequencies are equal they part by :math:`\pm g_n/2`, of first order in the sag.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from math import pi, sqrt

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.motion import ACROSS, ALONG
from cabledrive.mechanics.network.pieces import wrap_at
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.modal.motion import Mode
from cabledrive.modal.networks import ModalNetwork
from cabledrive.modal.pieces import sag_parameter
from cabledrive.modal.spectrum import Spectrum
from cabledrive.parameters.arrays import Array

INCOMPLETE = "the count gives more modes than could be found and proven"
ALLOWED = 1e-3
"""Relative error of a frequency by sag or by a changing tension up to which the list is certified."""
FAST = 0.8
"""Share of the critical speed above which a warning is given."""
BEYOND = 1.5
"""Modes up to so many times the highest listed one may meet it; the others lie within the shift at rest."""


def sag_coupling_limit(
    network: Network,
    listed: Sequence[Mode],
    below: Callable[[float], list[Mode]],
    straight: Collection[int],
) -> str | None:
    """Why sag leaves a list uncertified by coupling motion along and across; None where it does not.

    ``below``: all modes below a frequency [rad/s]; ``straight``: spans whose sag is left out.
    """
    every = irvine_parameters(network)
    spans = {span: float(every[span]) for span in straight if sqrt(2 * every[span]) > ALLOWED * pi**2}
    if not spans or not listed:
        return None
    highest = 2 * pi * max(mode.frequency for mode in listed)
    meets = max(_first(network, i) * sqrt(sqrt(2 * own) / pi**2 / ALLOWED) for i, own in spans.items())
    found = below(BEYOND * min(highest, meets))
    together = [*listed, *(mode for mode in found if not any(_same(mode, own) for own in listed))]
    shifts = coupling_shifts(network, together, spans)[: len(listed)]
    worst = int(np.argmax(shifts.sum(axis=1)))
    error = float(shifts[worst].sum())
    if error <= ALLOWED:
        return None
    span = network.drive.free_spans[list(spans)[int(np.argmax(shifts[worst]))]].name
    return (
        f"sag, which is left out, couples motion along and across span {span} and moves the mode at "
        f"{together[worst].frequency:.5g} Hz by about {error:.2g} of its frequency, more than {ALLOWED:g}: "
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


def _same(a: Mode, b: Mode) -> bool:
    """Whether two modes are one, found a second time."""
    alike = (a.kind, a.span, a.plane, a.clamped) == (b.kind, b.span, b.plane, b.clamped)
    return alike and abs(a.frequency - b.frequency) <= 1e-9 * b.frequency


def sag_errors(network: Network) -> Array:
    r"""Largest relative shift of the first mode of each span by its sag, :math:`4\lambda^2/\pi^4`."""
    return 4.0 * irvine_parameters(network) / pi**4


def gradient_error(network: Network, span: int) -> float:
    r"""Relative error of an even string of the same travel time, :math:`(\Delta T/\bar T)^2/300`.

    Against the roots of :math:`J_0(z_a) Y_0(z_b) - J_0(z_b) Y_0(z_a)` it is 6.5e-4 where the tension grows
    from 300 N to 473 N, and 2e-5 from 2000 N to 2173 N; higher modes err less.
    """
    statics = network.statics
    return float((statics.end[span] - statics.start[span]) ** 2 / statics.mean[span] ** 2 / 300.0)


def bending_error(network: Network, span: int, frequency: float = 0.0) -> float:
    r"""Relative error of a frequency by bending stiffness that is left out, :math:`(n\pi e/L)^2/2`.

    Only ropes that run leave it out. ``frequency``: of the mode [Hz]; default: the first one.
    """
    drive = network.drive
    own = drive.free_spans[span]
    rope, route = drive.ropes[own.route], drive.route[own.route]
    if not route.speed or not rope.bending_stiffness:
        return 0.0
    tension = float(network.statics.mean[span])
    slack = tension - rope.density * route.speed**2 / (1.0 + tension / rope.axial_rigidity)
    half_waves = max(1.0, 2.0 * own.length * frequency / rope.wave_speed(tension))
    return 0.5 * (half_waves * pi / own.length) ** 2 * rope.bending_stiffness / slack


def curvature_error(network: Network, span: int) -> float:
    r"""Relative shift of a span's modes by the rope's curvature where it leaves its pulleys, a bound.

    It decays as :math:`e^{-x/e}/r`, so that a motion across stretches the rope, and shifts a frequency by
    :math:`EA\,EI^2 (1/r_1 + 1/r_2)^2/(4 T^3 L^2)` at most.
    """
    drive = network.drive
    own = drive.free_spans[span]
    rope = drive.ropes[own.route]
    bent = sum(1.0 / place.radius for place in (own.start, own.end) if place.sense)
    stiffness = rope.axial_rigidity * (rope.bending_stiffness or 0.0) ** 2
    return stiffness * bent**2 / (4.0 * float(network.statics.mean[span]) ** 3 * own.length**2)


def route_limit(network: Network, listed: Sequence[Mode], spectrum: Spectrum, *, hanging: bool) -> str | None:
    """Why a list of a machine with routes is not certified although the count agrees; None where it is.

    ``hanging``: whether its ropes sag.
    """
    straight = _straight(network, hanging)
    return (
        (_lifted(network) if hanging else None)
        or tangent_limit(spectrum.network, listed)
        or range_limit(network, listed, straight)
        or sag_coupling_limit(network, listed, spectrum.below, straight)
    )


def _straight(network: Network, hanging: bool) -> list[int]:
    """Numbers of the spans whose sag is left out: those that run, and all where none hangs."""
    drive = network.drive
    return [i for i, own in enumerate(drive.free_spans) if not hanging or drive.route[own.route].speed]


def range_limit(network: Network, listed: Sequence[Mode], straight: Collection[int]) -> str | None:
    """Why a list is not certified although the count agrees: a span outside the range of its model.

    ``straight``: spans whose sag is left out.
    """
    sag = sag_errors(network)
    highest: dict[str, float] = {}
    for mode in listed:
        if mode.kind == TRANSVERSE and mode.span is not None:
            highest[mode.span] = max(mode.frequency, highest.get(mode.span, 0.0))
    for number, span in enumerate(network.drive.free_spans):
        if span.name not in highest:
            continue
        runs = bool(network.drive.route[span.route].speed)
        for error, what in (
            (sag[number] if number in straight else 0.0, "sag"),
            (gradient_error(network, number) if runs else 0.0, "weight along it"),
            (curvature_error(network, number), "curvature at the pulleys"),
            (bending_error(network, number, highest[span.name]), "bending stiffness while it runs"),
        ):
            if error > ALLOWED:
                return (
                    f"the {what} of span {span.name} moves a listed mode by up to {error:.2g} of "
                    f"its frequency, more than {ALLOWED:g}, and is left out: raise the pretension"
                )
    return None


def route_range_warnings(network: Network, *, hanging: bool) -> Iterator[str]:
    """Warnings that touch a list of a machine with routes; ``hanging``: whether its ropes sag."""
    straight = _straight(network, hanging)
    yield from unheld_words(network.motion, network.statics)
    for number, route in enumerate(network.drive.route):
        spans = [i for i, span in enumerate(network.drive.free_spans) if span.route == number]
        rope = network.drive.ropes[number]
        slowest = min(rope.wave_speed(float(network.statics.mean[i])) for i in spans)
        if abs(route.speed) > FAST * slowest:
            yield (
                f"route {route.name} runs at {abs(route.speed):.4g} m/s, {abs(route.speed) / slowest:.0%} of "
                f"the wave speed {slowest:.4g} m/s at which its spans lose their stiffness"
            )
        if route.speed and network.drive.ropes[number].bending_stiffness:
            most = max(bending_error(network, i) for i in spans)
            yield (
                f"route {route.name} runs: its bending stiffness is left out, which would raise mode n of a "
                f"span by up to {most:.2g} n^2 of it"
            )
    sag = sag_errors(network)
    for number in straight:
        span = network.drive.free_spans[number]
        if sag[number] > 1e-4:
            yield (
                f"sag, which is left out, moves the first mode of span {span.name} "
                f"by up to {sag[number]:.2g} of it"
            )


def tangent_limit(network: ModalNetwork, listed: Sequence[Mode]) -> str | None:
    """Why a list of ropes that sag is not certified: their tangent points stay those of straight ropes.

    A section that grows by a share of its length lowers a mode by that times its share of the strain energy.
    """
    longer: dict[tuple[str, tuple[float, float]], float] = {}
    for rope in network.ropes:
        piece = network.pieces[rope.tags[0][0]]
        key = piece.span, piece.section
        longer[key] = longer.get(key, 0.0) + rope.moved / (piece.section[1] - piece.section[0])
    for mode in listed if max(longer.values(), default=0.0) > ALLOWED else ():
        shares = (share * longer.get((span, own), 0.0) for (span, _, own), share in mode.places.items())
        if (error := sum(shares)) > ALLOWED:
            return (
                "sag moves the points where ropes leave their pulleys, which is left out, and the mode at "
                f"{mode.frequency:.5g} Hz by about {error:.2g} of it, more than {ALLOWED:g}: raise the "
                "pretension"
            )
    return None


def _lifted(network: Network) -> str | None:
    """Why a rope does not lie on a pulley: sag turns it, at both its ends together, by more than it wraps."""
    drive = network.drive
    left = {i: span.wrap for i, span in enumerate(drive.free_spans) if span.wrap is not None}
    for piece in network.pieces:
        for start, (along, across) in ((True, piece.rest.force), (False, piece.rest.end_force)):
            place, wrap = piece.place(start), wrap_at(drive, piece.span, start)
            if place is not None and wrap is not None and not piece.route.speed:
                left[wrap[0]] += (place.sense if start else -place.sense) * across / along
    for number, wrapped in left.items():
        span = drive.free_spans[number]
        if wrapped < 0.0:
            return (
                f"sag lifts the rope off {span.end.name}, it takes {np.degrees(-wrapped):.3g} deg more than "
                f"its wrap of {np.degrees(span.wrap or 0.0):.3g} deg: raise the pretension"
            )
    return None


def irvine_parameters(network: Network) -> Array:
    r"""Irvine's :math:`\lambda^2` of each free span at rest, the largest of its sections, shape (spans,)."""
    irvine = np.zeros(len(network.drive.free_spans))
    for own in network.sections:
        here = own[0].span
        irvine[here] = max(irvine[here], sag_parameter([piece.rest for piece in own]))
    return irvine
