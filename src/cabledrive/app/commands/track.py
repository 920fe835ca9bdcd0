"""`cabledrive track`: a control law follows pulses on the virtual rig."""

from functools import partial
from typing import Any

import click

from cabledrive.answers.runs import TRACKED
from cabledrive.app.combinations import refuse_given, tell_given
from cabledrive.app.options import (
    axis_argument,
    complete_controller,
    listed_laws,
    option,
    pulse_options,
    saves_answer,
    subcommand,
)
from cabledrive.app.results import Answer, NewFile, log_text
from cabledrive.app.tracked import answer_of_run, parse_payload, parse_payload_range, two_motor_answer
from cabledrive.parameters import load_drive

OF_THE_RIG = (
    *("observer", "feedback", "encoder_phase", "ideal_sensors", "smooth_friction", "as_printed"),
    *("segments", "check_conditions", "jitter", "pair", "preload"),
)
OF_THE_RUN = ("controller", "bandwidth", "gains", "feedforward", "plant", "seed", "draws", "repeat")
METHOD = "inertias and links in steps of second order between samples, friction set-valued"


@subcommand(
    "cabledrive track dissertation-3 --controller darc-4 --seed 7",
    (saves_answer, partial(axis_argument, winches=True)),
    names=lambda: {"Control laws": listed_laws()},
)
@option(
    "--controller",
    "NAME|FILE",
    "Control law, best (first in compare), or a study's controller.json; default: by the joint.",
    shell_complete=complete_controller,
)
@option("--bandwidth", "Hz", "lambda/(2 pi) instead of that of --gains.")
@option(
    "--gains",
    "best|dissertation|printed",
    "best: the tuning that compare lists for this drive; printed is another name of the second.",
    "best",
    metavar="best|dissertation",
)
@option(
    "--feedforward",
    "damped|undamped|rigid",
    "Inverse that pd, pid, lqg, lqi, hinf, dob and shaper follow.",
    "damped",
)
@option("--plant", "NAME", "model-1 to model-4, cable; by default the highest model.")
@pulse_options
@option("--pulses", "count", "", 1)
@option("--order", "count", "Odd order of the rise; default: what the law needs, 9 or 11.")
@option("--seed", "count", "Of the encoder phases.", 0)
@option("--observer", "kalman|difference", "", "kalman")
@option("--feedback", "motor|drive", "Encoder that stands for theta_1.", "motor")
@option("--encoder-phase", "random|centred", "", "random")
@option("--ideal-sensors", "flag", "The law receives true angles and speeds.")
@option("--smooth-friction", "flag", "c tanh(50 w) in the plant instead of stick-slip.")
@option("--no-adaptation", "flag", "Estimates keep their initial values.")
@option("--tension-only", "flag", "Continue where a span goes slack (tension zero).")
@option("--as-printed", "flag", "The cable as plant keeps its own EA and damping, not those of [lumped].")
@option("--segments", "count", "Per span of the cable as plant.", 8)
@option("--jitter", "s", "Standard deviation of the sample times.", 0.0)
@option(
    "--disturbance disturbances",
    "SHAFT:NM:START:END",
    "Torque on motor or load, as load:0.05:0.3:0.6; without an end it stays. Winches: camera.x:30:1:2.",
    multiple=True,
)
@option("--blind", "SHAFT:START:END", "Encoder dropout, as load:0.1:0.2.")
@option("--check-conditions", "flag", "Check the conditions on the robust term along the run.")
@option("--plant-set plant_settings", "KEY=VALUE", "As --set, of the plant only.", multiple=True)
@option(
    "--repeat",
    "count",
    "Repeat the motion up to N times and learn the torque along it between repetitions.",
    0,
)
@option("--pair", "flag", "A second motor like the first, preloaded against its backlash.")
@option("--preload", "N m", "Of --pair; default: a quarter of the torque limit.", metavar="N m")
@option(
    "--payload payloads",
    "FACTOR:START",
    "Load announced to lqi-scheduled (gain scheduling), as 3:0.7s; repeatable.",
    multiple=True,
)
@option(
    "--payload-range",
    "LOW:HIGH",
    "Loads that lqi-scheduled is designed for; default: 0.5:3 times the drive's.",
)
@option("--load-change", "FACTOR:START", "The plant's load from a time on, as 3:0.7s.")
@option("--draws", "count", "Number of plants sampled from the bounds.", 0)
@option(
    "--move moves", "NAME=M", "Winches: how far the body goes, as camera.x=2m; repeatable.", multiple=True
)
@option(
    "--least-tension", "N", "Winches: no line falls below; default: a fifth of the smaller tension at rest."
)
@option("--gust", "N", "Force on the body for which the tension is promised; default: a tenth of its weight.")
@option("--log log_file", ".csv", "Write the encoder readings to FILE.csv.")
@option(
    "--animate",
    ".html",
    "Animate the run: motors and load as they move, ropes coloured by tension.",
    metavar="FILE.html",
)
def command(
    drive: Any,
    log_file: NewFile | None,
    animate: NewFile | None,
    plant_settings: tuple[str, ...],
    **spec: Any,
) -> Answer:
    """Let a control law follow pulses of the load pulley of DRIVE, on a rig with encoders and friction."""
    from cabledrive.reduction.network_axis import as_axis
    from cabledrive.reduction.two_motors import is_winched
    from cabledrive.rig import Motion, RigOptions, track
    from cabledrive.rig.setting import parse_disturbance, parse_encoder_dropout

    if is_winched(drive):
        return two_motor_answer(drive, plant_settings, spec)
    refuse_given(
        "moves", "least_tension", "gust", why="is for a body between two winches: this drive has none"
    )
    if spec["plant"] != "cable":
        refuse_given("segments", why="divides the cable as plant: add --plant cable, or leave it out")
        tell_given("as_printed", why="has no effect: it is about --plant cable")
    elif drive.chain_of:
        tell_given("as_printed", why="has no effect: a machine with routes has no [lumped]")
    if spec["ideal_sensors"]:
        tell_given("observer", "encoder_phase", why="has no effect beside --ideal-sensors")
    given = click.get_current_context().params
    actual = None
    if plant_settings:
        settings = (*given["settings"], *plant_settings)
        actual = as_axis(load_drive(given["drive"], overrides=settings), given["axis"])
    motion = Motion(
        **{name: spec[name] for name in ("angle", "rise", "dwell", "pulses", "order")},
        payload=tuple(map(parse_payload, spec["payloads"])),
        payload_range=parse_payload_range(spec["payload_range"]),
    )
    change = None if spec["load_change"] is None else parse_payload(spec["load_change"])
    options = RigOptions(
        **{name: spec[name] for name in OF_THE_RIG},
        forbid_slack=not spec["tension_only"],
        load_change=None if change is None else (change.start, change.factor),
        disturbances=tuple(parse_disturbance(words) for words in spec["disturbances"]),
        blind=parse_encoder_dropout(spec["blind"]),
    )
    found = track(
        drive,
        **{name: spec[name] for name in OF_THE_RUN},
        motion=motion,
        options=options,
        plant_drive=actual,
        adapt=not spec["no_adaptation"],
    )
    if log_file is not None:
        log_file.write(log_text(found, actual or drive))
    if animate is not None:
        from cabledrive.report.animation import controlled_film

        animate.write(controlled_film(actual or drive, found))
    return answer_of_run(drive, found, TRACKED, METHOD, spec["seed"])
