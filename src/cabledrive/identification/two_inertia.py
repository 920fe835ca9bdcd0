"""Two inertias, a spring between them, friction at both: identified from logs of either speed or both.

The input is a torque, a force, or a voltage or current, in whose unit all parameters then are. A speed that
never changes its sign under an input that does is that of a sensor which shows its absolute value. Logs that
show both sides with their signs are solved by the two equations of `two_sides`; a log of one side, or of a
speed without its sign, is simulated from many starts.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cabledrive.identification import chain_fit, estimates, two_sides
from cabledrive.identification.axis.timing import lag_said
from cabledrive.identification.chain_fit import ChainModel, FreeParameter, Record
from cabledrive.identification.estimates import Estimate, Finding, Identification, readable
from cabledrive.identification.log_response import speed_of
from cabledrive.identification.logs.log import Log
from cabledrive.identification.rope_friction import without_slip
from cabledrive.identification.signals import zero_phase
from cabledrive.identification.two_sides import LOAD, SUM, Solution, TwoSides, load_equation, sum_equation
from cabledrive.parameters import InputRefused
from cabledrive.parameters.arrays import Array

NAME = "two-inertia"
FREE = {  # quantity and number of each parameter in a chain, and how far its bounds lie from its scale
    "inertia_motor": ("inertia", 0, 1e4),
    "inertia_load": ("inertia", 1, 1e4),
    "stiffness": ("stiffness", 0, 1e6),
    "damping": ("damping", 0, 1e6),
    "viscous_friction_motor": ("viscous", 0, 1e5),
    "viscous_friction_load": ("viscous", 1, 1e5),
    "coulomb_friction_motor": ("coulomb", 0, 1e4),
    "coulomb_friction_load": ("coulomb", 1, 1e4),
}
NAMES = (*FREE, "offset")
NEEDED, FRICTIONS = NAMES[:3], NAMES[4:8]
INPUTS = {"torque": "N m", "force": "N", "current": "A", "voltage": "V"}
MOTIONS = ("velocity", "angle", "position")
LOAD_WORDS = ("load", "pulley", "output", "second")
DIFFERENCED = 10
"""Lags over which the difference of an angle correlates the noise of its encoder."""
FOLLOWS = 70.0
"""Share of each speed, of torque, of the load's acceleration, explained where intervals are given [%]."""
STILL = 0.05
"""Share of its usual speed below which the sign of a speed is not trusted."""
GEAR = 1.3
"""Turns of the motor over those of the load from which a gear lies between: a spring makes them fewer."""
EXCITED = 0.99
"""Share of the input's power below the frequency to which a log is said to excite."""
LACKING, LACKING_SURE, FADING = 0.85, 8.0, 4.0
"""Share of a residual's power that effects leave, and size of one over its error, with which the model lacks
it; speed at which an excess of friction has fallen to 1/e, over that below which a sign is not trusted."""
SEED = 0  # of the starts
UNKNOWN = "not identifiable from the log"


