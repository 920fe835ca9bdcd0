"""One quantity of a drive against another, as labelled arrays with units."""

from cabledrive.studies.carriage_position import (
    MidspanCrossing,
    cable_mass,
    frequency_against_carriage_position,
    midspan_crossing,
    with_carriage,
)
from cabledrive.studies.frequency_against import frequency_against
from cabledrive.studies.modal_determinant import modal_determinant
from cabledrive.studies.mode_shapes import mode_shapes
from cabledrive.studies.table_3_2 import table_3_2

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
