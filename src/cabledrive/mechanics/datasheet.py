"""The datasheet of a drive: what follows from its file by closed formulas, before any mode is computed."""

import dataclasses
from dataclasses import dataclass
from math import pi, tanh
from typing import Any

import numpy as np

from cabledrive.mechanics.holding import lumped_cable_mode, lumped_joint_mode, shafts_of
from cabledrive.mechanics.sag import irvine_parameter, midspan_sag, squared_shear, tension_with_sag
from cabledrive.mechanics.spans import transverse_chains
from cabledrive.parameters.drive import Drive
from cabledrive.parameters.drive_parts import Pulley
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


def lowest_static_tension(drive: Drive) -> float:
    r"""Lowest tension on the cable at rest, the drive pulley held, the load pulley free unless it is fixed.

    Gravity along the line, from drive to load, is :math:`g_s = -g\sin\varphi`. At distance s from the drive
    pulley a span carries the mass M(s) between there and the load pulley,

    .. math:: T(s) = \sigma + g_s\,M(s), \qquad \frac{1}{N L}\sum_{spans}\int_0^L T\,ds = T_0
              \;\Rightarrow\;
              \sigma = T_0 - \frac{g_s}{N}\sum_{spans}\Big(\tfrac12\rho_0 L + \sum_i m_i\frac{x_i}{L}\Big),

    because the stretch of all N spans together stays what the pretension made it (:math:`x_i` is the distance
    of carriage i from the drive pulley). A fixed load pulley keeps the stretch of each span apart. The lowest
    tension is at the lower end. Sag and friction are left out.

    Returns lowest tension [N]; zero or less means that a span hangs slack at rest.
    """
    length = drive.span_length
    pull = -drive.layout.gravity_along
    masses, moments = [], []
    for span in drive.spans:
        carriages = drive.carriages_on(span)
        from_drive = [c.position if span == "upper" else length - c.position for c in carriages]
        masses.append(drive.cable.mass_per_length * length + sum(c.mass for c in carriages))
        moment = sum(c.mass * x for c, x in zip(carriages, from_drive, strict=True))
        moments.append(drive.cable.mass_per_length * length / 2.0 + moment / length)
    if not drive.load_pulley.fixed:
        moments = [sum(moments) / len(moments)] * len(moments)
    at_load = [drive.cable.pretension - pull * moment for moment in moments]
    return min(t + min(0.0, pull * mass) for t, mass in zip(at_load, masses, strict=True))


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivedQuantities:
    r"""Quantities that follow from the drive file.

    Attributes
    ----------
    prestrain : float
        Strain under the pretension T0 / EA [-].
    axial_rigidity : float
        EA [N].
    axial_wave_speed, transverse_wave_speed : float
        c_u and c_w along the pretensioned cable [m/s].
    span_length, pulley_distance : float
        Length of a span, L unstretched and Le under pretension [m].
    stretched_mass_per_length : float
        Mass per pretensioned metre rho [kg/m].
    cable_mass : float
        Mass of the cable, all spans [kg].
    cable_stiffness : float
        EA / L of one span [N/m].
    lumped_cable_stiffness : float or None
        Measured stiffness of one span that reduced models use instead [N/m].
    chi1, chi2 : float or None
        Mass ratios of drive and load pulley, J / (r^2 m) with the cable's mass m; of a loop
        :math:`J/(2\rho r^2 L_e)`, as under Eq. (5.4) but with Le. The drive pulley counts with the motor
        where the joint is rigid, without it where it is flexible. None where the pulley is fixed.
    slack_torque : float
        Torque at the drive pulley at which a span goes slack: 2 r1 T0 of a loop, r1 T0 of a line [N m].
    no_slip_torque_drive, no_slip_torque_load : float or None
        Torque a pulley of a loop transmits before the cable slips on it, see `no_slip_torque` [N m].
    lowest_static_tension : float
        Lowest tension at rest on an inclined line, see `lowest_static_tension` [N].
    static_sag : float
        Largest sag at the middle of a free stretch, were the tension kept at T0 [m]. A stretch runs between
        pulleys and guided carriages; weight across the line is that of cable and hanging carriages.
    sag_ratio : float
        Static sag over the length Le of the span [-].
    irvine_parameter : float
        lambda^2 of the span where it is largest, see `irvine_parameter` [-].
    tension_with_sag : float
        Tension of that span after its sag has stretched it between held pulleys [N].
    static_sag_held : float
        The largest sag at the tension so raised [m].
    transverse_frequency_hz : float
        Lowest frequency of an empty span as a string, c_w / (2 Le) [Hz].
    cable_mode_frequency_hz : float or None
        Lumped estimate of the cable mode, carriages included, see `lumped_cable_mode` [Hz].
    joint_mode_frequency_hz : float or None
        Lumped estimate of the joint mode, see `lumped_joint_mode` [Hz].
    motor_encoder_resolution, drive_encoder_resolution, load_encoder_resolution : float or None
        One count [rad], the motor's at the output shaft.
    motor_encoder_counts_per_motor_turn : float or None
        Counts per revolution of the motor's own shaft [-].
    reflected_rotor_inertia : float or None
        Inertia of the bare rotor seen through the gear, at the output shaft [kg m^2].
    """

    prestrain: float
    axial_rigidity: float
    axial_wave_speed: float
    transverse_wave_speed: float
    span_length: float
    pulley_distance: float
    stretched_mass_per_length: float
    cable_mass: float
    cable_stiffness: float
    lumped_cable_stiffness: float | None
    chi1: float | None
    chi2: float | None
    slack_torque: float
    no_slip_torque_drive: float | None
    no_slip_torque_load: float | None
    lowest_static_tension: float
    static_sag: float
    sag_ratio: float
    irvine_parameter: float
    tension_with_sag: float
    static_sag_held: float
    transverse_frequency_hz: float
    cable_mode_frequency_hz: float | None
    joint_mode_frequency_hz: float | None
    motor_encoder_resolution: float | None
    drive_encoder_resolution: float | None
    load_encoder_resolution: float | None
    motor_encoder_counts_per_motor_turn: float | None
    reflected_rotor_inertia: float | None

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers in SI, for JSON.

        Returns
        -------
        dict
            Every attribute by its name, None where it does not exist for this drive; "reasons" says why.
        """
        values = dataclasses.asdict(self)
        missing = {name: _REASONS[name] for name, value in values.items() if value is None}
        return values | {"reasons": missing}


_REASONS = {
    "lumped_cable_stiffness": "lumped.cable_stiffness is not given: EA / L holds",
    "chi1": "the drive pulley is fixed",
    "chi2": "the load pulley is fixed",
    "no_slip_torque_drive": "needs a loop with pulley.0.wrap_angle and pulley.0.capstan_friction",
    "no_slip_torque_load": "needs a loop with pulley.1.wrap_angle and pulley.1.capstan_friction",
    "cable_mode_frequency_hz": "both pulleys are fixed and nothing rides on the cable",
    "joint_mode_frequency_hz": "motor.joint_stiffness is not given: there is no flexible joint",
    "motor_encoder_resolution": "sensors.motor_encoder is not given",
    "drive_encoder_resolution": "sensors.drive_encoder is not given",
    "load_encoder_resolution": "sensors.load_encoder is not given",
    "motor_encoder_counts_per_motor_turn": "needs sensors.motor_encoder and motor.gear_ratio",
    "reflected_rotor_inertia": "needs motor.rotor_inertia and motor.gear_ratio",
}


def derived_quantities(drive: Drive) -> DerivedQuantities:
    """Work out the datasheet of a drive.

    Parameters
    ----------
    drive : Drive

    Returns
    -------
    DerivedQuantities
    """
    require_two_pulleys(drive, "`derived_quantities`")
    return DerivedQuantities(
        **_of_the_cable(drive),
        **_of_the_sag(drive),
        **_of_the_pulleys(drive),
        **_of_the_motor_and_sensors(drive),
    )


def _of_the_cable(drive: Drive) -> dict[str, Any]:
    cable = drive.cable
    return {
        "prestrain": cable.prestrain,
        "axial_rigidity": cable.axial_rigidity,
        "axial_wave_speed": cable.axial_wave_speed,
        "transverse_wave_speed": cable.transverse_wave_speed,
        "span_length": drive.span_length,
        "pulley_distance": drive.pulley_distance,
        "stretched_mass_per_length": cable.stretched_mass_per_length,
        "cable_mass": _cable_mass(drive),
        "cable_stiffness": cable.axial_rigidity / drive.span_length,
        "lumped_cable_stiffness": drive.lumped.cable_stiffness if drive.lumped else None,
        "lowest_static_tension": lowest_static_tension(drive),
        "transverse_frequency_hz": cable.transverse_wave_speed / (2.0 * drive.pulley_distance),
    }


def _cable_mass(drive: Drive) -> float:
    return len(drive.spans) * drive.span_length * drive.cable.mass_per_length


def _of_the_sag(drive: Drive) -> dict[str, Any]:
    """Sag of the free stretches; what belongs to the whole span is that of the worse one."""
    cable, layout = drive.cable, drive.layout
    weight = layout.gravity_across
    line_load = cable.stretched_mass_per_length * weight
    sags = dict.fromkeys(drive.spans, 0.0)
    shears = dict.fromkeys(drive.spans, 0.0)
    for labelled in transverse_chains(drive):
        span, string = labelled.stretches[0].span, labelled.chain
        ends = np.cumsum(string.lengths) * (1.0 + cable.prestrain)
        load = float(ends[-1]), line_load, ends[:-1], string.masses[1:-1] * weight
        sags[span] = max(sags[span], midspan_sag(cable.pretension, *load))
        shears[span] += squared_shear(*load) / drive.pulley_distance
    stiffness = cable.axial_rigidity * (1.0 + cable.prestrain)
    irvine = {span: irvine_parameter(stiffness, cable.pretension, shear) for span, shear in shears.items()}
    tension = {span: tension_with_sag(cable.pretension, irvine[span]) for span in sags}
    return {
        "static_sag": max(sags.values()),
        "sag_ratio": max(sags.values()) / drive.pulley_distance,
        "irvine_parameter": max(irvine.values()),
        "tension_with_sag": max(tension.values()),
        "static_sag_held": max(sags[span] * cable.pretension / tension[span] for span in sags),
    }


def _of_the_pulleys(drive: Drive) -> dict[str, Any]:
    rims = [None if s.fixed else s.rim_mass / _cable_mass(drive) for s in shafts_of(drive)[:2]]
    return {
        "chi1": rims[0],
        "chi2": rims[1],
        "slack_torque": len(drive.spans) * drive.drive_pulley.radius * drive.cable.pretension,
        "no_slip_torque_drive": _no_slip_torque(drive, drive.drive_pulley),
        "no_slip_torque_load": _no_slip_torque(drive, drive.load_pulley),
        "cable_mode_frequency_hz": _hertz(lumped_cable_mode(drive)),
        "joint_mode_frequency_hz": _hertz(lumped_joint_mode(drive)),
    }


def _no_slip_torque(drive: Drive, pulley: Pulley) -> float | None:
    if drive.kind == "line" or pulley.wrap_angle is None or pulley.capstan_friction is None:
        return None
    return no_slip_torque(pulley.radius, drive.cable.pretension, pulley.capstan_friction, pulley.wrap_angle)


def _hertz(omega: float | None) -> float | None:
    return None if omega is None else omega / (2.0 * pi)


def _of_the_motor_and_sensors(drive: Drive) -> dict[str, Any]:
    sensors, motor = drive.sensors, drive.motor
    counts = {name: getattr(sensors, f"{name}_encoder", None) for name in ("motor", "drive", "load")}
    gear = motor.gear_ratio if motor else None
    rotor = motor.rotor_inertia if motor else None
    sheet = {f"{name}_encoder_resolution": 2.0 * pi / n if n else None for name, n in counts.items()}
    return sheet | {
        "motor_encoder_counts_per_motor_turn": counts["motor"] / gear if counts["motor"] and gear else None,
        "reflected_rotor_inertia": rotor * gear**2 if rotor and gear else None,
    }
