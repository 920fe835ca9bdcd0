"""What hands out the chunks: this process, processes of this machine, or a cluster."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, Protocol

from cabledrive.campaign import cluster
from cabledrive.campaign.processes import Worker, WorkerEnded, do_alone, tried_chunk
from cabledrive.campaign.rows import compute_rows
from cabledrive.campaign.spec import CampaignSpec
from cabledrive.campaign.work import Plan, Report, chosen_chunk, do_chunk, loaded, untried_chunk
from cabledrive.parameters import InputRefused


class Engine(Protocol):
    """What hands out the chunks."""

    name: str
    notes: tuple[str, ...]

    def chunk(self, spec: CampaignSpec) -> int:
        """Rows of a chunk, by a trial."""
        ...

    def ready(self, plan: Plan) -> None:
        """Get every machine ready for a plan, kernels compiled once on each."""
        ...

    def reports(self, plan: Plan, todo: Sequence[int]) -> Iterator[Report]:
        """A report of each chunk as it is done, of their numbers."""
        ...


TRIAL = -1
"""In place of the number of a chunk."""


class ThisProcess:
    """Every chunk in this process.

    What is in hand is noted beside the store; what is noted when a driver starts had ended the driver before:
    a chunk is then computed in processes of its own, a trial left out.
    """

    notes: tuple[str, ...] = ()

    def __init__(self, store: Path, part: tuple[int, int] | None) -> None:
        words = part_words(part)
        self.name = f"this process, part {words}" if part else "this process"
        self._mark = store.with_name(f".{store.name}-chunk{words and '-'}{words.replace(' ', '-')}")
        self._parts = part[1] if part else 1
        try:
            self._suspect: int | None = int(self._mark.read_text())
        except (OSError, ValueError):
            self._suspect = None

    @contextmanager
    def _noting(self) -> Iterator[None]:
        try:
            yield
        finally:
            with suppress(OSError):
                self._mark.unlink()

    def chunk(self, spec: CampaignSpec) -> int:
        """Rows of a chunk, by a trial."""
        if spec.chunk is not None or self._suspect == TRIAL:
            return untried_chunk(spec, self._parts)
        with self._noting():
            self._mark.write_text(str(TRIAL))
            return chosen_chunk(spec, self._parts)

    def ready(self, plan: Plan) -> None:
        """Nothing: the first row gets it ready."""

    def reports(self, plan: Plan, todo: Sequence[int]) -> Iterator[Report]:
        """A report of each chunk as it is done."""
        with self._noting():
            for number in todo:
                if number == self._suspect:
                    yield do_alone(number, plan)
                    continue
                self._mark.write_text(str(number))
                yield do_chunk(number, plan)


class Processes:
    """Workers on this machine; a chunk that ended one is computed alone in the end."""

    notes: tuple[str, ...] = ()

    def __init__(self, count: int) -> None:
        self.name, self._count = f"{count} local workers", count
        self._workers: list[Worker] = []

    def chunk(self, spec: CampaignSpec) -> int:
        """Rows of a chunk, by a trial."""
        return tried_chunk(spec, self._count)

    def ready(self, plan: Plan) -> None:
        """Let one worker compute the first row, whose kernels it compiles, then all load what rows need."""
        self._workers = [Worker(plan.spec) for _ in range(self._count)]
        self._all(self._workers[:1], compute_rows, plan.spec, 0, 1)
        self._all(self._workers, loaded, plan)

    @staticmethod
    def _all(workers: list[Worker], task: Callable[..., Any], *given: object) -> None:
        for worker in workers:
            worker.begin(task, *given)
        for worker in workers:
            with suppress(Exception):  # the first chunk finds out what is wrong
                worker.answer()

    def reports(self, plan: Plan, todo: Sequence[int]) -> Iterator[Report]:
        """A report of each chunk as it is done; `OSError` if the disk refuses."""
        left, suspects = deque(todo), []
        idle = self._workers[: len(todo)]
        busy: dict[Any, tuple[Worker, int]] = {}
        while idle or busy:
            while idle and left:
                worker, number = idle.pop(), left.popleft()
                worker.begin(do_chunk, number, plan)
                busy[worker.pipe] = worker, number
            if not busy:
                break
            for pipe in wait(list(busy)):
                worker, number = busy.pop(pipe)
                try:
                    report = worker.answer()
                except (WorkerEnded, MemoryError):
                    suspects.append(number)
                    worker.close()
                    self._workers.remove(worker)
                    self._workers.append(worker := Worker(plan.spec))
                else:
                    yield report
                idle.append(worker)
        for number in suspects:
            yield do_alone(number, plan)

    def close(self) -> None:
        """End the workers."""
        for worker in self._workers:
            worker.close()


@contextmanager
def chosen_engine(
    store: Path, workers: int, scheduler: str | None, part: tuple[int, int] | None
) -> Iterator[Engine]:
    """The engine that was asked for; refused: a scheduler that does not answer, or together with a part."""
    if part is not None and scheduler is not None:
        raise InputRefused("--part and --scheduler do not go together: give one of them")
    if scheduler is not None:
        with cluster.cluster_at(scheduler) as found:
            yield found
    elif part is not None or workers == 1:
        yield ThisProcess(store, part)
    else:
        with closing(Processes(workers)) as processes:
            yield processes


def part_words(part: tuple[int, int] | None) -> str:
    """A part in words, "3 of 16"; empty for the whole."""
    return "" if part is None else f"{part[0]} of {part[1]}"
