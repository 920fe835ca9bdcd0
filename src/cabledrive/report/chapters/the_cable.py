"""Chapter "The cable": the nonlinear loop in time, plucked, forced, whirling, slack, and by every method."""

import numpy as np

from cabledrive.parameters import Drive, content_hash, load_drive
from cabledrive.report.animation import animation_svg
from cabledrive.report.blocks import Chapter, Column, Figure, Paragraph, RowGroup, Section, Table
from cabledrive.report.context import ReportContext
from cabledrive.report.figures.run_fields import (
    energy_picture,
    slack_picture,
    space_time_picture,
    tension_field,
    tension_picture,
)
from cabledrive.report.figures.run_histories import (
    orbit_picture,
    spectrum_marks,
    spectrum_picture,
)
from cabledrive.report.motion import frame_interval
from cabledrive.report.numbers import number, quantity
from cabledrive.report.picture import Picture
from cabledrive.report.time_plots import histories_plot
from cabledrive.simulation import SimulationResult
from cabledrive.studies.cable_runs import (
    PLUCKS,
    SEGMENTS,
    TORQUE,
    WHIRL,
    by_every_way,
    forced_run,
    largest_difference,
    plucked_run,
    sag_table,
    slack_torque,
    slackened_run,
    whirling_run,
)
from cabledrive.studies.spectrum import amplitude_spectrum

PLACE = 400
EXAMPLE = "dissertation-2"
PRINTED_PEAK = 81.6  # Hz, Fig. 3.6
_SHOWN, _FAST_RATE = 0.08, 20_000.0


def chapter(context: ReportContext) -> Chapter | None:
    """Runs of the rig of chapter 5, where it is among the drives."""
    digest = content_hash(load_drive(EXAMPLE))
    if digest not in context.hashes:
        return None
    drive = context.drives[context.hashes.index(digest)]
    context.progress("the cable in time")
    every = max(1, round(_FAST_RATE * frame_interval(drive) / 2.0))
    close = plucked_run(drive, _SHOWN, rate=_FAST_RATE, fields=every)
    return Chapter(
        title="The cable",
        summary="Large motion of the loop: plucked, forced, whirling and slack, with its energy budget.",
        anchor="the-cable",
        blocks=(
            Paragraph(
                text=f"{drive.name}: time simulation of the nonlinear loop. Both spans are plucked at "
                "midspan, "
                f"the upper one by {quantity(PLUCKS[0], 'm')} and the lower one by "
                f"{quantity(PLUCKS[1], 'm')}, from equilibrium. The tension of a vibrating span rises and "
                "falls twice per period; the two spans pull unequally, and the pulleys turn."
            ),
            _animation(drive, close),
        ),
        sections=(_at_rest(drive), _free(drive, close), _forced(drive), _slack(drive), _ways(drive)),
        methods=(
            f"The cable in time: leapfrog on a conservative chain with the exact geometry of the cable, "
            f"{SEGMENTS} segments per span unless stated otherwise; each figure is drawn from a run of its "
            "own.",
        ),
        headline=f"{drive.name} plucked and forced on the exact nonlinear loop; largest error of the "
        f"energy balance of the first run: {number(close.energy_budget_error, 2)}.",
    )


def _figure(name: str, picture: Picture, alt: str, caption: str) -> Figure:
    return Figure(name=name, alt=alt, caption=caption, wide=picture.wide, narrow=picture.narrow)


def _animation(drive: Drive, run: SimulationResult) -> Figure:
    switch, wide, narrow = animation_svg("cable-animation", drive, run)
    return Figure(
        name="cable-animation",
        alt="The loop in motion: the corners of both plucks split and travel along the spans, and the "
        "light load pulley oscillates in time with them.",
        caption="The loop in slow motion, deflections and angles magnified by the stated factors.",
        switch=switch,
        wide=wide,
        narrow=narrow,
    )


