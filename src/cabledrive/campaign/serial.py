"""Chunks one after another in this process: without dask, and as one part of an array job."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from cabledrive.campaign.lone import do_alone
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.work import Plan, Report, chosen_chunk, do_chunk, untried_chunk


def chunk_by_trial(spec: CampaignSpec, store: Path, workers: int, part: str) -> int:
    """Rows of a chunk by a trial in this process; none where one ended the driver of this part before."""
    mark = _mark(store, "trial", part)
    if spec.chunk is not None or mark.exists():
        with suppress(OSError):
            mark.unlink()
        return untried_chunk(spec, workers)
    mark.touch()
    try:
        return chosen_chunk(spec, workers)
    finally:
        with suppress(OSError):
            mark.unlink()


def in_this_process(plan: Plan, todo: Sequence[int], part: str) -> Iterator[Report]:
    """Reports of the chunks as they are done.

    The number of the chunk in hand is noted beside the store; one that is noted when a driver starts had
    ended the driver before, and is computed in a process of its own. ``part``: "1 of 4"; empty for the whole.
    """
    mark = _mark(plan.store, "chunk", part)
    suspect = _noted(mark)
    try:
        for number in todo:
            if number == suspect:
                yield do_alone(number, plan)
                continue
            mark.write_text(str(number))
            yield do_chunk(number, plan)
    finally:
        with suppress(OSError):
            mark.unlink()


def _mark(store: Path, what: str, part: str) -> Path:
    return store.with_name(f".{store.name}-{what}{part and '-'}{part.replace(' ', '-')}")


def _noted(mark: Path) -> int | None:
    """The chunk at which an earlier driver ended."""
    try:
        return int(mark.read_text())
    except (OSError, ValueError):
        return None
