"""The example of the drive file that the reference shows in full loads, and means what it says."""

from pathlib import Path

from cabledrive.parameters import Carriage, load_drive

EXAMPLE = Path(__file__).with_name("contract_example.toml")


def test_commented_lines_of_the_example_load_as_well(tmp_path):
    """The carriage and the fixed pulley, which the example shows as comments."""
    text = EXAMPLE.read_text(encoding="utf-8")
    for line in ("[[carriage]]", "mass =", "span =", "position =", "guided =", "fixed ="):
        assert f"# {line}" in text
        text = text.replace(f"# {line}", line)
    (tmp_path / "drive.toml").write_text(text, encoding="utf-8")
    drive = load_drive(tmp_path / "drive.toml")
    assert drive.load_pulley.fixed
    assert drive.carriage == (Carriage(mass=0.5, span="upper", position=0.25, guided=True),)
