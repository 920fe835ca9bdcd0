"""Chapter "Internal resonance": chapter 5 beside what is computed, and where every machine stands."""

import numpy as np

from cabledrive.parameters import Drive, content_hash, load_drive
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Paragraph, RowGroup, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.resonance import (
    contours_picture,
    forced_picture,
    free_picture,
    map_picture,
    steady_picture,
    surfaces_picture,
    swept_picture,
)
from cabledrive.report.machine.internal_resonance import kept_resonance
from cabledrive.report.numbers import number, quantity
from cabledrive.report.picture import Picture
from cabledrive.studies.alarm import alarm
from cabledrive.studies.chapter_5 import (
    FLOOR,
    FREE_PLUCKS,
    GAMMA,
    LEVEL,
    PLUCKS,
    PULLEY_DAMPING,
    SWEEP_RATE,
    TORQUE,
    forced_response,
    free_response,
    swept_response,
    tuned_drive,
)
from cabledrive.studies.example_motions import example_motions
from cabledrive.studies.map_spot_checks import spot_check_line, spot_checks
from cabledrive.studies.resonance import ResonanceSummary
from cabledrive.studies.resonance_map import growth_map
from cabledrive.studies.steady_motion import steady_branches

PLACE = 500
EXAMPLE = "dissertation-2"
SEED = 0
STEADY_SHIFT = 0.99
"""Frequency of the torque of the steady branches over the pulley mode's."""


def chapter(context: ReportContext) -> Chapter | None:
    """Where every machine stands, and the figures of chapter 5 where its rig is among the machines."""
    if not context.drives:
        return None
    context.progress("internal resonance")
    digest = content_hash(load_drive(EXAMPLE))
    rig = context.drives[context.hashes.index(digest)] if digest in context.hashes else None
    found = [(drive, kept_resonance(drive)) for drive in context.drives]
    return Chapter(
        title="Internal resonance",
        summary="Which machines lie near the 1:2 resonance of pulley and cable, and the threshold torque.",
        anchor="internal-resonance",
        blocks=(
            Paragraph(
                text="Where the pulley mode has twice the frequency of a transverse mode, a torque at the "
                "pulleys excites the transverse mode parametrically, and the two exchange energy. The "
                "verdict is for a torque at the pulley mode's frequency: the torque limit of the "
                "motor, else one hundredth of the slack torque."
            ),
            _instabilities(found),
        ),
        sections=() if rig is None else (_parameters(rig), *_responses(rig), _steady(rig), _motions(rig)),
        methods=(
            "Internal resonance: coupling by exact integrals over certified modes, averaged equations to "
            "second order, maps by integration of the oscillators, responses by the full nonlinear model.",
        ),
        headline=_headline(found),
    )


def _headline(found: list[tuple[Drive, ResonanceSummary]]) -> str:
    verdicts = [summary.verdict for _, summary in found]
    if len(verdicts) == 1:
        return f"{verdicts[0]} at the torque named there."
    counted = ((verdict, verdicts.count(verdict)) for verdict in ("resonant", "close", "safe"))
    said = ", ".join(f"{n} {verdict}" for verdict, n in counted if n)
    return f"of {len(found)} machines {said}, each at the torque named there."


def _instabilities(found: list[tuple[Drive, ResonanceSummary]]) -> Table:
    return Table(
        caption="Detuning of each machine from its internal resonance.",
        columns=(
            Column(title="Machine"),
            Column(title="Verdict"),
            Column(title="Ratio", numeric=True),
            Column(title="Tuned at", unit="N", numeric=True),
            Column(title="Threshold, tuned", unit="N m", numeric=True),
            Column(title="Torque", unit="N m", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(_instability(drive, summary) for drive, summary in found)),),
        note="Ratio: lowest transverse mode of an empty span over the pulley mode; 1/2 is the resonance. "
        "The threshold is zero where the drive file gives the pulley mode or the cable no damping.",
    )


def _instability(drive: Drive, found: ResonanceSummary) -> tuple[Cell, ...]:
    shown = (found.frequency_ratio, found.tuned_pretension, found.threshold_torque)
    numbers = ["none" if value is None else number(value) for value in shown]
    return (drive.name, found.verdict, *numbers, number(found.torque))


def _figure(name: str, picture: Picture, alt: str, caption: str) -> Figure:
    return Figure(name=name, alt=alt, caption=caption, wide=picture.wide, narrow=picture.narrow)


def _parameters(rig: Drive) -> Section:
    damped = tuned_drive(rig)
    growth = growth_map(damped, torque=TORQUE)
    validation = spot_check_line(spot_checks(damped, growth, np.random.default_rng(SEED)))
    blocks: tuple[Block, ...] = (
        _figure(
            "resonance-surfaces",
            surfaces_picture("resonance-surfaces", rig),
            "Frequency ratio over the mass of the load pulley: it rises with the mass and with the tension.",
            "As Fig. 5.2: frequency ratio over the mass ratios, cable of configuration 2. Full: light "
            "drive pulley, chi1 = 1; dashed: heavy, chi1 = 1000. The line is the resonance, one half.",
        ),
        _figure(
            "resonance-contours",
            contours_picture("resonance-contours", rig),
            "Contours of pulley masses in resonance, one for each tension, each with an asymptote at the "
            "left.",
            "As Fig. 5.3: pulleys in resonance, a contour for each tension, the cable's mass conserved. "
            "The ring is configuration 2: it lies on the contour of its tuned pretension, 3.2838 N.",
        ),
        _figure(
            "resonance-map",
            map_picture("resonance-map", growth),
            "Contours of growth over pretension and torque: an instability region that opens upwards at "
            "the tuned pretension.",
            f"Growth of a small pluck in {number(growth.duration)} s: contours of 1.5, 3 and 10 times. "
            "Dashed: threshold. Ring: the forced response below. "
            f"Dampings of {number(GAMMA)} 1/s across and {number(PULLEY_DAMPING)} 1/s of the pulley mode "
            f"are estimates. {validation}",
        ),
    )
    return Section(title="When", anchor="resonance-when", blocks=blocks)


