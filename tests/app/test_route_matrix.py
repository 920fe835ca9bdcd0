"""Every command on every packaged machine with routes: it answers, or refuses in one line; none fails."""

import pytest

from command import call, the_line

MACHINES = (
    *("printer-idlers", "corexy", "lift-2-to-1", "serpentine"),
    *("tendon-finger", "ropeway-towers", "camera-winches", "capstan-arm"),
)
ALL = {
    "check": (),
    "modes": ("--count", "4"),
    "resonance": (),
    "resonance --motion": ("--motion", "motion.csv"),
    "simulate": ("--duration", "1 ms", "--segments", "4"),
    "response": (),
    "track": (),
    "compare": ("--draws", "2", "-o", "compared"),
    "experiment": ("-o", "log.csv"),
    "study": ("--quick", "-o", "studied"),
    "report": ("-o", "page.html"),
    "export": ("--format", "c99", "-o", "exported"),
}
NO_CHAIN = ("corexy", "lift-2-to-1", "serpentine", "tendon-finger", "camera-winches")


def answered(name, machine, options):
    """Whether a command answers; where it does not, its status and its one line are checked."""
    result = call(name.split()[0], machine, *options)
    if result.exit_code == 0:
        assert result.stdout.strip(), "silent"
        return True
    assert result.exit_code in (2, 3), (name, machine, result.output)
    assert result.stdout == ""
    assert the_line(result.stderr)
    return False


@pytest.mark.parametrize("machine", MACHINES)
def test_what_every_machine_answers(machine):
    assert answered("check", machine, ())
    assert answered("drives", machine, ())


@pytest.mark.parametrize("machine", NO_CHAIN)
def test_a_machine_whose_load_is_no_end_of_a_chain_is_refused(machine, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert not answered("study", machine, ALL["study"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.verify
@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("name", ALL)
def test_no_command_fails(name, machine, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "motion.csv").write_text("time [s],torque [N m]\n0,0.01\n0.05,-0.01\n0.1,0\n")
    answered(name, machine, ALL[name])
