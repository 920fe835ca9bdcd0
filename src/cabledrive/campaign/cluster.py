"""The workers of a cluster that is there already, by the scheduler of dask.distributed."""

import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from cabledrive.campaign.engine import Opened
from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.store import EXTRA
from cabledrive.parameters import InputRefused
from cabledrive.parameters.version import __version__

PATIENCE = 20.0
"""Until a scheduler has to answer [s]."""
TASKS_EACH = 2
"""Chunks that a worker has in hand, so that it does not wait for the next one."""
LOGGERS = ("", ".nanny", ".scheduler", ".worker")

Workers = tuple[int, Opened, tuple[type[Exception], ...]]


@contextmanager
def cluster_at(url: str) -> Iterator[Workers]:
    """Tasks at a time, executor, and what a lost task raises, of a scheduler such as tls://host:8786.

    Refused if it does not answer, or has no workers, or one has another version of the package.
    """
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise InputRefused(f"--scheduler: {EXTRA}") from None
    with _quiet_logs():
        try:
            client = Client(url, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InputRefused(
                f"--scheduler {url}: does not answer ({why}): check address and port"
            ) from None

        @contextmanager
        def opened(spec: CampaignSpec) -> Iterator[Executor]:
            """The workers, of which one on each machine has compiled the kernels."""
            known: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
            one_each = {worker["host"]: address for address, worker in known.items()}
            client.run(compute_rows, spec, 0, 1, workers=[*one_each.values()], on_error="ignore")
            executor = client.get_executor(pure=False)
            try:
                yield executor
            finally:
                executor.shutdown(wait=False)

        with client:
            versions = client.run(_version)
            _check_workers(versions, url)
            yield TASKS_EACH * len(versions), opened, (KilledWorker, MemoryError)


def _check_workers(versions: dict[str, str], url: str) -> None:
    if not versions:
        raise InputRefused(f"--scheduler {url}: has no workers: start some first")
    for worker, version in sorted(versions.items()):
        if version != __version__:
            said = f"--scheduler {url}: worker {worker} has cabledrive {version}, this is {__version__}"
            raise InputRefused(f"{said}: install one version everywhere")


def _version() -> str:
    """Version of the package on a worker."""
    try:
        from cabledrive.parameters.version import __version__ as theirs
    except ImportError:
        return "not installed"
    return theirs


@contextmanager
def _quiet_logs() -> Iterator[None]:
    """Without the library's own lines: what matters of them is said by the campaign."""
    loggers = [
        logging.getLogger(name) for name in (*(f"distributed{p}" for p in LOGGERS), "tornado.application")
    ]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
