"""Longitudinal modes of many rows at once, where the drives have two turning pulleys and no carriages."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.columns import allowed_rows, are_plain_loops, loops_of
from cabledrive.campaign.of_drives import DEFAULT_COUNT, OF_BOTH_KINDS
from cabledrive.campaign.spec import CampaignSpec


def fits(spec: CampaignSpec) -> bool:
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
