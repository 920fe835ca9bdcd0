"""What hands out the chunks: this process, processes of this machine, or a cluster."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path

from cabledrive.campaign import cluster, store
from cabledrive.campaign.lone import Trial, do_alone, trial_begun
from cabledrive.campaign.processes import process_context
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.work import Plan, Report, chosen_chunk, do_chunk, untried_chunk
from cabledrive.parameters import InputRefused


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Engine:
    """What hands out the chunks."""

    name: str
    chunk: Callable[[CampaignSpec, Path], int]  # rows of a chunk, by a trial; takes the store to be
    warm: Callable[[Plan], None]  # gets every machine ready for a plan, kernels compiled once on each
    reports: Callable[[Plan, Sequence[int]], Iterator[Report]]
    """A report of each chunk as it is done; takes their numbers."""
    memory: Callable[[], float | None]  # of all workers [bytes], or none
    notes: tuple[str, ...] = ()


@contextmanager
def chosen_engine(
    workers: int, scheduler: str | None, part: tuple[int, int] | None, spec: CampaignSpec, new: bool
) -> Iterator[Engine]:
    """The engine that was asked for; without dask this process, which is noted.

    The first rows of a ``new`` campaign are tried while workers come up. Refused: a scheduler that does not
    answer, or together with a part.
    """
    words = part_words(part)
    if part is not None and scheduler is not None:
        raise InputRefused("--part and --scheduler do not go together: give one of them")
    if part is not None or (scheduler is None and workers == 1):
        yield _serial(words, part[1] if part else 1)
    elif scheduler is None and not cluster.dask_at_hand():
        yield _serial(words, 1, f"dask is not installed, so rows ran in one process: {store.EXTRA}")
    else:
        early: AbstractContextManager[Trial | None] = nullcontext()
        if scheduler is None:
            process_context(spec)  # loads while the scheduler comes up
            early = trial_begun(spec, workers) if new else early
        up = cluster.local_workers(workers) if scheduler is None else cluster.distant_workers(scheduler)
        with early as begun, up as client:
            count = workers if scheduler is None else cluster.worker_count(client)
            tried: list[int] = []  # then kernels are compiled on this machine

            def chunk(spec: CampaignSpec, path: Path) -> int:
                with nullcontext(begun) if begun is not None else trial_begun(spec, count) as trial:
                    tried.append(trial.chunk())
                return tried[-1]

            def warm(plan: Plan) -> None:
                if scheduler is not None or not tried:
                    cluster.warm(client, plan)
                cluster.load(client, plan)

            yield Engine(
                name=f"{workers} local workers" if scheduler is None else scheduler,
                chunk=chunk,
                warm=warm,
                reports=lambda plan, todo: cluster.on_workers(client, plan, todo),
                memory=cluster.worker_memory(client),
            )


def part_words(part: tuple[int, int] | None) -> str:
    """A part in words, "3 of 16"; empty for the whole."""
    return "" if part is None else f"{part[0]} of {part[1]}"


def _serial(part: str, parts: int, *notes: str) -> Engine:
    return Engine(
        name=f"this process, part {part}" if part else "this process",
        chunk=lambda spec, path: chunk_by_trial(spec, path, parts, part),
        warm=lambda plan: None,
        reports=lambda plan, todo: in_this_process(plan, todo, part),
        memory=lambda: None,
        notes=notes,
    )
