"""What is recorded of a run: one row of numbers per recorded time, and what each column is.

The columns are the same for every drive and method; what a drive does not have stays zero. Behind them come
three columns (u, v, w) for each probe, the first probes being the midpoints of the spans.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from cabledrive.simulation.plan import Plan


class Channel(NamedTuple):
    """One column of the record: its name, unit and meaning."""

    name: str
    unit: str
    meaning: str


CHANNELS = (
    Channel("drive_angle", "rad", "angle of the drive pulley"),
    Channel("load_angle", "rad", "angle of the load pulley"),
    Channel("motor_angle", "rad", "angle of the motor; of the drive pulley where the joint is rigid"),
    Channel("drive_speed", "rad/s", "angular speed of the drive pulley"),
    Channel("load_speed", "rad/s", "angular speed of the load pulley"),
    Channel("motor_speed", "rad/s", "angular speed of the motor"),
    Channel("torque", "N m", "torque of the motor, offset included"),
    Channel("mean_tension_upper", "N", "tension of the upper span, mean along it"),
    Channel("mean_tension_lower", "N", "tension of the lower span, mean along it"),
    Channel("least_tension_upper", "N", "least tension of the upper span"),
    Channel("least_tension_lower", "N", "least tension of the lower span"),
    Channel("axial_energy_upper", "J", "kinetic energy of u in the upper span, guided carriages included"),
    Channel("axial_energy_lower", "J", "kinetic energy of u in the lower span, guided carriages included"),
    Channel("transverse_energy_upper", "J", "kinetic energy of v and w in the upper span"),
    Channel("transverse_energy_lower", "J", "kinetic energy of v and w in the lower span"),
    Channel("strain_energy_upper", "J", "elastic energy of the upper span above the pretensioned cable"),
    Channel("strain_energy_lower", "J", "elastic energy of the lower span above the pretensioned cable"),
    Channel("drive_energy", "J", "kinetic energy of the drive pulley"),
    Channel("load_energy", "J", "kinetic energy of the load pulley"),
    Channel("motor_energy", "J", "kinetic energy of the motor behind a flexible joint"),
    Channel("joint_energy", "J", "elastic energy of the motor joint and of the rotor's holding stiffness"),
    Channel("weight_energy", "J", "potential energy of the weight, zero for the straight cable"),
    Channel("torque_work", "J", "work of the torque since the start"),
    Channel("force_work", "J", "work of the forces on carriages since the start"),
    Channel("transverse_loss", "J", "energy lost to transverse damping since the start"),
    Channel("axial_loss", "J", "energy lost to axial damping of the cable since the start"),
    Channel("viscous_loss", "J", "energy lost to viscous friction of the shafts since the start"),
    Channel("coulomb_loss", "J", "energy lost to Coulomb friction of the shafts since the start"),
    Channel("joint_loss", "J", "energy lost to the damping of the motor joint since the start"),
    Channel("balance", "J", "energy of the method, plus losses, minus work: constant if the budget closes"),
)

COLUMN = {channel.name: number for number, channel in enumerate(CHANNELS)}
WIDTH = len(CHANNELS)

AXIAL, WEIGHT_ENERGY = COLUMN["axial_energy_upper"], COLUMN["weight_energy"]

# Tallies kept from step to step, in the order of their columns.
TORQUE_WORK, FORCE_WORK, TRANSVERSE_LOSS, AXIAL_LOSS, VISCOUS_LOSS, COULOMB_LOSS, JOINT_LOSS = range(7)
TALLIES = 7


def displacements(points: Iterable[str]) -> tuple[Channel, ...]:
    """Columns u, v, w of recorded points, by words for each."""
    names = (f"{plane} at {point}" for point in points for plane in "uvw")
    return tuple(Channel(name, "m", f"displacement {name}") for name in names)


def width_of(plan: "Plan") -> int:
    """Numbers of a row of the kernels, see `cabledrive.simulation.observe`."""
    n, motors = len(plan.mass), len(plan.motor)
    return 5 * len(plan.nodes) + 3 * len(plan.probe) + 4 + TALLIES + 2 * n + motors
