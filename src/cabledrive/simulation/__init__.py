"""The nonlinear cable loop in time, with an audit of its own error."""

from cabledrive.simulation.one_run import simulate
from cabledrive.simulation.result import SimulationResult, SlackEvent
from cabledrive.simulation.run import SimulationInterrupted
from cabledrive.simulation.signals import (
    CarriageForce,
    Constant,
    FromFunction,
    Multisine,
    Sampled,
    Signal,
    Sine,
    Sweep,
)
from cabledrive.simulation.start import Pluck, Recording, Scheme, Start

__all__ = [
    "CarriageForce",
    "Constant",
    "FromFunction",
    "Multisine",
    "Pluck",
    "Recording",
    "Sampled",
    "Scheme",
    "Signal",
    "SimulationInterrupted",
    "SimulationResult",
    "Sine",
    "SlackEvent",
    "Start",
    "Sweep",
    "simulate",
]
