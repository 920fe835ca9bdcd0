"""Exchange with python-control, where it is installed: the extra ``control`` of this package."""

from typing import Any

import numpy as np

from cabledrive.parameters import InputRefused
from cabledrive.reduction.lumped_chain import LumpedChain, speed_transfer_function, state_space


def to_control(chain: LumpedChain) -> Any:
    """A lumped chain as a state-space object of python-control.

    Parameters
    ----------
    chain : LumpedChain

    Returns
    -------
    control.StateSpace
        Torque on the first inertia in, angles of all inertias out; both and the states with their names.

    Raises
    ------
    InputRefused
        If python-control is not installed.
    """
    a, b = state_space(chain)
    n = chain.size
    angles = [f"{name}_angle" for name in chain.names]
    return _control().ss(
        a,
        b[:, :1],
        np.eye(n, 2 * n),
        np.zeros((n, 1)),
        inputs=["torque"],
        outputs=angles,
        states=[*(f"{name}.state" for name in angles), *(f"{name}_speed" for name in chain.names)],
    )


def speed_to_control(chain: LumpedChain, torque_on: int = 0, speed_of: int = 0) -> Any:
    """A transfer function from torque to speed as an object of python-control.

    Parameters
    ----------
    chain : LumpedChain
    torque_on, speed_of : int, default 0
        Numbers of the inertias, from the motor.

    Returns
    -------
    control.TransferFunction

    Raises
    ------
    InputRefused
        If python-control is not installed.
    """
    return _control().tf(*speed_transfer_function(chain, torque_on, speed_of))


def _control() -> Any:
    try:
        import control
    except ImportError:
        raise InputRefused(
            "to_control needs python-control: install cabledrive with its extra [control]"
        ) from None
    return control
