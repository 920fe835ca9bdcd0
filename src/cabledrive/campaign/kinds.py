"""Computations that a SPEC can name: of the drive alone, in closed loop, a whole study."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import fields
from math import sin
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.campaign.computation import FLAG, LIST, TEXT, Found, Kind, Output, Row, declared, padded
from cabledrive.campaign.rows import plain_value
from cabledrive.campaign.spec import GOALS, MOTION, PLANT, CampaignSpec, settings_of
from cabledrive.parameters import InputRefused, Machine
from cabledrive.parameters.keys import varied_together

if TYPE_CHECKING:
    from cabledrive.modal.batch import ChainBatch

Many = tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]
"""Rows that are done, (n,), and their outputs, (n, ...), by name."""

DEFAULT_COUNT = 6
STRAIGHT = 1e-3
"""Irvine parameter, with what hangs on it, up to which a rope is straight for its longitudinal modes."""
EVEN = 1e-5
"""Share of its rigidity by which a rope's tension may differ along it."""
SPANS = ("upper", "lower")


def _modes_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    size = (options.get("count", DEFAULT_COUNT),)
    along = "longitudinal natural frequencies at rest, each by its multiplicity"
    across = "transverse natural frequencies, of each section and plane"
    return (
        *declared({"longitudinal_hz": ("Hz", along)}, ("mode",), size),
        *declared({"transverse_hz": ("Hz", across)}, ("transverse_mode",), size),
        *declared(OF_A_LIST),
    )


OF_A_LIST = {
    "longitudinal_proven": (FLAG, "whether counts certify each longitudinal frequency and a complete list"),
    "certified": (FLAG, "whether the whole list of both kinds is certified"),
    "certified_reason": (TEXT, "why it is not"),
    "warnings": (TEXT, "warnings that touch the list"),
    "rigid_body_modes": ("1", "motions that strain nothing"),
}
OF_BOTH_KINDS = {"transverse_hz", "certified", "certified_reason", "warnings", "rigid_body_modes"}
"""Outputs of `modes` that need transverse modes as well; the state of rest is then computed for each row."""


def _modes(row: Row) -> Mapping[str, Any]:
    from cabledrive.modal.natural import longitudinal_modes, modes

    count, motor = row.options.get("count", DEFAULT_COUNT), row.options.get("motor")
    if not OF_BOTH_KINDS & set(row.options["outputs"]):
        along = longitudinal_modes(row.drive, count=count, motor=motor, taut=is_straight(row.drive))
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
    "verdict": (TEXT, "resonant, close or safe at the torque given, else at the torque limit"),
}

FIELDS = {
    "threshold_torque_at_own_pretension": "threshold_here",
    "tenfold_growth_torque": "growth_torque",
    "pulley_frequency_hz": "pulley_frequency",
}
"""Outputs that a resonance has under another name."""
IN_DETAIL = ("tenfold_growth_torque", "verdict")
"""Outputs that are a search over time and torque, and one over all pairs of modes: if asked for."""


def _resonance(row: Row) -> Mapping[str, Any]:
    from cabledrive.studies.resonance import resonance

    found = resonance(
        row.drive,
        torque=row.options.get("torque"),
        load_torque=row.options.get("load_torque", 0.0),
        details=not set(IN_DETAIL).isdisjoint(row.options["outputs"]),
    )
    return {name: getattr(found, FIELDS.get(name, name)) for name in RESONANCE}


def _map_outputs(options: Mapping[str, Any]) -> tuple[Output, ...]:
    shape = tuple(len(options.get(name, ())) for name in ("torques", "pretensions"))
    axes = ("map_torque", "map_pretension")
    growth = "largest transverse amplitude over the pluck; NaN where a span went slack"
    least = "threshold torque at each pretension of the map"
    return (
        *declared({"growth": ("1", growth)}, axes, shape),
        *declared({"map_threshold_torque": ("N m", least)}, axes[1:], shape[1:]),
    )


