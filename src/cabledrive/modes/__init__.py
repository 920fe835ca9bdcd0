"""Natural modes of cable drives, every one of them, with proof."""

from cabledrive.modes.mode import Mode
from cabledrive.modes.natural import Certificate, Modes, longitudinal_modes, modes, natural_frequencies

__all__ = ["Certificate", "Mode", "Modes", "longitudinal_modes", "modes", "natural_frequencies"]
