"""The damping-aware law on rows of three, four and five inertias."""

import numpy as np
import pytest

from cabledrive.control.kalman import KalmanTuning
from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, natural_frequencies_of
from cabledrive.rig.closed_loop.chain_loop import ChainRig, chain_loop, share_bounds
from cabledrive.rig.closed_loop.loop import Loop, run
from cabledrive.trajectories import pulse

INTERVAL, COUNT = 2e-4, 2.0 * np.pi / 40_000
MOTION = pulse(np.pi / 4.0, 0.5, 0.3, order=13)
TUNING = KalmanTuning(torque=1e-6, disturbance=1e-2, load_acceleration=0.1)


def arm() -> LumpedChain:
    """Three-inertia model of an industrial robot's arm: E. Wernholt and S. Gunnarsson, motor side."""
    whole, motor, gear = 0.03291699877416, 0.17910964111956, 0.61206166914114
    return LumpedChain(
        names=("motor", "gear", "arm"),
        inertias=(whole * motor, whole * gear, whole * (1.0 - motor - gear)),
        viscous=(0.00986346744839, 0.0, 0.0),
        coulomb=(0.74302635727901, 0.0, 0.0),
        offsets=(0.0, 0.0, 0.0),
        stiffness=(20.59269827430799, 20.23072060978318),
        damping=(0.06241814047290, 0.00987527995798),
        ratios=((1.0, 1.0), (1.0, 1.0)),
    )


def row(n: int) -> LumpedChain:
    """A motor, light pulleys and a heavy load behind ever softer cables."""
    return LumpedChain(
        names=tuple(f"shaft {i + 1}" for i in range(n)),
        inertias=(1.1e-3, *(6e-4,) * (n - 2), 2.3e-3),
        viscous=(3e-3, *(0.0,) * (n - 1)),
        coulomb=(0.04, *(0.0,) * (n - 1)),
        offsets=(0.0,) * n,
        stiffness=tuple(np.linspace(60.0, 8.0, n - 1)),
        damping=tuple(np.linspace(0.05, 0.03, n - 1)),
        ratios=((1.0, 1.0),) * (n - 1),
    )


def peak(loop: Loop) -> float:
    done = run(loop)
    assert done.ended == len(loop.target)
    return float(np.degrees(np.abs(done.log[:, loop.chain.size - 1] - loop.target).max()))


@pytest.mark.parametrize("chain", [arm(), row(4), row(5)], ids=["arm", "four", "five"])
def test_smooth_friction_and_true_states_leave_a_ten_thousandth_of_a_degree(chain, measured):
    """35 Hz, above every row's lowest mode; what is left is friction's turn within tanh(50 w)."""
    found = peak(chain_loop(chain, MOTION, ChainRig(interval=INTERVAL), 35.0, smooth_friction=True))
    measured(f"{found:.1e} deg")
    assert found < 2e-4, f"observed {found:.1e} deg"


@pytest.mark.parametrize(
    "chain, hertz", [(arm(), 20.0), (row(4), 35.0), (row(5), 35.0)], ids=["arm", "four", "five"]
)
def test_two_encoders_and_stick_slip_leave_two_counts(chain, hertz, measured):
    """Motor and load encoders of 0.009 deg a count, zeros off by a third of one; the rest is observed."""
    rig = ChainRig(interval=INTERVAL, encoders=(0, chain.size - 1), counts=(COUNT, COUNT), phases=(0.3, -0.2))
    found = peak(chain_loop(chain, MOTION, rig, hertz, tuning=TUNING))
    measured(f"{found:.4f} deg, {found / np.degrees(COUNT):.2f} counts")
    assert found < 2.0 * np.degrees(COUNT), f"observed {found:.4f} deg"


def test_leaving_the_dampers_out_costs_most_of_the_accuracy():
    """A design that believes in a tenth of the damping, on the row as it is."""
    chain = row(4)
    believed = LumpedChain(
        **{f: getattr(chain, f) for f in chain.__slots__} | {"damping": tuple(0.1 * b for b in chain.damping)}
    )
    rig = ChainRig(interval=INTERVAL)
    right = peak(chain_loop(chain, MOTION, rig, 35.0, smooth_friction=True))
    wrong = peak(chain_loop(chain, MOTION, rig, 35.0, design=believed, smooth_friction=True))
    assert wrong > 20.0 * right, f"observed {wrong:.4f}, {right:.5f} deg"


def test_a_bandwidth_below_the_rows_own_modes_cannot_hold_its_friction():
    """The loop's stiffness falls with the (2n - 1)-th power of the bandwidth: 10 Hz is lost on five."""
    chain = row(5)
    assert natural_frequencies_of(chain)[0] / (2.0 * np.pi) > 10.0
    low, high = (peak(chain_loop(chain, MOTION, ChainRig(interval=INTERVAL), f)) for f in (10.0, 20.0))
    assert low > 1.0 > 0.2 > high, f"observed {low:.3f}, {high:.3f} deg"


def test_rows_and_bounds_that_cannot_be_are_refused():
    bounds = share_bounds(arm(), 0.1)
    assert np.all((bounds.low < bounds.nominal) & (bounds.nominal < bounds.high))
    with pytest.raises(InputRefused, match="as many of each"):
        chain_loop(arm(), MOTION, ChainRig(interval=INTERVAL, encoders=(0, 2), counts=(COUNT,)), 20.0)
    rig = ChainRig(interval=INTERVAL, encoders=(0, 1), counts=(COUNT, COUNT), phases=(0.0, 0.0))
    with pytest.raises(InputRefused, match="let it read the load"):
        chain_loop(arm(), MOTION, rig, 20.0)
