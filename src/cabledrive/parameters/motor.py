"""The motor on the drive pulley's shaft, as seen at the output of its gearhead."""

from dataclasses import dataclass

from cabledrive.parameters.fields import check_fields, quantity


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """Motor and gearhead; every quantity at the output shaft unless said otherwise.

    Attributes
    ----------
    inertia : float
        Moment of inertia J11 [kg m^2], on top of the drive pulley's.
    viscous_friction, coulomb_friction : float, default 0.0
        Friction b1 [N m s/rad] and c1 [N m].
    offset_torque : float, default 0.0
        Constant torque d0 on the motor's side of the balance, Eq. (4.16) [N m].
    joint_stiffness : float or None, default None
        Stiffness k_m of the joint to the drive pulley [N m/rad]; None: rigid.
    joint_damping : float, default 0.0
        Damping b_m of the joint [N m s/rad].
    torque_limit : float or None, default None
        Largest torque [N m].
    torque_per_volt : float or None, default None
        Gain of amplifier, motor and gear [N m/V].
    speed_limit : float or None, default None
        Largest speed [rad/s].
    gear_ratio : float or None, default None
        Motor revolutions per revolution of the output shaft [-].
    rotor_inertia : float or None, default None
        Inertia of the bare rotor, at the motor's own shaft [kg m^2]; a check on `inertia`.
    holding_stiffness : float or None, default None
        Stiffness that holds the rotor where it is commanded [N m/rad]: the magnetic spring of a stepper, or
        the proportional gain of a position loop. None: no such spring.
    backlash : float, default 0.0
        Backlash of the gearhead at the output shaft [rad].
    current_bandwidth : float or None, default None
        Bandwidth of the first-order torque loop [Hz]; None: ideal.
    """

    inertia: float = quantity("kg m^2", "positive", "moment of inertia at the output shaft")
    viscous_friction: float = quantity("N m s/rad", "nonnegative", "viscous friction b1", 0.0)
    coulomb_friction: float = quantity("N m", "nonnegative", "Coulomb friction c1", 0.0)
    offset_torque: float = quantity("N m", "finite", "constant torque d0 added to the motor's", 0.0)
    joint_stiffness: float | None = quantity(
        "N m/rad", "positive", "joint stiffness k_m; absent: rigid", None
    )
    joint_damping: float = quantity("N m s/rad", "nonnegative", "joint damping b_m", 0.0)
    torque_limit: float | None = quantity("N m", "positive", "largest torque", None)
    torque_per_volt: float | None = quantity("N m/V", "positive", "gain of amplifier, motor and gear", None)
    speed_limit: float | None = quantity("rad/s", "positive", "largest speed of the output shaft", None)
    gear_ratio: float | None = quantity("1", "positive", "motor revolutions per output revolution", None)
    rotor_inertia: float | None = quantity("kg m^2", "positive", "bare rotor, at the motor's own shaft", None)
    holding_stiffness: float | None = quantity(
        "N m/rad", "positive", "spring from the rotor to its commanded angle; absent: none", None
    )
    backlash: float = quantity("rad", "nonnegative", "backlash at the output shaft", 0.0)
    current_bandwidth: float | None = quantity(
        "Hz", "positive", "first-order torque loop; absent: ideal", None
    )

    def __post_init__(self) -> None:
        check_fields(self)
