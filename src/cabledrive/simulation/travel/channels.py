"""What is recorded of a run in which bodies travel: names and units of the columns of a record."""

from cabledrive.simulation.channels import Channel
from cabledrive.simulation.network.channels import slides


def travel_channels(
    names: tuple[str, ...], motors: tuple[str, ...], spans: tuple[str, ...]
) -> tuple[Channel, ...]:
    """Columns of a record, in order."""
    units = ["m" if slides(name) else "rad" for name in names]
    both = list(zip(names, units, strict=True))
    found = [Channel(name, unit, f"place of {name} from the pose of the file") for name, unit in both]
    found += [Channel(f"speed of {name}", f"{unit}/s", f"speed of {name}") for name, unit in both]
    found += [Channel(f"torque on {name}", "N m", f"torque of the motor of {name}") for name in motors]
    found += [
        Channel(f"mean tension, {one}", "N", f"tension of {one} with its damping, mean along it")
        for one in spans
    ]
    found += [
        Channel(f"least tension, {one}", "N", f"least tension of {one} with its damping") for one in spans
    ]
    found += [Channel(f"free length, {one}", "m", f"free length of {one}") for one in spans]
    return (
        *found,
        Channel("rope_energy", "J", "kinetic energy of the ropes in their spans"),
        Channel("body_energy", "J", "kinetic energy of bodies, pulleys and motors, of drums with their rope"),
        Channel("strain_energy", "J", "elastic energy of the ropes in their spans"),
        Channel("spring_energy", "J", "energy of springs, weights and loads above that at rest"),
        Channel("torque_work", "J", "work of the torques since the start"),
        Channel("weight_work", "J", "work of the ropes' weight since the start"),
        Channel("axial_loss", "J", "energy lost to axial damping of the ropes since the start"),
        Channel("viscous_loss", "J", "energy lost to bearings, bodies and joints since the start"),
        Channel("coulomb_loss", "J", "energy lost to Coulomb friction since the start"),
        Channel("creep_loss", "J", "energy lost where rope creeps on pulleys, since the start"),
        Channel("wound_energy", "J", "energy that rope took onto rims and drums since the start"),
        Channel("balance", "J", "energies plus losses minus works: constant if the budget closes"),
    )
