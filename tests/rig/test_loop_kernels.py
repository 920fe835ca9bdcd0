"""Parts of the loop that few runs enter: an eccentric encoder."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.rig import Motion, RigOptions
from cabledrive.rig.closed_loop.chain_kernels import see_chain
from cabledrive.rig.closed_loop.loop import close_loop, loop_at_rest
from cabledrive.rig.closed_loop.loop_numbers import DIVERGED, WENT_SLACK
from cabledrive.rig.laws.given import own_law
from cabledrive.rig.trial import spec_for

pytestmark = pytest.mark.kernel
SHORT = Motion(angle=0.05, rise=0.02, dwell=0.002)


def test_an_eccentric_encoder_shows_the_load_off_by_its_sine():
    drive = cd.load_drive("dissertation-3")
    controller = own_law(cd.OwnController(step=max, initial_state=np.zeros(3)), spec_for(drive, SHORT))
    loop = close_loop(drive, drive, controller, SHORT, RigOptions(), np.random.default_rng(1))
    state = loop_at_rest(loop)
    state.x[:] = 0.1 * np.arange(1.0, state.x.size + 1.0)
    eccentric = loop.plant._replace(eccentricity=2e-3, turning=2.0, phases=np.array([0.0, 0.0, 0.4]))
    see_chain(loop.plant, 10.0, state)
    np.testing.assert_array_equal(state.work[: state.x.size], state.x)
    assert see_chain(eccentric, 10.0, state) == 0
    off = state.work[: state.x.size] - state.x
    assert off[2] == pytest.approx(2e-3 * np.sin(2.0 * 0.3 + 0.4), rel=1e-12)
    assert np.count_nonzero(off) == 1
    assert see_chain(loop.plant, 0.2, state) == DIVERGED
    assert see_chain(loop.plant._replace(twist_limit=0.05), 10.0, state) == WENT_SLACK
