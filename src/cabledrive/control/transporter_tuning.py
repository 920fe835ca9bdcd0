r"""A transporter's weights by one bandwidth, for a machine of any size.

A mass M on a cost of :math:`x^2/e^2 + u^2/F^2` closes at :math:`\omega^2 = F/(eM)`; a steady observer whose
accelerations are noise of density q and whose readings are noise of density R, at :math:`\omega^4 = q/R`.
"""

from math import sqrt

from cabledrive.control.transporter_law import TransporterTuning
from cabledrive.reduction.transporter import Transporter

OBSERVER = 1.5
"""Bandwidth of the observer over that of the law."""
STRETCHING = 0.24
"""Speed against the drive pulley that weighs as much as the error, over bandwidth times error."""
ERROR, WIND_TIME, READING = 2e-3, 2.0, 1000.0
UNWEIGHED = 1e6


def tuning_for(
    transporter: Transporter, bandwidth: float, *, interval: float, count: float, hanging: bool = True
) -> TransporterTuning:
    """Weights of law and observer by the bandwidth [rad/s] of the loop round the rigid whole.

    ``count``: one count of the encoders at the rim [m]; not ``hanging``: only the carriage's error counts.
    """
    mass, error = float(transporter.masses.sum()), ERROR / sqrt(2.0) if hanging else ERROR
    density = READING * count**2 / 12.0 * interval  # of a reading's noise [m^2 s]
    observer = OBSERVER * bandwidth
    return TransporterTuning(
        payload=ERROR if hanging else UNWEIGHED * ERROR,
        carriage=ERROR,
        stretching=STRETCHING * bandwidth * ERROR,
        force=mass * error * bandwidth**2,
        disturbance=mass**2 * density * observer**6,
        wind=transporter.payload_mass * bandwidth**3 * sqrt(0.5 * WIND_TIME * density),
        wind_time=WIND_TIME,
        acceleration=density * observer**4,
        reading=READING,
    )
