"""A cable law of the user's own: its formula compiled where numba can, interpreted where not, never replaced.

The formula that is compiled is the method of the law itself, applied to one segment at a time; before it is
used it is compared with what the method gives on arrays. At the steps at which something is recorded or a
segment is slack the law itself is asked, and so it is at every step where its formula is not compiled.
"""

from collections.abc import Callable
from functools import lru_cache
from hashlib import sha256
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.compiled import why_plain
from cabledrive.mechanics.tension_only import taut_law
from cabledrive.simulation.channels import BALANCE
from cabledrive.simulation.method import DONE, NOT_FINITE, SLACK, TOO_STIFF
from cabledrive.simulation.plan import INVERSE_SPACING, SPACING, Plan
from cabledrive.simulation.state import (
    EVENTS,
    LOWER_SLACK,
    MOST_EVENTS,
    STEPS,
    UPPER_SLACK,
    State,
)
from cabledrive.simulation.workspace import ENERGY, TENSION, Workspace

AGREEMENT = 1e-12
"""Largest difference between compiled and interpreted components, over the largest component."""


class CompiledLaw(NamedTuple):
    """A formula as the kernel takes it."""

    formula: Any
    numbers: Array


def law_fingerprint(law: CableLaw) -> dict[str, Any]:
    """What distinguishes one law from another, also after its formula has been edited: plain data."""
    taut = taut_law(law)
    kind = type(taut)
    excess = np.stack(np.broadcast_arrays(*taut.excess_components(*_samples())))
    return {
        "class": f"{kind.__module__}.{kind.__qualname__}",
        "components": sha256(np.ascontiguousarray(excess).tobytes()).hexdigest(),
    }


def why_interpreted(plan: Plan, law: CableLaw) -> str | None:
    """Why the steps under an own law are not compiled; None if they are."""
    compiled = compiled_law(plan, law)
    return compiled if isinstance(compiled, str) else None


def compiled_law(plan: Plan, law: CableLaw) -> CompiledLaw | str:
    """The compiled formula of a law, or why there is none."""
    if plain := why_plain():
        return plain
    if plan.axial_damping > 0.0:
        return "axial damping under an own law is not compiled"
    taut = taut_law(law)
    kind = type(taut)
    if kind.tension is not CableLaw.tension or kind.is_slack is not CableLaw.is_slack:
        return f"{kind.__name__} gives its tension in closed form, which is not compiled"
    own_excess = kind.source == "excess_components"
    source: Any = getattr(kind, kind.source)
    if not isinstance(source, FunctionType):
        return f"{kind.__name__}.components is no plain function"
    names = ("pretension", *sorted(set(source.__code__.co_names) & _numbers(taut).keys() - {"pretension"}))
    numbers = np.array([float(getattr(taut, name)) for name in names])
    formula = _compiled(source, names, own_excess)
    if isinstance(formula, str):
        return formula
    return CompiledLaw(formula, numbers) if _agrees(formula, numbers, taut) else _DISAGREES


_DISAGREES = "the compiled formula does not agree with the interpreted one"


def _numbers(law: CableLaw) -> dict[str, float]:
    """Attributes of a law that are numbers."""
    found = {}
    for name in dir(law):
        if not name.startswith("__") and isinstance(value := getattr(law, name), int | float | np.number):
            found[name] = float(value)
    return found


@lru_cache(maxsize=64)
def _compiled(source: FunctionType, names: tuple[str, ...], own_excess: bool) -> Any:
    """Loop over the segments around a formula, compiled; a line that says why where it cannot be."""
    import numba
    from numba import types

    of_floats = {k: _numpy_of_floats() if v is np else v for k, v in source.__globals__.items()}
    plain = FunctionType(source.__code__, of_floats, source.__name__, source.__defaults__, source.__closure__)
    components = numba.njit(error_model="numpy", nogil=True)(plain)
    record = np.dtype([(name, np.float64) for name in names])
    held_back = 0.0 if own_excess else 1.0

    def loop(numbers: Array, x: Array, inverse_spacing: Array, p: Array) -> int:
        own = numbers.view(record)[0]
        slack = 0
        for i in range(p.shape[1]):
            h = inverse_spacing[i]
            u_x = (x[0, i + 1] - x[0, i]) * h
            v_x = (x[1, i + 1] - x[1, i]) * h
            w_x = (x[2, i + 1] - x[2, i]) * h
            t_x, t_y, t_z = components(own, u_x, v_x, w_x)
            excess = t_x - held_back * own.pretension
            slack += (own.pretension + excess) * (1.0 + u_x) + t_y * v_x + t_z * w_x < 0.0
            p[0, i] = excess
            p[1, i] = t_y
            p[2, i] = t_z
        return slack

    rows, row = types.float64[:, ::1], types.float64[::1]
    try:
        return numba.cfunc(types.intp(row, rows, row, rows), error_model="numpy")(loop)
    except Exception as error:  # whatever numba makes of a formula it does not know
        words = [line.strip() for line in str(error).splitlines() if line.strip()]
        return f"numba cannot compile it ({type(error).__name__}: {' '.join(words)[:160]})"


def _numpy_of_floats() -> ModuleType:
    """The module numpy, with the functions on single numbers for which numba makes arrays."""
    import numba

    module = ModuleType("numpy_of_floats")
    vars(module).update(vars(np))
    scalar: dict[str, Callable[..., Any]] = {
        "where": lambda condition, yes, no: yes if condition else no,
        "zeros_like": lambda value: 0.0 * value,
        "ones_like": lambda value: 0.0 * value + 1.0,
    }
    vars(module).update({name: numba.njit(function) for name, function in scalar.items()})
    return module


