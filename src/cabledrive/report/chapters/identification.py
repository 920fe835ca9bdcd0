"""Chapter "Identification": the experiments of chapter 4 on the virtual rig, beside the print."""

from collections.abc import Sequence

from cabledrive.identification.estimates import Estimate
from cabledrive.parameters import content_hash, load_drive
from cabledrive.report.blocks import Block, Cell, Chapter, Column, Figure, Paragraph, RowGroup, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.identification import amplifier_picture, response_picture
from cabledrive.report.numbers import number
from cabledrive.report.picture import Picture
from cabledrive.report.time_plots import regressors_plot
from cabledrive.studies.chapter_4 import JOINT, RATE, SEED, Chapter4, Experiment, chapter_4

PLACE = 550
EXAMPLE = "dissertation-3"
SYMBOLS = {"inertia": "J", "viscous_friction": "b", "coulomb_friction": "c", "offset_torque": "d"}


def chapter(context: ReportContext) -> Chapter | None:
    """The experiments of chapter 4, where their rig is among the machines."""
    if content_hash(load_drive(EXAMPLE)) not in context.hashes:
        return None
    context.progress("identification: experiments of chapter 4")
    found = chapter_4()
    return Chapter(
        title="Identification",
        summary="Parameters from simulated logs of known truth: values, intervals, modelling errors.",
        anchor="identification",
        blocks=(
            Paragraph(
                text="The experiments of chapter 4, run on a virtual rig with the printed parameters, "
                "stick-slip friction, an encoder of 2,600 counts, a torque noise of 6 mN m and random "
                "encoder phases. The identified parameters are compared with those of the rig."
            ),
            _bench_table(found.experiments),
            _second_table(found),
        ),
        sections=(_bench(found.experiments), _responses(found)),
        methods=(
            "Identification: rig in set-valued friction, logged at 1 kHz and 5 kHz; output error with exact "
            f"sensitivities; responses by Hann windows of 1 s; seed {SEED}.",
        ),
    )


def _figure(name: str, picture: Picture, alt: str, caption: str) -> Figure:
    return Figure(name=name, alt=alt, caption=caption, wide=picture.wide, narrow=picture.narrow)


def _interval(estimate: Estimate, scale: float = 1e3) -> str:
    return f"{number(scale * estimate.low, 5)} to {number(scale * estimate.high, 5)}"


def _bench_table(experiments: Sequence[Experiment]) -> Table:
    groups = []
    for one in experiments:
        truth = (one.test.inertia, one.test.viscous, one.test.coulomb, one.test.offset)
        printed = one.printed_regressor.parameters.values()
        rows: list[tuple[Cell, ...]] = [
            (
                SYMBOLS[name],
                number(1e3 * value, 4),
                _interval(estimate),
                "yes" if estimate.low <= value <= estimate.high else "no",
                number(1e3 * smooth.value, 4),
            )
            for (name, estimate), value, smooth in zip(
                one.found.parameters.items(), truth, printed, strict=True
            )
        ]
        groups.append(RowGroup(title=one.title, rows=tuple(rows)))
    return Table(
        caption="Parameters of the rig (Table 4.1, in thousandths of SI units), and those identified from "
        "the log.",
        columns=(
            Column(title="Parameter"),
            Column(title="Rig", numeric=True),
            Column(title="Identified, 95 %", numeric=True),
            Column(title="Covered"),
            Column(title="With tanh(0.5 w)", numeric=True),
        ),
        groups=tuple(groups),
        note="One in twenty intervals may miss the true value. The last column uses the regressor of the "
        "print on the same log: such wide smoothing cannot separate viscous from Coulomb friction, "
        "least of all at low speed.",
    )


def _second_table(found: Chapter4) -> Table:
    printed = {"J1": 1.742, "J11": 1.1, "J12": 0.642, "J2": 2.35}
    rows: list[tuple[Cell, ...]] = [
        (name, number(value), _interval(found.inertias[name]), "g m²") for name, value in printed.items()
    ]
    fit = found.coupled.fit
    for words, name, value, unit in (
        ("k_m", "joint_stiffness", JOINT[0], "N m/rad"),
        ("b_m", "joint_damping", JOINT[1], "N m s/rad"),
    ):
        low, high = fit.bounds(name, 0.95)
        rows.append((words, number(value), f"{number(low, 4)} to {number(high, 4)}", unit))
    gain, bandwidth = found.amplifier.gain, found.amplifier.bandwidth
    rows.append(("amplifier gain", "1.6218", _interval(gain, 1.0), "N m/V"))
    rows.append(("its bandwidth", "none (rig: 1000)", _interval(bandwidth, 1.0), "Hz"))
    return Table(
        caption="Differences of the rigs (Table 4.2), the coupling (4.19), the amplifier (4.20).",
        columns=(
            Column(title="Parameter"),
            Column(title="Printed", numeric=True),
            Column(title="Identified, 95 %", numeric=True),
            Column(title="Unit"),
        ),
        groups=(RowGroup(rows=tuple(rows)),),
    )


def _bench(experiments: Sequence[Experiment]) -> Section:
    blocks: list[Block] = []
    for k, one in enumerate(experiments, start=1):
        name = f"identification-{k}"
        blocks.append(
            regressors_plot(
                name,
                one.curves,
                alt="Acceleration, speed and friction regressor over time, filtered and unfiltered; below, "
                "the torque and the much smaller modelling error.",
                caption=f"As Figs. {one.figures}: {one.title}. Filtered: causal, 20 Hz, which lags. "
                f"Modelling error {number(100 * one.curves.error_share, 3)} % of the torque with "
                f"tanh(0.5 w), {number(100 * one.error_share, 3)} % with the sign of the speed; "
                "most of it is encoder quantisation in the acceleration.",
            )
        )
    return Section(title="Bench tests", anchor="identification-bench", blocks=tuple(blocks))


def _responses(found: Chapter4) -> Section:
    coupled = found.coupled.fit
    blocks = (
        _figure(
            "identification-motor",
            response_picture("identification-motor", found.motor),
            "Magnitude and phase from torque to motor speed: an integrator.",
            "As Fig. 4.17: motor alone, friction and offset taken off the torque. Dashed: 1/(Js + b) of the "
            "rig. Deviations: below 10 Hz by reversals of the friction, above 200 Hz by encoder "
            "quantisation.",
        ),
        _figure(
            "identification-coupled",
            response_picture("identification-coupled", found.coupled),
            "Magnitude and phase with a shallow dip and a peak at the resonance of the coupling.",
            f"As Fig. 4.19: with the drive pulley on its coupling, (4.19) dashed. Fitted by weighted least "
            f"squares: k_m = {number(coupled['joint_stiffness'], 4)} N m/rad, b_m = "
            f"{number(coupled['joint_damping'], 3)} N m s/rad.",
        ),
        _figure(
            "identification-amplifier",
            amplifier_picture(
                "identification-amplifier", found.amplifier_response, found.amplifier, 1.0 / RATE
            ),
            "Magnitude and phase from command to torque: constant, then a slow fall.",
            f"As Fig. 4.21: {number(found.amplifier.decibels, 3)} dB. The fall towards 300 Hz is due to "
            "the current loop and the zero-order hold of the command.",
        ),
    )
    return Section(title="Responses", anchor="identification-responses", blocks=blocks)
