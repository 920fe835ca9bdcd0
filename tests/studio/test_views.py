"""What the page shows is what the public functions give; logs that are given to it."""

import json
import re
import shlex
from dataclasses import replace
from urllib.parse import parse_qsl, urlencode

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from scipy.io import wavfile

from cabledrive.mechanics.spans import rigid_mass
from cabledrive.parameters import drive_text, load_drive, packaged_drives, packaged_text
from cabledrive.parameters.drive_file import drive_from_text
from cabledrive.rig import track
from cabledrive.rig.setting import Motion
from cabledrive.studio.control_view import spectrum
from cabledrive.studio.form import text_with
from cabledrive.studio.log_store import safe_name
from command import call


@pytest.mark.parametrize("name", packaged_drives())
def test_every_view_of_every_packaged_machine_shows_something_or_says_in_a_sentence_why_not(studio, name):
    """No red line; a pair of modes is one that `route_resonance` or `resonance` finds."""
    assert "``" not in studio.get(f"/machine?drive={name}").text
    page = studio.get(f"/resonance?drive={name}").text
    assert 'class="problem"' not in page
    assert ("Frequency ratio" in page) != ("no internal resonance to show" in page)
    found = studio.get(f"/control/part?drive={name}&law=pd&bandwidth=5+Hz").json()
    assert not found.get("refusal")
    assert found.get("none_here") or found["rows"] or found["refused"]
    for view in ("/", "/control", "/logs", "/studies"):
        page = studio.get(f"{view}?drive={name}").text
        assert 'class="problem"' not in page
        assert 'role="alert">' not in page.replace('role="alert" hidden', "")


def test_a_switched_on_disturbance_is_that_of_the_command(studio):
    asked = "drive=dissertation-3&law=pd&rise=0.2+s&dwell=0.1+s&dropout=1&smooth=1"
    found = studio.get(f"/control/part?{asked}").json()
    words = shlex.split(found["command"])
    answer = json.loads(call(*words[1:], "--json").stdout)
    assert found["rows"][0]["peak_error_deg"] == answer["peak_error_deg"]
    assert {"--smooth-friction", "--blind=load:0.3 s:0.32 s"} <= set(words)


def test_a_measured_response_stands_over_the_computed_one(studio):
    """A rigid inertia below all resonances: the computed response is 1 / (J w^2) of the whole drive."""
    _, folder = studio.desk.jobs.new_folder()
    card = {"title": "Response", "shown": "", "arguments": ["response", "--response=angle"], "status": "done"}
    (folder / "job.json").write_text(json.dumps(card))
    hertz = [0.0, 0.5, 1.0]
    lines = {"frequency_hz": hertz, "magnitude": [1.0] * 3, "phase_deg": [0.0] * 3, "coherence": [1.0] * 3}
    (folder / "answer.json").write_text(json.dumps(lines))
    studio.desk.jobs._restore(folder / "job.json")
    found = studio.get("/studies/1/response?drive=dissertation-2").json()
    drive = load_drive("dissertation-2").listed
    first, second = drive.drive_pulley, drive.load_pulley
    inertia = first.inertia + second.inertia * (first.radius / second.radius) ** 2
    omega = 2 * np.pi * np.array(hertz[1:])
    np.testing.assert_allclose(found["computed"], 1 / (inertia * omega**2), rtol=0.02)
    assert found["frequency_hz"] == hertz[1:]
    assert found["output"] == "motor angle"
    carried, belt = load_drive("dissertation-transporter").listed, load_drive("printer-idlers")
    found = studio.get("/studies/1/response?drive=dissertation-transporter").json()
    inertia = rigid_mass(carried) * carried.drive_pulley.radius**2
    np.testing.assert_allclose(found["computed"], 1 / (inertia * omega**2), rtol=0.02)
    found = studio.get("/studies/1/response?drive=printer-idlers").json()
    turned = sum(own.inertia / own.radius**2 for own in belt.pulley) + belt.body[0].mass
    inertia = belt.motor[0].inertia + turned * belt.pulley[belt.driven[0]].radius ** 2
    np.testing.assert_allclose(found["computed"], 1 / (inertia * omega**2), rtol=0.02)
    refused = studio.get("/studies/1/response?drive=camera-winches").json()
    assert refused["computed"] == []
    assert "No computed response" in refused["words"]


def test_the_spectrum_is_that_of_the_error_in_degrees(studio):
    """Of two tones the amplitudes; of a load at rest what an axis of powers of ten can show."""
    run = track(
        load_drive("dissertation-3").listed,
        controller="pd",
        bandwidth=10.0,
        motion=Motion(dwell=1.0, rise=0.3),
    )
    tone = np.radians(0.02 * np.sin(2 * np.pi * 40.0 * run.time))
    frequency, amplitude = spectrum(replace(run, error=tone))
    assert amplitude.max() == pytest.approx(0.02, rel=0.01)
    assert frequency[np.argmax(amplitude)] == pytest.approx(40.0, abs=0.2)
    found = studio.get("/control/part?drive=corexy&law=stepper&rise=0.1+s&dwell=0.3+s").json()["curves"][0]
    assert 0.0 < min(found["amplitude"]) <= max(found["amplitude"]) < 0.1


