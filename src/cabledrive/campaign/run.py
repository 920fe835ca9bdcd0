"""`run_sweep`: a campaign from its SPEC to a full store, resumed where it was left."""

import time
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

from cabledrive.answers.figures import Row
from cabledrive.answers.result import Result
from cabledrive.campaign import store
from cabledrive.campaign.computation import Computation
from cabledrive.campaign.design import Design
from cabledrive.campaign.engine import Engine, Plan, chosen_engine
from cabledrive.campaign.spec import CampaignSpec, read_spec
from cabledrive.parameters import InputRefused
from cabledrive.parameters.fields import described, meaning
from cabledrive.parameters.files import check_folder_writable, one_process
from cabledrive.parameters.terminal import Progress

MANY_ROWS, MANY_BYTES = 10**7, 100e9
"""Above these a campaign has to be meant."""
BESIDE_BYTES = 18
"""Of a row beside keys and outputs: status, seed, time, about."""


@described
@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class SweepResult(Result):
    """What a campaign came to."""

    _heading = "{0.store}"
    _shown = (
        Row("done", "rows done", form="d"),
        Row("rows", "of", form="d"),
        Row("refused", "refused", form="d"),
        Row("failed", "not completed", form="d"),
        Row("seconds", "time", "s"),
        Row("setup_seconds", "before that", "s"),
        Row("engine", "engine"),
    )
    rows: int = meaning("rows of the campaign")
    done: int = meaning("rows with a status")
    refused: int = meaning("of these refused")
    failed: int = meaning("of these not completed")
    first_reason: str = meaning("why the first of these has no result; empty where all have one")
    seconds: float = meaning("from the first chunk handed out to the last mark [s]")
    setup_seconds: float = meaning("before that [s]")
    store: Path = meaning("folder of the store")
    engine: str = meaning("what did the work")

    def open(self) -> Any:
        """The store as labelled arrays.

        Returns
        -------
        xarray.Dataset
            Read when used.
        """
        import xarray

        return xarray.open_zarr(self.store)

    def to_dataframe(self) -> Any:
        """Keys, status and outputs of one number of every row.

        Returns
        -------
        pandas.DataFrame
        """
        found = self.open()
        return found[[name for name, one in found.items() if one.ndim == 1]].to_dataframe()


def run_sweep(
    spec: str | Path | CampaignSpec,
    output: str | Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    part: tuple[int, int] | None = None,
    yes: bool = False,
    force: bool = False,
    progress: bool | None = None,
    design: Design | None = None,
    computation: Computation | None = None,
) -> SweepResult:
    """Run a campaign, or what is left of it, into a store that `xarray.open_zarr` reads.

    Parameters
    ----------
    spec : path-like or CampaignSpec
        File of the SPEC.
    output : path-like
        The store, a folder; that of the same campaign is resumed.
    workers : int, optional
        Processes on this machine, of which a row may end one; default: this process. A script that asks for
        them needs ``if __name__ == "__main__":`` around the call.
    scheduler : str, optional
        Address of a running scheduler of dask.distributed instead.
    part : (int, int), optional
        Part i of N of the chunks, i from 1: for array jobs.
    yes : bool, default False
        Whether more than 10^7 rows or 100 GB are meant.
    force : bool, default False
        Whether the store of another campaign may be deleted.
    progress : bool, optional
        Whether to show it on standard error; default: where that is a terminal.
    design : Design, optional
        Of your own, in place of ``[design]``.
    computation : Computation, optional
        Of your own, in place of ``[compute]``.

    Returns
    -------
    SweepResult

    Raises
    ------
    InputRefused
        If the SPEC is not understood or too large, the store is of another campaign or in use, or the
        scheduler does not answer.
    NotComputed
        If workers end before any row.
    """
    began = time.monotonic()
    if not isinstance(spec, CampaignSpec):
        spec = read_spec(spec, design=design, computation=computation)
    path = Path(output)
    _check(path, spec, workers, part, yes)
    words = "part {} of {}".format(*part) if part else ""
    with one_process(path.with_name(f"{path.name}.lock") / (words or "whole")):
        if force:
            store.delete_another(path, spec)
        if (path / "zarr.json").is_file():
            plan = Plan(spec=spec, store=path.resolve(), chunk=store.check_store(path, spec))
            if not _todo(plan, part):
                return _result(plan, 0.0, time.monotonic() - began, "nothing: it was done before")
        with chosen_engine(workers, scheduler, words) as engine:
            if not (path / "zarr.json").is_file():  # the first driver chooses the chunk
                store.create(path, spec, engine.chunk(spec))
            plan = Plan(spec=spec, store=path.resolve(), chunk=store.check_store(path, spec))
            first, last = _run(plan, _todo(plan, part), engine, progress)
    return _result(plan, last - first, first - began, engine.name)


def _run(plan: Plan, todo: list[int], engine: Engine, progress: bool | None) -> tuple[float, float]:
    """Hand out the chunks; when the first was handed out and the last was marked."""
    rows, before = plan.spec.design.rows, store.status_counts(plan.store)
    done, bad = before["done"], before["refused"] + before["failed"]
    shown, marks = Progress(rows, progress), list[float]()
    try:
        for report in engine.reports(plan, todo):
            marks.append(time.monotonic())
            if report is not None:
                done, bad = done + report["done"], bad + report["refused"] + report["failed"]
            shown.at(done, f"{done} of {rows} rows, {bad} refused or failed")
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"finished chunks are kept in {plan.store.name}; to go on, give the same command again"
        ) from None
    finally:
        shown.end()
    return marks[0], marks[-1]


def _result(plan: Plan, seconds: float, setup: float, engine: str) -> SweepResult:
    return SweepResult(
        rows=plan.spec.design.rows,
        **store.status_counts(plan.store),
        seconds=seconds,
        setup_seconds=setup,
        store=plan.store,
        engine=engine,
    )


def _check(
    path: Path, spec: CampaignSpec, workers: int | None, part: tuple[int, int] | None, yes: bool
) -> None:
    """Refuse what cannot be meant, before anything is made."""
    store.zarr_at_hand()
    if workers is not None and workers < 1:
        raise InputRefused(f"workers = {workers} must be at least 1")
    if part is not None and not 1 <= part[0] <= part[1]:
        raise InputRefused(f"part = {part[0]}/{part[1]} is none: i counts from 1 to N")
    rows = spec.design.rows
    numbers = len(spec.units) + sum(prod(output.shape) for output in spec.computation.outputs)
    size = rows * (8.0 * numbers + BESIDE_BYTES)  # before compression; texts are not known and not counted
    if not yes and (rows > MANY_ROWS or size > MANY_BYTES):
        raise InputRefused(
            f"{rows} rows, up to {size / 1e9:.3g} GB, are above {MANY_ROWS:.0e} rows or "
            f"{MANY_BYTES / 1e9:.0f} GB: add --yes if that is meant, or lower design.rows or n"
        )
    if path.is_dir() and any(path.iterdir()):
        store.attributes_of(path)
    else:
        check_folder_writable(path)


def _todo(plan: Plan, part: tuple[int, int] | None) -> list[int]:
    done, numbers = store.done_chunks(plan.store), plan.chunks
    if part is not None:
        numbers = numbers[part[0] - 1 :: part[1]]
    return [number for number in numbers if number not in done]
