"""Whatever is done to a valid drive file, it loads or is refused in one line: nothing else ever happens."""

import copy
import datetime
import tomllib
from pathlib import Path

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from cabledrive.parameters import Drive, InputRefused, drive_text, load_drive, packaged_drives

EXAMPLE = Path(__file__).with_name("contract_example.toml")
DRIVES = [load_drive(source) for source in (*packaged_drives(), EXAMPLE)]
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


def message_of_refusal(path, **options):
    """Load the file: the refusal's message, or nothing if it is a drive."""
    try:
        assert isinstance(load_drive(path, **options), Drive)
    except InputRefused as refusal:
        return str(refusal)
    return None


def check(content, tmp_path_factory, **options):
    """The claim of this file."""
    path = tmp_path_factory.getbasetemp() / "mutant.toml"
    path.write_bytes(content)
    message = message_of_refusal(path, **options)
    if message is not None:
        assert message.isprintable(), f"{message!r}"
        assert len(message) < 300, f"{len(message)} characters: {message}"
        assert message.startswith(f"{path}: ")


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


@given(content=mutants())
@settings(max_examples=500)
def test_any_change_of_keys_and_values_loads_or_is_refused(content, tmp_path_factory):
    check(content, tmp_path_factory)


@given(
    content=st.sampled_from(FILES),
    flips=st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=6),
)
@settings(max_examples=500)
def test_any_flip_of_bytes_loads_or_is_refused(content, flips, tmp_path_factory):
    mutant = bytearray(content)
    for place, byte in flips:
        mutant[place % len(mutant)] = byte
    check(bytes(mutant), tmp_path_factory)


@given(content=st.sampled_from(FILES), data=st.data())
@settings(max_examples=300)
def test_any_cut_and_splice_of_lines_loads_or_is_refused(content, data, tmp_path_factory):
    """Lines dropped, doubled and swapped: sections twice, keys under the wrong head."""
    lines = content.splitlines(keepends=True)
    order = data.draw(st.lists(st.integers(0, len(lines) - 1), max_size=2 * len(lines)))
    check(b"".join(lines[n] for n in order), tmp_path_factory)


@given(content=st.binary(max_size=200))
@settings(max_examples=200)
def test_any_bytes_load_or_are_refused(content, tmp_path_factory):
    check(content, tmp_path_factory)


places = st.lists(
    st.sampled_from(["cable", "pulley", "carriage", "0", "1", "pretension", "radius"]) | keys, max_size=4
)
settings_texts = st.builds(
    lambda place, value: f"{'.'.join(place)}={value}",
    places,
    st.one_of(st.text(max_size=20), odd_texts, values.map(str)),
)


@given(overrides=st.lists(settings_texts | st.text(max_size=20), min_size=1, max_size=3))
@settings(max_examples=500)
def test_any_setting_loads_or_is_refused(overrides, tmp_path_factory):
    check(FILES[0], tmp_path_factory, overrides=overrides)


@given(path=st.text(max_size=300))
@settings(max_examples=200)
def test_any_path_loads_or_is_refused(path, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.getbasetemp())
        message = message_of_refusal(path)
    assert message is None or (message.isprintable() and len(message) < 300), f"{message!r}"


def test_mutants_are_neither_all_refused_nor_all_loaded(tmp_path_factory):
    """Guard of this file: a mutation that nothing survives, or that everything survives, tests nothing."""
    loaded = []

    @given(content=mutants())
    @settings(max_examples=100, database=None)
    def count(content):
        path = tmp_path_factory.getbasetemp() / "mutant.toml"
        path.write_bytes(content)
        loaded.append(message_of_refusal(path) is None)

    count()
    assert 0 < sum(loaded) < len(loaded), f"{sum(loaded)} of {len(loaded)} mutants load"
