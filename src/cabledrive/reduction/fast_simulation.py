"""The fast model behind the door of the exact one: same start, torque and record, in the same words."""

import time
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path

import numpy as np

from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.mesh import Mesh, mesh_of
from cabledrive.mechanics.network.motion import gravity
from cabledrive.parameters import Drive, InputRefused, Machine, content_hash
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.fields import require_known
from cabledrive.parameters.files import check_writable, not_written, one_process
from cabledrive.parameters.route.drive import ANGLES
from cabledrive.parameters.route.two_pulleys import NAMES, two_pulleys_of
from cabledrive.parameters.version import __version__
from cabledrive.reduction.stretches import StretchModel, numbers_of
from cabledrive.reduction.uniform_tension import IntegratedMotion, integrate, uniform_tension_model
from cabledrive.simulation import Recording, Signal, SimulationResult, SlackEvent, Start
from cabledrive.simulation.case import released_torque
from cabledrive.simulation.channels import channels_of, speed_name
from cabledrive.simulation.keeping import MOST_MEMORY, RESULT, part_of
from cabledrive.simulation.netcdf import write_netcdf
from cabledrive.simulation.network.mesh import rest_of
from cabledrive.simulation.prepared import extremes_of
from cabledrive.simulation.result import neglected
from cabledrive.simulation.signals import Function, checked_signal
from cabledrive.simulation.start import at_start

REMEDY, SPANS = "lower the torque or use --model exact", ("upper", "lower")
CHANNELS = channels_of(ANGLES, NAMES[:1], SPANS, points=[f"the middle of {span}" for span in SPANS])
COLUMN = {channel.name: number for number, channel in enumerate(CHANNELS)}


def _rows(drive: Drive, model: StretchModel, recorded: IntegratedMotion, torque: Array) -> Array:
    """Records, shape (records, columns), from the motion and the torque there [N m].

    The energy of motion along the ropes counts as that of bodies; along its spans a cable moves as in the
    longitudinal modes, slopes apart.
    """
    (q, p), (a, b) = recorded.along.swapaxes(0, 1), recorded.across.swapaxes(0, 1)
    stretched = 0.5 * np.einsum("nbm,bm->nb", a**2, model.square)
    pumping = 0.5 * np.einsum("nk,kbm,nbm->nb", q, model.coupling, a**2)
    string = 0.5 * np.einsum("nbm,bm->nb", a**2, model.mass * model.transverse**2)
    strain = string + pumping + 0.5 * stretched * (stretched @ model.carried)
    tension = model.rest + q @ model.tension.T + stretched @ model.raised.T
    weight = -np.einsum("nbm,bm->n", a, model.mass * model.transverse**2 * model.sag)
    work, across, viscous = recorded.tallies.T
    found = {
        "rope_energy": 0.5 * np.einsum("nbm,bm->n", b**2, model.mass),
        "body_energy": 0.5 * (p**2).sum(axis=1),
        "strain_energy": strain.sum(axis=1) + 0.5 * ((q * model.natural) ** 2).sum(axis=1) + weight,
        "transverse_loss": across,
        "viscous_loss": viscous,
    }
    found["balance"] = np.sum(list(found.values()), axis=0) - work
    found |= {"torque_work": work, f"torque on {NAMES[0]}": torque}
    for name, shape in zip(ANGLES, model.motions, strict=True):
        found |= {name: q @ shape, speed_name(name): p @ shape}
    for j, span in enumerate(SPANS):
        found |= {f"mean tension, {span}": tension[:, j], f"least tension, {span}": tension[:, j]}
    points = [f"{plane} at the middle of {span}" for plane in "wv" for span in SPANS]
    moved = a - model.sag if drive.called else a  # of a machine with routes from rest
    found |= {point: moved[:, j] @ model.probes[j, :, 0] for j, point in enumerate(points[: a.shape[1]])}
    half_turns = 0.5 * model.natural * drive.pulley_distance / drive.cable.axial_wave_speed
    rims = 0.5 * np.array([pulley.radius for pulley in drive.pulley]) @ model.motions[:2] / np.cos(half_turns)
    found |= {f"u at the middle of {span}": q @ rims for span in SPANS}
    rows = np.zeros((len(q), len(CHANNELS)))
    rows[:, [COLUMN[name] for name in found]] = np.column_stack(list(found.values()))
    return rows


