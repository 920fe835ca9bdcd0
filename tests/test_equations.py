"""docs/equations.md is true: one home per equation, which says so, and a test that checks it."""

from pathlib import Path

import pytest

import equation_index
from equation_index import Row

ROOT = Path(__file__).resolve().parent.parent
HERE = "tests/test_equations.py"


def test_every_equation_has_one_home_that_names_it_and_a_test():
    table = equation_index.rows((ROOT / "docs" / "equations.md").read_text())
    assert table, "docs/equations.md holds no table"
    faults = equation_index.disagreements(table, equation_index.claims("cabledrive"), ROOT)
    assert not faults, "\n".join(faults)


def test_each_of_the_208_numbered_equations_has_a_home_or_a_reason_for_none():
    """Chapters 2 to 6 number so many; (2.14), (3.2) and (6.97) are lost in the text that was read."""
    page = (ROOT / "docs" / "equations.md").read_text()
    last = {"2": 39, "3": 38, "4": 20, "5": 4, "6": 110}
    printed = equation_index.numbered(last, {"2.14", "3.2", "6.97"})
    assert len(printed) == 208
    homes = {equation_index.without_letter(n) for row in equation_index.rows(page) for n in row.equations}
    reasons = equation_index.without_home(page)
    homeless = [number for number, _ in reasons]
    assert len(homeless) == len(set(homeless)), "an equation stands twice among those without a home"
    assert sorted(set(homeless) & homes) == []
    assert sorted(printed - homes - set(homeless)) == []
    assert sorted(set(homeless) - printed) == []
    assert all(len(reason) > 10 for _, reason in reasons)


@pytest.mark.parametrize(
    "text, numbers",
    [
        ("(3.13)", "3.13"),
        ("(3.29)-(3.32)", "3.29 3.30 3.31 3.32"),
        ("(3.9) – (3.11)", "3.9 3.10 3.11"),
        ("(3.14a)", "3.14a"),
        ("(3.7a)-(3.7c), (A.1)", "3.7a 3.7b 3.7c A.1"),
    ],
)
def test_ranges_and_letters_are_written_out(text, numbers):
    assert equation_index.expand(text) == tuple(numbers.split())


@pytest.mark.parametrize("text", ["(3.32)-(3.29)", "(2.1)-(3.2)", "(3.1a)-(3.2b)", "(3.1)-(3.1c)"])
def test_what_is_not_a_range_is_refused(text):
    with pytest.raises(ValueError, match="is not a range"):
        equation_index.expand(text)


@pytest.mark.parametrize(
    "docstring, numbers",
    [
        ("Natural frequencies, Eq. (3.13).", {"3.13"}),
        ("The hanging mass, Eqs. (3.29)-(3.31) and\n    (3.33), printed.", {"3.29", "3.30", "3.31", "3.33"}),
        ("Rigid supports, Eqs. (3.14a), (3.14b), (3.20).", {"3.14a", "3.14b", "3.20"}),
        ("The chain, Eq. (M.2); Eq. (3.9) with mass.", {"M.2", "3.9"}),
        ("Version (3.13) of a method with eq (2.1).", set()),
    ],
)
def test_equations_named_in_a_docstring_are_found(docstring, numbers):
    assert equation_index.named(docstring) == numbers


def test_only_a_table_with_the_four_columns_is_read():
    page = """
| Other | table |
|---|---|
| (1.1) | `x` |

| Equation | What | Home | Checked by |
|---|---|---|---|
| (3.29)-(3.30) | sag | `a.b` | `tests/x.py`, `tests/y.py::test_z` |

(3.99) is outside.
"""
    assert equation_index.rows(page) == [Row(("3.29", "3.30"), "a.b", ("tests/x.py", "tests/y.py::test_z"))]


def test_a_row_without_a_home_is_refused():
    page = "| Equation | What | Home | Checked by |\n|---|---|---|---|\n| (3.1) | x |  | `t` |"
    with pytest.raises(ValueError, match="is missing"):
        equation_index.rows(page)


@pytest.fixture
def printed(tmp_path, monkeypatch):
    """A package with one home, one mention and one property."""
    (tmp_path / "sample_print").mkdir()
    (tmp_path / "sample_print" / "__init__.py").write_text("")
    (tmp_path / "sample_print" / "loop.py").write_text(
        'def matrix():\n    """Modal matrix,\n    Eq. (3.13).\n\n    From Eq. (3.12).\n    """\n'
        'class Span:\n    @property\n    def speed(self):\n        """Wave speed, Eq. (2.4)."""\n'
    )
    monkeypatch.syspath_prepend(tmp_path)
    return [
        Row(("3.13",), "sample_print.loop.matrix", (HERE,)),
        Row(("2.4",), "sample_print.loop.Span.speed", (HERE,)),
    ]


def test_a_summary_claims_and_a_later_paragraph_mentions(printed):
    homes = [("3.13", "sample_print.loop.matrix"), ("2.4", "sample_print.loop.Span.speed")]
    assert equation_index.claims("sample_print") == homes
    assert equation_index.disagreements(printed, homes, ROOT) == []


@pytest.mark.parametrize(
    "row, fault",
    [
        (Row(("3.13",), "sample_print.loop.Span", (HERE,)), "(3.13) has two homes"),
        (Row(("9.9",), "sample_print.loop.matrix", (HERE,)), "does not name (9.9)"),
        (Row(("9.9",), "sample_print.loop.absent", (HERE,)), "sample_print.loop.absent does not exist"),
        (Row(("9.9",), "sample_print.absent.matrix", (HERE,)), "sample_print.absent.matrix does not exist"),
        (Row(("3.12",), "sample_print.loop.matrix", ("tests/absent.py",)), "tests/absent.py does not exist"),
        (Row(("3.12",), "sample_print.loop.matrix", (f"{HERE}::test_absent_",)), "has no test_absent_"),
    ],
)
def test_a_row_that_is_not_true_is_found(printed, row, fault):
    faults = equation_index.disagreements([*printed, row], [], ROOT)
    assert any(fault in line for line in faults), faults


def test_a_claim_that_the_table_does_not_know_is_found(printed):
    claimed = equation_index.claims("sample_print")
    faults = equation_index.disagreements(printed[:1], claimed, ROOT)
    assert faults == ["sample_print.loop.Span.speed claims (2.4); the table says nothing about it"]
