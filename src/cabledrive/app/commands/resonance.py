"""`cabledrive resonance`: how near a drive is to its internal resonance, and what would help."""

from typing import Any

import click
import numpy as np

from cabledrive.app.options import (
    NewFile,
    NewFileType,
    Quantity,
    Subcommand,
    answering,
    drive_argument,
    saves_answer,
)
from cabledrive.app.results import Absent, Answer, provenance
from cabledrive.parameters import Drive
from cabledrive.studies.alarm import AlarmResult, alarm
from cabledrive.studies.motion_file import read_motion
from cabledrive.studies.resonance import ResonanceSummary, resonance_summary
from cabledrive.studies.resonance_remedies import Remedy, remedies, sensitivity
from cabledrive.studies.resonance_standing import BUILD_UP, SAFE

FLOOR, LIMIT = 1e-5, 5e-4
METHOD = "certified modes, coupling by exact integrals, averaged equations to second order"
SEED = 0
NUMBERS = ("frequency_ratio", "tuned_pretension", "threshold_torque", "detuning")


@click.command(
    cls=Subcommand,
    example="cabledrive resonance dissertation-2 --torque 10mN*m --map map.html",
    short_help="How near DRIVE is to the internal resonance of chapter 5, and what would help.",
)
@answering
@saves_answer
@drive_argument
@click.option(
    "--torque",
    type=Quantity("N m"),
    metavar="NM",
    help="Amplitude of the torque that the verdict is about; the torque limit, else 1 % of the slack torque.",
)
@click.option(
    "--load-torque",
    type=Quantity("N m"),
    default=0.0,
    metavar="NM",
    help="Steady torque on the load pulley, which splits the tuning of the two spans.",
)
@click.option(
    "--motion",
    "motion_file",
    type=click.Path(),
    metavar="FILE",
    help="Judge a planned motion: a CSV file with time [s], torque [N m] and, where they change, pretension "
    "[N], carriage [m], load torque [N m].",
)
@click.option(
    "--floor",
    type=Quantity("m"),
    default=FLOOR,
    metavar="M",
    help="Transverse amplitude that is always there, for --motion; 10 um unless told.",
)
@click.option(
    "--limit",
    type=Quantity("m"),
    default=LIMIT,
    metavar="M",
    help="Largest transverse amplitude allowed, for --motion; 0.5 mm unless told.",
)
@click.option(
    "--map",
    "map_file",
    type=NewFileType(".html"),
    metavar="FILE",
    help="Draw growth over pretension and torque into FILE, an interactive page that needs nothing else.",
)
def command(
    drive: Drive,
    torque: float | None,
    load_torque: float,
    motion_file: str | None,
    floor: float,
    limit: float,
    map_file: NewFile | None,
) -> Answer:
    """Frequency ratio, tuned pretension, threshold torque and verdict for the internal resonance of DRIVE.

    The resonance is between the pulleys' own mode and transverse modes near half its frequency. With --motion
    a planned motion is judged as well: where along it the cable is pumped, how far it grows, what would help.
    """
    found = resonance_summary(drive, torque=torque, load_torque=load_torque)
    changes = () if found.verdict == SAFE else remedies(drive, found.torque, load_torque)
    judged = None
    if motion_file is not None:
        judged = alarm(drive, read_motion(motion_file), floor=floor, limit=limit)
    if map_file is not None:
        from cabledrive.report.resonance_map_page import resonance_map_page
        from cabledrive.studies.map_spot_checks import spot_check_line, spot_checks
        from cabledrive.studies.resonance_map import growth_map

        growth = growth_map(drive, torque=found.torque, load_torque=load_torque)
        checks = () if load_torque else spot_checks(drive, growth, np.random.default_rng(SEED))
        map_file.write(resonance_map_page(growth, spot_check_line(checks)))
    data = resonance_data(drive, found, changes, load_torque)
    text = _text(drive, found, changes)
    if judged is not None:
        data["motion"] = alarm_data(judged)
        text += "\n\n" + alarm_text(judged)
    return Answer(
        data=data,
        text=text,
        provenance=provenance(drive, method=METHOD, tolerances={"build_up": BUILD_UP}),
    )


