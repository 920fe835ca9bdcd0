"""The studio as a process: its address, a taken port, a folder in use, Ctrl-C, no work left behind."""

import signal
import socket
import subprocess
import sys
import urllib.request
from contextlib import contextmanager
from http.cookiejar import CookieJar
from pathlib import Path
from urllib.parse import urlsplit

from command import call, listening, run


@contextmanager
def running(folder: Path, *arguments: str, env: dict[str, str] | None = None):
    """A studio as a shell starts it, with its address."""
    command = [
        sys.executable,
        "-W",
        "error",
        "-m",
        "cabledrive",
        "studio",
        *arguments,
        "--folder",
        str(folder),
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes, preexec_fn=listening, env=env) as process:
        try:
            yield process, process.stdout.readline().strip()
        finally:
            if process.poll() is None:
                process.kill()


def test_the_first_line_is_the_address_and_ctrl_c_ends_it_with_130(tmp_path):
    with running(tmp_path / "one", "dissertation-2", "--no-browser") as (process, address):
        parts = urlsplit(address)
        assert (parts.scheme, parts.hostname, parts.path) == ("http", "127.0.0.1", "/")
        browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
        page = browser.open(address, timeout=60)
        assert page.url.startswith(f"http://127.0.0.1:{parts.port}/machine?drive=dissertation-2")
        assert b"dissertation-2" in page.read()

        second = run("studio", "--no-browser", "--folder", str(tmp_path / "one"))
        assert second.returncode == 2
        assert "another studio works in this folder" in second.stderr
        busy = run("studio", "--no-browser", "--port", str(parts.port), "--folder", str(tmp_path / "two"))
        assert busy.returncode == 2
        assert f"--port {parts.port}" in busy.stderr
        assert "give another" in busy.stderr

        with socket.create_connection(("127.0.0.1", parts.port)) as raw:
            raw.sendall(b"\x16\x03\x01 no request at all\r\n\r\n")
            assert b" 400 " in raw.recv(1000)

        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 130
        assert (
            process.stderr.read() == f"cabledrive: interrupted; what was made is kept in {tmp_path / 'one'}\n"
        )


def test_without_the_extra_the_door_says_which(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    result = call("studio", "--no-browser", "--folder", str(tmp_path / "x"))
    assert result.exit_code == 2
    assert "pip install 'cabledrive[studio]'" in result.stderr
