"""The studio as a process: one folder, one port of the loopback, one printed address, until Ctrl-C."""

import contextlib
import logging
import os
import socket
import sys
import threading
import webbrowser
from pathlib import Path
from typing import Any

from cabledrive.parameters import InputRefused
from cabledrive.parameters.files import check_folder_writable, one_process

EXTRA = "the studio needs an extra: pip install 'cabledrive[studio]'"
HOST = "127.0.0.1"
FOLDER = "cabledrive-studio"
WARM = "CABLEDRIVE_STUDIO_WARM"
"""Environment variable that, set to 0, leaves kernels to be made ready when they are first needed."""
PATIENCE = 1
"""Seconds that open connections have when the studio ends."""


def open_studio(
    source: str | None = None, *, port: int = 0, browser: bool = True, folder: str | Path = FOLDER
) -> None:
    """Serve the studio on 127.0.0.1 until Ctrl-C; the first line printed is its address with the token.

    Parameters
    ----------
    source : str, optional
        Path of a drive file or name of a packaged drive to begin with.
    port : int, default 0
        Of the loopback; 0: a free one.
    browser : bool, default True
        Whether the browser is opened.
    folder : path-like
        Where drives, logs and results are kept; made if it is missing. Nothing is written elsewhere.

    Raises
    ------
    InputRefused
        If the extra is missing, the drive is refused, the port is taken, the folder cannot be written, or
        another studio works in it.
    """
    try:
        import starlette  # noqa: F401
        import uvicorn
    except ImportError:
        raise InputRefused(EXTRA) from None
    from cabledrive.studio.application import application
    from cabledrive.studio.guard import Keys
    from cabledrive.studio.library import Library
    from cabledrive.studio.state import first_state

    place = check_folder_writable(folder)
    library = Library(place.absolute())
    first = first_state(library, source)
    with _alone_in(place), _listening(port) as listener:
        keys = Keys(listener.getsockname()[1])
        app = application(library, keys, first, warm=os.environ.get(WARM) != "0")
        settings: dict[str, Any] = {"log_config": None, "access_log": False, "server_header": False}
        settings |= {"proxy_headers": False, "ws": "none", "loop": "asyncio", "http": "h11", "lifespan": "on"}
        server = uvicorn.Server(uvicorn.Config(app, **settings, timeout_graceful_shutdown=PATIENCE))
        _report_defects(server)
        print(_address(keys), flush=True)
        if browser:
            threading.Thread(target=_open_browser, args=(_address(keys),), daemon=True).start()
        server.run(sockets=[listener])


def _report_defects(server: Any) -> None:
    """Say what goes wrong in the server, but for what others send it and what Ctrl-C breaks off."""
    errors = logging.StreamHandler()
    errors.setLevel(logging.ERROR)
    errors.addFilter(lambda record: not server.should_exit)
    logging.getLogger("uvicorn.error").addHandler(errors)


def _address(keys: Any) -> str:
    return f"http://{HOST}:{keys.port}/?token={keys.token}"


@contextlib.contextmanager
def _alone_in(folder: Path) -> Any:
    """Keep a folder for this studio. Raises `InputRefused` if another one has it."""
    with contextlib.ExitStack() as held:
        try:
            held.enter_context(one_process(folder / ".studio"))
        except InputRefused as refusal:
            if "another process" not in str(refusal):
                raise
            raise InputRefused(
                f"{folder}: another studio works in this folder: use its page, or give another --folder"
            ) from None
        yield


@contextlib.contextmanager
def _listening(port: int) -> Any:
    """A socket of the loopback that listens. Raises `InputRefused` if the port is taken."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((HOST, port))
            listener.listen(128)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or error
            raise InputRefused(
                f"--port {port}: cannot be used ({reason}): give another, or leave it out for a free one"
            ) from None
        listener.set_inheritable(False)
        yield listener


def _open_browser(address: str) -> None:
    """Open the page; where there is no browser, say what to do."""
    opened = False
    with contextlib.suppress(webbrowser.Error, OSError):
        opened = webbrowser.open(address)
    if not opened:
        print("no browser was found: open the address above in one on this machine", file=sys.stderr)
