"""What is recorded of a run: one row of numbers per recorded time, and what each column is."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from cabledrive.simulation.plan import Plan


class Channel(NamedTuple):
    """One column of the record: its name, unit and meaning."""

    name: str
    unit: str
    meaning: str


# Tallies kept from step to step, in the order of their columns.
TORQUE_WORK, FORCE_WORK, TRANSVERSE_LOSS, AXIAL_LOSS, VISCOUS_LOSS, COULOMB_LOSS, JOINT_LOSS = range(7)
TALLIES = 7


def displacements(points: Iterable[str]) -> tuple[Channel, ...]:
    """Columns u, v, w of recorded points, by words for each."""
    names = (f"{plane} at {point}" for point in points for plane in "uvw")
    return tuple(Channel(name, "m", f"displacement {name}") for name in names)


def channels_of(
    names: tuple[str, ...],
    motors: tuple[str, ...],
    spans: tuple[str, ...],
    pushed: Sequence[str] = (),
    points: Sequence[str] = (),
    travels: bool = False,
) -> tuple[Channel, ...]:
    """Columns of a record; coordinates with forces, points of spans, whether lengths follow the bodies."""
    pose, damped = (" from the pose of the file", " with its damping") if travels else ("", "")
    both = [(name, "m" if slides(name) else "rad") for name in names]
    found = [Channel(name, unit, f"place of {name}{pose}") for name, unit in both]
    found += [Channel(speed_name(name), f"{unit}/s", f"speed of {name}") for name, unit in both]
    found += [Channel(f"torque on {name}", "N m", f"torque of the motor of {name}") for name in motors]
    found += [Channel(f"force on {name}", "N", f"force on {name}") for name in pushed]
    mean = [(one, f"tension of {one}{damped}, mean along it") for one in spans]
    found += [Channel(f"mean tension, {one}", "N", words) for one, words in mean]
    found += [Channel(f"least tension, {one}", "N", f"least tension of {one}{damped}") for one in spans]
    if travels:
        found += [Channel(f"free length, {one}", "m", f"free length of {one}") for one in spans]
    found += displacements(points)
    energies = _TRAVELLING if travels else _STANDING
    return (*found, *(Channel(name, "J", words) for name, words in energies))


_SINCE = "since the start"
_STANDING = (
    ("rope_energy", "kinetic energy of the ropes"),
    ("body_energy", "kinetic energy of bodies, pulleys and motors"),
    ("strain_energy", "energy of the ropes above that at rest, elastic and of their weight"),
    ("spring_energy", "energy of springs and of turning bodies above that at rest"),
    ("torque_work", f"work of the torques, and of forces on carriages, {_SINCE}"),
    ("transverse_loss", f"energy lost to transverse damping {_SINCE}"),
    ("axial_loss", f"energy lost to axial damping of the ropes {_SINCE}"),
    ("viscous_loss", f"energy lost to bearings, bodies and joints {_SINCE}"),
    ("coulomb_loss", f"energy lost to Coulomb friction and slipping ropes {_SINCE}"),
    ("balance", "energy of the method, plus losses, minus work: constant if the budget closes"),
)
_TRAVELLING = (
    ("rope_energy", "kinetic energy of the ropes in their spans"),
    ("body_energy", "kinetic energy of bodies, pulleys and motors, of drums with their rope"),
    ("strain_energy", "elastic energy of the ropes in their spans"),
    ("spring_energy", "energy of springs, weights and loads above that at rest"),
    ("torque_work", f"work of the torques {_SINCE}"),
    ("weight_work", f"work of the ropes' weight {_SINCE}"),
    ("axial_loss", f"energy lost to axial damping of the ropes {_SINCE}"),
    ("viscous_loss", f"energy lost to bearings, bodies and joints {_SINCE}"),
    ("coulomb_loss", f"energy lost to Coulomb friction {_SINCE}"),
    ("creep_loss", f"energy lost where rope creeps on pulleys, {_SINCE}"),
    ("wound_energy", f"energy that rope took onto rims and drums {_SINCE}"),
    ("balance", "energies plus losses minus works: constant if the budget closes"),
)


def speed_name(name: str) -> str:
    """What records call the speed of a coordinate."""
    return name.replace("_angle", "_speed") if name.endswith("_angle") else f"speed of {name}"


def slides(name: str) -> bool:
    """Whether a coordinate is a length."""
    return name.endswith((".x", ".y", " along", " across", " out of plane")) or name.startswith("slip at ")


def width_of(plan: "Plan") -> int:
    """Numbers of a row of the kernels, see `cabledrive.simulation.observe`."""
    n, motors = len(plan.mass), len(plan.motor)
    return 5 * len(plan.nodes) + 3 * len(plan.probe) + 4 + TALLIES + 2 * n + motors
