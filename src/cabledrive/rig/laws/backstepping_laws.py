"""Backstepping of six states, ready for a drive with a flexible motor joint."""

from cabledrive.control.backstepping import chain_generator, chain_numbers, chain_reference
from cabledrive.control.backstepping_recursion import gain_names
from cabledrive.control.observers import QUIET
from cabledrive.rig.laws.controllers import Controller, DesignSpec
from cabledrive.rig.laws.fitting import law_shafts

SIX_HZ = 25.0
ADAPTATION = 1e-18


def backstepping_6(spec: DesignSpec) -> Controller:
    """Backstepping with unmatched uncertainty on Model 4, dampers and friction along the reference."""
    chain = spec.model(4)
    hertz = SIX_HZ if spec.bandwidth is None else spec.bandwidth
    adaptation = ADAPTATION if spec.adapt else 0.0
    law = chain_numbers(chain, hertz, adaptation, spec.interval)
    gains = gain_names(law.matrix, law.rows[0])
    return Controller(
        name="backstepping-6",
        law=law,
        reference=chain_reference(chain, spec.wanted(6), spec.interval),
        shafts=law_shafts(4, spec.feedback),
        start=law.learning[0],
        tuning=QUIET,
        gains={"bandwidth_hz": hertz, "adaptation": adaptation} | gains,
        model=4,
        damped=True,
        generator=chain_generator(chain, spec.interval),
    )
