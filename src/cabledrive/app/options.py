"""Options that commands share, and what the shell is offered for them."""

import functools
import inspect
import os
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import click
from click.shell_completion import CompletionItem

from cabledrive.app.failures import BEGUN, QUIET, note
from cabledrive.app.results import (
    FORCE,
    OBJECT,
    PAGE,
    Answer,
    NewFile,
    NewFileType,
    json_text,
    provenance,
    show,
)
from cabledrive.parameters import Drive, InputRefused, Machine, NotComputed, load_drive, packaged_drives
from cabledrive.parameters.terminal import on_a_terminal
from cabledrive.parameters.units import to_si


def complete_drive(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of packaged drives, then files, for the shell. ``incomplete``: what has been typed."""
    names = [CompletionItem(name) for name in packaged_drives() if name.startswith(incomplete)]
    return [*names, CompletionItem(incomplete, type="file")]


def complete_controller(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Names of control laws, for the shell. ``incomplete``: what has been typed."""
    from cabledrive.rig.laws.registry import CONTROLLERS

    return [CompletionItem(name) for name in sorted((*CONTROLLERS, "best")) if name.startswith(incomplete)]


def listed_laws() -> tuple[str, ...]:
    """The laws that help lists, and where the others stand."""
    from cabledrive.rig.laws.registry import CONTROLLERS, MAIN_LAWS

    return (*MAIN_LAWS, "best", f"and {len(CONTROLLERS) - len(MAIN_LAWS)} more in docs/control")


Function = Callable[..., Any]
SHARED = {"--set", "--output", "--force", "--json", "--quiet", "--verbose", "--help"}
_ABOUT = "cabledrive.about"


class Subcommand(click.Command):
    """A command whose help shows its own options before those it shares with others, then an example.

    ``names`` gives the names that an option takes, by title; it is called when the help is shown.
    """

    def __init__(
        self, *args: Any, example: str, names: Callable[[], dict[str, Sequence[str]]] = dict, **options: Any
    ) -> None:
        super().__init__(*args, **options)
        self.epilog = f"\b\nExample:\n  {example}"
        self._names = names

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the arguments; a file both read and written is refused, even with ``--force``."""
        rest = super().parse_args(ctx, args)
        given = [one for own in ctx.params.values() for one in (own if isinstance(own, tuple) else (own,))]
        read = {os.path.realpath(one) for one in given if isinstance(one, str) and "\0" not in one}
        for value in ctx.params.values():
            if isinstance(value, NewFile) and os.path.realpath(value.path) in read:
                raise InputRefused(
                    f"{value.path}: is read and was to be written: give the output another name"
                )
        return rest

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options in two lists."""
        options = [option for option in self.get_params(ctx) if option.param_type_name == "option"]
        shared = [option for option in options if SHARED & set(option.opts)]
        own = [option for option in options if not SHARED & set(option.opts)]
        for title, group in (("Options", own), ("Options of every command", shared)):
            records = [record for option in group if (record := option.get_help_record(ctx)) is not None]
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)
        for title, listed in self._names().items():
            with formatter.section(title):
                formatter.write_text(", ".join(listed))


class Quantity(click.ParamType):  # type: ignore[type-arg]
    """A number, or text with a unit; ``counted_in``: of a bare number and the value, by default in SI."""

    def __init__(self, unit: str, counted_in: str | None = None) -> None:
        self.unit, self.counted_in = unit, counted_in
        self.name = counted_in or unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """A number in SI, or in the unit that it counts in; refused if none, or of another dimension."""
        try:
            if not isinstance(value, str):
                return float(value)
            if self.counted_in is None:
                return to_si(value, self.unit)
            with suppress(InputRefused):
                return to_si(value, "1")
            return float(f"{to_si(value, self.unit) / to_si(f'1 {self.counted_in}', self.unit):.15g}")
        except InputRefused as refusal:
            raise refusal.at(param.opts[0] if param else "value") from None


ANGLE = Quantity("rad", "deg")


