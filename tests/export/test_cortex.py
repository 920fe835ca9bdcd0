"""The self-test on an emulated Cortex-M7: bare metal, newlib's math library, no operating system."""

import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from cabledrive.export.c99 import controller_package
from cabledrive.export.door import write_folder
from export.designs import source_of

BOARD = Path(__file__).parent / "cortex"
CC, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16")
FLAGS += ("-mfloat-abi=hard", "--specs=rdimon.specs", "-fstack-usage")
MACHINE = ("-M", "mps2-an500", "-cpu", "cortex-m7", "-nographic", "-monitor", "none", "-serial", "none")
MACHINE += ("-semihosting-config", "enable=on,target=native")
STEP = re.compile(r"k_\w+|cd_step|tanh\w*|expm1\w*|exp\w*|__ieee754\w*|memcpy")
pytestmark = [
    pytest.mark.verify,
    pytest.mark.skipif(not (shutil.which(CC) and shutil.which(EMULATOR)), reason=f"needs {CC}, {EMULATOR}"),
]


@pytest.fixture(scope="module", params=["darc-4-damped", "pd"])
def board(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cortex") / request.param
    write_folder(folder, controller_package(source_of(request.param)))
    sources = [BOARD / "start.c", "cabledrive_law.c", "check.c", "-lm", "-T", BOARD / "cortex_m7.ld"]
    subprocess.run([CC, *FLAGS, *sources, "-o", "check.elf"], cwd=folder, check=True, capture_output=True)
    return request.param, folder


def emulated(folder, *more):
    command = [EMULATOR, *MACHINE, *more, "-kernel", "check.elf"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def test_the_self_test_passes_to_the_bit(board):
    done = emulated(board[1])
    assert done.returncode == 0, done.stdout
    assert "1000 samples, command kept at 7, largest difference 0 N m" in done.stdout


def test_a_step_takes_less_than_a_kilobyte_of_stack_and_a_stated_number_of_instructions(board, measured):
    name, folder = board
    stack = sum(
        int(line.split("\t")[1]) for line in (folder / "check.elf-cabledrive_law.su").read_text().splitlines()
    )
    assert 0 < stack < 1024, f"observed {stack} bytes"
    lines = (folder / "vectors.csv").read_text().splitlines()[:42]
    few = folder / "few"
    few.mkdir()
    (few / "vectors.csv").write_text("\n".join(lines) + "\n")
    shutil.copy(folder / "check.elf", few)
    emulated(few, "-singlestep", "-d", "exec,nochain", "-D", "trace.log")
    with (few / "trace.log").open(errors="replace") as trace:
        names = (line.rsplit("] ", 1)[-1].strip() for line in trace)
        counted = Counter(one for one in names if STEP.fullmatch(one.split(".")[0]))
    steps = 41 + 40  # of both controllers of the self-test
    measured(f"{name}: {sum(counted.values()) / steps:.0f} instructions a step, {stack} bytes of stack")
    assert 100 < sum(counted.values()) / steps < 10_000
