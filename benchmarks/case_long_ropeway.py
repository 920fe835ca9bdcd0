"""A ropeway with a thousand carriages: certified modes with shapes against bisection on the same count."""

from dataclasses import replace
from math import pi

import numpy as np
from exact import exact_frequency
from harness import duration, side_by_side, table, worst_error

import cabledrive as cd
from cabledrive.mechanics.spans import longitudinal_chains
from cabledrive.modal.natural import longitudinal_modes
from cabledrive.modal.route_network import network_at_rest
from cabledrive.modal.spectrum import Spectrum

TITLE = "A ropeway with 1,000 carriages, first 50 modes"
CARRIAGES, MODES = 1000, 50
SIZES = (100, 300, 1000, 3000, 10000)
TOLERANCE = 1e-12


def report() -> str:
    return f"{against_bisection()}\n\n{growth()}"


def ropeway(carriages: int) -> cd.Drive:
    """The packaged ropeway with carriages at uneven distances, half of them on either span."""
    drive = cd.load_drive("ropeway").two_pulleys
    rng = np.random.default_rng(1)
    gaps = rng.uniform(0.5, 1.5, carriages // 2 + 1)
    places = drive.span_length * np.cumsum(gaps)[:-1] / gaps.sum()
    template = drive.carriage[0]
    strung = [
        replace(template, span=span, position=float(s), mass=template.mass * float(rng.uniform(0.5, 1.5)))
        for span in ("upper", "lower")
        for s in places
    ]
    return replace(drive, carriage=tuple(strung))


def bisection(drive: cd.Drive) -> np.ndarray:
    """Each of the first modes by halving on the count alone; frequencies [Hz] without shapes."""
    (labelled,) = longitudinal_chains(drive)
    spectrum = Spectrum(network_at_rest(drive.machine, taut=True)[0])
    top = pi / labelled.chain.travel_times.sum()
    while spectrum.count(top, {"longitudinal"}) < MODES:
        top *= 2
    found, low = [], 0.0
    for number in range(1, MODES + 1):
        high = top
        while high - low > TOLERANCE * high:
            middle = 0.5 * (low + high)
            low, high = (
                (low, middle) if spectrum.count(middle, {"longitudinal"}) >= number else (middle, high)
            )
        found.append(0.5 * (low + high))
    return np.array(found) / (2 * pi)


def against_bisection() -> str:
    drive = ropeway(CARRIAGES)
    times = side_by_side(
        {
            "cabledrive": lambda: longitudinal_modes(drive, count=MODES, taut=True),
            "bisection": lambda: bisection(drive),
        }
    )
    ours, plain = times["cabledrive"], times["bisection"]
    frequencies = np.array([mode.frequency for mode in ours.result])
    (labelled,) = longitudinal_chains(drive)
    some = [0, MODES // 2, MODES - 1]
    exact = np.array([exact_frequency(labelled.chain, 2 * pi * frequencies[k]) for k in some]) / (2 * pi)
    proven = sum(mode.proven for mode in ours.result)
    gives = f"frequencies, shapes, {proven} of {MODES} proven"
    errors = [f"{worst_error(found[some], exact):.0e}" for found in (frequencies, plain.result)]
    rows = [
        ("cabledrive", gives, duration(ours), errors[0], "1"),
        ("bisection", "frequencies", duration(plain), errors[1], f"{plain.times_slower_than(ours):.2f}"),
    ]
    note = (
        f"Errors of modes 1, {some[1] + 1} and {MODES} against fifty digits. Target: less than 0.1 s, and "
        "less than bisection on the same count to 1e-12."
    )
    return table(["method", "gives", "time", "error", "times ours"], rows) + "\n\n" + note


def growth() -> str:
    """Time per mode against the number of carriages, and its exponent."""
    drives = {size: ropeway(size) for size in SIZES}
    times = side_by_side(
        {str(n): lambda d=d: longitudinal_modes(d, count=MODES, taut=True) for n, d in drives.items()}
    )
    per_mode = np.array([times[str(n)].median / MODES for n in SIZES])
    fit = np.polyfit(np.log(SIZES), np.log(per_mode), 1)[0]
    last = np.log(per_mode[-1] / per_mode[-3]) / np.log(SIZES[-1] / SIZES[-3])
    rows = [(n, duration(times[str(n)]), f"{1e6 * t:.0f} µs") for n, t in zip(SIZES, per_mode, strict=True)]
    note = (
        f"Exponent of the time per mode: {fit:.2f} fitted from {SIZES[0]} to {SIZES[-1]}, "
        f"{last:.2f} from {SIZES[-3]} to {SIZES[-1]}; target: at most 1.1. "
        "Tables are counted as Python for many frequencies at once."
    )
    return table(["carriages", f"first {MODES} modes", "per mode"], rows) + "\n\n" + note
