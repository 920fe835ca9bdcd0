"""Commands stopped at one of their own writes go on to the same bytes, or are refused; no status is wrong."""

import pytest

from attack import moments


@pytest.fixture(scope="module")
def attack(tmp_path_factory):
    """Commands ready to be stopped, and what they write undisturbed."""
    with moments.attacker(tmp_path_factory.mktemp("moments")) as ready:
        if ready is None:
            pytest.skip("no C compiler here, or no LD_PRELOAD: faults cannot be made")
        yield ready


@pytest.mark.parametrize(
    ("seed", "count", "names"),
    [
        pytest.param(0, 20, ["simulate", "modes"], marks=pytest.mark.verify),
        pytest.param(1, 500, [*moments.COMMANDS], marks=pytest.mark.verify),
    ],
    ids=["few", "every command"],
)
def test_a_stopped_command_goes_on_to_the_same_bytes_or_is_refused(attack, seed, count, names, measured):
    outcomes, bad = moments.batch(attack, seed, count, names)
    measured(f"{count} moments: {dict(sorted(outcomes.items()))}")
    assert not bad, "\n".join(bad[:20])
    assert len(outcomes) == len(moments.KINDS)
