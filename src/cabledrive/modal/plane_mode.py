"""A mode in the plane of gravity, and modes of one frequency distinguished by their sections."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cabledrive.modal.section_string import SectionMotion, combined

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PlaneMode:
    """One mode of the plane of gravity.

    Attributes
    ----------
    omega : float
        [rad/s].
    proven : bool
        Whether counts on both sides of the enclosure prove it.
    along : float
        Share of the kinetic energy in the motion along the cable [-].
    shares : ndarray, shape (sections,)
        Share in the motion across of each section [-].
    parts : tuple of SectionMotion
        Motion of each section, of unit modal mass.
    """

    omega: float
    proven: bool
    along: float
    shares: Array
    parts: tuple[SectionMotion, ...]


def localised(cluster: list[PlaneMode]) -> list[PlaneMode]:
    """Modes of one frequency, combined anew so that each moves as few sections as can be.

    Their shapes may be combined at will; the combinations that make the sum over the sections of section
    number times share stationary are the same whatever the start, and are the sections themselves where these
    ring alone.

    ``cluster``: of unit modal mass.
    Returns as many.
    """
    if len(cluster) == 1:
        return cluster
    sections = range(len(cluster[0].parts))
    products = [[[a.parts[i].product(b.parts[i]) for b in cluster] for a in cluster] for i in sections]
    weighted = sum((number + 1.0) * np.array(product) for number, product in enumerate(products))
    turns = np.linalg.eigh(weighted)[1]
    found = []
    for turn in turns.T:
        parts = tuple(combined([mode.parts[i] for mode in cluster], turn) for i in sections)
        shares = np.array([part.mass for part in parts])
        along = float(turn**2 @ [mode.along for mode in cluster])
        proven = all(mode.proven for mode in cluster)
        found.append(PlaneMode(cluster[0].omega, proven, along, shares, parts))
    return found
