"""Chapter 2: the numbers of the difference scheme."""

import numpy as np

from reproduction.drives import packaged
from reproduction.items import Outcome

COURANT, SEGMENTS = 0.999, 100


def section_2_4(quick: bool) -> Outcome:
    """The Courant number below one, with the print's wave speed and with the right one."""
    true = COURANT * float(np.sqrt(1.0 + packaged("dissertation-2").cable.prestrain))
    grown, kept = amplification(true), amplification(COURANT)
    found = {"true": true, "stable": COURANT / true, "grown": grown, "kept": kept}
    return found | {"section_2_4_courant": grown < 1.0 + 1e-9}, []


def amplification(courant: float) -> float:
    """Growth per step of the shortest wave of the linear scheme, one where it is stable."""
    # |g| of g^2 - (2 - 4 sigma^2 sin^2(pi (n - 1) / 2 n)) g + 1 = 0
    bend = 4.0 * courant**2 * np.sin(0.5 * np.pi * (SEGMENTS - 1) / SEGMENTS) ** 2
    return float(np.max(np.abs(np.roots([1.0, bend - 2.0, 1.0]))))
