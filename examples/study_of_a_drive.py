"""The drawing says 0.0026 kg m^2, the rig has 0.00235: does a log put it right, and will the drive follow?

The study takes the data sheet and a log of twelve seconds, finds the load within half a per cent, designs a
law with a bound, and tests it on plants drawn from what it knows. The same motion in a third of the time is
refused: torque is what no law can mend.
"""

from dataclasses import replace
from math import pi
from pathlib import Path

import cabledrive as cd
from cabledrive.app.results import log_csv
from cabledrive.rig.experiment import Excitation, experiment
from cabledrive.studies.study import Goals, run_study

machine = cd.load_drive("dissertation-3", overrides=["sensors.sample_rate=1 kHz"])
shake = Excitation(kind="multisine", duration=12.0, amplitude=0.5, band=(0.25, 10.0), period=4.0)
Path("log.csv").write_text(log_csv(experiment(machine, shake, seed=1)))

drawing = replace(machine, pulley=(machine.pulley[0], replace(machine.pulley[1], inertia=0.0026)))
goals = Goals(error=0.3 * pi / 180, angle=pi / 4, duration=0.5, dwell=0.1, draws=300, cable_draws=0)
found = run_study(drawing, [Path("log.csv")], goals)
load = found.knowledge.quantities["load_inertia"]
print(f"load {load.value:.6f} kg m^2, {load.low:.6f} to {load.high:.6f}")
print(found.verdict.answer, "-", found.verdict.reasons[0])

hasty = run_study(drawing, [Path("log.csv")], replace(goals, duration=0.1))
print(hasty.verdict.answer, "-", hasty.verdict.reasons[0])

assert abs(load.value / 0.00235 - 1.0) < 0.005, load  # Table 4.2
assert (found.verdict.answer, hasty.verdict.answer) == ("yes", "no")
