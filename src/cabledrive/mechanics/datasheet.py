"""The data sheet of a drive, what follows from its file by closed formulas, and warnings by it."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, inf, pi, sqrt, tanh
from typing import Any

from cabledrive.answers.figures import figure, rounded
from cabledrive.answers.result import Result
from cabledrive.mechanics.holding import lumped_joint_mode, shafts_of
from cabledrive.mechanics.network.rest_forces import sag_parameter
from cabledrive.mechanics.network.span_table import ELASTIC_RULE, route_warnings, slipping, strained, worn
from cabledrive.mechanics.network.statics import statics_of
from cabledrive.mechanics.rest import rest_state
from cabledrive.mechanics.spans import lumped_cable_mode
from cabledrive.parameters import Machine
from cabledrive.parameters.cable import Rope
from cabledrive.parameters.drive import PART_NAMES, Drive
from cabledrive.parameters.fields import described
from cabledrive.parameters.route.two_pulleys import two_pulleys_of

CABLE, TORQUE, REST, INERTIAS = "Cable", "Torque", "At rest", "Inertias"
MASSLESS, RESOLUTION = "Estimates with a massless cable", "Resolution"
_WRAP = "needs a loop with pulley.{0}.wrap_angle and pulley.{0}.capstan_friction"


@described
@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class DerivedQuantities(Result):
    r"""Quantities that follow from the drive file.

    Mass ratios of a loop are :math:`J/(2\rho r^2 L_e)`, as under Eq. (5.4) but with Le; the drive pulley
    counts with the motor where the joint is rigid, without it where it is flexible. Tension and sag are those
    of the elastic catenaries of `cabledrive.mechanics.rest.rest_state`.
    """

    axial_rigidity: float = figure("N", "Axial rigidity EA", CABLE)
    prestrain: float = figure("1", "Strain under the pretension, T₀/EA", CABLE)
    cable_stiffness: float = figure("N/m", "Stiffness of one span, EA/L", CABLE)
    lumped_cable_stiffness: float | None = figure(
        "N/m", "Measured stiffness of one span", why="lumped.cable_stiffness is not given: EA / L holds"
    )
    cable_mass: float = figure("kg", "Mass of the whole cable", CABLE)
    stretched_mass_per_length: float = figure("kg/m", "Mass per metre under the pretension, rho")
    span_length: float = figure("m", "Unstretched span, L")
    pulley_distance: float = figure("m", "Span under pretension, Lₑ", CABLE)
    axial_wave_speed: float = figure("m/s", "Longitudinal wave speed", CABLE)
    transverse_wave_speed: float = figure("m/s", "Transverse wave speed", CABLE)
    transverse_frequency_hz: float = figure("Hz", "Lowest frequency of an empty span, c_w / (2 Le)")
    slack_torque: float = figure("N m", "Slack torque at the drive pulley", TORQUE)
    no_slip_torque_drive: float | None = figure(
        "N m", "Slip torque at the drive pulley", TORQUE, _WRAP.format(0)
    )
    no_slip_torque_load: float | None = figure(
        "N m", "Slip torque at the load pulley", TORQUE, _WRAP.format(1)
    )
    lowest_static_tension: float = figure("N", "Lowest tension at rest", REST)
    static_sag: float = figure("m", "Largest sag of a free stretch", REST)
    sag_ratio: float = figure("1", "That sag over the length Le of the span")
    irvine_parameter: float = figure("1", "Irvine parameter λ²; sag is small well below 1", REST)
    chi1: float | None = figure(
        "1", "Drive pulley over cable, χ₁ = J₁/(r₁² m)", INERTIAS, "the drive pulley is fixed"
    )
    chi2: float | None = figure(
        "1", "Load pulley over cable, χ₂ = J₂/(r₂² m)", INERTIAS, "the load pulley is fixed"
    )
    reflected_rotor_inertia: float | None = figure(
        "kg m^2",
        "Rotor through the gear, at the output shaft",
        INERTIAS,
        "needs motor.rotor_inertia and motor.gear_ratio",
    )
    cable_mode_frequency_hz: float | None = figure(
        "Hz",
        "Lowest mode of pulleys and carriages, motor joint rigid",
        MASSLESS,
        "both pulleys are fixed and nothing rides on the cable",
    )
    joint_mode_frequency_hz: float | None = figure(
        "Hz",
        "Motor against drive pulley",
        MASSLESS,
        "motor.joint_stiffness is not given: there is no flexible joint",
    )
    motor_encoder_resolution: float | None = figure(
        "rad",
        "Motor encoder, one count at the output shaft",
        RESOLUTION,
        "sensors.motor_encoder is not given",
    )
    drive_encoder_resolution: float | None = figure(
        "rad", "Drive encoder, one count", RESOLUTION, "sensors.drive_encoder is not given"
    )
    load_encoder_resolution: float | None = figure(
        "rad", "Load encoder, one count", RESOLUTION, "sensors.load_encoder is not given"
    )
    motor_encoder_counts_per_motor_turn: float | None = figure(
        "1",
        "Counts per revolution of the motor's own shaft",
        why="needs sensors.motor_encoder and motor.gear_ratio",
    )

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers in SI, for JSON.

        Returns
        -------
        dict
            Every attribute by its name, None where it does not exist for this drive; "reasons" says why.
        """
        values = dataclasses.asdict(self)
        whys = {field.name: field.metadata["why"] for field in dataclasses.fields(self)}
        return values | {"reasons": {name: whys[name] for name, value in values.items() if value is None}}


