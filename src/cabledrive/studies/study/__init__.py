"""From a drive file and logs to a controller with a verdict: the stages of a study, each kept when done."""

from cabledrive.studies.study.goals import Goals, load_goals
from cabledrive.studies.study.pipeline import run_study
from cabledrive.studies.study.result import StudyResult

__all__ = ["Goals", "StudyResult", "load_goals", "run_study"]
