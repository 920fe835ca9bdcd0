"""Chapter 2: the numbers of the difference scheme."""

import numpy as np

from cabledrive.parameters import load_drive
from reproduction.items import Outcome

SHEET = """
## section-2-4 section_2_4: Section 2.4
section-2-4-courant | Section 2.4, (2.31): stable where sigma < 1 | arithmetic
  printed: sigma < 1
  computed: sigma < {stable:.4f}
  erratum: c_u of (2.31) lacks the prestrain: {COURANT} by (2.31) is really {true:.4f}, and the shortest wave of
    {SEGMENTS} segments grows {grown:.3f} times per step; at a true {COURANT} it grows {kept:.3f} times.
    #erratum-2-31-wave-speed
section-2-4-spacing | Section 2.4, (2.31): spacing of n segments
  printed: dx = Le/(n - 1)
  computed: dx = Le/n
  erratum: n segments of the printed length do not fit the span. #erratum-2-31-spacing
"""
COURANT, SEGMENTS = 0.999, 100


def section_2_4(quick: bool) -> Outcome:
    """The Courant number below one, with the print's wave speed and with the right one."""
    true = COURANT * float(np.sqrt(1.0 + load_drive("dissertation-2").cable.prestrain))
    grown, kept = amplification(true), amplification(COURANT)
    found = {"true": true, "stable": COURANT / true, "grown": grown, "kept": kept}
    return found | {"section_2_4_courant": grown < 1.0 + 1e-9}, []


def amplification(courant: float) -> float:
    r"""Growth per step of the shortest wave of the linear scheme, one where it is stable.

    .. math:: |g|, \qquad g^2 - (2 - 4\sigma^2\sin^2\tfrac{\pi(n-1)}{2n})g + 1 = 0
    """
    bend = 4.0 * courant**2 * np.sin(0.5 * np.pi * (SEGMENTS - 1) / SEGMENTS) ** 2
    return float(np.max(np.abs(np.roots([1.0, bend - 2.0, 1.0]))))
