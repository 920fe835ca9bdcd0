"""Closed loops of many rows at once: one law on lumped plants that differ from its drive."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.keys import PLANT, drive_with
from cabledrive.campaign.of_loops import OF_SCORES, motion_of, rig_options
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.route import RoutedDrive

OF_THE_CHAIN = {
    "cable.youngs_modulus",
    "cable.area",
    "cable.axial_rigidity",
    "cable.axial_damping",
    "cable.mass_per_length",
    "cable.transverse_damping",
    "cable.pretension",
    "layout.span_length",
    "layout.pulley_distance",
    "pulley.0.inertia",
    "pulley.0.viscous_friction",
    "pulley.1.inertia",
    "pulley.1.viscous_friction",
    "motor.inertia",
    "motor.viscous_friction",
    "motor.coulomb_friction",
    "motor.offset_torque",
    "motor.joint_stiffness",
    "motor.joint_damping",
    "lumped.cable_stiffness",
    "lumped.cable_damping",
}
"""Keys of the plant that change its lumped chain and nothing else of the loop but the limit of slack."""


def fits(spec: CampaignSpec) -> bool:
    """Whether the rows may share a law: one drive, varied in its lumped plant alone, no encoders."""
    options = spec.computation.options  # type: ignore[attr-defined]
    varied = {key.removeprefix(f"{PLANT}.") for key in spec.units if key.startswith(f"{PLANT}.")}
    return (
        len(spec.drives) == 1
        and not isinstance(next(iter(spec.drives.values())), RoutedDrive)
        and len(varied) == len(spec.units)
        and varied <= OF_THE_CHAIN
        and set(options["outputs"]) <= OF_SCORES | {"controller"}
        and options.get("ideal_sensors", False)
        and options.get("smooth_friction", False)
    )


def many_tracks(
    spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]] | None:
    """Scores of the rows that run to their end under the law that they share.

    ``values``: of the varied keys, in SI; the campaign `fits`.
    Returns which rows are done, and the outputs; None: the law depends on the plant, or the loop has what
    only single runs follow.
    """
    from cabledrive.rig.shared_law import shared_law, track_plants

    (drive,) = spec.drives.values()
    assert isinstance(drive, Drive)
    o = spec.computation.options  # type: ignore[attr-defined]
    law = shared_law(
        drive,
        motion_of(spec.motion),
        rig_options(o),
        controller=o.get("controller"),
        bandwidth=o.get("bandwidth"),
        gains=o.get("gains", "best"),
        plant=o.get("plant"),
        adapt=not o.get("no_adaptation", False),
    )
    if law is None or "feedforward" in o:
        return None
    done, found = track_plants(law, _plants(spec, drive, values))
    names = np.full(done.size, law.loop.controller.name, dtype=object)
    return done, found | {"controller": names}


def _plants(spec: CampaignSpec, drive: Drive, values: Mapping[str, NDArray[Any]]) -> list[Any]:
    """The drive of each row as it is; None where it is refused, with a reason that the single run gives."""
    (tables,) = spec.tables.values()
    keys = [key.removeprefix(f"{PLANT}.") for key in values]
    plants: list[Any] = []
    for row in zip(*(column.tolist() for column in values.values()), strict=True):
        try:
            plants.append(drive_with(drive, tables, dict(zip(keys, row, strict=True))))
        except InputRefused:
            plants.append(None)
    return plants
