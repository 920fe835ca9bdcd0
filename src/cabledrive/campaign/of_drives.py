"""Computations on the drive alone: modes, internal resonance, growth over a map, simulation."""

from collections.abc import Mapping
from math import nan
from typing import Any

import numpy as np

from cabledrive.campaign.computation import FLAG, LIST, TEXT, Found, Kind, Output, Row, padded
from cabledrive.parameters import InputRefused
from cabledrive.parameters.route import RoutedDrive

DEFAULT_COUNT = 6
SPANS = ("upper", "lower")


def _modes_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    size = (options.get("count", DEFAULT_COUNT),)
    return (
        Output(
            name="longitudinal_hz",
            unit="Hz",
            meaning="longitudinal natural frequencies of the taut cable, each by its multiplicity",
            dims=("mode",),
            shape=size,
        ),
        Output(
            name="longitudinal_proven",
            unit="",
            kind=FLAG,
            meaning="whether counts certify each longitudinal frequency and that the list is complete",
        ),
        Output(
            name="transverse_hz",
            unit="Hz",
            meaning="transverse natural frequencies, of each section and plane",
            dims=("transverse_mode",),
            shape=size,
        ),
        Output(
            name="certified", unit="", kind=FLAG, meaning="whether the whole list of both kinds is certified"
        ),
        Output(name="certified_reason", unit="", kind=TEXT, meaning="why it is not"),
        Output(name="warnings", unit="", kind=TEXT, meaning="warnings that touch the list"),
        Output(name="rigid_body_modes", unit="1", meaning="motions that strain nothing"),
    )


OF_BOTH_KINDS = {"transverse_hz", "certified", "certified_reason", "warnings", "rigid_body_modes"}
"""Outputs of `modes` that need transverse modes as well; the state of rest is then computed for each row."""


def _modes(row: Row) -> Mapping[str, Any]:
    from cabledrive.modal.natural import longitudinal_modes, modes

    count, motor = row.options.get("count", DEFAULT_COUNT), row.options.get("motor")
    if not OF_BOTH_KINDS & set(row.options["outputs"]):
        along = longitudinal_modes(row.drive, count=count, motor=motor)
        return _longitudinal(along, count)
    found = modes(row.drive, count=count, motor=motor)
    return _longitudinal(found.longitudinal, count) | {
        "transverse_hz": padded([mode.frequency for mode in found.transverse], count),
        "certified": found.certified,
        "certified_reason": found.certified_reason or "",
        "warnings": "; ".join(found.warnings),
        "rigid_body_modes": found.rigid_body_modes,
    }


def _longitudinal(along: Any, count: int) -> dict[str, Any]:
    frequencies = np.repeat([mode.frequency for mode in along], [mode.multiplicity for mode in along])
    return {
        "longitudinal_hz": padded(frequencies, count),
        "longitudinal_proven": all(mode.proven for mode in along) and frequencies.size >= count,
    }


RESONANCE = {
    "frequency_ratio": ("1", "lowest transverse frequency of an empty span over the pulley mode's"),
    "detuning": ("1", "that minus one half"),
    "tuned_pretension": ("N", "pretension that makes the ratio one half"),
    "threshold_torque": ("N m", "at the tuned pretension"),
    "threshold_torque_at_own_pretension": ("N m", "at the drive's own pretension"),
    "tenfold_growth_torque": ("N m", "for tenfold growth in one second, tuned"),
    "pulley_frequency_hz": ("Hz", "of the pulley mode"),
}

IN_DETAIL = "tenfold_growth_torque"
IN_CLOSED_FORM = {*RESONANCE, "verdict"} - {IN_DETAIL}
"""Outputs of `resonance` that many rows get at once; the other is a search over time and torque."""


def _resonance_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    numbers = tuple(
        Output(name=name, unit=unit, meaning=meaning) for name, (unit, meaning) in RESONANCE.items()
    )
    return (
        *numbers,
        Output(
            name="verdict",
            unit="",
            kind=TEXT,
            meaning="resonant, close or safe at the torque given, else at the torque limit",
        ),
    )