@dataclass(frozen=True, slots=True, kw_only=True)
class Channels:
    """Which channels of the logs are used."""

    input: str
    # motor, load: speed, angle or position of each side; one of them at least
    motor: str | None
    load: str | None
    rectified: bool  # whether the sensor shows absolute values
    units: dict[str, str]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Those that are measured, the motor's first."""
        return tuple(name for name in (self.motor, self.load) if name is not None)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed of them."""
        found = ["the speed is never negative: assumed to be its absolute value"] if self.rectified else []
        if self.input.rpartition("_")[2] in ("voltage", "current"):
            found.append(f"parameters are in the unit of the {readable(self.input)}: the gain is not known")
        if self.motor is None:
            found.append("only the load is measured: motor and load may be exchanged")
        return tuple(found)

    def unit_of(self, name: str) -> str:
        """Unit of a parameter: of N m and rad, or of the input and the motion."""
        force = INPUTS[self.input.rpartition("_")[2]]
        way = self.units[self.outputs[0]].split("/")[0]
        if name == "sensor_lag":
            return "s"
        if name.startswith("inertia"):
            plain = {("N m", "rad"): "kg m^2", ("N", "m"): "kg"}
            return plain.get((force, way), f"{force} s^2/{way}")
        if name.startswith(("viscous", "damping")):
            return f"{force} s/{way}"
        return f"{force}/{way}" if name == "stiffness" else force


def identify_two_inertia(
    logs: Sequence[Log], progress: Callable[[str], None] | None = None
) -> Identification:
    """Identify motor and load inertia, the spring between them, its damping and all frictions.

    No intervals where the model does not follow the log. Raises `InputRefused` if a channel is missing or
    constant; `NotComputed` if no start leads to a model that moves like the log.
    """
    channels = channels_of(logs)
    if len(channels.outputs) == 2 and not channels.rectified:
        return identify_by_equations(logs, channels)
    return identify_by_simulation(logs, channels, progress or (lambda words: None))


def channels_of(logs: Sequence[Log]) -> Channels:
    """Choose the channels, the same in every log; refused if input or motion is missing or constant."""
    names = [name for name in logs[0].channels if all(name in log.channels for log in logs)]
    input_ = next((n for kind in INPUTS for n in names if n.rpartition("_")[2] == kind), None)
    if input_ is None:
        raise InputRefused(f"{logs[0].source}: no torque, force, voltage or current: map one with --column")
    moving = [n for kind in MOTIONS for n in names if n.rpartition("_")[2] == kind]
    load = next((n for n in moving if set(n.split("_")) & set(LOAD_WORDS)), None)
    motor = next((n for n in moving if not set(n.split("_")) & set(LOAD_WORDS)), None)
    if load is None and motor is None:
        said = f"{logs[0].source}: no velocity, angle or position"
        raise InputRefused(f'{said}: map one, as --column "load_velocity=COLUMN:rad/s"')
    for log in logs:
        for name in filter(None, (input_, motor, load)):
            if np.ptp(log.channel(name)) == 0.0:
                raise InputRefused(f"{log.source}: {name} is constant: a log must move the machine")
    speeds = [n for n in (motor, load) if n is not None and n.rpartition("_")[2] == "velocity"]
    both = any(log.channel(input_).min() < 0.0 < log.channel(input_).max() for log in logs)
    rectified = bool(speeds) and both and all(log.channel(n).min() >= 0.0 for log in logs for n in speeds)
    return Channels(input=input_, motor=motor, load=load, rectified=rectified, units=dict(logs[0].units))


def identify_by_simulation(
    logs: Sequence[Log], channels: Channels, say: Callable[[str], None]
) -> Identification:
    """By output error from many starts."""
    records = []
    for log in logs:
        output = np.column_stack([speed_of(log, name) for name in channels.outputs])
        records.append(Record(input=log.channel(channels.input), output=output, interval=log.interval))
    scale, starts = chain_fit.starts_for(records, channels.rectified, np.random.default_rng(SEED))
    fit, made, agreeing = chain_fit.fit_from_many_starts(records, _models(channels, scale), starts, say)
    explained = []
    for record in records:
        for measured, simulated in zip(record.output.T, fit.simulated(record).T, strict=True):
            varies = np.linalg.norm(measured - measured.mean())
            explained.append(float(100.0 * (1.0 - np.linalg.norm(measured - simulated) / varies)))
    follows = min(explained) >= FOLLOWS
    differenced = any(not name.endswith("velocity") for name in channels.outputs)
    doubts = fit.doubts(records, DIFFERENCED if differenced else 1)
    if not follows:
        words = f"the model explains {min(explained):.3g} % of a measured speed"
        doubts.insert(0, Finding("model-misfit", f"{words}, less than {FOLLOWS:g} %: no intervals are given"))
    if agreeing < 2:
        words = f"only one of {made} fits reaches this residual: a better one may exist"
        doubts.append(Finding("one-start-only", words))
    closed = {name for name in fit.undetermined() if name in NEEDED}
    if len(channels.outputs) == 1:
        doubts += _beyond(fit.values, channels, records, closed)
    shown = set() if not follows else set(fit.values) - set(fit.at_bounds())
    if channels.rectified:
        acting = {"hold": fit.model.hold, "delay_samples": fit.model.delay}
        note = f"the {readable(channels.input)} acts in {fit.model.hold}s, {fit.model.delay} samples late"
    else:
        interval, (low, high) = max(one.interval for one in records), fit.interval_of("instant")
        lag = interval * fit.values["instant"]
        acting = {"lag": lag, "smoothing": fit.values["smoothing"]}
        note, late = lag_said(lag, 0.5 * interval * (high - low), interval, channels.input)
        doubts += late
    parameters, names = {}, [name for name in fit.values if name not in chain_fit.ACTING]
    for name in names:
        value, unit, error = fit.values[name], channels.unit_of(name), fit.errors[name]
        low, high = fit.interval_of(name) if name in shown else (-np.inf, np.inf)
        one = Estimate(value=value, unit=unit, standard_error=error, low=low, high=high)
        parameters[name] = Estimate.unknown(unit, UNKNOWN) if name in closed else one
    size = float(np.sqrt(np.mean(np.concatenate([r.output.ravel() for r in records]) ** 2)))
    covariance = fit.covariance[: len(names), : len(names)]
    spread, condition = np.sqrt(np.diag(covariance)), float("inf")
    if np.all(np.isfinite(spread)) and np.all(spread > 0.0):
        condition = float(np.sqrt(np.linalg.cond(covariance / np.outer(spread, spread))))
    return _answer(
        logs,
        channels,
        parameters,
        [name for name in NEEDED if name in closed],
        residual={
            "rms": fit.residual,
            "relative": fit.residual / size,
            "rows": sum(r.output.size for r in records),
        },
        condition_number=condition,
        method={
            "name": "output-error",
            "residual_of": "speed",
            "sensor": "rectified" if channels.rectified else "signed",
            **acting,
            "starts": len(starts),
            "full_fits": made,
            "agreeing_fits": agreeing,
            "explained_percent": explained,
            "seed": SEED,
        },
        covariance=covariance,
        freedom=fit.freedom,
        findings=tuple(doubts),
        notes=(note, *channels.notes),
        check_reason="share explained, whiteness of the residual, bounds, several starts",
    )


def _beyond(
    values: dict[str, float], channels: Channels, records: Sequence[Record], closed: set[str]
) -> list[Finding]:
    """Close what one side does not tell where the spring's own frequency lies beyond the excitation."""
    excited = 0.0  # [Hz], below which nearly all power of the input lies, of the log that reaches highest
    for record in records:
        power = np.abs(np.fft.rfft(record.input - record.input.mean())) ** 2
        place = int(np.searchsorted(np.cumsum(power), EXCITED * power.sum()))
        excited = max(excited, place / (record.input.size * record.interval))
    motor, load, spring = (values[name] for name in NEEDED)
    far, what = (load, "antiresonance") if channels.motor else (motor * load / (motor + load), "resonance")
    if (own := float(np.sqrt(spring / far)) / (2.0 * np.pi)) <= excited and not closed:
        return []
    total = sum(values[name] for name in NEEDED[:2] if name not in closed) or motor + load
    closed |= set(NEEDED)
    words = f"the log excites up to {excited:.3g} Hz, the {what} of the fit is {own:.3g} Hz: from one side "
    words += f"this tells the sum of the inertias, {total:.4g}, and neither part nor the spring"
    return [Finding("excited-below-the-spring", f"{words}: excite beyond it, or measure both sides")]


