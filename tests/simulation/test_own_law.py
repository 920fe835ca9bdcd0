"""Cable laws of one's own: run as they are, compiled where that is possible, and never as another law.

`cabledrive.simulation.own_law` compiles the formula, `cabledrive.simulation.kernels` takes the steps.
"""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.mechanics.cable_laws import cable_law
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.mesh import mesh_of
from cabledrive.reduction.fast_simulation import simulate_fast
from cabledrive.simulation import CarriageForce, Pluck, Recording, Scheme, Sine, Start
from cabledrive.simulation.case import case_of
from cabledrive.simulation.channels import width_of
from cabledrive.simulation.kernels import integrate
from cabledrive.simulation.methods import NAMES, integrate_steps, largest_stable_step
from cabledrive.simulation.own_law import compiled_law
from cabledrive.simulation.plan import DONE, INVERSE_SPACING, STEPS, new_workspace
from cabledrive.simulation.plan import SLACK as SLACK_SPAN
from cabledrive.simulation.segment_laws import law_components
from command import python
from network_samples import route
from oracles.readable_chain.verlet import integrate_reference

DRIVE = cd.load_drive("dissertation-2").listed
RUN = {
    "torque": Sine(amplitude=0.02, frequency=81.6),
    "start": Start(plucks=(Pluck(height=1e-3, shape="half-sine"),)),
    "scheme": Scheme(segments=12),
    "recording": Recording(rate=2000.0),
}


class OwnLinear(cd.CableLaw):
    def components(self, u_x, v_x, w_x):
        return self.pretension + self.stiffness * u_x, self.pretension * v_x, self.pretension * w_x


class OwnExact(cd.CableLaw):
    def components(self, u_x, v_x, w_x):
        stretch = np.sqrt((1.0 + u_x) ** 2 + v_x**2 + w_x**2)
        tension = self.pretension + self.stiffness * (stretch - 1.0)
        return tension * (1.0 + u_x) / stretch, tension * v_x / stretch, tension * w_x / stretch


class Interpreted(cd.ExactLaw):
    """`super` is beyond numba."""

    def components(self, u_x, v_x, w_x):
        return super().components(u_x, v_x, w_x)


@dataclass(frozen=True, kw_only=True)
class Duffing(cd.CableLaw):
    cubic: float = 2e4
    softer: float = 1.0

    def components(self, u_x, v_x, w_x):
        stretch = np.sqrt((1.0 + u_x) ** 2 + v_x**2 + w_x**2)
        strain = np.where(stretch > 1.0, stretch - 1.0, self.softer * (stretch - 1.0))
        tension = self.pretension + self.stiffness * strain * (1.0 + self.cubic * strain**2)
        return tension * (1.0 + u_x) / stretch, tension * v_x / stretch, tension * w_x / stretch


def run(model, duration=0.02, **options):
    return cd.simulate(DRIVE, duration, model=model, **{**RUN, **options})


DAMPED = replace(DRIVE, cable=replace(DRIVE.cable, axial_damping=0.5))
SLACK = {"scheme": Scheme(segments=12, slack="tension-only"), "start": Start(load_angle=0.5)}


@pytest.mark.parametrize(
    ("own", "name", "drive", "duration", "options"),
    [
        (OwnLinear, "linear", DRIVE, 0.02, {}),
        (OwnExact, "exact", DRIVE, 0.02, {}),
        (Interpreted, "exact", DRIVE, 0.02, {}),
        (OwnExact, "exact", DAMPED, 0.002, {}),
        (OwnExact, "exact", DRIVE, 0.005, SLACK),
    ],
    ids=["linear", "exact", "interpreted", "axial damping", "slack"],
)
def test_a_law_of_the_same_formula_gives_the_same_motion_to_round_off(own, name, drive, duration, options):
    ours, theirs = (cd.simulate(drive, duration, model=model, **{**RUN, **options}) for model in (own, name))
    assert [event.time for event in ours.slack_events] == [event.time for event in theirs.slack_events]
    assert bool(ours.slack_events) == (options is SLACK)
    assert drive is not DAMPED or "axial damping" in ours.interpreted
    of_straight = (
        1e4 if drive is DAMPED else 1.0
    )  # the packaged law takes the dampers' matrix of a straight rope
    for quantity in ("load_angle", "drive_angle"):
        a, b = getattr(ours, quantity), getattr(theirs, quantity)
        error = np.max(np.abs(a - b)) / np.max(np.abs(b))
        assert error < of_straight * (1e-10 if options else 1e-11), f"{quantity}: {error:.1e}"
    error = np.max(np.abs(ours.midpoint() - theirs.midpoint())) / 1e-3
    assert error < of_straight * 1e-10, f"midpoint: {error:.1e}"
    apart = abs(ours.energy_budget_error - theirs.energy_budget_error)
    assert apart < (1e-6 if options or drive is DAMPED else 1e-9), f"budget: {apart:.1e}"