def _at_rest(drive: Drive) -> Section:
    sag = sag_table(drive)
    rows = (
        ("Chain of 200 segments, exact law, Newton's method", sag.chain),
        ("Elastic catenary", sag.catenary),
        ("Parabola, tension raised by its own stretch", sag.parabola),
        ("Parabola at the pretension", sag.unstretched),
    )
    table = Table(
        caption="Sag of the upper span at midspan.",
        columns=(
            Column(title="By"),
            Column(title="Sag", unit="mm", numeric=True),
            Column(title="Off the catenary", numeric=True),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (words, f"{1e3 * value:.9f}", number(value / sag.catenary - 1.0, 2))
                    for words, value in rows
                )
            ),
        ),
        note="The catenary is exact for a linearly elastic cable; the chain has the same geometry.",
    )
    return Section(title="At rest", anchor="cable-at-rest", blocks=(table,))


def _free(drive: Drive, close: SimulationResult) -> Section:
    long = plucked_run(drive, 2.0)
    spectrum = amplitude_spectrum(long.time, long.load_angle)
    marks = spectrum_marks(drive)
    mode = next(frequency for frequency, kind in marks if kind == "longitudinal")
    string = next(frequency for frequency, kind in marks if kind == "transverse")
    peak, height = spectrum.peak(0.9 * mode, 1.1 * mode)
    twice, twice_height = spectrum.peak(1.9 * string, 2.1 * string)
    tension = tension_field(drive, close)
    whirl = whirling_run(drive, 0.3)
    return Section(
        title="Plucked",
        anchor="cable-plucked",
        blocks=(
            histories_plot(
                "cable-histories",
                close,
                alt="Three curves over time: the angle of the load pulley shows beats, both midpoints "
                "vibrate in a plane.",
                caption=f"Load pulley and midpoints after the plucks. Largest error of the energy balance: "
                f"{number(close.energy_budget_error, 2)} of the largest energy handled.",
            ),
            _figure(
                "cable-spectrum",
                spectrum_picture("cable-spectrum", long, marks),
                "Amplitude spectrum of the load angle on a logarithmic scale, with peaks at the lowest "
                "pulley mode, and at one and two times the frequency of the spans.",
                f"As Fig. 3.6, amplitude spectrum of the load angle over {number(long.time[-1])} s (Hann "
                f"window). The peak of the pulley mode is at {number(peak, 4)} Hz (printed: "
                f"{number(PRINTED_PEAK)} Hz, certified mode: {number(mode, 5)} Hz); peaks are resolved from "
                f"{number(2 * spectrum.resolution, 2)} Hz apart. The peak at {number(twice, 4)} Hz, "
                f"{number(twice_height / height, 2)} times as high, is twice the frequency of the spans: "
                "their tension acts on the pulley twice per period. Ticks: certified modes, long ones "
                "longitudinal.",
            ),
            _figure(
                "cable-space-time",
                space_time_picture("cable-space-time", close),
                "Map of the upper span over time: nested boxes, blue and orange by turns.",
                f"The upper span in space and time, w: the corner of the pluck splits in two, which travel "
                f"to the pulleys at {number(_wave_speed(drive), 3)} m/s and return inverted; between them "
                "the span is straight.",
            ),
            _figure(
                "cable-tension",
                tension_picture("cable-tension", drive, close),
                "Map of the tension along the upper and then the lower span over time: vertical stripes, "
                "different in each span.",
                "Tension along the cable, upper span below the dashed line, minus the pretension of "
                f"{quantity(drive.cable.pretension, 'N')}; it stays between {number(tension.min(), 4)} and "
                f"{number(tension.max(), 4)} N. Longitudinal waves are {number(_ratio(drive), 2)} times as "
                "fast as transverse ones, so the tension is nearly uniform along a span, as the fast model "
                "assumes.",
            ),
            _figure(
                "cable-orbit",
                orbit_picture("cable-orbit", whirl),
                "Orbit of the midpoint in the plane of v and w: an ellipse whose axes rotate slowly.",
                f"Whirl: midpoint of the upper span over {number(whirl.time[-1], 2)} s after a half-sine "
                f"pluck of {quantity(WHIRL, 'm')} in w and a kick in v. The stretch of the cable rotates "
                "the ellipse.",
            ),
        ),
    )


