"""`cabledrive check`: whether a drive file is valid, what follows from it, and what looks odd."""

import click

from cabledrive.app.options import Subcommand, answering, drive_argument, saves_answer
from cabledrive.app.results import Answer, provenance
from cabledrive.mechanics.datasheet import DerivedQuantities, derived_quantities
from cabledrive.mechanics.warnings import practitioner_warnings
from cabledrive.parameters import Drive, content_hash

METHOD = "closed formulas of the datasheet"
LINES = {
    "prestrain": ("prestrain T0 / EA", "1"),
    "axial_rigidity": ("axial rigidity EA", "N"),
    "axial_wave_speed": ("axial wave speed", "m/s"),
    "transverse_wave_speed": ("transverse wave speed", "m/s"),
    "span_length": ("span, unstretched", "m"),
    "pulley_distance": ("span, under pretension", "m"),
    "cable_mass": ("mass of the cable", "kg"),
    "cable_stiffness": ("stiffness of a span, EA / L", "N/m"),
    "lumped_cable_stiffness": ("stiffness of a span, measured", "N/m"),
    "chi1": ("drive pulley over cable, chi1", "1"),
    "chi2": ("load pulley over cable, chi2", "1"),
    "slack_torque": ("torque at which a span goes slack", "N m"),
    "no_slip_torque_drive": ("torque at which the drive pulley slips", "N m"),
    "no_slip_torque_load": ("torque at which the load pulley slips", "N m"),
    "lowest_static_tension": ("lowest tension at rest", "N"),
    "static_sag": ("sag, tension kept at T0", "m"),
    "static_sag_held": ("sag between held pulleys", "m"),
    "irvine_parameter": ("Irvine parameter", "1"),
    "transverse_frequency_hz": ("lowest mode of an empty span", "Hz"),
    "cable_mode_frequency_hz": ("cable mode, lumped estimate", "Hz"),
    "joint_mode_frequency_hz": ("motor joint mode, lumped estimate", "Hz"),
    "motor_encoder_resolution": ("motor encoder, one count", "rad"),
    "drive_encoder_resolution": ("drive encoder, one count", "rad"),
    "load_encoder_resolution": ("load encoder, one count", "rad"),
    "motor_encoder_counts_per_motor_turn": ("motor encoder, counts per motor turn", "1"),
    "reflected_rotor_inertia": ("rotor through the gear", "kg m^2"),
}


@click.command(cls=Subcommand, example='cabledrive check elevator --set cable.pretension="20 kN"')
@answering
@saves_answer
@drive_argument
def command(drive: Drive) -> Answer:
    """Check DRIVE: is the file valid, what follows from it, and what would a practitioner look at twice."""
    derived, warnings = derived_quantities(drive), practitioner_warnings(drive)
    return Answer(
        data={
            "valid": True,
            "drive_hash": content_hash(drive),
            "derived": derived.as_dict(),
            "warnings": warnings,
        },
        text=_text(drive, derived, warnings),
        provenance=provenance(drive, method=METHOD),
    )


def _text(drive: Drive, derived: DerivedQuantities, warnings: tuple[str, ...]) -> str:
    from cabledrive.report.numbers import quantity

    width = max(len(label) for label, _ in LINES.values())
    values = [(label, getattr(derived, name), unit) for name, (label, unit) in LINES.items()]
    lines = [
        f"{label:<{width}}  {quantity(value, unit)}" for label, value, unit in values if value is not None
    ]
    findings = [f"Warning: {line}." for line in warnings] or ["Nothing stands out."]
    head = [drive.title or drive.name, f"valid; content hash {content_hash(drive)}"]
    return "\n".join([*head, "", *lines, "", *findings])