def derived_quantities(drive: Machine | Drive) -> DerivedQuantities:
    """Work out the datasheet of a drive.

    Parameters
    ----------
    drive : Machine or Drive
        One cable between two pulleys.

    Returns
    -------
    DerivedQuantities

    Raises
    ------
    InputRefused
        If it has other parts.
    NotComputed
        If no state of rest is found.
    """
    drive = two_pulleys_of(drive, "`derived_quantities`")
    cable, motor, sensors = drive.cable, drive.motor, drive.sensors
    mass = len(drive.spans) * drive.span_length * cable.mass_per_length
    rest = rest_state(drive)
    sag = max(section.sag for section in rest.sections)
    rims = [None if s.fixed else s.rim_mass / mass for s in shafts_of(drive)[:2]]
    modes = [omega and omega / (2.0 * pi) for omega in (lumped_cable_mode(drive), lumped_joint_mode(drive))]
    slips: list[float | None] = []
    for pulley in drive.pulley:
        friction, wrap = pulley.capstan_friction, pulley.wrap_angle
        known = drive.closed and friction is not None and wrap is not None
        # one span gains what the other loses, and e^(mu alpha) is their ratio at most (Euler and Eytelwein)
        share = tanh(0.5 * (friction or 0.0) * (wrap or 0.0))
        slips.append(2.0 * pulley.radius * cable.pretension * share if known else None)
    counts = {name: getattr(sensors, f"{name}_encoder", None) for name in ("motor", "drive", "load")}
    gear, rotor = (motor.gear_ratio, motor.rotor_inertia) if motor else (None, None)
    return DerivedQuantities(
        prestrain=cable.prestrain,
        axial_rigidity=cable.axial_rigidity,
        axial_wave_speed=cable.axial_wave_speed,
        transverse_wave_speed=cable.transverse_wave_speed,
        span_length=drive.span_length,
        pulley_distance=drive.pulley_distance,
        stretched_mass_per_length=cable.stretched_mass_per_length,
        cable_mass=mass,
        cable_stiffness=cable.axial_rigidity / drive.span_length,
        lumped_cable_stiffness=drive.lumped.cable_stiffness if drive.lumped else None,
        lowest_static_tension=rest.lowest_tension,
        transverse_frequency_hz=cable.transverse_wave_speed / (2.0 * drive.pulley_distance),
        static_sag=sag,
        sag_ratio=sag / drive.pulley_distance,
        irvine_parameter=max(sag_parameter(section.stretches) for section in rest.sections),
        chi1=rims[0],
        chi2=rims[1],
        slack_torque=len(drive.spans) * drive.drive_pulley.radius * cable.pretension,
        no_slip_torque_drive=slips[0],
        no_slip_torque_load=slips[1],
        cable_mode_frequency_hz=modes[0],
        joint_mode_frequency_hz=modes[1],
        motor_encoder_counts_per_motor_turn=counts["motor"] / gear if counts["motor"] and gear else None,
        reflected_rotor_inertia=rotor * gear**2 if rotor and gear else None,
        **{f"{name}_encoder_resolution": 2.0 * pi / n if n else None for name, n in counts.items()},
    )


SMALL_SAG = 0.01  # of the span
SMALL_IRVINE = 1.0  # the sag has then raised the tension by 4 %
STIFFNESS_TOLERANCE = 0.2
SAMPLES_PER_CYCLE = 10.0


