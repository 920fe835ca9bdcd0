"""What the fast model recorded, in the words and columns of the exact one, and whether it holds."""

from math import pi
from typing import Any

import numpy as np

from cabledrive.parameters import Drive, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.version import __version__
from cabledrive.reduction.uniform_tension import HIGHEST_SHARE, UniformTensionModel
from cabledrive.reduction.uniform_tension_integration import IntegratedMotion
from cabledrive.simulation import SimulationResult, SlackEvent
from cabledrive.simulation.channels import COLUMN, WIDTH

STEEPEST = 0.05
"""Largest slope of the cable for which the tension may count as uniform; (slope)^2 is the relative error."""


def bounded_part(recorded: IntegratedMotion, longest: float) -> tuple[IntegratedMotion, int | None]:
    """What was recorded before an amplitude outgrew ``longest`` [m] or the numbers, and how many records.

    Their number is None if all are kept.
    """
    sizes = np.abs(recorded.across[:, 0]).max(axis=(1, 2, 3))
    finite = np.isfinite(recorded.along).all(axis=(1, 2)) & np.isfinite(recorded.tallies).all(axis=1)
    bounded = finite & (sizes < longest)
    if bounded.all():
        return recorded, None
    kept = max(1, int(np.argmin(bounded)))
    along, across, tallies = recorded.along[:kept], recorded.across[:kept], recorded.tallies[:kept]
    return IntegratedMotion(along, across, tallies, recorded.peaks), kept


def fast_rows(model: UniformTensionModel, recorded: IntegratedMotion, torque: Array) -> Array:
    """Records, shape (records, columns of the exact model), from the motion and the torque there [N m].

    What the reduced model does not distinguish stays zero.
    """
    q, p = recorded.along[:, 0], recorded.along[:, 1]
    a, b = recorded.across[:, 0], recorded.across[:, 1]
    rows = np.zeros((q.shape[0], WIDTH + 6))
    shafts = np.column_stack((model.rims / model.radii, model.torque_shape))
    for column, shape in zip(("drive", "load", "motor"), shafts.T, strict=True):
        rows[:, COLUMN[f"{column}_angle"]] = q @ shape
        rows[:, COLUMN[f"{column}_speed"]] = p @ shape
    stretched = np.einsum("npjm,m->nj", a**2, 0.25 * model.wave_numbers**2 * model.span)
    tension = (
        q @ (model.stiffness / model.span * model.stretch) + model.axial_rigidity / model.span * stretched
    )
    swing = 0.5 * model.transverse_mass * np.einsum("npjm->nj", b**2)
    string = 0.5 * model.transverse_mass * np.einsum("npjm,m->nj", a**2, model.transverse**2)
    carried = 0.5 * model.transverse_mass * model.carrier * stretched**2 * 4.0 / model.span
    pumping = np.einsum("nk,kjm,npjm->nj", q, model.coupling, a**2)
    strain = string + 0.5 * carried + pumping + 0.25 * ((q * model.natural) ** 2).sum(axis=1)[:, None]
    for j, span in enumerate(("upper", "lower")):
        rows[:, COLUMN[f"mean_tension_{span}"]] = model.pretension + tension[:, j]
        rows[:, COLUMN[f"least_tension_{span}"]] = model.pretension + tension[:, j]
        rows[:, COLUMN[f"transverse_energy_{span}"]] = swing[:, j]
        rows[:, COLUMN[f"strain_energy_{span}"]] = strain[:, j]
        rows[:, COLUMN[f"axial_energy_{span}"]] = 0.25 * (p**2).sum(axis=1)
        middle = np.sin(0.5 * pi * np.arange(1, model.transverse.size + 1))
        for plane in range(a.shape[1]):
            rows[:, WIDTH + 3 * j + (2 - plane)] = a[:, plane, j] @ middle
    rows[:, COLUMN["weight_energy"]] = -model.transverse_mass * np.einsum(
        "njm,jm->n", a[:, 0], model.gravity_load
    )
    rows[:, COLUMN["torque"]] = torque
    rows[:, COLUMN["torque_work"]] = recorded.tallies[:, 0]
    rows[:, COLUMN["transverse_loss"]] = recorded.tallies[:, 1]
    rows[:, COLUMN["viscous_loss"]] = recorded.tallies[:, 2]
    rows[:, COLUMN["balance"]] = _balance(rows)
    return rows


