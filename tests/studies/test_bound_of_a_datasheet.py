"""The stated bound where all that is known is the data sheet: springs and load off by a tenth and more."""

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.reduction.quality import model_quality
from cabledrive.rig.setting import Motion
from cabledrive.studies.study.acceptance_stage import accept
from cabledrive.studies.study.controller_stage import LawSetting, design_controller
from cabledrive.studies.study.goals import SPREADS
from cabledrive.studies.study.knowledge_stage import know
from cabledrive.studies.study.plants import load_loop
from cabledrive.studies.study.stage_cache import StageCache

DRIVE = load_drive("dissertation-3")


@pytest.mark.parametrize("draws", [40, pytest.param(1000, marks=pytest.mark.verify)])
def test_no_plant_within_the_datasheet_leaves_the_bound(draws, measured):
    """Of the law that the bound is stated for, on plants without backlash."""
    known = know(DRIVE, [], SPREADS, backlash=0.0)
    motion = Motion()
    holds = {one.model: one.holds_5 for one in model_quality(DRIVE) if one.model in (3, 4)}
    control = design_controller(DRIVE, motion, known.quantities, holds, None)
    law = LawSetting(controller=control.name, model=control.model, value=control.bandwidth)
    runs = accept(
        load_loop(DRIVE, motion, known, law, None, cable=False),
        known,
        plant="lumped",
        law=law.controller,
        draws=draws,
        seed=7,
        cache=StageCache(folder=None, note=lambda line: None),
        bound=control.bound,
    )
    worst, bound = np.degrees(runs.peaks[-1]), np.degrees(control.bound)
    measured(f"bound {bound:.3f} deg, worst {worst:.3f} deg; {100 * runs.inside:.1f} % within")
    assert runs.inside == 1.0
    assert bound < 3.0 * worst
