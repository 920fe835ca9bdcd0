"""Table 3.2 of the dissertation: as printed, as computed here, and as its mixed conventions give it."""

from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from cabledrive.modal import modes, natural_frequencies
from cabledrive.modal.rigid_supports import rigid_support_longitudinal
from cabledrive.parameters import Drive, Layout, load_drive
from cabledrive.studies.varied_drive import stamped

if TYPE_CHECKING:
    import xarray as xr

PRINTED = {
    1: {"fundamental": "116", "second": "766", "transverse": "50.5", "rigid": "751.8"},
    2: {"fundamental": "81.6", "second": "757.5", "transverse": "50.5", "rigid": "751.8"},
}
QUANTITIES = {
    "fundamental": "Fundamental longitudinal frequency",
    "in phase": "In-phase mode, pulleys at rest",
    "second": "Second longitudinal frequency of the print, the third mode",
    "transverse": "Fundamental transverse frequency",
    "rigid": "Fundamental longitudinal frequency with rigid end-supports",
}
_MIXED = (
    "the print takes c_u = sqrt(EA/rho) of (2.31), without the factor 1 + eps0 under the root, "
    "and divides by the stretched length Le = L (1 + eps0)"
)
EXPLANATIONS = {
    "fundamental": _MIXED,
    "in phase": "not in the print, though det = 0 there too: sin(omega Le/c_u) = 0; Fig. 3.5(b) draws it",
    "second": f"{_MIXED}; it is the third mode, the in-phase one lies below it",
    "transverse": "the print takes the unstretched length L and leaves the density unstretched",
    "rigid": "the printed parameters give 751.73 Hz; 751.8 Hz follows from nylon's density before rounding, "
    "c_u = sqrt(E / 1150 kg/m^3)",
}


def table_3_2() -> "xr.Dataset":
    """Table 3.2, row by row.

    Returns
    -------
    xarray.Dataset
        Over ``row``: ``configuration`` (1 or 2), ``quantity``, ``printed`` (text as in the print, empty where
        it has nothing), ``computed`` [Hz], ``mixture`` [Hz] (the conventions that the print mixes),
        ``reproduced`` (whether the mixture rounds to the print) and ``explanation``.
    """
    import xarray as xr

    rows = [row for number in (1, 2) for row in _rows(number)]
    names = ("configuration", "quantity", "printed", "computed", "mixture", "reproduced", "explanation")
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    units = {name: {"units": "Hz"} if name in ("computed", "mixture") else {} for name in names}
    text = {"quantity", "printed", "explanation"}
    data = xr.Dataset(
        {
            name: ("row", np.array(column, dtype=object if name in text else None), units[name])
            for name, column in columns.items()
        }
    )
    return stamped(data, load_drive("dissertation-1"), "Table 3.2").assign_attrs(
        drive="dissertation-1 and dissertation-2"
    )


def _rows(number: int) -> list[tuple[int, str, str, float, float, bool, str]]:
    drive = load_drive(f"dissertation-{number}")
    computed, mixture, printed = _computed(drive), _mixture(drive), PRINTED[number]
    return [
        (
            number,
            QUANTITIES[key],
            printed.get(key, ""),
            computed[key],
            mixture[key],
            _rounds_to(mixture[key], printed.get(key, "")),
            EXPLANATIONS[key],
        )
        for key in QUANTITIES
    ]


def _computed(drive: Drive) -> dict[str, float]:
    fundamental, in_phase, second = natural_frequencies(drive, count=3)
    return {
        "fundamental": float(fundamental),
        "in phase": float(in_phase),
        "second": float(second),
        "transverse": modes(drive, count=1).transverse[0].frequency,
        "rigid": rigid_support_longitudinal(drive),
    }


def _mixture(drive: Drive) -> dict[str, float]:
    """Wave speed of the unstretched cable with the stretched length; with L where the print has c/(2 L)."""
    stretched = replace(drive, layout=Layout(span_length=drive.pulley_distance))
    fundamental, in_phase, second = natural_frequencies(stretched, count=3)
    cable = drive.cable
    return {
        "fundamental": float(fundamental),
        "in phase": float(in_phase),
        "second": float(second),
        "transverse": sqrt(cable.pretension / cable.mass_per_length) / (2.0 * drive.span_length),
        "rigid": sqrt(cable.axial_rigidity / cable.mass_per_length) / (2.0 * drive.span_length),
    }


def _rounds_to(value: float, printed: str) -> bool:
    digits = len(printed.partition(".")[2])
    return bool(printed) and f"{value:.{digits}f}" == printed
