"""What the arrays of a controller.json mean, and what the columns of its reference are called."""

from cabledrive.control.numbers import DARC, LEARNING, LINEAR, OWN, REFERENCE_MODEL, SCHEDULED, LawNumbers

ARRAYS = {
    "law.matrix": (
        "darc: angles and speeds to z and its derivatives; linear: next memory from memory, errors, "
        "last command; backstepping: feedback by step and error"
    ),
    "law.rows": (
        "darc: sliding surface, elastic torque, inertial acceleration in powers of s; linear: command "
        "from memory and errors; learning: the same, then what whitens the innovations; scheduled: one for "
        "each load, heaviest first; backstepping: scales of the states"
    ),
    "law.learning": (
        "rows: nominal value, lower bound, upper bound, adaptation gain, rate limit of each estimate"
    ),
    "law.scalars": (
        "sample time s; K_sigma; K of tanh(K w) s/rad; friction by reference; regressor by reference; "
        "mu; beta_n; learning: sample time s; kept share of an excited direction, gate in deviations, "
        "renewal; scheduled: sample time s, one over the heaviest load, step of it between points, Coulomb "
        "friction N m, K of tanh(K w) s/rad"
    ),
    "filter.chosen": "which filter states are the angles, then the speeds of the law's shafts",
    "filter.places": "filter states that are the motor's speed and the disturbance torque",
    "filter.model": (
        "transition; then inputs: shaft torque, command before and after the delay, friction and offset"
    ),
    "filter.output": "readings from filter states",
    "filter.gains": "correction per reading, on which the filter settles; by load: of each point",
    "filter.scalars": (
        "sample time s; unused; shaft torque from itself, older and newer command; Coulomb friction N "
        "m; K of tanh(K w) s/rad; offset torque N m; whether the disturbance is cancelled; by load: one over "
        "the heaviest load, step in one over the load between points"
    ),
    "reference.taps": "delay s and weight of each copy of the motion",
    "reference.lags": "first-order filters: share of the newest value, of the last value, fading",
    "reference.sources": "stage that each filter takes; 0: the motion",
    "reference.output": (
        "row from all stages, each the load angle and its derivatives rad/s^k at the first shaft"
    ),
    "reference.constant": "added to the row",
    "reference.friction": "Coulomb friction N m and slope s/rad of each c tanh(K w) added to a column",
    "reference.places": "that column, and the column of the speed w",
    "reference.load.sign": "weights of the sign of the speed over the samples around, for it and derivatives",
    "reference.load.lags": "filters of the chain's dampers, as reference.lags",
    "reference.load.sources": "stage that each takes; 0: the torque at the load",
    "reference.load.output": "angles, speeds, motor torque from all stages, each the torque and derivatives",
    "reference.load.transition": "of the filter's error; last column: from a torque at the load",
    "reference.load.seen": "readings from the filter's error",
    "reference.load.gains": "correction per reading",
    "reference.load.chosen": "states of the filter that the law takes",
    "reference.load.white": "what makes innovations white and of variance 1",
    "reference.load.scalars": "sample time s; K of tanh(K w / largest w)",
}

REGRESSOR = (
    "adapted_inertia [rad/s^2]",
    "adapted_viscous [rad/s]",
    "adapted_coulomb [1]",
    "adapted_offset [1]",
)
"""Functions of the reference that carry the adapted factors of a reference-model law."""

ANNOUNCED = "announced_load [1]"
"""Inertia of the load over that of the drive: what firmware writes, and the generator leaves at 1."""

LEARNT = (("friction", "/(N m)"), ("viscous", "/(N m s/rad)"), ("inertia", "/(kg m^2)"))
"""What a law learns of the load, and the unit of what goes with a unit of it."""


def reference_columns(
    law: LawNumbers, shafts: tuple[str, ...], width: int, *, motion: bool = False
) -> list[str]:
    """Names with units of the columns of a law's reference; ``motion``: load angle and derivatives alone."""
    if motion:
        return [f"load_angle_{k} [rad/s^{k}]" for k in range(width)]
    if law.kind in (LINEAR, REFERENCE_MODEL, OWN):
        angles = [f"{shaft}_angle [rad]" for shaft in shafts]
        names = [*angles, *(f"{shaft}_speed [rad/s]" for shaft in shafts), "torque [N m]"]
        return [*names, *REGRESSOR][:width]
    if law.kind == LEARNING:
        followed = 2 * len(shafts) + 1
        names, readings = reference_columns(law._replace(kind=LINEAR), shafts, followed), len(law.rows) - 1
        for learnt, unit in LEARNT:
            for shaft in shafts:
                names.append(f"{learnt}_{shaft}_angle [rad{unit}]")
            for shaft in shafts:
                names.append(f"{learnt}_{shaft}_speed [rad/s{unit}]")
            names.append(f"{learnt}_torque [N m{unit}]")
            names += [f"{learnt}_innovation_{i + 1} [1{unit}]" for i in range(readings)]
        return names[:width]
    if law.kind == SCHEDULED:
        own = reference_columns(law._replace(kind=LINEAR), shafts, 2 * len(shafts) + 1)
        return [*own, *(f"{name} for each further load" for name in own), ANNOUNCED]
    if law.kind == DARC:
        flat = [f"flat_output_{k} [rad/s^{k}]" for k in range(width - 2)]
        return [*flat, "motor_speed [rad/s]", "motor_acceleration [rad/s^2]"]
    n = len(shafts)
    names = [f"load_angle_{k} [rad/s^{k}]" for k in range(min(width, 2 * n + 1))]
    for j in range(1, n + 1):
        names += [f"known_acceleration_{j}_{k} [scaled]" for k in range(2 * (n - j) + 1)]
    return [*names, "motor_speed [rad/s]"][:width]