def _resonance(row: Row) -> Mapping[str, Any]:
    from cabledrive.studies.resonance import default_torque, resonance

    found = resonance(
        row.drive,
        torque=row.options.get("torque", default_torque(row.drive)),
        load_torque=row.options.get("load_torque", 0.0),
        details=IN_DETAIL in row.options["outputs"],
    )
    named = {
        "threshold_torque_at_own_pretension": found.threshold_here,
        "tenfold_growth_torque": found.growth_torque,
        "pulley_frequency_hz": found.pulley_frequency,
    }
    plain = ("frequency_ratio", "detuning", "tuned_pretension", "threshold_torque")
    named |= {name: getattr(found, name) for name in plain}
    return {name: nan if value is None else value for name, value in named.items()} | {
        "verdict": found.verdict
    }


def _map_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    shape = tuple(len(options.get(name, ())) for name in ("torques", "pretensions"))
    axes = ("map_torque", "map_pretension")
    return (
        Output(
            name="growth",
            unit="1",
            meaning="largest transverse amplitude over the pluck; NaN where a span went slack",
            dims=axes,
            shape=shape,
        ),
        Output(
            name="map_threshold_torque",
            unit="N m",
            meaning="threshold torque at each pretension of the map",
            dims=axes[1:],
            shape=shape[1:],
        ),
    )


def _map(row: Row) -> Mapping[str, Any]:
    from cabledrive.studies.resonance_map import growth_map

    torques = row.options["torques"]
    found = growth_map(
        row.drive,
        torque=row.options.get("torque", max(torques)),
        pretensions=row.options["pretensions"],
        torques=torques,
        duration=row.options.get("duration", 1.0),
        threads=1,
    )
    threshold = np.where(np.isfinite(found.threshold), found.threshold, np.nan)
    return {"growth": found.growth, "map_threshold_torque": threshold}


SIMULATION = {
    "energy_budget_error": ("1", "largest error of the energy balance over the largest energy handled"),
    "steps": ("1", "time steps"),
    "slack_events": ("1", "number of times that a span went slack"),
    "load_angle_peak_to_peak": ("rad", "of the load pulley"),
    "upper_midpoint_peak": ("m", "largest transverse displacement w of the upper midpoint"),
    "lower_midpoint_peak": ("m", "largest transverse displacement w of the lower midpoint"),
    "least_tension": ("N", "smallest tension of any span at any record"),
    "midpoint_peak": ("m", "largest transverse displacement w of any span's midpoint"),
    "coordinate_peak_to_peak": ("rad", "of compute.coordinate, of a machine with routes [rad or m]"),
}


def _simulate_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    return tuple(
        Output(name=name, unit=unit, meaning=meaning) for name, (unit, meaning) in SIMULATION.items()
    )


def _simulate(row: Row) -> Mapping[str, Any] | Found:
    from cabledrive.simulation import (
        Constant,
        Pluck,
        Recording,
        Scheme,
        Sine,
        Start,
        simulate,
    )

    o = row.options
    if isinstance(row.drive, RoutedDrive):
        return _simulate_routes(row.drive, o)
    if {"pluck", "pluck_span", "coordinate"} & set(o):
        raise InputRefused("pluck, pluck_span and coordinate are for machines with routes: leave them out")
    amplitude, frequency = o.get("torque_amplitude", 0.0), o.get("torque_frequency", 0.0)
    heights = {"upper": o.get("pluck_upper", 0.0), "lower": o.get("pluck_lower", 0.0)}
    shape = o.get("pluck_shape", "triangle")
    plucks = tuple(Pluck(height=h, span=span, shape=shape) for span, h in heights.items() if h)
    scheme = Scheme(
        model=o.get("model", "exact"),
        method=o.get("method", "verlet"),
        segments=o.get("segments", Scheme().segments),
        slack="tension-only" if o.get("tension_only") else "stop",
        friction="smoothed" if o.get("smooth_friction") else "stick-slip",
    )
    result = simulate(
        row.drive,
        o["duration"],
        torque=Sine(amplitude=amplitude, frequency=frequency) if frequency else Constant(amplitude),
        start=Start(plucks=plucks, from_equilibrium=o.get("from_equilibrium", False)),
        scheme=scheme,
        recording=Recording(rate=o.get("rate", 10_000.0)),
        progress=False,
    )
    values = _of_run(result.summary())
    return values if result.stopped is None else Found(values=values, incomplete=result.stopped)


