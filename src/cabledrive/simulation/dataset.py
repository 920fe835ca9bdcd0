"""A result as a labelled dataset."""

import xarray

from cabledrive.simulation.labels import Content


def dataset_of(content: Content) -> xarray.Dataset:
    """All arrays of a result over time, probe, plane, span, node and field_time, with units and meanings."""
    described = {
        variable.name: (
            variable.dimensions,
            variable.values,
            {"units": variable.unit, "long_name": variable.meaning},
        )
        for variable in (*content.coordinates, *content.variables)
    }
    numbers = {variable.name for variable in content.coordinates}
    return xarray.Dataset(
        {name: content for name, content in described.items() if name not in numbers},
        coords={name: content for name, content in described.items() if name in numbers} | content.words,
        attrs=content.attributes,
    )