def _result(
    drive: Drive,
    model: StretchModel,
    recorded: IntegratedMotion,
    torque: tuple[Array, dict[str, str]],
    grid: tuple[int, float, int],
) -> SimulationResult:
    """A run of the fast model in the form of an exact one, `stopped` set where the model does not hold.

    ``torque``: at the records [N m], its fingerprint and the hash of the drive; ``grid``: steps, step [s],
    steps per record, of which fewer were recorded where an amplitude outgrew the span. The time it took is
    left to the caller.
    """
    steps, step, stride = grid
    rows = _rows(drive, model, recorded, torque[0][: len(recorded.along)])
    if diverged := len(rows) < steps // stride + 1:
        steps = stride * (len(rows) - 1)
    times, length = np.arange(rows.shape[0], dtype=np.float64) * (stride * step), drive.pulley_distance
    names = drive.called or SPANS
    events, stopped = _limits(model, recorded, rows, times, names)
    if diverged and not events:
        stopped = f"the displacement exceeds the span after t = {times[-1]:.6g} s: {REMEDY}"
    at_rest = -0.5 * np.sum(model.mass * (model.transverse * model.sag) ** 2)
    handled = rows[0, COLUMN["balance"]] - at_rest + np.max(np.abs(rows[:, COLUMN["torque_work"]]))
    # least and largest of the records, which are as dense as the step unless a rate was asked for
    extremes = extremes_of(ANGLES, np.stack([own(rows[:, :3], axis=0) for own in (np.min, np.max)]))
    peaks = np.abs(rows[:, [COLUMN[f"w at the middle of {span}"] for span in SPANS]]).max(axis=0)
    return SimulationResult(
        time=times,
        rows=rows,
        probes=tuple((span, 0.5 * length) for span in names),
        field_time=np.empty(0),
        fields=np.empty((0, 3, 0)),
        spans=names,
        channels=channels_of(ANGLES, NAMES[:1], names, points=[f"the middle of {span}" for span in names]),
        midpoint_peaks=dict(zip(names, peaks.tolist(), strict=True)),
        steps=steps,
        step=step,
        largest_step=pi / max(model.natural.max(), model.transverse.max()),
        energy_handled=float(handled),
        slack_events=events,
        extremes=extremes,
        assumptions=neglected([drive.cable], drive.motors)
        + ("the cable does not slip: capstan_friction is left out",)
        * any(p.capstan_friction for p in drive.pulley),
        provenance={
            "cabledrive": __version__,
            "drive": drive.name,
            "method": {
                "name": "uniform-tension modes",
                "model": "fast",
                "sines": model.slopes.size,
                "longitudinal_modes": int(np.count_nonzero(model.natural)),
                "step": step,
                "ends_at_hz": model.highest / (2 * pi),
            },
            "duration": steps * step,
            **torque[1],
            "torque_offset": drive.motor.offset_torque if drive.motor else 0.0,
        },
        stopped=stopped,
        wall_time=0.0,
    )


def _limits(
    model: StretchModel, recorded: IntegratedMotion, rows: Array, times: Array, names: tuple[str, ...]
) -> tuple[tuple[SlackEvent, ...], str | None]:
    """Slack and steepness, over all steps; ``names``: of the spans."""
    why = why_not(model, recorded.peaks, names)
    if why and "slack" in why:
        number = int(np.argmax(recorded.peaks[:, 0] < 0.0))
        span, tension = names[number], rows[:, COLUMN[f"mean tension, {SPANS[number]}"]]
        first = int(np.argmax(tension < 0.0)) if np.any(tension < 0.0) else int(np.argmin(tension))
        event = SlackEvent(time=float(times[first]), span=span, position=0.0, tension=float(tension[first]))
        return (event,), f"{why} at t = {times[first]:.6g} s: {REMEDY}"
    return (), why and f"{why}: use --model exact"


def why_not(model: StretchModel, peaks: Array, names: tuple[str, ...] = SPANS) -> str | None:
    """Why the model does not hold where `IntegratedMotion.peaks` were reached; None where it does."""
    for span, tension in zip(names, peaks[:, 0], strict=True):
        if tension < 0.0:
            return f"the {span} span goes slack"
    if not np.all(np.isfinite(peaks)):
        return "diverged: lower the torque or the plucks"
    slope = float(model.slopes[0] * peaks[:, 1].max())
    if slope <= model.steepest:
        return None
    return f"the cable reaches a slope of {slope:.3g}, the fast model is valid below {model.steepest}"


HIDDEN_SHARE = 1e-3
"""Largest share of the torque's energy that may lie above the model's frequencies."""