def drive_warnings(drive: Machine | Drive) -> tuple[str, ...]:
    """Find what in a drive is likely to be a mistake or a limit.

    Parameters
    ----------
    drive : Machine or Drive

    Returns
    -------
    tuple of str
        One line each: what, value with unit, the bound it met, the remedy. Empty if nothing stands out.
    """
    drive = drive.machine
    own = drive.two_pulleys
    if own is None:
        return (*route_warnings(drive), *_rotors(drive))
    sheet = derived_quantities(own)
    checks = (_static, _elastic, _sag, _bends, _torque, _light, _stiffness, _joint)
    lines = [line for check in checks for line in check(own, sheet)]
    highest = max(sheet.cable_mode_frequency_hz or 0.0, sheet.joint_mode_frequency_hz or 0.0)
    rest = drive, statics_of(drive, pushes=True)
    return (*lines, *goal_warnings(own, highest), *_rotors(drive), *slipping(*rest), *worn(*rest))


def warnings_of_rest(drive: Machine) -> tuple[str, ...]:
    """Warnings that touch what is said of vibrations, a line each: slack at rest, strain and sag."""
    own = drive.two_pulleys
    if own is None:
        return tuple(strained(drive))
    sheet = derived_quantities(own)
    return tuple(line for check in (_static, _elastic, _sag, _bends) for line in check(own, sheet))


def sags(drive: Drive) -> bool:
    """Whether a loop or a line sags more than the straight cable of reduced models may."""
    return any(True for _ in _sag(drive, derived_quantities(drive)))


def largest_pretension(rope: Rope) -> float:
    """Pretension that strains a rope to its ``strain_limit``, without one to `ELASTIC_RULE` [N]."""
    return (rope.strain_limit or ELASTIC_RULE) * rope.axial_rigidity


def elastic_range(rope: Rope) -> str:
    """How far a pretension may be raised, for a sentence that advises none."""
    return f"within the cable's elastic range, up to {rounded(largest_pretension(rope), 4)} N,"


def _none_is_enough(drive: Drive, needed: float) -> str:
    """Said instead of a pretension beyond the elastic range that the file states; else nothing."""
    if drive.cable.strain_limit is None or needed <= largest_pretension(drive.cable):
        return ""
    return f"no pretension {elastic_range(drive.cable)} is enough"


def _or_raise(drive: Drive, needed: float) -> str:
    none = _none_is_enough(drive, needed)
    return f": {none}" if none else f" or raise the pretension to {needed:.4g} N"


