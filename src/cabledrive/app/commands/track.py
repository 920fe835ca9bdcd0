"""`cabledrive track`: a control law follows pulses on the virtual rig."""

from typing import Any

import click

from cabledrive.app.combinations import refuse_given, tell_given
from cabledrive.app.completion import complete_controller, control_laws
from cabledrive.app.new_file import NewFile, NewFileType
from cabledrive.app.options import (
    FREQUENCY,
    Quantity,
    Subcommand,
    answering,
    axis_argument,
    saves_answer,
)
from cabledrive.app.pulse_options import pulse_options
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import Drive, load_drive

METHOD = "hybrid simulation: exact between samples, stick-slip events on the exact motion"


@click.command(
    cls=Subcommand,
    example="cabledrive track dissertation-3 --controller darc-4 --seed 7",
    short_help="Follow pulses with a control law on the virtual rig.",
    names=lambda: {"Control laws": (*control_laws(), "best")},
)
@answering
@saves_answer
@axis_argument
@click.option(
    "--controller",
    metavar="NAME|FILE",
    shell_complete=complete_controller,
    help="Control law, best (first in compare), or a study's controller.json; default: by the joint.",
)
@click.option("--bandwidth", type=FREQUENCY, metavar="HZ", help="lambda/(2 pi) instead of that of --gains.")
@click.option(
    "--gains",
    type=click.Choice(["best", "dissertation", "printed"]),
    default="best",
    show_default=True,
    metavar="best|dissertation",
    help="best: the bandwidth that trial runs accept on this drive; printed is another name of the second.",
)
@click.option(
    "--feedforward",
    type=click.Choice(["damped", "undamped", "rigid"]),
    default="damped",
    show_default=True,
    help="Inverse that pd, pid, lqg, lqi, hinf, dob and shaper follow.",
)
@click.option("--plant", metavar="NAME", help="model-1 to model-4, cable; by default the highest model.")
@pulse_options
@click.option("--pulses", type=int, default=1, show_default=True, metavar="N")
@click.option(
    "--order", type=int, metavar="N", help="Odd order of the rise; default: what the law needs, 9 or 11."
)
@click.option("--seed", type=int, default=0, show_default=True, metavar="N", help="Of the encoder phases.")
@click.option("--observer", type=click.Choice(["kalman", "difference"]), default="kalman", show_default=True)
@click.option(
    "--feedback",
    type=click.Choice(["motor", "drive"]),
    default="motor",
    show_default=True,
    help="Encoder that stands for theta_1.",
)
@click.option(
    "--encoder-phase", type=click.Choice(["random", "centred"]), default="random", show_default=True
)
@click.option("--ideal-sensors", is_flag=True, help="The law receives true angles and speeds.")
@click.option("--smooth-friction", is_flag=True, help="c tanh(50 w) in the plant instead of stick-slip.")
@click.option("--no-adaptation", is_flag=True, help="Estimates keep their initial values.")
@click.option("--tension-only", is_flag=True, help="Continue where a span goes slack (tension zero).")
@click.option(
    "--as-printed",
    is_flag=True,
    help="The cable as plant keeps its own EA and damping, not those of [lumped].",
)
@click.option(
    "--segments", type=int, default=8, show_default=True, metavar="N", help="Per span of the cable as plant."
)
@click.option(
    "--jitter", type=Quantity("s"), default=0.0, metavar="S", help="Standard deviation of the sample times."
)
@click.option(
    "--disturbance",
    "disturbances",
    multiple=True,
    metavar="SHAFT:NM:START:END",
    help="Torque on motor or load, as load:0.05:0.3:0.6; without an end it stays.",
)
@click.option("--blind", metavar="SHAFT:START:END", help="Encoder dropout, as load:0.1:0.2.")
@click.option(
    "--check-conditions", is_flag=True, help="Check the conditions on the robust term along the run."
)
@click.option(
    "--plant-set", "plant_settings", multiple=True, metavar="KEY=VALUE", help="As --set, of the plant only."
)
@click.option(
    "--repeat",
    type=int,
    default=0,
    metavar="N",
    help="Repeat the motion up to N times and learn the torque along it between repetitions.",
)
@click.option("--draws", type=int, default=0, metavar="N", help="Number of plants sampled from the bounds.")
@click.option(
    "--log",
    "log_file",
    type=NewFileType(".csv"),
    metavar="FILE",
    help="Write the encoder readings to FILE.csv.",
)
@click.option(
    "--animate",
    type=NewFileType(".html"),
    metavar="FILE.html",
    help="Animate the run: pulleys as they turn, spans coloured by tension.",
)
def command(
    drive: Drive,
    log_file: NewFile | None,
    animate: NewFile | None,
    plant_settings: tuple[str, ...],
    **spec: Any,
) -> Answer:
    """Let a control law follow pulses of the load pulley of DRIVE, on a rig with encoders and friction."""
    from cabledrive.app.run_limits import check_run
    from cabledrive.reduction.network_axis import as_axis
    from cabledrive.rig import Motion, RigOptions, track
    from cabledrive.rig.log_file import log_text
    from cabledrive.rig.parsed_options import parse_disturbance, parse_encoder_dropout

    _check_combination(spec)
    given = click.get_current_context().params
    actual = None
    if plant_settings:
        settings = (*given["settings"], *plant_settings)
        actual = as_axis(load_drive(given["drive"], overrides=settings), given["axis"])
    motion = Motion(**{name: spec[name] for name in ("angle", "rise", "dwell", "pulses", "order")})
    options = RigOptions(
        observer=spec["observer"],
        feedback=spec["feedback"],
        encoder_phase=spec["encoder_phase"],
        ideal_sensors=spec["ideal_sensors"],
        smooth_friction=spec["smooth_friction"],
        forbid_slack=not spec["tension_only"],
        as_printed=spec["as_printed"],
        segments=spec["segments"],
        check_conditions=spec["check_conditions"],
        jitter=spec["jitter"],
        disturbances=tuple(parse_disturbance(words) for words in spec["disturbances"]),
        blind=parse_encoder_dropout(spec["blind"]),
    )
    check_run(actual or drive, motion, options, draws=spec["draws"], cable=spec["plant"] == "cable")
    found = track(
        drive,
        controller=spec["controller"],
        bandwidth=spec["bandwidth"],
        gains=spec["gains"],
        feedforward=spec["feedforward"],
        plant=spec["plant"],
        motion=motion,
        options=options,
        plant_drive=actual,
        seed=spec["seed"],
        adapt=not spec["no_adaptation"],
        draws=spec["draws"],
        repeat=spec["repeat"],
    )
    if log_file is not None:
        log_file.write(log_text(found, actual or drive))
    if animate is not None:
        from cabledrive.report.controlled_film import controlled_film

        animate.write(controlled_film(actual or drive, found))
    said = found.summary
    return Answer(
        data=said,
        text=_text(drive, said),
        provenance=provenance(drive, method=METHOD, step=said["internal_step"], seed=spec["seed"]),
        incomplete=found.incomplete,
    )


