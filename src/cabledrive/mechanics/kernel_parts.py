"""Kernels that kernels call: one version for every constant, and machine code inside their callers alone.

numba compiles a called kernel anew for each constant among its arguments, gives every version an entry from
Python, optimises it in full and makes machine code of it, although each caller holds a copy of its own. That
is more than half of the first run of a control loop. Here a kernel that a kernel calls is a *part*: constants
are arguments like others, and the compiler's code is linked into the kernel that Python calls, to be
optimised and made machine code with it. What an operation gives for types is looked up once.

numba has no public door for this. What is used of its inside is named in `INSIDE` and tried with the versions
in `TRIED`; with any other version kernels are compiled as numba does it, with equal results, only slower.
"""

import gc
from functools import cache, partial
from typing import Any

TRIED = ("0.68",)
"""Versions of numba (major.minor) whose inside was read and tested; `why_whole` names another."""
INSIDE = {
    "numba.core.codegen": (
        "JITCodeLibrary._optimize_final_module",
        "JITCodeLibrary._finalize_final_module",
        "JITCodeLibrary._finalize_dynamic_globals",
        "JITCodeLibrary._verify_declare_only_symbols",
        "JITCPUCodegen._library_class",
        "JITCPUCodegen.set_env",
    ),
    "numba.core.dispatcher": ("Dispatcher.get_call_template", "Dispatcher.get_overload"),
    "numba.core.event": ("Listener", "register"),
    "numba.core.ir": ("Inst._rec_list_vars", "Loc"),
    "numba.core.targetconfig": ("ConfigStack.top_or_none", "TargetConfig.__eq__"),
    "numba.core.types": ("BaseFunction.get_call_type", "BaseFunction.get_impl_key", "unliteral"),
}
"""Names of numba's inside that are used, by module."""
_COMPILING: list[Any] = []
"""Dispatchers that are compiling now, the outermost first."""
_TYPED: dict[Any, Any] = {}
"""Signatures found while the outermost of them compiles, and what implements each."""


@cache
def why_whole() -> str | None:
    """Why kernels that kernels call are compiled whole here, in one line; None if they are parts."""
    import numba

    slow = "first runs take twice as long"
    if ".".join(numba.__version__.split(".")[:2]) not in TRIED:
        return f"numba {numba.__version__} is none of those tried ({', '.join(TRIED)}): {slow}"
    missing = [name for module, names in INSIDE.items() for name in names if not _is_there(module, name)]
    return f"numba {numba.__version__} has no {missing[0]}: {slow}" if missing else None


def as_part_of_callers(compiled: Any) -> None:
    """Change a dispatcher to compile as a part in kernels, whole for Python, unless `why_whole` says why."""
    if why_whole() is not None:
        return
    from numba.core import types

    _link_parts()
    _look_up_once()
    part = cache(partial(_part_of, compiled))

    def get_call_template(args: Any, kws: Any) -> Any:
        named = {name: types.unliteral(one) for name, one in kws.items()}
        return part().get_call_template(tuple(map(types.unliteral, args)), named)

    compiled.get_call_template = get_call_template
    compiled.get_overload = lambda sig: part().get_overload(sig)


def _part_of(compiled: Any) -> Any:
    """A dispatcher of the same function and options, without an entry from outside; nothing of it is kept."""
    import numba

    options = {name: value for name, value in compiled.targetoptions.items() if name != "nopython"}
    options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    part: Any = numba.njit(**options)(compiled.py_func)
    part.is_part = True
    return part


def _is_there(module: str, name: str) -> bool:
    from pkgutil import resolve_name

    try:
        resolve_name(f"{module}:{name}")
    except (ImportError, AttributeError):
        return False
    return True


def _in_a_part() -> bool:
    """Whether what is compiled now is only linked, a part or numba's own code; a user's Python may call."""
    if not _COMPILING:
        return False
    now = _COMPILING[-1]
    library = len(_COMPILING) > 1 and now.py_func.__module__.split(".")[0] == "numba"
    return library or hasattr(now, "is_part")


@cache
def _link_parts() -> None:
    """Let numba stop at the compiler's code where a part is compiled."""
    from numba.core import codegen, event

    class Compiling(event.Listener):
        """Keeps what is compiling; meanwhile the compiler's many objects are not searched for garbage."""

        collects = False

        def on_start(self, event: Any) -> None:
            if not _COMPILING:
                self.collects = gc.isenabled()
                gc.disable()
            _COMPILING.append(event.data["dispatcher"])

        def on_end(self, event: Any) -> None:
            _COMPILING.pop()
            if not _COMPILING:
                _TYPED.clear()
                if self.collects:
                    gc.enable()

    class Library(codegen.JITCodeLibrary):
        """Code of a kernel; of a part only what its callers link."""

        def _optimize_final_module(self) -> None:
            if not _in_a_part():
                super()._optimize_final_module()

        def _finalize_final_module(self) -> None:
            if not _in_a_part():
                super()._finalize_final_module()
                return
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = True

    jit: Any = codegen.JITCPUCodegen
    plain = jit.set_env

    def set_env(self: Any, name: str, env: Any) -> None:
        if self._engine.is_symbol_defined(name):  # a part has none: it raises nothing
            plain(self, name, env)

    event.register("numba:compile", Compiling())
    jit.set_env = set_env
    jit._library_class = Library


@cache
def _look_up_once() -> None:
    """Keep what numba finds anew at each operation: options, variables, what a function gives for types."""
    from numba.core import ir, targetconfig, types

    names: Any = ir.Inst
    options: Any = targetconfig.TargetConfig
    function: Any = types.BaseFunction
    plain_vars, plain_equal, plain_type = names._rec_list_vars, options.__eq__, function.get_call_type
    no_variables = {ir.Loc, str, int, bool, type(None)}

    def call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
        key = self, context, tuple(args), tuple(kws.items()), targetconfig.ConfigStack.top_or_none()
        if key not in _TYPED:
            found = plain_type(self, context, args, kws)
            if not _COMPILING:
                return found
            _TYPED[key] = found, self.get_impl_key(found)
        found, self._impl_keys[found.args] = _TYPED[key]
        return found

    names._rec_list_vars = lambda self, value: [] if type(value) in no_variables else plain_vars(self, value)
    options.__hash__ = lambda self: hash(type(self))
    options.__eq__ = lambda a, b: a is b or a._values == getattr(b, "_values", None) or plain_equal(a, b)
    function.get_call_type = call_type
