r"""Plants drawn from what is known of a drive, and the law of a study in closed loop on them.

An interval is the regression's 95 % and, on top, what cannot be distinguished from a number: other filters, a
residual that hides. Of the second part nobody knows how it goes together with that of another number; it is
taken as independent. The whole covariance is then the regression's and a diagonal, and with the half widths
:math:`h` of the regression's intervals and :math:`H` of the whole ones the correlation is

.. math:: \rho_{ij} = \frac{C_{ij}}{\sqrt{C_{ii}C_{jj}}}\,\frac{h_i}{H_i}\,\frac{h_j}{H_j}, \qquad i \ne j .
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from cabledrive.control.darc import Bounds
from cabledrive.identification.estimates import Fit, Identification
from cabledrive.parameters import Drive
from cabledrive.parameters.arrays import Array
from cabledrive.reduction.lumped_chain import FLEXIBLE_JOINT
from cabledrive.rig.closed_loop.loop import Loop, close_loop, run, with_plant
from cabledrive.rig.laws import controllers
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.setting import CABLE, Motion, RigOptions
from cabledrive.rig.tuning import LawSetting, law_at
from cabledrive.studies.study.machine import LOG, Quantity, drive_with

RIPPLE_ORDER = 12.0
"""Periods per radian where none is drawn."""
MOTOR_SIDE = ("viscous_friction", "coulomb_friction", "offset_torque")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadCase:
    """A load that is to follow a motion, and what is known of its drive."""

    drive: Drive  # with the best values
    motion: Motion
    torque: float | None = None  # largest of the goals [N m]; None: the motor's limit
    quantities: Mapping[str, Quantity]
    correlations: Sequence["Correlation"] = ()

    @property
    def spec(self) -> DesignSpec:
        """For what laws are designed: encoders with random phases, stick-slip, delay; slack ends a run."""
        near = "motor" if "motor" in controllers.fitted_encoders(self.drive) else "drive"
        options = RigOptions(feedback=near, forbid_slack=True)
        return DesignSpec(self.drive, self.motion, options=options)

    def law(self, setting: LawSetting) -> Controller:
        """A law at its setting, which has a value."""
        assert setting.bandwidth is not None
        if setting.model is not None:
            return self.chain_law(setting.model, setting.bandwidth)
        return law_at(setting.controller, setting.bandwidth, setting.filter, self.spec)

    def chain_law(self, model: int, hertz: float) -> Controller:
        """The damped law of a model of the chain at a bandwidth [Hz], its projection bounds as known."""
        quantities = self.quantities
        low, high = quantities["near_inertia"].outer
        if FLEXIBLE_JOINT[model]:
            share = quantities["motor_share"].outer
            low, high = low * share[0], high * share[1]
        elif model == 1:
            gear, load = controllers.load_gear(self.drive), quantities["load_inertia"].outer
            low, high = low + load[0] / gear**2, high + load[1] / gear**2
        chain = controllers.plant_chain(self.drive, model)
        nominal = np.array([chain.inertias[0], chain.viscous[0], chain.coulomb[0], chain.offsets[0]])
        lows, highs = np.array([[low, high], *(quantities[name].outer for name in MOTOR_SIDE)]).T
        bounds = Bounds(nominal=nominal, low=np.minimum(lows, nominal), high=np.maximum(highs, nominal))
        return controllers.chain_law(replace(self.spec, bandwidth=hertz), model, damped=True, bounds=bounds)

    def loop(self, law: Controller, *, ideal: bool = False, cable: bool = False) -> Loop:
        """A law on its drive, with the torque limit of the goals; ``ideal``: it sees true angles."""
        spec = replace(self.spec, options=replace(self.spec.options, ideal_sensors=ideal))
        loop = close_loop(spec, law, np.random.default_rng(0), CABLE if cable else None)
        limit = loop.rig.torque_limit if self.torque is None else min(self.torque, loop.rig.torque_limit)
        return replace(loop, rig=loop.rig._replace(torque_limit=float(limit)))


def with_values(loop: Loop, values: Mapping[str, float], phases: np.ndarray | None) -> Loop:
    """The same law on another plant, its encoders at phases from -1/2 to 1/2, its delay by whole samples.

    Ripple of the motor's torque goes with the angle that is wanted, which the motor keeps nearly.
    """
    plant = drive_with(loop.spec.drive, values)
    chain = controllers.plant_chain(plant, None)
    play = 0.0 if loop.cable is not None else controllers.joint_backlash(plant, chain)
    fresh = with_plant(loop, chain, play)
    if "slip_torque" in values:  # a run in which the rope slides ends
        slides = values["slip_torque"] / chain.stiffness[-1]
        limit = min(fresh.plant.twist_limit, slides)
        fresh = replace(fresh, plant=fresh.plant._replace(twist_limit=limit))
    rig = fresh.rig if phases is None else fresh.rig._replace(phases=phases)
    if "delay" in values:
        known = rig.late_samples * rig.interval + rig.late_part
        more = round((values["delay"] - known) / rig.interval)
        rig = rig._replace(late_samples=max(rig.late_samples + more, 0))
    if values.get("ripple_torque"):
        order, phase = values.get("ripple_order", RIPPLE_ORDER), values.get("ripple_phase", 0.0)
        ripple = values["ripple_torque"] * np.sin(order * loop.target[: len(rig.forces)] + phase)
        rig = rig._replace(forces=rig.forces + np.column_stack((ripple, np.zeros_like(ripple))))
    return replace(fresh, rig=rig)


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """What one run left."""

    # peak, rest: largest error [rad] or [m], and the largest while a carriage is to stand [m]; None: the run
    # ended before its time, or nothing is to stand
    peak: float | None
    # torque, tension: largest torque [N m] and, of a carriage, smallest tension of a strand [N]
    torque: float | None
    saturated: float  # share of the samples at the torque's limit
    rest: float | None = None
    tension: float | None = None


class LoadLoop:
    """A law on the plants of a drive."""

    def __init__(self, case: LoadCase, law: LawSetting, cable: bool) -> None:
        self.loop = case.loop(case.law(law), cable=cable)
        self.encoders = len(self.loop.rig.phases)

    def run(self, values: Mapping[str, float], phases: Array) -> Score:
        """Eccentricity of the load's encoder, which the law follows, and creep are added to the error."""
        moved = with_values(self.loop, values, phases)
        done = run(moved, log=False)
        found = done.score
        share = found["saturated"] / len(moved.target)
        if done.failed:
            return Score(peak=None, torque=None, saturated=share)
        peak = found["peak"] / moved.gear + values.get("eccentricity", 0.0)
        if "creep" in values:  # the largest angle by which the rope is then off along the motion
            speed = np.gradient(moved.target, moved.rig.interval)
            pull = moved.chain.inertias[-1] * np.gradient(speed, moved.rig.interval)
            path = np.cumsum(pull * np.abs(speed)) * moved.rig.interval
            peak += float(values["creep"] * np.abs(path).max() / moved.gear)
        return Score(peak=peak, torque=found["peak_torque"], saturated=share)

    def history(self, values: Mapping[str, float], phases: Array) -> dict[str, Array]:
        """The wanted angle of the load, its error, and the command."""
        moved = with_values(self.loop, values, phases)
        log, rig = run(moved).log, moved.rig
        return {
            "time": rig.interval * np.arange(len(log), dtype=np.float64),
            "reference": moved.target / moved.gear,
            "error": moved.load_error(log),
            "torque": log[:, 2 * moved.chain.size + 1 + len(rig.encoders)],
        }


