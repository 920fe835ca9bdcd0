"""One page about the identification of somebody's own log, with the figures of chapter 4."""

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path

import numpy as np

from cabledrive.answers.figures import number
from cabledrive.answers.runs import PARAMETERS
from cabledrive.identification.axis.axis import AxisOptions, channels_of
from cabledrive.identification.axis.equation import direction_of
from cabledrive.identification.estimates import Identification
from cabledrive.identification.log_response import compensated_torque, speed_of
from cabledrive.identification.logs.log import Log
from cabledrive.identification.signals import causal_filter, difference, ideal_low_pass, response_by_segments
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array
from cabledrive.parameters.files import check_writable, write_whole
from cabledrive.report.blocks import (
    Block,
    Chapter,
    Figure,
    Note,
    Panel,
    Paragraph,
    Plot,
    Section,
    Series,
    listed,
    time_plot,
)
from cabledrive.report.figures.followed import measured_picture
from cabledrive.report.page import page_of

LONGEST_WINDOW, END = 2.0, 0.25  # s; derivatives at the ends of a log are of one side
MOST_BYTES = 2**30
"""Of a log whose content hash is stated."""


def write_log_report(
    log: Log,
    found: Identification,
    path: str | Path,
    *,
    options: AxisOptions | None = None,
    files: Sequence[str | Path] = (),
    force: bool = False,
    written_at: datetime | None = None,
) -> Path:
    """Write the HTML page of one identified log, found with ``options`` in ``files``, whose hashes it states.

    Refused if the file exists (without `force`) or cannot be written.
    """
    path = check_writable(path, force=force)
    report = log.report
    said = [*report.repaired, *report.findings] or ["no repairs, no findings"]
    data = Paragraph(
        text=f"{report.rows} rows, {number(report.duration, 4)} s at {number(1.0 / report.interval, 4)} Hz. "
        f"Data check: {'; '.join(said)}."
    )
    chapter = Chapter(
        "Identification",
        "identification",
        (*_numbers(found), data),
        sections=_figures(log, found, options or AxisOptions()),
        methods=(str(found.method["name"]),),
    )
    hashes = [(f"{Path(name).name}, SHA-256 of the file", _hash(Path(name))) for name in files]
    page = page_of(log.source, f"Model {found.model}", (chapter,), hashes, written_at)
    return write_whole(path, page, force=force)


def _hash(path: Path) -> str:
    """SHA-256 of a file, piece by piece."""
    if path.stat().st_size > MOST_BYTES:
        return "not computed: larger than 1 GiB"
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _numbers(found: Identification) -> list[Block]:
    rows = (one.as_dict() | {"name": name.replace("_", " ")} for name, one in found.parameters.items())
    share, of = number(100 * found.residual["relative"], 3), found.method.get("residual_of", "torque")
    note = f"Residual {share} % of the measured {of}."
    parameters = listed("Identified parameters.", PARAMETERS, rows, note)
    words = [*found.unidentifiable, *found.findings]
    return [parameters, *(Note(text=word[:1].upper() + word[1:], tone="warning") for word in words)]


def _figures(log: Log, found: Identification, options: AxisOptions) -> tuple[Section, ...]:
    torque, position = channels_of(log)
    linear = log.units[torque] == "N"
    blocks: list[Block] = []
    with suppress(InputRefused):
        blocks.append(_regressors_plot(log, torque, regressor_curves(log, found, options)))
    window = min(LONGEST_WINDOW, log.report.duration / 6.0)
    if window * log.sample_rate >= 32:
        blocks.append(_response(log, found, (torque, position), window, linear))
    return (Section("Figures", "log-figures", tuple(blocks)),) if blocks else ()


