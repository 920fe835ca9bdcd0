"""The compiled chain against the same loop in plain C and in numpy; what conserving energy costs."""

from dataclasses import replace
from functools import partial

import numpy as np
from harness import duration, side_by_side, table
from plain_chain import LOOPS, InC, InNumpy, InNumpyByParts, compiled, once_each

import cabledrive as cd
from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start
from cabledrive.simulation.case import RopeRun, case_of
from cabledrive.simulation.channels import width_of
from cabledrive.simulation.methods import integrate_steps
from cabledrive.simulation.plan import new_workspace

TITLE = "Chain: steps of the exact law"
DRIVE = cd.load_drive(
    "dissertation-2", overrides=["cable.pretension=3.26", "cable.transverse_damping=2"]
).two_pulleys
TORQUE = Sine(amplitude=0.02, frequency=81.6)
IN_PLANE = (Pluck(height=1e-3, shape="half-sine"),)
CARRIAGE = replace(DRIVE, carriage=(cd.Carriage(mass=2e-3, position=0.31),))
WEIGHTLESS = replace(DRIVE, layout=replace(DRIVE.layout, gravity=0.0))
DAMPED = cd.load_drive(
    "dissertation-2",
    overrides=["cable.pretension=3.26", "cable.transverse_damping=2", "cable.axial_damping=0.003"],
).two_pulleys
WHIRL = (*IN_PLANE, Pluck(height=1e-3, shape="half-sine", plane="v"))
RATES = {"1 kHz": 1e3, "10 kHz": 1e4}  # records per second


def report() -> str:
    library, vectorised = compiled()
    rows = [
        row
        for segments in (100, 1000)
        for name, plucks in (("in plane", IN_PLANE), ("whirling", WHIRL))
        for row in compared(library, segments, name, plucks)
    ]
    note = (
        "`dissertation-2` at 3.26 N, torque 0.02 N m at 81.6 Hz, Gamma 2 1/s, half-sine pluck of 1 mm, CFL "
        "0.9. The C loop keeps no record, energy, extreme or slack; it was compiled with `gcc -O3 -march=native "
        f"-ffast-math`, which vectorised {vectorised} of its {LOOPS} loops. In the plane of the pulleys "
        "the kernel leaves out v, which stays exactly zero; the C loop does not. The last column is the difference "
        "of displacements after some thousand steps without weight, by which the spans of the kernel hang. "
        "Targets: C at least 1.0 times the kernel, numpy 100 "
        "times, axial damping at most 3 (n = 100) and 4 (n = 1000), energy-conserving 2.3."
    )
    columns = ["n", "motion", "contestant", "time per step", "times the kernel", "difference"]
    return table(columns, rows) + "\n\n" + note


def compared(library, segments: int, name: str, plucks):
    case = prepared(segments, plucks, "verlet", 1e3)
    steps = case.grid.every * max(1, round(2000 / case.grid.every))
    contestants = {
        f"kernel, records at {rate}": Integrated(prepared(segments, plucks, "verlet", hertz))
        for rate, hertz in RATES.items()
    }
    contestants["kernel with a carriage, records at 1 kHz"] = Integrated(
        prepared(segments, plucks, "verlet", 1e3, CARRIAGE)
    )
    contestants["kernel with axial damping, records at 1 kHz"] = Integrated(
        prepared(segments, plucks, "verlet", 1e3, DAMPED)
    )
    contestants["energy-conserving, records at 1 kHz"] = Integrated(
        prepared(segments, plucks, "energy-conserving", 1e3)
    )
    contestants["energy-conserving with a carriage, records at 1 kHz"] = Integrated(
        prepared(segments, plucks, "energy-conserving", 1e3, CARRIAGE)
    )
    contestants["plain C"] = InC(library, case)
    if segments == 100 and plucks is IN_PLANE:
        contestants["numpy, by parts"] = InNumpyByParts(case)
        contestants["numpy, in one array"] = InNumpy(case)
    weightless = prepared(segments, plucks, "verlet", 1e3, WEIGHTLESS)
    error = difference(weightless, InC(library, weightless), 2 * steps)
    times = side_by_side({key: partial(run, steps) for key, run in contestants.items()})
    ours = times["kernel, records at 1 kHz"]
    for key, timing in times.items():
        per_step = type(timing)(timing.seconds / steps, None)
        ratio = f"{timing.times_slower_than(ours):.2f}"
        yield segments, name, key, duration(per_step), ratio, f"{error:.0e}" if key == "plain C" else ""


def prepared(segments: int, plucks, method: str, rate: float, drive=DRIVE) -> RopeRun:
    """A case whose step does not depend on the recording rate."""
    scheme = Scheme(segments=segments, method=method)
    return case_of(
        drive.machine,
        1.0,
        torque=TORQUE,
        start=Start(plucks=plucks),
        scheme=scheme,
        recording=Recording(rate=rate),
    )


def difference(case: RopeRun, in_c: InC, steps: int) -> float:
    ours = Integrated(case)
    ours(steps)
    in_c(steps)
    x = once_each(case, ours.state.x)
    return max(float(np.max(np.abs(x[k] - in_c.rows[k])) / np.max(np.abs(in_c.rows[k]))) for k in (0, 2))


class Integrated:
    """The steps of a method from the start of a case, with its records."""

    def __init__(self, case: RopeRun):
        self.case, self.state, self.work = case, case.first_state(), new_workspace(case.plan)
        self.fields = np.zeros((0, 3, case.nodes))
        self.inputs: tuple = (np.zeros((0, 1)), np.zeros((0, 0)))

    def __call__(self, steps: int) -> None:
        case = self.case
        if self.inputs[0].size != steps:
            self.inputs = case.inputs(0, steps)
            self.rows = np.zeros((-(-steps // case.grid.every), width_of(case.plan)))
        given, records = (case.plan, self.state, self.work), (self.rows, self.fields)
        code = integrate_steps(case.scheme.method, given, self.inputs, case.grid.every, records)
        if code:
            raise RuntimeError(f"the integration ended with code {code}")
