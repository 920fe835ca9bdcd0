"""The transporter's law in closed loop with its plant, made once and run on this plant or that."""

import numpy as np
from numpy.typing import NDArray

from cabledrive.control.transporter import OBSERVED
from cabledrive.reduction.transporter import Transporter
from cabledrive.rig.carriage.transporter_kernels import CarriageLoop, TransporterPlant, run_transporter

Array = NDArray[np.float64]
CARRIAGE, SWING, PAYLOAD, TENSIONS, FORCE, ESTIMATE = 1, 3, 8, 9, 12, 13
"""Columns of a log; eight states come first, three tensions stand from `TENSIONS` on."""


def run_carriage(loop: CarriageLoop, plant: Transporter, phases: Array) -> Array:
    """Run a plant under the law.

    ``phases``, shape (2,): of the encoders, in counts.
    Returns shape (samples, 23): 8 states, payload's place, 3 tensions, force of the motor, 10 estimates;
    fewer samples where a strand went slack or the carriage left its span.
    """
    log = np.zeros((len(loop.reference), ESTIMATE + OBSERVED))
    ended = run_transporter(loop, plant_of(plant), phases, np.zeros(8), log)
    return log[:ended]


def plant_of(transporter: Transporter) -> TransporterPlant:
    """The transporter as the compiled run takes it."""
    t = transporter
    return TransporterPlant(
        lengths=np.array([t.span_length, t.start, t.line_length]),
        cable=np.array([t.axial_rigidity, t.pretension / t.axial_rigidity, t.damping_time]),
        masses=t.masses,
        friction=np.array(
            [t.viscous, t.coulomb, t.offset, t.rail_friction, t.swing_damping * t.gravity / t.line_length]
        ),
        gravity=t.gravity,
    )
