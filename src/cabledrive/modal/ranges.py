"""Where the models of ropes hold, and what a user must know of a list of modes."""

from collections.abc import Iterator, Sequence
from math import pi, sqrt

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.pieces import Piece, wrap_at
from cabledrive.mechanics.network.rest_forces import sag_parameter
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.modal.mode import LONGITUDINAL, TRANSVERSE
from cabledrive.modal.motion import Mode
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.cable import Rope

INCOMPLETE = "the count gives more modes than could be found and proven"
ALLOWED = 1e-3
"""Relative error of a frequency by sag or by a changing tension up to which the list is certified."""
FAST = 0.8
"""Share of the critical speed above which a warning is given."""


def sag_errors(irvine: Array) -> Array:
    r"""Largest relative shift of the first mode of each span by its sag, :math:`4\lambda^2/\pi^4`."""
    return 4.0 * irvine / pi**4


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


def curvature_error(rope: Rope, tension: float, length: float, bent: float) -> float:
    r"""Relative shift of a span's modes by the rope's curvature where it leaves its pulleys, a bound.

    It decays as :math:`e^{-x/e}/r`, so that a motion across stretches the rope, and shifts a frequency by
    :math:`EA\,EI^2 (1/r_1 + 1/r_2)^2/(4 T^3 L^2)` at most; ``bent``: the bracket [1/m].
    """
    stiffness = rope.axial_rigidity * (rope.bending_stiffness or 0.0) ** 2
    return stiffness * bent**2 / (4.0 * tension**3 * length**2)


def range_limit(network: Network, listed: Sequence[Mode]) -> str | None:
    """Why a list is not certified although the count agrees: a span outside the range of its model."""
    irvine = irvine_parameters(network)
    sag = sag_errors(irvine)
    highest: dict[str, float] = {}
    for mode in listed:
        if mode.kind == TRANSVERSE and mode.span is not None:
            highest[mode.span] = max(mode.frequency, highest.get(mode.span, 0.0))
    called = {piece.span: piece.rest.span for piece in network.pieces}
    for number, span in enumerate(network.drive.free_spans):
        name = called[number]
        if name not in highest:
            continue
        runs = bool(network.drive.route[span.route].speed)
        part = _parted(listed, name, irvine[number]) if runs else 0.0
        bent = sum(1.0 / place.radius for place in (span.start, span.end) if place.sense)
        at_rest = network.drive.ropes[span.route], float(network.statics.mean[number]), span.length
        for error, what in (
            (max(sag[number], part) if runs else 0.0, "sag"),
            (gradient_error(network, number) if runs else 0.0, "weight along it"),
            (curvature_error(*at_rest, bent), "curvature at the pulleys"),
            (bending_error(network, number, highest[name]), "bending stiffness while it runs"),
        ):
            if error > ALLOWED:
                said = f"the {what} of span {name} moves a listed mode by up to {error:.2g} of its frequency"
                return f"{said}, more than {ALLOWED:g}, and is left out: raise the pretension"
    return None


def _parted(listed: Sequence[Mode], span: str, irvine: float) -> float:
    r"""How far sag parts modes along and across a span that meet, :math:`\sqrt{2}\,\lambda/\pi^2`, or 0."""
    half = sqrt(2.0 * irvine) / pi**2
    along, across = (
        np.array(
            [m.frequency for m in listed if m.kind == kind and span in [own for own, _ in m.strain_by_span]]
        )
        for kind in (LONGITUDINAL, TRANSVERSE)
    )
    return half if np.any(np.abs(along[:, None] - across) < 2.0 * half * across) else 0.0


def route_range_warnings(network: Network) -> Iterator[str]:
    """Warnings that touch a list of a machine with routes."""
    yield from unheld_words(network.motion, network.statics)
    for number, route in enumerate(network.drive.route):
        if not route.speed:
            continue
        spans = [i for i, span in enumerate(network.drive.free_spans) if span.route == number]
        rope = network.drive.ropes[number]
        slowest = min(rope.wave_speed(float(network.statics.mean[i])) for i in spans)
        if abs(route.speed) > FAST * slowest:
            yield (
                f"route {route.name} runs at {abs(route.speed):.4g} m/s, {abs(route.speed) / slowest:.0%} of "
                f"the wave speed {slowest:.4g} m/s at which its spans lose their stiffness"
            )
        if rope.bending_stiffness:
            most = max(bending_error(network, i) for i in spans)
            yield (
                f"route {route.name} runs: its bending stiffness is left out, which would raise mode n of a "
                f"span by up to {most:.2g} n^2 of it"
            )
    yield from sag_words(network, hanging=True)


def sag_words(network: Network, *, hanging: bool = False, least: float = 1e-4) -> Iterator[str]:
    """Spans whose first mode is moved by more than a share by sag that is left out."""
    drive = network.drive
    errors = sag_errors(irvine_parameters(network)).tolist()
    for span, error in zip(drive.free_spans, errors, strict=True):
        if error > least and not (hanging and not drive.route[span.route].speed):
            yield (
                f"sag, which is left out, moves the first mode of span {span.name} by up to {error:.2g} of it"
            )


def _slopes_at_pulleys(network: Network) -> Iterator[tuple[Piece, bool, float]]:
    """Pieces that end at a pulley and do not run, whether they start there, and their slope to the chord."""
    for piece in network.pieces:
        for start in (True, False):
            place, (cosine, sine) = piece.place(start), piece.direction(start)
            if place is not None and place.sense and not piece.route.speed:
                yield piece, start, sine / cosine


def lifted_limit(network: Network) -> str | None:
    """Why a rope does not lie on a pulley: sag turns it, at both its ends together, by more than it wraps."""
    drive = network.drive
    left = {i: span.wrap for i, span in enumerate(drive.free_spans) if span.wrap is not None}
    for piece, start, slope in _slopes_at_pulleys(network):
        place, wrap = piece.place(start), wrap_at(drive, piece.span, start)
        if place is not None and wrap is not None:
            left[wrap[0]] += (place.sense if start else -place.sense) * slope
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
