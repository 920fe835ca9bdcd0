"""Where the models of straight ropes hold, and what a user must know of the list."""

from collections.abc import Collection, Iterator, Sequence
from math import pi

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.elements import element_of
from cabledrive.mechanics.network.hanging import irvine_parameters
from cabledrive.mechanics.network.motion import ACROSS, Array
from cabledrive.mechanics.network.unheld import unheld_words
from cabledrive.modal.mode import TRANSVERSE, Mode

ALLOWED = 1e-3
"""Relative error of a frequency by sag or by a changing tension up to which the list is certified."""

FAST = 0.8
"""Share of the critical speed above which a warning is given."""


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


def step_error(network: Network, span: int) -> float:
    """Relative error of a frequency by the changing tension: of running ropes, and by the steps of beams."""
    if network.drive.route[network.drive.free_spans[span].route].speed:
        return gradient_error(network, span)
    elements = [element_of(network.drive, piece, ACROSS) for piece in network.pieces if piece.span == span]
    return max(0.0 if element is None else element.step_error for element in elements)


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
        for error, what in (
            (sag[number] if number in straight else 0.0, "sag"),
            (step_error(network, number), "weight along it"),
            (curvature_error(network, number), "curvature at the pulleys"),
            (bending_error(network, number, highest[span.name]), "bending stiffness while it runs"),
        ):
            if error > ALLOWED:
                return (
                    f"the {what} of span {span.name} moves a listed mode by up to {error:.2g} of "
                    f"its frequency, more than {ALLOWED:g}, and is left out: raise the pretension"
                )
    return None


def range_warnings(network: Network, straight: Collection[int]) -> Iterator[str]:
    """Warnings that touch the list, one line each; ``straight``: spans whose sag is left out."""
    yield from unheld_words(network.motion, network.statics)
    for number, route in enumerate(network.drive.route):
        spans = [i for i, span in enumerate(network.drive.free_spans) if span.route == number]
        rope = network.drive.ropes[number]
        slowest = min(rope.wave_speed(float(network.statics.mean[i])) for i in spans)
        if abs(route.speed) > FAST * slowest:
            yield (
                f"route {route.name} runs at {abs(route.speed):.4g} m/s, "
                f"{abs(route.speed) / slowest:.0%} of the wave "
                f"speed {slowest:.4g} m/s at which its spans lose their stiffness"
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
