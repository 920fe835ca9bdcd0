"""What runs and planned motions answer: a load, a body between two winches, laws compared, an experiment."""

from functools import partial

from cabledrive.answers.figures import Row, inside, percent
from cabledrive.answers.keys import Keys

RUN = Keys(
    "text: controller plant observer map: gains=any count: seed number: sample_rate internal_step "
    "flag: estimates_within_bounds",
    {"estimates_within_bounds": "the law has no estimates with bounds"},
)
"""What each run of the rig answers."""
TRACKING = (
    Row("peak_error_deg", "peak error", "deg", ".4f"),
    Row("encoder_error_deg", "by encoder of load, else motor", "deg", ".4f"),
    Row("rms_error_deg", "rms error", "deg", ".4f"),
    Row("axis.peak_error_mm", "peak error of the axis", "mm", ".4f", kind="number?"),
    Row("theory_bound_deg", "bound", "deg", ".4f"),
    Row("within_bound", "bound kept", kind="flag"),
    Row("broken_assumptions", "assumptions that do not hold", kind="texts"),
    Row("peak_torque", "peak torque", "N m", ".4f"),
    Row("saturated_fraction", "at its limit", "% of the samples", ".1f", 100.0),
    Row("slack_samples", "samples with a slack span", form="d"),
    Row("invalid_samples", "samples without a reading", form="d"),
    Row("rest_swing_deg", "swing at rest", "deg", ".4f", kind="number?"),
    Row("rest_swing_counts", "of the load's encoder", "counts", ".1f", kind="number?"),
    Row("limit_cycle", "limit cycle", kind="flag?"),
    Row("pair.preload", "pair of motors, preload", "N m"),
    Row("pair.least_flank_torque", "least flanks", "N m", kind="numbers"),
    Row("pair.motor_peak_torque", "each at most", "N m", kind="numbers"),
    Row("pair.reason", "flanks", kind="text?"),
    Row("pair.assumptions", "as long as", kind="texts"),
    Row("axis.load", "axis", kind="text"),
    Row("axis.neglected", "modes left out", "%", ".2g", 100.0),
    Row("axis.neglected_strings", "strings left out", "%", ".2g", 100.0),
    Row("axis.off_the_end", "off the end", "%", ".2g", 100.0),
    Row("axis.sag", "left out", kind="note"),
    Row("axis.coupled", "coupling", kind="note"),
    Row("axis.held_torque", "held at rest, beside what is shown, and off the limit", "N m", kind="number?"),
    Row("learnt.used_reason", "nothing learnt"),
    Row("learnt.beta", "learnt, beta", "1/s^2", ".1f"),
    Row("learnt.inertia.value", "learnt, inertia", "kg m^2"),
    Row("cable.spillover_deg", "spillover", "deg", ".2e"),
    Row("cable.frequency_ratio", "transverse over pulley mode", form=".1f"),
    Row("cable.one_to_two", "1:2 coupling", kind="text"),
    Row("cable.passed", "as long as", kind="texts"),
    Row("repeated.best", "repetition shown", form="d"),
    Row("repeated.stopped", "stopped", kind="text"),
    Row("repeated.contraction", "converges by, a repetition", form=".3f"),
    Row("repeated.assumed", "as long as", kind="texts"),
    Row("over_draws.draws", "draws", form="d"),
    Row("over_draws.median_peak_error_deg", "median over draws", "deg", ".4f"),
    Row("over_draws.worst_peak_error_deg", "worst over draws", "deg", ".4f"),
    Row("over_draws.failed", "ended early", form="d"),
    Row("over_draws.flanks_closed", "flanks of the pair closed in", form="d", kind="count?"),
    Row("over_draws.expected_bound_deg", "bound for all uncertainties together", "deg", ".4f"),
    Row("interpreted", "interpreted, slower", kind="note"),
    Row("motor_reason", "motor", kind="text?"),
    Row("ended_at", "ended early", "s", kind="number?"),
    Row("gains.reasons", "law"),
)
"""Figures of a run that a load follows."""
WINCHES = (
    Row("peak_error_mm", "peak error", "mm", ".3f"),
    Row("rms_error_mm", "rms error", "mm", ".3f"),
    Row("position_bound_used", "of the bound used", form=".2f"),
    Row("position_broken_assumptions", "assumptions that do not hold", kind="texts"),
    Row("least_tension", "least tension", "N", ".1f"),
    Row("least_allowed", "least allowed", "N", ".1f"),
    Row("peak_torque", "peak torque", "N m", ".2f"),
    Row("least_damping", "least damping of the poles", form=".2f"),
    Row("gust", "tension promised for gusts up to", "N"),
    Row("assumptions", "as long as", kind="texts"),
    Row("reasons", "reasons", kind="texts"),
    Row("over_draws.draws", "draws", form="d"),
    Row("over_draws.kept", "tension kept in", form="d"),
    Row("over_draws.share_low", "of all at least", "%", ".1f", 100.0),
    Row("over_draws.least_tension", "least tension over draws", "N", ".1f"),
    Row("over_draws.median_peak_error_mm", "median over draws", "mm", ".2f"),
    Row("over_draws.worst_peak_error_mm", "worst over draws", "mm", ".2f"),
    Row("over_draws.position_bound_left", "bound of the position left by", form="d"),
    Row("over_draws.drawn", "drawn", kind="text"),
)
"""Figures of a run of a body between two winches."""
CHAIN = Keys(
    "map: motors number: gain coupling slack_torque numbers: inertias stiffness load_row frequencies_hz "
    "note: other reason flag: slides object: cross_motion{text: other? numbers: motion? load?}?",
    figures=inside(TRACKING, "axis"),
)
FAILED, UNTUNED = "no run, or too many ended early", "no run: the law could not be tuned"
MOTION = (
    "object: motion{number: angle_deg rise dwell count: pulses order rows: payload{number: factor start}?}"
)
TRACKED = Keys(
    "text: motor friction slack_rule number: backlash first_pulse_error_deg later_pulses_error_deg "
    "slack_share delay bound_used printed_norm_bound_deg? numbers: encoder_phases flag: inside_tube? "
    "count: free_play_samples texts: feedback encoders departures rows: "
    f"closed_loop_poles{{number: frequency_hz damping_ratio}} {MOTION} axis? "
    "circumstances{number: jitter torque_limit? current_bandwidth_hz? rows: disturbances{text: on number: "
    "torque start end?} object: load_change{number: start factor}? any: blind?} "
    "pair{number: backlash torque_limit flank_observer_error flag: flanks_closed count: flank_open_samples}? "
    "repeated{rows: repetitions{number: encoder_rms_deg peak_error_deg} count: directions}? "
    "cable{count: segments steps_per_sample number: step stiffness axial_damping span_mode_hz sway "
    "pulley_mode_hz transverse_mode_hz}? "
    "best{text: controller count: draws number: goal_deg rows: candidates{text: name number: worst_deg "
    "median_deg}}? "
    "over_draws{number: peak_error_99_deg worst_first_pulse_error_deg worst_torque map: "
    "expected_bound_parts_deg?}? map: learnt=any? robust_conditions=any? d_z?",
    {
        "later_pulses_error_deg": "the motion has one pulse",
        "bound_used": "no bound",
        "closed_loop_poles": "the law is none of the chain",
        "slack_share": "the lumped model has no span that goes slack",
        "torque_limit": "the drive file has no limit",
        "rest_swing_counts": "the load has no encoder",
        "limit_cycle": "the load has no encoder",
        "learnt": "no pulse came after the first",
        "worst_deg": FAILED,
        "median_deg": FAILED,
    },
    {"axis": CHAIN},
    (RUN,),
    figures=TRACKING,
)
WOUND = Keys(
    "number: rms_error_deg peak_error_deg theory_bound_deg saturated_fraction reshaped_fraction flag: "
    "within_bound tension_kept position_within_bound texts: broken_assumptions "
    "map: error_mm position_bound_mm "
    "rows: lines{text: name texts: spans number: least_tension largest_tension at_rest least_allowed margin} "
    "motors{text: name number: peak_torque rms_torque torque_limit} "
    "object: motion{map: way number: rise dwell used count: pulses order} over_draws{number: share}?",
    {
        "least_tension": "the run diverged",
        "position_within_bound": "assumptions of the bound do not hold",
    },
    also=(RUN,),
    figures=WINCHES,
)
SHARE = partial(percent, unit="")
ERRORS = (
    Row("name", "law", kind="text"),
    Row("median_deg", "median", "deg", 3, none="none"),
    Row("error_99_deg", "99 %", "deg", 3, none="none"),
    Row("worst_deg", "worst", "deg", 3, none="none"),
    Row("worst_whole_run_deg", "worst, first pulse included", "deg", 3, none="none"),
    Row("share_within", "within the goal", "%", SHARE),
    Row("share_low", "at least, with 95 % confidence", "%", SHARE),
    Row("reason", "", kind="text"),
)
"""Of each law that was compared: errors of the load."""
COSTS = (
    Row("bandwidth_hz", "bandwidth", "Hz", "g"),
    Row("filter", "filter", kind="text"),
    Row("peak_torque", "peak torque", "N m", 3, none="any"),
    Row("torque_ripple", "ripple, 5 deviations", "N m", 3, none="any"),
    Row("disk_margin", "disk margin", "", 3, none="any"),
    Row("gain_margin", "gain margin", "", 3, none="any"),
    Row("phase_margin_deg", "phase margin", "deg", 3, none="any"),
    Row("tuning_seconds", "tuning", "s", 3),
)
"""Torque, margins at the motor's torque and time to tune."""
COMPARED = Keys(
    "text: drive drive_hash note: best count: draws seed number: goal_deg texts: not_covered rows: "
    "controllers{number: worst_later_deg median_torque count: runs failed saturated_runs flag: learns} "
    f"{MOTION} limits{{number: disk_margin torque_ripple torque}} axis? map: disturbances=numbers",
    {
        "best": "no law could be tuned within the limits",
        "bandwidth_hz": "nothing keeps the limits",
        "torque": "the drive file has no limit",
    }
    | dict.fromkeys(
        ("disk_margin", "gain_margin", "phase_margin_deg", "torque_ripple"),
        "infinite, or the law could not be tuned",
    )
    | dict.fromkeys(("share_within", "share_low", "peak_torque", "median_torque"), UNTUNED)
    | {f"{name}_deg": FAILED for name in ("worst", "median", "error_99", "worst_whole_run", "worst_later")},
    {"axis": CHAIN},
    figures=tuple(row._replace(key=f"controllers.{row.key}") for row in (*ERRORS, *COSTS)),
)
LOGGED = Keys("text: motor motor_reason? log count: rows map: channels=text number: sample_rate_hz")
PLANNED = Keys(
    "text: motor motor_reason? map: relative_standard_error object: peaks{number: torque speed stroke} "
    "number: moving amplitude_factor texts: warnings",
    {
        "amplitude_factor": "the drive file has no limit",
        "relative_standard_error": "not identifiable from this test",
    },
)
ALARMED = (
    Row("reasons", "reasons", kind="texts"),
    Row("largest_transverse", "largest transverse displacement", "m", ""),
    Row("limit", "allowed", "m", ""),
    Row("floor", "always there", "m", ""),
    Row("lowest_tension", "lowest tension", "N", ""),
    Row("remedy", "remedy", kind="text"),
    Row("assumptions", "assumes", kind="texts"),
)
"""Figures of the verdict on a planned motion."""
PARAMETERS = (
    Row("name", "parameter", kind="text"),
    Row("value", "value", "", ".6g", none="not determined"),
    Row("low", "low (95 %)", "", ".6g", none="none"),
    Row("high", "high (95 %)", "", ".6g", none="none"),
    Row("unit", "unit", kind="text"),
)
"""Of each parameter that was identified."""