def _check_combination(spec: dict[str, Any]) -> None:
    """Refuse or report what would have no effect."""
    from cabledrive.rig.laws.baselines import BASELINES

    if spec["plant"] != "cable":
        refuse_given("segments", why="divides the cable as plant: add --plant cable, or leave it out")
        tell_given("as_printed", why="has no effect: it is about --plant cable")
    if spec["ideal_sensors"]:
        tell_given("observer", "encoder_phase", why="has no effect beside --ideal-sensors")
    if spec["controller"] in BASELINES:
        refuse_given("no_adaptation", why=f"has no effect: {spec['controller']} adapts nothing: leave it out")


def _text(drive: Drive, said: dict[str, Any]) -> str:
    lines = [
        f"{drive.title or drive.name}: {said['controller']} on {said['plant']}, {said['observer']}",
        "",
        f"  peak error      {said['peak_error_deg']:9.4f} deg",
        f"   by its encoder {said['encoder_error_deg']:9.4f} deg",
        f"  rms error       {said['rms_error_deg']:9.4f} deg",
        f"  peak torque     {said['peak_torque']:9.4f} N m",
        f"  at its limit    {100 * said['saturated_fraction']:9.1f} % of the samples",
    ]
    if "axis" in said:
        lines += axis_lines(said["axis"])
    if said["theory_bound_deg"] is not None:
        lines.append(f"  bound           {said['theory_bound_deg']:9.4f} deg")
    if said["broken_assumptions"]:
        lines.append("  the theorem's assumptions do not hold: " + "; ".join(said["broken_assumptions"]))
    if said["interpreted"]:
        lines.append(f"  interpreted, slower: {said['interpreted']}")
    lines += _disturbances(said)
    if "motor_reason" in said:
        lines.append(f"  {said['motor_reason']}")
    if "over_draws" in said:
        over = said["over_draws"]
        lines.append(
            f"  over {over['draws']} draws   median {over['median_peak_error_deg']:.4f}, "
            f"worst {over['worst_peak_error_deg']:.4f} deg"
        )
        if over["expected_bound_deg"] is not None:
            lines.append(f"  bound for all uncertainties together {over['expected_bound_deg']:.4f} deg")
    if "repeated" in said:
        lines += _repeated(said["repeated"])
    lines += [f"  {reason}" for reason in said["gains"].get("reasons", ())]
    return "\n".join(lines)