def _responses(rig: Drive) -> tuple[Section, ...]:
    drive = tuned_drive(rig)
    forced, swept, free = forced_response(drive), swept_response(drive), free_response(drive)
    claims = (
        (
            "Fig. 5.4",
            "strong coupling of load pulley and cable, energy exchanged",
            f"the load angle grows, then falls to {number(100 * forced.fallen, 2)} % of its peak as the "
            "cable "
            "takes over",
        ),
        (
            "Fig. 5.5",
            "sudden increase as gamma approaches one half",
            f"from {number(1e6 * FLOOR)} um to {number(1e3 * LEVEL)} mm at gamma = "
            f"{number(swept.found, 4)}: steep growth, no jump",
        ),
        ("Fig. 5.6", "growth of both amplitudes, a kind of beats", "as Fig. 5.4"),
        (
            "Fig. 5.7",
            "pulley amplitude largest when the upper span is smallest, decayed after 1 s",
            f"spans exchange energy through the pulleys, undamped period {quantity(free.period, 's')}",
        ),
    )
    table = Table(
        caption="Statements of chapter 5 and results computed here.",
        columns=(Column(title="Figure"), Column(title="Claim"), Column(title="Found")),
        groups=(RowGroup(rows=claims),),
    )
    plucks = " and ".join(number(1e3 * pluck) for pluck in PLUCKS)
    free_plucks = " and ".join(number(1e3 * pluck) for pluck in FREE_PLUCKS)
    forced_figure = _figure(
        "resonance-forced",
        forced_picture("resonance-forced", forced),
        "Load angle and midpoint over time: both grow and exchange energy.",
        f"As Figs. 5.4 and 5.6: torque of {quantity(TORQUE, 'N m')} at the pulley mode's frequency, "
        f"triangular plucks of {plucks} mm, full nonlinear model. The averaged equations differ by "
        f"{number(100 * forced.errors[0], 2)} % in the load angle and {number(100 * forced.errors[1], 2)} "
        "% at midspan.",
    )
    swept_figure = _figure(
        "resonance-swept",
        swept_picture("resonance-swept", swept),
        "Amplitude over the frequency ratio: steep growth inside the instability region.",
        "As Fig. 5.5: tension rising so that the detuning changes by "
        f"{number(SWEEP_RATE / (2 * np.pi), 2)} Hz per second, from a floor of {number(1e6 * FLOOR)} um at "
        "the edge of the instability region; Hill's equation of the transverse mode, without back-action "
        "on the pulleys.",
    )
    free_figure = _figure(
        "resonance-free",
        free_picture("resonance-free", free),
        "Load angle, upper midpoint and shares of energy: the spans exchange energy through the pulleys.",
        f"As Fig. 5.7: triangular plucks of {free_plucks} mm, no torque, full nonlinear model. Closed form "
        "without "
        f"damping: period {quantity(free.period, 's')}, largest load angle "
        f"{number(free.stroke * 57.29578, 3)} deg.",
    )
    return (
        Section(
            title="Amplitude",
            anchor="resonance-how-far",
            blocks=(table, forced_figure, swept_figure, free_figure),
        ),
    )


def _steady(rig: Drive) -> Section:
    drive = tuned_drive(rig)
    forcing = STEADY_SHIFT * autoparametric_model(drive).natural
    branches = steady_branches(drive, 2 * TORQUE, np.random.default_rng(SEED), forcing=forcing)
    single = branches[0]
    said = (
        f"They branch from the state of rest at {quantity(single.onset, 'N m')}, the threshold"
        if single.onset
        else "They rise"
    )
    if single.folds:
        said += f", with a fold at {quantity(single.folds[0], 'N m')}: below it a large motion decays"
    figure = _figure(
        "resonance-steady",
        steady_picture("resonance-steady", branches),
        "Steady amplitude over the torque: one branch for one span alone, one for both.",
        f"Steady motions at {number(100 * STEADY_SHIFT, 3)} % of the pulley mode's frequency, continued. "
        f"Full: stable; dashed: not. {said}. A steady load of 0.1 mN m is enough to separate the spans.",
    )
    return Section(title="Steady motion", anchor="resonance-steady-states", blocks=(figure,))


def _motions(rig: Drive) -> Section:
    drive = tuned_drive(rig)
    rows = []
    for words, motion in example_motions(drive).items():
        found = alarm(drive, motion)
        worst = found.modes[0]
        rows.append(
            (
                words,
                found.verdict,
                f"{worst.number}, {worst.span}",
                worst.excitation,
                number(worst.time, 2),
                number(1e3 * found.largest_transverse, 3),
            )
        )
    table = Table(
        caption="Assessment of four motions of configuration 2 at its tuned pretension.",
        columns=(
            Column(title="Motion"),
            Column(title="Verdict"),
            Column(title="Largest mode"),
            Column(title="Excitation"),
            Column(title="Largest at", unit="s", numeric=True),
            Column(title="Largest transverse displacement", unit="mm", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
        note="Every transverse mode has a floor of 0.01 mm, the limit is 0.5 mm. Direct excitation goes "
        'through the sag; parametric excitation is of one mode (1:2) or of two. "unknown": a small change of '
        "the frequencies and the torque would exceed the limit, or the model is not valid.",
    )
    return Section(title="Planned motions", anchor="resonance-motions", blocks=(table,))
