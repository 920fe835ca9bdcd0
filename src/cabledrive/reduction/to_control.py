"""Exchange with python-control, where it is installed."""

from typing import Any

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, state_space


def to_control(chain: LumpedChain) -> Any:
    """A row of inertias as a state-space object of python-control.

    Parameters
    ----------
    chain : LumpedChain

    Returns
    -------
    control.StateSpace
        Torque on the first inertia in, angles of all inertias out.

    Raises
    ------
    InputRefused
        If python-control is not installed.
    """
    try:
        import control
    except ImportError:
        raise InputRefused(
            "to_control needs python-control: install cabledrive with its extra [control]"
        ) from None
    a, b = state_space(chain)
    n = chain.size
    return control.ss(a, b[:, :1], np.eye(n, 2 * n), np.zeros((n, 1)))
