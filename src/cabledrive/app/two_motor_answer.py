"""`cabledrive track` of a body between two motors: its options, its run, its text."""

from typing import Any

import click

from cabledrive.app.combinations import refuse_given
from cabledrive.app.results import Answer, provenance
from cabledrive.parameters import InputRefused, load_drive
from cabledrive.parameters.route import RoutedDrive
from cabledrive.parameters.units import to_si

METHOD = "exact geometry of two lines that only pull, symplectic steps, set-valued friction"
NOT_HERE = (
    *("gains", "feedforward", "plant", "angle", "observer", "feedback", "encoder_phase", "ideal_sensors"),
    *("smooth_friction", "no_adaptation", "tension_only", "as_printed", "segments", "jitter", "blind"),
    *("check_conditions", "repeat", "log_file", "animate", "pair", "preload"),
    *("payloads", "payload_range", "load_change"),
)


def two_motor_answer(drive: RoutedDrive, plant_settings: tuple[str, ...], spec: dict[str, Any]) -> Answer:
    """Run the law of two motors on two winches, with those options of `track` that have an effect here."""
    from cabledrive.rig import BodyMotion, RigOptions, TwoMotorTracking, track
    from cabledrive.rig.front_door import NAMED
    from cabledrive.rig.setting import parse_disturbance
    from cabledrive.rig.winch_summary import CONTROLLER

    refuse_given(*NOT_HERE, why="is for pulses of a load pulley: two winches move a body, see --move")
    if spec["controller"] not in NAMED:
        raise InputRefused(
            f'--controller "{spec["controller"][:60]}" moves a load by one motor: a body between two '
            f"winches has {CONTROLLER}, leave it out"
        )
    given = click.get_current_context().params
    actual = None
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
        **{name: spec[name] for name in ("least_tension", "gust", "bandwidth", "seed", "draws")},
        plant_drive=actual if isinstance(actual, RoutedDrive) else None,
    )
    assert isinstance(found, TwoMotorTracking)  # the drive has two winches
    said = found.summary
    return Answer(
        data=said,
        text=_text(drive, said),
        provenance=provenance(drive, method=METHOD, step=said["internal_step"], seed=spec["seed"]),
        incomplete=found.incomplete,
    )


def move_of(words: str) -> tuple[str, float]:
    """Coordinate and distance [m]."""
    name, equals, value = words.partition("=")
    if not equals:
        raise InputRefused(f'move "{words[:60]}" is not NAME=DISTANCE: write camera.x=2m')
    return name.strip(), to_si(value, "m")


HEAD = """\
{title}: {controller} on {plant}

  motion          {way} in {motion[rise]:.4g} s and back
  peak error      {peak_error_mm:9.3f} mm
  rms error       {rms_error_mm:9.3f} mm"""
LINE = (
    "  {name:<15} {least:>9} to {largest_tension:.1f} N, allowed from {least_allowed:.1f} N, at rest "
    "{at_rest:.1f} N"
)
MOTOR = "  {name:<15} {peak_torque:9.2f} N m at most, limit {torque_limit:.4g} N m"
DRAWS = """\
  over {draws} draws   tension kept in {kept} (of all at least {low:.1f} %), least {least_tension:.1f} N
    peak error {median} median, {worst} worst
    bound of the position left by {position_bound_left}
    drawn: {drawn}"""


def _text(drive: RoutedDrive, said: dict[str, Any]) -> str:
    way = ", ".join(f"{name} {value:+.4g} m" for name, value in said["motion"]["way"].items())
    lines = [HEAD.format(**said, title=drive.title or drive.name, way=way)]
    lines += [f"  bound {name:<9} {bound:9.3f} mm" for name, bound in said["position_bound_mm"].items()]
    lines.append(f"   used           {said['position_bound_used']:9.2f}")
    if said["position_broken_assumptions"]:
        lines.append("   its assumptions do not hold: " + "; ".join(said["position_broken_assumptions"]))
    for line in said["lines"]:
        least = "-" if line["least_tension"] is None else f"{line['least_tension']:.1f}"
        lines += [LINE.format(**line, least=least), *(f"    {span}" for span in line["spans"])]
    lines += [MOTOR.format(**motor) for motor in said["motors"]]
    lines.append(f"  least damping   {said['least_damping']:9.2f} of the poles of the loop along the way")
    lines.append(f"  tension promised for gusts of up to {said['gust']:.4g} N, as long as")
    lines += [f"    {words}" for words in said["assumptions"]]
    lines += [f"  {words}" for words in said["reasons"]]
    if over := said.get("over_draws"):
        errors = (over[f"{name}_peak_error_mm"] for name in ("median", "worst"))
        median, worst = ("none" if error is None else f"{error:.2f} mm" for error in errors)
        lines.append(DRAWS.format(**over, low=100 * over["share_low"], median=median, worst=worst))
    return "\n".join(lines)
