"""What is measured, what a measurement said where it differs from theory, and what is asked for."""

from dataclasses import dataclass

from cabledrive.parameters.fields import check_fields, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Lumped:
    """Spring and damper of one span as fitted to a measured response, Table 6.2.

    Attributes
    ----------
    cable_stiffness : float or None, default None
        Stiffness k of one span [N/m]; None: EA / L.
    cable_damping : float or None, default None
        Damping b_c of one span, force per relative pulley speed [N s/rad]; None: from `Cable.axial_damping`.
    """

    cable_stiffness: float | None = quantity("N/m", "positive", "stiffness k of one span", None)
    cable_damping: float | None = quantity("N s/rad", "nonnegative", "damping b_c of one span", None)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensors:
    """Encoders, load cell and sampling.

    Attributes
    ----------
    motor_encoder, drive_encoder, load_encoder : int or None, default None
        Counts per revolution, at the output shaft, drive pulley and load pulley; None: not fitted.
    load_cell_noise : float or None, default None
        Standard deviation of the tension measurement [N].
    sample_rate : float or None, default None
        Samples per second [Hz].
    delay : float, default 0.0
        Time from sampling to torque [s].
    """

    motor_encoder: int | None = quantity(
        "count", "positive", "counts per revolution at the output shaft", None
    )
    drive_encoder: int | None = quantity(
        "count", "positive", "counts per revolution at the drive pulley", None
    )
    load_encoder: int | None = quantity("count", "positive", "counts per revolution at the load pulley", None)
    load_cell_noise: float | None = quantity("N", "nonnegative", "standard deviation of the tension", None)
    sample_rate: float | None = quantity("Hz", "positive", "samples per second", None)
    delay: float = quantity("s", "nonnegative", "from sampling to torque", 0.0)

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Goal:
    """What the drive is asked to do, so that `check` can say what stands in the way.

    Attributes
    ----------
    tracking_error : float or None, default None
        Largest error of the load angle that is allowed [rad].
    """

    tracking_error: float | None = quantity(
        "rad", "positive", "largest error of the load angle allowed", None
    )

    def __post_init__(self) -> None:
        check_fields(self)
