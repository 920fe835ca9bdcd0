"""Belts and ropes by name: the packaged table that `[cable] type` refers to."""

import tomllib
from functools import cache
from importlib import resources
from typing import Any

from cabledrive.parameters.errors import InputRefused
from cabledrive.parameters.fields import kind_of, nearest

RIGIDITY = ("youngs_modulus", "area")


@cache
def cable_types() -> dict[str, dict[str, Any]]:
    """The table: keys of ``[cable]`` by name of the belt or rope, and ``source``."""
    text = (resources.files("cabledrive.parameters") / "cable_types.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def with_type(table: Any, place: str) -> Any:
    """A ``[cable]`` table, what it leaves out from its packaged type; an unknown type is refused."""
    if not isinstance(table, dict) or "type" not in table:
        return table
    name = table["type"]
    if not isinstance(name, str):
        raise InputRefused(f"{place}.type is {kind_of(name)}, not text: write it between quotation marks")
    if name not in cable_types():
        raise InputRefused(
            f'{place}.type = "{name[:60]}" is not in the table{nearest(name[:60], cable_types())}'
        )
    listed = {key: value for key, value in cable_types()[name].items() if key != "source"}
    if any(key in table for key in RIGIDITY):  # a rigidity of the file's own, by modulus and area
        listed.pop("axial_rigidity", None)
    return listed | table