def _samples() -> Array:
    """Gradients from small to steep, taut and slack, shape (3, 120)."""
    rng = np.random.default_rng(20)
    return rng.uniform(-1.0, 1.0, (3, 120)) * np.repeat([1e-6, 1e-4, 1e-2, 0.3], 30)


def _agrees(formula: Any, numbers: Array, law: CableLaw) -> bool:
    """Whether the compiled formula gives what the law gives."""
    from cabledrive.simulation.kernels.own_law import components_under

    gradients = _samples()
    x = np.concatenate([np.zeros((3, 1)), np.cumsum(gradients, axis=1)], axis=1)
    gradients = np.diff(x, axis=1)
    found, ones = np.zeros_like(gradients), np.ones(gradients.shape[1])
    with np.errstate(all="ignore"):
        components_under(formula, numbers, x, ones, found)
        expected = np.stack(np.broadcast_arrays(*law.excess_components(*gradients)))
    scale = law.pretension + np.abs(expected)
    return bool(np.all(np.isnan(found) == np.isnan(expected))) and not np.any(
        np.abs(found - expected) > AGREEMENT * scale
    )


def integrate_own(
    law: CableLaw,
    plan: Plan,
    state: State,
    work: Workspace,
    torque: Array,
    forces: Array,
    every: int,
    rows: Array,
    fields: Array,
) -> int:
    """Stoermer-Verlet under an own law, see `cabledrive.simulation.method.Method.integrate`.

    Returns also TOO_STIFF, before the step of a record at which the step is too long for the law.
    """
    compiled = compiled_law(plan, law)
    j = 0
    while j < torque.size:
        recording = j % every == 0
        if recording and stiffness_over_limit(plan, law, state.x).max() > 1.0 + 1e-6:
            return TOO_STIFF
        row = rows[j // every] if recording else None
        if not _step(plan, law, state, work, torque[j], forces[j], row):
            return SLACK
        if row is not None:
            if fields.shape[0] > 0:
                fields[j // every] = work.before[0]
            if not abs(row[BALANCE]) < 1e300:
                return NOT_FINITE
        j += 1
        if not isinstance(compiled, str):
            from cabledrive.simulation.kernels.own_law import steps_under

            end = min(torque.size, j - 1 - (j - 1) % every + every)
            j += steps_under(*compiled, plan, state, work, torque[j:end], forces[j:end])
    return DONE


def _step(
    plan: Plan, law: CableLaw, state: State, work: Workspace, torque: float, forces: Array, row: Array | None
) -> bool:
    """One step under the law as it is, recorded in ``row``; false before one that slack is to stop."""
    from cabledrive.simulation.kernels.observe import record_given
    from cabledrive.simulation.kernels.own_law import keep_instant, step_given

    keep_instant(plan, state, work)
    gradients = np.diff(state.x, axis=1) * plan.segment[INVERSE_SPACING]
    slack = _note_slack(plan, law, state, gradients)
    if slack and plan.stop_when_slack:
        return False
    work.p[:] = np.stack(np.broadcast_arrays(*law.excess_components(*gradients)))
    if plan.axial_damping > 0.0:
        work.direction[:] = np.stack(np.broadcast_arrays(*law.strain_gradient(*gradients)))
    step_given(plan, state, work, torque, forces)
    if row is not None:
        work.q[TENSION], work.q[ENERGY] = law.tension(*gradients), law.energy_density(*gradients)
        record_given(plan, work, state.x_t, state.motor, state.tallies, torque, row)
    return True


def _note_slack(plan: Plan, law: CableLaw, state: State, gradients: Array) -> bool:
    """Note where and when a span goes slack that was taut at the step before; whether one is slack now."""
    pushes = law.is_slack(*gradients).reshape(plan.spans, -1)
    slack = pushes.any(axis=1)
    for span in np.flatnonzero(slack & (state.counts[UPPER_SLACK:][: plan.spans] == 0)):
        if state.counts[EVENTS] < MOST_EVENTS:
            tension = taut_law(law).tension(*gradients).reshape(plan.spans, -1)[span]
            place = int(np.argmin(tension))
            state.events[state.counts[EVENTS]] = state.counts[STEPS], span, place, tension[place]
        state.counts[EVENTS] += 1
    state.counts[UPPER_SLACK : LOWER_SLACK + 1][: plan.spans] = slack
    return bool(slack.any())


def stiffness_over_limit(plan: Plan, law: CableLaw, x: Array) -> Array:
    """Slope of each segment's tension along itself, over the largest for which the step is stable.

    ``x``, shape (3, nodes): displacements [m]. Returns shape (segments,).
    """
    gradients = np.diff(x, axis=1) * plan.segment[INVERSE_SPACING]
    stretch = np.sqrt((1.0 + gradients[0]) ** 2 + gradients[1] ** 2 + gradients[2] ** 2)
    along = (gradients + np.array([[1.0], [0.0], [0.0]])) / stretch
    step = 1e-6 * along
    ahead, behind = (np.stack(law.excess_components(*(gradients + d))) for d in (step, -step))
    slope = np.sum((ahead - behind) * along, axis=0) / 2e-6
    limit = plan.density * (plan.segment[SPACING] / plan.step) ** 2
    return np.asarray(slope / limit)
