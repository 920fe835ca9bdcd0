"""The bandwidth of a carriage's law: the smallest error that torque, sampling and stability allow."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from numpy.linalg import LinAlgError

from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.studies.study.bandwidth_cost import cheapest, moved_within
from cabledrive.studies.study.carriage_case import (
    CarriageCase,
    case_of,
    errors,
    growth,
    loop_at,
    torque_of,
    whole_run,
)
from cabledrive.studies.study.carriage_machine import carriage_values, transporter_with
from cabledrive.studies.study.controller_stage import SAMPLES_PER_PERIOD
from cabledrive.studies.study.goals import Goals
from cabledrive.studies.study.machine import Quantity

SHARES = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8)
"""Bandwidths that are tried, over the lowest frequency of the carriage on its cable along the way."""
SWINGS = (1.0, 1.5, 2.0, 3.0, 4.5)
"""The same over the frequency of the swing, where a mass hangs below the carriage."""
CENTRED = np.zeros(2)
OFF = np.array([0.25, -0.25])
"""Encoder phases of the run that measures the effect of quantisation, in counts."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageCandidate:
    """One bandwidth and what it costs."""

    bandwidth: float  # of the loop round the rigid whole [Hz]
    nominal: float | None = None  # largest error at the best values, encoders that do not count [m]
    # what each number within its bounds adds, by itself; the root of the squares' sum [m]
    uncertain: float | None = None
    sensors: float | None = None  # what counting adds [m]
    estimate: float | None = None  # all of it, with what the model leaves out [m]; no theorem's bound
    torque: float | None = None  # largest torque with encoders that count [N m]
    # largest real part of a pole along the way, the cable at its best value and at its bounds [1/s]
    growth: float | None = None
    refused: str = ""  # why it cannot be used; empty where it can


@dataclass(frozen=True, slots=True, kw_only=True)
class CarriageController:
    """The law of a carriage."""

    name: str
    bandwidth: float | None  # [Hz]; None: none could be used
    chosen: CarriageCandidate | None
    candidates: tuple[CarriageCandidate, ...]
    shares: dict[str, float]  # what each uncertain number adds to the error [m]
    both: bool  # whether the law listens to the encoder of the load pulley as well
    # positions, frequencies: places along the way [m] and the carriage's frequency on its cable there [Hz]
    positions: tuple[float, ...]
    frequencies: tuple[float, ...]
    reason: str


def design_carriage_law(
    drive: Drive, goals: Goals, quantities: Mapping[str, Quantity], left_out: float
) -> CarriageController:
    """The scheduled law with the smallest estimated error; ``left_out``: what the model leaves out [m]."""
    case = case_of(drive, goals)
    lowest, rate = float(case.cable_frequencies.min()), 1.0 / case.interval / SAMPLES_PER_PERIOD
    hertz = _bandwidths(case, lowest, rate)
    tried = (evaluate(case, quantities, f, left_out) for f in hertz)
    candidates, best, parts = cheapest(tried, "estimate")
    return CarriageController(
        name="scheduled",
        bandwidth=None if best is None else best.bandwidth,
        chosen=best,
        candidates=candidates,
        shares=parts,
        both=len(case.reads) > 1,
        positions=tuple(float(x) for x in case.places),
        frequencies=tuple(float(f) for f in case.cable_frequencies),
        reason=_reason(best, candidates, lowest, rate),
    )


def _bandwidths(case: CarriageCase, lowest: float, rate: float) -> list[float]:
    """From the lowest on; what is too fast for sampling or for the cable is not tried."""
    hertz = [share * lowest for share in SHARES]
    if case.hanging:
        swing = (case.design.gravity / case.design.line_length) ** 0.5 / (2.0 * pi)
        hertz += [share * swing for share in SWINGS if share * swing < SHARES[-1] * lowest]
    return sorted({float(f"{f:.3g}") for f in hertz if f <= rate})


def evaluate(
    case: CarriageCase, quantities: Mapping[str, Quantity], hertz: float, left_out: float
) -> tuple[CarriageCandidate, dict[str, float]]:
    """What one bandwidth costs: ``shares``: what each number adds [m]; ``hertz``, ``left_out`` [Hz], [m]."""
    empty = CarriageCandidate(bandwidth=hertz)
    try:
        ideal, real = (loop_at(case, hertz, ideal=kind) for kind in (True, False))
    except LinAlgError as failure:
        return replace(empty, refused=f"no feedback or observer exists: {failure}"), {}
    best, cable = carriage_values(case.drive, case.goals), quantities["cable_stiffness"]
    tried = {"the cable at its best value": cable.value}
    tried |= dict(zip(("the cable at its softest", "the cable at its stiffest"), cable.outer, strict=True))
    plants = {
        words: transporter_with(case.drive, best | {"cable_stiffness": stiff})
        for words, stiff in tried.items()
    }
    rate, place, bound = max((*growth(case, real, plant), words) for words, plant in plants.items())
    empty = replace(empty, growth=rate)
    if rate >= 0.0:
        return replace(empty, refused=f"unstable at {place:.3g} m, {bound}"), {}
    clean, seen = whole_run(case, ideal, {}, CENTRED), whole_run(case, real, {}, OFF)
    if min(len(clean), len(seen)) < len(case.reference):
        return replace(empty, refused="a strand goes slack, or the carriage leaves its span"), {}

    def error(values: Mapping[str, float]) -> Array | None:
        log = whole_run(case, ideal, values, CENTRED) if values else clean
        return errors(case, log) if len(log) == len(case.reference) else None

    found = moved_within(quantities, quantities, error)
    if found is None:
        why = "for some parameters within their bounds the drive diverges, or a strand goes slack"
        return replace(empty, refused=why), {}
    largest = {name: np.abs(both).max(axis=0) for name, both in found.items()}
    # At every sample by squares: the numbers are drawn independently of one another.
    moved = np.sqrt(
        np.sum([np.zeros_like(errors(case, clean)), *(one**2 for one in largest.values())], axis=0)
    )
    nominal = np.abs(errors(case, clean))
    sensors = float(np.abs(errors(case, seen) - errors(case, clean)).max())
    torque, saturated = torque_of(case, seen)
    return replace(
        empty,
        nominal=float(nominal.max()),
        uncertain=float(moved.max()),
        sensors=sensors,
        estimate=float((nominal + moved).max()) + sensors + left_out,
        torque=torque,
        refused=f"the torque reaches its limit of {torque:.4g} N m" if saturated else "",
    ), {name: float(one.max()) for name, one in largest.items()}


def _reason(
    best: CarriageCandidate | None, candidates: tuple[CarriageCandidate, ...], lowest: float, rate: float
) -> str:
    if best is None:
        why = candidates[0].refused if candidates else f"none is below {rate:.3g} Hz, a fortieth of sampling"
        return f"no bandwidth can be used: {why}"
    assert best.estimate is not None
    return (
        f"{best.bandwidth:g} Hz gives the smallest estimated error, {1e3 * best.estimate:.3g} mm, while "
        f"stable along the way with the cable at both of its bounds and without excessive torque ripple "
        f"from quantisation; the carriage vibrates on its cable at {lowest:.3g} Hz and more"
    )
