"""ROS 2 bags in SQLite, ``.db3`` (optional extra): numbers in messages, by topic."""

from pathlib import Path
from typing import Any

from cabledrive.identification.logs.messages import Topics
from cabledrive.identification.logs.table import Reading, Table
from cabledrive.identification.logs.unpacking import require_fitting
from cabledrive.parameters import InputRefused


def open_rosbag(path: Path, reading: Reading | None = None) -> Table:
    """Open a ROS 2 bag: columns ``topic.field``, ``topic.log_time`` and, where given, ``topic.header.stamp``.

    Message types come from the bag where it holds them (ROS 2 Iron and later), else from those of ROS 2
    Humble; topics of other types are left out.

    Raises `InputRefused` if the extra is not installed, or the bag holds no numbers.
    """
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputRefused(
            f"{path.name}: reading ROS 2 bags needs an extra: pip install 'cabledrive[ros2]'"
        ) from None
    require_fitting(path, path.stat().st_size)
    if any(sign in str(path) for sign in "?#%"):  # parts of the address by which SQLite opens a file
        raise InputRefused(f"{path}: SQLite takes no ?, # or % in a path: rename it")
    types, topics = get_typestore(Stores.ROS2_HUMBLE), Topics(source=path.name)
    left_out: set[str] = set()
    with Reader(path) as bag:
        known = {connection.id: _learnt(connection, types) for connection in bag.connections}
        for connection, when, data in bag.messages():
            if known[connection.id]:
                topics.add(connection.topic, when, types.deserialize_cdr(data, connection.msgtype))
            else:
                left_out.add(connection.msgtype)
    if not topics.columns:
        missing = f" of a known type (not: {', '.join(sorted(left_out))[:80]})" if left_out else ""
        raise InputRefused(f"{path.name}: holds no numbers in messages{missing}: export it to CSV or Parquet")
    return topics.table(reading)


def _learnt(connection: Any, types: Any) -> bool:
    """Whether the type of a topic is known, once its definition in the bag is read."""
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    if connection.msgtype in types.types:
        return True
    definition = getattr(connection.msgdef, "data", "")
    if not definition:
        return False
    form = str(connection.msgdef.format.name)
    found = (
        get_types_from_idl(definition)
        if form == "IDL"
        else get_types_from_msg(definition, connection.msgtype)
    )
    types.register({name: kind for name, kind in found.items() if name not in types.types})
    return connection.msgtype in types.types
