"""docs/guide_commands.md says of the commands what is so."""

import re
import shlex
from pathlib import Path

import pytest
from click import Context

from cabledrive.app.main import main
from command import call

GUIDE = (Path(__file__).parents[2] / "docs" / "guide_commands.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"^\$ cabledrive (.+)\n((?:(?!\$|```).*\n)*)", GUIDE, re.M)


def test_guide_lists_every_command():
    listed = re.findall(r"^\| `cabledrive (\w+)", GUIDE, re.M)
    assert sorted(listed) == main.list_commands(Context(main))


@pytest.mark.parametrize(("arguments", "output"), SHOWN)
def test_commands_of_the_guide_do_what_it_shows(arguments, output):
    done = call(*shlex.split(arguments))
    if output:
        assert (done.exit_code, done.stderr) == (2, output)
    else:
        assert (done.exit_code, done.stderr) == (0, "")
