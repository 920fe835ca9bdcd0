"""Mutants of kernels and formulas, and which of them the tests of their room notice.

A mutant is one function with one change: an operator or a comparison turned round, a constant doubled (0: 1),
a term, an ``abs`` or an addition to a name dropped, a condition negated, ``min`` for ``max``. Left out are
refusals, words, indices, bounds below 1e-5. The sample is drawn by hashes: it stays where the sources do.

A process for each room collects its tests, notes which of them enter a sampled function and their time. It
forks for every mutant: the child takes the changed code and runs the tests that enter it, fastest first, up
to a failure. Kernels run without the compiler, under the tests marked ``kernel``.

``python tools/mutants.py`` writes tests/mutants.md from all rooms; ``--room control`` does one room anew, and
``--room control --again FILE`` tries what survived there on the tests of that file.
"""

import argparse
import ast
import builtins
import copy
import functools
import gc
import hashlib
import importlib
import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import FunctionType

import pytest

from other_code import codes, place_of, text_of

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "src" / "cabledrive"
ROOMS = (
    "parameters mechanics trajectories modal simulation reduction identification control rig studies export"
)
ROOMS += " campaign"
USED_BY = dict(
    parameters="mechanics",
    mechanics="modal",
    modal="reduction",
    simulation="reduction",
    reduction="studies",
    identification="studies",
    control="rig",
    rig="studies",
    studies="app",
)
"""The room whose tests may notice what no test of a room enters."""
TABLE, KEPT = ROOT / "tests" / "mutants.md", ROOT / "build" / "mutants"
EQUIVALENT = ROOT / "tools" / "equivalent_mutants.toml"
SLOWEST, ALTOGETHER = 10.0, 30.0  # seconds of a test, and of all tests of a mutant

SWAPS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
FLIPS = {
    ast.Lt: ast.Gt,
    ast.Gt: ast.Lt,
    ast.LtE: ast.GtE,
    ast.GtE: ast.LtE,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
}
OTHER = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
REFUSING = re.compile(r"_?(check|require|refuse|warn|say|describe)|.*(words|message|sentence|refusal)|__")
TOLERANCE = re.compile(r".*tol|maxiter|axis|ndmin|stacklevel")


@dataclass(frozen=True, slots=True)
class Mutant:
    """Where a change is made: file, line, the outermost function, the node in the order of `ast.walk`."""

    file: str
    line: int
    function: str
    change: str
    kernel: bool
    node: int
    variant: int
    count: int = 0
    """Of earlier changes of the same text in the function."""

    @property
    def key(self) -> tuple[str, str, str, int]:
        return self.file, self.function, self.change, self.count

    @property
    def room(self) -> str:
        return Path(self.file).parts[2]


def variants(node: ast.AST) -> Iterator[ast.AST]:
    """What a node is replaced by, one by one."""
    match node:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in SWAPS:
            if not any(isinstance(side, ast.List | ast.Tuple) or _is_text(side) for side in (left, right)):
                yield ast.BinOp(left, SWAPS[type(op)](), right)
                if isinstance(op, ast.Add | ast.Sub):
                    yield left
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in FLIPS and not _is_text(
            right
        ):
            yield ast.Compare(left, [FLIPS[type(op)]()], [right])
        case ast.Constant(value=value) if type(value) in (int, float) and not 0 < abs(value) < 1e-5:
            yield ast.Constant(2 * value if value else 1)
        case ast.If() | ast.IfExp():
            changed = copy.copy(node)
            changed.test = ast.UnaryOp(ast.Not(), node.test)
            yield changed
        case ast.Call(func=ast.Name(id="abs") | ast.Attribute(attr="abs"), args=[argument]):
            yield argument
        case ast.Call(func=ast.Name(id=name)) if name in OTHER:
            yield ast.Call(ast.Name(OTHER[name], ast.Load()), node.args, node.keywords)
        case ast.Call(func=ast.Attribute(value=value, attr=name)) if name in OTHER:
            yield ast.Call(ast.Attribute(value, OTHER[name], ast.Load()), node.args, node.keywords)
        case ast.AugAssign():
            yield ast.Pass()


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _left_out(node: ast.AST) -> Iterator[ast.AST]:
    """Parts of a node in which nothing is changed."""
    match node:
        case ast.Raise() | ast.JoinedStr() | ast.Assert():
            yield from ast.iter_child_nodes(node)
        case ast.If(test=test, body=body) if all(isinstance(one, ast.Raise) for one in body):
            yield from (node, test, *body)
        case ast.IfExp(body=body, orelse=orelse) if _is_text(body) or _is_text(orelse):
            yield node
        case ast.Subscript(slice=part) | ast.AnnAssign(annotation=part):
            yield part
        case ast.keyword(arg=name) if name and TOLERANCE.match(name):
            yield node.value
        case ast.Call(func=ast.Name(id=name)) if name in ("InputRefused", "NotComputed", "Doubt", "warn"):
            yield from ast.iter_child_nodes(node)
        case ast.FunctionDef() if (
            REFUSING.match(node.name) or ast.unparse(node.returns or node.args) == "str"
        ):
            yield from node.body
        case ast.FunctionDef():
            yield from filter(None, (node.args, node.returns, *node.decorator_list))


