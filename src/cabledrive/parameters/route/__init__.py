"""Machines of kind "route": any number of pulleys, bodies and cables, in the words of the file."""

from cabledrive.parameters.cable import Rope
from cabledrive.parameters.route.drive import Machine
from cabledrive.parameters.route.geometry import FreeSpan, Place
from cabledrive.parameters.route.parts import Anchor, Body, Route, RoutedCarriage, RoutedMotor, RoutedPulley
from cabledrive.parameters.route.strain_free import moved, posed

__all__ = [
    "Anchor",
    "Body",
    "FreeSpan",
    "Machine",
    "Place",
    "Rope",
    "Route",
    "RoutedCarriage",
    "RoutedMotor",
    "RoutedPulley",
    "moved",
    "posed",
]