def _simulate_routes(drive: RoutedDrive, o: Mapping[str, Any]) -> Mapping[str, Any] | Found:
    """A run of a machine with routes: its spans and coordinates have names."""
    from cabledrive.simulation import Constant, Pluck, Recording, Scheme, Sine, simulate
    from cabledrive.simulation.network.case import NetworkStart

    taken = {"duration", "torque_amplitude", "torque_frequency", "pluck", "pluck_span", "pluck_shape"}
    others = sorted(set(o) - taken - {"segments", "rate", "coordinate", "outputs"})
    if others:
        raise InputRefused(f"compute.{others[0]} is for loops and lines, the drive has routes: leave it out")
    amplitude, frequency = o.get("torque_amplitude", 0.0), o.get("torque_frequency", 0.0)
    shape, start = o.get("pluck_shape", "triangle"), None
    if o.get("pluck"):
        start = NetworkStart(plucks=(Pluck(height=o["pluck"], span=o.get("pluck_span", ""), shape=shape),))
    result = simulate(
        drive,
        o["duration"],
        torque=Sine(amplitude=amplitude, frequency=frequency) if frequency else Constant(amplitude),
        start=start,
        scheme=Scheme(segments=o.get("segments", Scheme().segments)),
        recording=Recording(rate=o.get("rate", 10_000.0)),
        progress=False,
    )
    said = result.summary()
    known, name = said["coordinates"], o.get("coordinate")
    if name is not None and name not in known:
        raise InputRefused(f'compute.coordinate = "{name[:60]}" is none: take one of {", ".join(known)}')
    middles = [one["midpoint_peak"] for one in said["spans"] if one["midpoint_peak"] is not None]
    tensions = [one["least_tension"] for one in said["spans"] if one["least_tension"] is not None]
    found = dict.fromkeys(SIMULATION, nan) | {
        "energy_budget_error": nan if said["energy_budget_error"] is None else said["energy_budget_error"],
        "steps": said["steps"],
        "slack_events": len(said["slack_events"]),
        "least_tension": min(tensions, default=nan),
        "midpoint_peak": max(middles, default=nan),
        "coordinate_peak_to_peak": nan if name is None else known[name]["peak_to_peak"],
    }
    return found if result.stopped is None else Found(values=found, incomplete=result.stopped)


def _of_run(said: Mapping[str, Any]) -> dict[str, Any]:
    numbers = {
        "energy_budget_error": said["energy_budget_error"],
        "steps": said["steps"],
        "slack_events": len(said["slack_events"]),
        "load_angle_peak_to_peak": said["load_angle"]["peak_to_peak"],
        "upper_midpoint_peak": said["upper_midpoint"]["peak"],
        "lower_midpoint_peak": said.get("lower_midpoint", {}).get("peak"),
        "least_tension": said["least_tension"],
        "midpoint_peak": max(
            said[f"{span}_midpoint"]["peak"] for span in SPANS if f"{span}_midpoint" in said
        ),
        "coordinate_peak_to_peak": None,
    }
    return {name: nan if value is None else value for name, value in numbers.items()}


KINDS = {
    "modes": Kind(
        outputs=_modes_outputs,
        default=("longitudinal_hz", "longitudinal_proven"),
        one=_modes,
        modules=("cabledrive.campaign.columns", "cabledrive.modal.batch"),
        options={"count": "count", "motor": TEXT},
    ),
    "resonance": Kind(
        outputs=_resonance_outputs,
        default=tuple(name for name in (*RESONANCE, "verdict") if name != IN_DETAIL),
        one=_resonance,
        modules=("cabledrive.campaign.columns", "cabledrive.studies.resonance_detuning"),
        options={"torque": "N m", "load_torque": "N m"},
    ),
    "map": Kind(
        outputs=_map_outputs,
        default=("growth", "map_threshold_torque"),
        one=_map,
        modules=("cabledrive.studies.resonance_map",),
        options={"pretensions": f"{LIST}N", "torques": f"{LIST}N m", "torque": "N m", "duration": "s"},
        required=("pretensions", "torques"),
    ),
    "simulate": Kind(
        outputs=_simulate_outputs,
        default=tuple(SIMULATION),
        one=_simulate,
        modules=("cabledrive.simulation.kernels",),
        options={
            "duration": "s",
            "torque_amplitude": "N m",
            "torque_frequency": "Hz",
            "pluck_upper": "m",
            "pluck_lower": "m",
            "pluck_shape": TEXT,
            "pluck": "m",
            "pluck_span": TEXT,
            "coordinate": TEXT,
            "model": TEXT,
            "method": TEXT,
            "segments": "count",
            "rate": "Hz",
            "from_equilibrium": FLAG,
            "tension_only": FLAG,
            "smooth_friction": FLAG,
        },
        required=("duration",),
    ),
}
