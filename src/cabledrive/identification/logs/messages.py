"""Messages of topics as columns: MCAP files and ROS 2 bags."""

import json
import struct
from array import array
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from cabledrive.identification.logs.log import LARGEST_IN_MEMORY, ColumnMap, Table, require_fitting, sliced
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

MOST_MESSAGES = 5_000_000
MOST_FIELDS = 256
MOST_NUMBERS = 100_000_000
"""Numbers of all messages together that are kept; 8 bytes each."""
LOG_TIME, STAMP = "log_time", "header.stamp"
PARTS = ("sec", "secs"), ("nanosec", "nsec", "nsecs")
"""Names of the whole seconds of a stamp, and of the nanoseconds beside them."""


@dataclass(kw_only=True, eq=False)
class Topics:
    """Columns of every topic, grown message by message."""

    source: str  # name of the file
    # by ``topic.field``; a field that a message lacks is NaN
    columns: dict[str, "array[float]"] = field(default_factory=dict)
    rows: dict[str, int] = field(default_factory=dict)  # messages of each topic
    # first log time and first stamp of the file [ns], taken off before a double rounds them
    origins: dict[str, int] = field(default_factory=dict)
    messages: int = 0
    numbers: int = 0

    def add(self, topic: str, log_time: int, message: Any) -> None:
        """Add one message, a mapping or an object with slots or fields; ``log_time`` [ns]."""
        topic = topic.strip("/").replace("/", "_")
        fields: dict[str, float] = {}
        flatten("", message, fields)
        fields[LOG_TIME] = 1e-9 * (log_time - self.origins.setdefault(LOG_TIME, log_time))
        seconds, rest = (
            next((fields[f"{STAMP}.{n}"] for n in names if f"{STAMP}.{n}" in fields), 0.5) for names in PARTS
        )
        if seconds.is_integer() and rest.is_integer():  # when the sensor was read [ns]
            stamp = int(seconds) * 1_000_000_000 + int(rest)
            fields[STAMP] = 1e-9 * (stamp - self.origins.setdefault(STAMP, stamp))
        row = self.rows.get(topic, 0)
        self.messages += 1
        self.numbers += len(fields)
        if self.messages > MOST_MESSAGES or self.numbers > MOST_NUMBERS:
            raise InputRefused(f"{self.source}: more than {self.messages - 1} messages: split it")
        for name, value in fields.items():
            column = self.columns.setdefault(f"{topic}.{name}", array("d"))
            if len(column) < row:
                column.extend([np.nan] * (row - len(column)))
            column.append(value)
        self.rows[topic] = row + 1

    def table(self, resample: bool) -> Table:
        """All topics as one table."""
        arrays = {}
        for name, column in self.columns.items():
            missing = self.rows[_topic(name, self.rows)] - len(column)
            arrays[name] = np.append(np.frombuffer(column), np.full(missing, np.nan))
        units = {name: "s" for name in arrays if name.endswith((f".{LOG_TIME}", f".{STAMP}"))}
        return Table(
            source=self.source,
            names=tuple(arrays),
            units=units,
            rows=max(self.rows.values(), default=0),
            read=lambda names: sliced(self._joined(arrays, names, resample)),
        )

    def _joined(self, arrays: dict[str, Array], names: tuple[str, ...], resample: bool) -> dict[str, Array]:
        """Columns of one topic; those of others at the times of the topic of the time, if asked."""
        topics = list(dict.fromkeys(_topic(name, self.rows) for name in names))
        if len(topics) == 1:
            return {name: arrays[name] for name in names}
        times = [name for name in names if name.endswith((f".{LOG_TIME}", f".{STAMP}"))]
        if not resample or len(times) != 1:
            raise InputRefused(
                f"{self.source}: columns of several topics ({', '.join(topics)}) are sampled at different "
                "times: take all from one topic, or say --resample, with the time of one of them"
            )
        kind, time = STAMP if times[0].endswith(STAMP) else LOG_TIME, arrays[times[0]]
        others = {topic: arrays.get(f"{topic}.{kind}", np.empty(0)) for topic in topics}
        for topic, own in others.items():
            if not own.size or not np.isfinite(own).all() or (np.diff(own) <= 0.0).any():
                said = f"{self.source}: the topic {topic} has no {kind} that ascends"
                raise InputRefused(f"{said}: take the other time, or one topic")
        first, last = (max(own[0] for own in others.values()), min(own[-1] for own in others.values()))
        both = time[(time >= first) & (time <= last)]
        if both.size < 3:
            raise InputRefused(f"{self.source}: {' and '.join(topics)} do not overlap in {kind}: take one")
        stamps = {name: others[_topic(name, self.rows)] for name in names}
        return {name: np.asarray(np.interp(both, stamps[name], arrays[name])) for name in names}


