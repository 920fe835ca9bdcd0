"""Where the elements of shallow sag hold: slopes, strain at rest, and ropes that stay on their pulleys."""

from collections.abc import Mapping, Sequence

import numpy as np

from cabledrive.mechanics.network.assembly import Network
from cabledrive.mechanics.network.elements import end_place, wrap_at
from cabledrive.mechanics.network.hanging import HangingElement
from cabledrive.mechanics.network.motion import ACROSS, ALONG
from cabledrive.modal.mode import Mode


def hanging_limit(
    network: Network, elements: Mapping[int, HangingElement], listed: Sequence[Mode], allowed: float
) -> str | None:
    """Why a list with hanging ropes is not certified although the count agrees; None where it is.

    ``elements``: by the number of their piece; ``allowed``: relative error of a frequency.
    """
    lifted = _lifted(network, elements)
    if lifted is not None:
        return lifted
    names = [span.name for span in network.drive.free_spans]
    errors: dict[str, float] = {}
    for piece, element in elements.items():
        span = names[network.pieces[piece].span]
        errors[span] = max(slope_error(element), errors.get(span, 0.0))
    for mode in listed:
        shares = mode.strain_shares
        parts = {
            span: error * min(1.0, sum(shares.get(f"{span}, {way}", 0.0) for way in (ALONG, ACROSS)))
            for span, error in errors.items()
        }
        if sum(parts.values()) > allowed:
            span = max(parts, key=lambda name: parts[name])
            return (
                f"span {span} sags so deep that shallow sag errs by up to {sum(parts.values()):.2g} of the "
                f"mode at {mode.frequency:.5g} Hz, more than {allowed:g}: raise the pretension"
            )
    return None


def slope_error(element: HangingElement) -> float:
    r"""Relative error of a frequency by shallow sag, an estimate: :math:`\theta^2 + \min(g, 1)\,T/EA`.

    :math:`\theta` is the steepest slope against the chord, :math:`g = \sqrt 8\,\lambda/\pi^2` the coupling of
    motion along and across, which the tension at rest changes by T/EA of it. Against cables divided about
    their catenaries, 100 random machines, the largest error found is 0.96 of it.
    """
    strain = element.tension / element.axial_rigidity
    coupling = np.sqrt(8.0 * element.hanging.irvine(element.axial_rigidity)) / np.pi**2
    return float(np.abs(element.hanging.end_slopes).max() ** 2 + min(coupling, 1.0) * strain)


def _lifted(network: Network, elements: Mapping[int, HangingElement]) -> str | None:
    """Why a rope does not lie on a pulley: sag turns it, at both its ends together, by more than it wraps."""
    drive = network.drive
    left = {i: span.wrap for i, span in enumerate(drive.free_spans) if span.wrap is not None}
    for number, element in elements.items():
        piece = network.pieces[number]
        near, far = element.hanging.end_slopes.tolist()
        for start, slope in ((True, near), (False, -far)):
            place, wrap = end_place(drive, piece, start), wrap_at(drive, piece.span, start)
            if place is not None and wrap is not None:
                left[wrap[0]] += place.sense * slope
    for number, wrapped in left.items():
        span = drive.free_spans[number]
        if wrapped < 0.0:
            return (
                f"sag lifts the rope off {span.end.name}, it takes {np.degrees(-wrapped):.3g} deg more than "
                f"its wrap of {np.degrees(span.wrap or 0.0):.3g} deg: raise the pretension"
            )
    return None
