"""Hypothesis strategies: what can be done to a valid drive file."""

import copy
import datetime
import tomllib
from pathlib import Path

import tomli_w
from hypothesis import strategies as st

from cabledrive.parameters import drive_text, load_drive, packaged_drives

EXAMPLE = Path(__file__).parent / "parameters" / "contract_example.toml"
DRIVES = [load_drive(source) for source in (*packaged_drives("loop", "line"), EXAMPLE)]
FILES = [EXAMPLE.read_bytes(), *[drive_text(drive).encode() for drive in DRIVES]]
TABLES = [tomllib.loads(content.decode()) for content in FILES]

odd_numbers = st.sampled_from(
    [0, -1, -0.0, 1e-320, 1e308, 1e400, 2**63, 10**400, float("nan"), float("-inf")]
)
odd_texts = st.sampled_from(
    ["", "5", "5 kg", "50 Hz", "nan N", "1e999 m", "7 N\n", "\x00", "5 N^9", "x" * 3000, "-3 %"]
)
odd_times = st.sampled_from(
    [datetime.date(1979, 5, 27), datetime.time(7, 32), datetime.datetime(1979, 5, 27, 7, 32)]
)
plain = st.one_of(
    odd_numbers, odd_texts, odd_times, st.booleans(), st.integers(), st.floats(), st.text(max_size=20)
)
keys = st.sampled_from(
    ["pretension", "radius", "position", "cable", "", "a.b", "\x1b[31m", "k" * 400]
) | st.text(max_size=9)
values = st.recursive(
    plain, lambda v: st.lists(v, max_size=3) | st.dictionaries(keys, v, max_size=3), max_leaves=6
)


def tables_of(data):
    """Every table of plain data, the outermost first."""
    found = [data]
    for table in found:
        for value in table.values():
            rows = value if isinstance(value, list) else [value]
            found += [row for row in rows if isinstance(row, dict)]
    return found


@st.composite
def mutants(draw):
    """Keys dropped, renamed or added, values replaced, tables moved into one another."""
    data = copy.deepcopy(draw(st.sampled_from(TABLES)))
    for _ in range(draw(st.integers(1, 3))):
        table = draw(st.sampled_from(tables_of(data)))
        key = draw(st.sampled_from(sorted(table)) | keys if table else keys)
        deed = draw(st.sampled_from(["drop", "rename", "replace", "nest", "double"]))
        old = table.pop(key, None)
        if deed == "rename":
            table[draw(keys)] = old if old is not None else 1
        elif deed == "replace":
            table[key] = draw(values)
        elif deed == "nest":
            table[key] = {key: old} if old is not None else {}
        elif deed == "double":
            table[key] = [old, old] if old is not None else []
    return tomli_w.dumps(data).encode("utf-8")
