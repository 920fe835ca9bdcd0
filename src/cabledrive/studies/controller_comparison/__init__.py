"""Controllers side by side on one drive: tuned by one procedure, run on the same disturbed plants."""

from cabledrive.studies.controller_comparison.comparison import Comparison, compare

__all__ = ["Comparison", "compare"]
