"""Names of a room that load the module they live in when they are first asked for."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def on_demand(room: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """The ``__getattr__`` of a room; ``homes``: module of each name, relative to the room, or its own."""

    def find(name: str) -> Any:
        if name in homes:
            module = import_module(f"{room}.{homes[name]}")
            return module if homes[name] == name else getattr(module, name)
        raise AttributeError(f"module {room!r} has no attribute {name!r}")

    return find