def _response(
    log: Log, found: Identification, channels: tuple[str, str], window: float, linear: bool
) -> Figure:
    """Response from torque to speed, friction and offset taken off where they are known."""
    torque, speed = log.channel(channels[0]), speed_of(log, channels[1])
    model = None
    if found.identifiable and found.model in ("rigid-axis-coulomb", "rigid-axis-tanh"):
        inertia, viscous, coulomb, offset = (one.value for one in found.parameters.values())
        torque = compensated_torque(torque, speed, coulomb, offset)
        fine = np.geomspace(0.5, 0.4 * log.sample_rate, 300)
        model = (fine, 1.0 / (2j * np.pi * fine * inertia + viscous))
    measured = response_by_segments(torque, speed, log.interval, (window, 0.5 * window))
    unit = "m/(N s)" if linear else "rad/(N m s)"
    shown = measured.between(0.0, 0.4 * log.sample_rate)
    return Figure(
        name="log-response",
        alt="Magnitude and phase from torque to speed with their band, and the identified model.",
        caption=f"From torque to speed, windows of {number(window, 3)} s. Valid only at the "
        "frequencies excited in the log, where the band is narrow.",
        drawing=measured_picture("log-response", shown, model, unit),
    )


def _regressors_plot(log: Log, torque: str, curves: tuple[Array, Array, Array]) -> Plot:
    """Acceleration, speed and friction regressor, filtered and not; torque and modelling error."""
    inner = slice(round(END / log.interval), -round(END / log.interval))
    unfiltered, filtered, error = (own[..., inner] for own in curves)
    linear, measured = log.units[torque] == "N", log.channel(torque)[inner]
    share = float(np.sqrt(np.mean(error**2) / np.mean(measured**2)))
    length = "m" if linear else "rad"
    rows = (("Acceleration", f"{length}/s²"), ("Speed", f"{length}/s"), ("Friction regressor", "1"))
    panels = [
        Panel(title, unit, (Series("unfiltered", unfiltered[k], "quiet"), Series("filtered", filtered[k])))
        for k, (title, unit) in enumerate(rows)
    ]
    pushed = Series("measured", measured, "quiet"), Series("modelling error", error, "orange")
    panels.append(Panel("Force" if linear else "Torque", log.units[torque], pushed))
    return time_plot(
        "log-regressors",
        log.time[inner],
        panels,
        alt="Acceleration, speed and friction regressor over time, filtered and unfiltered; below, "
        "the measured torque and the modelling error.",
        caption="Filtered: causal, 20 Hz. The modelling error is "
        f"{number(100 * share, 3)} % of the torque, {END:g} s at both ends left out.",
    )


FILTER = 20.0
"""Natural frequency of the causal filter [Hz], as section 4.2.1 has it; damping 1."""
IDEAL = 50.0
"""Cutoff of the ideal low-pass for speed and acceleration [Hz], as section 4.2.1 has it."""
RESTING = 0.02
"""Share of the speed's size below which an axis counts as at rest."""


def regressor_curves(log: Log, found: Identification, options: AxisOptions) -> tuple[Array, Array, Array]:
    r"""Acceleration, speed and friction regressor of an identified axis, and its modelling error (4.9).

    The regressors by differences and the ideal low-pass, and through the causal filter (4.1), each
    (3, samples); the error :math:`[\ddot\theta,\ \dot\theta,\ S(\dot\theta),\ -1]\,P - \tau`, (samples,).
    """
    kind = found.model.removeprefix("rigid-axis-")
    if kind not in ("coulomb", "tanh") or not found.identifiable:
        raise InputRefused(f"{found.model}: curves are drawn of identified axes with one Coulomb friction")
    torque, position = (log.channel(name) for name in channels_of(log))
    interval = log.interval
    cutoff, natural = min(IDEAL, 0.2 / interval), min(FILTER, 0.1 / interval)
    speed = ideal_low_pass(difference(position, interval), interval, cutoff)
    acceleration = ideal_low_pass(difference(difference(position, interval), interval), interval, cutoff)
    if kind == "tanh":
        friction = np.tanh(options.friction.slope * speed)
    else:
        friction = direction_of(speed, RESTING * float(np.sqrt(np.mean(speed**2))))
    unfiltered = np.array([acceleration, speed, friction])
    _, slow, slower = causal_filter(position, interval, natural)
    filtered = np.array([slower, slow, causal_filter(friction, interval, natural)[0]])
    return unfiltered, filtered, found.values[:3] @ unfiltered - found.values[3] - torque