def _static(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A span that hangs slack at rest."""
    lowest = sheet.lowest_static_tension
    if lowest <= 0.0:
        yield (
            "a span hangs slack at rest: on this slope cable and carriages take its lower end to "
            f"{lowest:.4g} N; raise the pretension above {drive.cable.pretension - lowest:.4g} N"
        )


def _elastic(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A prestrain out of the elastic range."""
    limit = drive.cable.strain_limit or ELASTIC_RULE
    if sheet.prestrain > limit:
        stated = drive.cable.strain_limit is not None
        origin = "strain_limit" if stated else "a rule of thumb: give strain_limit"
        yield (
            f"the pretension strains the cable by {rounded(100 * sheet.prestrain, 4)}%, beyond {limit:.3%}, "
            f"its elastic range ({origin}); lower the pretension below {largest_pretension(drive.cable):.4g} "
            "N or take more cable"
        )


def _sag(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A sag that bends the straight cable of the reduced models."""
    ratio, irvine = sheet.sag_ratio / SMALL_SAG, sheet.irvine_parameter / SMALL_IRVINE
    if max(ratio, irvine) > 1.0:
        pull = max(stretch.mean_tension for stretch in rest_state(drive).stretches)
        straight = pull * max(ratio, irvine ** (1.0 / 3.0))
        advice = _none_is_enough(drive, straight) or f"a pretension of {straight:.3g} N would be enough"
        yield (
            f"a span sags by {sheet.static_sag:.3g} m, {rounded(100 * sheet.sag_ratio, 3)}% of its length "
            f"(small: {SMALL_SAG:.0%}), Irvine parameter {sheet.irvine_parameter:.3g} "
            f"(small: {SMALL_IRVINE:g}): the modes are those of the hanging rope; "
            f"lumped models, maps and branches take a straight cable; {advice} to straighten it"
        )


def _bends(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A bending stiffness that the modes alone count: hinged at pulleys, clamped at carriages."""
    bent = sqrt((drive.cable.bending_stiffness or 0.0) / drive.cable.pretension)
    bent /= min(own.end - own.start for own in rest_state(drive).sections)
    raised = 0.5 * (pi * bent) ** 2 + (2.0 * bent if drive.carriage else 0.0)
    if raised > 1e-4:
        yield (
            f"bending_stiffness raises a transverse frequency by {raised:.2g} (small: 1e-4): "
            "modes count it; the data sheet, simulations, internal resonance and pings take a limp cable"
        )


def _torque(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A motor that can unload a span, or make the cable slip on either pulley."""
    limit = drive.motor.torque_limit if drive.motor else None
    if limit is None:
        return
    if limit > sheet.slack_torque:
        formula = "2 r1 T0" if drive.closed else "r1 T0"
        needed = drive.cable.pretension * limit / sheet.slack_torque
        yield (
            f"the motor's torque_limit = {limit:.4g} N m is above {sheet.slack_torque:.4g} N m, the slack "
            f"torque {formula}: a span can go slack; limit the torque{_or_raise(drive, needed)}"
        )
    margins = sheet.no_slip_torque_drive, sheet.no_slip_torque_load
    for name, pulley, margin in zip(PART_NAMES, drive.pulley, margins, strict=False):
        asked = limit * pulley.radius / drive.drive_pulley.radius
        if margin is not None and asked > margin:
            needed = drive.cable.pretension * asked / margin
            yield (
                f"the motor's torque_limit asks {asked:.4g} N m of the {name}, which slips at {margin:.4g} N "
                f"m (capstan): limit the torque or wrap further{_or_raise(drive, needed)}"
            )


def _light(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A pulley lighter than the cable: the models of springs without mass end there."""
    for name, ratio in zip(PART_NAMES, (sheet.chi1, sheet.chi2), strict=False):
        if ratio is not None and ratio < 1.0:
            rim = ratio * sheet.cable_mass
            yield (
                f"the {name} is lighter than the cable, J / r^2 = {rim:.3g} kg below "
                f"{sheet.cable_mass:.3g} kg: lumped models of it are rough; use the distributed cable, or "
                "check its inertia"
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


def _joint(drive: Drive, sheet: DerivedQuantities) -> Iterator[str]:
    """A motor joint softer than the cable."""
    joint, cable = sheet.joint_mode_frequency_hz, sheet.cable_mode_frequency_hz
    if joint is not None and cable is not None and joint < cable:
        yield (
            f"the motor joint's mode, about {joint:.4g} Hz, lies below the cable's, about {cable:.4g} Hz: "
            "keep the joint in the model, or raise joint_stiffness by a factor above "
            f"{(cable / joint) ** 2:.3g}"
        )


def _rotors(drive: Machine) -> Iterator[str]:
    """A rotor that is heavier than the motor it is a part of."""
    for motor in drive.motors:
        reflected = (motor.rotor_inertia or 0.0) * (motor.gear_ratio or 0.0) ** 2
        if reflected > motor.inertia * (1.0 + 1e-9):
            yield (
                f"the rotor alone is {reflected:.4g} kg m^2 through the gear, above the motor's inertia, "
                f"{motor.inertia:.4g} kg m^2, which should hold it: check inertia, rotor_inertia, gear_ratio"
            )


def goal_warnings(drive: Drive, highest: float) -> Iterator[str]:
    """A tracking goal finer than backlash or encoder at the load; too low a sample rate for the modes.

    ``highest``: frequency of the highest lumped mode [Hz].
    """
    goal = drive.goal.tracking_error if drive.goal and drive.goal.tracking_error is not None else inf
    asked = f"goal.tracking_error = {degrees(goal):.3g} deg"
    if drive.motor is not None and drive.motor.backlash > goal:
        yield (
            f"a backlash of {degrees(drive.motor.backlash):.3g} deg is above {asked}: the motor does not "
            "hold the load that closely; take out the play or relax the goal"
        )
    count = drive.sensors.load_encoder if drive.sensors else None
    if count is not None and 2.0 * pi / count > goal:
        yield (
            f"one count of sensors.load_encoder is {360.0 / count:.3g} deg, above {asked}: use a finer "
            "encoder or relax the goal"
        )
    rate = drive.sensors.sample_rate if drive.sensors else None
    if rate is not None and rate < SAMPLES_PER_CYCLE * highest:
        yield (
            f"sensors.sample_rate = {rate:.4g} Hz is below {SAMPLES_PER_CYCLE:g} times the highest lumped "
            f"mode, about {highest:.4g} Hz: sample at {SAMPLES_PER_CYCLE * highest:.4g} Hz or more, or "
            "filter that mode"
        )
