"""Each item of the errata pages names tests that exist, or says that it was checked by reading."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = ("docs/errata.md", "docs/errata_control.md")
ENTRIES = {
    "erratum": ("Printed", "Correct", "Why", "Checked by"),
    "confirmed": ("Printed", "Correct", "Why", "Checked by"),
    "convention": ("Printed", "Here", "Why", "Checked by"),
    "number": ("Printed", "Computed", "Why", "Checked by"),
}
ANCHOR = re.compile(r"^\(([a-z0-9-]+)\)=$")
ENTRY = re.compile(r"^- ([A-Z][a-z ]+):(.*)$")
TEST = re.compile(r"`(reproduction/test_\w+\.py)::(test_\w+)`")


def items_of(page):
    """List the items of a page as (heading, anchor, entries) in the order in which they stand."""
    text = re.sub(r"<!--.*?-->", "", (ROOT / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    lines = text.splitlines()
    starts = [i for i, line in enumerate(lines) if line.startswith("### ")]
    ends = [
        next((j for j in range(i + 1, len(lines)) if lines[j].startswith("#")), len(lines)) for i in starts
    ]
    found = []
    for start, end in zip(starts, ends, strict=True):
        match = ANCHOR.match(lines[start - 1])
        anchor = match.group(1) if match else None
        found.append((lines[start][4:], anchor, entries_of(lines[start + 1 : end])))
    return found


def entries_of(lines):
    """Entries ``- Name: text`` of one item; indented lines belong to the entry above them."""
    entries, name = {}, None
    for line in lines:
        match = ENTRY.match(line)
        if match:
            name = match.group(1)
            entries[name] = match.group(2).strip()
        elif name and line.startswith("  "):
            entries[name] += " " + line.strip()
        else:
            name = None
    return entries


def docstrings(path):
    """Map the name of every test function in a file to its docstring."""
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    return {f.name: ast.get_docstring(f) or "" for f in functions if f.name.startswith("test_")}


@pytest.mark.parametrize("page", PAGES)
def test_every_item_has_an_anchor_and_its_entries(page):
    """An item without an anchor cannot be cited; one without its entries says nothing."""
    items = items_of(page)
    assert items, f"{page} has no item"
    wrong = []
    for heading, anchor, entries in items:
        kind = (anchor or "").partition("-")[0]
        missing = [
            name for name in ENTRIES.get(kind, ("an anchor of a known kind",)) if not entries.get(name)
        ]
        wrong += [f"{heading}: no {', '.join(missing)}"] if missing else []
    assert not wrong, f"{page}:\n" + "\n".join(wrong)


def test_no_anchor_is_used_twice():
    """A link to an item leads to one place, over both pages."""
    anchors = [anchor for page in PAGES for _, anchor, _ in items_of(page)]
    twice = sorted({a for a in anchors if anchors.count(a) > 1})
    assert not twice, f"used more than once: {twice}"


@pytest.mark.parametrize("page", PAGES)
def test_every_item_is_checked_by_an_existing_test_or_by_reading(page):
    """`Checked by` names tests whose docstrings name the anchor in return, or says `reading`."""
    wrong = []
    for _, anchor, entries in items_of(page):
        checked = entries.get("Checked by", "")
        tests = TEST.findall(checked)
        leftover = TEST.sub("", checked).replace(",", "").strip()
        if checked.strip() != "reading" and (not tests or leftover):
            wrong.append(f"{anchor}: cannot be read as tests or 'reading': {checked!r}")
        for path, name in tests:
            known = docstrings(path) if (ROOT / path).is_file() else {}
            if name not in known:
                wrong.append(f"{anchor}: {path}::{name} does not exist")
            elif not re.search(rf"\b{re.escape(anchor)}(?![\w-])", known[name]):
                wrong.append(f"{anchor}: the docstring of {path}::{name} does not name it")
    assert not wrong, f"{page}:\n" + "\n".join(wrong)


def test_every_test_of_an_anchor_is_cited_by_its_item():
    """The way back: an anchor named in a docstring here exists and cites that test."""
    cited = {
        (a, p, n)
        for page in PAGES
        for _, a, e in items_of(page)
        for p, n in TEST.findall(e.get("Checked by", ""))
    }
    kinds = "|".join(ENTRIES)
    wrong = []
    for file in sorted((ROOT / "reproduction").glob("test_*.py")):
        path = file.relative_to(ROOT).as_posix()
        for name, text in docstrings(path).items():
            named = re.findall(rf"`((?:{kinds})-[a-z0-9-]+)`", text)
            wrong += [f"{path}::{name} names {a}" for a in named if (a, path, name) not in cited]
    assert not wrong, "\n".join(wrong)