def test_a_law_of_ones_own_moves_a_machine_with_routes_whose_ropes_are_alike(measured):
    asked = {"start": Start(plucks=(Pluck(height=1e-3, span="motor to lower idler"),))}
    asked |= {"scheme": Scheme(segments=12), "recording": Recording(rate=2000.0)}
    ours, theirs = (cd.simulate(route("printer"), 0.02, model=own, **asked) for own in (OwnExact, "exact"))
    apart = max(np.abs(ours.channel(name) - theirs.channel(name)).max() for name in ("head.x", "motor"))
    measured(f"{apart:.1e} m, rad")
    assert ours.interpreted is None
    assert apart < 1e-10 * np.abs(theirs.channel("motor")).max()
    with pytest.raises(cd.InputRefused, match="ropes of one kind and tension"):
        cd.simulate(cd.load_drive("camera-winches"), 1e-3, model=OwnExact)


@pytest.mark.kernel
def test_the_compiled_steps_under_a_law_equal_the_readable_ones():
    """Forty steps, with damping, friction and forces; up to the first segment that is slack."""
    drive = replace(DRIVE, carriage=(cd.Carriage(mass=2e-3, position=0.3, guided=False),))
    push = CarriageForce(signal=Sine(amplitude=0.01, frequency=50.0))
    case = case_of(
        drive.machine, 0.01, **{**RUN, "scheme": Scheme(model=OwnExact, segments=12)}, forces=[push]
    )
    ours, theirs, slack = (case.first_state() for _ in range(3))
    torque, forces = case.inputs(0, 40)
    compiled = compiled_law(case.plan, case.laws[0])
    formula, numbers = (by_python, np.zeros(1)) if isinstance(compiled, str) else compiled
    work = new_workspace(case.plan)
    law_components(formula, numbers, ours.x, case.plan.segment[INVERSE_SPACING], work.p)
    expected = case.laws[0].excess_components(*np.diff(ours.x, axis=1) * case.plan.segment[INVERSE_SPACING])
    np.testing.assert_allclose(work.p, np.stack(np.broadcast_arrays(*expected)), rtol=1e-10, atol=1e-12)
    rows, fields = np.zeros((1, width_of(case.plan))), np.zeros((0, 3, 25))
    law, inputs = (formula, numbers, None, None, False), (work, torque, forces, 0, rows, fields)
    assert integrate(*law, case.plan, ours, *inputs) == DONE
    assert ours.counts[STEPS] == 40
    integrate_reference(case.plan, theirs, work, torque, forces, 40, rows, fields, case.laws[0])
    for name in ("x", "x_t", "q", "extremes"):
        a, b = getattr(ours, name), getattr(theirs, name)
        np.testing.assert_allclose(a, b, atol=1e-11 * np.max(np.abs(b), initial=1e-300), err_msg=name)
    slack.x[0, 3] += 0.1
    assert integrate(*law, case.plan, slack, *inputs) == SLACK_SPAN
    assert slack.counts[STEPS] == 0


def by_python(numbers, x, inverse_spacing, p):
    """`OwnExact` for the kernel where nothing is compiled."""
    law = cable_law(DRIVE.cable, OwnExact)
    gradients = np.diff(x, axis=1) * inverse_spacing
    p[:] = law.excess_components(*gradients)
    return int(np.sum(law.is_slack(*gradients)))


@pytest.mark.kernel
@pytest.mark.parametrize("method", NAMES)
@pytest.mark.parametrize("number", [-1, 4])
def test_kernels_refuse_a_law_that_they_do_not_know(method, number):
    case = case_of(DRIVE.machine, 0.001, scheme=Scheme(segments=12))
    plan, state = case.plan._replace(law=number), case.first_state()
    inputs, records = (
        (np.zeros((1, 1)), np.zeros((1, 0))),
        (np.zeros((1, len(case.channels))), np.zeros((0, 3, 25))),
    )
    with pytest.raises(ValueError, match="no kernel knows"):
        integrate_steps(method, (plan, state, new_workspace(plan)), inputs, 1, records)


def test_the_step_is_chosen_for_the_stiffest_part_of_the_law():
    """Twice as stiff where it shortens: half the square of the stable step, though Hooke's elsewhere."""
    mesh = mesh_of(DRIVE.machine, 20)
    hooke, own = (
        cable_law(DRIVE.cable, "exact"),
        cable_law(DRIVE.cable, partial(Duffing, cubic=0.0, softer=2.0)),
    )
    ratio = largest_stable_step(mesh, 2 * [hooke]) / largest_stable_step(mesh, 2 * [own])
    assert ratio == pytest.approx(np.sqrt(2.0), rel=1e-6)


