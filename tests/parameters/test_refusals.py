"""A drive file that cannot be used is refused in one line: file, key, value with unit, bound, remedy."""

import time
from pathlib import Path

import pytest

from cabledrive.parameters import InputRefused, load_drive

DRIVE = """\
schema = 1
name = "test"
kind = "loop"
[cable]
youngs_modulus = "3 GPa"
area = "1.46e-7 m^2"
mass_per_length = "0.168 g/m"
pretension = "7 N"
[layout]
span_length = "1 m"
[[pulley]]
radius = "4 cm"
inertia = "0.000642 kg m^2"
[[pulley]]
radius = "4 cm"
inertia = "0.00235 kg m^2"
"""
SECOND_PULLEY = '[[pulley]]\nradius = "4 cm"\ninertia = "0.00235 kg m^2"\n'
CARRIAGE = "[[carriage]]\nmass = 1\nposition = {}\n"
MOTOR = "[motor]\ninertia = 0.001\n{}\n"


def changed(old, new):
    assert DRIVE.count(old) == 1
    return DRIVE.replace(old, new)


def refusal(path, **options):
    """The refusal's message after the name of the file, checked to be one short line."""
    with pytest.raises(InputRefused) as refused:
        load_drive(path, **options)
    message = str(refused.value)
    assert message.isprintable(), f"{message!r}"
    assert len(message) < 300, f"{len(message)} characters"
    assert message.startswith(f"{path}: "), message
    return message.removeprefix(f"{path}: ")


SLOPE = "slope from drive to load pulley"
LENGTHS = "layout.span_length [m, unstretched] or pulley_distance [m, pretensioned]"
NO_EQUALS = "Expected '=' after a key in a key/value pair (at line 1, column 5)"
PRETENSIONS = {  # value in the file and what is said of cable.pretension
    "0": "= 0 N must be above 0: pretension T0; a slack cable transmits nothing",
    "nan": "= nan N must be finite: give a number",
    "1e31": "= 1e+31 N is no size of a machine (1e-24 to 1e+24): check its unit",
    "9" * 400: "has more digits than a double can hold: give a finite number",
    "'5 kg'": '= "5 kg" is of dimension [mass], not N: give it in N',
    "true": "is true or false, not a number: give it in N, or as text with a unit",
    "[7]": "is an array, not a quantity in N: write one number or text",
    '"7\\nN\\u202E!"': '= "7\\nN\\u202e!": "N\\u202e!" is not a unit: give it in N',
}
MOTORS = {  # line of [motor] and what is said of motor
    'speed_limit = "50 Hz"': 'speed_limit = "50 Hz" is a frequency [Hz], not rad/s: give it in rad/s',
    "backlash = -0.1": "backlash = -0.1 rad must not be negative: backlash at the output shaft",
}
CARRIAGES = {  # position and more lines of [[carriage]] and what is said of carriage
    "1.0": "0.position = 1 m lies outside its span of 1 m (unstretched): move it inside",
    "0.5\n" + CARRIAGE.format("'50 cm'"): (
        "1.position = 0.5 m is taken by carriage.0 on the same span: add the masses or move one"
    ),
    "0.5\nspan = 'middle'": '0.span = "middle" is not one of its values: write "upper" or "lower"',
}
BAD_VALUES = {
    **{f"cable.pretension {words}": changed('"7 N"', value) for value, words in PRETENSIONS.items()},
    **{f"motor.{words}": DRIVE + MOTOR.format(line) for line, words in MOTORS.items()},
    **{f"carriage.{words}": DRIVE + CARRIAGE.format(lines) for lines, words in CARRIAGES.items()},
    f"layout.inclination = 1.6 rad must lie between -90 deg and 90 deg: {SLOPE}": changed(
        '"1 m"', '"1 m"\ninclination = 1.6'
    ),
    "sensors.drive_encoder = 1000.5 must be a whole number of counts per revolution": DRIVE
    + "[sensors]\ndrive_encoder = 1000.5",
    'carriage.0.span = "lower", but a "line" has no lower span: write "upper"': changed('"loop"', '"line"')
    + CARRIAGE.format("0.5")
    + "span = 'lower'",
}
BAD_SHAPES = {
    "schema = 2, but this version reads schema 1: write schema = 1": changed("schema = 1", "schema = 2"),
    "schema = a number, but this version reads schema 1: write schema = 1": changed(
        "schema = 1", "schema = 0x" + "f" * 9000
    ),
    'kind = "ring" is not one of its values: write "loop" or "line"': changed('"loop"', '"ring"'),
    "name is a number, not text: write it between quotation marks": changed('"test"', "5"),
    'unknown key "cable.pretention" (did you mean "cable.pretension"?)': changed("pretension", "pretention"),
    "cable.axial_rigidity = 19000 N beside youngs_modulus or area: give the rigidity, or modulus and area": (
        changed("pretension", 'axial_rigidity = "19 kN"\npretension')
    ),
    "cable.area is missing: give youngs_modulus [Pa] and area [m^2], or axial_rigidity [N], their product": (
        changed('area = "1.46e-7 m^2"', "")
    ),
    'unknown key "cable.EA": give axial_rigidity': changed("pretension", 'EA = "19 kN"\npretension'),
    'unknown key "pulley.1.diameter": give radius, half of it': DRIVE + "diameter = 1",
    'unknown key "goal.x" (known: tracking_error)': DRIVE + "[goal]\nx = 1",
    'unknown key "chain_of" (known: cable, carriage, excitation, goal, kind, layout, lumped, motor, name, '
    "pulley, schema, sensors, source, title)": "chain_of = 1\n" + DRIVE,
    'missing key "cable.pretension": pretension T0; a slack cable transmits nothing; add it': changed(
        'pretension = "7 N"', ""
    ),
    'missing key "cable": rigidity, mass and pretension; add it': "schema = 1\nname = 'a'\nkind = 'loop'",
    "pulley: 1 given, but a drive has 2: the drive pulley, then the load pulley": changed(SECOND_PULLEY, ""),
    "pulley is a table, not an array of tables: write [[pulley]] above each": (
        DRIVE.split("[[pulley]]")[0] + "[pulley]\nradius = 1"
    ),
    "carriage.0 is a number, not a table: write [[carriage]] above its keys": "carriage = [1]\n" + DRIVE,
    f"{LENGTHS}: both are given; give one": changed('"1 m"', '"1 m"\npulley_distance = 1'),
    f"{LENGTHS}: neither is given; give one": changed('span_length = "1 m"', ""),
    "pulley.0.fixed = true, but [motor] drives that pulley: leave one of the two out": changed(
        '"0.000642 kg m^2"', "1\nfixed = true"
    )
    + MOTOR.format(""),
    "not TOML: Cannot declare ('cable',) twice (at line 17, column 7); correct that line": DRIVE
    + "[cable]\n",
    f"not TOML: {NO_EQUALS}; correct that line": "off we go",
}


