"""What `cabledrive track` prints for people."""

from math import pi
from typing import Any

from cabledrive.parameters import Drive

HEAD = """\
{title}: {controller} on {plant}, {observer}

  peak error      {peak_error_deg:9.4f} deg
   by {encoder} encoder{encoder_error_deg:{width}.4f} deg
  rms error       {rms_error_deg:9.4f} deg
  peak torque     {peak_torque:9.4f} N m
  at its limit    {limited:9.1f} % of the samples"""


def track_text(drive: Drive, said: dict[str, Any]) -> str:
    """The text; ``said``: what `cabledrive track --json` prints."""
    seen = "load" in said["encoders"]
    shown = said | {"title": drive.title or drive.name, "limited": 100 * said["saturated_fraction"]}
    encoder = {"encoder": "its", "width": 10} if seen else {"encoder": "motor", "width": 8}
    lines = [HEAD.format(**shown, **encoder)]
    if not seen:
        lines.append("  no encoder at the load: errors are of the simulated load, which no sensor shows")
    if "axis" in said:
        lines += axis_lines(said["axis"])
    lines += _pair(said)
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
        median, worst = (
            "none" if (value := over[f"{name}_peak_error_deg"]) is None else f"{value:.4f}"
            for name in ("median", "worst")
        )
        ended = f"; {over['failed']} ended early" if over["failed"] else ""
        lines.append(f"  over {over['draws']} draws   median {median}, worst {worst} deg{ended}")
        if over.get("flanks_closed") is not None:
            lines.append(f"   flanks of the pair closed in {over['flanks_closed']}")
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


def _pair(said: dict[str, Any]) -> list[str]:
    """What is left at rest of a drive with backlash, and the flanks of a pair of motors."""
    lines = []
    if said.get("rest_swing_deg") is not None:
        lines.append(f"  swing at rest   {said['rest_swing_deg']:9.4f} deg")
        if said["limit_cycle"]:
            lines.append(
                f"   a limit cycle of {said['rest_swing_counts']:.1f} counts of the load's encoder: the loop "
                "does not come to rest in the backlash"
            )
    pair = said.get("pair")
    if pair is None:
        return lines
    least, most = (
        " and ".join(f"{value:.4g}" for value in pair[key])
        for key in ("least_flank_torque", "motor_peak_torque")
    )
    lines.append(f"  pair of motors  preloaded by {pair['preload']:.4g} N m")
    lines += [f"   least flanks   {least} N m", f"   each at most   {most} N m"]
    lines += [f"   {pair['reason']}"] if "reason" in pair else []
    return [*lines, "   as long as", *(f"    {words}" for words in pair["assumptions"])]


def axis_lines(axis: dict[str, Any]) -> list[str]:
    """The lumped chain of a machine with routes."""
    shown = " and ".join(f"{'-' if share < 0 else ''}{name}" for name, share in axis["motors"].items())
    gain = f"{1e3 * axis['gain']:.4g} mm/rad" if axis["slides"] else f"{axis['gain']:.4g} rad/rad"
    lines = [
        f"  axis            {axis['load']} driven by {shown}, {gain}",
        f"   modes left out {100 * axis['neglected']:9.2g} %   strings "
        f"{100 * axis['neglected_strings']:.2g} %   off the end {100 * axis['off_the_end']:.2g} %",
    ]
    if axis["sag"]:
        lines.append(f"   left out       {axis['sag']}")
    if "peak_error_mm" in axis:
        lines.append(f"   peak error     {axis['peak_error_mm']:9.4f} mm")
    found = axis["cross_motion"]  # of the other axis, its motors free or held, and of the load by it
    if not found:
        return lines
    moved, off = (
        f"{scale * max(found[name]):.2g} {unit}"
        for name, of in (("motion", axis["other"]), ("load", axis["load"]))
        for scale, unit in [(1e3, "mm") if of.endswith((".x", ".y", "along")) else (180.0 / pi, "deg")]
    )
    return [
        *lines,
        f"   coupling       {100 * axis['coupling']:9.2g} %   along this run {axis['other']} moves by up to "
        f"{moved},",
        f"   its motors free or held, which adds up to {off} to the error of {axis['load']}",
    ]


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
