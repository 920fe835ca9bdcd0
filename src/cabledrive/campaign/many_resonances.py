"""Thresholds of the internal resonance of many rows at once: level loops of two pulleys, no carriages."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.columns import allowed_rows, are_plain_loops, column_of, loops_of
from cabledrive.campaign.of_drives import IN_CLOSED_FORM
from cabledrive.campaign.spec import CampaignSpec


def fits(spec: CampaignSpec) -> bool:
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
    from cabledrive.studies import resonance_batch

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
