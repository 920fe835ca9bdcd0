"""MCAP logs (optional extra): numbers in JSON or ROS 2 messages, by topic."""

import json
from pathlib import Path
from typing import Any

from cabledrive.identification.logs.messages import Topics
from cabledrive.identification.logs.table import Reading, Table
from cabledrive.identification.logs.unpacking import require_fitting, unpacked_mcap
from cabledrive.parameters import InputRefused


def open_mcap(path: Path, reading: Reading | None = None) -> Table:
    """Open an MCAP log: columns ``topic.field``, ``topic.log_time`` and, where given, ``topic.header.stamp``.

    Returns times in seconds from the first of their kind in the file.
    Raises `InputRefused` if the extra is not installed, or the file is damaged or holds no numbers.
    """
    try:
        from mcap.reader import make_reader
    except ImportError:
        raise InputRefused(
            f"{path.name}: reading MCAP needs an extra: pip install 'cabledrive[mcap]'"
        ) from None
    require_fitting(path, unpacked_mcap(path))
    topics = Topics(source=path.name)
    factories = _decoders()
    try:
        with path.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages():
                decoded = _decoded(schema, channel, message, factories)
                if decoded is not None:
                    topics.add(channel.topic, message.log_time, decoded)
    except (InputRefused, MemoryError):
        raise
    except Exception as error:  # decoders raise many kinds for a message that is not what its schema says
        raise InputRefused(f"{path.name}: is damaged ({error}): record it again") from None
    if not topics.columns:
        raise InputRefused(
            f"{path.name}: holds no numbers in JSON or ROS 2 messages: export it to CSV or Parquet"
        )
    return topics.table(reading)


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
