"""Sections 4.1 and 4.4: the ratings of the rig, the camera, the amplifier."""

from math import pi

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.camera.clip import levels_of, spots_of
from cabledrive.parameters import load_drive
from cabledrive.rig.bench.virtual_rig import TORQUE_PER_VOLT
from reproduction.appendix import (
    NOMINAL_SPEED,
    NOMINAL_TORQUE,
    RPM,
    TORQUE_CONSTANT,
    VOLTAGE,
    encoder_counts,
    gear_ratio,
)
from reproduction.item import DIFFERS, Entry, Item, Outcome, outcome, place
from reproduction.judge import claimed, compared, erratum, taken, unknown
from reproduction.panel import Panel, curve

CHOSEN = "a dimension or setting of the rig: nothing in the print gives it again"
ROWS, COLUMNS = 160, 224
SEED = 2015


def section_4_1(quick: bool) -> Outcome:
    """Every number of the description of the rig.

    ``quick``: changes nothing here.
    """
    sensors, gear = load_drive("dissertation-3").sensors, gear_ratio()
    assert sensors is not None
    assert sensors.load_encoder is not None
    power = "240 W is nominal torque times nominal speed, 200 W the motor's name in Table A.1"
    camera = "480 frames/s is the camera's largest rate; the experiments of chapter 5 ran at 400"
    items: list[Item] = [
        unknown("section-4-1-shaft", "Section 4.1: diameter of the steel shafts", 0.5, "in", CHOSEN),
        compared(
            "section-4-1-power",
            "Section 4.1: rated power",
            "240",
            NOMINAL_TORQUE * NOMINAL_SPEED * RPM,
            "W",
            tolerance=1.0,
            note=f"{power}. {place('erratum-4-1-motor-power')}",
            tested=False,
        ),
        compared(
            "section-4-1-speed",
            "Section 4.1: nominal speed, as Table A.1",
            "5680",
            NOMINAL_SPEED,
            "rpm",
            tested=False,
        ),
        compared(
            "section-4-1-voltage",
            "Section 4.1: nominal voltage, as Table A.1",
            "24",
            VOLTAGE,
            "V",
            tested=False,
        ),
        compared(
            "section-4-1-torque",
            "Section 4.1: nominal torque, as Table A.1",
            "0.405",
            NOMINAL_TORQUE,
            "N m",
            tested=False,
        ),
        taken("section-4-1-gear", "Section 4.1: gear ratio", "5.2", gear, ""),
        compared(
            "section-4-1-output-torque",
            "Section 4.1: torque at the output",
            "2.1",
            gear * NOMINAL_TORQUE,
            "N m",
            tested=False,
        ),
        compared(
            "section-4-1-output-speed",
            "Section 4.1: speed at the output",
            "1092",
            NOMINAL_SPEED / gear,
            "rpm",
            tested=False,
        ),
        taken(
            "section-4-1-counts", "Section 4.1: counts of the motor's encoder", "500", encoder_counts(), ""
        ),
        compared(
            "section-4-1-output-counts",
            "Section 4.1: counts per revolution of the output",
            "2600",
            encoder_counts() * gear,
            "",
            note="without the fourfold edges of an incremental encoder",
            tested=False,
        ),
        taken(
            "section-4-1-pulley-counts",
            "Section 4.1: counts of the pulleys' encoders",
            "10000",
            float(sensors.load_encoder),
            "",
        ),
        erratum(
            "section-4-1-camera",
            "Sections 4.1, 5.2.2, 5.3: frames per second",
            "at most 480",
            "400 in the experiments",
            "",
            f"{camera}. {place('erratum-4-1-camera')}",
        ),
        unknown("section-4-1-picture", "Section 4.1: size of a frame", "224 x 160", "pixel", CHOSEN),
    ]
    return outcome(items)


def figure_4_6(quick: bool) -> Outcome:
    """Fig. 4.6: grey frame, threshold, unwanted pixels removed, centroid; on frames that are made up.

    ``quick``: fewer frames.
    """
    rng = np.random.default_rng(SEED)
    truth, found = [], []
    for _ in range(20 if quick else 200):
        row, column = rng.uniform(60.0, 100.0), rng.uniform(100.0, 124.0)
        frame = _frame(row, column, rng)
        spots = spots_of(frame, levels_of([frame]))
        truth.append(row)
        found.append(float(spots[0, 0]))
    error = float(np.sqrt(np.mean((np.array(found) - truth) ** 2)))
    item = claimed(
        "figure-4-6",
        "Fig. 4.6: centroid of the white pixels after removal of unwanted ones",
        "tracks the motion of the cable midpoint",
        f"rms error of the centroid {error:.2g} pixel of {ROWS} by {COLUMNS}, noise and specks added",
        error < 0.2,
        otherwise=(DIFFERS, "the centroid is pulled by what is left of the specks"),
        note=(
            "the frames of the print are lost: a white segment on black with noise and stray specks is "
            "made up"
        ),
    )
    panel = Panel(
        figure="Fig. 4.6",
        title="Centroid found over true place, made-up frames",
        x="true row [pixel]",
        y="row found [pixel]",
        curves=(curve("frames", np.sort(truth), np.array(found)[np.argsort(truth)]),),
    )
    return outcome([item], [panel])