_PER_PULLEY_PERIOD, _PER_SINE_RADIAN = 60.0, 2.0
_PROJECTION_SEGMENTS = 512
_MOST_STEPS = 200_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class FastScheme:
    """How the fast model is set up."""

    sines: int = 16  # transverse modes per span and plane; 1 for half-sine plucks, more for a triangle
    step: float | None = None  # time step [s]; None: a sixtieth of the pulley mode's period or finer


def simulate_fast(
    drive: Machine | Drive,
    duration: float,
    *,
    torque: Signal | float | Function = 0.0,
    start: Start | None = None,
    scheme: FastScheme | None = None,
    recording: Recording | None = None,
    output: str | Path | None = None,
    force: bool = False,
) -> SimulationResult:
    """Motion of the loop by the uniform-tension model, a hundred times faster than the chain.

    It integrates (R.1)-(R.3) by (R.4). Good below the first longitudinal resonance of a span, without slack,
    for slopes below 0.05 and without questions of wave fronts; the first three limits are checked. All losses
    of the longitudinal modes are in the channel "viscous_loss".

    Parameters
    ----------
    drive : Machine or Drive
        A loop round two pulleys without carriages, held pulleys and Coulomb friction.
    duration : float
        Length of the run [s].
    torque : Signal, float or callable, default 0.0
        Torque of the motor, of the drive pulley where there is none [N m].
    start : Start, optional
        Plucks in v and w, angles and speeds at t = 0; by default the straight cable at rest.
    scheme : FastScheme, optional
    recording : Recording, optional
        Only its rate is used.
    output : path-like, optional
        NetCDF file to write.
    force : bool, default False
        Whether an existing file may be replaced.

    Returns
    -------
    SimulationResult
        Also where a span would go slack or the cable gets too steep: ``stopped`` says so.

    Raises
    ------
    InputRefused
        If the drive, the start or the torque does not fit the model.
    """
    began, own = time.perf_counter(), content_hash(drive)
    drive = two_pulleys_of(drive, "the fast model, unlike --model exact,")
    path = None if output is None else check_writable(output, force=force)
    scheme, start, recording = scheme or FastScheme(), start or Start(), recording or Recording()
    model = uniform_tension_model(drive, scheme.sines)
    steps, stride, step = grid_of(model, duration, scheme, recording)
    # torque and its spectrum per step, amplitudes and row per record
    size = 64 * steps + 8 * (steps // stride + 1) * (8 * scheme.sines + 2 * model.natural.size + 100)
    if size > MOST_MEMORY:
        said = f"this run takes {size / 1e9:.3g} GB of memory, at most {MOST_MEMORY / 1e9:.0f} GB are used"
        raise InputRefused(f"{said}: lower rate or shorten it")
    signal = checked_signal(torque, "torque", duration, step)
    samples = signal.at(np.arange(steps + 1, dtype=np.float64) * step) + (
        drive.motor.offset_torque if drive.motor else 0.0
    )
    check_band(model, samples, step)
    ours = dict(zip(drive.called or SPANS, SPANS, strict=True))
    for pluck in (*start.plucks, *start.kicks):
        require_known(pluck.span[:60], ours, f'pluck: "{pluck.span[:60]}" is no span')
    both = (start.plucks, start.kicks)
    plucks, kicks = (tuple(replace(one, span=ours[one.span]) for one in own) for own in both)
    start = replace(start, plucks=plucks, kicks=kicks)
    if drive.called:  # a machine with routes starts at rest
        start = replace(start, from_equilibrium=True, hold="drive")
    state = start_amplitudes(drive, model, start)
    if len(state[2]) > len(SPANS):
        model = uniform_tension_model(drive, scheme.sines, planes=2)
    recorded = integrate(numbers_of(model, step), state, samples, stride)
    # records before an amplitude outgrew the span, or the numbers
    sizes = np.abs(recorded.across[:, 0]).max(axis=(1, 2))
    finite = np.isfinite(recorded.along).all(axis=(1, 2)) & np.isfinite(recorded.tallies).all(axis=1)
    bounded = finite & (sizes < drive.pulley_distance)
    if not bounded.all():
        kept = max(1, int(np.argmin(bounded)))
        along, across, tallies = recorded.along[:kept], recorded.across[:kept], recorded.tallies[:kept]
        recorded = IntegratedMotion(along, across, tallies, recorded.peaks)
    given = samples[: steps + 1 : stride], {"torque": signal.fingerprint, "drive_hash": own}
    result = _result(drive, model, recorded, given, (steps, step, stride))
    result = replace(result, wall_time=time.perf_counter() - began)
    if path is None:
        return result
    with one_process(part_of(path)):  # another process may be writing under the same name
        try:
            write_netcdf(result.content, path, part_of(path) / RESULT, force=force)
        except OSError as error:
            raise not_written(path, error) from None
    return replace(result, path=path)


def grid_of(
    model: StretchModel, duration: float, scheme: FastScheme, recording: Recording
) -> tuple[int, int, float]:
    """Steps of a run of some length [s], steps per record and step [s]; refused where they make no sense."""
    if not (np.isfinite(duration) and duration > 0.0):
        raise InputRefused(f"duration = {duration:.9g} s must be positive and finite: give a time in seconds")
    largest = pi / (2.0 * max(model.natural.max(), model.transverse.max()))
    if scheme.step is not None and not 0.0 < scheme.step <= largest:
        raise InputRefused(f"step = {scheme.step:.4g} s must be positive and at most {largest:.4g} s here")
    steps = max(1, int(np.ceil(duration / (scheme.step or finest_step(model)))))
    if steps > _MOST_STEPS:
        raise InputRefused(
            f"duration = {duration:.4g} s takes {steps} steps, at most {_MOST_STEPS}: shorten it"
        )
    step = duration / steps
    return steps, max(1, int(1.0 / (recording.rate * step))), step


def finest_step(model: StretchModel) -> float:
    """Step that resolves every mode of the model [s]."""
    return float(
        min(2 * pi / (_PER_PULLEY_PERIOD * model.natural.max()), _PER_SINE_RADIAN / model.transverse.max())
    )


def check_band(model: StretchModel, samples: Array, step: float) -> None:
    """Refuse a torque [N m], sampled every ``step`` [s], not finite or where the model has no modes."""
    if not np.all(np.isfinite(samples)):
        raise InputRefused("torque must be finite at every step: repair the samples")
    content = np.abs(np.fft.rfft((samples - samples.mean()) * np.hanning(samples.size))) ** 2
    frequency = 2 * pi * np.fft.rfftfreq(samples.size, step)
    top = model.highest
    hidden = content[frequency > top].sum() / max(content.sum(), 1e-300)
    if hidden > HIDDEN_SHARE:
        said = f"torque: {100 * hidden:.2g} % of its energy lies above {top / (2 * pi):.4g} Hz"
        raise InputRefused(f"{said}, where the fast model ends: use --model exact")


def start_amplitudes(drive: Drive, model: StretchModel, start: Start) -> tuple[Array, Array, Array, Array]:
    """Amplitudes and rates at t = 0: sines by projection, longitudinal modes by the rims.

    Returns ``q, p``, shape (k,): longitudinal amplitudes [m kg^1/2] and rates; ``a, b``, shape (rows, m):
    transverse amplitudes [m] and rates of both spans, in the plane w, and in v where something moves in it.
    Raises `InputRefused` if the start does not fit the model.
    """
    mesh, law = mesh_of(drive.machine, _PROJECTION_SEGMENTS), cable_law(drive.cable)
    if any(pluck.plane == "u" for pluck in (*start.plucks, *start.kicks)):
        raise InputRefused(
            "pluck: plane = u does not fit the fast model, where u follows the rims: use --model exact"
        )
    rest = rest_of(mesh, [law] * len(mesh.pieces), gravity(drive.machine))
    place, speed, q, q_t = at_start(mesh, [law], rest, start, released_torque(mesh))
    sines = [_sines(mesh, field, model.slopes.size) for field in (place - rest.counted, speed)]
    moving = 4 if any(np.any(part[2:]) for part in sines) else 2
    radii = np.array([own.radius for own in (*drive.pulley, drive.drive_pulley)])[:, None]
    rims = radii * mesh.turns[:3] @ np.column_stack([q - rest.turned, q_t])
    along = np.linalg.lstsq(radii * model.motions, rims, rcond=None)[0].T
    return along[0], along[1], sines[0][:moving].copy(), sines[1][:moving].copy()


def _sines(mesh: Mesh, field: Array, count: int) -> Array:
    """Sine amplitudes of w on both spans, then of v, shape (4, count)."""
    n = mesh.nodes[0, 1]
    basis = np.sin(np.outer(np.arange(1, count + 1), np.arange(n + 1)) * pi / n)
    spans = np.stack([field[:, first : last + 1] for first, last in mesh.nodes])
    return np.concatenate([2.0 / n * spans[:, plane] @ basis.T for plane in (2, 1)])
