"""Whatever has happened to a file that is read as text: taken, or refused in one line."""

import pytest

from attack import ledger, texts

WHOLE = pytest.mark.verify


@pytest.mark.parametrize(
    ("kind", "seed", "count"),
    [
        ("drive", 0, 400),
        ("goals", 0, 200),
        ("excitation", 0, 200),
        ("motion", 0, 200),
        ("route", 0, 100),
        ("sweep", 0, 200),
        ("disturbances", 0, 100),
        ("controller", 0, 150),
        *(pytest.param(kind, 1, 20_000, marks=WHOLE) for kind in texts.KINDS),
    ],
)
def test_a_damaged_text_ends_with_status_0_2_or_3_and_one_line(kind, seed, count, measured):
    outcomes, bad = texts.attack(kind, seed, count)
    ledger.note(kind, seed, outcomes)
    measured(f"{count} damaged files of kind {kind} by status: {dict(sorted(outcomes.items()))}")
    assert not bad, "\n".join(bad[:20])
    least = 0.01 if kind == "sweep" else 0.02  # a SPEC is read strictly: fewer stay valid
    assert outcomes["0"] > least * count, outcomes
    assert outcomes["2"] > 0.2 * count, outcomes


@pytest.mark.parametrize(("seed", "count"), [(0, 12), pytest.param(1, 10_000, marks=WHOLE)])
def test_a_process_given_a_damaged_drive_file_ends_so_within_its_memory(seed, count, measured):
    outcomes, bad, largest = texts.attack_in_processes(seed, count)
    ledger.note("processes", seed, outcomes)
    measured(
        f"{count} processes by status: {dict(sorted(outcomes.items()))}, at most {largest / 2**20:.0f} MiB"
    )
    assert not bad, "\n".join(bad[:20])
    assert largest < texts.BYTES