def _frame(row: float, column: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """A white segment of 3 by 24 pixels with soft edges, noise, and a few specks."""
    y, x = np.mgrid[0:ROWS, 0:COLUMNS]
    across = 1.0 / (1.0 + np.exp(4.0 * (np.abs(y - row) - 1.5)))
    along = 1.0 / (1.0 + np.exp(4.0 * (np.abs(x - column) - 12.0)))
    frame = 20.0 + 200.0 * across * along + rng.normal(0.0, 4.0, (ROWS, COLUMNS))
    specks = rng.integers(0, ROWS * COLUMNS, 8)
    frame.ravel()[specks] += 120.0
    return np.asarray(np.clip(frame, 0.0, 255.0), dtype=np.float64)


def figure_4_21(quick: bool) -> Outcome:
    """Fig. 4.21 and (4.20): the amplifier's gain.

    ``quick``: changes nothing here.
    """
    hertz = np.geomspace(1.0, 500.0, 200)
    bandwidth = load_drive("dissertation-3").motor.current_bandwidth or np.inf  # type: ignore[union-attr]
    size = 20 * np.log10(TORQUE_PER_VOLT / np.hypot(1.0, hertz / bandwidth))
    current = 20 * np.log10(TORQUE_PER_VOLT / (TORQUE_CONSTANT * gear_ratio()))
    items = [
        compared(
            "section-4-4-gain",
            "(4.20): gain of the amplifier",
            "4.2",
            20 * np.log10(1.6218),
            "dB",
            tested=False,
        ),
        compared(
            "section-4-4-torque", "(4.20): torque per volt", "1.6218", TORQUE_PER_VOLT, "N m/V", tested=False
        ),
        compared(
            "section-4-4-voltage",
            "(4.20): volts per torque",
            "0.6166",
            1.0 / TORQUE_PER_VOLT,
            "V/(N m)",
            tested=False,
        ),
        erratum(
            "section-4-4-current",
            "Section 4.4: relation between voltage command and motor current",
            4.2,
            float(current),
            "dB",
            "4.2 dB belong to the torque, (4.20); the current would have 18.2. "
            f"{place('erratum-4-20-current')}",
        ),
        claimed(
            "figure-4-21",
            "Fig. 4.21: response of the amplifier",
            "essentially a constant gain",
            f"falls by {size[0] - size[-1]:.2g} dB from 1 to 500 Hz with a torque loop of {bandwidth:g} Hz",
            bool(size[0] - size[-1] < 3.0),
            otherwise=(DIFFERS, "the loop's bandwidth is a choice, none is printed"),
            note="the loop's bandwidth is a choice, none is printed",
            tested=False,
        ),
    ]
    panel = Panel(
        figure="Fig. 4.21",
        title="Torque over voltage command; first-order torque loop chosen",
        x="frequency [Hz]",
        y="gain [dB]",
        curves=(curve("amplifier", hertz, size),),
        log_x=True,
    )
    return outcome(items, [panel])


def section_4_3(quick: bool) -> Outcome:
    """The excitation and the windows of the frequency responses.

    ``quick``: changes nothing here.
    """
    spacing = (500.0 - 1.0) / (1000 - 1)
    hann = np.hanning(5000)
    leak = float(abs(np.sum(hann * np.exp(2j * pi * spacing * np.arange(5000) / 5000.0))) / np.sum(hann))
    return outcome(
        [
            erratum(
                "section-4-3-lines",
                "(4.14), (4.15): 1000 sines from 1 to 500 Hz seen through a Hann window of 1 s",
                "settings of the estimate",
                f"lines {spacing:.4f} Hz apart, the window parts 1 Hz",
                "",
                f"a neighbouring line is seen with {leak:.2f} of its amplitude. "
                f"{place('erratum-4-14-line-spacing')}",
            ),
            unknown(
                "section-4-3-settings",
                "Section 4.3: 5 kHz, 8 s of which 5 s are used, overlap 0.2 s, at most 1 V",
                "5 kHz, 8 s, 5 s, 0.2 s, 1 V",
                "",
                "settings of the experiment: they are used as they are in Figs. 4.17, 4.19 and 6.3",
            ),
        ]
    )


ENTRIES = (
    Entry(name="section-4-1", chapter="4", covers=("Section 4.1",), compute=section_4_1),
    Entry(name="figure-4-6", chapter="4", covers=("Fig. 4.6",), compute=figure_4_6),
    Entry(name="section-4-3", chapter="4", covers=("Section 4.3",), compute=section_4_3),
    Entry(name="figure-4-21", chapter="4", covers=("Fig. 4.21", "Section 4.4"), compute=figure_4_21),
)
