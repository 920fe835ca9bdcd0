"""The command starts fast: what is heavy is imported where it is needed."""

import subprocess
import sys

import pytest

HEAVY = {"matplotlib", "numba", "pint", "scipy", "xarray", "pandas", "jinja2", "sympy"}


def imported(statement):
    """Heavy packages that a process has imported after a statement."""
    code = f"import sys\n{statement}\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return HEAVY & {name.split(".")[0] for name in done.stdout.split()}


def invoke(*arguments):
    runner = "from click.testing import CliRunner\nfrom cabledrive.app.main import main\n"
    return f"{runner}CliRunner().invoke(main, {list(arguments)})"


@pytest.mark.parametrize("arguments", [("--version",), ("--help",), ("modes",)])
def test_asking_for_help_imports_nothing_heavy(arguments):
    assert imported(invoke(*arguments)) == set()


def test_modes_import_no_plotting_and_no_report():
    """But for jinja2, which pint's look for an installed dask brings along."""
    assert imported(invoke("modes", "dissertation-2")) <= {"pint", "scipy", "numba", "jinja2"}
