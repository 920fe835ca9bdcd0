"""Natural modes of cable drives, every one of them, with proof."""

from cabledrive.modal.mode import Certificate, Modes
from cabledrive.modal.motion import Mode
from cabledrive.modal.natural import modes, natural_frequencies

__all__ = ["Certificate", "Mode", "Modes", "modes", "natural_frequencies"]
