"""The uniform-tension model against the chain at equal accuracy, and ten thousand parameter sets of it."""

import os
import time
from functools import partial
from unittest import mock

import numpy as np
from case_chain import DRIVE, TORQUE, Integrated
from harness import duration, side_by_side, table

from cabledrive.reduction import fast_simulation
from cabledrive.reduction.fast_members import fast_ensemble
from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast
from cabledrive.reduction.uniform_tension import integrate
from cabledrive.simulation import Pluck, Recording, Scheme, Start, simulate
from cabledrive.simulation.case import case_of

TITLE = "Fast model"
REFERENCE = 800  # segments of the chain that both are held against
ACCURACY = 0.01
CANDIDATES = (52, 56, 60, 64, 72, 80, 100, 120, 150, 160, 180, 200, 240)
STEP = 2e-4  # s, about what the model chooses for 16 sines; both are timed with a record at each
SINES = {"half-sine": (1, 2, 3), "triangle": (14, 16, 17, 18, 20, 24)}
TARGETS = {"half-sine": 100, "triangle": 70}
RECORDING = Recording(rate=1.0 / STEP)
PRETENSIONS, TORQUES = np.linspace(3.0, 3.6, 100), np.linspace(0.001, 0.02, 100)


def report() -> str:
    rows = [row for shape in SINES for row in compared(shape)]
    note = (
        "One second of `dissertation-2` at 3.26 N, Gamma 2 1/s, torque 0.02 N m at 81.6 Hz, both spans plucked "
        f"by 1 mm. Errors: largest difference of the envelopes from those of {REFERENCE} segments over the "
        f"largest. The fewest segments and sines within {100 * ACCURACY:g} % are timed, integration alone, with "
        f"{1.0 / STEP:,.0f} records. Targets: {TARGETS['half-sine']} and {TARGETS['triangle']} times."
    )
    columns = ["pluck", "method", "load angle", "midpoint", "time per second", "times the fast model"]
    return table(columns, rows) + "\n\n" + note + "\n\n" + many_sets()


def start_with(shape: str) -> Start:
    return Start(plucks=tuple(Pluck(height=1e-3, span=span, shape=shape) for span in ("upper", "lower")))


def compared(shape: str):
    run = partial(simulate, DRIVE, 1.0, torque=TORQUE, start=start_with(shape))
    exact = envelopes(run(scheme=Scheme(segments=REFERENCE)))
    for segments in CANDIDATES:
        chain_error = errors(exact, run(scheme=Scheme(segments=segments)))
        if max(chain_error) < ACCURACY:
            break
    for sines in SINES[shape]:
        fast_error, arguments = fast_run(shape, sines, exact)
        if max(fast_error) < ACCURACY:
            break
    case = case_of(
        DRIVE.machine,
        1.0,
        torque=TORQUE,
        start=start_with(shape),
        scheme=Scheme(segments=segments),
        recording=RECORDING,
    )
    chain = Integrated(case)
    times = side_by_side({"chain": lambda: chain(case.grid.steps), "fast": lambda: integrated(arguments)})
    ratio = times["chain"].times_slower_than(times["fast"])
    for name, error, key, times_fast in (
        (f"chain, {segments} segments", chain_error, "chain", f"{ratio:.0f}"),
        (f"fast model, {sines} sines, step {1e3 * STEP:g} ms", fast_error, "fast", "1"),
    ):
        yield shape, name, f"{error[0]:.1e}", f"{error[1]:.1e}", duration(times[key]), times_fast


def fast_run(shape: str, sines: int, exact):
    """Error of the fast model, and the arguments of its integration."""
    taken = []

    def kept(numbers, start, *rest):
        taken.append((numbers, tuple(part.copy() for part in start), *rest))
        return integrate(numbers, start, *rest)

    with mock.patch.object(fast_simulation, "integrate", kept):
        result = simulate_fast(
            DRIVE,
            1.0,
            torque=TORQUE,
            start=start_with(shape),
            scheme=FastScheme(sines=sines, step=STEP),
            recording=RECORDING,
        )
    return errors(exact, result), taken[0]


def integrated(arguments):
    numbers, start, *rest = arguments
    return integrate(numbers, tuple(part.copy() for part in start), *rest)


def envelopes(result):
    """Peaks of windows of two forcing periods, without linear trend."""
    time_of = np.arange(0.0, 0.9999, 1e-4)
    return [
        envelope(np.interp(time_of, result.time, x)) for x in (result.load_angle, result.midpoint()[:, 2])
    ]


def envelope(signal: np.ndarray, window: int = 250) -> np.ndarray:
    x = np.linspace(-1.0, 1.0, signal.size)
    flat = np.abs(signal - np.polyval(np.polyfit(x, signal, 1), x))
    return flat[: flat.size // window * window].reshape(-1, window).max(axis=1)


def errors(exact, result) -> list[float]:
    return [float(np.max(np.abs(a - b)) / np.max(a)) for a, b in zip(exact, envelopes(result), strict=True)]


def many_sets() -> str:
    """A grid of pretensions and torques, each one second, on two threads; wall time, preparation included."""
    rows = []
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if cores:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        for sines, target in ((1, 2.0), (16, 15.0)):
            ensemble(PRETENSIONS[:2], sines, 2)  # compiles
            wall, processor = [], []
            for _ in range(3):
                began = time.perf_counter(), time.process_time()
                ensemble(PRETENSIONS, sines, 2)
                wall.append(time.perf_counter() - began[0])
                processor.append(time.process_time() - began[1])
            rows.append((sines, f"{min(wall):.2f} s", f"{min(processor):.2f} s", f"{target:g} s"))
    finally:
        if cores:
            os.sched_setaffinity(0, cores)
    note = (
        f"{PRETENSIONS.size * TORQUES.size:,} parameter sets, {PRETENSIONS.size} pretensions times "
        f"{TORQUES.size} torques, one second each in steps of {1e3 * STEP:g} ms, 100 records per set; models and coefficients are made in "
        "the same time. Two threads, least of three runs. The wall knows of all that the machine does besides; "
        "on an idle machine it is about half of the processor time of both threads."
    )
    return table(["sines", "wall", "processor", "target, wall"], rows) + "\n\n" + note


def ensemble(pretensions, sines: int, threads: int):
    return fast_ensemble(
        DRIVE,
        1.0,
        {"pretension": pretensions, "torque_amplitude": TORQUES},
        common={"torque_frequency": TORQUE.frequency, "pluck_upper": 1e-3, "pluck_lower": 1e-3},
        scheme=FastScheme(sines=sines, step=STEP),
        threads=threads,
    )
