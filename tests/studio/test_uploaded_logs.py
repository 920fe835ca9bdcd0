"""Logs: streamed to disk under a name of the studio's, drawn by extremes that no pixel loses, checked."""

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from scipy.io import wavfile

from cabledrive.studio.log_store import safe_name

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
