"""Where the prediction error begins: at the torque's instant by the regression, or at a convention's."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from cabledrive.identification.estimates import Identification
from cabledrive.identification.innovations import NotReproduced
from cabledrive.identification.logs.log import Log
from cabledrive.identification.prediction_error import Predicted, refine_by_prediction
from cabledrive.identification.rigid_axis import AxisOptions, channels_of, identify_rigid_axis
from cabledrive.identification.torque_timing import CONVENTIONS, TorqueTiming, with_torque_moved


def predict_from_some_instant(
    logs: Sequence[Log], found: Identification, options: AxisOptions, timing: TorqueTiming
) -> Predicted:
    """Prediction error from the torque's instant as found; where that loses the log, from a convention's.

    Inside a feedback loop the regression's instant can be off by more than the observer finds back from.
    """
    try:
        return refine_by_prediction(logs, found, options, timing)
    except NotReproduced:
        if timing.known or not options.lag:
            raise
    torque, _ = channels_of(logs[0], options)
    interval = max(log.interval for log in logs)
    for name in sorted(CONVENTIONS, key=lambda name: abs(CONVENTIONS[name] * interval - timing.shift)):
        start = replace(timing, shift=CONVENTIONS[name] * interval, law="shift")
        begun = identify_rigid_axis(with_torque_moved(logs, torque, start), options)
        if begun.identifiable:
            with suppress(NotReproduced):
                return refine_by_prediction(logs, begun, options, start)
    raise NotReproduced
