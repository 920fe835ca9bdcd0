"""Natural modes of cable drives, every one of them, with proof."""

from typing import TYPE_CHECKING

from cabledrive.modal.mode import Certificate, Modes
from cabledrive.modal.motion import Mode
from cabledrive.modal.natural import longitudinal_modes, modes, natural_frequencies
from cabledrive.parameters.on_demand import on_demand

if TYPE_CHECKING:
    from cabledrive.modal.lowest import Comparison, against_lumped_springs, against_rigid_supports

__getattr__ = on_demand(
    __name__,
    {
        "Comparison": "lowest",
        "against_lumped_springs": "lowest",
        "against_rigid_supports": "lowest",
    },
)

__all__ = [
    "Certificate",
    "Comparison",
    "Mode",
    "Modes",
    "against_lumped_springs",
    "against_rigid_supports",
    "longitudinal_modes",
    "modes",
    "natural_frequencies",
]
