"""A result as a labelled dataset."""

import xarray

from cabledrive.simulation.labels import attributes, coordinates, variables, words
from cabledrive.simulation.result import SimulationResult


def dataset_of(result: SimulationResult) -> xarray.Dataset:
    """All arrays of a result with their dimensions, units and meanings.

    Returns dimensions time, probe, plane, span, node, field_time; every array with `units` and `long_name`.
    """
    described = {
        variable.name: (
            variable.dimensions,
            variable.values,
            {"units": variable.unit, "long_name": variable.meaning},
        )
        for variable in (*coordinates(result), *variables(result))
    }
    numbers = {variable.name for variable in coordinates(result)}
    return xarray.Dataset(
        {name: content for name, content in described.items() if name not in numbers},
        coords={name: content for name, content in described.items() if name in numbers} | words(result),
        attrs=attributes(result),
    )