Interval = tuple[float, float, float]
ROUNDING = 1e-9
"""Largest negative eigenvalue of a matrix of correlations that counts as rounding."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """How two numbers of a log err together."""

    # first, second: Quantities, in the order of the alphabet
    first: str
    second: str
    value: float  # from -1 to 1


def of_intervals(fit: Fit, intervals: Mapping[str, Interval]) -> tuple[Correlation, ...]:
    """Correlations of what is identified from a whole drive's log.

    The cable comes out over the load's inertia, whose error it shares; the joint is independent.
    """
    common = _half_products(fit.covariance, fit.half_width())
    names = [name for name in fit.names if name in intervals]
    place = fit.names.index
    products = {(a, b): float(common[place(a), place(b)]) for a, b in permutations(names, 2)}
    whole = {name: 0.5 * (high - low) for name, (_, low, high) in intervals.items()}
    cable = [name for name in ("cable_stiffness", "cable_damping") if name in intervals]
    shares = {name: intervals[name][0] / intervals["load_inertia"][0] for name in cable}
    for name in cable:
        for other in names:
            along = products.get(("load_inertia", other), whole["load_inertia"] ** 2)
            products[name, other] = shares[name] * along
    if len(cable) == 2:
        products[cable[0], cable[1]] = shares[cable[0]] * shares[cable[1]] * whole["load_inertia"] ** 2
    return _over(products, whole)


def of_an_axis(
    found: Identification, parts: Mapping[str, float], known: Mapping[str, Quantity]
) -> tuple[Correlation, ...]:
    """Correlations of what is identified from a log of one rigid axis."""
    names = list(found.parameters)
    halves = np.array([0.5 * (e.high - e.low) for e in found.parameters.values()])
    common = _half_products(found.covariance, halves)
    weights = {name: (names.index("inertia"), part) for name, part in parts.items()}
    weights |= {name: (names.index(name), 1.0) for name in names if name in known}
    products = {
        (a, b): float(weights[a][1] * weights[b][1] * common[weights[a][0], weights[b][0]])
        for a, b in permutations(weights, 2)
    }
    return _over(products, {name: known[name].half_width for name in weights})


def _half_products(covariance: Array, halves: Array) -> Array:
    """Correlation times both half widths; 0 where a number has no variance."""
    errors = np.sqrt(np.diag(covariance))
    scale = np.divide(halves, errors, out=np.zeros_like(errors), where=errors > 0.0)
    return np.asarray(covariance * np.outer(scale, scale), dtype=np.float64)


def _over(products: Mapping[tuple[str, str], float], whole: Mapping[str, float]) -> tuple[Correlation, ...]:
    found = {(min(a, b), max(a, b)): p / (whole[a] * whole[b]) for (a, b), p in products.items() if p != 0.0}
    return tuple(Correlation(first=a, second=b, value=found[a, b]) for a, b in sorted(found))


def among(correlations: Sequence[Correlation], quantities: Mapping[str, Quantity]) -> tuple[Correlation, ...]:
    """Those of two numbers that both stayed the log's."""
    from_log = {name for name, quantity in quantities.items() if quantity.source == LOG}
    return tuple(one for one in correlations if {one.first, one.second} <= from_log)


