"""How processes of a campaign begin: forked from one that has loaded the package, where that is safe.

Eight workers on two cores that load the package each for itself are busy for four times as long as one.
"""

import multiprocessing
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from cabledrive.campaign.spec import CampaignSpec

METHOD = "forkserver" if sys.platform == "linux" else "spawn"
"""Elsewhere libraries of the system do not stand a fork after they were loaded."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
QUIET = {"DASK_LOGGING__DISTRIBUTED": "critical"}
"""Of a worker process: an interrupt ends its work, and the driver says so in one line."""
OF_ALL = (
    "distributed.nanny",
    "cabledrive.campaign.work",
    "cabledrive.campaign.loaded_kernels",
    "zarr.codecs",
)
"""Modules of every worker; one that is not installed is passed over."""


def process_context(spec: CampaignSpec) -> Any:
    """What begins the processes of a campaign.

    The process that they are forked from loads what the rows import, and computes nothing, so that it has
    one thread. Where it runs already, or there is none, each process loads what it lacks.
    """
    context: Any = multiprocessing.get_context(METHOD)
    if METHOD == "forkserver":
        from multiprocessing.forkserver import ensure_running

        needed = [name for part in (spec.computation, spec.design) for name in getattr(part, "modules", ())]
        context.set_forkserver_preload([*OF_ALL, *needed])
        with _environment(ONE_THREAD | QUIET):
            ensure_running()
    return context


@contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    """Variables of the environment, for the processes that begin meanwhile."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
