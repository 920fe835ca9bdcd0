"""The map of the internal resonance, 100 pretensions times 100 torques, one second each, on two threads."""

import os
import time
from dataclasses import replace

import numpy as np
from harness import table

from cabledrive.modal.tuning import tuned_pretension
from cabledrive.parameters import load_drive
from cabledrive.reduction.autoparametric import AutoparametricModel, at_pretension, autoparametric_model
from cabledrive.studies import resonance_map
from cabledrive.studies.resonance_map import growth_map

TITLE = "Map of the internal resonance"
PRETENSIONS, TORQUES = np.linspace(3.0, 3.6, 100), np.linspace(0.001, 0.02, 100)
PLUCK = 1e-4
ROUNDS, PEER_POINTS = 5, 4
TARGET = 0.3


def drive():
    """Configuration 2 at its tuned pretension, Gamma 2 1/s, c_q 5 1/s."""
    plain = load_drive(
        "dissertation-2", overrides=["cable.transverse_damping=2", "layout.gravity=0"]
    ).two_pulleys
    load = replace(plain.load_pulley, viscous_friction=5.0 / 1.3043e5)
    tuned = replace(plain.cable, pretension=tuned_pretension(plain))
    return replace(plain, cable=tuned, pulley=(plain.drive_pulley, load))


def report() -> str:
    cores = sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []
    if cores:
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        return one_table(drive())
    finally:
        if cores:
            os.sched_setaffinity(0, cores)


def one_table(machine) -> str:
    points = [(PRETENSIONS[k], TORQUES[k]) for k in (10, 40, 50, 90)][:PEER_POINTS]
    peer_seconds, peer = peer_run(machine, points)
    found, inner, whole, processor = timed(machine)
    ratio = peer_seconds / (inner / found.growth.size)
    rows = [(f"{inner:.3f} s", f"{whole:.3f} s", f"{processor:.3f} s", f"{TARGET:g} s", f"{ratio:,.0f}")]
    own = [found.growth[find(TORQUES, t), find(PRETENSIONS, p)] for p, t in points]
    error = max(abs(a / b - 1.0) for a, b in zip(own, peer, strict=True))
    note = (
        f"{PRETENSIONS.size * TORQUES.size:,} sets, one second each, two threads, least of {ROUNDS} runs. Integration: "
        "wall time of the integration. Whole call: wall time of `growth_map`, with the modes of the drive, "
        "coefficients of every set and the start map. Targets are for the integration. Last column: scipy's "
        f"`solve_ivp` (DOP853, rtol 1e-8) on the equations (A.9) at {len(points)} of the points, "
        f"{peer_seconds:.2f} s each on one core, over the integration per point. Growth differs from it by at "
        f"most {100 * error:.2g} % at those points."
    )
    columns = ["integration", "whole call", "processor", "target", "times solve_ivp per point"]
    return table(columns, rows) + "\n\n" + note


def find(axis: np.ndarray, value: float) -> int:
    return int(np.argmin(np.abs(axis - value)))


def timed(machine):
    """Result, least wall time of the integration and of the whole call, least processor time of the call."""
    spent, inner = [], resonance_map.in_lanes  # the integration as the map calls it

    def watched(*given):
        began = time.perf_counter()
        inner(*given)
        spent.append(time.perf_counter() - began)

    def run():
        return growth_map(
            machine,
            torque=0.01,
            pretensions=PRETENSIONS,
            torques=TORQUES,
            duration=1.0,
            threads=2,
        )

    resonance_map.in_lanes = watched
    try:
        run()
        spent.clear()
        walls, processors = [], []
        for _ in range(ROUNDS):
            began = time.perf_counter(), time.process_time()
            found = run()
            walls.append(time.perf_counter() - began[0])
            processors.append(time.process_time() - began[1])
    finally:
        resonance_map.in_lanes = inner
    return found, min(spent), min(walls), min(processors)


def peer_run(machine, points) -> tuple[float, list[float]]:
    """Seconds per point, and the growth at each, by an adaptive solver on the oscillators."""
    model = autoparametric_model(machine)
    growth, seconds = [], []
    for tension, torque in points:
        began = time.process_time()
        growth.append(solved(at_pretension(model, float(tension)), float(torque)))
        seconds.append(time.process_time() - began)
    return float(np.median(seconds)), growth


def solved(m: AutoparametricModel, torque: float) -> float:
    from scipy.integrate import solve_ivp

    def rates(t, y):
        q, p, v, a, b = y[0], y[1], y[2], y[3:5], y[5:7]
        push = torque * np.sin(m.natural * t)
        pull = m.torque_arm * push - m.coupling @ a**2 - m.cross_damping * v
        pulley = pull / m.modal_mass - m.modal_damping * p - m.natural**2 * q
        rigid = (m.rigid_arm * push - m.rigid_damping * v - m.cross_damping * p) / m.rigid_mass
        stiff = m.transverse**2 + (2 * m.coupling * q + m.stiffening @ a**2) / m.transverse_mass
        return np.concatenate(([p, pulley, rigid], b, -m.transverse_damping * b - stiff * a))

    start = np.array([0.0, 0.0, 0.0, PLUCK, 0.5 * PLUCK, 0.0, 0.0])
    end = solve_ivp(rates, (0.0, 1.0), start, method="DOP853", rtol=1e-8, atol=1e-14, max_step=2e-4)
    return float(np.max(np.abs(end.y[3:5])) / PLUCK)
