"""Chunks on a cluster that is there already, by the scheduler of dask.distributed."""

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from cabledrive.campaign.processes import do_alone, tried_chunk
from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.store import EXTRA
from cabledrive.campaign.work import Plan, Report, do_chunk, loaded
from cabledrive.parameters import InputRefused
from cabledrive.parameters.version import __version__

PATIENCE = 20.0
"""Until a scheduler has to answer [s]."""
LOGGERS = ("", ".nanny", ".scheduler", ".worker")


class Cluster:
    """The workers of a scheduler."""

    notes: tuple[str, ...] = ()

    def __init__(self, url: str, client: Any) -> None:
        self.name, self._client = url, client

    def _workers(self) -> dict[str, Any]:
        found: dict[str, Any] = self._client.scheduler_info(n_workers=-1)["workers"]
        return found

    def chunk(self, spec: CampaignSpec) -> int:
        """Rows of a chunk, by a trial on this machine."""
        return tried_chunk(spec, max(1, len(self._workers())))

    def ready(self, plan: Plan) -> None:
        """Compute the first row once on each machine, whose kernels one process compiles; load the rest."""
        hosts = {worker["host"]: address for address, worker in self._workers().items()}
        futures = [
            self._client.submit(
                compute_rows, plan.spec, 0, 1, workers=[address], pure=False, allow_other_workers=False
            )
            for address in hosts.values()
        ]
        self._client.gather(futures, errors="skip")
        self._client.run(loaded, plan, on_error="ignore")  # the first chunk finds out what is wrong

    def reports(self, plan: Plan, todo: Sequence[int]) -> Iterator[Report]:
        """A report of each chunk as it is done; `OSError` if the disk refuses.

        A chunk whose workers ended is computed in the end in processes of this machine, which find the row
        that does it; an innocent chunk that was on such a worker is done there as well.
        """
        from distributed import KilledWorker, as_completed

        shared = self._client.scatter(plan, broadcast=False, hash=False) if len(todo) > 1000 else plan
        run = f"{plan.store.name}-{os.getpid()}-{time.time_ns()}"
        futures = self._client.map(
            do_chunk, list(todo), plan=shared, pure=False, key=[f"{run}-{number}" for number in todo]
        )
        number_of = {future.key: number for future, number in zip(futures, todo, strict=True)}
        suspects, finished = [], as_completed(futures, raise_errors=False)
        del futures
        for future in finished:
            error = future.exception() if future.status == "error" else None
            if error is None:
                yield future.result()
            elif isinstance(error, (KilledWorker, MemoryError)):
                suspects.append(number_of[future.key])
            else:
                raise error
            future.release()
        for number in suspects:
            yield do_alone(number, plan)


@contextmanager
def cluster_at(url: str) -> Iterator[Cluster]:
    """The workers of a scheduler by its address, such as tls://host:8786.

    Refused if it does not answer, or has no workers, or one has another version of the package.
    """
    try:
        from distributed import Client
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
        with client:
            _check_workers(client, url)
            yield Cluster(url, client)


def _check_workers(client: Any, url: str) -> None:
    versions = client.run(_version)
    if not versions:
        raise InputRefused(f"--scheduler {url}: has no workers: start some first")
    for worker, version in sorted(versions.items()):
        if version != __version__:
            raise InputRefused(
                f"--scheduler {url}: worker {worker} has cabledrive {version}, this is {__version__}: "
                "install one version everywhere"
            )


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
    import logging

    names = [f"distributed{part}" for part in LOGGERS]
    loggers = [logging.getLogger(name) for name in (*names, "tornado.application")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
