"""Machines driven by flexible cables, belts and tendons: modes, resonance, identification, control."""

from typing import TYPE_CHECKING

from cabledrive.at_once import LISTENS as _LISTENS  # noqa: F401 (before all others, see there)
from cabledrive.parameters import (
    Cable,
    Carriage,
    Drive,
    Goal,
    InputRefused,
    Layout,
    Lumped,
    Machine,
    Motor,
    NotComputed,
    Pulley,
    Sensors,
    content_hash,
    drive_schema,
    load_drive,
    packaged_drives,
    save_drive,
)
from cabledrive.parameters.on_demand import on_demand
from cabledrive.parameters.version import __version__

if TYPE_CHECKING:
    from cabledrive.campaign import run_sweep
    from cabledrive.control import OwnController
    from cabledrive.export import export_to
    from cabledrive.identification.log_response import response
    from cabledrive.identification.logs.reading import read_log
    from cabledrive.identification.one_log import identify
    from cabledrive.identification.printer import shaper
    from cabledrive.mechanics import (
        CableLaw,
        DerivedQuantities,
        ExactLaw,
        LinearLaw,
        derived_quantities,
        drive_warnings,
    )
    from cabledrive.modal import Certificate, Mode, Modes, modes, natural_frequencies
    from cabledrive.reduction import LumpedChain
    from cabledrive.report import write_report
    from cabledrive.rig import OwnPlant, track
    from cabledrive.rig.experiment import experiment
    from cabledrive.simulation import simulate
    from cabledrive.studies import frequency_against
    from cabledrive.studies.controller_comparison import compare
    from cabledrive.studies.mode_map import map_modes
    from cabledrive.studies.resonance import resonance
    from cabledrive.studies.study import run_study

# Loaded when first asked for, with the libraries they need.
__getattr__ = on_demand(
    __name__,
    {
        "CableLaw": "mechanics",
        "Certificate": "modal",
        "DerivedQuantities": "mechanics",
        "ExactLaw": "mechanics",
        "LinearLaw": "mechanics",
        "LumpedChain": "reduction",
        "Mode": "modal",
        "Modes": "modal",
        "OwnController": "control",
        "OwnPlant": "rig",
        "compare": "studies.controller_comparison",
        "derived_quantities": "mechanics",
        "drive_warnings": "mechanics",
        "experiment": "rig.experiment",
        "export_to": "export",
        "frequency_against": "studies",
        "identify": "identification.one_log",
        "map_modes": "studies.mode_map",
        "mechanics": "mechanics",
        "modal": "modal",
        "modes": "modal",
        "natural_frequencies": "modal",
        "read_log": "identification.logs.reading",
        "resonance": "studies.resonance",
        "response": "identification.log_response",
        "run_study": "studies.study",
        "run_sweep": "campaign",
        "shaper": "identification.printer",
        "simulate": "simulation",
        "track": "rig",
        "write_report": "report",
    },
)

__all__ = [
    "Cable",
    "CableLaw",
    "Carriage",
    "Certificate",
    "DerivedQuantities",
    "Drive",
    "ExactLaw",
    "Goal",
    "InputRefused",
    "Layout",
    "LinearLaw",
    "Lumped",
    "LumpedChain",
    "Machine",
    "Mode",
    "Modes",
    "Motor",
    "NotComputed",
    "OwnController",
    "OwnPlant",
    "Pulley",
    "Sensors",
    "__version__",
    "compare",
    "content_hash",
    "derived_quantities",
    "drive_schema",
    "drive_warnings",
    "experiment",
    "export_to",
    "frequency_against",
    "identify",
    "load_drive",
    "map_modes",
    "modes",
    "natural_frequencies",
    "packaged_drives",
    "read_log",
    "resonance",
    "response",
    "run_study",
    "run_sweep",
    "save_drive",
    "shaper",
    "simulate",
    "track",
    "write_report",
]


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(__all__))
