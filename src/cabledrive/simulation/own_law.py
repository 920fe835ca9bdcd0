"""A cable law of the user's own: its formula compiled where numba can, interpreted where not, never replaced.

The formula that is compiled is the method of the law itself, applied to one segment at a time; before it is
used it is compared with what the method gives on arrays.
"""

from functools import lru_cache
from hashlib import sha256
from types import FunctionType
from typing import Any

import numpy as np

from cabledrive.mechanics.cable_law import Array, CableLaw
from cabledrive.mechanics.cable_laws import taut_law
from cabledrive.mechanics.compiled import why_plain
from cabledrive.simulation import damped as of
from cabledrive.simulation import plan as at
from cabledrive.simulation.plan import Plan, State

AGREEMENT = 1e-12
"""Largest difference between compiled and interpreted components, over the largest component."""


def law_fingerprint(law: CableLaw) -> dict[str, Any]:
    """What distinguishes one law from another, also after its formula has been edited: plain data."""
    taut = taut_law(law)
    excess = np.stack(np.broadcast_arrays(*taut.excess_components(*_samples())))
    return {
        "class": f"{type(taut).__module__}.{type(taut).__qualname__}",
        "components": sha256(np.ascontiguousarray(excess).tobytes()).hexdigest(),
    }


def why_interpreted(plan: Plan, law: CableLaw) -> str | None:
    """Why the steps under an own law are not compiled; None if they are."""
    compiled = compiled_law(plan, law)
    return compiled if isinstance(compiled, str) else None


def compiled_law(plan: Plan, law: CableLaw) -> tuple[Any, Array] | str:
    """The compiled formula of a law and its numbers, or why there is none."""
    if plain := why_plain():
        return plain
    if plan.axial != of.UNDAMPED:
        return "axial damping under an own law is not compiled"
    taut = taut_law(law)
    kind = type(taut)
    if kind.tension is not CableLaw.tension or kind.is_slack is not CableLaw.is_slack:
        return f"{kind.__name__} gives its tension in closed form, which is not compiled"
    source: Any = getattr(kind, kind.source)
    if not isinstance(source, FunctionType):
        return f"{kind.__name__}.components is no plain function"
    found = {name: getattr(taut, name) for name in dir(taut) if not name.startswith("__")}
    known = {name: float(v) for name, v in found.items() if isinstance(v, int | float | np.number)}
    names = ("pretension", *sorted(set(source.__code__.co_names) & known.keys() - {"pretension"}))
    formula = _compiled(source, names, kind.source == "excess_components")
    if isinstance(formula, str):
        return formula
    made = formula, np.array([known[name] for name in names])
    return made if _agrees(made, taut) else "the compiled formula does not agree with the interpreted one"


@lru_cache(maxsize=64)
def _compiled(source: FunctionType, names: tuple[str, ...], own_excess: bool) -> Any:
    """Loop over the segments around a formula, compiled; a line that says why where it cannot be."""
    import numba
    from numba import types

    scalar = {  # for which numba makes arrays of single numbers
        "where": lambda condition, yes, no: yes if condition else no,
        "zeros_like": lambda value: 0.0 * value,
        "ones_like": lambda value: 0.0 * value + 1.0,
    }
    of_floats = type(np)("numpy_of_floats")
    vars(of_floats).update(vars(np) | {name: numba.njit(function) for name, function in scalar.items()})
    names_in = {k: of_floats if v is np else v for k, v in source.__globals__.items()}
    plain = FunctionType(source.__code__, names_in, source.__name__, source.__defaults__, source.__closure__)
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
            p[0, i], p[1, i], p[2, i] = excess, t_y, t_z
        return slack

    rows, row = types.float64[:, ::1], types.float64[::1]
    try:
        return numba.cfunc(types.intp(row, rows, row, rows), error_model="numpy")(loop)
    except Exception as error:  # whatever numba makes of a formula it does not know
        words = [line.strip() for line in str(error).splitlines() if line.strip()]
        return f"numba cannot compile it ({type(error).__name__}: {' '.join(words)[:160]})"


def _samples() -> Array:
    """Gradients from small to steep, taut and slack, shape (3, 120)."""
    rng = np.random.default_rng(20)
    return rng.uniform(-1.0, 1.0, (3, 120)) * np.repeat([1e-6, 1e-4, 1e-2, 0.3], 30)


def _agrees(made: tuple[Any, Array], law: CableLaw) -> bool:
    """Whether the compiled formula gives what the law gives."""
    from cabledrive.simulation.segment_laws import law_components

    gradients = _samples()
    x = np.concatenate([np.zeros((3, 1)), np.cumsum(gradients, axis=1)], axis=1)
    gradients = np.diff(x, axis=1)
    found, ones = np.zeros_like(gradients), np.ones(gradients.shape[1])
    with np.errstate(all="ignore"):
        law_components(*made, x, ones, found)
        expected = np.stack(np.broadcast_arrays(*law.excess_components(*gradients)))
    apart = np.abs(found - expected) > AGREEMENT * (law.pretension + np.abs(expected))
    return bool(np.all(np.isnan(found) == np.isnan(expected))) and not apart.any()


def slack_of(plan: Plan, law: CableLaw, state: State, gradients: Array) -> bool:
    """Note where and when a span goes slack that was taut at the step before; whether one is slack now."""
    spans = [slice(first, last) for first, last in plan.nodes.tolist()]
    slack = np.array([law.is_slack(*gradients[:, own]).any() for own in spans])
    for span in np.flatnonzero(slack & (state.slack == 0)):
        if state.counts[at.EVENTS] < at.MOST_EVENTS:
            tension = taut_law(law).tension(*gradients[:, spans[span]])
            place = int(np.argmin(tension))
            state.events[state.counts[at.EVENTS]] = state.counts[at.STEPS], span, place, tension[place]
        state.counts[at.EVENTS] += 1
    state.slack[:] = slack
    return bool(slack.any())


def stiffness_over_limit(plan: Plan, law: CableLaw, x: Array) -> Array:
    """Slope of each segment's tension along itself, (segments,), over the largest that is stable."""
    gradients = np.diff(x, axis=1) * plan.segment[at.INVERSE_SPACING]
    along = gradients + np.array([[1.0], [0.0], [0.0]])
    along /= np.linalg.norm(along, axis=0)
    step = 1e-6 * along
    ahead, behind = (np.stack(law.excess_components(*(gradients + d))) for d in (step, -step))
    slope = np.sum((ahead - behind) * along, axis=0) / 2e-6
    gained = np.maximum(plan.node[at.KICK_U, 1:], plan.node[at.KICK_U, :-1])
    return np.asarray(slope * gained * plan.segment[at.INVERSE_SPACING] * plan.step)
