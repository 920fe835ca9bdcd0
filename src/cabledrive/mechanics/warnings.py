"""Warnings about a drive, to be read before its results are used."""

from collections.abc import Iterator
from math import degrees, inf

from cabledrive.mechanics.datasheet import DerivedQuantities, derived_quantities
from cabledrive.mechanics.rest import rest_state
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.fields import rounded
from cabledrive.parameters.route.drive import require_two_pulleys

ELASTIC_RULE = 0.02  # strain, where the file states no limit
SMALL_SAG = 0.01  # of the span
SMALL_IRVINE = 1.0  # the sag has then raised the tension by 4 %
STIFFNESS_TOLERANCE = 0.2
SAMPLES_PER_CYCLE = 10.0


def drive_warnings(drive: Drive) -> tuple[str, ...]:
    """Find what in a drive is likely to be a mistake or a limit.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    tuple of str
        One line each: what, value with unit, the bound it met, the remedy. Empty if nothing stands out.
    """
    require_two_pulleys(drive, "`drive_warnings`")
    sheet = derived_quantities(drive)
    checks = (_static, _elastic, _sag, _torque, _light, _stiffness, _motor, _goal_and_sampling)
    return tuple(line for check in checks for line in check(drive, sheet))


def warnings_of_rest(drive: Drive) -> tuple[str, ...]:
    """Warnings that touch what is said of vibrations, a line each: slack at rest, strain and sag."""
    sheet = derived_quantities(drive)
    return tuple(line for check in (_static, _elastic, _sag) for line in check(drive, sheet))


def largest_pretension(drive: Drive) -> float:
    """Pretension [N] that strains the cable to ``cable.strain_limit``, or without one to `ELASTIC_RULE`."""
    return (drive.cable.strain_limit or ELASTIC_RULE) * drive.cable.axial_rigidity


def elastic_range(drive: Drive) -> str:
    """How far a pretension may be raised, for a sentence that advises none."""
    return f"within the cable's elastic range, up to {rounded(largest_pretension(drive), 4)} N,"


def _none_is_enough(drive: Drive, needed: float) -> str:
    """Said instead of a pretension beyond the elastic range that the file states; else nothing."""
    if drive.cable.strain_limit is None or needed <= largest_pretension(drive):
        return ""
    return f"no cable.pretension {elastic_range(drive)} is enough"


def _or_raise(drive: Drive, needed: float) -> str:
    none = _none_is_enough(drive, needed)
    return f": {none}" if none else f" or raise cable.pretension to {needed:.4g} N"


