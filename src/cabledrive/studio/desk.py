"""What the routes of a studio share, and how they read a request."""

from dataclasses import dataclass

from starlette.requests import Request

from cabledrive.parameters import InputRefused
from cabledrive.studio.jobs import Jobs
from cabledrive.studio.library import Library
from cabledrive.studio.log_store import LogStore
from cabledrive.studio.state import State
from cabledrive.studio.warm import Warm


@dataclass(frozen=True, slots=True, kw_only=True)
class Desk:
    """What the routes share."""

    library: Library
    first: State  # where an address names no drive
    jobs: Jobs
    logs: LogStore
    warm: Warm


async def bounded_body(request: Request, most: int) -> bytes:
    """The body of a request.

    Raises `InputRefused` if it is longer than ``most`` bytes.
    """
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise InputRefused(f"the request is longer than {most} bytes: send less")
        parts.append(part)
    return b"".join(parts)
