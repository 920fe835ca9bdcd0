"""What a span, a pulley and a carriage do: state of rest, equations of motion, the datasheet."""

from cabledrive.mechanics.cable_law import CableLaw
from cabledrive.mechanics.cable_laws import ExactLaw, LinearLaw
from cabledrive.mechanics.chain import Chain, LabelledChain, Pendant
from cabledrive.mechanics.datasheet import DerivedQuantities, derived_quantities, drive_warnings
from cabledrive.mechanics.network.rest_forces import RestingStretch
from cabledrive.mechanics.rest import RestingSection, RestState, rest_state

__all__ = [
    "CableLaw",
    "Chain",
    "DerivedQuantities",
    "ExactLaw",
    "LabelledChain",
    "LinearLaw",
    "Pendant",
    "RestState",
    "RestingSection",
    "RestingStretch",
    "derived_quantities",
    "drive_warnings",
    "rest_state",
]
