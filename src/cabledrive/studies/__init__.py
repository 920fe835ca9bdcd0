"""One quantity of a drive against another, as labelled arrays with units; resonance; the study of one drive.

How do frequencies change with pretension or position, does a planned motion excite the transverse modes, does
the machine reach its goal? Begin with `frequency_against` and `cabledrive.studies.study.run_study`.
"""

from cabledrive.studies.carriage_position import (
    MidspanCrossing,
    cable_mass,
    frequency_against_carriage_position,
    midspan_crossing,
    with_carriage,
)
from cabledrive.studies.carriage_table import table_3_2
from cabledrive.studies.determinant import modal_determinant
from cabledrive.studies.frequency_curves import frequency_against
from cabledrive.studies.motion_file import read_motion
from cabledrive.studies.shapes import mode_shapes
from cabledrive.studies.steady_motion import steady_branches

__all__ = [
    "MidspanCrossing",
    "cable_mass",
    "frequency_against",
    "frequency_against_carriage_position",
    "midspan_crossing",
    "modal_determinant",
    "mode_shapes",
    "read_motion",
    "steady_branches",
    "table_3_2",
    "with_carriage",
]
