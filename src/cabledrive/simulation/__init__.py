"""The nonlinear cable loop in time, with an audit of its own error."""

from cabledrive.simulation.error_estimate import ErrorEstimate
from cabledrive.simulation.loop_result import SimulationResult
from cabledrive.simulation.one_run import simulate
from cabledrive.simulation.result import SlackEvent
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
    "ErrorEstimate",
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
