"""The lumped chain is Models 1 to 4, and its transfer functions are those of chapters 4 and 6."""

import numpy as np
import pytest

from cabledrive.parameters import InputRefused, load_drive
from cabledrive.reduction.lumped_chain import (
    natural_frequencies_of,
    speed_response,
    speed_transfer_function,
    state_space,
)
from cabledrive.reduction.models import lumped_model

DRIVE = load_drive("dissertation-3")
J11, J12, J2, B1 = 0.0011, 0.000642, 0.00235, 0.0031
K_M, B_M, KK, BB = 135.0, 0.075, 2 * 850 * 0.04**2, 2 * 0.18 * 0.04
OMEGA = 2 * np.pi * np.geomspace(0.3, 400.0, 60)


def test_model_1_is_one_inertia():
    """(4.17) with all inertias in one."""
    numerator, denominator = speed_transfer_function(lumped_model(DRIVE, 1))
    total = J11 + J12 + J2
    np.testing.assert_allclose(numerator, [1 / total], rtol=1e-13)
    np.testing.assert_allclose(denominator, [1.0, B1 / total], rtol=1e-13)


def test_model_2_is_the_first_line_of_4_19_with_the_load_on_the_pulley():
    s, j = 1j * OMEGA, J12 + J2
    pulley = j * s**2 + B_M * s + K_M
    printed = pulley * s / ((J11 * s**2 + (B1 + B_M) * s + K_M) * pulley - (K_M + B_M * s) ** 2)
    numerator, denominator = speed_transfer_function(lumped_model(DRIVE, 2))
    np.testing.assert_allclose(np.polyval(numerator, s) / np.polyval(denominator, s), printed, rtol=1e-10)


def test_model_3_has_the_coefficients_of_6_12():
    numerator, denominator = speed_transfer_function(lumped_model(DRIVE, 3))
    j1 = J11 + J12
    np.testing.assert_allclose(numerator, [1 / j1, BB / (j1 * J2), KK / (j1 * J2)], rtol=1e-10)
    expected = [1.0, (B1 + BB) / j1 + BB / J2, KK / j1 + KK / J2 + B1 * BB / (j1 * J2), KK * B1 / (j1 * J2)]
    np.testing.assert_allclose(denominator, expected, rtol=1e-10)


def test_model_4_is_6_14_with_its_first_line_mended():
    s = 1j * OMEGA
    cable = s**2 + BB / J2 * s + KK / J2
    quartic = (
        s**4
        + (BB / J2 + BB / J12 + B_M / J12) * s**3
        + (KK / J2 + KK / J12 + K_M / J12 + BB * B_M / (J12 * J2)) * s**2
        + (BB * K_M + B_M * KK) / (J12 * J2) * s
        + KK * K_M / (J12 * J2)
    )
    transmitted = B_M / J12 * (s + K_M / B_M) * cable / quartic
    mended = (s / J11) / (s**2 + (B1 + B_M) / J11 * s + K_M / J11 - transmitted * B_M / J11 * (s + K_M / B_M))
    chain = lumped_model(DRIVE, 4)
    numerator, denominator = speed_transfer_function(chain)
    np.testing.assert_allclose(np.polyval(numerator, s) / np.polyval(denominator, s), mended, rtol=1e-9)
    np.testing.assert_allclose(speed_response(chain, OMEGA), mended, rtol=1e-10)


def test_natural_frequencies_are_those_of_table_6_2():
    """8.27 Hz and 92.2 Hz follow from Table 6.2."""
    found = natural_frequencies_of(lumped_model(DRIVE)) / (2 * np.pi)
    np.testing.assert_allclose(found, [8.27, 92.2], rtol=1e-3)


def test_rigid_rotation_costs_no_energy_at_unequal_radii():
    from dataclasses import replace

    drive = replace(DRIVE, pulley=(DRIVE.pulley[0], replace(DRIVE.pulley[1], radius=0.06)))
    chain = lumped_model(drive)
    turned = np.array([1.0, 1.0, 0.04 / 0.06])
    assert np.abs(chain.stiffness_matrix @ turned).max() < 1e-13 * np.abs(chain.stiffness_matrix).max()
    merged = lumped_model(drive, 1)
    assert merged.inertias[0] == pytest.approx(turned @ np.diag(chain.inertias) @ turned, rel=1e-14)


def test_both_state_spaces_have_the_same_poles():
    chain = lumped_model(DRIVE)
    a, _ = state_space(chain)
    _, denominator = speed_transfer_function(chain)
    poles = np.sort_complex(np.linalg.eigvals(a))
    minimal = np.sort_complex(np.append(np.roots(denominator), 0.0))
    np.testing.assert_allclose(poles, minimal, atol=1e-5)


@pytest.mark.parametrize(
    "name, model", [("dissertation-2", 4), ("dissertation-transporter", 3), ("dissertation-3", 5)]
)
def test_a_model_the_drive_has_no_data_for_is_refused(name, model):
    with pytest.raises(InputRefused, match="model"):
        lumped_model(load_drive(name), model)
