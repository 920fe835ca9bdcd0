"""From a drive file and logs to a controller with a verdict: the stages of a study, each kept when done."""

from cabledrive.studies.study.goals import Goals, load_goals
from cabledrive.studies.study.pipeline import StudyResult, run_study

__all__ = ["Goals", "StudyResult", "load_goals", "run_study"]
