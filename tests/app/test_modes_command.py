"""`cabledrive modes`: the contract's object, a table in which nothing is lost, a picture of the same."""

import re

import pytest

import cabledrive as cd
from cabledrive.modal.mode_rows import mode_rows
from cabledrive.modal.mode_table import mode_table
from command import answer, call, refusal


def test_json_has_what_the_contract_promises():
    found = answer("modes", "dissertation-1", "--below", "1000")
    longitudinal = [mode for mode in found["modes"] if mode["kind"] == "longitudinal"]
    assert [round(mode["frequency_hz"], 8) for mode in longitudinal] == [
        116.32932059,
        751.7326924,
        769.66140323,
    ]
    assert [mode["family"] for mode in longitudinal] == [
        "pulleys out of phase",
        "pulleys at rest",
        "pulleys in phase",
    ]
    assert {mode["multiplicity"] for mode in found["modes"]} == {1}
    assert {mode["plane"] for mode in found["modes"] if mode["kind"] == "transverse"} == {"v", "w"}
    assert (found["certified"], found["rigid_body_modes"]) == (True, 1)
    proof = found["certificate"]
    assert proof["below_hz"] == pytest.approx(1000.0, rel=1e-11)
    assert proof["count"] == proof["longitudinal"] + proof["transverse"] == len(found["modes"])


def test_count_lists_so_many_of_each_kind():
    kinds = [mode["kind"] for mode in answer("modes", "elevator", "--count", "7")["modes"]]
    assert (kinds.count("longitudinal"), kinds.count("transverse")) == (7, 7)


def test_ring_of_four_equal_masses_has_a_double_root_first():
    """Two carriages of J / r^2 halfway between equal pulleys: the ring turned by a quarter is itself."""
    carriages = ", ".join(f'{{mass=0.01, position=0.5, span="{span}"}}' for span in ("upper", "lower"))
    settings = [f"carriage=[{carriages}]"]
    settings += [f"pulley.{n}.{value}" for n in (0, 1) for value in ("radius=0.5", "inertia=0.0025")]
    options = [word for setting in settings for word in ("--set", setting)]
    found = [
        mode
        for mode in answer("modes", "dissertation-1", *options)["modes"]
        if mode["kind"] == "longitudinal"
    ]
    assert [mode["multiplicity"] for mode in found[:2]] == [2, 1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--below", "1e9"], "at most 20000 are certified: lower it to about"),
        (["--below", "0"], "below = 0 Hz must be positive and finite"),
        (["--below", "-3"], "below = -3 Hz must be positive and finite"),
        (["--count", "0"], "count = 0 modes must lie between 1 and 20000"),
        (["--below", "5", "--count", "3"], "are both given: give one of the two"),
    ],
)
def test_limits_beyond_what_can_be_certified_are_refused(arguments, words):
    assert words in refusal("modes", "elevator", *arguments)


def test_frequencies_may_have_a_unit():
    assert answer("modes", "finger-tendon", "--below", "20 kHz") == answer(
        "modes", "finger-tendon", "--below", "20000"
    )


@pytest.mark.parametrize("name", cd.packaged_drives("loop", "line"))
def test_table_counts_every_mode_once(name):
    found = cd.modes(cd.load_drive(name), count=12)
    rows = mode_rows(found)
    assert sum(row.count for row in rows) == sum(mode.multiplicity for mode in found.modes)
    assert [mode for row in rows for mode in row.modes if mode.kind == "longitudinal"] == list(
        found.longitudinal
    )
    assert [row.frequency for row in rows] == sorted(row.frequency for row in rows)
    for row in rows:
        assert {mode.kind for mode in row.modes} == {row.kind}


def test_table_gives_where_a_mode_lives():
    text = call("modes", "dissertation-transporter", "--below", "120").stdout
    assert re.search(
        r"67\.192218\d +1 +transverse +string +upper span, carriage 0 to load pulley; horizontal plane",
        text,
    )
    assert re.search(r"50\.394164\d +1 +transverse +string +lower span; horizontal plane", text)
    assert re.search(r"50\.394324\d +1 +transverse +string +lower span; vertical plane", text)
    assert re.search(
        r"111\.68464\d +1 +longitudinal +pulleys out of phase +load pulley 59%, drive pulley 30%", text
    )
    assert re.search(r"120 Hz \(certified\): 7 modes \(1 longitudinal, 6 transverse\)", text)


def test_command_and_python_show_the_same_table():
    table = mode_table(cd.modes(cd.load_drive("ropeway"), below=3.0))
    assert call("modes", "ropeway", "--below", "3").stdout.endswith(f"\n{table}\n")


@pytest.mark.parametrize(("ending", "magic"), [("png", b"\x89PNG"), ("SVG", b"<?xml"), ("pdf", b"%PDF")])
def test_picture_is_written_in_the_format_of_its_name(ending, magic, tmp_path):
    path = tmp_path / f"modes.{ending}"
    done = call("modes", "camera-line", "--plot", path)
    assert (done.exit_code, done.stderr) == (0, f"written to {path}\n")
    assert path.read_bytes().startswith(magic)


def test_picture_is_the_same_each_time(tmp_path):
    for name in ("a.svg", "b.svg"):
        assert call("modes", "elevator", "--below", "15", "--plot", tmp_path / name).exit_code == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
