"""A line that is rewritten in place leaves nothing of the longer one before it, and nothing at the end."""

import sys

from cabledrive.parameters.terminal import TerminalLine, on_a_terminal


def seen(written: str) -> str:
    """What a terminal shows of one line: a carriage return goes back to its start."""
    shown: list[str] = []
    place = 0
    for letter in written:
        if letter == "\r":
            place = 0
            continue
        shown[place : place + 1] = [letter]
        place += 1
    return "".join(shown).rstrip()


def test_a_shorter_line_covers_a_longer_one_and_clearing_leaves_nothing(capsys):
    line = TerminalLine()
    line.clear()
    assert capsys.readouterr().err == "", "nothing was written, nothing is cleared"
    line.write("10 of 100 rows, 40 s left")
    line.write("11 of 100 rows")
    line.write("12")
    written = capsys.readouterr().err
    assert seen(written) == "12"
    line.clear()
    assert seen(written + capsys.readouterr().err) == ""


def test_where_standard_error_is_closed_nobody_looks(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    assert not on_a_terminal()
