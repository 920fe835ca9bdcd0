"""What a span, a pulley and a carriage do: dynamic stiffness, equations of motion, the datasheet."""

from cabledrive.mechanics.datasheet import DerivedQuantities, derived_quantities
from cabledrive.mechanics.warnings import practitioner_warnings

__all__ = ["DerivedQuantities", "derived_quantities", "practitioner_warnings"]
