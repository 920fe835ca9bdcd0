"""The datasheet of a drive: what follows from its file by closed formulas, before any mode is computed."""

import dataclasses
from dataclasses import dataclass
from math import pi, tanh
from typing import Any

import numpy as np

from cabledrive.mechanics.holding import lumped_joint_mode, shafts_of
from cabledrive.mechanics.network.rest_forces import irvine_parameter
from cabledrive.mechanics.rest import rest_state
from cabledrive.mechanics.spans import lumped_cable_mode
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.fields import described, figure
from cabledrive.parameters.route.drive import require_two_pulleys


def no_slip_torque(radius: float, pretension: float, friction: float, wrap_angle: float) -> float:
    r"""Largest torque a pulley of a loop transmits before the cable slips.

    One span gains what the other loses, :math:`T_{tight} + T_{slack} = 2 T_0`, so that with the ratio
    :math:`T_{tight}/T_{slack} \le e^{\mu\alpha}` of Euler and Eytelwein

    .. math:: \tau = r\,(T_{tight} - T_{slack}) = 2 r T_0\,\frac{e^{\mu\alpha} - 1}{e^{\mu\alpha} + 1}
                   = 2 r T_0 \tanh\frac{\mu\alpha}{2}

    It is below the slack torque 2 r T0 at any friction: a loop slips before a span goes slack.

    ``radius``: radius r of the pulley [m]; ``pretension``: pretension T0 [N]; ``friction``: coefficient of
    friction mu between cable and pulley [-]; ``wrap_angle``: angle alpha the cable wraps round the pulley
    [rad].
    Returns torque [N m].
    """
    return 2.0 * radius * pretension * tanh(friction * wrap_angle / 2.0)


CABLE, TORQUE, REST, INERTIAS = "Cable", "Torque", "At rest", "Inertias"
MASSLESS, RESOLUTION = "Estimates with a massless cable", "Resolution"
_WRAP = "needs a loop with pulley.{0}.wrap_angle and pulley.{0}.capstan_friction"


@described
@dataclass(frozen=True, slots=True, kw_only=True)
class DerivedQuantities:
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


def derived_quantities(drive: Drive) -> DerivedQuantities:
    """Work out the datasheet of a drive.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    DerivedQuantities

    Raises
    ------
    NotComputed
        If no state of rest is found.
    """
    require_two_pulleys(drive, "`derived_quantities`")
    cable, motor, sensors = drive.cable, drive.motor, drive.sensors
    mass = len(drive.spans) * drive.span_length * cable.mass_per_length
    rest, irvine = rest_state(drive), [0.0]
    for span in drive.spans:
        squares = pull = 0.0
        for own in (stretch for stretch in rest.stretches if stretch.span == span):
            first, last = own.force_at(np.array([own.start, own.end]))[1].tolist()
            squares += own.length * (first**2 + first * last + last**2) / 3.0
            pull += own.length * own.mean_tension
        if squares:
            pull, shear = pull / drive.span_length, squares / drive.span_length
            irvine.append(irvine_parameter(cable.axial_rigidity * (1.0 + cable.prestrain), pull, shear))
    sag = max(section.sag for section in rest.sections)
    rims = [None if s.fixed else s.rim_mass / mass for s in shafts_of(drive)[:2]]
    modes = [omega and omega / (2.0 * pi) for omega in (lumped_cable_mode(drive), lumped_joint_mode(drive))]
    slips: list[float | None] = []
    for pulley in drive.pulley:
        friction, wrap = pulley.capstan_friction, pulley.wrap_angle
        known = drive.kind != "line" and friction is not None and wrap is not None
        torque = no_slip_torque(pulley.radius, cable.pretension, friction or 0.0, wrap or 0.0)
        slips.append(torque if known else None)
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
        irvine_parameter=max(irvine),
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