def root_of(correlations: Sequence[Correlation], names: Sequence[str]) -> Array:
    """Symmetric root of the correlations, shape (names, names): it makes independent numbers correlated."""
    matrix = np.eye(len(names))
    for one in correlations:
        i, j = names.index(one.first), names.index(one.second)
        matrix[i, j] = matrix[j, i] = one.value
    sizes, directions = np.linalg.eigh(matrix)
    if sizes.size and sizes[0] < -ROUNDING:
        raise ValueError(f"smallest eigenvalue {sizes[0]:.3g} of the correlations is negative: mend them")
    return np.asarray(directions * np.sqrt(np.maximum(sizes, 0.0)) @ directions.T, dtype=np.float64)


TWO_SIDED_95 = 1.96
RIPPLE_ORDERS = (1.0, 50.0)
"""Periods of torque ripple per radian of the motor: from once a turn and more to slots behind a gear."""


def sampled_plant(
    quantities: Mapping[str, Quantity],
    encoders: int,
    seed: int,
    draw: int,
    correlations: Sequence[Correlation] = (),
) -> tuple[dict[str, float], np.ndarray]:
    """One plant from what is known, and encoder phases, (encoders,); each draw has its own generator."""
    generator, names = np.random.default_rng([seed, draw]), sorted(quantities)
    from_log = [name for name in names if quantities[name].source == LOG]
    chance = {name: generator.standard_normal() if name in from_log else generator.random() for name in names}
    if correlations:
        mixed = root_of(correlations, from_log) @ [chance[name] for name in from_log]
        chance |= dict(zip(from_log, mixed, strict=True))
    values = {}
    for name in names:  # normal where a log gave the interval, else anywhere within the bounds
        q = quantities[name]
        start, width = (q.value, q.half_width / TWO_SIDED_95) if q.source == LOG else (q.low, q.high - q.low)
        most = 0.999 if name == "motor_share" else np.inf
        values[name] = float(np.clip(start + width * chance[name], q.least, most))
    phases = generator.uniform(-0.5, 0.5, encoders)
    if "ripple_torque" in values:
        order = float(generator.uniform(*RIPPLE_ORDERS))
        values.setdefault("ripple_order", order)
        values["ripple_phase"] = float(generator.uniform(0.0, 2.0 * np.pi))
    return values, phases
