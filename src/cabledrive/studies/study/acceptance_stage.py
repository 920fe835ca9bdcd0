"""Stage 7: the sampled controller on many plants drawn from what is known, lumped and on the cable."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from cabledrive.parameters import Drive
from cabledrive.rig.loop import Loop, run
from cabledrive.rig.loop_numbers import SUMMARY
from cabledrive.rig.setting import Motion
from cabledrive.studies.study.closed_loop import joined_loop, make_law, with_values
from cabledrive.studies.study.controller_stage import ControllerResult
from cabledrive.studies.study.drawn_plants import drawn_plant
from cabledrive.studies.study.machine import Quantity
from cabledrive.studies.study.stage_cache import StageCache

BLOCK, CABLE_BLOCK = 50, 5
KEPT = 400
"""Points of the worst run that are kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawBlock:
    """Runs on some plants.

    Attributes
    ----------
    peaks, torques : tuple of float
        Largest error [rad] and torque [N m] of each run.
    saturated : tuple of float
        Share of the samples at the torque's limit.
    failed : tuple of bool
        Runs that ended before their time.
    """

    peaks: tuple[float, ...]
    torques: tuple[float, ...]
    saturated: tuple[float, ...]
    failed: tuple[bool, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class WorstCase:
    """The run with the largest error.

    Attributes
    ----------
    draw : int
    values : dict of str to float
        Quantities of its plant.
    phases : tuple of float
        Of its encoders, in counts.
    time, reference, error, torque : tuple of float
        Thinned course [s], [rad], [rad], [N m].
    """

    draw: int
    values: dict[str, float]
    phases: tuple[float, ...]
    time: tuple[float, ...]
    reference: tuple[float, ...]
    error: tuple[float, ...]
    torque: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class AcceptanceResult:
    """What many runs said.

    Attributes
    ----------
    plant : {"lumped", "cable"}
    draws : int
    peaks : tuple of float
        Largest error of each run, ascending [rad].
    inside : float
        Share of the runs whose error stayed inside the stated bound.
    reached : float or None
        Share of the runs whose error stayed inside the goal; None without one.
    failed : int
    saturated : int
        Runs in which the torque met its limit.
    largest_torque : float
        [N m].
    worst : WorstCase or None
        None: every run failed, or none was made.
    reason : str
        Why there are no runs, where there are none.
    """

    plant: str
    draws: int
    peaks: tuple[float, ...]
    inside: float
    reached: float | None
    failed: int
    saturated: int
    largest_torque: float
    worst: WorstCase | None
    reason: str

    def quantile(self, share: float) -> float | None:
        """Error that a share of the runs kept below.

        Parameters
        ----------
        share : float

        Returns
        -------
        float or None
            [rad]; None without runs.
        """
        return float(np.quantile(self.peaks, share)) if self.peaks else None


def accept(
    drive: Drive,
    motion: Motion,
    quantities: Mapping[str, Quantity],
    controller: ControllerResult,
    *,
    draws: int,
    seed: int,
    torque: float | None,
    error: float | None,
    cable: bool,
    cache: StageCache,
    inputs: Mapping[str, object],
) -> AcceptanceResult:
    """Run the accepted law on many plants, block by block; each finished block is kept.

    Parameters
    ----------
    drive : Drive
        With the best values.
    motion : Motion
    quantities : mapping of str to Quantity
    controller : ControllerResult
        With a bandwidth.
    draws, seed : int
    torque, error : float or None
        Goals [N m], [rad].
    cable : bool
        Whether the plants are distributed nonlinear cables.
    cache : StageCache
    inputs : mapping
        All that the stage depends on, for the blocks' keys.

    Returns
    -------
    AcceptanceResult
    """
    assert controller.bandwidth is not None
    assert controller.bound is not None
    law = make_law(drive, motion, quantities, controller.model, controller.bandwidth)
    loop = joined_loop(drive, drive, law, motion, torque, cable=cable)
    plant, size = ("cable", CABLE_BLOCK) if cable else ("lumped", BLOCK)
    blocks = []
    for first in range(0, draws, size):
        last = min(first + size, draws)
        blocks.append(
            cache.staged(
                f"acceptance-{plant}-{first:05d}",
                DrawBlock,
                {**inputs, "first": first, "last": last},
                _block(loop, drive, quantities, seed, range(first, last)),
            )
        )
        cache.note(f"      {plant} plants: {last} of {draws}")
    return _summed(loop, drive, quantities, seed, blocks, controller.bound, error, plant)


def _block(
    loop: Loop, drive: Drive, quantities: Mapping[str, Quantity], seed: int, draws: range
) -> Callable[[], DrawBlock]:
    def compute() -> DrawBlock:
        def one(draw: int) -> tuple[float, float, float, bool]:
            values, phases = drawn_plant(quantities, len(loop.rig.phases), seed, draw)
            moved = with_values(loop, drive, values, phases)
            done = run(moved, log=False)
            score = dict(zip(SUMMARY, (float(v) for v in done.state.summary), strict=False))
            samples = len(moved.target)
            return (
                score["peak"] / moved.gear,
                score["peak_torque"],
                score["saturated"] / samples,
                done.ended < samples,
            )

        with ThreadPoolExecutor(2) as pool:
            rows = list(pool.map(one, draws))
        peaks, torques, saturated, failed = zip(*rows, strict=True)
        sound = tuple(p if np.isfinite(p) else 1e9 for p in peaks)
        return DrawBlock(peaks=sound, torques=torques, saturated=saturated, failed=failed)

    return compute


def _summed(
    loop: Loop,
    drive: Drive,
    quantities: Mapping[str, Quantity],
    seed: int,
    blocks: list[DrawBlock],
    bound: float,
    error: float | None,
    plant: str,
) -> AcceptanceResult:
    peaks = np.array([p for block in blocks for p in block.peaks])
    failed = np.array([f for block in blocks for f in block.failed])
    inside = (peaks <= bound) & ~failed
    reached = None if error is None else float(np.mean((peaks <= error) & ~failed))
    lasting = np.where(failed, -1.0, peaks)
    worst = int(np.argmax(lasting))
    return AcceptanceResult(
        plant=plant,
        draws=len(peaks),
        peaks=tuple(float(p) for p in np.sort(peaks)),
        inside=float(inside.mean()),
        reached=reached,
        failed=int(failed.sum()),
        saturated=sum(s > 0.0 for block in blocks for s in block.saturated),
        largest_torque=max(t for block in blocks for t in block.torques),
        worst=None if failed.all() else _worst(loop, drive, quantities, seed, worst),
        reason="",
    )


def _worst(loop: Loop, drive: Drive, quantities: Mapping[str, Quantity], seed: int, draw: int) -> WorstCase:
    values, phases = drawn_plant(quantities, len(loop.rig.phases), seed, draw)
    moved = with_values(loop, drive, values, phases)
    done = run(moved)
    n, rig = moved.chain.size, moved.rig
    error = (done.log[:, n - 1] - moved.target) / moved.gear
    step = max(1, len(error) // KEPT)
    shown = np.unique(np.append(np.arange(0, len(error), step), np.argmax(np.abs(error))))
    command = done.log[shown, 2 * n + 1 + len(rig.encoders)]
    return WorstCase(
        draw=draw,
        values=values,
        phases=tuple(float(p) for p in phases),
        time=tuple(float(t) for t in rig.interval * shown),
        reference=tuple(float(r) for r in moved.target[shown] / moved.gear),
        error=tuple(float(e) for e in error[shown]),
        torque=tuple(float(u) for u in command),
    )


def no_runs(plant: str, reason: str) -> AcceptanceResult:
    """An acceptance that was not made, with its reason.

    Parameters
    ----------
    plant : {"lumped", "cable"}
    reason : str

    Returns
    -------
    AcceptanceResult
    """
    return AcceptanceResult(
        plant=plant,
        draws=0,
        peaks=(),
        inside=0.0,
        reached=None,
        failed=0,
        saturated=0,
        largest_torque=0.0,
        worst=None,
        reason=reason,
    )
