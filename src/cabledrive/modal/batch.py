"""Certified longitudinal spectra of many drives in one call, each as `natural_frequencies` gives it alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChainBatch:
    """Chains of one build with numbers of their own, as `cabledrive.mechanics.chain.Chain` describes one.

    Attributes
    ----------
    times : ndarray, shape (n, m)
        Travel times of the segments [s].
    masses, grounds : ndarray, shape (n, j)
        Masses of the joints [kg] and their springs to the ground [N/m].
    impedance : ndarray, shape (n,)
        Wave impedance [kg/s].
    pendant : ndarray, shape (n, 3)
        Stiffness [N/m], mass [kg] and stiffness to the ground [N/m] of the motor behind a flexible joint, on
        the first joint; zeros where there is none.
    closed : bool
        Whether the chains are rings; a line has free ends.
    """

    times: Array
    masses: Array
    grounds: Array
    impedance: Array
    pendant: Array
    closed: bool


def many_spectra(chains: ChainBatch, wanted: int) -> tuple[Array, NDArray[np.bool_]]:
    """The first natural frequencies of each chain, proven by counts.

    Returns ``omega``, shape (n, wanted) [rad/s]; ``done``, shape (n,): false where a mode is multiple or
    round-off clouds a count, which the search of one chain settles.
    """
    from cabledrive.modal.batch_kernels import spectra

    count = chains.times.shape[0]
    held = (chains.pendant[:, 2] > 0.0) | np.any(chains.grounds > 0.0, axis=1)
    omegas, found = np.full((count, wanted), np.nan), np.zeros(count, dtype=np.int64)
    spectra(
        np.ascontiguousarray(chains.times),
        np.ascontiguousarray(chains.masses),
        np.ascontiguousarray(chains.grounds),
        np.ascontiguousarray(chains.impedance),
        np.ascontiguousarray(chains.pendant),
        0,
        chains.closed,
        np.where(held, 0, 1).astype(np.int64),
        omegas,
        found,
    )
    return omegas, found == wanted
