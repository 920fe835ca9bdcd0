"""Where the models of ropes hold, and what a user must know of a list of modes."""

from collections.abc import Iterator, Sequence
from math import pi

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.pieces import wrap_at
from cabledrive.mechanics.network.rest_forces import sag_parameter
from cabledrive.mechanics.network.statics import unheld_words
from cabledrive.modal.mode import TRANSVERSE
from cabledrive.modal.motion import Mode
from cabledrive.parameters.cable import Rope

INCOMPLETE = "the count gives more modes than could be found and proven"
ALLOWED = 1e-3
"""Relative error of a frequency by what is left out up to which the list is certified."""
FAST = 0.8
"""Share of the critical speed above which a warning is given."""


def curvature_error(rope: Rope, tension: float, length: float, bent: float) -> float:
    r"""Relative shift of a span's modes by the rope's curvature where it leaves its pulleys, a bound.

    It decays as :math:`e^{-x/e}/r`, so that a motion across stretches the rope, and shifts a frequency by
    :math:`EA\,EI^2 (1/r_1 + 1/r_2)^2/(4 T^3 L^2)` at most; ``bent``: the bracket [1/m].
    """
    stiffness = rope.axial_rigidity * (rope.bending_stiffness or 0.0) ** 2
    return stiffness * bent**2 / (4.0 * tension**3 * length**2)


def range_limit(network: Network, listed: Sequence[Mode]) -> str | None:
    """Why a list is not certified although the count agrees: a span outside the range of its model."""
    spans = {mode.span for mode in listed if mode.kind == TRANSVERSE}
    called = {piece.span: piece.rest.span for piece in network.pieces}
    for number, span in enumerate(network.drive.free_spans):
        if called[number] not in spans:
            continue
        bent = sum(1.0 / place.radius for place in (span.start, span.end) if place.sense)
        tension = float(network.statics.mean[number]) - network.statics.stretches[number][0].flow
        error = curvature_error(network.drive.ropes[span.route], tension, span.length, bent)
        if error > ALLOWED:
            return (
                f"the curvature at the pulleys of span {called[number]} moves a listed mode by up to "
                f"{error:.2g} of its frequency, more than {ALLOWED:g}, and is left out: raise the pretension"
            )
    return None


def route_range_warnings(network: Network) -> Iterator[str]:
    """Warnings that touch a list of a machine with routes."""
    yield from unheld_words(network.motion, network.statics)
    for number, route in enumerate(network.drive.route):
        if not route.speed:
            continue
        spans = [i for i, span in enumerate(network.drive.free_spans) if span.route == number]
        rope = network.drive.ropes[number]
        slowest = min(rope.wave_speed(rope.pretension or float(network.statics.mean[i])) for i in spans)
        rate = max(abs(route.speed) / network.drive.free_spans[i].length for i in spans)
        yield (
            f"route {route.name} runs and takes its strain with it over the wheels, which is left out: what "
            f"stretches a span is damped at up to {rate:.3g} 1/s, a mode of f Hz moves by up to "
            f"({rate / (2.0 * pi):.3g}/f)^2/2 of it"
        )
        if abs(route.speed) > FAST * slowest:
            yield (
                f"route {route.name} runs at {abs(route.speed):.4g} m/s, {abs(route.speed) / slowest:.0%} of "
                f"the wave speed {slowest:.4g} m/s at which its spans lose their stiffness"
            )


def sag_words(network: Network, least: float = 1e-4) -> Iterator[str]:
    r"""Spans whose first mode is moved by more than a share, :math:`4\lambda^2/\pi^4`, by sag left out."""
    irvine = np.zeros(len(network.drive.free_spans))
    for own in network.sections:
        here = own[0].span
        irvine[here] = max(irvine[here], sag_parameter([piece.rest for piece in own]))
    for span, error in zip(network.drive.free_spans, (4.0 * irvine / pi**4).tolist(), strict=True):
        if error > least:
            yield (
                f"sag, which is left out, moves the first mode of span {span.name} by up to {error:.2g} of it"
            )


def lifted_limit(network: Network) -> str | None:
    """Why a rope does not lie on a pulley: sag turns it, at both its ends together, by more than it wraps."""
    drive = network.drive
    left = {i: span.wrap for i, span in enumerate(drive.free_spans) if span.wrap is not None}
    for piece in network.pieces:
        for start in (True, False):
            place, wrap = piece.place(start), wrap_at(drive, piece.span, start)
            if place is not None and wrap is not None:
                cosine, sine = piece.direction(start)
                left[wrap[0]] += (place.sense if start else -place.sense) * sine / cosine
    for number, wrapped in left.items():
        span = drive.free_spans[number]
        if wrapped < 0.0:
            return (
                f"sag lifts the rope off {span.end.name}, it takes {np.degrees(-wrapped):.3g} deg more than "
                f"its wrap of {np.degrees(span.wrap or 0.0):.3g} deg: raise the pretension"
            )
    return None
