"""Modules that moved in 0.2: the old path warns and gives the module at its new one, for one version."""

import importlib
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any
from warnings import warn

MOVED = {
    "cabledrive.reduction.fast_ensemble": "cabledrive.reduction.fast_members",
    "cabledrive.reduction.to_control": "cabledrive.reduction.python_control",
    "cabledrive.studies.beats": "cabledrive.studies.envelopes",
    "cabledrive.identification.published_recipe": "cabledrive.identification.recipe",
    "cabledrive.identification.conclusion": "cabledrive.identification.regression_result",
    "cabledrive.identification.posed_axis": "cabledrive.identification.axis_problem",
    "cabledrive.identification.row_model": "cabledrive.identification.chain_model",
    "cabledrive.identification.sound_logs": "cabledrive.identification.reference_logs",
    "cabledrive.identification.tension.heard": "cabledrive.identification.tension.prepared_recording",
    "cabledrive.identification.tension.telling_apart": "cabledrive.identification.tension.span_assignment",
    "cabledrive.reduction.friction_march": "cabledrive.reduction.friction_integration",
    "cabledrive.reduction.row_motion_kernels": "cabledrive.reduction.chain_motion_kernels",
    "cabledrive.reduction.uniform_tension_march": "cabledrive.reduction.uniform_tension_integration",
    "cabledrive.rig.causes": "cabledrive.rig.error_budget",
    "cabledrive.rig.circumstances": "cabledrive.rig.disturbances",
    "cabledrive.rig.draws": "cabledrive.rig.plant_samples",
    "cabledrive.rig.learning_draws": "cabledrive.rig.learning_samples",
    "cabledrive.rig.spoken_options": "cabledrive.rig.parsed_options",
    "cabledrive.rig.two_laws": "cabledrive.rig.law_change",
    "cabledrive.studies.meetings": "cabledrive.studies.crossings",
    "cabledrive.studies.resonance_referee": "cabledrive.studies.resonance_validation",
    "cabledrive.studies.resonance_standing": "cabledrive.studies.resonance_detuning",
    "cabledrive.studies.study.drawn_plants": "cabledrive.studies.study.sampled_plants",
    "cabledrive.studies.reproduction": "cabledrive.dissertation",
    "cabledrive.modes": "cabledrive.modal",
    "cabledrive.mechanics.dynamic_stiffness": "cabledrive.mechanics.stiffness_matrix",
    "cabledrive.parameters.content_hash": "cabledrive.parameters.hashing",
    "cabledrive.identification.camera.marker_log": "cabledrive.identification.camera.marker_table",
    "cabledrive.identification.identify": "cabledrive.identification.one_log",
    "cabledrive.simulation.simulate": "cabledrive.simulation.one_run",
    "cabledrive.studies.frequency_against": "cabledrive.studies.frequency_curves",
    "cabledrive.studies.modal_determinant": "cabledrive.studies.determinant",
    "cabledrive.studies.mode_shapes": "cabledrive.studies.shapes",
    "cabledrive.studies.table_3_2": "cabledrive.studies.carriage_table",
    "cabledrive.trajectories.smooth_rise": "cabledrive.trajectories.rise",
    "cabledrive.trajectories.waypoints": "cabledrive.trajectories.segments",
}


class _Moved(ModuleType):
    """A module whose path is also the name of a public function: a call still goes to the function."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return self._function(*arguments, **options)


class _OldNames(MetaPathFinder, Loader):
    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(name, self, is_package=True) if new_name(name) is not None else None

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        old = module.__name__
        new = new_name(old)
        assert new is not None
        warn(f"{old} is now {new}; the old path goes with version 0.3", DeprecationWarning, stacklevel=2)
        found = importlib.import_module(new)
        parent, _, leaf = old.rpartition(".")
        function = getattr(sys.modules[parent], leaf, None)
        if callable(function):  # the import system is about to put the module in its place
            shim = _Moved(old, found.__doc__)
            vars(shim).update({**vars(found), "__name__": old, "_function": staticmethod(function)})
            found = shim
        sys.modules[old] = found


def new_name(old: str) -> str | None:
    """Where a module is now; None for a path that was never moved."""
    for start, new in MOVED.items():
        if old == start or old.startswith(f"{start}."):
            return new + old.removeprefix(start)
    return None


def keep_old_names() -> None:
    """Let imports of old paths find the modules."""
    sys.meta_path.append(_OldNames())
