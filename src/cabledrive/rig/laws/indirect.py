"""The law that identifies in the loop: one pulse to learn from, then law, reference and filter made anew."""

from dataclasses import dataclass, replace
from math import isclose
from typing import Any

import numpy as np

from cabledrive.control.darc import Bounds, printed_bounds
from cabledrive.control.observers import Sampling
from cabledrive.control.regression import Estimates, acting_torque, estimate_load, estimate_motor
from cabledrive.parameters import Drive, InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain
from cabledrive.rig.closed_loop.loop import Loop, Run, run
from cabledrive.rig.disturbances import control_delay, current_rate
from cabledrive.rig.laws.controllers import Controller, DesignSpec, chain_law, fit_observer, fitted_encoders
from cabledrive.rig.laws.eigenvalues import damped_law

NAME = "darc-indirect"
SPREADS = {3: (0.2, 0.05, 0.05), 2: (0.06, 0.05)}
"""Relative half widths within which the inertias, motor to load, are believed, by their number."""
LEAST_SPREAD = 0.02
CERTAIN, DAMPING_CERTAIN, SIGNIFICANT, MOTOR_CERTAIN = 0.02, 0.3, 3.0, 0.05
"""Half widths over values with which stiffness, damping and the motor's inertia and friction are known, and
friction of the load over its error."""
CABLE = ("beta", "gamma", "load_coulomb", "load_viscous")
MOTOR = ("inertia", "viscous_friction", "coulomb_friction", "offset_torque")
SEED = 20


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Learnt:
    """What one pulse gave."""

    load: Estimates  # of the cable and the load's friction, over the load's inertia
    motor: Estimates  # of whole inertia and friction

    @property
    def excited(self) -> bool:
        """Whether the load's equation holds and shows the cable's stiffness: from less, nothing is learnt."""
        return self.load.known(CERTAIN, 0) and self.load.believed

    @property
    def motor_excited(self) -> bool:
        """Whether inertia and friction are known."""
        return self.motor.known(np.inf, 1) and self.motor.known(MOTOR_CERTAIN, 0, 2)

    @property
    def words(self) -> dict[str, Any]:
        """What was learnt, with 95 % intervals, and whether it was used; None where nothing is known.

        Friction of the load is over its inertia [rad/s^2], [1/s]; motor values are those of the whole drive.
        """
        found: dict[str, Any] = {}
        for name, value, low, high in zip(CABLE, self.load.values, *self.load.intervals, strict=True):
            found |= {name: _known(value), f"{name}_low": _known(low), f"{name}_high": _known(high)}
        found |= {"misfit": _known(self.load.misfit), "used": self.excited}
        found["motor_used"] = self.excited and self.motor_excited
        if not self.excited:
            found["used_reason"] = self.refusal
        for name, value, low, high in zip(MOTOR, self.motor.values, *self.motor.intervals, strict=True):
            found[name] = {"value": _known(value), "low": _known(low), "high": _known(high)}
        return found

    @property
    def refusal(self) -> str:
        """Why what was learnt is not used."""
        if self.load.believed:
            return "the motion is too small to identify the cable's stiffness to 2 %"
        return (
            f"the residual of the load's equation is {self.load.misfit:.3g} times what rounding to counts "
            "leaves: the load does not obey it"
        )


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def indirect(spec: DesignSpec) -> Controller:
    """The law before anything has been learnt: the damping-aware one of its highest model."""
    return replace(damped_law(spec, spec.number), name=NAME)


def learn(loop: Loop, early: Run, pause: int, drive: Drive, chain: LumpedChain) -> Learnt:
    """What readings and commands of the first pulse say of cable and motor."""
    shafts = loop.controller.shafts
    if loop.encoder_shafts != shafts or not np.all(loop.rig.counts > 0.0):
        raise InputRefused(
            f"{NAME} learns from the counts of the encoders of {', '.join(shafts)}, and reads "
            f"{len(loop.encoder_shafts)} encoders here: fit those, leave ideal sensors out"
        )
    first, last = 2 * loop.chain.size + 1, 2 * loop.chain.size + 1 + len(shafts)
    readings, command = early.log[:pause, first:last], early.log[:pause, last]
    counts, interval, generator = loop.rig.counts, loop.rig.interval, np.random.default_rng(SEED)
    torque = acting_torque(command, interval, delay=control_delay(drive), current_rate=current_rate(drive))
    load = estimate_load(readings[:, -2:], counts[-2:], interval, generator)
    inertias, spread = np.array(chain.inertias), np.array(SPREADS[chain.size])
    motor = estimate_motor(readings, torque, counts, inertias, interval, generator, spread=spread)
    return Learnt(load=load, motor=motor)


