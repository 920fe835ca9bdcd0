"""Where the model of straight strings of even tension holds, and what a user must know of the list."""

from collections.abc import Iterator, Sequence
from math import pi

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.straightness import sag_parameter
from cabledrive.modal.mode import TRANSVERSE, Mode

ALLOWED = 1e-3
"""Relative error of a frequency by sag or by a changing tension up to which the list is certified."""

FAST = 0.8
"""Share of the critical speed above which a warning is given."""


def sag_error(network: Network, span: int) -> float:
    r"""Largest relative shift of the first mode of a span by its sag, :math:`4\lambda^2/\pi^4`."""
    drive, statics = network.drive, network.statics
    own = drive.free_spans[span]
    rigidity = drive.ropes[own.route].axial_rigidity
    return 4.0 * sag_parameter(rigidity, float(statics.mean[span]), statics.line_load[span], own) / pi**4


def gradient_error(network: Network, span: int) -> float:
    r"""Relative error of a string of the same travel time, :math:`(\Delta T/\bar T)^2/300`.

    Against the roots of :math:`J_0(z_a) Y_0(z_b) - J_0(z_b) Y_0(z_a)` it is 6.5e-4 where the tension grows
    from 300 N to 473 N, and 2e-5 from 2000 N to 2173 N; higher modes err less.
    """
    statics = network.statics
    return float((statics.end[span] - statics.start[span]) ** 2 / statics.mean[span] ** 2 / 300.0)


def range_limit(network: Network, listed: Sequence[Mode]) -> str | None:
    """Why a list is not certified although the count agrees: a span outside the range of its model."""
    vibrating = {mode.span for mode in listed if mode.kind == TRANSVERSE}
    for number, span in enumerate(network.drive.free_spans):
        for error, what in (
            (sag_error(network, number), "sag"),
            (gradient_error(network, number), "weight along it"),
        ):
            if error > ALLOWED and span.name in vibrating:
                return (
                    f"the {what} of span {span.name} moves its first mode by up to {error:.2g} of "
                    "its frequency, more "
                    f"than {ALLOWED:g}: it is listed as a straight string of even tension; raise "
                    "the pretension"
                )
    return None


def range_warnings(network: Network) -> Iterator[str]:
    """Warnings that touch the list, one line each."""
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
    for number, span in enumerate(network.drive.free_spans):
        sag = sag_error(network, number)
        if sag > 1e-4:
            yield f"sag, which is left out, moves the first mode of span {span.name} by up to {sag:.2g} of it"