class OptionOf(click.Option):
    """An option with the kinds of input it is of, in the command's words; `refuse_not_of` refuses others."""

    def __init__(self, *args: Any, of: tuple[str, ...], **options: Any) -> None:
        super().__init__(*args, **options)
        self.of = of


KINDS: dict[str, dict[str, Any]] = {
    "flag": {"is_flag": True},
    "count": {"type": int, "metavar": "N"},
    "path": {"type": click.Path(), "metavar": "FILE"},
    "page": {"type": NewFileType(*PAGE), "metavar": "FILE"},
    "picture": {"type": NewFileType(".png", ".svg", ".pdf"), "metavar": "FILE"},
}
UNITS = ("1", "s", "m", "m/s", "rad", "Hz", "N", "N m")


def option(names: str, kind: Any, words: str, default: Any = None, **more: Any) -> Callable[..., Any]:
    """An option of a command.

    ``names``: as click takes them, apart by blanks; ``kind``: one of `KINDS` or of `UNITS`, the ending of a
    new file as ".nc", choices as "a|b", a type of click, or what the help calls its text; ``words``: help,
    which shows the default unless these name it; ``more``: for click, and ``of``, see `OptionOf`.
    """
    if not isinstance(kind, str):
        found: dict[str, Any] = {"type": kind}
    elif kind in UNITS:
        found = {"type": Quantity(kind), "metavar": kind.replace(" ", "").upper()}
    elif kind.startswith("."):
        found = {"type": NewFileType(kind), "metavar": "FILE"}
    elif "|" in kind and kind == kind.lower():
        found = {"type": click.Choice(kind.split("|"))}
    else:
        found = KINDS.get(kind, {"metavar": kind})
    if default is not None:
        found = found | {"default": default, "show_default": "default" not in words}
    if "of" in more:
        found = found | {"cls": OptionOf}
    return click.option(*names.split(), **(found | {"help": words} | more))


def machine_argument(function: Function) -> Function:
    """Give a command the argument DRIVE and the option ``--set``; it is called with the drive itself."""

    @click.argument("drive", metavar="DRIVE", shell_complete=complete_drive)
    @option(
        "--set settings",
        "KEY=VALUE",
        'Replace a value of the drive file for this run, such as cable.pretension="6 N"; repeatable.',
        multiple=True,
    )
    @functools.wraps(function)
    def _with_drive(*, drive: str, settings: tuple[str, ...], **options: Any) -> Any:
        click.get_current_context().meta[_ABOUT] = loaded = load_drive(drive, overrides=settings)
        return function(drive=loaded, **options)

    return _with_drive


def axis_argument(function: Function, *, winches: bool = False, chainless: bool = False) -> Function:
    """As `machine_argument`, with ``--axis``: a machine with routes becomes the drive of its axis.

    ``winches``: a body between two winches stays the machine that it is; ``chainless``: so does a machine
    without a chain, with the reason as ``no_chain``.
    """

    @machine_argument
    @option(
        "--axis",
        "NAME",
        "Axis: its load, such as head.x of corexy; default: the load pulley, of routes the first that has a "
        "chain.",
    )
    @functools.wraps(function)
    def _with_axis(*, drive: Machine | Drive, axis: str | None, **options: Any) -> Any:
        from cabledrive.reduction.network_axis import NoChain, as_axis
        from cabledrive.reduction.two_motors import is_winched

        no_chain = None
        try:
            if not (winches and axis is None and is_winched(drive)):
                click.get_current_context().meta[_ABOUT] = drive = as_axis(drive, axis)
        except NoChain as refusal:
            if not chainless:
                raise
            no_chain = str(refusal)
        return function(drive=drive, **options, **({"no_chain": no_chain} if chainless else {}))

    return _with_axis


def force_option(function: Function) -> Function:
    """Give a command the option ``--force``, which its `NewFileType` options obey."""
    first: dict[str, Any] = {"is_eager": True, "expose_value": False}
    first["callback"] = lambda ctx, param, value: ctx.meta.update({FORCE: value})
    return click.option("--force", is_flag=True, **first, help="Replace files that exist.")(function)


