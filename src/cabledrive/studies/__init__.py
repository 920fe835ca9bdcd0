"""One quantity of a drive against another, as labelled arrays with units."""

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
from cabledrive.studies.shapes import mode_shapes

__all__ = [
    "MidspanCrossing",
    "cable_mass",
    "frequency_against",
    "frequency_against_carriage_position",
    "midspan_crossing",
    "modal_determinant",
    "mode_shapes",
    "table_3_2",
    "with_carriage",
]
