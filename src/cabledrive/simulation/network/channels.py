"""What is recorded of a network: names and units of the columns of a record."""

from cabledrive.simulation.channels import Channel
from cabledrive.simulation.network.mesh import NetworkMesh

PLANES = ("u", "v", "w")


def channels_of(mesh: NetworkMesh, motors: tuple[str, ...]) -> tuple[Channel, ...]:
    """Columns of a record, in order."""
    units = ["m" if slides(name) else "rad" for name in mesh.names]
    found = [Channel(name, unit, f"place of {name}") for name, unit in zip(mesh.names, units, strict=True)]
    found += [
        Channel(f"speed of {name}", f"{unit}/s", f"speed of {name}")
        for name, unit in zip(mesh.names, units, strict=True)
    ]
    found += [Channel(f"torque on {name}", "N m", f"torque of the motor of {name}") for name in motors]
    found += [Channel(f"mean tension, {one}", "N", f"tension of {one}, mean along it") for one in mesh.pieces]
    found += [Channel(f"least tension, {one}", "N", f"least tension of {one}") for one in mesh.pieces]
    found += [
        Channel(f"{plane} at the middle of {one}", "m", f"displacement {plane} at the middle of {one}")
        for one in mesh.pieces
        for plane in PLANES
    ]
    return (
        *found,
        Channel("rope_energy", "J", "kinetic energy of the ropes"),
        Channel("body_energy", "J", "kinetic energy of bodies, pulleys and motors"),
        Channel("strain_energy", "J", "elastic energy of the ropes above that at rest"),
        Channel("spring_energy", "J", "energy of springs and of turning bodies above that at rest"),
        Channel("torque_work", "J", "work of the torques since the start"),
        Channel("transverse_loss", "J", "energy lost to transverse damping since the start"),
        Channel("axial_loss", "J", "energy lost to axial damping of the ropes since the start"),
        Channel("viscous_loss", "J", "energy lost to bearings, bodies and joints since the start"),
        Channel("coulomb_loss", "J", "energy lost to Coulomb friction and slipping ropes since the start"),
        Channel(
            "balance", "J", "energy of the method, plus losses, minus work: constant if the budget closes"
        ),
    )


def slides(name: str) -> bool:
    """Whether a coordinate is a length."""
    return name.endswith((".x", ".y", " along", " across", " out of plane")) or name.startswith("slip at ")