def _static(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A span that hangs slack at rest."""
    lowest = sheet.lowest_static_tension
    if lowest <= 0.0:
        yield (
            "a span hangs slack at rest: on this slope cable and carriages take its lower end to "
            f"{lowest:.4g} N; raise cable.pretension above {drive.cable.pretension - lowest:.4g} N"
        )


def _elastic(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A prestrain out of the elastic range."""
    limit = drive.cable.strain_limit or ELASTIC_RULE
    if sheet.prestrain > limit:
        stated = drive.cable.strain_limit is not None
        origin = "cable.strain_limit" if stated else "a rule of thumb: give cable.strain_limit"
        yield (
            f"the pretension strains the cable by {rounded(100 * sheet.prestrain, 4)}%, beyond {limit:.3%}, "
            f"its elastic range ({origin}); lower cable.pretension below {largest_pretension(drive):.4g} N "
            "or take more cable"
        )


def _sag(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A sag that bends the straight cable of the reduced models."""
    ratio, irvine = sheet.sag_ratio / SMALL_SAG, sheet.irvine_parameter / SMALL_IRVINE
    if max(ratio, irvine) > 1.0:
        pull = max(stretch.mean_tension for stretch in rest_state(drive).stretches)
        straight = pull * max(ratio, irvine ** (1.0 / 3.0))
        advice = _none_is_enough(drive, straight) or f"a cable.pretension of {straight:.3g} N would be enough"
        yield (
            f"a span sags by {sheet.static_sag:.3g} m, {rounded(100 * sheet.sag_ratio, 3)}% of its length "
            f"(small: {SMALL_SAG:.0%}), Irvine parameter {sheet.irvine_parameter:.3g} "
            f"(small: {SMALL_IRVINE:g}): the modes are those of the hanging rope; "
            f"lumped models and the internal resonance take a straight cable; {advice} to straighten it"
        )


def _torque(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A motor that can unload a span, or make the cable slip on either pulley."""
    limit = drive.motor.torque_limit if drive.motor else None
    if limit is None:
        return
    if limit > sheet.slack_torque:
        formula = "2 r1 T0" if drive.kind == "loop" else "r1 T0"
        needed = drive.cable.pretension * limit / sheet.slack_torque
        yield (
            f"motor.torque_limit = {limit:.4g} N m is above {sheet.slack_torque:.4g} N m, the slack torque "
            f"{formula}: a span can go slack; limit the torque{_or_raise(drive, needed)}"
        )
    pulleys = zip(drive.pulley, (sheet.no_slip_torque_drive, sheet.no_slip_torque_load), strict=True)
    for number, (pulley, margin) in enumerate(pulleys):
        asked = limit * pulley.radius / drive.drive_pulley.radius
        if margin is not None and asked > margin:
            needed = drive.cable.pretension * asked / margin
            yield (
                f"motor.torque_limit asks {asked:.4g} N m of pulley.{number}, which slips at {margin:.4g} N "
                f"m (capstan): limit the torque or wrap further{_or_raise(drive, needed)}"
            )


def _light(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A pulley lighter than the cable: the models of springs without mass end there."""
    for number, (name, ratio) in enumerate((("drive", sheet.chi1), ("load", sheet.chi2))):
        if ratio is not None and ratio < 1.0:
            rim = ratio * sheet.cable_mass
            yield (
                f"the {name} pulley is lighter than the cable, J / r^2 = {rim:.3g} kg below "
                f"{sheet.cable_mass:.3g} kg: lumped models of it are rough; use the distributed cable, or "
                f"check pulley.{number}.inertia"
            )


def _stiffness(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A measured stiffness that is not the cable's."""
    measured, theory = sheet.lumped_cable_stiffness, sheet.cable_stiffness
    if measured is not None and abs(measured / theory - 1.0) > STIFFNESS_TOLERANCE:
        yield (
            f"lumped.cable_stiffness = {measured:.4g} N/m is {measured / theory:.3g} times EA / L = "
            f"{theory:.4g} N/m (bound: within {STIFFNESS_TOLERANCE:.0%}): modes use the one, lumped models "
            "the other; check modulus and area, and whether it counts one span"
        )


def _motor(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A motor joint softer than the cable, a rotor that is heavier than the motor it is a part of."""
    joint, cable = sheet.joint_mode_frequency_hz, sheet.cable_mode_frequency_hz
    if joint is not None and cable is not None and joint < cable:
        yield (
            f"the motor joint's mode, about {joint:.4g} Hz, lies below the cable's, about {cable:.4g} Hz: "
            "keep the joint in the model, or stiffen motor.joint_stiffness by a factor above "
            f"{(cable / joint) ** 2:.3g}"
        )
    reflected = sheet.reflected_rotor_inertia
    if drive.motor is not None and reflected is not None and reflected > drive.motor.inertia * (1.0 + 1e-9):
        yield (
            f"the rotor alone is {reflected:.4g} kg m^2 through the gear, above motor.inertia = "
            f"{drive.motor.inertia:.4g} kg m^2, which should hold it: check motor.inertia, "
            "motor.rotor_inertia and motor.gear_ratio"
        )


def _goal_and_sampling(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A tracking goal finer than backlash or encoder at the load; too low a sample rate for the modes."""
    goal = drive.goal.tracking_error if drive.goal and drive.goal.tracking_error is not None else inf
    asked = f"goal.tracking_error = {degrees(goal):.3g} deg"
    if drive.motor is not None and drive.motor.backlash > goal:
        yield (
            f"motor.backlash = {degrees(drive.motor.backlash):.3g} deg is above {asked}: the motor does not "
            "hold the load that closely; take out the play or relax the goal"
        )
    count = sheet.load_encoder_resolution
    if count is not None and count > goal:
        yield (
            f"one count of sensors.load_encoder is {degrees(count):.3g} deg, above {asked}: use a finer "
            "encoder or relax the goal"
        )
    rate = drive.sensors.sample_rate if drive.sensors else None
    highest = max(sheet.cable_mode_frequency_hz or 0.0, sheet.joint_mode_frequency_hz or 0.0)
    if rate is not None and rate < SAMPLES_PER_CYCLE * highest:
        yield (
            f"sensors.sample_rate = {rate:.4g} Hz is below {SAMPLES_PER_CYCLE:g} times the highest lumped "
            f"mode, about {highest:.4g} Hz: sample at {SAMPLES_PER_CYCLE * highest:.4g} Hz or more, or "
            "filter that mode"
        )
