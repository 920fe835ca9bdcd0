"""Models of few equations that keep what matters, and what they neglect.

Which lumped chain has the lowest modes of the machine, how does a pulley's vibration excite a string at half
its frequency, and how fast can a cable be simulated? Begin with `lumped_model` and `simulate_fast`.
"""

from typing import TYPE_CHECKING

from cabledrive.parameters.on_demand import on_demand

if TYPE_CHECKING:
    from cabledrive.reduction.decay import damping_from_decay
    from cabledrive.reduction.fast_members import fast_ensemble
    from cabledrive.reduction.fast_simulation import simulate_fast
    from cabledrive.reduction.lumped_chain import LumpedChain, lumped_model

__getattr__ = on_demand(
    __name__,
    {
        "LumpedChain": "lumped_chain",
        "damping_from_decay": "decay",
        "fast_ensemble": "fast_members",
        "lumped_model": "lumped_chain",
        "simulate_fast": "fast_simulation",
    },
)

__all__ = ["LumpedChain", "damping_from_decay", "fast_ensemble", "lumped_model", "simulate_fast"]
