"""Two inertias, a spring between them, friction at both: identified from logs of either speed or both.

The input is a torque, a force, or a voltage or current, in whose unit all parameters then are. A speed that
never changes its sign under an input that does is that of a sensor which shows its absolute value.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.both_sides import identify_by_equations
from cabledrive.identification.chain_model import ChainModel, FreeParameter, Record, Sensor
from cabledrive.identification.estimates import Estimate, Finding, Identification
from cabledrive.identification.fit_doubts import at_bounds, doubts_of, interval_of, undetermined
from cabledrive.identification.logs.log import Log
from cabledrive.identification.output_error import RowFit, StartedFit, fit_from_many_starts, fit_of
from cabledrive.identification.regression import readable
from cabledrive.identification.two_inertia_channels import (
    TwoInertiaChannels,
    channels_of,
    record_of,
    unit_of,
)
from cabledrive.identification.two_inertia_starts import starts_for

Array = NDArray[np.float64]

NAME = "two-inertia"
NEEDED = ("inertia_motor", "inertia_load", "stiffness")
DIFFERENCED = 10
"""Lags over which the difference of an angle correlates the noise of its encoder."""
FOLLOWS = 70.0
"""Share of every measured speed [%] that the model explains where its intervals are given."""
SUBSTEPS = 4


def identify_two_inertia(
    logs: Sequence[Log], seed: int = 0, progress: Callable[[str], None] | None = None
) -> Identification:
    """Identify motor and load inertia, the spring between them, its damping and all frictions.

    Logs that show both sides with their signs are solved by `both_sides`; a log of one side, or of a speed
    without its sign, is simulated from many starts.

    ``logs``: of one machine, with the same channels: torque, force, voltage or current, and a velocity, angle
    or position of the motor, the load ("load velocity") or both; ``seed``: of the starts; ``progress``:
    called with a line for each fit of a simulation.
    Returns ``inertia_motor``, ``inertia_load``, ``stiffness``, ``damping``, ``viscous_friction_motor``,
    ``viscous_friction_load``, ``coulomb_friction_motor``, ``coulomb_friction_load``, ``offset``; with a
    rectifying sensor its ``sensor_lag``. No intervals where the model does not follow the log.
    Raises `InputRefused` if a channel is missing or constant; `NotComputed` if no start leads to a model that
    moves like the log.
    """
    channels = channels_of(logs)
    if len(channels.outputs) == 2 and not channels.rectified:
        return identify_by_equations(logs, channels)
    records = [record_of(log, channels) for log in logs]
    begins = starts_for(records, channels.rectified, np.random.default_rng(seed))
    models = [_model(channels, begins.scale, hold, delay) for hold, delay in _conventions(channels.input)]
    found = fit_from_many_starts(records, models, begins.starts, progress=progress)
    return _answer(logs, channels, records, found, seed)


def _conventions(input_: str) -> tuple[tuple[str, int], ...]:
    """Ways in which a logged input may act: held or on straight lines, at once or a sample late."""
    if input_.rpartition("_")[2] in ("voltage", "current"):
        return ("step", 0), ("step", 1)
    return ("line", 0), ("step", 0)


def _model(channels: TwoInertiaChannels, scale: dict[str, float], hold: str, delay: int) -> ChainModel:
    """The chain with bounds far on both sides of the scales of the log."""

    def wide(name: str, quantity: str, number: int, unit: str, reach: float = 1e4) -> FreeParameter:
        return FreeParameter(
            name=name, quantity=quantity, number=number, low=scale[unit] / reach, high=scale[unit] * reach
        )

    free = [
        wide("inertia_motor", "inertia", 0, "inertia"),
        wide("inertia_load", "inertia", 1, "inertia"),
        wide("stiffness", "stiffness", 0, "stiffness", 1e6),
        wide("damping", "damping", 0, "damping", 1e6),
        wide("viscous_friction_motor", "viscous", 0, "viscous", 1e5),
        wide("viscous_friction_load", "viscous", 1, "viscous", 1e5),
        wide("coulomb_friction_motor", "coulomb", 0, "input"),
        wide("coulomb_friction_load", "coulomb", 1, "input"),
        FreeParameter(
            name="offset", quantity="offset", low=-10.0 * scale["input"], high=10.0 * scale["input"]
        ),
    ]
    if channels.rectified:
        free.append(FreeParameter(name="sensor_lag", quantity="lag", low=1e-5, high=1.0))
    measured = tuple(
        number for number, name in enumerate((channels.motor, channels.load)) if name is not None
    )
    return ChainModel(
        inertias=2,
        free=tuple(free),
        measured=measured,
        given={},
        sensor=Sensor(rectified=channels.rectified),
        delay=delay,
        hold=hold,
        substeps=SUBSTEPS,
    )


def _answer(
    logs: Sequence[Log],
    channels: TwoInertiaChannels,
    records: Sequence[Record],
    found: StartedFit,
    seed: int,
) -> Identification:
    fit = found.fit
    explained = [
        fit_of(record.output[:, k], fit.simulated(record)[:, k])
        for record in records
        for k in range(record.output.shape[1])
    ]
    follows = min(explained) >= FOLLOWS
    differenced = any(not name.endswith("velocity") for name in channels.outputs)
    doubts = list(doubts_of(fit, records, DIFFERENCED if differenced else 1))
    if not follows:
        message = (
            f"the model does not reproduce the log: it explains {min(explained):.3g} % of a measured speed"
        )
        doubts.insert(0, ("model-misfit", f"{message}, less than {FOLLOWS:g} %: no intervals are given"))
    if found.agreeing < 2:
        doubts.append(
            (
                "one-start-only",
                f"only one of {found.settled} fits reaches this residual: a better one may exist",
            )
        )
    open_ = [name for name in undetermined(fit) if name in NEEDED]
    parameters = {s.name: _estimate(fit, s.name, follows, channels, logs[0], open_) for s in fit.model.free}
    size = float(np.sqrt(np.mean(np.concatenate([r.output.ravel() for r in records]) ** 2)))
    return Identification(
        model=NAME,
        parameters=parameters,
        identifiable=not open_,
        unidentifiable=tuple(f"{readable(name)} is not determined by the log" for name in open_),
        residual={
            "rms": fit.residual,
            "relative": fit.residual / size,
            "rows": sum(record.compared_size for record in records),
        },
        condition_number=_condition(fit.covariance),
        method={
            "name": "output-error",
            "residual_of": "speed",
            "input": channels.input,
            "measured": list(channels.outputs),
            "sensor": "rectified" if channels.rectified else "signed",
            "hold": fit.model.hold,
            "delay_samples": fit.model.delay,
            "starts": found.starts,
            "full_fits": found.settled,
            "agreeing_fits": found.agreeing,
            "explained_percent": explained,
            "seed": seed,
        },
        covariance=fit.covariance,
        freedom=fit.freedom,
        findings=tuple(Finding(code, message) for code, message in doubts),
        notes=_notes(channels, fit),
        checked=True,
        check_reason="share explained, whiteness of the residual, bounds, several starts",
        reports=tuple(log.report for log in logs),
    )


def _estimate(
    fit: RowFit, name: str, follows: bool, channels: TwoInertiaChannels, log: Log, open_: Sequence[str]
) -> Estimate:
    unit, infinite = unit_of(name, channels, log), float("inf")
    if name in open_:
        return Estimate(
            value=float("nan"), unit=unit, standard_error=infinite, low=-infinite, high=infinite,
            reason="not identifiable from the log",
        )  # fmt: skip
    low, high = interval_of(fit, name) if follows and name not in at_bounds(fit) else (-infinite, infinite)
    return Estimate(value=fit.values[name], unit=unit, standard_error=fit.errors[name], low=low, high=high)


def _notes(channels: TwoInertiaChannels, fit: RowFit) -> tuple[str, ...]:
    """Conventions that were found in the log."""
    how = (
        "is held from sample to sample"
        if fit.model.hold == "step"
        else "acts on straight lines between samples"
    )
    late = ", one sample late" if fit.model.delay else ""
    found = [f"the {readable(channels.input)} {how}{late}"]
    return (*found, *channels.notes)


def _condition(covariance: Array) -> float:
    scale = np.sqrt(np.diag(covariance))
    if not np.all(np.isfinite(scale)) or not np.all(scale > 0.0):
        return float("inf")
    return float(np.sqrt(np.linalg.cond(covariance / np.outer(scale, scale))))
