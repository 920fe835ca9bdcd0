"""`cabledrive resonance`: how near a drive is to its internal resonance, and what would help."""

from dataclasses import replace

from cabledrive.app.combinations import refuse_given, tell_given
from cabledrive.app.options import machine_argument, opt, saves_answer, subcommand
from cabledrive.app.results import Answer, NewFile, provenance
from cabledrive.parameters import Machine, NotComputed
from cabledrive.parameters.route.two_pulleys import two_pulleys_of

FLOOR, LIMIT = 1e-5, 5e-4
METHOD = "modes at rest, coupling by exact integrals, averaged equations to second order"
METHOD_OF_PAIRS = "exact modes of the network, coupling by exact integrals, first-order instability"
SEED = 0
ALONE = "belongs to --motion FILE: add that, or leave it out"


@subcommand(
    "cabledrive resonance dissertation-2 --torque 10mN*m --map map.html", (saves_answer, machine_argument)
)
def command(
    drive: Machine,
    torque: float | None = opt(
        "N m", "Torque amplitude of the verdict; default: that of [excitation] in the file."
    ),
    load_torque: float = opt(
        "N m", "Steady torque on the load pulley: the spans are then tuned at different pretensions.", 0.0
    ),
    motion_file: str | None = opt(
        "path",
        "Assess a planned motion: a CSV file with time [s], torque [N m] and, where they change, pretension "
        "[N], carriage [m] (of the first; coupled ones follow), load torque [N m]; of a machine with routes "
        "also torque NAME, of another motor's pulley, and places of bodies such as head.x [m].",
        flags="--motion",
    ),
    floor: float = opt(
        "m", "Amplitude below which no transverse mode falls, for --motion; default: 10 um.", FLOOR
    ),
    limit: float = opt(
        "m", "Largest transverse displacement from rest allowed, for --motion; default: 0.5 mm.", LIMIT
    ),
    with_branches: bool = opt(
        "flag",
        "Follow the branches of steady motion over the torque: stability, folds, where beats begin.",
        flags="--branches",
    ),
    map_file: NewFile | None = opt(
        "page",
        "Draw growth over pretension and torque into FILE, an interactive page that needs nothing else.",
        flags="--map",
    ),
) -> Answer:
    """Frequency ratio, tuned pretension, threshold torque and verdict for the internal resonance of DRIVE.

    The resonance is between the pulleys' own mode and transverse modes near half its frequency; pairs of
    other longitudinal modes and of sum type are listed with their threshold torques. With --motion a planned
    motion is checked as well: how far the cable moves across, excited directly through sag or parametrically.
    """
    import numpy as np

    from cabledrive.app import resonances as shown
    from cabledrive.mechanics.holding import FREE, left_out_under_torque
    from cabledrive.reduction.threshold import BUILD_UP, NEAR, RESONANT
    from cabledrive.report.machine.tables import pair_data
    from cabledrive.studies.alarm import alarm
    from cabledrive.studies.planned_motion import read_motion
    from cabledrive.studies.resonance import pair_remedies, remedies, resonance
    from cabledrive.studies.resonance_map import steady_branches

    for name, given in (("--map", map_file is not None), ("--branches", with_branches)):
        if given:
            two_pulleys_of(drive, name)
    if motion_file is None:
        refuse_given("floor", "limit", why=ALONE)
    else:
        tell_given("load_torque", why="is not for --motion, which takes that of its file")
    found = resonance(drive, torque=torque, load_torque=load_torque)
    acting, judged, motion, incomplete = found.torque or 0.0, None, None, None
    region = found.instability  # of the pulleys' own mode on two pulleys
    unsafe = region is not None and {found.verdict, region.verdict} <= {RESONANT, NEAR}
    changes = remedies(drive, acting, load_torque) if unsafe else ()
    if not unsafe and found.verdict in (RESONANT, NEAR) and not load_torque:
        changes = pair_remedies(drive, found)
    if motion_file is not None:
        motion = read_motion(motion_file, drive)
        judged = alarm(drive, motion, floor=floor, limit=limit)
        found = shown.of_motion(found, judged)
    data = shown.SUMMARY(found) | {"pairs": [pair_data(pair) for pair in found.pairs]}
    data["remedies"] = [shown.REMEDY(change) for change in changes]
    parts = shown.summary_text(drive, found)
    if changes:
        parts.append(shown.remedies_text(changes, "the pulley mode" if unsafe else "it"))
    if region is not None:
        data |= shown.loop_data(drive, found, load_torque)
        parts += shown.loop_text(drive, found)
    if judged is not None:
        left_out = left_out_under_torque(drive)
        listed = replace(judged, passages=judged.passages[: shown.MOST_PASSAGES])
        data["motion"] = (
            shown.ALARM(listed) | {"motor": FREE} | ({"motor_reason": left_out} if left_out else {})
        )
        parts.append(shown.alarm_text(judged) + (f"\n{left_out}" if left_out else ""))
    if map_file is not None:
        from cabledrive.report.map_page import resonance_map_page, spot_check_line
        from cabledrive.studies.resonance_map import growth_map, spot_checks

        growth = growth_map(drive, torque=acting, load_torque=load_torque)
        checks = () if load_torque else spot_checks(drive, growth, np.random.default_rng(SEED))
        map_file.write(resonance_map_page(growth, spot_check_line(checks), motion=motion))
    if with_branches:
        try:
            branches = steady_branches(drive, acting, np.random.default_rng(SEED), load_torque=load_torque)
        except NotComputed as failure:
            branches, incomplete = (), str(failure)
        data["branches"] = [shown.BRANCH(branch) for branch in branches]
        parts.append(shown.branches_text(branches, acting))
        incomplete = incomplete or next((branch.ended for branch in branches if not branch.complete), None)
    method, tolerances = (METHOD, {"build_up": BUILD_UP}) if region is not None else (METHOD_OF_PAIRS, None)
    about = provenance(drive, method=method, tolerances=tolerances)
    return Answer(data=data, text="\n\n".join(parts), incomplete=incomplete, provenance=about)
