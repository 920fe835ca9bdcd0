"""The determinant of the modal matrix against frequency, as in Figs. 3.1 and 3.2."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import longitudinal_modes
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.studies.varied_drive import stamped
from reproduction.printed_matrices import loop_matrix

if TYPE_CHECKING:
    import xarray as xr

WHOLE = np.linspace(0.0, 3000.0, 3001)
ZOOMED = np.linspace(0.0, 200.0, 801)
"""The frequencies of the two views of Figs. 3.1 and 3.2 [Hz]; the ranges of the print are lost."""


def modal_determinant(drive: Drive, frequencies: Sequence[float] | Array = WHOLE) -> "xr.Dataset":
    """Determinant of the matrix (3.13) against frequency, with the modes of the drive beside it.

    Parameters
    ----------
    drive : Drive
        A loop without carriages.
    frequencies : array_like, shape (f,), optional
        Frequencies [Hz]; 0 to 3000 Hz where none are given, `ZOOMED` for the enlarged view.

    Returns
    -------
    xarray.Dataset
        ``determinant`` over ``frequency`` [Hz]; ``natural_frequency`` [Hz] and ``family`` over ``mode``:
        every mode up to the highest of the frequencies.

    Raises
    ------
    InputRefused
        If the drive is not a loop without carriages.
    """
    import xarray as xr

    frequency = np.asarray(frequencies, dtype=float)
    determinant = [np.linalg.det(loop_matrix(drive, 2 * np.pi * f)) for f in frequency]
    modes = longitudinal_modes(drive, below=float(frequency.max()))
    data = xr.Dataset(
        {
            "determinant": ("frequency", determinant, {"units": "1", "long_name": "determinant of (3.13)"}),
            "natural_frequency": ("mode", [mode.frequency for mode in modes], {"units": "Hz"}),
            "family": ("mode", np.array([mode.family for mode in modes], dtype=object)),
        },
        {"frequency": ("frequency", frequency, {"units": "Hz"}), "mode": np.arange(len(modes))},
    )
    return stamped(data, drive, "determinant of the modal matrix")
