"""Chapter "Transporter": a carriage with a hanging mass along its span, section 7.2.3."""

import numpy as np

from cabledrive.parameters import Drive, content_hash, load_drive
from cabledrive.report.blocks import Chapter, Column, Figure, Paragraph, RowGroup, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.carriage_moves import moves_picture, way_picture
from cabledrive.report.numbers import number
from cabledrive.rig.carriage.carriage_move import CarriageMove
from cabledrive.rig.carriage.transporter import LAWS, move_carriage
from cabledrive.studies.transporter_moves import along_the_way, residual_motion, scaled_transporter

PLACE = 750
EXAMPLE = "dissertation-transporter"
SHOWN = ("scheduled", "pd-flat", "pd", "shaper")
RUNS = 3
GUST = 0.2


def chapter(context: ReportContext) -> Chapter | None:
    """Moves of the scaled transporter, where it is among the drives."""
    if content_hash(load_drive(EXAMPLE)) not in context.hashes:
        return None
    drive = scaled_transporter(load_drive(EXAMPLE))
    return Chapter(
        title="Transporter",
        summary="A carriage moved along its span: positions, tensions and errors.",
        anchor="transporter",
        blocks=(
            Paragraph(
                text="The dissertation leaves open a transporter whose stiffness changes as the carriage "
                "travels, with a hanging payload in the wind. Here the "
                f"transporter of {EXAMPLE} is scaled to carry 0.5 kg with 0.25 kg on a line of 0.25 m "
                "over 1 m: span 1.5 m, pretension 10 N, damping of the cable over its stiffness 0.5 ms "
                "(an estimate), and the motor of configuration 3. Law and observer see the encoders of the "
                "two pulleys only; neither carriage nor load carries a sensor."
            ),
        ),
        sections=(_moves(drive), _way(drive)),
        methods=(
            "Transporter: strands whose length changes with the carriage, nonlinear pendulum, motor with "
            "stick-slip friction; fourth-order steps of 40 us, encoders with random phases.",
        ),
    )


def _moves(drive: Drive) -> Section:
    still, gusty = (
        [move_carriage(drive, law, move=CarriageMove(gust=(force, 1.0, 1.5))) for law in SHOWN]
        for force in (0.0, GUST)
    )
    picture = moves_picture("carriage-moves", still, gusty)
    words = ", ".join(f"{run.law} {number(1e3 * run.residual(), 2)} mm" for run in still)
    return Section(
        title="One metre in two and a half seconds",
        anchor="transporter-moves",
        blocks=(
            Figure(
                name="carriage-moves",
                alt="Distance of the payload from its rest position under four laws; largest in still air: "
                f"{words}.",
                caption="Distance of the payload from its target position. Dotted: end of the motion, "
                "the shaper's included. Below, a gust of 0.2 N on the mass.",
                wide=picture.wide,
                narrow=picture.narrow,
            ),
            _table(drive),
        ),
    )


def _table(drive: Drive) -> Table:
    rows = []
    for law in SHOWN:
        cells = []
        for drawn, gust in ((False, 0.0), (True, 0.0), (True, GUST)):
            found = residual_motion(drive, law, runs=RUNS, drawn=drawn, gust=gust)
            cells.append(number(1e3 * float(np.median(found.at_once)), 2))
            if gust > 0.0:
                cells.append(number(1e3 * float(np.median(found.later)), 2))
        rows.append((law, LAWS[law][1], *cells))
    return Table(
        caption="Residual motion of the payload after the arrival, median.",
        columns=(
            Column(title="Law"),
            Column(title="Feedforward"),
            Column(title="Designed", unit="mm", numeric=True),
            Column(title="Drawn", unit="mm", numeric=True),
            Column(title="Gust", unit="mm", numeric=True),
            Column(title="2 s later", unit="mm", numeric=True),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
        note="Feedback: of the first law scheduled over the position, else PD on the motor at 5 Hz. "
        f"{RUNS} runs each. Sampled: payload 10 %, line and cable 5 %, friction 6 %. In still air the "
        "feedforward suffices; a gust is damped by feedback only.",
    )


def _way(drive: Drive) -> Section:
    way = along_the_way(drive, positions=16)
    picture = way_picture("carriage-way", way)
    worst = {law: number(float(growth.max()), 2) for law, growth in way.growth.items()}
    return Section(
        title="Stability along the way",
        anchor="transporter-way",
        blocks=(
            Paragraph(
                text="The poles of law, observer and plant are computed at each position with the carriage "
                "frozen there. The law scheduled over the position is stable everywhere "
                f"(largest real part {worst['scheduled']} per second); a single design for the middle of "
                f"the way has growth rates up to {worst['frozen']} per second near the ends: in a run a "
                "strand goes slack."
            ),
            Figure(
                name="carriage-way",
                alt="Above, natural frequencies of payload and carriage over the position of the carriage; "
                "below, the "
                f"largest real part of a closed-loop pole: scheduled at most {worst['scheduled']} per "
                f"second, frozen up to {worst['frozen']} per second.",
                caption="Natural frequencies, and the largest real part of a closed-loop pole, over the "
                "position of the carriage.",
                wide=picture.wide,
                narrow=picture.narrow,
            ),
        ),
    )
