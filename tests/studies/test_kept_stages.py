"""What is kept of a study or a reproduction is believed only as it was written, by the code that wrote it."""

import json
from dataclasses import dataclass

import pytest

from cabledrive.app import finished_study
from cabledrive.parameters.files import OWN_HASH, with_own_hash
from cabledrive.studies.study.stage_cache import StageCache


@dataclass(frozen=True)
class Found:
    """A result."""

    value: float


CALLS = []


def half_more(value: float) -> Found:
    CALLS.append(value)
    return Found(1.5 * value)


def twice(value: float) -> Found:
    CALLS.append(value)
    return Found(2.0 * value)


def staged(folder, function=half_more, argument=1.0):
    return StageCache(folder=folder, note=print).staged("stage", function, argument)


DAMAGES = {
    "edited": lambda text: json.dumps(json.loads(text) | {"result": {"value": 99.0}}),
    "without a hash": lambda text: json.dumps({k: v for k, v in json.loads(text).items() if k != OWN_HASH}),
    "under another key": lambda text: json.dumps(with_own_hash(json.loads(text) | {"key": "0" * 64})),
    "cut": lambda text: text[:-3],
    "zeroed": lambda text: text[:20] + "\0" * 10 + text[30:],
    "a list": lambda text: "[1, 2]",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_stage_is_served_as_it_was_written_and_else_made_again(tmp_path, damage):
    CALLS.clear()
    assert staged(tmp_path) == staged(tmp_path) == Found(1.5)
    assert len(CALLS) == 1
    (file,) = tmp_path.iterdir()
    file.write_text(damage(file.read_text()))
    assert staged(tmp_path) == staged(tmp_path) == Found(1.5)
    assert len(CALLS) == 2


def test_a_stage_is_known_by_its_function_and_by_every_argument_that_it_is_given(tmp_path):
    CALLS.clear()
    assert staged(tmp_path, argument=2.0) == Found(3.0)
    assert staged(tmp_path, argument=3.0) == Found(4.5)
    assert staged(tmp_path, twice, 2.0) == Found(4.0)
    assert CALLS == [2.0, 3.0, 2.0]


def test_results_are_a_finished_study_only_with_the_files_they_were_written_with(tmp_path):
    import hashlib

    (tmp_path / "report.html").write_text("a page")
    files = {"report.html": hashlib.sha256(b"a page").hexdigest()}
    data = with_own_hash({"verdict": "yes", "files": files})
    (tmp_path / "results.json").write_text(json.dumps(data))
    assert finished_study.finished(tmp_path) == data
    (tmp_path / "report.html").write_text("another page")
    assert finished_study.finished(tmp_path) is None
    (tmp_path / "report.html").write_text("a page")
    (tmp_path / "results.json").write_text(json.dumps(data | {"verdict": "no"}))
    assert finished_study.finished(tmp_path) is None
    (tmp_path / "results.json").write_text(json.dumps({"verdict": "yes"}))
    assert finished_study.finished(tmp_path) is None
