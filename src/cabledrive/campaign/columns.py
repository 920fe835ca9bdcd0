"""Rows of a campaign as arrays: modes of many plain loops at once."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.kinds import DEFAULT_COUNT, OF_BOTH_KINDS
from cabledrive.campaign.rows import plain_value
from cabledrive.campaign.spec import CampaignSpec, settings_of
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.batch import ChainBatch, batch_of
from cabledrive.modal.natural import is_straight
from cabledrive.parameters import InputRefused
from cabledrive.parameters.keys import varied_together

Found = tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]
"""Rows that are done, (n,), and their outputs, (n, ...), by name."""


def plain_rows(
    spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[np.bool_], ChainBatch] | None:
    """Which rows are straight loops of two turning pulleys without carriages, built as the first drive.

    Their chains beside; the others are computed one by one. None: there is none.
    """
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
            if _build(drive) == build and is_straight(drive):
                found[i] = drive
    if not found:
        return None
    good: NDArray[np.bool_] = np.zeros(rows, dtype=bool)
    good[[*found]] = True
    return good, batch_of([longitudinal_chains(drive)[0].chain for drive in found.values()])


def _build(drive: Any) -> tuple[Any, ...] | None:
    """What loops of one batch have in common; None of what is no plain loop."""
    if drive.kind != "loop" or drive.carriage or any(pulley.fixed for pulley in drive.pulley):
        return None
    motor = drive.motor
    return (
        motor is not None and motor.joint_stiffness is not None,
        motor is not None and motor.holding_stiffness is not None,
    )


def many_modes(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> Found | None:
    """Longitudinal modes of the rows that have only simple ones; None where another way is asked for."""
    from cabledrive.modal.batch import many_spectra

    options = spec.computation.options  # type: ignore[attr-defined]
    fits = "motor" not in options and not OF_BOTH_KINDS & {*options["outputs"]}
    rows = plain_rows(spec, values) if fits else None
    if rows is None:
        return None
    (good, chains), count = rows, options.get("count", DEFAULT_COUNT)
    done, omegas = good.copy(), np.full((good.size, count), np.nan)
    omegas[good], done[good] = many_spectra(chains, count)
    return done, {"longitudinal_hz": omegas / (2.0 * np.pi), "longitudinal_proven": done.astype(np.int8)}
