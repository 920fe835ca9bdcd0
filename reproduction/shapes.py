"""Shapes of the lowest modes along the spans, as in Figs. 3.3, 3.4 and 3.9."""

from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import Mode, longitudinal_modes
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.studies.varied_drive import stamped

if TYPE_CHECKING:
    import xarray as xr


def mode_shapes(drive: Drive, *, modes: int = 1, points: int = 201) -> "xr.Dataset":
    """Longitudinal displacement along each span in the lowest modes, largest value 1.

    The largest displacement, the first if there are several, is positive. Displacements count along each
    span's own direction (upper: drive to load, lower: load to drive).

    Parameters
    ----------
    drive : Drive
    modes : int, default 1
        How many modes, from the lowest.
    points : int, default 201
        Points along each span, both rims included.

    Returns
    -------
    xarray.Dataset
        ``displacement`` over ``mode``, ``span``, ``position`` (unstretched, from the pulley where the span
        starts [m]); ``frequency`` [Hz] and ``family`` over ``mode``; ``carriage_displacement`` over ``mode``
        and ``carriage``, with ``carriage_span`` and ``carriage_position`` [m].
    """
    import xarray as xr

    positions = np.linspace(0.0, drive.span_length, points)
    found = [(mode, i) for mode in longitudinal_modes(drive, count=modes) for i in range(mode.multiplicity)]
    shapes, carried = _normalised(drive, found[:modes], positions)
    data = xr.Dataset(
        {
            "displacement": (("mode", "span", "position"), shapes, {"units": "1"}),
            "frequency": ("mode", [mode.frequency for mode, _ in found[:modes]], {"units": "Hz"}),
            "family": ("mode", np.array([mode.family for mode, _ in found[:modes]], dtype=object)),
            "carriage_displacement": (("mode", "carriage"), carried, {"units": "1"}),
        },
        {
            "mode": np.arange(modes),
            "span": list(drive.spans),
            "position": ("position", positions, {"units": "m", "long_name": "unstretched position"}),
            "carriage_span": ("carriage", [carriage.span for carriage in drive.carriage]),
            "carriage_position": (
                "carriage",
                np.array([carriage.position for carriage in drive.carriage], dtype=float),
                {"units": "m"},
            ),
        },
    )
    return stamped(data, drive, "mode shapes")


def _normalised(drive: Drive, found: list[tuple[Mode, int]], positions: Array) -> tuple[Array, Array]:
    shapes = np.array([[mode.shape(span, positions)[i] for span in drive.spans] for mode, i in found])
    names = [f"carriage {number}" for number in range(len(drive.carriage))]
    still = np.zeros(max(mode.multiplicity for mode, _ in found))
    carried = np.array([[mode.joints.get(name, still)[i] for name in names] for mode, i in found])
    for shape, masses in zip(shapes, carried, strict=True):
        largest = np.abs(shape).max()
        first = np.flatnonzero(np.abs(shape.ravel()) >= (1 - 1e-9) * largest)[0]
        scale = np.sign(shape.ravel()[first]) * largest
        shape /= scale
        masses /= scale
    return shapes, carried
