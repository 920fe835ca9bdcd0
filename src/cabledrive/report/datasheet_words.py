"""The derived quantities of a drive in words, in the order in which a reader wants them."""

DATASHEET: dict[str, tuple[tuple[str, str, str], ...]] = {
    "Cable": (
        ("axial_rigidity", "Axial rigidity EA", "N"),
        ("prestrain", "Strain under the pretension, T₀/EA", "1"),
        ("cable_stiffness", "Stiffness of one span, EA/L", "N/m"),
        ("cable_mass", "Mass of the whole cable", "kg"),
        ("pulley_distance", "Span under pretension, Lₑ", "m"),
        ("axial_wave_speed", "Longitudinal wave speed", "m/s"),
        ("transverse_wave_speed", "Transverse wave speed", "m/s"),
    ),
    "Torque": (
        ("slack_torque", "Slack torque at the drive pulley", "N m"),
        ("no_slip_torque_drive", "Slip torque at the drive pulley", "N m"),
        ("no_slip_torque_load", "Slip torque at the load pulley", "N m"),
    ),
    "At rest": (
        ("lowest_static_tension", "Lowest tension at rest", "N"),
        ("static_sag", "Largest sag of a free stretch, tension kept at T₀", "m"),
        ("irvine_parameter", "Irvine parameter λ²; sag is small well below 1", "1"),
    ),
    "Inertias": (
        ("chi1", "Drive pulley over cable, χ₁ = J₁/(r₁² m)", "1"),
        ("chi2", "Load pulley over cable, χ₂ = J₂/(r₂² m)", "1"),
        ("reflected_rotor_inertia", "Rotor through the gear, at the output shaft", "kg m^2"),
    ),
    "Estimates with a massless cable": (
        ("cable_mode_frequency_hz", "Lowest mode of pulleys and carriages, motor joint rigid", "Hz"),
        ("joint_mode_frequency_hz", "Motor against drive pulley", "Hz"),
    ),
    "Lowest longitudinal frequency": (
        ("lowest_frequency_free_hz", "Motor free (without a motor: drive pulley free)", "Hz"),
        ("lowest_frequency_held_hz", "Motor held (without a motor: drive pulley held)", "Hz"),
        ("lowest_frequency_holding_hz", "Motor on its holding stiffness", "Hz"),
    ),
    "Resolution": (
        ("motor_encoder_resolution", "Motor encoder, one count at the output shaft", "rad"),
        ("drive_encoder_resolution", "Drive encoder, one count", "rad"),
        ("load_encoder_resolution", "Load encoder, one count", "rad"),
    ),
}
"""For each heading: name in `DerivedQuantities` or `LowestFrequencies`, words, SI unit."""
