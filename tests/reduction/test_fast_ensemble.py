"""Many runs of the fast model at once are the runs one by one."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.parameters import InputRefused
from cabledrive.reduction.fast_members import fast_ensemble
from cabledrive.reduction.fast_simulation import FastScheme, simulate_fast
from cabledrive.simulation import Pluck, Recording, Setting, Sine, Start

DRIVE = cd.load_drive("dissertation-2", overrides=["cable.transverse_damping=2"])
SCHEME = FastScheme(sines=3, step=2e-4)
COMMON = Setting(torque_frequency=81.6, pluck_upper=1e-3, pluck_lower=-5e-4)


def test_members_are_single_runs(measured):
    axes = {"torque_amplitude": [0.0, 0.01], "pretension": [3.2, 3.3, 4.0]}
    found = fast_ensemble(DRIVE, 0.1, axes, common=COMMON, pluck_shape="triangle", scheme=SCHEME, rate=1000.0)
    assert found.load_angle.dims == ("torque_amplitude", "pretension", "time")
    worst = 0.0
    plucks = tuple(Pluck(height=h, span=s, shape="triangle") for s, h in (("upper", 1e-3), ("lower", -5e-4)))
    for amplitude in axes["torque_amplitude"]:
        for pretension in axes["pretension"]:
            single = simulate_fast(
                cd.load_drive(
                    "dissertation-2",
                    overrides=["cable.transverse_damping=2", f"cable.pretension={pretension}"],
                ),
                0.1,
                torque=Sine(amplitude=amplitude, frequency=81.6),
                start=Start(plucks=plucks),
                scheme=SCHEME,
                recording=Recording(rate=1000.0),
            )
            member = found.sel(torque_amplitude=amplitude, pretension=pretension)
            for name, expected in (
                ("load_angle", single.load_angle),
                ("drive_angle", single.drive_angle),
                ("upper_midpoint", single.midpoint("upper")[:, 2]),
                ("lower_midpoint", single.midpoint("lower")[:, 2]),
            ):
                scale = np.max(np.abs(single.load_angle)) + np.max(np.abs(expected))
                worst = max(worst, float(np.max(np.abs(member[name] - expected)) / scale))
                np.testing.assert_allclose(member[name], expected, atol=1e-9 * scale, err_msg=name)
    measured(f"members within {worst:.1e} of single runs, relative to the largest motion")


def test_threads_do_not_matter():
    axes = {"pretension": np.linspace(3.0, 5.0, 5), "torque_amplitude": [0.01, 0.02]}
    one, two = (fast_ensemble(DRIVE, 0.05, axes, common=COMMON, threads=n) for n in (1, 2))
    assert one.identical(two)


def test_members_for_which_the_model_does_not_hold_say_so_and_show_no_motion():
    found = fast_ensemble(
        DRIVE, 0.2, {"torque_amplitude": [0.01, 1.0], "pluck_upper": [1e-3, 3e-2]}, common=COMMON
    )
    reasons = found.stopped.values
    assert reasons[0, 0] == ""
    assert "slack" in reasons[1, 0], reasons
    assert "slope" in reasons[0, 1] or "slack" in reasons[0, 1]
    assert np.isfinite(found.load_angle[0, 0]).all()
    assert np.isnan(found.load_angle.values[reasons != ""]).all()
    assert found.least_tension_upper[1, 0] < 0.0


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ({"pretention": [1.0]}, "did you mean"),
        ({"torque_frequency": [80.0, 900.0]}, "where the fast model ends"),
        ({"pretension": [np.nan]}, "finite values in N"),
    ],
)
def test_what_makes_no_sense_is_refused(axes, words):
    with pytest.raises(InputRefused, match=words):
        fast_ensemble(DRIVE, 0.05, axes, common=Setting(torque_amplitude=0.01))