def _models(channels: Channels, scale: dict[str, float]) -> list[ChainModel]:
    """The chain with bounds far on both sides of the scales of the log, in each way its input may act."""
    free = [
        FreeParameter(name=name, quantity=kind, number=k, low=scale[kind] / reach, high=scale[kind] * reach)
        for name, (kind, k, reach) in FREE.items()
    ]
    wide = {"offset": 10.0 * scale["coulomb"]}
    wide |= {} if channels.rectified else chain_fit.ACTING  # a sensor without sign hides it
    free += [FreeParameter(name=name, quantity=name, low=-far, high=far) for name, far in wide.items()]
    if channels.rectified:
        free.append(FreeParameter(name="sensor_lag", quantity="lag", low=1e-5, high=1.0))
    model = ChainModel(
        inertias=2,
        free=tuple(free),
        measured=tuple(k for k, name in enumerate((channels.motor, channels.load)) if name is not None),
        rectified=channels.rectified,
    )
    if channels.rectified and channels.input.rpartition("_")[2] in ("voltage", "current"):
        return [model, replace(model, delay=1)]
    return [replace(model, hold="line"), *([model] if channels.rectified else [])]


def identify_by_equations(logs: Sequence[Log], channels: Channels) -> Identification:
    """By the two equations of logs that show both sides, at the motor's shaft."""
    sides, slip = without_slip([_sides(log, channels) for log in logs])
    load = load_equation(sides)
    torque, sides, lag = sum_equation(sides, load)
    values, halves, covariance = _parameters(torque, load)
    solved = [one for one in (torque, load) if one is not None]
    explained = [100.0 * (1.0 - one.fit.residual / one.fit.scale) for one in solved]
    findings = [] if slip is None else [Finding("slip", f"{slip.words(values[1])}: taken out of the twist")]
    follows = min(explained) >= FOLLOWS
    if not follows:
        what = "torque" if explained[0] < FOLLOWS else "load's acceleration"
        words = f"the model explains {min(explained):.3g} % of the {what}, less than {FOLLOWS:g} %"
        findings.append(Finding("model-misfit", f"{words}: no intervals are given"))
    elif slip is None and (missing := _lacking(sides, torque, load)):
        follows, words = False, " and ".join(missing)
        findings.append(Finding("model-misfit", f"the model lacks {words}: no intervals are given"))
    note, late = lag_said(lag, torque.of("lag")[1], max(one.interval for one in sides), channels.input)
    findings += late
    closed = {name for k, name in enumerate(NEEDED) if not halves[k] < abs(values[k])}
    closed |= {"stiffness", "damping", *FRICTIONS} if load is None else set()
    closed |= {"inertia_motor", "inertia_load"} if estimates.unidentifiable_parameters(torque.fit) else set()
    parameters = {}
    for name, value, half, error in zip(NAMES, values, halves, np.sqrt(np.diag(covariance)), strict=True):
        one = Estimate.of(value, channels.unit_of(name), error, half)
        if name in closed:
            one = Estimate.unknown(one.unit, UNKNOWN)
        elif name in FRICTIONS and value < 0.0 < one.high:
            one = replace(one, value=0.0, low=0.0)
        elif name != "offset" and value < 0.0:
            words = f"{readable(name)} is identified as negative: check signs and units"
            findings.append(Finding("negative", words))
        parameters[name] = one if follows else replace(one, low=-np.inf, high=np.inf)
    fit = torque.fit
    return _answer(
        logs,
        channels,
        parameters,
        [name for name in NAMES if name in closed],
        residual={"rms": fit.residual, "relative": fit.residual / fit.scale, "rows": fit.rows},
        condition_number=fit.condition,
        method={
            "name": "inverse-dynamics",
            "residual_of": channels.input,
            "lag": lag,
            "bandwidths": [one.band for one in solved],
            "explained_percent": explained,
        },
        covariance=covariance,
        freedom=min(one.fit.freedom for one in solved),
        findings=tuple(findings),
        notes=(note, *(() if sides[0].cogging is None else (sides[0].cogging.words,)), *channels.notes),
        check_reason="shares explained, other bandwidths, lag, backlash, friction at low speed; not checked: "
        "small ones of these, a torque of the position over few periods",
    )


