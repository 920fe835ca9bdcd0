"""What has another name in 0.2 than in 0.1: the old name warns and gives the new, for one version."""

import importlib
import sys
from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
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
    "cabledrive.mechanics.expanded_equations": "cabledrive.dissertation.expanded_equations",
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
RENAMED = {  # module at its present path: old name of a function or class, and its present one
    "cabledrive": {"practitioner_warnings": "drive_warnings"},
    "cabledrive.mechanics": {"practitioner_warnings": "drive_warnings"},
    "cabledrive.mechanics.warnings": {"practitioner_warnings": "drive_warnings"},
    "cabledrive.identification.innovations": {"Foreseen": "Prediction", "foreseen": "predicted_angles"},
    "cabledrive.identification.loop_check": {"free_plays": "backlash_widths"},
    "cabledrive.identification.axis_problem": {
        "identify_posed_axis": "solve_axis_problem",
        "posed_rows": "problem_rows",
    },
    "cabledrive.identification.chain_model": {"RowModel": "ChainModel", "Sought": "FreeParameter"},
    "cabledrive.identification.reference_logs": {"sound_tracks": "reference_tracks"},
    "cabledrive.identification.regression_result": {"concluded": "regression_result"},
    "cabledrive.identification.tension.prepared_recording": {
        "Heard": "PreparedRecording",
        "heard_in": "prepared_recording",
    },
    "cabledrive.reduction.axis_kernels": {"march_axis": "integrate_axis"},
    "cabledrive.reduction.ensemble_kernels": {
        "march_averaged": "integrate_averaged",
        "march_oscillators": "integrate_oscillators",
    },
    "cabledrive.reduction.friction_integration": {
        "march_chain": "integrate_chain",
        "march_rigid_axis": "integrate_rigid_axis",
    },
    "cabledrive.reduction.oscillators": {"march_oscillators_reference": "integrate_oscillators_reference"},
    "cabledrive.reduction.threshold": {"tongue_half_width": "instability_half_width"},
    "cabledrive.reduction.uniform_tension_kernels": {"march_kernel": "integration_kernel"},
    "cabledrive.rig.disturbances": {"blind_encoder": "encoder_dropout"},
    "cabledrive.rig.error_budget": {"Cause": "ErrorSource", "causes": "error_sources"},
    "cabledrive.rig.laws.controllers": {"Wish": "DesignSpec"},
    "cabledrive.rig.learning_samples": {
        "LearningDraws": "LearningSamples",
        "run_learning_draws": "run_learning_samples",
    },
    "cabledrive.rig.parsed_options": {
        "spoken_blindness": "parse_encoder_dropout",
        "spoken_disturbance": "parse_disturbance",
    },
    "cabledrive.rig.plant_samples": {
        "Draws": "PlantSamples",
        "drawn_chain": "sampled_chain",
        "drawn_loops": "sampled_loops",
        "run_draws": "run_samples",
    },
    "cabledrive.rig.tracking": {"told": "summarize"},
    "cabledrive.rig.run_facts": {"circumstance_words": "disturbance_facts"},
    "cabledrive.rig.trial": {"wish_for": "spec_for", "track": "track_pulses"},
    "cabledrive.studies.crossings": {"Meeting": "Crossing", "meetings": "crossings"},
    "cabledrive.studies.resonance": {"resonance_summary": "resonance"},
    "cabledrive.studies.resonance_detuning": {
        "Standing": "InstabilityMargin",
        "standing_of": "instability_margin",
    },
    "cabledrive.studies.study.acceptance_stage": {"DrawBlock": "SampleBlock"},
    "cabledrive.studies.study.chain_regression": {"Told": "RegressionResult", "tell": "identify_chain"},
    "cabledrive.studies.study.sampled_plants": {
        "drawn_plant": "sampled_plant",
        "drawn_values": "sampled_values",
    },
    "cabledrive.studies.study.spring_regression": {"tell_joint": "identify_joint"},
    "cabledrive.studies.transporter_moves": {"drawn_transporter": "sampled_transporter"},
}


class _Moved(ModuleType):
    """A module whose path is also the name of a public function: a call still goes to the function."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return self._function(*arguments, **options)


class _OldNames(MetaPathFinder, Loader):
    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if new_name(name) is not None:
            return ModuleSpec(name, self, is_package=True)
        found = PathFinder.find_spec(name, path, target) if name in RENAMED else None
        if found is not None and isinstance(found.loader, SourceFileLoader):
            found.loader = _WithOldNames(name, found.loader.path)
        return found

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None

    def exec_module(self, module: ModuleType) -> None:
        old = module.__name__
        new = new_name(old)
        assert new is not None
        _warn(old, new)
        found = importlib.import_module(new)
        parent, _, leaf = old.rpartition(".")
        function = getattr(sys.modules[parent], leaf, None)
        if callable(function):  # the import system is about to put the module in its place
            shim = _Moved(old, found.__doc__)
            vars(shim).update({**vars(found), "__name__": old, "_function": staticmethod(function)})
            found = shim
        sys.modules[old] = found


class _WithOldNames(SourceFileLoader):
    """Loads a module as ever, then lets it answer to the former names of its functions and classes."""

    def exec_module(self, module: ModuleType) -> None:
        super().exec_module(module)
        vars(module)["__getattr__"] = by_old_name(module.__name__, vars(module).get("__getattr__"))


def by_old_name(room: str, otherwise: Callable[[str], Any] | None = None) -> Callable[[str], Any]:
    """What a module looks names up with that it does not hold: by the former name, else as it did before."""
    names = RENAMED[room]

    def find(old: str) -> Any:
        if old in names:
            _warn(f"{room}.{old}", f"{room}.{names[old]}")
            return getattr(sys.modules[room], names[old])
        if otherwise is None:
            raise AttributeError(f"module {room!r} has no attribute {old!r}")
        return otherwise(old)

    return find


def _warn(old: str, new: str) -> None:
    warn(f"{old} is now {new}; the old name goes with version 0.3", DeprecationWarning, stacklevel=3)


def new_name(old: str) -> str | None:
    """Where a module is now; None for a path that was never moved."""
    for start, new in MOVED.items():
        if old == start or old.startswith(f"{start}."):
            return new + old.removeprefix(start)
    return None


def keep_old_names() -> None:
    """Let imports of old paths and names find what they mean; ahead of the finder that knows files alone."""
    sys.meta_path.insert(0, _OldNames())
    for room in RENAMED.keys() & sys.modules.keys():  # loaded before there was this finder
        names = vars(sys.modules[room])
        names["__getattr__"] = by_old_name(room, names.get("__getattr__"))
