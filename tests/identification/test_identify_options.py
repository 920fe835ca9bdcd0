"""The configuration of `identify`: each value is of its kind, or refused in one line with its remedy."""

import pytest

from cabledrive.identification.logs.column_map import load_column_map
from cabledrive.identification.one_log import load_options
from cabledrive.parameters import InputRefused
from cabledrive.rig.bench.experiment import load_excitation
from cabledrive.studies.study.goals import load_goals

READERS = [load_options, load_column_map, load_excitation, load_goals]


def test_a_configuration_says_slope_bandwidth_and_check_with_their_units(tmp_path):
    path = tmp_path / "identify.toml"
    path.write_text(
        '[identify]\nmodel = "rigid-axis-tanh"\nslope = "2 s/rad"\nbandwidth = 12\ncheck = false\n'
    )
    found = load_options(path)
    assert (found.model, found.axis.friction.slope, found.axis.bandwidth) == ("rigid-axis-tanh", 2.0, 12.0)
    assert not found.check


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('slope = "steep"', 'identify.slope = "steep" is not a quantity'),
        ('fading = "slow"', 'identify.fading = "slow" is not a quantity'),
        ("slope = -1", "identify.slope = -1 s/rad must be above 0"),
        ("bandwidth = 0", "identify.bandwidth = 0 Hz must be above 0"),
        ('bandwidth = "20 rad/s"', "not Hz"),
        ("bandwidth = true", "identify.bandwidth = true is no quantity"),
        ('check = "no"', 'identify.check = "no" is neither true nor false'),
        ("check = 0", "identify.check = 0 is neither true nor false"),
        ("model = 3", "identify.model = 3 is no text"),
        ('model = "rigid"', 'did you mean "rigid-axis"'),
        ('method = "outputerror"', 'did you mean "output-error"'),
        ('filter = "none"', 'identify.filter = "none" is unknown'),
        ("bandwith = 1", 'did you mean "bandwidth"'),
        ("slope = 1" + 400 * "0", "is no quantity"),
    ],
)
def test_a_value_of_another_kind_is_refused_with_its_key(line, words, tmp_path):
    path = tmp_path / "identify.toml"
    path.write_text(f"[identify]\n{line}\n")
    with pytest.raises(InputRefused) as refusal:
        load_options(path)
    assert words in str(refusal.value)
    assert str(refusal.value).startswith("identify.toml: ")


@pytest.mark.parametrize("reader", READERS)
def test_a_small_file_that_cannot_be_read_is_refused_in_words(reader, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "deep").write_text("a = " + 5000 * "[")
    (tmp_path / "broken").write_text("a = = 3")
    for name, words in (
        ("absent", "absent: is not there: check the path"),
        ("folder", "folder: is a folder"),
        ("binary/inside", "inside: cannot be read (Not a directory)"),
        ("binary", "binary: not text"),
        ("deep", "deep: not TOML that can be read"),
        ("broken", "broken: not TOML"),
        ("nul\0", "write TOML"),
        ("n" * 300, "cannot be read (File name too long)"),
    ):
        with pytest.raises(InputRefused) as refusal:
            reader(tmp_path / name)
        assert words in str(refusal.value), name
        assert "Errno" not in str(refusal.value)