def _repeated(said: dict[str, Any]) -> list[str]:
    lines = [
        f"  repetition {number:3d}  {one['encoder_rms_deg']:9.4f} deg rms by its encoder, "
        f"largest {one['peak_error_deg']:.4f} deg"
        for number, one in enumerate(said["repetitions"], start=1)
    ]
    return [
        *lines,
        f"  repetition {said['best']} is shown above; stopped: {said['stopped']}",
        f"  converges by {said['contraction']:.3f} a repetition or faster in {said['directions']} "
        f"directions, as long as {'; '.join(said['assumed'])}",
    ]


def axis_lines(axis: dict[str, Any]) -> list[str]:
    """The lumped chain of a machine with routes."""
    shown = " and ".join(f"{'-' if share < 0 else ''}{name}" for name, share in axis["motors"].items())
    gain = f"{1e3 * axis['gain']:.4g} mm/rad" if axis["slides"] else f"{axis['gain']:.4g} rad/rad"
    lines = [
        f"  axis            {axis['load']} driven by {shown}, {gain}",
        f"   modes left out {100 * axis['neglected']:9.2g} %   strings "
        f"{100 * axis['neglected_strings']:.2g} %   off the end {100 * axis['off_the_end']:.2g} %",
    ]
    if "peak_error_mm" in axis:
        lines.append(f"   peak error     {axis['peak_error_mm']:9.4f} mm")
    return lines


def _disturbances(said: dict[str, Any]) -> list[str]:
    lines = []
    if said["closed_loop_poles"]:
        poles = ", ".join(
            f"{pole['frequency_hz']:.1f} Hz ({pole['damping_ratio']:.2f})"
            for pole in said["closed_loop_poles"]
        )
        lines.append(f"  poles on the plant, true states: {poles}")
    if said.get("learnt"):
        lines.append(_learnt(said["learnt"]))
    if said["slack_samples"]:
        lines.append(f"  a span was slack at {said['slack_samples']} samples; {said['slack_rule']}")
    if said["invalid_samples"]:
        lines.append(f"  the last command was held at {said['invalid_samples']} samples without a reading")
    if "cable" in said:
        cable = said["cable"]
        lines.append(
            f"  spillover       {cable['spillover_deg']:9.2e} deg   1:2 coupling: {cable['one_to_two']} "
            f"(ratio {cable['frequency_ratio']:.1f})"
        )
    return lines


def _learnt(said: dict[str, Any]) -> str:
    if not said["used"]:
        return f"  nothing learnt: {said['used_reason']}"
    words = (
        f"  learnt          beta {said['beta']:.1f} 1/s^2 ({said['beta_low']:.1f} to {said['beta_high']:.1f})"
    )
    if not said["motor_used"]:
        return words + ", inertia and friction kept"
    return words + f", inertia {said['inertia']['value']:.4g} kg m^2"
