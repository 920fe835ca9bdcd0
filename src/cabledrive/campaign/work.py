"""One chunk of work, from the SPEC to the store."""

import time
from dataclasses import dataclass
from pathlib import Path

from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.store import chunk_bounds, write_chunk

WORK = 5.0
"""Of a chunk, where the SPEC leaves it open [s]."""
PROBE = 0.5
"""How long rows are tried to learn how long they take [s]."""
MOST_ROWS = 25_000
"""Of a chunk: so that a campaign of fast rows has chunks to divide."""
UNTRIED = 100
"""Rows of a chunk where the trial ended its process."""
CHUNKS_EACH = 4
"""Least chunks for each worker, where there are rows enough."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plan:
    """A campaign with its store."""

    spec: CampaignSpec
    store: Path
    chunk: int  # rows of a chunk

    def bounds(self, number: int) -> tuple[int, int]:
        """First row of a chunk and the row behind its last one."""
        return chunk_bounds(number, self.chunk, self.spec.design.rows)


def do_chunk(number: int, plan: Plan) -> dict[str, int]:
    """Compute a chunk and write it; `OSError` if the disk refuses. Returns `counts` of its rows."""
    first, last = plan.bounds(number)
    return write_chunk(plan.store, first, compute_rows(plan.spec, first, last))


def chosen_chunk(spec: CampaignSpec, workers: int) -> int:
    """Rows of about five seconds of work, by a trial of the first rows; kernels are compiled by then."""
    rows = spec.design.rows
    if rows == 1:
        return 1
    compute_rows(spec, 0, 1)
    if spec.chunk is not None:
        return min(spec.chunk, rows)
    tried, spent, count = 1, 0.0, 1  # the first row's time is that of compiling
    while spent < PROBE and tried < rows:
        last = min(tried + count, rows)
        began = time.perf_counter()
        compute_rows(spec, tried, last)
        spent += time.perf_counter() - began
        tried, count = last, 2 * count
    fitting = int(WORK * (tried - 1) / max(spent, 1e-9))
    shared = -(-rows // (CHUNKS_EACH * workers))
    return max(1, min(fitting, shared, MOST_ROWS, rows))


def untried_chunk(spec: CampaignSpec, workers: int) -> int:
    """Rows of a chunk where the first rows cannot be tried."""
    shared = -(-spec.design.rows // (CHUNKS_EACH * workers))
    return min(spec.chunk or min(UNTRIED, shared), spec.design.rows)