def flatten(prefix: str, value: Any, into: dict[str, float]) -> None:
    """Numbers of a message by their path, arrays element by element, into what grows up to `MOST_FIELDS`."""
    if len(into) >= MOST_FIELDS or isinstance(value, (str, bytes)) or value is None:
        return
    if isinstance(value, (bool, int, float, np.number)):
        into[prefix] = float(value)
    elif isinstance(value, dict):
        for name, item in value.items():
            flatten(f"{prefix}.{name}".strip("."), item, into)
    elif isinstance(value, (list, tuple, np.ndarray)):
        for k, item in enumerate(value[:MOST_FIELDS]):
            flatten(f"{prefix}[{k}]", item, into)
    else:
        fields: Any = getattr(value, "__dataclass_fields__", None) or getattr(value, "__slots__", ())
        for name in fields:
            if not name.startswith("__"):
                flatten(f"{prefix}.{name.lstrip('_')}".strip("."), getattr(value, name, None), into)


def _topic(name: str, rows: dict[str, int]) -> str:
    """Topic of a column; topics may hold dots themselves."""
    return max((topic for topic in rows if name.startswith(f"{topic}.")), key=len)


CHUNK = 6
"""Opcode of a chunk of an MCAP file."""
LZ4_RATIO = 255
"""Bytes that one byte of LZ4 can unpack to."""


def unpacked_mcap(path: Path, limit: int = LARGEST_IN_MEMORY) -> int:
    """Bytes of the chunks of an MCAP file unpacked, as heads state them and LZ4 allows, to a limit."""
    total, end = 0, path.stat().st_size
    with path.open("rb") as file:
        file.seek(8)
        while total <= limit and len(head := file.read(9)) == 9:
            code, size = struct.unpack("<BQ", head)
            after = min(file.tell() + size, end)
            if code == CHUNK and len(start := file.read(32)) == 32:
                stated = struct.unpack("<QQQII", start)
                scheme = file.read(min(stated[4], 16))
                total += max(stated[2], size if scheme == b"" else 0)
                if scheme == b"lz4" and stated[2] > LZ4_RATIO * size:
                    return limit + 1
            file.seek(after)
    return total


def open_mcap(path: Path, reading: ColumnMap) -> Table:
    """Open an MCAP log: columns ``topic.field``, ``topic.log_time``, ``topic.header.stamp``, from 0 s on."""
    try:
        from mcap.reader import make_reader
    except ImportError:
        raise InputRefused(f"{path.name}: MCAP needs an extra: pip install 'cabledrive[mcap]'") from None
    require_fitting(path, unpacked_mcap(path))
    topics, factories = Topics(source=path.name), []
    with suppress(ImportError):
        from mcap_ros2.decoder import DecoderFactory

        factories = [DecoderFactory()]
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            decoded = json.loads(message.data) if channel.message_encoding == "json" else None
            for factory in factories:
                if decode := factory.decoder_for(channel.message_encoding, schema):
                    decoded = decode(message.data)
            if decoded is not None:
                topics.add(channel.topic, message.log_time, decoded)
    if not topics.columns:
        raise InputRefused(f"{path.name}: holds no numbers in JSON or ROS 2 messages: export it to CSV")
    return topics.table(reading.resample)


def open_rosbag(path: Path, reading: ColumnMap) -> Table:
    """Open a ROS 2 bag, with columns as of an MCAP log; topics of unknown types are left out."""
    try:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputRefused(f"{path.name}: ROS 2 bags need an extra: pip install 'cabledrive[ros2]'") from None
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
    return topics.table(reading.resample)


def _learnt(connection: Any, types: Any) -> bool:
    """Whether the type of a topic is known, once its definition in the bag is read."""
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    if connection.msgtype in types.types:
        return True
    definition = getattr(connection.msgdef, "data", "")
    if not definition:
        return False
    if str(connection.msgdef.format.name) == "IDL":
        found = get_types_from_idl(definition)
    else:
        found = get_types_from_msg(definition, connection.msgtype)
    types.register({name: kind for name, kind in found.items() if name not in types.types})
    return connection.msgtype in types.types
