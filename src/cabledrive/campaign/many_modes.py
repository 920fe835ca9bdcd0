"""Longitudinal modes of many rows at once, where the drives have two turning pulleys and no carriages."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.of_drives import DEFAULT_COUNT, OF_BOTH_KINDS
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.parameters import Drive
from cabledrive.parameters.fields import LARGEST, SMALLEST

Array = NDArray[np.float64]

POSITIVE = {
    "cable.youngs_modulus",
    "cable.area",
    "cable.axial_rigidity",
    "cable.mass_per_length",
    "cable.pretension",
    "layout.span_length",
    "layout.pulley_distance",
    "pulley.0.radius",
    "pulley.0.inertia",
    "pulley.1.radius",
    "pulley.1.inertia",
    "motor.inertia",
    "motor.joint_stiffness",
    "motor.holding_stiffness",
}
"""Keys on which the frequencies depend, or could; each has to be above 0 and asks nothing of other keys."""
WITHOUT_EFFECT = {
    "cable.transverse_damping",
    "cable.axial_damping",
    "pulley.0.viscous_friction",
    "pulley.0.coulomb_friction",
    "pulley.1.viscous_friction",
    "pulley.1.coulomb_friction",
}
"""Keys on which they do not depend; none may be negative."""


def fits(spec: CampaignSpec) -> bool:
    """Whether the rows of a campaign can be computed at once: one drive, a loop of two turning pulleys."""
    options = spec.computation.options if hasattr(spec.computation, "options") else {}
    drive = next(iter(spec.drives.values()))
    tables = next(iter(spec.tables.values()))
    known = POSITIVE | WITHOUT_EFFECT
    plain = len(spec.drives) == 1 and set(spec.units) <= known and "motor" not in options
    return (
        plain
        and not OF_BOTH_KINDS & set(options.get("outputs", ()))
        and _is_plain_loop(drive)
        and all(key.startswith("pulley") or _given(tables, key) for key in spec.units)
    )


def _is_plain_loop(drive: Drive) -> bool:
    turning = not any(pulley.fixed for pulley in drive.pulley)
    return drive.kind == "loop" and not drive.carriage and turning


def _given(tables: Mapping[str, Any], key: str) -> bool:
    """Whether the file has the key already: a new one may contradict another."""
    table, _, name = key.partition(".")
    return name in tables.get(table, {}) or key in WITHOUT_EFFECT


def many_modes(
    spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]:
    """Longitudinal modes of the rows whose values are allowed and whose modes are all simple.

    ``values``: of the varied keys, in SI; the campaign `fits`.
    Returns which rows are done, and the outputs.
    """
    from cabledrive.modal.batch import many_spectra

    count = spec.computation.options.get("count", DEFAULT_COUNT)  # type: ignore[attr-defined]
    allowed = _allowed(values)
    chosen = {key: column[allowed] for key, column in values.items()}
    done = allowed.copy()
    frequency = np.full((allowed.size, count), np.nan)
    if allowed.any():
        omegas, proven = many_spectra(_chains(spec, chosen), count)
        frequency[allowed] = omegas / (2.0 * np.pi)
        done[allowed] = proven
    return done, {"longitudinal_hz": frequency, "longitudinal_proven": done.astype(np.int8)}


def _allowed(values: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """Rows that no bound of the drive file refuses; the others get their reason one by one."""
    good: NDArray[np.bool_] = np.ones(len(next(iter(values.values()))), dtype=bool)
    for key, column in values.items():
        least = SMALLEST if key in POSITIVE else 0.0
        good &= (column >= least) & (column <= LARGEST)
    return good


def _chains(spec: CampaignSpec, values: Mapping[str, Array]) -> Any:
    """Chains of the rows, as `cabledrive.mechanics.spans.longitudinal_chains` makes each."""
    from cabledrive.modal.batch import ChainBatch

    tables = next(iter(spec.tables.values()))
    rows = len(next(iter(values.values())))

    def column(key: str) -> Array | None:
        if key in values:
            return np.asarray(values[key], dtype=float)
        table, *path = key.split(".")
        part = tables.get(table, {})
        part = part[int(path[0])] if isinstance(part, list) else part
        value = part.get(path[-1])
        return None if value is None else np.full(rows, float(value))

    def needed(key: str) -> Array:
        found = column(key)
        assert found is not None
        return found

    rigidity = column("cable.axial_rigidity")
    if rigidity is None:
        rigidity = needed("cable.youngs_modulus") * needed("cable.area")
    density, length = needed("cable.mass_per_length"), column("layout.span_length")
    if length is None:
        length = needed("layout.pulley_distance") / (1.0 + needed("cable.pretension") / rigidity)
    square = needed("pulley.0.radius") ** 2
    masses = np.column_stack(
        (needed("pulley.0.inertia") / square, needed("pulley.1.inertia") / needed("pulley.1.radius") ** 2)
    )
    grounds, pendant = np.zeros((rows, 2)), np.zeros((rows, 3))
    holding = column("motor.holding_stiffness")
    held = np.zeros(rows) if holding is None else holding / square
    joint, inertia = column("motor.joint_stiffness"), column("motor.inertia")
    if inertia is not None and joint is not None:
        pendant = np.column_stack((joint / square, inertia / square, held))
    elif inertia is not None:
        masses[:, 0] += inertia / square
        grounds[:, 0] = held
    time = length / np.sqrt(rigidity / density)
    return ChainBatch(
        times=np.column_stack((time, time)),
        masses=masses,
        grounds=grounds,
        impedance=np.sqrt(rigidity * density),
        pendant=pendant,
        closed=True,
    )
