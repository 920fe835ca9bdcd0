"""Open and see: the page shows what the commands print, and refuses as the reader does."""

import re
import shlex
from urllib.parse import parse_qsl, urlencode

import pytest

from cabledrive.parameters import drive_text, load_drive, packaged_drives, packaged_text
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.studio.form import text_with
from command import call


def part(studio, *settings, **more):
    query = urlencode([("drive", "dissertation-3"), *(("set", one) for one in settings), *more.items()])
    return studio.get(f"/machine/part?{query}").json()


def frequencies_of(html):
    return re.findall(r'class="pick"[^>]*>([^<]+)</button>', html)


@pytest.mark.parametrize("motor", ["", "held"])
def test_the_table_is_what_modes_prints_to_the_last_digit(studio, motor):
    found = part(studio, "cable.pretension=6.5 N", "motor.joint_stiffness=80", motor=motor)
    line = shlex.split(found["command"])
    assert line[:3] == ["cabledrive", "modes", "dissertation-3"]
    printed = call(*line[1:]).stdout
    shown = frequencies_of(found["part"])
    assert len(shown) >= 8
    assert shown == re.findall(r"^ *([\d.e+]+)  +\d+  (?:long|trans)", printed, re.MULTILINE)


@pytest.mark.parametrize(
    "setting, key",
    [
        ("cable.pretension=-1 N", "cable.pretension"),
        ("pulley.1.inertia=5 kg", "pulley.1.inertia"),
        ("motor.inertia=", "motor.inertia"),
        ("layout.inclination=100 deg", "layout.inclination"),
    ],
)
def test_a_refusal_is_that_of_the_reader_and_stands_beside_its_field(studio, setting, key):
    found = part(studio, setting)
    printed = call("modes", "dissertation-3", f"--set={setting}").stderr
    assert found["refusal"].strip()
    assert found["refusal"] in printed
    assert found["key"] == key


def test_the_text_beside_the_form_is_the_file_with_its_comments(studio):
    found = part(
        studio,
        "cable.pretension=6 N",
        "pulley.1.inertia=0.003",
        "motor.backlash=0.1 deg",
        "goal.tracking_error=0.1 deg",
    )
    original, edited = packaged_text("dissertation-3"), found["text"]
    comments = re.findall(r"#.*", original)
    assert [line for line in comments if line not in edited] == []
    wanted = load_drive(
        "dissertation-3",
        overrides=[
            "cable.pretension=6 N",
            "pulley.1.inertia=0.003",
            "motor.backlash=0.1 deg",
            "goal.tracking_error=0.1 deg",
        ],
    )
    assert drive_from_text(edited) == wanted


@pytest.mark.parametrize("name", packaged_drives())
def test_every_packaged_file_takes_a_setting_as_text(name):
    settings = (("cable.pretension", "123.5 N"), ("layout.gravity", "1.6 m/s^2"))
    drive = drive_from_text(packaged_text(name), overrides=[f"{key}={value}" for key, value in settings])
    text = text_with(packaged_text(name), drive, settings)
    assert drive_from_text(text) == drive
    assert text != drive_text(drive)  # edited, not written anew


def test_an_edited_text_becomes_an_address_that_outlives_the_page(make_studio):
    studio = make_studio()
    text = packaged_text("dissertation-2").replace("[cable]", "[cable]  # mine")
    query = studio.post("/machine/text", content=text.encode()).json()["query"]
    again = make_studio()
    found = again.get(f"/machine/part?{query}").json()
    assert "# mine" in found["text"]
    assert frequencies_of(found["part"])
    name = dict(parse_qsl(query))["drive"]
    assert shlex.split(found["command"])[2].endswith(f"drives/{name}.toml")


def test_a_machine_with_routes_is_drawn_and_its_modes_listed(studio):
    found = studio.get("/machine/part?drive=printer-idlers&row=2").json()
    assert len(frequencies_of(found["part"])) >= 6
    assert found["part"].count("data-motion") == 2
    assert "upper idler to right clamp" in found["part"]
    assert 'data-key="head.x"' in studio.get("/machine?drive=printer-idlers").text
    moved = studio.get("/machine/part?drive=printer-idlers&set=head.x%3D0.25+m").json()
    assert frequencies_of(moved["part"]) != frequencies_of(found["part"])
