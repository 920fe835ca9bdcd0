"""What `cabledrive track` prints for people, and a body between two motors: its options, its run."""

from math import pi
from typing import TYPE_CHECKING, Any

import click

from cabledrive.answers.figures import aligned, stated
from cabledrive.answers.keys import Keys
from cabledrive.answers.runs import WOUND
from cabledrive.app.combinations import refuse_given
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import InputRefused, Machine, load_drive
from cabledrive.parameters.units import to_si

if TYPE_CHECKING:
    from cabledrive.rig import Tracking
    from cabledrive.rig.setting import Payload

METHOD = "exact geometry of two lines that only pull, symplectic steps, set-valued friction"
OF_TRACK = ("controller", "least_tension", "gust", "bandwidth", "seed", "draws")
NOT_HERE = (
    *("gains", "feedforward", "plant", "angle", "observer", "feedback", "encoder_phase", "ideal_sensors"),
    *("smooth_friction", "no_adaptation", "tension_only", "as_printed", "segments", "jitter", "blind"),
    *("check_conditions", "repeat", "log_file", "animate", "pair", "preload"),
    *("payloads", "payload_range", "load_change"),
)


def two_motor_answer(drive: Machine, plant_settings: tuple[str, ...], spec: dict[str, Any]) -> Answer:
    """Run the law of two motors on two winches, with those options of `track` that have an effect here."""
    from cabledrive.rig import BodyMotion, RigOptions, track
    from cabledrive.rig.setting import parse_disturbance

    refuse_given(*NOT_HERE, why="is for pulses of a load pulley: two winches move a body, see --move")
    given = click.get_current_context().params
    actual: Any = None
    if plant_settings:
        actual = load_drive(given["drive"], overrides=(*given["settings"], *plant_settings))
    source = click.get_current_context().get_parameter_source("rise")
    found = track(
        drive,
        motion=BodyMotion(
            moves=dict(map(move_of, spec["moves"])),
            rise=spec["rise"] if source is click.core.ParameterSource.COMMANDLINE else None,
            **{name: spec[name] for name in ("dwell", "pulses", "order")},
        ),
        options=RigOptions(disturbances=tuple(map(parse_disturbance, spec["disturbances"]))),
        **{name: spec[name] for name in OF_TRACK},
        plant_drive=actual,
    )
    return answer_of_run(drive, found, WOUND, METHOD, spec["seed"])


def answer_of_run(drive: Machine, found: "Tracking", keys: Keys, method: str, seed: int) -> Answer:
    """What a run of either kind answers, by its keys."""
    step = found.summary["internal_step"]
    return Answer(
        data=keys(found.summary),
        text=track_text(drive, found),
        provenance=provenance(drive, method=method, step=step, seed=seed),
        incomplete=found.incomplete,
    )


def move_of(words: str) -> tuple[str, float]:
    """Coordinate and distance [m]."""
    name, equals, value = words.partition("=")
    if not equals:
        raise InputRefused(f'move "{words[:60]}" is not NAME=DISTANCE: write camera.x=2m')
    return name.strip(), to_si(value, "m")


def track_text(drive: Machine, found: "Tracking") -> str:
    """The text: the figures of the run, and what comes in lists."""
    said = found.summary
    head = f"{drive.title or drive.name}: {said['controller']} on {said['plant']}, {said['observer']}"
    lines = [head, "", *aligned(found.figures)]
    if isinstance(said.get("encoders"), list) and "load" not in said["encoders"]:
        lines.append("  no encoder at the load: errors are of the simulated load, which no sensor shows")
    poles = (
        f"{one['frequency_hz']:.1f} Hz ({one['damping_ratio']:.2f})"
        for one in said.get("closed_loop_poles") or ()
    )
    if shown := ", ".join(poles):
        lines.append(f"  poles on the plant, true states: {shown}")
    for number, one in enumerate(said.get("repeated", {}).get("repetitions", ()), start=1):
        seen, true = one["encoder_rms_deg"], one["peak_error_deg"]
        lines.append(f"  repetition {number:3d}  {seen:9.4f} deg rms by its encoder, largest {true:.4f} deg")
    moved = said.get("axis", {}).get("cross_motion")  # of the other axis, its motors free or held
    if moved:
        away, off = (
            _most(of, moved[key]) for of, key in ((moved["other"], "motion"), (said["axis"]["load"], "load"))
        )
        lines.append(
            f"  along this run {moved['other']} moves by up to {away}, which adds up to {off} to the error"
        )
    for name, bound in said.get("position_bound_mm", {}).items():
        lines.append(f"  bound {name:<9} {bound:9.3f} mm")
    lines += [LINE.format(**line, least=stated(line["least_tension"], 5)) for line in said.get("lines", ())]
    lines += [MOTOR.format(**motor) for motor in said.get("motors", ())]
    return "\n".join(lines)


LINE = (
    "  {name:<15} {least} to {largest_tension:.1f} N, allowed from {least_allowed:.1f} N, "
    "at rest {at_rest:.1f} N"
)
MOTOR = "  {name:<15} {peak_torque:.2f} N m at most, limit {torque_limit:.4g} N m"


def _most(coordinate: str, values: list[float]) -> str:
    """The larger of two motions, in mm or deg."""
    scale, unit = (1e3, "mm") if coordinate.endswith((".x", ".y", "along")) else (180.0 / pi, "deg")
    return f"{scale * max(values):.2g} {unit}"


def parse_payload(words: str) -> "Payload":
    """A load from a time on, such as ``3:0.7 s``; without a time from the beginning."""
    from cabledrive.rig.setting import Payload

    factor, colon, start = words.partition(":")
    return Payload(factor=to_si(factor, "1"), start=to_si(start, "s") if colon else 0.0)


def parse_payload_range(words: str | None) -> tuple[float, float]:
    """Least and largest load of a design, such as ``0.5:3``; None: that by default."""
    from cabledrive.rig.setting import PAYLOAD_RANGE

    if words is None:
        return PAYLOAD_RANGE
    low, colon, high = words.partition(":")
    if not colon:
        raise InputRefused(f'payload range "{words[:60]}" is not LOW:HIGH: write 0.5:3')
    return to_si(low, "1"), to_si(high, "1")