def test_a_law_that_outgrows_its_step_ends_the_run():
    """Stiff only beyond twice the pretension, where the step was not chosen for it."""

    class Hardens(cd.CableLaw):
        def components(self, u_x, v_x, w_x):
            over = np.maximum(u_x - 1.2 * self.pretension / self.stiffness, 0.0)
            tension = self.pretension + self.stiffness * (u_x + 40.0 * over)
            return tension, self.pretension * v_x, self.pretension * w_x

    scheme = Scheme(segments=12, slack="tension-only")  # whose step is a quarter of the stable one
    result = cd.simulate(DRIVE, 0.02, model=Hardens, start=Start(load_angle=0.5), scheme=scheme)
    assert "too stiff for the step" in result.stopped
    assert "give a step of at most" in result.stopped


def test_an_edited_formula_is_another_run():
    """A resumed run must not go on under another formula of the same name."""

    def named(factor):
        class Law(cd.CableLaw):
            def components(self, u_x, v_x, w_x):
                return (
                    self.pretension + factor * self.stiffness * u_x,
                    self.pretension * v_x,
                    self.pretension * w_x,
                )

        return case_of(DRIVE.machine, 0.001, scheme=Scheme(model=Law, segments=12)).fingerprint["law"]

    assert named(1.0) == named(1.0)
    assert named(1.0) != named(1.001)


def test_laws_that_cannot_be_run_are_refused():
    class Loose(cd.CableLaw):
        def components(self, u_x, v_x, w_x):
            return self.stiffness * u_x, self.pretension * v_x, self.pretension * w_x

    class Needs(OwnLinear):
        def __init__(self, wire, **cable):
            super().__init__(**cable)

    class Both(OwnLinear):
        def components(self, u_x, v_x, w_x):
            return self.pretension + u_x, v_x, w_x

        def excess_components(self, u_x, v_x, w_x):
            return 2.0 * u_x, v_x, w_x

    for model, words in (
        (Loose, "the straight cable carries"),
        (Needs, "cannot be made from pretension"),
        (Both, "disagree"),
        (3.0, "give the name of a law"),
        (dict, "return a CableLaw"),
        (OwnLinear(pretension=1.0, axial_rigidity=300.0), "has pretension = 1 N"),
    ):
        with pytest.raises(cd.InputRefused, match=words):
            run(model)
    for method in ("node-centred", "energy-conserving"):
        with pytest.raises(cd.InputRefused, match="does not know laws"):
            run(OwnLinear, scheme=Scheme(method=method))
    with pytest.raises(TypeError, match="define components"):

        class Report(cd.ExactLaw):
            def tension(self, u_x, v_x, w_x):
                return 0.0 * u_x


class WithOnes(cd.CableLaw):
    def components(self, u_x, v_x, w_x):
        one = np.ones_like(u_x)
        return self.pretension * one + self.stiffness * u_x, self.pretension * v_x, self.pretension * w_x


def test_a_formula_with_numpys_own_makers_of_arrays_is_compiled():
    case = case_of(DRIVE.machine, 0.01, **RUN | {"scheme": Scheme(segments=12, model=WithOnes)})
    assert why_plain() or isinstance(compiled_law(case.plan, case.laws[0]), tuple)


# --- On a machine where numba is not to be had, every method runs in numpy and gives the same
HIDDEN = """
import sys

class Hidden:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("numba", "llvmlite"):
            raise ImportError(name)

sys.meta_path.insert(0, Hidden())
import test_own_law as t
for rows in t.every_run():
    sys.stdout.write(rows.tobytes().hex() + "\\n")
assert "numba" not in sys.modules
"""


def every_run():
    run = {"torque": Sine(amplitude=0.02, frequency=81.7), "start": Start(plucks=(Pluck(height=1e-3),))}
    for method in NAMES:
        yield cd.simulate(DRIVE, 2e-3, scheme=Scheme(segments=12, method=method), **run).rows
    yield simulate_fast(DRIVE, 2e-2, **run).rows


def test_every_method_gives_the_same_without_numba(measured):
    pytest.importorskip("numba")
    lines = python(HIDDEN, paths=[Path(__file__).parent]).split()
    assert len(lines) == len(NAMES) + 1
    apart = []
    for line, rows in zip(lines, every_run(), strict=True):
        found = np.frombuffer(bytes.fromhex(line)).reshape(rows.shape)
        scale = np.max(np.abs(rows), axis=0) + 1e-12
        apart.append(np.max(np.abs(found - rows) / scale))
    measured("within " + ", ".join(f"{one:.1e}" for one in apart) + f": {', '.join(NAMES)}, fast model")
    assert max(apart) < 1e-9, apart
