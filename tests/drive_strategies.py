"""Hypothesis strategies: any drive that a file can describe, by the bounds of its fields; files damaged."""

import copy
import tomllib
from dataclasses import fields, replace
from datetime import date, datetime, time
from math import inf, nan
from pathlib import Path

import tomli_w
from hypothesis import strategies as st

import cabledrive as cd
from cabledrive.parameters import Cable, Carriage, Drive, Goal, Layout, Lumped, Motor, Pulley, Sensors
from cabledrive.parameters.drive_file import drive_text

positive = st.floats(1e-12, 1e12)
within = {"positive": positive, "nonnegative": st.just(0.0) | positive, "finite": st.floats(-1e6, 1e6)}
words = st.text(st.characters(blacklist_categories=("Cc", "Cs"), whitelist_characters="\n\t"), max_size=40)


def maybe(strategy):
    """The value, or None: not stated."""
    return st.none() | strategy


def table(kind, **own):
    """A table of the file; ``own``: strategies of fields that others bind."""
    found = {}
    for field in fields(kind):
        if "unit" in field.metadata and field.name not in own:
            count = field.metadata["unit"] == "count"
            one = st.integers(1, 10_000_000) if count else within[field.metadata["bound"]]
            found[field.name] = maybe(one) if field.default is None else one
    return st.builds(kind, **found | own)


materials = st.one_of(
    st.fixed_dictionaries({"youngs_modulus": st.floats(1e6, 1e12), "area": st.floats(1e-9, 1e-2)}),
    st.fixed_dictionaries({"given_rigidity": st.floats(1e-3, 1e10)}),
)
cables = st.builds(
    lambda material, **others: Cable(**material, **others),
    material=materials,
    mass_per_length=st.floats(1e-6, 1e3),
    pretension=st.floats(1e-3, 1e6),
    transverse_damping=within["nonnegative"],
    axial_damping=within["nonnegative"],
    strain_limit=maybe(positive),
)
pulleys, motors, sensors, lumped = (table(kind) for kind in (Pulley, Motor, Sensors, Lumped))


@st.composite
def drives(draw, most_carriages=4):
    """Any drive: loop or line, with or without motor, joint, carriages, sensors.

    A span between 1 mm and 10 km, given by one of its two lengths.
    """
    given = {draw(st.sampled_from(["span_length", "pulley_distance"])): draw(st.floats(1e-3, 1e4))}
    slope = {"gravity": draw(st.floats(0.0, 100.0)), "inclination": draw(st.floats(-1.57, 1.57))}
    cable, layout = draw(cables), Layout(**given, **slope)
    kind = draw(st.sampled_from(["loop", "line"]))
    motor = draw(maybe(motors))
    length = layout.span_length or layout.pulley_distance / (1.0 + cable.prestrain)
    shares = st.floats(0.001, 0.999)
    places = draw(st.lists(shares, max_size=most_carriages, unique_by=lambda share: share * length))
    carriages = [
        Carriage(
            mass=draw(positive),
            position=place * length,
            span=draw(st.sampled_from(["upper", "lower"])) if kind == "loop" else "upper",
            guided=draw(st.booleans()),
        )
        for place in places
    ]
    most = 1e4 * length  # beyond that the span is round-off, and is refused
    both = [replace(own, radius=min(own.radius, most)) for own in (draw(pulleys), draw(pulleys))]
    return Drive(
        name=draw(words),
        title=draw(words),
        source=draw(words),
        kind=kind,
        cable=cable,
        layout=layout,
        pulley=both,
        carriage=carriages,
        motor=motor,
        lumped=draw(maybe(lumped)),
        sensors=draw(maybe(sensors)),
        goal=draw(maybe(table(Goal))),
    )


# --- What can be done to a valid drive file
EXAMPLE = Path(__file__).parent / "parameters" / "contract_example.toml"
DRIVES = [cd.load_drive(source).listed for source in (*cd.packaged_drives("loop", "line"), EXAMPLE)]
FILES = [EXAMPLE.read_bytes(), *[drive_text(drive).encode() for drive in DRIVES]]
TABLES = [tomllib.loads(content.decode()) for content in FILES]

odd_numbers = st.sampled_from([0, -1, -0.0, 1e-320, 1e308, 1e400, 2**63, 10**400, nan, -inf])
odd_texts = st.sampled_from(
    ["", "5", "5 kg", "50 Hz", "nan N", "1e999 m", "7 N\n", "\x00", "5 N^9", "x" * 3000, "-3 %"]
)
odd_times = st.sampled_from([date(1979, 5, 27), time(7, 32), datetime(1979, 5, 27, 7, 32)])
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