def sites(path: Path) -> Iterator[Mutant]:
    """Every mutant of a file."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    kernels = set(re.findall(r"\bnjit\w*\((\w+)", text))
    outer: dict[ast.AST, tuple[str, bool]] = {}
    for owner in [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))]:
        for function in (node for node in owner.body if isinstance(node, ast.FunctionDef)):
            name = function.name if owner is tree else f"{owner.name}.{function.name}"
            decorators = " ".join(ast.unparse(one) for one in function.decorator_list)
            kernel = "njit" in decorators or function.name in kernels
            outer |= dict.fromkeys(ast.walk(function), (name, kernel))
    banned: set[ast.AST] = set()
    seen: Counter[tuple[str, str]] = Counter()
    for number, node in enumerate(ast.walk(tree)):
        banned |= {
            below for part in _left_out(node) for below in (ast.walk(part) if part is not node else [node])
        }
        if node in outer and node not in banned:
            function, kernel = outer[node]
            for variant, changed in enumerate(variants(node)):
                change = f"{_shown(node)} → {_shown(changed)}"
                file = path.relative_to(ROOT).as_posix()
                count = seen[function, change]
                seen[function, change] += 1
                yield Mutant(file, node.lineno, function, change, kernel, number, variant, count)


def _shown(node: ast.AST) -> str:
    words = ast.unparse(node).splitlines()[0].removesuffix(":")
    return words if len(words) < 70 else words[:66] + " ..."


def sample(seed: int, count: int) -> list[Mutant]:
    """The mutants whose hashes with the seed are the smallest."""
    found = [
        one
        for room in ROOMS.split()
        for path in sorted((PACKAGE / room).rglob("*.py"))
        for one in sites(path)
    ]
    ranked = sorted(found, key=lambda one: hashlib.sha256(repr((seed, one.key)).encode()).digest())
    return sorted(
        ranked[:count], key=lambda one: (ROOMS.split().index(one.room), one.file, one.line, one.change)
    )


def change_code(mutant: Mutant, note: str = "") -> None:
    """Give the functions of a mutant its code, or with ``note`` code that notes when it is entered."""
    file = str(ROOT / mutant.file)
    tree = ast.parse(text_of(file))
    owner, _, name = mutant.function.rpartition(".")
    scope = next((one for one in tree.body if isinstance(one, ast.ClassDef) and one.name == owner), tree)
    outermost = next(
        one for one in scope.body
        if getattr(one, "name", "") == name and one.lineno <= mutant.line <= one.end_lineno
    )  # fmt: skip
    if note:
        outermost.body[:0] = ast.parse(f"mutant_entered({note!r})").body
    else:
        target = next(node for number, node in enumerate(ast.walk(tree)) if number == mutant.node)
        changed = ast.copy_location([*variants(target)][mutant.variant], target)
        _Replacing(target, changed).visit(tree)
    first = min(one.lineno for one in (outermost, *outermost.decorator_list))
    made = codes(ast.fix_missing_locations(tree), file)
    for function in [one for one in gc.get_objects() if isinstance(one, FunctionType)]:
        place = place_of(function)
        if (
            function.__code__.co_filename == file
            and first <= place[1] <= outermost.end_lineno
            and place in made
        ):
            function.__code__ = made[place]


class _Replacing(ast.NodeTransformer):
    def __init__(self, target: ast.AST, changed: ast.AST) -> None:
        self.target, self.changed = target, changed

    def visit(self, node: ast.AST) -> ast.AST:
        return self.changed if node is self.target else self.generic_visit(node)


class Runner:
    """A plugin for pytest: runs the tests of a room once to note what they enter, then every mutant."""

    def __init__(self, mutants: list[Mutant], report: Path) -> None:
        self.mutants, self.report = mutants, report
        self.entering: defaultdict[str, set[str]] = defaultdict(set)
        self.seconds: dict[str, float] = {}
        self.failed: set[str] = set()
        self.now = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration
        if report.failed:
            self.failed.add(report.nodeid)

    def run(self, items: list[pytest.Item], stop: bool = False) -> None:
        for item, after in zip(items, [*items[1:], None], strict=True):
            self.now = item.nodeid
            item.ihook.pytest_runtest_protocol(item=item, nextitem=None if stop and self.failed else after)
            if stop and self.failed:
                return

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        places = {(one.file, one.function): one for one in self.mutants}
        builtins.__dict__["mutant_entered"] = lambda name: self.entering[name].add(self.now)
        signal.signal(signal.SIGALRM, _late)
        for file, _ in places:  # what is imported when it is first needed would bring code of its own
            importlib.import_module(".".join(Path(file).with_suffix("").parts[1:]))
        for item in session.items:
            item.obj = _limited(item.obj) if hasattr(item, "obj") else None
        child = os.fork()  # what is noted is noted by a child: here the functions stay as they are
        notes = self.report.with_suffix(".notes")
        if child == 0:
            _silence()
            for (file, function), one in places.items():
                change_code(one, note=f"{file} {function}")
            with suppress(BaseException):  # an alarm that comes between two tests
                self.run(session.items)
            known = {name: sorted(tests) for name, tests in self.entering.items()}
            notes.write_text(json.dumps([known, self.seconds, sorted(self.failed)]))
            os._exit(0)
        os.waitpid(child, 0)
        known, self.seconds, failed = json.loads(notes.read_text())
        items = {item.nodeid: item for item in session.items if item.nodeid not in failed}
        found = []
        for one in self.mutants:
            tests = sorted(
                known.get(f"{one.file} {one.function}", ()), key=lambda test: (self.seconds[test], test)
            )
            chosen, spent = [], 0.0
            for test in (test for test in tests if test in items and self.seconds[test] < SLOWEST):
                spent += self.seconds[test]
                if spent < ALTOGETHER:
                    chosen.append(items[test])
            found.append(asdict(one) | {"tests": len(chosen), "killer": self.killer(one, chosen)})
            self.report.with_suffix(".part").write_text(json.dumps(found, indent=1))
        self.report.with_suffix(".part").replace(self.report)
        return True

    def killer(self, mutant: Mutant, items: list[pytest.Item]) -> str:
        """The test that fails on a mutant; nothing where none does."""
        if not items:
            return ""
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            _silence()
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            clear_caches()
            change_code(mutant)
            for item in items:
                item.obj = getattr(item.obj, "unlimited", item.obj)
            signal.alarm(round(3 * ALTOGETHER))
            try:
                self.failed.clear()
                self.run(items, stop=True)
                os.write(writer, next(iter(self.failed), "").encode())
            except BaseException as error:
                os.write(writer, f"{self.now} ({type(error).__name__})".encode())
            os._exit(0)
        os.close(writer)
        with os.fdopen(reader) as words:
            failed = words.read()
        _, status = os.waitpid(child, 0)
        return failed or (f"time or signal {status & 127}" if status else "")


def _late(*_: object) -> None:
    raise TimeoutError("too slow for a mutant")


def _limited(test):
    """A test that ends after the longest time that tests of mutants may take."""

    @functools.wraps(test)
    def limited(*arguments, **named):
        signal.alarm(round(SLOWEST))
        try:
            return test(*arguments, **named)
        finally:
            signal.alarm(0)

    limited.unlimited = test
    return limited


def _silence() -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)


def clear_caches() -> None:
    """Forget results that functions of the package and of its tests keep."""
    for one in gc.get_objects():
        if isinstance(one, functools._lru_cache_wrapper) and "numba" not in (one.__module__ or ""):
            one.cache_clear()


def work(room: str, kernel: bool, seed: int, count: int, files: list[str]) -> None:
    """One room in this process: its kernels, or its plain functions; survivors alone under some files."""
    mutants = [one for one in sample(seed, count) if one.room == room and one.kernel == kernel]
    report = KEPT / f"{room}-{'kernels' if kernel else 'formulas'}.json"
    report.parent.mkdir(parents=True, exist_ok=True)
    if files:
        before = json.loads(report.read_text())
        alive = {
            (one["file"], one["function"], one["change"], one["count"])
            for one in before
            if not (one["killer"] or (one["tests"] and files == [f"tests/{USED_BY.get(room)}"]))
        }
        if not alive:
            return
        again = report.with_suffix(".again")
        runner = Runner([one for one in mutants if one.key in alive], again)
        marker = "kernel and not verify" if kernel else "not verify"
        pytest.main(["-p", "no:xdist", "-q", "-s", "-m", marker, *files], plugins=[runner])
        found = {
            (one["file"], one["function"], one["change"], one["count"]): one
            for one in json.loads(again.read_text())
        }
        for one in before:
            new = found.get((one["file"], one["function"], one["change"], one["count"]))
            if new and new["killer"]:
                one |= {"killer": new["killer"], "tests": new["tests"], "line": new["line"]}
        report.write_text(json.dumps(before, indent=1))
        return
    if not mutants:
        report.write_text("[]")
        return
    marker = "kernel and not verify" if kernel else "not verify"
    pytest.main(
        ["-p", "no:xdist", "-q", "-s", "-m", marker, f"tests/{room}"], plugins=[Runner(mutants, report)]
    )


def written(seed: int) -> str:
    """The table of all rooms whose results are kept."""
    listed = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["mutant"] if EQUIVALENT.exists() else []
    reasons = {(one["file"], one["function"], one["change"]): one["reason"] for one in listed}
    rows, rooms, by_users = [], [], 0
    for room in ROOMS.split():
        counts = Counter[str]()
        for kind in ("kernels", "formulas"):
            kept = KEPT / f"{room}-{kind}.json"
            for one in json.loads(kept.read_text()) if kept.exists() else []:
                reason = reasons.get((one["file"], one["function"], one["change"]))
                killer = one["killer"].removeprefix(f"tests/{room}/")
                outcome = "killed" if killer else "equivalent" if reason else "SURVIVED"
                counts[f"{kind} {outcome}"] += 1
                words = f"`{killer}`" if killer else f"equivalent: {reason}" if reason else "SURVIVED"
                by_users += "tests/" in killer
                if not killer and not reason and not one["tests"]:
                    words += " (no test enters it)"
                place = f"{one['file'].removeprefix('src/cabledrive/')}:{one['line']}"
                rows.append([f"`{place}`", f"`{one['function']}`", f"`{one['change']}`", words])
        cells = [
            str(counts[f"{kind} {one}"]) for kind in ("kernels", "formulas") for one in ("killed", "SURVIVED")
        ]
        rooms.append([room, *cells, str(counts["kernels equivalent"] + counts["formulas equivalent"])])
    totals = [sum(int(row[k]) for row in rooms) for k in range(1, 6)]
    rooms.append(["all", *map(str, totals)])
    killed, alive = totals[0] + totals[2], totals[1] + totals[3]
    share = killed / max(1, killed + alive)
    missing = [
        f"{room} ({kind})"
        for room in ROOMS.split()
        for kind in ("kernels", "formulas")
        if not (KEPT / f"{room}-{kind}.json").exists()
    ]
    open_ = f" Not run: {', '.join(missing)}." if missing else ""
    return "\n".join([
        "# Mutants",
        "",
        f"Written by `make mutants`, seed {seed}: functions with one change, and a test that fails.",
        f"Killed: {killed} of {killed + alive}, {share:.1%}, {by_users} of them by tests of a room that uses "
        f"the function, whose path is whole; equivalent: {totals[4]}.{open_}",
        "",
        *_table(["room", "kernels killed", "survived", "formulas killed", "survived", "equivalent"], rooms),
        "",
        *_table(["place", "function", "change", "killed by"], rows),
        "",
    ])  # fmt: skip


def _table(heads: list[str], rows: list[list[str]]) -> list[str]:
    lines = [heads, ["---"] * len(heads), *([cell.replace("|", "\\|") for cell in row] for row in rows)]
    return [f"| {' | '.join(line)} |" for line in lines]


def main() -> None:
    """Do the rooms asked for, two at a time, and write the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--room", action="append", choices=ROOMS.split())
    parser.add_argument("--kind", choices=("kernels", "formulas"))
    parser.add_argument("--again", nargs="+", default=[], metavar="FILE", help="try survivors on these tests")
    parser.add_argument("--here", action="store_true", help="one room and kind, in this process")
    given = parser.parse_args()
    if given.here:
        work(given.room[0], given.kind == "kernels", given.seed, given.count, given.again)
        return
    kinds = [given.kind] if given.kind else ["kernels", "formulas"]
    jobs = [(room, kind, given.again) for kind in kinds for room in given.room or ROOMS.split()]
    users = [(room, kind, [f"tests/{USED_BY[room]}"]) for room, kind, _ in jobs if room in USED_BY]

    def job(one: tuple[str, str, list[str]]) -> None:
        began = time.monotonic()
        command = [sys.executable, __file__, "--here", "--room", one[0], "--kind", one[1]]
        command += ["--seed", str(given.seed), "--count", str(given.count)]
        command += ["--again", *one[2]] if one[2] else []
        environment = os.environ | ({"NUMBA_DISABLE_JIT": "1"} if one[1] == "kernels" else {})
        subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, check=False)
        print(*one, f"{time.monotonic() - began:.0f} s", flush=True)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(job, jobs))
        list(pool.map(job, [] if given.again else users))
    TABLE.write_text(written(given.seed), encoding="utf-8")


if __name__ == "__main__":
    main()
