"""The methods by name."""

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.simulation.energy_conserving import EnergyConserving
from cabledrive.simulation.method import Method
from cabledrive.simulation.node_centred import NodeCentred
from cabledrive.simulation.verlet import StoermerVerlet

METHODS: dict[str, Method] = {
    method.name: method for method in (StoermerVerlet(), NodeCentred(), EnergyConserving())
}


def method_named(name: str) -> Method:
    """Method of a name.

    Raises `InputRefused` if there is none of that name.
    """
    if name not in METHODS:
        raise InputRefused(f'method = "{name}" is not one of its values{nearest(name, METHODS)}')
    return METHODS[name]
