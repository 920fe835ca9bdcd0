"""How far a span is from a straight line, and from a direction."""

from math import hypot

from cabledrive.parameters.arrays import Array
from cabledrive.parameters.route.geometry import FreeSpan


def sag_parameter(rigidity: float, tension: float, load: Array, span: FreeSpan) -> float:
    r"""Irvine's :math:`\lambda^2 = (w L/T)^2\,EA/T` of a rope, w the weight across it per metre."""
    across = abs(load[0] * span.across[0] + load[1] * span.across[1])
    return (across * span.length / tension) ** 2 * rigidity / tension


def lean(span: FreeSpan, direction: tuple[float, float]) -> float:
    """Sine of the angle between a span and a direction."""
    cross = span.along[0] * direction[1] - span.along[1] * direction[0]
    return abs(cross) / hypot(*direction)