def _map(row: Row) -> Mapping[str, Any]:
    from cabledrive.studies.resonance_map import growth_map

    torques = row.options["torques"]
    found = growth_map(
        row.drive,
        torque=row.options.get("torque", max(torques)),
        pretensions=row.options["pretensions"],
        torques=torques,
        duration=row.options.get("duration"),
        threads=1,
    )
    threshold = np.where(np.isfinite(found.threshold), found.threshold, np.nan)
    return {"growth": found.growth, "map_threshold_torque": threshold, "map_duration": found.duration}


SIMULATION = {
    "energy_budget_error": ("1", "largest error of the energy balance over the largest energy handled"),
    "steps": ("1", "time steps"),
    "slack_events": ("1", "number of times that a span went slack"),
    "load_angle_peak_to_peak": ("rad", "of the load pulley"),
    "upper_midpoint_peak": ("m", "largest transverse displacement w of the upper midpoint"),
    "lower_midpoint_peak": ("m", "largest transverse displacement w of the lower midpoint"),
    "least_tension": ("N", "smallest tension of any span at any record"),
    "midpoint_peak": ("m", "largest transverse displacement w of any span's midpoint"),
    "coordinate_peak_to_peak": ("rad", "of compute.coordinate [rad or m]"),
}


FLAGS = ("from_equilibrium", "tension_only", "smooth_friction")


def _simulate(row: Row) -> Mapping[str, Any] | Found:
    from cabledrive.simulation import Pluck, Recording, Scheme, Sine, Start, simulate

    o = row.options
    amplitude, frequency = o.get("torque_amplitude", 0.0), o.get("torque_frequency", 0.0)
    if ("torque_amplitude" in o) != ("torque_frequency" in o):
        raise InputRefused("a torque needs both compute.torque_amplitude and compute.torque_frequency")
    heights = {span: o.get(f"pluck_{span}") for span in SPANS} | {o.get("pluck_span", ""): o.get("pluck")}
    shape = o.get("pluck_shape", "triangle")
    plucks = tuple(Pluck(height=h, span=span, shape=shape) for span, h in heights.items() if h)
    result = simulate(
        row.drive,
        o["duration"],
        torque=Sine(amplitude=amplitude, frequency=frequency) if frequency else amplitude,
        start=Start(plucks=plucks, from_equilibrium=True) if o.get("from_equilibrium") else plucks,
        scheme=Scheme(
            model=o.get("model", "exact"),
            method=o.get("method", "verlet"),
            segments=o.get("segments", Scheme().segments),
            slack="tension-only" if o.get("tension_only") else "stop",
            friction="smoothed" if o.get("smooth_friction") else "stick-slip",
        ),
        recording=Recording(rate=o.get("rate", 10_000.0)),
        progress=False,
    )
    values = _seen(result.summary(), o.get("coordinate"))
    return values if result.stopped is None else Found(values=values, incomplete=result.stopped)


def _seen(said: Mapping[str, Any], coordinate: str | None) -> dict[str, Any]:
    """Figures of a run's summary; ``coordinate``: whose motion is asked for."""
    spans = said.get("spans", ())
    peaks = {f"{s}_midpoint_peak": said[f"{s}_midpoint"]["peak"] for s in SPANS if f"{s}_midpoint" in said}
    middles = [*peaks.values(), *(one["midpoint_peak"] for one in spans)]
    tensions = [said.get("least_tension"), *(one["least_tension"] for one in spans)]
    turned = {name: said[name] for name in ("drive_angle", "load_angle") if name in said}
    moved = {name: one["peak_to_peak"] for name, one in said.get("coordinates", turned).items()}
    if coordinate is not None and coordinate not in moved:
        raise InputRefused(
            f'compute.coordinate = "{coordinate[:60]}" is none: take one of {", ".join(moved)}'
        )
    return {
        **{name: said[name] for name in ("energy_budget_error", "steps")},
        **peaks,
        "slack_events": len(said["slack_events"]),
        "load_angle_peak_to_peak": moved.get("load_angle"),
        "least_tension": min((own for own in tensions if own is not None), default=None),
        "midpoint_peak": max((own for own in middles if own is not None), default=None),
        "coordinate_peak_to_peak": moved.get(coordinate or ""),
    }


