"""The transporter over many drawn plants and encoder phases."""

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.studies.transporter_moves import along_the_way, residual_motion, scaled_transporter

pytestmark = pytest.mark.verify
DRIVE = scaled_transporter(load_drive("dissertation-transporter"))
LAWS = ("scheduled", "pd-flat", "pd", "shaper")


@pytest.fixture(scope="module")
def residuals():
    return {
        (law, gust): residual_motion(DRIVE, law, runs=40, seed=1, drawn=True, gust=gust)
        for law in LAWS
        for gust in (0.0, 0.2)
    }


def in_millimetres(residuals, when, wind):
    sizes = {
        law: 1e3 * getattr(found, when) for (law, gust), found in residuals.items() if (gust > 0.0) == wind
    }
    return ", ".join(f"{law} {np.median(size):.2f} / {size.max():.2f}" for law, size in sizes.items()) + " mm"


def test_residual_motion_over_16_phases(measured):
    """The nominal plant: a fifth of PD with rigid feedforward; PD with the flat feedforward leaves less."""
    found = {(law, 0.0): residual_motion(DRIVE, law, runs=16) for law in LAWS}
    measured(in_millimetres(found, "at_once", wind=False))
    worst = {law: one.at_once.max() for (law, _), one in found.items()}
    assert worst["scheduled"] < 0.2 * worst["pd"], f"observed {worst}"


def test_still_air_over_forty_draws(residuals, measured):
    """Worst of the scheduled law a fifth of every worst under PD with rigid feedforward, shaped or not."""
    worst = {law: found.at_once.max() for (law, gust), found in residuals.items() if gust == 0.0}
    measured(in_millimetres(residuals, "at_once", wind=False))
    assert worst["scheduled"] < 0.05 * worst["pd"], f"observed {worst}"
    assert worst["scheduled"] < 0.5 * worst["shaper"], f"observed {worst}"
    assert worst["scheduled"] < worst["pd-flat"], f"observed {worst}"


def test_after_a_gust_over_forty_draws(residuals, measured):
    later = {law: np.median(found.later) for (law, gust), found in residuals.items() if gust > 0.0}
    measured(f"at once {in_millimetres(residuals, 'at_once', wind=True)}")
    measured(f"two seconds later {in_millimetres(residuals, 'later', wind=True)}")
    assert later["scheduled"] < 0.1 * min(later["pd"], later["pd-flat"], later["shaper"]), f"observed {later}"


def test_stable_at_forty_places_with_ten_percent_of_the_cable(measured):
    for rigidity in (0.9, 0.95, 1.0, 1.05, 1.1):
        growth = along_the_way(DRIVE, rigidity=rigidity, laws=("scheduled",)).growth["scheduled"]
        measured(f"EA x {rigidity:g}: largest real part {growth.max():.3f} 1/s")
        assert growth.max() < 0.0, f"EA x {rigidity}: observed {growth.max():.3f} 1/s"
