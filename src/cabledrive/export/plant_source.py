"""The lumped plant of a source, with its encoders, delay and torque loop, ready to be translated."""

from dataclasses import dataclass

import numpy as np

from cabledrive.export.source import ExportSource
from cabledrive.parameters import Drive, InputRefused, content_hash
from cabledrive.rig.closed_loop.loop import Loop, close_loop
from cabledrive.rig.closed_loop.loop_numbers import RigNumbers
from cabledrive.rig.closed_loop.piecewise_kernels import PiecewiseNumbers
from cabledrive.rig.closed_loop.plant_kernels import PlantNumbers
from cabledrive.rig.laws.file_law import law_from_file
from cabledrive.rig.laws.registry import needed_order
from cabledrive.rig.setting import Motion, RigOptions
from cabledrive.rig.trial import spec_for

NOTE = (
    "the plant is the highest lumped model of the drive with stick-slip friction; a slack span carries "
    "nothing; encoder phases of seed 0"
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlantSource:
    """A plant in numbers: lumped chain, its pieces where links are not linear, rig, names of its shafts."""

    plant: PlantNumbers
    piecewise: PiecewiseNumbers
    rig: RigNumbers
    shafts: tuple[str, ...]


def plant_source(source: ExportSource) -> PlantSource:
    """The plant on which `cabledrive.track --tension-only` runs the law; refused if it is not at hand."""
    loop = plant_loop(source)
    return PlantSource(plant=loop.plant, piecewise=loop.piecewise, rig=loop.rig, shafts=loop.chain.names)


def plant_loop(source: ExportSource) -> Loop:
    """The loop that the rig runs for that law, along the standard pulse."""
    drive = source.drive
    if drive is None or content_hash(drive) != source.law.drive_hash:
        raise InputRefused(
            "the plant needs the drive, and no drive.toml with the law's hash is beside it: give the drive"
        )
    return loop_on(source, drive, Motion(order=needed_order(source.law.name, drive)))


def loop_on(source: ExportSource, drive: Drive, motion: Motion, *, slack: bool = True) -> Loop:
    """The loop of a law from its file on a drive along a motion; ``slack``: whether spans may go slack."""
    options = RigOptions(forbid_slack=not slack, feedback=source.law.feedback)
    made = law_from_file(source.law, spec_for(drive, motion, feedback=options.feedback, options=options))
    return close_loop(drive, drive, made, motion, options, np.random.default_rng(0))