def _lacking(sides: Sequence[TwoSides], torque: Solution, load: Solution | None) -> list[str]:
    """What the residuals of both equations show that the model lacks."""
    found = []
    for side, solution in (("motor", torque), *((("load", load),) if load is not None else ())):
        band, gap = solution.band, side == "load" and not any(one.rates for one in sides)
        rest = solution.of("zero")[0] / solution.of("beta")[0] if gap else 0.0

        def effects(one: TwoSides, side: str = side, band: float = band, rest: float = rest) -> Array:
            """Friction that fades with speed, and the sign of the twist, as the load's equation has both."""
            quick = one.quick(one.motor if side == "motor" else one.load, band)
            fading = np.exp(-np.abs(quick) / (FADING * one.slow)) * np.sign(quick)
            twist = zero_phase(one.near - one.load, one.interval, band) + rest
            return np.array([fading]) if side == "motor" else -np.array([fading, np.sign(twist)])

        share, values, covariance = two_sides.beside(sides, solution, effects)
        sure = (values > LACKING_SURE * np.sqrt(np.diag(covariance))) & (share < LACKING)
        words = f"friction of the {side} that is larger at low speed", "backlash"
        found += [one for one, own, known in zip(words, sure, (True, gap), strict=False) if own and known]
    return found


def _answer(
    logs: Sequence[Log],
    channels: Channels,
    parameters: dict[str, Estimate],
    closed: Sequence[str],
    **more: Any,
) -> Identification:
    method = {"input": channels.input, "measured": list(channels.outputs)} | more.pop("method")
    return Identification(
        model=NAME,
        parameters=parameters,
        unidentifiable=tuple(f"{readable(name)} is not determined by the log" for name in closed),
        method=method,
        checked=True,
        reports=tuple(log.report for log in logs),
        **more,
    )


