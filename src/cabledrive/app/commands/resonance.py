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
from cabledrive.studies.resonance import BUILD_UP, SAFE, ResonanceSummary, resonance_summary
from cabledrive.studies.resonance_remedies import Remedy, remedies, sensitivity

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
    "--map",
    "map_file",
    type=NewFileType(".html"),
    metavar="FILE",
    help="Draw growth over pretension and torque into FILE, an interactive page that needs nothing else.",
)
def command(drive: Drive, torque: float | None, map_file: NewFile | None) -> Answer:
    """Frequency ratio, tuned pretension, threshold torque and verdict for the internal resonance of DRIVE.

    The resonance is between the pulleys' own mode and transverse modes near half its frequency.
    """
    found = resonance_summary(drive, torque=torque)
    changes = () if found.verdict == SAFE else remedies(drive, found.torque)
    if map_file is not None:
        from cabledrive.report.resonance_map_page import resonance_map_page
        from cabledrive.studies.map_spot_checks import spot_check_line, spot_checks
        from cabledrive.studies.resonance_map import growth_map

        growth = growth_map(drive, torque=found.torque)
        checks = spot_checks(drive, growth, np.random.default_rng(SEED))
        map_file.write(resonance_map_page(growth, spot_check_line(checks)))
    return Answer(
        data=resonance_data(drive, found, changes),
        text=_text(drive, found, changes),
        provenance=provenance(drive, method=METHOD, tolerances={"build_up": BUILD_UP}),
    )


def resonance_data(drive: Drive, found: ResonanceSummary, changes: tuple[Remedy, ...]) -> dict[str, Any]:
    """The summary as JSON gives it.

    Parameters
    ----------
    drive : Drive
    found : ResonanceSummary
    changes : tuple of Remedy

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
        data["sensitivity"] = sensitivity(drive, found.torque)
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
    if changes:
        lines += ["", "what would make it safe, each by itself:", *(f"  {change.text}" for change in changes)]
    return "\n".join(lines)


def _shown(value: float | None, unit: str, quantity: Any) -> str:
    return "-" if value is None else quantity(value, unit)
