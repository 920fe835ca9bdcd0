"""One quantity of a drive against another, as labelled arrays with units; resonance; the study of one drive.

How do frequencies change with pretension or position, does a planned motion excite the transverse modes, does
the machine reach its goal? Begin with `frequency_against` and `cabledrive.studies.study.run_study`.
"""

from cabledrive.studies.following import frequency_against
from cabledrive.studies.planned_motion import read_motion

__all__ = ["frequency_against", "read_motion"]
