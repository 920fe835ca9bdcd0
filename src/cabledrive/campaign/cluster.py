"""Chunks on the workers of dask.distributed: local processes, or a cluster that is there already."""

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from cabledrive.campaign.lone import do_alone
from cabledrive.campaign.processes import METHOD, ONE_THREAD, QUIET
from cabledrive.campaign.rows import ManyRows, compute_rows
from cabledrive.campaign.store import EXTRA, open_arrays
from cabledrive.campaign.work import Plan, Report, do_chunk
from cabledrive.parameters import InputRefused, NotComputed
from cabledrive.parameters.version import __version__

ALLOWED_FAILURES = 2
"""Workers that may end while they hold a chunk, before the chunk is computed alone."""
STARTS = 3
"""Times that local workers are begun."""
PATIENCE = 20.0
"""Until a scheduler has to answer [s]."""
SCHEDULING = {
    "distributed.scheduler.allowed-failures": ALLOWED_FAILURES,
    "distributed.scheduler.worker-saturation": 1.0,
}
"""Of the scheduler: a worker holds one chunk, so that the last ones are not queued behind each other."""


def dask_at_hand() -> bool:
    """Whether dask.distributed is installed."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        return False
    return True


@contextmanager
def local_workers(count: int) -> Iterator[Any]:
    """A client of worker processes on this machine, one thread each, that end with this process."""
    import dask
    from distributed import Client

    settings = SCHEDULING | {
        "distributed.nanny.pre-spawn-environ": ONE_THREAD | QUIET,
        "distributed.worker.daemon": True,
        "distributed.worker.multiprocessing-method": METHOD,
        "distributed.worker.profile.enabled": False,  # looks at the rows' thread a hundred times a second
        "distributed.admin.tick.interval": "1s",
    }
    with _quiet_logs(), dask.config.set(settings), _started(count) as cluster, Client(cluster) as client:
        yield client


def _started(count: int) -> Any:
    """A cluster of worker processes, begun anew where one ends early; `NotComputed` if each time."""
    from distributed import LocalCluster

    for _ in range(STARTS):
        with suppress(RuntimeError):
            return LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                local_directory=os.environ.get("DASK_TEMPORARY_DIRECTORY") or tempfile.gettempdir(),
            )
    raise NotComputed(f"workers end before they are up, {STARTS} times: take fewer, or --workers 1")


@contextmanager
def distant_workers(url: str) -> Iterator[Any]:
    """A client of a cluster by its scheduler's address, such as tls://host:8786.

    Refused if it does not answer, or has no workers, or one has another version of the package.
    """
    if not dask_at_hand():
        raise InputRefused(f"--scheduler: {EXTRA}")
    from distributed import Client

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
            yield client


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

    names = (
        "distributed",
        "distributed.nanny",
        "distributed.scheduler",
        "distributed.worker",
        "tornado.application",
    )
    loggers = [logging.getLogger(name) for name in names]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def warm(client: Any, plan: Plan) -> None:
    """Compute the first row once on each machine, so that its kernels are compiled by one process."""
    hosts: dict[str, str] = {}
    for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
        hosts.setdefault(worker["host"], address)
    futures = [
        client.submit(_first_row, plan, workers=[address], pure=False, allow_other_workers=False)
        for address in hosts.values()
    ]
    client.gather(futures, errors="skip")


def _first_row(plan: Plan) -> None:
    compute_rows(plan.spec, 0, 1)


def load(client: Any, plan: Plan) -> None:
    """Load the package on every worker, and the kernels of rows that are computed at once.

    The first chunk of each worker would wait for it otherwise. Kernels of single rows are loaded with the
    first row, since it may take as long as a chunk.
    """
    client.run(_load, plan, on_error="ignore")  # the first chunk finds out what is wrong


def _load(plan: Plan) -> None:
    spec = plan.spec
    open_arrays(plan.store)
    if isinstance(spec.computation, ManyRows):
        spec.computation.many(spec, spec.values(0, 1))


def on_workers(client: Any, plan: Plan, todo: Sequence[int]) -> Iterator[Report]:
    """Reports of the chunks as they are done; `OSError` if the disk refuses.

    A chunk whose workers ended is computed in the end in a process of its own, which finds the row that does
    it; an innocent chunk that was on such a worker is done there as well.
    """
    from distributed import KilledWorker, as_completed

    shared = client.scatter(plan, broadcast=False, hash=False) if len(todo) > 1000 else plan
    run = f"{plan.store.name}-{os.getpid()}-{time.time_ns()}"
    futures = client.map(
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


def worker_count(client: Any) -> int:
    """Workers of a cluster."""
    return max(1, len(client.scheduler_info(n_workers=-1)["workers"]))


def worker_memory(client: Any) -> Callable[[], float | None]:
    """Asks how much memory all workers use [bytes]."""

    def ask() -> float | None:
        workers = client.scheduler_info(n_workers=-1)["workers"].values()
        used = [worker.get("metrics", {}).get("memory") for worker in workers]
        return float(sum(value for value in used if value)) if used else None

    return ask
