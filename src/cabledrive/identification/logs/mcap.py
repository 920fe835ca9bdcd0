"""MCAP logs (optional extra): numbers in JSON or ROS 2 messages, one topic at a time."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.table import Array, Blocks, Table, sliced
from cabledrive.identification.logs.unpacking import LARGEST_IN_MEMORY, unpacked_mcap
from cabledrive.parameters import InputRefused

MOST_MESSAGES = 5_000_000
MOST_FIELDS = 256


def open_mcap(path: Path) -> Table:
    """Open an MCAP log: columns ``topic.field``, and ``topic.log_time`` for the time of each message [s].

    Parameters
    ----------
    path : Path

    Returns
    -------
    Table

    Raises
    ------
    InputRefused
        If the extra is not installed, or the file is damaged or holds no numbers.
    """
    columns = _columns(path)
    if not columns:
        raise InputRefused(
            f"{path.name}: holds no numbers in JSON or ROS 2 messages: export it to CSV or Parquet"
        )
    units = {name: "s" for name in columns if name.endswith(".log_time")}

    def read(names: tuple[str, ...]) -> Blocks:
        if len({columns[name].size for name in names}) > 1 or len({name.split(".")[0] for name in names}) > 1:
            raise InputRefused(
                f"{path.name}: columns of several topics are sampled at different times and are not "
                "resampled: take all from one topic"
            )
        return sliced({name: columns[name] for name in names})

    return Table(source=path.name, names=tuple(columns), units=units, rows=None, read=read)


def _columns(path: Path) -> dict[str, Array]:
    try:
        from mcap.reader import make_reader
    except ImportError:
        raise InputRefused(
            f"{path.name}: reading MCAP needs an extra: pip install 'cabledrive[mcap]'"
        ) from None
    if unpacked_mcap(path) > LARGEST_IN_MEMORY:
        raise InputRefused(
            f"{path.name}: unpacks to more than {LARGEST_IN_MEMORY / 2**30:.0f} GiB: cut it into parts"
        )
    rows: dict[str, list[dict[str, float]]] = {}
    factories = _decoders()
    try:
        with path.open("rb") as stream:
            for number, (schema, channel, message) in enumerate(make_reader(stream).iter_messages()):
                if number >= MOST_MESSAGES:
                    raise InputRefused(f"{path.name}: more than {MOST_MESSAGES} messages: split it")
                decoded = _decoded(schema, channel, message, factories)
                if decoded is not None:
                    fields: dict[str, float] = {}
                    _flatten("", decoded, fields)
                    fields["log_time"] = message.log_time * 1e-9
                    rows.setdefault(channel.topic.strip("/").replace("/", "_"), []).append(fields)
    except InputRefused:
        raise
    except Exception as error:  # decoders raise many kinds for a message that is not what its schema says
        raise InputRefused(f"{path.name}: is damaged ({error}): record it again") from None
    return {
        f"{topic}.{name}": np.array([row.get(name, np.nan) for row in entries])
        for topic, entries in rows.items()
        for name in entries[0]
    }


def _decoders() -> list[Any]:
    try:
        from mcap_ros2.decoder import DecoderFactory
    except ImportError:
        return []
    return [DecoderFactory()]


def _decoded(schema: Any, channel: Any, message: Any, factories: list[Any]) -> Any:
    if channel.message_encoding == "json":
        return json.loads(message.data)
    for factory in factories:
        decode = factory.decoder_for(channel.message_encoding, schema)
        if decode is not None:
            return decode(message.data)
    return None


def _flatten(prefix: str, value: Any, into: dict[str, float]) -> None:
    """Numbers of a message by their path, arrays element by element."""
    if len(into) >= MOST_FIELDS or isinstance(value, (str, bytes)) or value is None:
        return
    if isinstance(value, (bool, int, float)):
        into[prefix] = float(value)
    elif isinstance(value, dict):
        for name, item in value.items():
            _flatten(f"{prefix}.{name}".strip("."), item, into)
    elif isinstance(value, (list, tuple)):
        for k, item in enumerate(value):
            _flatten(f"{prefix}[{k}]", item, into)
    elif hasattr(value, "__slots__"):
        for name in value.__slots__:
            _flatten(f"{prefix}.{name.lstrip('_')}".strip("."), getattr(value, name, None), into)
