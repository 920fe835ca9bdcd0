"""A virtual experiment as chapter 4 describes them: excitation by a file, log like a laboratory's."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cabledrive.identification.excitation import (
    chirp,
    low_crest_multisine,
    multisine_lines,
    random_multisine,
    steps,
    sum_of_sines,
)
from cabledrive.identification.logs.log import Log
from cabledrive.parameters import Drive, InputRefused
from cabledrive.parameters.fields import nearest
from cabledrive.parameters.route.drive import RoutedDrive
from cabledrive.parameters.route.two_pulleys import AxisDrive
from cabledrive.parameters.toml_values import flag_of, quantities_of, quantity_of, read_toml, whole_of
from cabledrive.reduction.network_axis import as_axis
from cabledrive.rig.bench.chapter_4 import rig_of
from cabledrive.rig.bench.load_cell import with_load_cell
from cabledrive.rig.bench.virtual_rig import run_rig

Array = NDArray[np.float64]

KINDS = ("sines", "multisine", "idinput", "chirp", "steps")
KEYS = (
    "kind",
    "duration",
    "frequencies",
    "amplitudes",
    "amplitude",
    "bias",
    "band",
    "lines",
    "period",
    "odd",
    "trials",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Excitation:
    """The command of an experiment.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    duration : float
        [s].
    frequencies, amplitudes : tuple of float
        Of "sines" [Hz], [V].
    amplitude : float
        Largest value of the others [V].
    bias : float
        Constant part [V]; keeps the shaft turning one way, so that Coulomb friction is constant.
    band : (float, float)
        Of multisines and chirp [Hz].
    lines : int or None
        Number of sines in the band; None: all.
    period : float
        Of multisines and steps [s].
    odd : bool
        Odd lines only.
    trials : int
        Draws of "idinput".
    """

    kind: str = "sines"
    duration: float = 70.0
    frequencies: tuple[float, ...] = (1.0, 3.0, 5.0)
    amplitudes: tuple[float, ...] = (0.1, 0.1, 0.1)
    amplitude: float = 0.35
    bias: float = 0.0
    band: tuple[float, float] = (1.0, 250.0)
    lines: int | None = None
    period: float = 2.0
    odd: bool = True
    trials: int = 10

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputRefused(f'excitation "{self.kind}" is unknown{nearest(self.kind, KINDS)}')
        if not 0.0 < self.duration <= 3600.0:
            raise InputRefused(
                f"duration = {self.duration:.4g} s must lie above 0 and below 3600 s: shorten it"
            )
        if len(self.frequencies) != len(self.amplitudes):
            counts = f"{len(self.frequencies)} frequencies and {len(self.amplitudes)} amplitudes"
            raise InputRefused(f"{counts}: give as many of one as of the other")
        if not self.frequencies:
            raise InputRefused("frequencies holds none: give at least one, or another kind")
        if len(self.band) != 2:
            raise InputRefused(f"band holds {len(self.band)} frequencies: give the lowest and the highest")
        if not self.period > 0.0:
            raise InputRefused(f"period = {self.period:.4g} s must be above 0: lengthen it")


def load_excitation(path: str | Path) -> Excitation:
    """Read an excitation from a TOML file.

    Raises `InputRefused` if it is not understood.
    """
    path = Path(path)
    content = read_toml(path, "write TOML")
    try:
        return excitation_of(content)
    except InputRefused as refusal:
        raise refusal.at(path.name) from None


def excitation_of(table: Mapping[str, Any]) -> Excitation:
    """An excitation from a table of TOML.

    Raises `InputRefused` if a key is unknown or a value has another unit.
    """
    units = {"duration": "s", "period": "s", "amplitude": "V", "bias": "V"}
    lists = {"frequencies": "Hz", "amplitudes": "V", "band": "Hz"}
    found: dict[str, Any] = {}
    for key, value in table.items():
        if key not in KEYS:
            raise InputRefused(f"{key}: unknown key{nearest(key, KEYS)}")
        if key in units:
            found[key] = quantity_of(key, value, units[key])
        elif key in lists:
            found[key] = quantities_of(key, value, lists[key])
        elif key in ("lines", "trials"):
            found[key] = whole_of(key, value)
        else:
            found[key] = flag_of(key, value) if key == "odd" else str(value)
    return Excitation(**found)


def command_of(excitation: Excitation, sample_rate: float, rng: np.random.Generator) -> Array:
    """The command, sample by sample.

    ``sample_rate`` [Hz]; ``rng``: phases of "sines" and "idinput".
    Returns shape (samples,) [V].
    Raises `InputRefused` if the period of a multisine is shorter than three samples.
    """
    e, samples = excitation, round(excitation.duration * sample_rate)
    if e.kind == "sines":
        phases = rng.uniform(0.0, 2 * np.pi, len(e.frequencies))
        return e.bias + sum_of_sines(e.duration, sample_rate, e.frequencies, e.amplitudes, phases)
    if e.kind == "chirp":
        return e.bias + e.amplitude * chirp(e.duration, sample_rate, *e.band)
    if e.kind == "steps":
        return e.bias + e.amplitude * steps(e.duration, sample_rate, e.period)
    period = round(e.period * sample_rate)
    if period < 3:
        raise InputRefused(f"period = {e.period:.4g} s holds {period} samples: lengthen it")
    lines = multisine_lines(period, sample_rate, *e.band, count=e.lines, odd=e.odd)
    if e.kind == "idinput":
        wave = random_multisine(period, sample_rate, lines, e.trials, rng)
    else:
        wave = low_crest_multisine(period, sample_rate, lines)
    return e.bias + e.amplitude * np.tile(wave.values, -(-samples // period))[:samples]


def random_from(seed: int) -> np.random.Generator:
    """A generator for phases and noise.

    Raises `InputRefused` if it is negative.
    """
    if seed < 0:
        raise InputRefused(f"seed = {seed} must not be negative: give 0 or more")
    return np.random.default_rng(seed)


def experiment(
    drive: Drive | RoutedDrive,
    excitation: Excitation | None = None,
    *,
    model: int | None = None,
    seed: int = 0,
) -> Log:
    """Run a virtual experiment on a drive and return its log.

    Parameters
    ----------
    drive : Drive or RoutedDrive
        Of a machine with routes the chain of its axis, where it is one.
    excitation : Excitation, optional
        Default: 1, 3 and 5 Hz of 0.1 V for 70 s, as in section 4.2.
    model : {1, 2, 3, 4}, optional
        Model of the plant; default: the highest that the drive's data allow.
    seed : int, default 0
        Of phases, noise and encoder phases.

    Returns
    -------
    Log
    """
    drive = as_axis(drive)
    rng = random_from(seed)
    rig = rig_of(drive, model)
    command = command_of(excitation or Excitation(), rig.sample_rate, rng)
    log = run_rig(rig, command, rng, source=f"virtual rig of {drive.name}")
    # A lumped chain of routes has no spans whose tension a load cell could measure.
    return log if isinstance(drive, AxisDrive) else with_load_cell(log, drive, rng)
