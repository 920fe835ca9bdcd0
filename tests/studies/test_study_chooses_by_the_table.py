"""A study tries every law that a comparison offers, and chooses what the comparison's order ranks first."""

from dataclasses import replace

import numpy as np
import pytest

from cabledrive.parameters import load_drive
from cabledrive.rig.closed_loop.chain_kernels import SUMMARY
from cabledrive.rig.closed_loop.loop import run
from cabledrive.rig.laws.load_learning import KINDS, SCHEDULED
from cabledrive.rig.plant_samples import Disturbances, Draws
from cabledrive.rig.trial import offered
from cabledrive.studies.study import plants as law_settings
from cabledrive.studies.study import run_study
from cabledrive.studies.study.plants import FIXED, load_case, tuned_laws
from cabledrive.studies.study.sampled_plants import sampled_plant, with_values
from cabledrive.studies.study.stage_cache import StageCache
from study_drives import drive_of, goals

DRIVE = drive_of("turntable")


def test_a_study_tries_every_law_that_a_comparison_offers():
    """Of one pulse, and of a load that changes; the law of the chain is the study's own entry.

    The law that goes by an announced load has nothing to go by: the plants of a study keep theirs.
    """
    names = offered(DRIVE, Disturbances(load_factor=(0.5, 3.0)))
    assert {name for name in names if not name.startswith("darc")} <= {*FIXED, *KINDS, SCHEDULED}


def on_the_plants_of(found, setting, draws):
    """Scores of a law on the plants of a study's acceptance, by the comparison's measure."""
    known = found.knowledge
    case = load_case(found.known, found.goals, known)
    loop = case.loop(case.law(setting))
    runs = []
    for draw in range(draws):
        values, phases = sampled_plant(
            known.quantities, len(loop.rig.phases), found.goals.seed, draw, known.correlations
        )
        done = run(with_values(loop, values, phases), log=False)
        peak = done.state.summary[SUMMARY.index("peak")] / loop.gear + values.get("eccentricity", 0.0)
        runs.append((float(peak), bool(done.failed)))
    peaks, failed = zip(*runs, strict=True)
    names = ("first_peak", "later_peak", "peak_torque", "saturated", "loose")
    return Draws(peak=peaks, failed=failed, **dict.fromkeys(names, (0.0,) * draws))


def choice_and_table(drive, asked, folder):
    """What a study without an error goal chooses, and the rank of every law on the same plants."""
    found = run_study(drive, [], asked, folder=folder)
    known = replace(found.known, name="", title="", source="")
    kept = StageCache(folder=folder, note=lambda line: None)  # the settings of the study itself
    case = load_case(known, asked, found.knowledge)
    tuned = kept.staged("laws", tuned_laws, case, found.controller, every_law=False)
    table = {
        one.controller: on_the_plants_of(found, one, asked.draws).rank(np.inf)
        for one in tuned
        if one.bandwidth is not None
    }
    return found.laws.chosen.controller, table


@pytest.mark.verify
def test_the_choice_of_a_study_is_the_first_of_the_table_on_the_same_plants(tmp_path, monkeypatch, measured):
    """Of five laws."""
    monkeypatch.setattr(law_settings, "FIXED", ("pd", "lqi", "pid"))
    monkeypatch.setattr(law_settings, "KINDS", ("lqi-learning",))
    chosen, table = choice_and_table(DRIVE, goals(30, 0.3, draws=10), tmp_path)
    measured(", ".join(f"{name} {np.degrees(error):.3f}" for name, (_, error) in table.items()))
    assert chosen == min(table, key=lambda name: table[name]), f"{chosen}, {table}"


@pytest.mark.verify
def test_the_choice_is_the_first_of_the_table_over_100_plants_with_a_flexible_joint(tmp_path, measured):
    chosen, table = choice_and_table(load_drive("dissertation-3"), goals(45, 0.5, draws=100), tmp_path)
    measured(", ".join(f"{name} {np.degrees(error):.3f}" for name, (_, error) in table.items()))
    assert chosen == min(table, key=lambda name: table[name]), f"{chosen}, {table}"
