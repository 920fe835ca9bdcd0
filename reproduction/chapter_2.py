"""Chapter 2: the numbers of the difference scheme."""

import numpy as np

from cabledrive.parameters import load_drive
from reproduction.item import Entry, Outcome, outcome, place
from reproduction.judge import erratum

COURANT = 0.999
SEGMENTS = 100


def section_2_4(quick: bool) -> Outcome:
    """The Courant number below one, with the print's wave speed and with the right one; the spacing.

    ``quick``: changes nothing here.
    """
    true = COURANT * float(np.sqrt(1.0 + load_drive("dissertation-2").cable.prestrain))
    growth = [amplification(courant) for courant in (COURANT, true)]
    why = (
        f"c_u of (2.31) lacks the prestrain: {COURANT} by (2.31) is really {true:.4f}, and the shortest wave "
        f"of {SEGMENTS} segments grows {growth[1]:.3f} times per step; at a true {COURANT} it grows "
        f"{growth[0]:.3f} "
        f"times. {place('erratum-2-31-wave-speed')}"
    )
    return outcome(
        [
            erratum(
                "section-2-4-courant",
                "Section 2.4, (2.31): stable where sigma < 1",
                "sigma < 1",
                f"sigma < {COURANT / true:.4f}",
                "",
                why,
            ),
            erratum(
                "section-2-4-spacing",
                "Section 2.4, (2.31): spacing of n segments",
                "dx = Le/(n - 1)",
                "dx = Le/n",
                "",
                f"n segments of the printed length do not fit the span. {place('erratum-2-31-spacing')}",
            ),
        ]
    )


def amplification(courant: float) -> float:
    r"""Growth per step of the shortest wave of the linear scheme.

    .. math:: |g|, \qquad g^2 - (2 - 4\sigma^2\sin^2\tfrac{\pi(n-1)}{2n})g + 1 = 0

    Returns one where it is stable.
    """
    bend = 4.0 * courant**2 * np.sin(0.5 * np.pi * (SEGMENTS - 1) / SEGMENTS) ** 2
    return float(np.max(np.abs(np.roots([1.0, bend - 2.0, 1.0]))))


ENTRIES = (Entry(name="section-2-4", chapter="2", covers=("Section 2.4",), compute=section_2_4),)
