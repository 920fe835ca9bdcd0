"""Rows of a campaign as arrays: modes and resonances of many drives at once."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.of_drives import DEFAULT_COUNT, IN_CLOSED_FORM, OF_BOTH_KINDS
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.modal.batch import LoopBatch
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import LARGEST, SMALLEST
from cabledrive.parameters.route import RoutedDrive
from cabledrive.studies.frequency_curves import value_of

PULLEYS = ("pulley.0", "pulley.1")
COLUMNS = {
    "density": "cable.mass_per_length",
    "pretension": "cable.pretension",
    "transverse_damping": "cable.transverse_damping",
    "axial_damping": "cable.axial_damping",
    "motor_inertia": "motor.inertia",
    "motor_viscous": "motor.viscous_friction",
    "joint_stiffness": "motor.joint_stiffness",
    "joint_damping": "motor.joint_damping",
    "holding_stiffness": "motor.holding_stiffness",
}
"""Key of each array of a batch; 0 where the drive has none."""
PAIRS = {"radius": "radius", "inertia": "inertia", "viscous": "viscous_friction"}
RIGIDITY = ("cable.axial_rigidity", "cable.youngs_modulus", "cable.area")
LENGTH = ("layout.span_length", "layout.pulley_distance")
NOT_NEGATIVE = {
    *(key for key in COLUMNS.values() if key.endswith(("damping", "friction"))),
    *(f"{pulley}.{kind}_friction" for pulley in PULLEYS for kind in ("viscous", "coulomb")),
    "motor.coulomb_friction",
    "compute.torque",
}
"""Keys that may be 0."""
FREE = {
    *COLUMNS.values(),
    *(f"{pulley}.{key}" for pulley in PULLEYS for key in PAIRS.values()),
    *NOT_NEGATIVE,
    *RIGIDITY,
    *LENGTH,
    "motor.torque_limit",
}
"""Keys whose bounds ask nothing of other keys: 0, or above it."""


def are_plain_loops(spec: CampaignSpec) -> bool:
    """Whether every row of a campaign is a loop of two turning pulleys without carriages, of one build."""
    drive = next(iter(spec.drives.values()))
    return (
        len(spec.drives) == 1
        and set(spec.units) <= FREE
        and not isinstance(drive, RoutedDrive)
        and drive.kind == "loop"
        and not (drive.carriage or any(pulley.fixed for pulley in drive.pulley))
        and all(key.startswith("compute") or value_of(drive, key) is not None for key in spec.units)
    )


def allowed_rows(values: Mapping[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """Rows, (n,), that no bound of the drive file refuses; the others get their reason one by one."""
    good: NDArray[np.bool_] = np.ones(len(next(iter(values.values()))), dtype=bool)
    for key, column in values.items():
        good &= (column <= LARGEST) & ((column >= SMALLEST) | ((column == 0.0) & (key in NOT_NEGATIVE)))
    return good


def column_of(spec: CampaignSpec, values: Mapping[str, NDArray[Any]], key: str) -> Array | None:
    """Values of a key, (n,) in SI, varied or from the drive file; None where neither has it."""
    if key in values:
        return np.asarray(values[key], dtype=float)
    value = value_of(next(iter(spec.drives.values())), key)
    return None if value is None else np.full(len(next(iter(values.values()))), float(value))


def loops_of(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> LoopBatch:
    """The rows as loops; the campaign is one of plain loops. ``values``: of the varied keys, in SI."""
    nothing = np.zeros(len(next(iter(values.values()))))

    def column(key: str) -> Array:
        found = column_of(spec, values, key)
        return nothing if found is None else found

    drive = next(iter(spec.drives.values()))
    whole, modulus, area = (column_of(spec, values, key) for key in RIGIDITY)
    rigidity = whole if whole is not None else modulus * area  # type: ignore[operator]  # one of both is given
    length, distance = (column_of(spec, values, key) for key in LENGTH)
    if length is None:
        length = distance / (1.0 + column("cable.pretension") / rigidity)  # type: ignore[operator]
    arrays: dict[str, Any] = {name: column(key) for name, key in COLUMNS.items()}
    arrays |= {name: tuple(column(f"{pulley}.{key}") for pulley in PULLEYS) for name, key in PAIRS.items()}
    return LoopBatch(
        rigidity=rigidity,
        length=length,
        **arrays,
        flexible=column_of(spec, values, "motor.joint_stiffness") is not None,
        held=column_of(spec, values, "motor.holding_stiffness") is not None,
        gravity_across=drive.layout.gravity_across,  # type: ignore[union-attr]  # a plain loop
    )


def modes_fit(spec: CampaignSpec) -> bool:
    """Whether the rows of a campaign can be computed at once: one drive, a loop of two turning pulleys."""
    options = spec.computation.options if hasattr(spec.computation, "options") else {}
    wanted = set(options.get("outputs", ()))
    return "motor" not in options and not OF_BOTH_KINDS & wanted and are_plain_loops(spec)


def many_modes(
    spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]:
    """Rows with allowed values and only simple modes, and their longitudinal modes; values in SI."""
    from cabledrive.modal.batch import many_spectra

    count = spec.computation.options.get("count", DEFAULT_COUNT)  # type: ignore[attr-defined]
    allowed = allowed_rows(values)
    chosen = {key: column[allowed] for key, column in values.items()}
    done = allowed.copy()
    frequency = np.full((allowed.size, count), np.nan)
    if allowed.any():
        omegas, proven = many_spectra(loops_of(spec, chosen).chains(), count)
        frequency[allowed] = omegas / (2.0 * np.pi)
        done[allowed] = proven
    return done, {"longitudinal_hz": frequency, "longitudinal_proven": done.astype(np.int8)}


def resonances_fit(spec: CampaignSpec) -> bool:
    """Whether the rows of a campaign can be computed at once."""
    options = spec.computation.options  # type: ignore[attr-defined]
    wanted = set(options["outputs"]) <= IN_CLOSED_FORM and not options.get("load_torque", 0.0)
    if not (wanted and are_plain_loops(spec)):
        return False
    layout: Any = next(iter(spec.drives.values())).layout
    return layout.span_length is not None and layout.gravity_along == 0.0


def many_resonances(
    spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]:
    """Rows with allowed values, and numbers of their internal resonance; values in SI."""
    from cabledrive.studies import resonance_detuning as resonance_batch

    allowed = allowed_rows(values)
    done, outputs = allowed.copy(), {name: np.full(allowed.size, np.nan) for name in IN_CLOSED_FORM}
    words = np.full(allowed.size, "", dtype=object)
    if allowed.any():
        chosen = {key: column[allowed] for key, column in values.items()}
        found = resonance_batch.many_resonances(loops_of(spec, chosen), _torque(spec, chosen))
        done[allowed], words[allowed] = found.done, found.verdict
        numbers = {
            "frequency_ratio": found.frequency_ratio,
            "detuning": found.frequency_ratio - 0.5,
            "tuned_pretension": found.tuned_pretension,
            "threshold_torque": found.threshold_torque,
            "threshold_torque_at_own_pretension": found.threshold_here,
            "pulley_frequency_hz": found.pulley_frequency,
        }
        for name, numbers_of_rows in numbers.items():
            outputs[name][allowed] = numbers_of_rows
    return done, outputs | {"verdict": words}


def _torque(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> NDArray[np.float64]:
    """Torque of the verdict in each row, as `cabledrive.studies.resonance.default_torque` has it [N m]."""
    from cabledrive.studies.resonance import SLACK_SHARE

    given = spec.computation.options.get("torque")  # type: ignore[attr-defined]
    rows = len(next(iter(values.values())))
    if "compute.torque" in values or given is not None:
        return np.asarray(values.get("compute.torque", np.full(rows, given or 0.0)), dtype=float)
    limit = column_of(spec, values, "motor.torque_limit")
    if limit is not None:
        return limit
    loops = loops_of(spec, values)
    return np.asarray(SLACK_SHARE * 2.0 * loops.radius[0] * loops.pretension)