@pytest.mark.parametrize("message", BAD_VALUES | BAD_SHAPES)
def test_refusal_names_key_value_bound_and_remedy(message, tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text((BAD_VALUES | BAD_SHAPES)[message], encoding="utf-8")
    assert refusal(path) == message.strip()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no keys"),
        (bytes(range(256)), "not text (byte 128 is not UTF-8): give a TOML file"),
        (b"\x7fELF\x02\x01\x01\x00", "not TOML"),
        (DRIVE.encode("utf-16"), "not text (byte 0 is not UTF-8): give a TOML file"),
        (DRIVE.encode() + b"\xed\xb0\x80 = 1", "not text"),
        (DRIVE.encode() + b'"\\uDC00" = 1', "not TOML"),
        (DRIVE.encode() + b"x = " + b"9" * 5000, "a number of absurd length"),
        (b"x = " + b"[" * 100_000, "nested too deeply"),
        (b"a" + b".a" * 100_000 + b" = 1", "nested too deeply"),
        (b"[a" + b" . 'a'" * 100_000 + b"]", "nested too deeply"),
    ],
    ids=lambda part: ascii(part)[:25],
)
def test_file_that_is_no_drive_file_is_refused_quickly(content, words, tmp_path):
    """A dotted key of 100,000 parts alone would hold the parser for minutes."""
    path = tmp_path / "drive.toml"
    path.write_bytes(content)
    start = time.perf_counter()
    assert words in refusal(path)
    assert time.perf_counter() - start < 5.0


def test_byte_order_mark_and_foreign_line_ends_are_read(tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(DRIVE)
    plain = load_drive(path)
    path.write_bytes(b"\xef\xbb\xbf" + DRIVE.replace("\n", "\r\n").encode())
    assert load_drive(path) == plain


def test_million_carriages_are_refused_quickly(tmp_path):
    """By the size of the file, before it is parsed, and by their number, before they are checked."""
    path = tmp_path / "drive.toml"
    start = time.perf_counter()
    path.write_text(DRIVE + CARRIAGE.format(0.5) * 1_000_000)
    assert refusal(path) == "larger than the 16 MB that are read"
    path.write_text("carriage = [" + "{}," * 1_000_000 + "]\n" + DRIVE)
    assert refusal(path) == "carriage: 1000000 given, at most 100000 are taken: lump some together"
    assert time.perf_counter() - start < 20.0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing.toml", "no such file, and no packaged drive of that name (known: "),
        ("dissertation-4", 'no such file, and no packaged drive of that name (did you mean "dissertation-'),
        ("folder", "is a folder: name a drive file in it"),
        ("file/drive.toml", "no such file"),
        ("ring", "cannot be read (Too many levels of symbolic links): check the path"),
        ("a\0b", None),
        ("\udcff", None),
        ("", None),
    ],
    ids=lambda part: ascii(part)[:25],
)
def test_path_that_is_no_file_is_refused(name, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    Path("file").touch()
    Path("ring").symlink_to("ring")
    if words is None:
        with pytest.raises(InputRefused) as refused:
            load_drive(name)
        assert str(refused.value).isprintable()
        assert len(str(refused.value)) < 300
    else:
        assert refusal(name).startswith(words)