def resonance_data(
    drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...], load_torque: float = 0.0
) -> dict[str, Any]:
    """The summary as JSON gives it.

    Parameters
    ----------
    drive : Drive
    found : ResonanceSummary
    changes : tuple of Remedy
    load_torque : float, default 0.0
        Steady torque on the load pulley [N m].

    Returns
    -------
    dict
        SI; frequencies in Hz where the key says so.
    """
    standing = found.standing
    data: dict[str, Any] = {name: _number(found, name) for name in NUMBERS}
    data |= {"verdict": found.verdict, "reasons": found.reasons, "torque": found.torque}
    data |= {"pulley_frequency_hz": _number(found, "pulley_frequency")}
    data |= {
        "threshold_torque_at_own_pretension": _number(found, "threshold_here"),
        "tenfold_growth_torque": _number(found, "growth_torque"),
        "coulomb_onset_torque": _number(found, "coulomb_onset"),
    }
    if standing is not None:
        data["tongue"] = {
            "distance": standing.distance,
            "half_width": standing.half_width,
            "growth_rate": standing.growth,
            "pulley_amplitude": standing.amplitude,
            "slack": standing.slack,
        }
        data["sensitivity"] = sensitivity(drive, found.torque, load_torque)
    if found.split:
        data["load_torque"] = load_torque
        data["tuned_pretension_under_load"] = {
            span: Absent(reason="no pretension in reach tunes it") if value is None else value
            for span, value in found.split.items()
        }
    data["pairs"] = [
        {
            "span": pair.span,
            "section": pair.section,
            "number": pair.number,
            "transverse_frequency_hz": pair.transverse_frequency,
            "frequency_ratio": pair.ratio,
            "tuned_pretension": Absent(reason=pair.reason)
            if pair.tuned_pretension is None
            else pair.tuned_pretension,
        }
        for pair in found.pairs
    ]
    data["remedies"] = [
        {"change": change.change, "value": change.value, "text": change.text} for change in changes
    ]
    return data


def alarm_data(judged: AlarmResult) -> dict[str, Any]:
    """The verdict on a motion as JSON gives it.

    Parameters
    ----------
    judged : AlarmResult

    Returns
    -------
    dict
        SI.
    """
    return {
        "verdict": judged.verdict,
        "remedy": judged.remedy,
        "floor": judged.floor,
        "limit": judged.limit,
        "largest_pulley": judged.largest_pulley,
        "slack": judged.slack,
        "modes": judged.modes,
    }


def alarm_text(judged: AlarmResult) -> str:
    """The verdict on a motion for people: the three modes that grow most.

    Parameters
    ----------
    judged : AlarmResult

    Returns
    -------
    str
    """
    from cabledrive.report.numbers import quantity

    lines = [f"the motion: {judged.verdict}", f"  {judged.remedy}"]
    if judged.slack:
        lines.append("  the torque alone takes a span's tension away on the way")
    for mode in judged.modes[:3]:
        where = f"{mode.span}, {mode.section[0]:.4g} to {mode.section[1]:.4g} m, m = {mode.number}"
        lines.append(
            f"  {where:<32} grows {np.exp(min(mode.gain, 700.0)):.3g} times from {mode.start:.3g} s to "
            f"{mode.end:.3g} s, reaches {quantity(mode.largest, 'm')}"
        )
    return "\n".join(lines)


def _number(found: ResonanceSummary, name: str) -> Any:
    value = getattr(found, name)
    if value is not None:
        return value
    return Absent(reason=found.missing.get(name, "the spans go slack before any torque does this"))


def _text(drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...]) -> str:
    from cabledrive.report.numbers import quantity

    lines = [
        drive.title or drive.name,
        "",
        f"verdict: {found.verdict}",
        *(f"  {reason}" for reason in found.reasons),
    ]
    named = (
        ("frequency ratio", found.frequency_ratio, "1"),
        ("detuning, ratio - 1/2", found.detuning, "1"),
        ("pulley mode", found.pulley_frequency, "Hz"),
        ("tuned pretension", found.tuned_pretension, "N"),
        ("threshold torque, tuned", found.threshold_torque, "N m"),
        ("threshold torque, as it is", found.threshold_here, "N m"),
        ("tenfold growth in 1 s, tuned", found.growth_torque, "N m"),
        ("Coulomb friction holds below", found.coulomb_onset, "N m"),
        ("torque of the verdict", found.torque, "N m"),
    )
    lines += ["", *(f"{label:<30}{_shown(value, unit, quantity)}" for label, value, unit in named)]
    if found.pairs:
        lines += ["", "pairs with the pulley mode:"]
        for pair in found.pairs:
            tuned = "-" if pair.tuned_pretension is None else quantity(pair.tuned_pretension, "N")
            where = f"{pair.span}, {pair.section[0]:.4g} to {pair.section[1]:.4g} m, m = {pair.number}"
            lines.append(f"  {where:<32} ratio {pair.ratio:.4f}   tuned at {tuned}")
    if found.split:
        tuned = ", ".join(f"{span} {_shown(value, 'N', quantity)}" for span, value in found.split.items())
        lines += ["", f"under the steady load each span is tuned at its own pretension: {tuned}"]
    if changes:
        lines += ["", "what would make it safe, each by itself:", *(f"  {change.text}" for change in changes)]
    return "\n".join(lines)


def _shown(value: float | None, unit: str, quantity: Any) -> str:
    return "-" if value is None else quantity(value, unit)