def _balance(rows: Array) -> Array:
    """Energy plus losses minus work."""
    kept = ("axial_energy_", "transverse_energy_", "strain_energy_")
    names = [f"{name}{span}" for name in kept for span in ("upper", "lower")]
    names += ["weight_energy", "transverse_loss", "viscous_loss"]
    return rows[:, [COLUMN[name] for name in names]].sum(axis=1) - rows[:, COLUMN["torque_work"]]


def fast_result(
    drive: Drive,
    model: UniformTensionModel,
    recorded: IntegratedMotion,
    rows: Array,
    *,
    grid: tuple[int, float, int],
    torque: str,
    diverged: bool = False,
) -> SimulationResult:
    """A run of the fast model in the form of an exact one, its limits checked.

    ``rows``, shape (records, columns); ``grid``: steps, step [s], steps per record; ``torque``: fingerprint
    of the torque; ``diverged``: whether the records end where an amplitude outgrew the span.
    Returns with `stopped` set where the model does not hold; the time it took is left to the caller.
    """
    steps, step, stride = grid
    times = np.arange(rows.shape[0], dtype=np.float64) * (stride * step)
    events, stopped = _limits(model, recorded, rows, times, diverged)
    at_rest = -0.5 * model.transverse_mass * np.sum((model.gravity_load / model.transverse) ** 2)
    handled = rows[0, COLUMN["balance"]] - at_rest + np.max(np.abs(rows[:, COLUMN["torque_work"]]))
    spans = ("upper", "lower")
    return SimulationResult(
        time=times,
        rows=rows,
        probes=tuple((span, 0.5 * model.span) for span in spans),
        field_time=np.empty(0),
        fields=np.empty((0, 3, 0)),
        spans=spans,
        position=np.tile([0.0, 0.5 * model.span, model.span], (2, 1)),
        steps=steps,
        step=step,
        cfl=step * max(model.natural.max(), model.transverse.max()) / pi,
        energy_handled=float(handled),
        slack_events=events,
        extremes=_extremes(rows),
        provenance=_provenance(drive, model, steps, step, torque),
        stopped=stopped,
        wall_time=0.0,
    )


def _limits(
    model: UniformTensionModel, recorded: IntegratedMotion, rows: Array, times: Array, diverged: bool
) -> tuple[tuple[SlackEvent, ...], str | None]:
    """Slack and steepness, over all steps."""
    slope = float(model.wave_numbers[0] * recorded.peaks[:, 1].max())
    for j, span in enumerate(("upper", "lower")):
        if model.pretension + recorded.peaks[j, 0] < 0.0:
            tension = rows[:, COLUMN[f"mean_tension_{span}"]]
            first = int(np.argmax(tension < 0.0)) if np.any(tension < 0.0) else int(np.argmin(tension))
            event = SlackEvent(
                time=float(times[first]), span=span, position=0.0, tension=float(tension[first])
            )
            line = f"the {span} span goes slack at t = {times[first]:.6g} s"
            return (event,), f"{line}: lower the torque or use --model exact"
    if diverged:
        line = f"the displacement exceeds the span after t = {times[-1]:.6g} s"
        return (), f"{line}: lower the torque or use --model exact"
    if slope > STEEPEST:
        line = f"the cable reaches a slope of {slope:.3g}, the fast model is valid below {STEEPEST}"
        return (), f"{line}: use --model exact"
    return (), None


def _extremes(rows: Array) -> dict[str, float]:
    """Least and largest of the records; they are as dense as the step unless a rate was asked for."""
    found = {}
    for shaft in ("drive", "load", "motor"):
        angle = rows[:, COLUMN[f"{shaft}_angle"]]
        found[f"{shaft}_angle_min"], found[f"{shaft}_angle_max"] = float(angle.min()), float(angle.max())
    for j, span in enumerate(("upper", "lower")):
        for plane, column in (("v", 1), ("w", 2)):
            found[f"{span}_{plane}_peak"] = float(np.max(np.abs(rows[:, WIDTH + 3 * j + column])))
    return found


def _provenance(
    drive: Drive, model: UniformTensionModel, steps: int, step: float, torque: str
) -> dict[str, Any]:
    return {
        "cabledrive": __version__,
        "drive": drive.name,
        "drive_hash": content_hash(drive),
        "method": {
            "name": "uniform-tension modes",
            "model": "fast",
            "sines": model.transverse.size,
            "longitudinal_modes": int(np.count_nonzero(model.natural)),
            "step": step,
            "ends_at_hz": HIGHEST_SHARE * model.span_resonance / (2 * pi),
        },
        "duration": steps * step,
        "torque": torque,
        "torque_offset": drive.motor.offset_torque if drive.motor else 0.0,
    }
