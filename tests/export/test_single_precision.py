"""A controller in single precision: other coordinates, the same closed loop, or a refusal."""

import numpy as np
import pytest

import cabledrive as cd
from cabledrive.export.c99 import controller_package
from cabledrive.export.door import write_folder
from cabledrive.export.self_test import commands_of, references_of, rippled_readings
from cabledrive.export.single_precision import (
    MARGIN,
    SinglePrecision,
    differenced,
    self_test_gap,
    single_precision,
)
from export.compilers import COMPILERS, WARNINGS, checked
from export.designs import source_of


@pytest.mark.parametrize("name", ["darc-3", "darc-4-damped", "pid"])
def test_differences_of_angles_are_the_same_controller(name):
    """In double precision nothing but rounding changes."""
    law = source_of(name).law
    other = differenced(law)
    readings = rippled_readings(law, 150, np.random.default_rng(1))
    one, _ = commands_of(law, readings, references_of(law, 150))
    two, _ = commands_of(other, readings, references_of(other, 150))
    gap = np.abs(one - two).max() / np.abs(one).max()
    assert gap < 1e-7, f"observed {gap:.1e}"
    assert np.abs(one).max() > 0.01


@pytest.mark.parametrize("compiler", COMPILERS)
def test_single_precision_in_c_is_within_the_tolerance_of_its_self_test(compiler, tmp_path):
    source = source_of("pd")
    law = differenced(source.law)
    made = SinglePrecision(law=law, factor=1.0, tolerance=MARGIN * self_test_gap(law)[0])
    files = controller_package(source, made)
    assert "typedef float real;" in files["cabledrive_law.h"]
    write_folder(tmp_path / "law", files)
    done = checked(tmp_path / "law", "-O2", *WARNINGS, "-Wdouble-promotion", compiler=compiler)
    assert done.returncode == 0, done.stdout
    assert "difference 0 N m" not in done.stdout  # single it is


@pytest.mark.verify
@pytest.mark.parametrize("name", ["darc-3", "darc-4", "darc-4-damped", "pd", "lqg"])
def test_the_closed_loop_keeps_its_error_in_single_precision(name, measured):
    found = single_precision(source_of(name))
    measured(f"{name}: factor {found.factor:.4f}, self-test {found.tolerance:.1e} N m")
    assert 0.5 < found.factor < 1.1


@pytest.mark.verify
@pytest.mark.parametrize("bound, words", [("ACCEPTED", "factor of 1"), ("TESTABLE", "amplifies rounding")])
def test_a_law_beyond_a_bound_is_refused_in_single_precision(bound, words, monkeypatch):
    monkeypatch.setattr(f"cabledrive.export.single_precision.{bound}", 1e-9)
    with pytest.raises(cd.InputRefused, match=words) as refusal:
        single_precision(source_of("darc-4"))
    assert "\n" not in str(refusal.value)