TRACK = {
    "peak_error_deg": ("deg", "largest error of the load angle"),
    "first_pulse_error_deg": ("deg", "over the first pulse with its dwell"),
    "later_pulses_error_deg": ("deg", "over the later pulses"),
    "rms_error_deg": ("deg", "root mean square of the error"),
    "peak_torque": ("N m", "largest torque of the motor"),
    "saturated_fraction": ("1", "share of the samples at the torque limit"),
    "slack_samples": ("1", "samples at which a span was slack"),
    "theory_bound_deg": ("deg", "bound of the theorem"),
    "within_bound": (FLAG, "whether the error kept the bound"),
    "broken_assumptions": (TEXT, "of the theorem"),
    "controller": (TEXT, "name of the law"),
}
OF_THE_RUN = ("controller", "bandwidth", "gains", "plant", "feedforward")


def _track(row: Row) -> Mapping[str, Any] | Found:
    from cabledrive.rig import Motion, RigOptions, track
    from cabledrive.rig.setting import DEGREE

    o = row.options
    motion = {name: value / DEGREE if name == "angle" else value for name, value in row.motion.items()}
    given = {field.name: o[field.name] for field in fields(RigOptions) if field.name in o}
    found = track(
        row.drive,
        **{name: o[name] for name in OF_THE_RUN if name in o},
        motion=Motion(**motion),
        options=RigOptions(**given, forbid_slack=not o.get("tension_only", False)),
        plant_drive=row.plant,
        seed=row.seed,
        adapt=not o.get("no_adaptation", False),
    )
    said = found.summary
    values = {name: said[name] for name in TRACK} | {
        "broken_assumptions": "; ".join(said["broken_assumptions"])
    }
    return values if found.incomplete is None else Found(values=values, incomplete=found.incomplete)


STUDY = {
    "verdict": (TEXT, "yes, no or unknown"),
    "headline": (TEXT, "what decides"),
    "chosen_controller": (TEXT, "law that is chosen"),
    "reached_error_deg": ("deg", "error of the load angle that is reached"),
    "reached_error_mm": ("mm", "error of the carriage that is reached"),
    "confidence": ("1", "of the reached error"),
}


def _study(row: Row) -> Mapping[str, Any]:
    from cabledrive.report.study.results import results_of
    from cabledrive.studies.study import Goals, run_study

    given: dict[str, Any] = dict(row.goals) | {"seed": row.seed}
    if row.options.get("quick", True):
        given = {"draws": 400, "cable_draws": 0, "carriage_draws": 400} | given
    result = run_study(row.drive, (), Goals(**given))
    said, chosen = results_of(result), result.laws.chosen
    return {name: said.get(name) for name in STUDY} | {"chosen_controller": chosen and chosen.controller}


def is_straight(drive: Machine) -> bool:
    """Whether it is a loop or line whose weights move a longitudinal mode by no more than some 1e-5.

    By the sag across, and by how much tension, and with it density and length, differs along the ropes.
    """
    if (loop := drive.two_pulleys) is None:
        return False
    cable, tension, layout = loop.cable, loop.cable.pretension, loop.layout
    rope = cable.mass_per_length * loop.span_length
    hung = rope + sum(own.mass for own in loop.carriage if not own.guided)
    borne = (rope + sum(own.mass for own in loop.carriage)) * layout.gravity * abs(sin(layout.inclination))
    sags = (hung * layout.gravity_across) ** 2 * cable.axial_rigidity > STRAIGHT * tension**3
    return not sags and borne <= EVEN * cable.axial_rigidity


def plain_rows(
    spec: CampaignSpec, values: Mapping[str, NDArray[Any]]
) -> "tuple[NDArray[np.bool_], ChainBatch] | None":
    """Which rows are straight loops of two turning pulleys without carriages, built as the first drive.

    Their chains beside; the others are computed one by one. None: there is none.
    """
    from cabledrive.mechanics.spans import longitudinal_chains
    from cabledrive.modal.batch import batch_of

    base, found = next(iter(spec.drives.values())), dict[int, Any]()
    build = _build(base) if len(spec.drives) == 1 else None
    given = {
        key: [plain_value(value, spec.units[key]) for value in column]
        for key, column in settings_of(values, "").items()
    }
    rows = len(next(iter(values.values())))
    for i in range(rows if build is not None else 0):
        with suppress(InputRefused):
            drive = varied_together(base, {key: column[i] for key, column in given.items()})
            if _build(drive) == build and is_straight(drive):
                found[i] = drive.two_pulleys
    if not found:
        return None
    good: NDArray[np.bool_] = np.zeros(rows, dtype=bool)
    good[[*found]] = True
    return good, batch_of([longitudinal_chains(drive)[0].chain for drive in found.values()])


