"""Eq. (A.36): its sag stiffens modes as Irvine says, its kernel is its Python, its friction holds."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import cabledrive as cd
from cabledrive.reduction.sagging_kernels import integrate_sagging, rub
from cabledrive.reduction.sagging_model import _fixed_length, longitudinal_modes, numbers_of, sagging_model
from cabledrive.reduction.static_state import static_state
from cabledrive.reduction.transverse_sections import largest_slope, span_tensions


def held_line(sag_parameter_scale):
    """A level line between held pulleys, lightly sagging."""
    pulleys = tuple(cd.Pulley(radius=0.05, inertia=1.0, fixed=True) for _ in range(2))
    return cd.Drive(
        name="line",
        kind="line",
        cable=cd.Cable(
            youngs_modulus=1e12, area=1e-6, mass_per_length=0.08, pretension=250.0 * sag_parameter_scale
        ),
        layout=cd.Layout(span_length=50.0),
        pulley=pulleys,
    )


@pytest.mark.parametrize("scale", [3.0, 6.0])
def test_sag_raises_the_first_symmetric_mode_in_the_plane_as_irvine_says(scale, measured):
    """tan x = x - 4 x^3 / lambda^2 with x half the wave number times the span; uniform tension along it."""
    drive = held_line(scale)
    state = static_state(drive, segments=200)
    model = sagging_model(drive, state, longitudinal_modes(drive, state, 0.0), [range(1, 12)])
    stiffness = np.diag(model.mass[0] * model.transverse[0] ** 2)
    stiffness += model.carried * np.outer(model.bend[0], model.bend[0])
    found = np.sqrt(eigh(stiffness, np.diag(model.mass[0]), eigvals_only=True))
    tension, rigidity = float(state.tension.mean()), drive.cable.axial_rigidity
    ratio = 0.08 * 9.81 * 50.0 / tension
    measured(f"first mode in the plane {found[0] / (2.0 * np.pi):.4f} Hz under {tension:.1f} N")
    parameter = ratio**2 * rigidity / tension
    x = brentq(lambda x: np.sin(x) - (x - 4 * x**3 / parameter) * np.cos(x), 0.5 * np.pi + 1e-9, np.pi - 1e-9)
    string = float(model.transverse[0, 0]) / np.pi
    expected = 2.0 * x * string
    seen = min(found, key=lambda w: abs(w - expected))
    assert seen == pytest.approx(expected, rel=3e-3), (
        f"lambda^2 = {parameter:.3g}: {found[:3]} for {expected}"
    )


@pytest.mark.kernel
def test_compiled_integration_equals_its_python():
    """cabledrive.reduction.sagging_kernels, compiled and as Python."""
    drive = cd.load_drive("dissertation-3", overrides=["layout.inclination=0.3"])
    state = static_state(drive, segments=40)
    modes = longitudinal_modes(drive, state, 0.0)
    model = sagging_model(drive, state, modes, [[1, 2, 5], [1, 3]])
    numbers = numbers_of(model, state, 1e-4)
    torque = 0.5 * np.sin(0.3 * np.arange(60))

    def run(kernel):
        k, (b, m) = model.natural.size, model.transverse.shape
        q, p, a = np.zeros(k), np.zeros(k), np.full((b, m), 1e-4)
        a[np.arange(m) >= model.count[:, None]] = 0.0
        top, modal, when = np.zeros((b, numbers.probes.shape[2])), np.zeros((b, m)), np.zeros((b, m))
        least, history = np.array([np.inf]), np.zeros((60, k))
        rate = np.zeros((b, m))
        kept = top, modal, when, least, history
        kernel(integrate_sagging)(numbers, torque, 0, (1e-4, 1e-4), (q, p, a, rate), kept)
        kernel(rub)(numbers.friction_shape, numbers.impulse_rate, numbers.solved, numbers.friction, 1e-4, p)
        return q, p, a, rate, *kept

    for one, other in zip(run(lambda k: k), run(lambda k: getattr(k, "py_func", k)), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-18)


def test_friction_above_the_torque_holds_the_rims():
    """Below its Coulomb friction neither pulley turns, and the modes keep still."""
    drive = cd.load_drive("dissertation-2")
    drive = replace(drive, pulley=tuple(replace(p, coulomb_friction=0.02) for p in drive.pulley))
    state = static_state(drive, segments=40)
    model = sagging_model(drive, state, longitudinal_modes(drive, state, 0.0), [[1], [1]])
    numbers, p = numbers_of(model, state, 1e-5), np.zeros(model.natural.size)
    p += 1e-5 * (numbers.solve @ (model.torque_shape * 0.01))
    rub(numbers.friction_shape, numbers.impulse_rate, numbers.solved, numbers.friction, 1e-5, p)
    speeds = numbers.friction_shape[:2] @ p
    free = 1e-5 * numbers.friction_shape[0] @ (numbers.solve @ (model.torque_shape * 0.01))
    assert np.max(np.abs(speeds)) < 1e-3 * free, speeds


# --- Limits and sizes that models of the loop state: slack, a span outside a mode, length of the cable
DRIVE = cd.load_drive("dissertation-2")


def test_the_stated_limit_of_the_load_torque_is_where_a_span_goes_slack():
    with pytest.raises(cd.InputRefused) as refused:
        span_tensions(DRIVE, 1e3)
    limit = float(re.search(r"stay below (\S+) N m", str(refused.value))[1])
    assert 0.0 < min(span_tensions(DRIVE, 0.999 * limit).values()) < 2e-3 * DRIVE.cable.pretension
    with pytest.raises(cd.InputRefused):
        span_tensions(DRIVE, 1.001 * limit)


def test_a_span_outside_a_mode_is_not_strained():
    assert largest_slope((), "upper") == 0.0


def test_the_cable_of_a_loop_is_as_long_as_its_stretched_spans():
    stretched = 1.0 + DRIVE.cable.pretension / DRIVE.cable.axial_rigidity
    assert _fixed_length(DRIVE) == pytest.approx(2.0 * DRIVE.span_length * stretched, rel=1e-12)


@pytest.mark.kernel
def test_a_free_mode_across_dies_out_at_its_rate():
    """cabledrive.reduction.sagging_kernels: exp(-c n h/2) of the amplitude is left after n steps of h."""
    settings = ["cable.transverse_damping=8", "layout.gravity=0"]
    drive = cd.load_drive("dissertation-3", overrides=settings)
    state = static_state(drive, segments=40)
    model = sagging_model(drive, state, longitudinal_modes(drive, state, 0.0), [[1, 2], [1, 2]])
    numbers, steps, h = numbers_of(model, state, 1e-5), 1500, 1e-5
    k, (b, m) = model.natural.size, model.transverse.shape
    q, p, a, rate = np.zeros(k), np.zeros(k), np.full((b, m), 1e-9), np.zeros((b, m))
    rest = (np.zeros((b, numbers.probes.shape[2])), np.zeros((b, m)), np.zeros((b, m)), np.array([np.inf]))
    kept = (*rest, np.zeros((steps, k)))
    integrate_sagging(numbers, np.zeros(steps), 0, (h, 0.0), (q, p, a, rate), kept)
    size = np.hypot(a, rate / model.transverse)
    np.testing.assert_allclose(size, 1e-9 * np.exp(-0.5 * model.loss * steps * h), rtol=5e-3)
