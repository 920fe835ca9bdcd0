"""Thresholds of pairs: the 1:2 formula of the averaged equations, the sum type by Floquet's theorem."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import cabledrive as cd
from cabledrive.reduction.autoparametric import autoparametric_model
from cabledrive.reduction.sagging_model import BAND, longitudinal_modes, sagging_model
from cabledrive.reduction.static_state import static_state
from cabledrive.reduction.threshold import mode_thresholds
from cabledrive.studies.pair_thresholds import ONE_TO_TWO, coupled_pairs
from resonance_samples import damped


@pytest.mark.parametrize("pretension", [3.15, 3.28377, 3.5])
def test_one_to_two_pairs_have_the_thresholds_of_the_averaged_equations(pretension):
    drive, number = damped(2.0, 5.0), 1
    drive = replace(drive, cable=replace(drive.cable, pretension=pretension))
    model = autoparametric_model(drive, number=number, at_rest=True)
    expected = mode_thresholds(model)[0]
    pairs = [p for p in coupled_pairs(drive, model.natural) if p.kind == ONE_TO_TWO and p.span == "upper"]
    found = next(
        p
        for p in pairs
        if p.numbers[0] == number and abs(p.longitudinal_hz * 2 * pi / model.natural - 1) < 1e-9
    )
    assert found.threshold_torque == pytest.approx(expected, rel=2e-3), found


def hanging():
    """Two spans of which one carries a hanging mass: its pieces are strained unevenly."""
    settings = ["cable.transverse_damping=4", "pulley.1.viscous_friction=2e-5", "cable.pretension=3"]
    drive = cd.load_drive("dissertation-2", overrides=settings)
    carriage = cd.parameters.Carriage(mass=3e-4, position=0.37, guided=False)
    return cd.parameters.Drive(
        **{name: getattr(drive, name) for name in ("name", "kind", "cable", "layout", "pulley")},
        carriage=(carriage,),
    )


def test_a_sum_pair_grows_above_its_threshold_and_not_below(measured):
    """Two oscillators under q = Q cos Wt: the largest Floquet multiplier crosses one at the threshold."""
    drive = hanging()
    state = static_state(drive, segments=240)
    modes = longitudinal_modes(drive, state, 0.0)
    model = sagging_model(drive, state, modes, [range(1, 9), range(1, 9)])
    natural = float(model.natural[1])
    r, a, b = 0, 0, 1
    own = model.transverse[r, [a, b]]
    mass, loss = model.mass[r, [a, b]], model.loss[r, [a, b]]
    coupled = float(model.coupling[1, r, a, b - a + BAND])
    forcing = float(own.sum()) + 0.5
    kappa = abs(coupled) / (4 * sqrt(mass[0] * mass[1] * own[0] * own[1]))
    least = sqrt(0.25 * loss[0] * loss[1] * (1 + 4 * 0.5**2 / (loss[0] + loss[1]) ** 2))

    def largest(amplitude):
        def rates(t, y):
            pull = coupled * amplitude * np.cos(forcing * t) * y[[1, 0]] / mass
            return np.concatenate((y[2:], -loss * y[2:] - own**2 * y[:2] - pull))

        period = 2 * pi / forcing
        columns = [
            solve_ivp(rates, (0, period), start, rtol=1e-10, atol=1e-13).y[:, -1] for start in np.eye(4)
        ]
        return float(np.max(np.abs(np.linalg.eigvals(np.array(columns).T))))

    below, above = largest(0.97 * least / kappa), largest(1.03 * least / kappa)
    measured(f"largest multiplier {below:.4f} at 0.97, {above:.4f} at 1.03 of the threshold")
    assert natural > 0.0
    assert below < 1.0 < above