def learnt_chain(chain: LumpedChain, found: Learnt) -> LumpedChain:
    """The chain as it is after learning: cable per load inertia, motor; load and drive inertia as believed.

    What has not been excited stays as it was. Friction of the load is taken where it stands out of its error,
    and off the whole friction, of which the rest is the motor's.
    """
    motor, inertia = found.motor, chain.inertias[-1]
    if found.excited:
        beta, gamma, coulomb, viscous = (found.load.values * inertia).tolist()
        stuck, slowed = (found.load.values > SIGNIFICANT * found.load.errors)[2:]
        damping = gamma if found.load.known(DAMPING_CERTAIN, 1) else chain.damping[-1]
        chain = replace(
            chain,
            stiffness=(*chain.stiffness[:-1], beta),
            damping=(*chain.damping[:-1], damping),
            coulomb=(*chain.coulomb[:-1], coulomb if stuck else 0.0),
            viscous=(*chain.viscous[:-1], viscous if slowed else 0.0),
        )
    own = float(motor.values[0]) - sum(chain.inertias[1:])
    if found.motor_excited and own > 0.0:
        _, viscous, coulomb, offset = (float(v) for v in motor.values)
        viscous, coulomb = viscous - sum(chain.viscous[1:]), coulomb - sum(chain.coulomb[1:])
        chain = replace(
            chain,
            inertias=(own, *chain.inertias[1:]),
            viscous=(viscous, *chain.viscous[1:]),
            coulomb=(coulomb, *chain.coulomb[1:]),
            offsets=(offset, *chain.offsets[1:]),
        )
    return chain


def learnt_bounds(chain: LumpedChain, found: Learnt) -> Bounds:
    """Bounds of p2 to p5 by the intervals that were learnt, at least 2 % wide; as printed where none were."""
    printed = printed_bounds(chain, flexible_joint=chain.size > 2)
    if not found.motor_excited or not isclose(sum(chain.coulomb), float(found.motor.values[2])):
        return printed
    half = np.diff(found.motor.intervals, axis=0)[0] / 2.0
    half = np.maximum(half, LEAST_SPREAD * np.abs(printed.nominal))
    return Bounds(nominal=printed.nominal, low=printed.nominal - half, high=printed.nominal + half)


def rebuilt(loop: Loop, spec: DesignSpec, found: Learnt) -> Loop:
    """The loop with law, reference and filter made for what was learnt; the plant is the same.

    The filter goes on from the states of the old one, with the gain it has settled on.
    """
    first, number = loop.controller, loop.controller.model
    chain = learnt_chain(spec.model(number), found)
    bounds = learnt_bounds(chain, found)
    same = replace(spec, bandwidth=float(first.gains["bandwidth_hz"]) if spec.best else spec.bandwidth)
    made = chain_law(same, number, damped=True, tuning=first.tuning, chain=chain, bounds=bounds)
    made = replace(made, name=NAME, gains=first.gains | made.gains | {"beta": float(found.load.values[0])})
    drive, options = spec.drive, loop.options
    sampling = Sampling(interval=spec.interval, delay=control_delay(drive), current_rate=current_rate(drive))
    fitted = fitted_encoders(drive, None if made.filter_model is None else made.shafts)
    observer = fit_observer(made, (chain, loop.chain), fitted, options, sampling, settled=True)
    return replace(loop, controller=made, observer=observer)


def run_indirect(spec: DesignSpec, loop: Loop) -> tuple[Loop, Run, Learnt | None]:
    """Run one pulse, learn, make all anew in the dwell, run the rest; the last loop, and what was learnt."""
    pause = loop.rig.first_end
    early = run(loop, last=min(pause, len(loop.target)))
    if early.failed:
        return loop, early, None
    if pause >= len(loop.target) - 1:
        return loop, early if pause >= len(loop.target) else _rest(loop, early, pause), None
    found = learn(loop, early, pause, spec.drive, spec.model(loop.controller.model))
    later = loop
    if found.excited:
        later = rebuilt(loop, spec, found)
        early.state.controller.parameters[:4] = later.controller.start
    return later, _rest(later, early, pause), found


def _rest(loop: Loop, early: Run, pause: int) -> Run:
    late = run(loop, state=early.state, first=pause)
    log = early.log.copy()
    log[pause:] = late.log[pause:]
    for before, after in ((early.tensions, late.tensions), (early.flanks, late.flanks)):
        if before is not None and after is not None:
            after[:pause] = before[:pause]
    return replace(late, log=log)