def _build(drive: Machine) -> tuple[Any, ...] | None:
    """What loops of one batch have in common; None of what is no plain loop."""
    loop = drive.two_pulleys
    if loop is None or not loop.closed or loop.carriage or any(pulley.fixed for pulley in loop.pulley):
        return None
    motor = loop.motor
    return (
        motor is not None and motor.joint_stiffness is not None,
        motor is not None and motor.holding_stiffness is not None,
    )


def many_modes(spec: CampaignSpec, values: Mapping[str, NDArray[Any]]) -> Many | None:
    """Longitudinal modes of the rows that have only simple ones; None where another way is asked for."""
    from cabledrive.modal.batch import many_spectra

    options = spec.computation.options  # type: ignore[attr-defined]
    fits = "motor" not in options and not OF_BOTH_KINDS & {*options["outputs"]}
    rows = plain_rows(spec, values) if fits else None
    if rows is None:
        return None
    (good, chains), count = rows, options.get("count", DEFAULT_COUNT)
    done, omegas = good.copy(), np.full((good.size, count), np.nan)
    omegas[good], done[good] = many_spectra(chains, count)
    return done, {"longitudinal_hz": omegas / (2.0 * np.pi), "longitudinal_proven": done.astype(np.int8)}


KINDS = {
    "modes": Kind(
        outputs=_modes_outputs,
        default=("longitudinal_hz", "longitudinal_proven"),
        one=_modes,
        modules=("cabledrive.campaign.kinds", "cabledrive.modal.batch"),
        options={"count": "count", "motor": TEXT},
    ),
    "resonance": Kind(
        outputs=lambda options: declared(RESONANCE),
        default=tuple(name for name in RESONANCE if name not in IN_DETAIL),
        one=_resonance,
        modules=("cabledrive.studies.resonance",),
        options={"torque": "N m", "load_torque": "N m"},
    ),
    "map": Kind(
        outputs=_map_outputs,
        default=("growth", "map_threshold_torque", "map_duration"),
        one=_map,
        modules=("cabledrive.studies.resonance_map",),
        options={"pretensions": f"{LIST}N", "torques": f"{LIST}N m", "torque": "N m", "duration": "s"},
        required=("pretensions", "torques"),
    ),
    "simulate": Kind(
        outputs=lambda options: declared(SIMULATION),
        default=tuple(SIMULATION),
        one=_simulate,
        modules=("cabledrive.simulation.kernels",),
        options={"duration": "s", "torque_amplitude": "N m", "torque_frequency": "Hz", "rate": "Hz"}
        | {"pluck_upper": "m", "pluck_lower": "m", "pluck": "m", "segments": "count"}
        | dict.fromkeys(("pluck_shape", "pluck_span", "coordinate", "model", "method"), TEXT)
        | dict.fromkeys(FLAGS, FLAG),
        required=("duration",),
    ),
    "track": Kind(
        outputs=lambda options: declared(TRACK),
        default=("peak_error_deg", "rms_error_deg", "peak_torque", "saturated_fraction"),
        one=_track,
        modules=("cabledrive.rig.tracking",),
        options={"bandwidth": "Hz", "jitter": "s", "segments": "count"}
        | dict.fromkeys(("controller", "gains", "plant", "feedforward", "observer", "feedback"), TEXT)
        | {"encoder_phase": TEXT}
        | dict.fromkeys(("ideal_sensors", "smooth_friction", "tension_only", "no_adaptation"), FLAG),
        spaces=(PLANT, MOTION),
    ),
    "study": Kind(
        outputs=lambda options: declared(STUDY),
        default=("verdict", "headline", "chosen_controller", "reached_error_deg", "confidence"),
        one=_study,
        modules=("cabledrive.studies.study.pipeline",),
        options={"quick": FLAG},
        spaces=(GOALS,),
        long=True,
    ),
}
