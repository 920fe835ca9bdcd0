"""Pairs of modes that come near internal resonance along a planned motion."""

from dataclasses import dataclass
from math import pi

import numpy as np

from cabledrive.parameters.arrays import Array
from cabledrive.reduction.threshold import lost_square
from cabledrive.studies.motion_response import PreparedMotion
from cabledrive.studies.motion_stages import interpolated
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, SUM, near_pairs

INSTANTS = 2000


@dataclass(frozen=True, slots=True, kw_only=True)
class Passage:
    """A longitudinal mode and the one or two transverse modes that it comes near to exciting."""

    kind: str  # {"1:2", "sum"}
    # span, plane: of the first transverse mode
    span: str
    plane: str
    # longitudinal_hz, transverse_hz: where the amplitude is the largest share of the threshold [Hz]
    longitudinal_hz: float
    transverse_hz: tuple[float, float]
    # lowest and highest longitudinal frequency minus the sum of the transverse ones [Hz]
    detuning_hz: tuple[float, float]
    passes: bool  # whether it goes through resonance
    amplitude: float  # amplitude of the longitudinal mode over its threshold, the largest along the motion
    time: float  # when [s]


def passages_of(prepared: PreparedMotion, spans: tuple[str, ...]) -> tuple[Passage, ...]:
    """Every pair that comes near resonance along a motion, the largest amplitude over its threshold first."""
    time, swing = prepared.swing
    picked = np.unique(np.linspace(0, time.size - 1, INSTANTS).astype(np.intp))
    here = np.interp(time[picked], prepared.time, prepared.here)

    def at(name: str) -> Array:
        return interpolated([getattr(model, name) for model in prepared.models], here)

    natural, across, loss = at("natural"), at("transverse"), at("loss")
    found = []
    for row, places in enumerate(prepared.places):
        size = len(places)
        mass = np.array([model.mass[row, :size] for model in prepared.models])
        w, lost = across[:, row, :size], loss[:, row, :size]
        for q in np.flatnonzero(natural[0] > 0.0):
            coupled = np.abs([model.coupling[q, row, :size, :size] for model in prepared.models])
            coupled = coupled / np.sqrt(mass[:, :, None] * mass[:, None, :])
            detunings = natural[:, q, None, None] - w[:, :, None] - w[:, None, :]
            crossed = np.ptp(np.sign(detunings), axis=0) > 0.0
            off = np.abs(detunings / natural[:, q, None, None]).min(axis=0)
            for i, j in near_pairs(coupled.max(axis=0), np.where(crossed, 0.0, off)):
                detuning = detunings[:, i, j]
                least = lost_square(0.5 * lost[:, i], 0.5 * lost[:, j], detuning)
                threshold = 4.0 * np.sqrt(w[:, i] * w[:, j] * least)
                share = interpolated(coupled[:, i, j], here) * swing[picked, q]
                share = share / np.maximum(threshold, 1e-300)
                when = int(np.argmax(share))
                found.append(
                    Passage(
                        kind=ONE_TO_TWO if i == j else SUM,
                        span=spans[places[i][0]],
                        plane=places[i][2],
                        longitudinal_hz=float(natural[when, q]) / (2.0 * pi),
                        transverse_hz=(float(w[when, i]) / (2.0 * pi), float(w[when, j]) / (2.0 * pi)),
                        detuning_hz=(float(detuning.min()) / (2.0 * pi), float(detuning.max()) / (2.0 * pi)),
                        passes=bool(detuning.min() <= 0.0 <= detuning.max()),
                        amplitude=float(share[when]),
                        time=float(time[picked[when]]),
                    )
                )
    return tuple(sorted(found, key=lambda one: -one.amplitude))