# --- Open and see: the page of a machine shows what the commands print, and refuses as the reader does
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
    settings = ("cable.pretension=6 N", "pulley.1.inertia=0.003", "motor.backlash=0.1 deg")
    settings += ("goal.tracking_error=0.1 deg",)
    found = part(studio, *settings)
    original, edited = packaged_text("dissertation-3"), found["text"]
    comments = re.findall(r"#.*", original)
    assert [line for line in comments if line not in edited] == []
    wanted = load_drive("dissertation-3", overrides=settings)
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
    assert found["part"].count("data-motion") == 1
    assert "upper idler to right clamp" in found["part"]
    assert 'data-key="head.x"' in studio.get("/machine?drive=printer-idlers").text
    moved = studio.get("/machine/part?drive=printer-idlers&set=head.x%3D0.25+m").json()
    assert frequencies_of(moved["part"]) != frequencies_of(found["part"])


# --- Logs that were uploaded
ROWS = 700_001
RATE = 1000.0


def sent(studio, name, content):
    return studio.post("/logs/file", params={"name": name}, content=content)


@pytest.fixture
def long_log(studio, tmp_path):
    """Two float32 columns, longer than a pixel can show, with one spike and one gap."""
    draw = np.random.default_rng(1)
    torque = draw.normal(size=ROWS).astype(np.float32)
    angle = np.cumsum(draw.normal(size=ROWS)).astype(np.float32)
    torque[123_457] = 99.0
    angle[500_000:500_010] = np.nan
    path = tmp_path / "long.parquet"
    table = pa.table({"time [s]": np.arange(ROWS) / RATE, "torque [N m]": torque, "angle [rad]": angle})
    pyarrow.parquet.write_table(table, path, row_group_size=200_000)
    answer = sent(studio, "long.parquet", path.read_bytes())
    assert answer.status_code == 200, answer.text
    return answer.json()["log"], torque, angle


def window(studio, log, **asked):
    answer = studio.get(f"/logs/{log}/curves", params=asked)
    assert answer.status_code == 200, answer.text
    return json.loads(answer.text, parse_constant=lambda word: pytest.fail(word))


@pytest.mark.parametrize(
    "start, end, points",
    [(None, None, 700), (100.0, 140.0, 300), (123.456, 123.4575, 50), (499.9, 500.2, 900)],
)
def test_no_extreme_is_lost_between_the_pixels(studio, long_log, start, end, points):
    log, torque, angle = long_log
    asked = {"points": points} | ({} if start is None else {"start": start, "end": end})
    found = window(studio, log, **asked)
    time = np.arange(ROWS) / RATE
    inside = slice(*np.searchsorted(time, [found["start"], found["end"] + 1e-9]))
    assert found["rows"] == ROWS
    assert [one["name"] for one in found["series"]] == ["torque", "angle"]
    for one, values in zip(found["series"], (torque, angle), strict=True):
        assert len(one["low"]) == len(one["high"]) == len(found["x"]) <= points
        low, high = np.array(one["low"], dtype=float), np.array(one["high"], dtype=float)
        assert np.nanmin(low) == np.nanmin(values[inside])
        assert np.nanmax(high) == np.nanmax(values[inside])


@pytest.mark.parametrize(("unit", "second"), [("s", 1.0), ("ms", 1000.0)])
def test_what_the_check_found_is_marked_where_it_happened_in_the_unit_of_the_file(studio, unit, second):
    time = np.arange(4000) / 1000.0 * second
    torque = np.sin(2 * np.pi * 3.0 * time / second)
    rows = zip(time, np.clip(torque, -1.0, 0.8), np.sin(time / second), strict=True)
    lines = [f"time [{unit}],torque [N m],angle [rad]", *(f"{a:.3f},{b:.6f},{c:.6f}" for a, b, c in rows)]
    log = sent(studio, "clipped.csv", "\n".join(lines).encode()).json()["log"]
    shown = window(studio, log)
    assert (shown["time_unit"], shown["end"]) == (unit, pytest.approx(time[-1], rel=1e-12))
    found = studio.get(f"/logs/{log}/check").json()
    assert any("end of its range" in words for words in found["said"])
    marked = np.zeros(4000, dtype=bool)
    for mark in found["marks"]:
        assert mark["channel"] == "torque"
        marked |= (time >= mark["start"] - 1e-9) & (time <= mark["end"] + 1e-9)
    np.testing.assert_array_equal(marked, torque >= 0.8)


def test_a_time_that_goes_back_is_no_axis(studio):
    back = "time [s],torque [N m]\n0,1\n1,2\n0.5,3\n2,4\n"
    log = sent(studio, "back.csv", back.encode()).json()["log"]
    assert (found := window(studio, log))["time"] is None
    assert found["x"] == [0.0, 1.0, 2.0, 3.0][: len(found["x"])]


@pytest.mark.parametrize(
    "name, kept",
    [("../../etc/x.csv", "x.csv"), ("..\\logs\\a b<c>.CSV", "a_b_c_.CSV"), (".hidden.csv", "hidden.csv")],
)
def test_a_name_of_a_file_is_never_a_path(name, kept):
    assert safe_name(name) == kept


def test_an_upload_that_breaks_off_or_is_too_long_leaves_nothing(studio, monkeypatch):
    monkeypatch.setattr("cabledrive.studio.log_store.LARGEST", 1000)

    async def _long():
        for _ in range(10):
            yield b"1,2\n" * 100

    assert "cut the log" in sent(studio, "long.csv", _long()).json()["refusal"]
    assert [path.name for path in (studio.folder / "logs").glob("*")] == []


def test_a_recording_of_sound_offers_its_tension(studio, tmp_path):
    wavfile.write(tmp_path / "ping.wav", 8000, np.zeros(800, dtype=np.int16))
    log = sent(studio, "ping.wav", (tmp_path / "ping.wav").read_bytes()).json()["log"]
    page = studio.get("/logs", params={"log": log, "drive": "corexy"}).text
    assert "A recording of sound" in page
    assert "<option>motor a to rear right a</option>" in page
    assert 'data-kind="identify"' not in page
