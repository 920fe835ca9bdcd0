"""Rows of a campaign as arrays: modes and resonances of many plain loops at once."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.kinds import DEFAULT_COUNT, FIELDS, IN_CLOSED_FORM, OF_BOTH_KINDS
from cabledrive.campaign.rows import plain_value
from cabledrive.campaign.spec import CampaignSpec, settings_of
from cabledrive.modal.batch import LoopBatch
from cabledrive.parameters import Drive, InputRefused
from cabledrive.studies.frequency_curves import varied_together

Found = tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]
"""Rows that are done, (n,), and their outputs, (n, ...), by name."""


class PlainRows(NamedTuple):
    """The rows that are loops of one build; the others are computed one by one."""

    good: NDArray[np.bool_]  # (n,): which these are
    drives: list[Drive]
    loops: LoopBatch


def plain_rows(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> PlainRows | None:
    """Loops of two turning pulleys without carriages, built as the first drive; None if there is none."""
    base, found = next(iter(spec.drives.values())), dict[int, Any]()
    build = _build(base) if len(spec.drives) == 1 else None
    given = {
        key: [plain_value(value, spec.units[key]) for value in column]
        for key, column in settings_of(values, "").items()
    }
    rows = len(next(iter(values.values())))
    for i in range(rows if build is not None else 0):
        with suppress(InputRefused):
            drive = varied_together(base, {key: column[i] for key, column in given.items()})
            if _build(drive) == build:
                found[i] = drive
    if not found:
        return None
    good: NDArray[np.bool_] = np.zeros(rows, dtype=bool)
    good[[*found]] = True
    return PlainRows(good, [*found.values()], loops_of([*found.values()]))


def _build(drive: Any) -> tuple[Any, ...] | None:
    """What loops of one batch have in common; None of what is no plain loop."""
    plain = isinstance(drive, Drive) and drive.kind == "loop" and not drive.carriage
    if not plain or any(pulley.fixed for pulley in drive.pulley):
        return None
    motor = drive.motor
    return (
        drive.layout.gravity_across,
        motor is not None and motor.joint_stiffness is not None,
        motor is not None and motor.holding_stiffness is not None,
    )


def loops_of(drives: Sequence[Drive]) -> LoopBatch:
    """The numbers of plain loops of one build."""

    def numbers(part: str, *names: str) -> dict[str, Any]:
        parts = [getattr(drive, part) for drive in drives]
        return {name: np.array([getattr(one, name, None) or 0.0 for one in parts]) for name in names}

    def of_pulleys(name: str) -> tuple[Any, Any]:
        first, second = np.array([[getattr(one, name) for one in drive.pulley] for drive in drives]).T
        return first, second

    cable = numbers("cable", "mass_per_length", "axial_rigidity", "pretension", "transverse_damping")
    motor = numbers("motor", "inertia", "viscous_friction")
    across, flexible, held = _build(drives[0]) or (0.0, False, False)
    return LoopBatch(
        rigidity=cable["axial_rigidity"],
        density=cable["mass_per_length"],
        pretension=cable["pretension"],
        length=np.array([drive.span_length for drive in drives]),
        transverse_damping=cable["transverse_damping"],
        **numbers("cable", "axial_damping"),
        radius=of_pulleys("radius"),
        inertia=of_pulleys("inertia"),
        viscous=of_pulleys("viscous_friction"),
        motor_inertia=motor["inertia"],
        motor_viscous=motor["viscous_friction"],
        **numbers("motor", "joint_stiffness", "joint_damping", "holding_stiffness"),
        flexible=flexible,
        held=held,
        gravity_across=across,
    )


def many_modes(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> Found | None:
    """Longitudinal modes of the rows that have only simple ones; None where another way is asked for."""
    from cabledrive.modal.batch import many_spectra

    options = spec.computation.options  # type: ignore[attr-defined]
    fits = "motor" not in options and not OF_BOTH_KINDS & {*options["outputs"]}
    rows = plain_rows(spec, values) if fits else None
    if rows is None:
        return None
    done, omegas = rows.good.copy(), np.full((rows.good.size, options.get("count", DEFAULT_COUNT)), np.nan)
    omegas[rows.good], done[rows.good] = many_spectra(rows.loops.chains(), omegas.shape[1])
    return done, {"longitudinal_hz": omegas / (2.0 * np.pi), "longitudinal_proven": done.astype(np.int8)}


def many_resonances(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> Found | None:
    """Numbers of the internal resonance in closed form; None where another way is asked for."""
    from cabledrive.studies import resonance_detuning as resonance_batch
    from cabledrive.studies.resonance import default_torque

    options = spec.computation.options  # type: ignore[attr-defined]
    base: Any = next(iter(spec.drives.values()))
    fits = {*options["outputs"]} <= IN_CLOSED_FORM and "compute.load_torque" not in values
    fits = fits and not options.get("load_torque", 0.0) and base.layout.gravity_along == 0.0
    fits = fits and _build(base) is not None and base.layout.span_length is not None
    rows = plain_rows(spec, values) if fits else None
    if rows is None:
        return None
    torque = np.array([options.get("torque", default_torque(drive)) for drive in rows.drives], dtype=float)
    if "compute.torque" in values:
        torque = values["compute.torque"][rows.good]
    found, done, outputs = resonance_batch.many_resonances(rows.loops, torque), rows.good.copy(), {}
    done[rows.good] = found.done
    for name in IN_CLOSED_FORM:
        column = found.frequency_ratio - 0.5 if name == "detuning" else getattr(found, FIELDS.get(name, name))
        outputs[name] = np.full(done.size, np.nan, dtype=column.dtype if name != "verdict" else object)
        outputs[name][rows.good] = column
    return done, outputs
