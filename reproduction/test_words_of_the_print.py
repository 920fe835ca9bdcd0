"""What the errata say the print says: sentences and table rows, looked up in the text where it is at hand."""

import re
from pathlib import Path

import pytest

HERE = Path(__file__).parent
TEXT = HERE.parents[1] / "shared" / "reference" / "dissertation.txt"
QUOTES = (HERE / "sheets" / "print.txt").read_text(encoding="utf-8")
SENTENCES, ROWS = re.findall(r"^([a-z0-9-]+): (.+)$", QUOTES, re.M), re.findall(r"^\|.+$", QUOTES, re.M)


@pytest.mark.skipif(not TEXT.is_file(), reason="needs ../shared/reference/dissertation.txt")
def test_quotes_stand_in_the_text():
    """An item that judges a sentence judges one that is there; every table value is the print's."""
    text, errata = (
        re.sub(r"\s+", "", path.read_text(encoding="utf-8")) for path in (TEXT, HERE / "errata.md")
    )
    assert len(SENTENCES) > 30
    assert len(ROWS) > 25
    quotes = (*ROWS, *(words for _, words in SENTENCES))
    absent = [quote for quote in quotes if re.sub(r"\s+", "", quote) not in text]
    assert not absent, "\n".join(absent)
    assert not [anchor for anchor, _ in SENTENCES if f"({anchor})=" not in errata]
