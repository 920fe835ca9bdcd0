"""Long work: commands of the package as processes, watched, cancelled without an orphan, resumed."""

import asyncio
import json
import os
import signal
import socket
import sys
import time
import urllib.request
from http.cookiejar import CookieJar
from urllib.parse import urlsplit

import pytest

from cabledrive.parameters import InputRefused
from cabledrive.studio.commands import KINDS, asked
from cabledrive.studio.jobs import RUNNING
from cabledrive.studio.state import State
from command import call
from studio_browser import studio_process

LONG = ["simulate", "dissertation-2", "--duration=1000", "--pluck-upper=1 mm", "-o", "run.nc"]


def alive(group):
    """Processes of a group that still run."""
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/stat") as file:
                    fields = file.read().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[2]) == group and fields[0] != "Z":
                found.append(int(entry))
    return found


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="looks for processes in /proc")
def test_a_cancel_leaves_no_process_and_the_same_command_goes_on(studio):
    jobs = studio.desk.jobs

    async def _begin():
        job = await jobs.start(jobs.new_folder(), "a long run", LONG)
        await asyncio.sleep(1.0)
        return job

    job = studio.run(_begin())
    assert job.status == RUNNING
    group = job.process.pid
    assert alive(group)
    with pytest.raises(Exception, match="is running"):
        studio.run(jobs.resume(job))
    begun = time.monotonic()
    assert studio.post(f"/studies/{job.number}/cancel").json()["status"] in (RUNNING, "cancelled")
    assert time.monotonic() - begun < 2.0
    assert alive(group) == []
    studio.run(asyncio.sleep(0.1))
    assert job.status == "cancelled"
    job.arguments = ["schema"]
    assert studio.post(f"/studies/{job.number}/resume").status_code == 200
    lines = studio.run(_events(studio, job))
    assert lines[-1] == ("end", "done")
    assert studio.get(f"/studies/{job.number}/part").json()["answer"]["title"] == "cabledrive drive file"


async def _events(studio, job):
    found, kind = [], ""
    async for event in studio.desk.jobs.events(job, 0):
        for line in event.splitlines():
            if line.startswith("event: "):
                kind = line.removeprefix("event: ")
            if line.startswith("data: "):
                found.append((kind, json.loads(line.removeprefix("data: "))))
    return found


def test_what_runs_when_a_studio_is_killed_is_called_interrupted(make_studio):
    studio = make_studio()
    _, folder = studio.desk.jobs.new_folder()
    card = {"title": "x", "shown": "cabledrive x", "arguments": ["x"], "status": RUNNING}
    (folder / "job.json").write_text(json.dumps(card))
    assert make_studio().desk.jobs.all[1].status == "interrupted"


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_no_value_of_a_page_becomes_an_option_or_a_path(studio, tmp_path, kind):
    """Values drawn to look like options and paths stay the value of the option they belong to."""
    content = b"time [s],torque [N m]\n0,1\n"
    log = studio.post("/logs/file", params={"name": "a.csv"}, content=content).json()["log"]
    evil = "--output=../stolen"
    form = dict.fromkeys(
        ("error", "draws", "angle", "rise", "dwell", "bandwidth", "goal", "controller", "torque",
         "frequency", "pluck", "duration", "model", "method", "input", "response", "axis", "column0",
         "limit", "key1", "from1", "to1", "vary1", "order1", "speed", "span", "span2", "seed"), evil
    )  # fmt: skip
    if kind == "klipper":  # of a shaper that was found here, and of nothing else
        with pytest.raises(InputRefused, match="no input shaper was found"):
            asked(studio.desk, kind, State(drive="dissertation-3"), form | {"job": evil}, tmp_path)
        return
    form |= {"log": log, "log2": log, "motion": log}
    form |= {"rows": "4", "count": "2", "format": "c99", "film-law": "pd"}
    state = State(drive="dissertation-3", settings=())
    found = asked(studio.desk, kind, state, form, tmp_path)
    named = [part for part in found.arguments if part.startswith("/")]
    assert all(part.startswith(str(studio.folder)) for part in named)
    assert evil not in found.arguments
    outputs = [found.arguments[k + 1] for k, part in enumerate(found.arguments) if part == "-o"]
    assert all("/" not in name for name in outputs)


@pytest.mark.parametrize("name", ["dissertation-2", "corexy"])
def test_a_film_plucks_the_first_span_of_every_kind_of_machine(studio, tmp_path, name, monkeypatch):
    """Machines with routes have no upper span: a film of one was refused with the page's own values."""
    form = {"pluck": "1 mm", "duration": "20 ms", "torque": "1 mN m", "frequency": "80 Hz"}
    found = asked(studio.desk, "film", State(drive=name, settings=()), form, tmp_path)
    monkeypatch.chdir(tmp_path)
    result = call(*found.arguments, "--json")
    assert result.exit_code == 0, result.stderr
    first = json.loads(result.stdout)["spans"][0]
    assert 0.999e-3 < first["midpoint_peak"] < 1.3e-3  # a loop falls from straight to its sag


# --- The studio as a process: its address, a taken port, a folder in use, Ctrl-C
def test_the_first_line_is_the_address_and_ctrl_c_ends_it_with_130(tmp_path, monkeypatch):
    monkeypatch.setattr("uvicorn.Server.run", None)  # of this process: one that served would be a defect
    with studio_process(tmp_path / "one", "dissertation-2", warm=True) as (process, address):
        parts = urlsplit(address)
        assert (parts.scheme, parts.hostname, parts.path) == ("http", "127.0.0.1", "/")
        browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
        page = browser.open(address, timeout=60)
        assert page.url.startswith(f"http://127.0.0.1:{parts.port}/machine?drive=dissertation-2")
        assert b"dissertation-2" in page.read()

        second = call("studio", "--no-browser", "--folder", tmp_path / "one")
        assert second.exit_code == 2
        assert "another studio works in this folder" in second.stderr
        busy = call("studio", "--no-browser", "--port", parts.port, "--folder", tmp_path / "two")
        assert busy.exit_code == 2
        assert f"--port {parts.port}" in busy.stderr
        assert "give another" in busy.stderr

        with socket.create_connection(("127.0.0.1", parts.port)) as raw:
            raw.sendall(b"\x16\x03\x01 no request at all\r\n\r\n")
            assert b" 400 " in raw.recv(1000)

        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 130
        kept = f"cabledrive: interrupted; what was made is kept in {tmp_path / 'one'}\n"
        assert process.stderr.read() == kept


def test_without_the_extra_the_door_says_which(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    result = call("studio", "--no-browser", "--folder", str(tmp_path / "x"))
    assert result.exit_code == 2
    assert "pip install 'cabledrive[studio]'" in result.stderr