def _sides(log: Log, channels: Channels) -> TwoSides:
    """Angles, or speeds where one of the two is a speed."""
    rates = any(name.endswith("velocity") for name in channels.outputs)
    motor, load = (speed_of(log, name) if rates else log.channel(name) for name in channels.outputs)
    one = TwoSides(
        source=log.source,
        interval=log.interval,
        torque=log.channel(channels.input),
        motor=motor,
        load=load,
        rates=rates,
        saturated=log.saturated.get(channels.input),
    )
    speeds = [one.quick(values, 10.0) for values in (motor, load)]
    turns = float(speeds[0] @ speeds[1] / (speeds[1] @ speeds[1]))
    if turns > GEAR:
        said = f"{log.source}: {channels.motor} moves {turns:.3g} times as far as {channels.load}"
        raise InputRefused(f"{said}: give both at one shaft, the load's times the gear ratio")
    return replace(one, slow=STILL * float(np.sqrt(np.mean(speeds[0] ** 2))))


def _parameters(torque: Solution, load: Solution | None) -> tuple[Array, Array, Array]:
    """Values and halves of intervals, each (9,), and covariance, the two equations erring independently."""

    def named(p: Any) -> Any:
        """The parameters, as `NAMES`, from the coefficients `SUM` and `LOAD`."""
        motor, inertia, viscous, coulomb, offset, _, beta, gamma, own_viscous, own_coulomb, _ = p
        rubbed, rubs = inertia * own_viscous, inertia * own_coulomb
        spring = inertia * beta, inertia * gamma
        return np.array([motor, inertia, *spring, viscous - rubbed, rubbed, coulomb - rubs, rubs, offset])

    split = len(SUM)
    p = np.concatenate([torque.fit.values, np.zeros(len(LOAD)) if load is None else load.fit.values])
    slopes = np.array([named(p + step).imag for step in 1e-200j * np.eye(p.size)]).T / 1e-200
    whole, beyond, student = np.zeros((p.size, p.size)), np.zeros(p.size), 0.0
    for one, place in ((torque, slice(split)), (load, slice(split, None))):
        if one is not None:
            whole[place, place], beyond[place] = one.fit.covariance, one.beyond
            own = one.fit.half_width()[0] / float(np.sqrt(one.fit.covariance[0, 0]) or 1.0)
            student = max(student, own)
    covariance = slopes @ whole @ slopes.T
    return named(p), student * np.sqrt(np.diag(covariance)) + np.abs(slopes) @ beyond, covariance