def _wave_speed(drive: Drive) -> float:
    return float(np.sqrt(drive.cable.pretension / drive.cable.stretched_mass_per_length))


def _ratio(drive: Drive) -> float:
    """Speed of waves along the cable over that of waves across it."""
    cable = drive.cable
    return float(np.sqrt((cable.axial_rigidity + cable.pretension) / cable.pretension))


def _forced(drive: Drive) -> Section:
    run = forced_run(drive, 0.3)
    peak = float(np.max(np.abs(run.load_angle - run.load_angle[0])))
    figures = (
        histories_plot(
            "cable-forced",
            run,
            alt="Three curves over time: the amplitudes of the load angle and of both midpoints grow.",
            caption=f"Torque of {quantity(TORQUE, 'N m')} at the frequency of the lowest longitudinal mode, "
            "from rest. The midpoints follow the tension, which changes the sag; "
            f"the motion is undamped, and the load angle reaches {quantity(peak, 'rad', 3)} in "
            f"{number(run.time[-1], 2)} s.",
        ),
        _figure(
            "cable-energy",
            energy_picture("cable-energy", run),
            "Above, energies over time with the work of the torque as their envelope; below, the error of "
            "the energy balance, very small.",
            f"Energies and the work of the torque, in microjoules, and the error of the balance over the "
            f"largest energy handled: at most {number(run.energy_budget_error, 2)} over {run.steps} steps.",
        ),
    )
    return Section(title="Forced", anchor="cable-forced-response", blocks=figures)


def _slack(drive: Drive) -> Section:
    run = slackened_run(drive)
    event = run.slack_events[0]
    found = float(np.interp(event.time, run.time, run.channel("torque")))
    expected = slack_torque(drive)
    return Section(
        title="Slack",
        anchor="cable-slack",
        blocks=(
            _figure(
                "cable-slack-torque",
                slack_picture("cable-slack-torque", run),
                "Least tension of both spans over the torque: two straight lines, one rising, one falling to "
                "zero.",
                f"Load pulley held, torque on the drive pulley raised slowly, without weight: the "
                f"{event.span} span goes slack at {number(found, 5)} N m, where 2 r T₀ is "
                f"{number(expected, 5)} N m, and the run stops with a message.",
            ),
        ),
    )


def _ways(drive: Drive) -> Section:
    runs = list(by_every_way(drive, 0.3))
    reference = runs[0][2]
    rows = tuple(
        (
            f"{model}, {method}",
            f"{run.steps}",
            number(run.cfl, 2),
            number(run.energy_budget_error, 2),
            number(100.0 * largest_difference(run, reference), 2),
            number(1e3 * float(np.ptp(run.load_angle)), 4),
        )
        for model, method, run in runs
    )
    table = Table(
        caption="The same plucks with several cable laws and integrators, 0.3 s, 60 segments per span.",
        columns=(
            Column(title="Law, method"),
            Column(title="Steps", numeric=True),
            Column(title="CFL", numeric=True),
            Column(title="Energy error", numeric=True),
            Column(title="Difference", unit="%", numeric=True),
            Column(title="Load, p-p", unit="mrad", numeric=True),
        ),
        groups=(RowGroup(rows=rows),),
        note="CFL: step over the largest stable one. Difference: largest difference of the upper midpoint "
        "over its largest deflection. With the linear law the pulleys stay at rest, since it neglects the "
        "tension caused by a deflection. The weak law, as printed, has no potential, so its energy balance "
        "does not close to the order of the step alone. The fast model integrates 16 sines per span and "
        "differs at the corners of a triangle.",
    )
    return Section(title="Comparison of models and integrators", anchor="cable-comparison", blocks=(table,))