def saves_answer(function: Function) -> Function:
    """Give a command the options ``--output`` and ``--force``: its JSON object goes into a file as well."""

    @force_option
    @option("-o --output", NewFileType(*OBJECT), "Write the JSON object to FILE as well.", metavar="FILE")
    @functools.wraps(function)
    def _saving(*, output: NewFile | None, **options: Any) -> Any:
        answer = function(**options)
        if output is not None:
            try:
                output.write(json_text(answer) + "\n")
            except NotComputed as failure:  # the disk refuses: it can still be shown
                lacking = [words for words in (answer.incomplete, str(failure)) if words]
                answer = replace(answer, incomplete="; ".join(lacking))
        return answer

    return _saving


def answering(function: Function) -> Function:
    """Give a command ``--json``, ``--quiet``, ``--verbose``; `NotComputed` after an incomplete answer."""

    @option("--json as_json", "flag", "Print one JSON object, in SI.")
    @option("--quiet", "flag", "No notes and no progress on standard error.")
    @option("--verbose", "flag", "Notes with times; the traceback of a defect.")
    @functools.wraps(function)
    def _answered(*, as_json: bool, quiet: bool, verbose: bool, **options: Any) -> None:
        meta = click.get_current_context().meta
        from cabledrive.mechanics.compile_time import LISTENERS  # `--help` does not wait for it

        meta[QUIET] = quiet
        meta[BEGUN] = time.monotonic() if verbose else None
        seen = on_a_terminal()  # a script counts lines
        LISTENERS[:] = [note] if verbose or seen else []
        try:
            answer = function(**options)
        except NotComputed as failure:
            about = provenance(meta.get(_ABOUT))
            answer = Answer(data={}, text="", provenance=about, incomplete=str(failure))
        except (InputRefused, click.ClickException, MemoryError, OSError):
            raise
        except Exception:
            if verbose:
                traceback.print_exc()
            raise
        if as_json or answer.text:
            show(answer, as_json=as_json)
        if answer.incomplete is not None:
            raise NotComputed(answer.incomplete)

    return _answered


def together(*own: Callable[..., Any]) -> Callable[..., Any]:
    """Options that several commands share, in the order of the help."""
    return lambda function: functools.reduce(lambda made, add: add(made), reversed(own), function)


class Declared(NamedTuple):
    """The default of a command's parameter: from the parameter's name to what adds it to the command."""

    add: Callable[[str], Callable[..., Any]]


def opt(kind: Any, words: str, default: Any = None, *, flags: str = "", **more: Any) -> Any:
    """A parameter that is an option, see `option`, by ``flags`` or its name: of repeatable spans --span."""

    def _add(name: str) -> Callable[..., Any]:
        word = name.removesuffix("s") if more.get("multiple") else name
        return option(f"{flags or '--' + word.replace('_', '-')} {name}", kind, words, default, **more)

    return Declared(_add)


HOW_HELD = opt(
    "free|held|holding", "How the rotor is held; default: holding with a motor.holding_stiffness, else free."
)
"""The default of the parameter ``motor``."""


def argument(metavar: str | None, **more: Any) -> Any:
    """A parameter that is an argument of the command; ``more``: for click."""
    return Declared(lambda name: click.argument(name, metavar=metavar, **more))


def subcommand(
    example: str,
    shared: Sequence[Callable[..., Any]] = (),
    names: Callable[[], dict[str, Sequence[str]]] = dict,
) -> Callable[[Function], click.Command]:
    """Make a command of a function whose `Answer` is shown, its options and arguments those it declares.

    ``shared``: options that it has in common with others, first in the help; ``names``: as of `Subcommand`.
    """

    def _made(function: Function) -> click.Command:
        declared = inspect.signature(function).parameters.items()
        own = [one.default.add(name) for name, one in declared if isinstance(one.default, Declared)]
        make = click.command(cls=Subcommand, example=example, names=names)
        return make(together(answering, *shared, *own)(function))

    return _made


pulse_options = together(
    option("--angle", ANGLE, "Of each pulse.", 45.0, metavar="DEG"),
    option("--rise", "s", "Rise time.", 0.5),
    option("--dwell", "s", "Rest after a move.", 0.5),
)
