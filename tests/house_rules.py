"""The house rules of CONTRIBUTING.md as functions from source text to the list of what breaks them."""

import ast
import re
from collections.abc import Iterator
from itertools import pairwise

from numpydoc.docscrape import NumpyDocString

Function = ast.FunctionDef | ast.AsyncFunctionDef

# Split, so that this file does not break the rule it states.
REGISTRIES = re.compile(
    r"pypi\.o"
    r"rg|pythonhosted\.o"
    r"rg|anaconda\.o"
    r"rg|npmjs\.o"
    r"rg|--(extra-)?index"
    r"-url|--find"
    r"-links"
)
MACHINE_PATHS = re.compile(r"(?<![\w.>}\]])(/(home|root|work|tmp|opt|Users)|[A-Z]:\\+\w+)(/|\\+)\w")


def places(pattern: re.Pattern[str], text: str) -> list[str]:
    """Lines of a text in which a pattern is found, as ``line number: what``."""
    return [
        f"{number}: {found[0]}"
        for number, line in enumerate(text.splitlines(), start=1)
        if (found := pattern.search(line))
    ]


def public_functions(tree: ast.Module) -> Iterator[tuple[str, Function]]:
    """Public functions and methods of a module, as a reader would name them; overloads are types."""
    for node in tree.body:
        if isinstance(node, Function) and not node.name.startswith("_") and not _overloads(node):
            yield node.name, node
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for child in node.body:
                if isinstance(child, Function) and not child.name.startswith("_"):
                    yield f"{node.name}.{child.name}", child


def _overloads(function: Function) -> bool:
    return any(getattr(decorator, "id", "") == "overload" for decorator in function.decorator_list)


def exports(tree: ast.Module) -> set[tuple[str, str]]:
    """Module and name of all that a room's ``__init__`` takes from its files and lists in ``__all__``."""
    listed = {
        element.value
        for node in tree.body
        if isinstance(node, ast.Assign) and any(getattr(t, "id", "") == "__all__" for t in node.targets)
        for element in getattr(node.value, "elts", [])
    }
    return {
        (node.module or "", name.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for name in node.names
        if (name.asname or name.name) in listed
    }


def decorators(function: Function) -> set[str]:
    """Last names of the decorators: ``@numba.njit(cache=True)`` gives njit."""
    calls = [d.func if isinstance(d, ast.Call) else d for d in function.decorator_list]
    return {d.attr if isinstance(d, ast.Attribute) else getattr(d, "id", "") for d in calls}


COMPILERS = {"njit", "njit_inlined", "njit_strict", "njit_in_place", "jit", "vectorize", "guvectorize"}


def is_kernel(function: Function) -> bool:
    return bool(decorators(function) & COMPILERS)


def compiles(tree: ast.Module) -> bool:
    """Whether a module compiles kernels, by a decorator or by a call when they are first needed."""
    names = {getattr(node, "attr", getattr(node, "id", None)) for node in ast.walk(tree)}
    return bool(names & COMPILERS)


def docstring_gaps(name: str, function: Function, exported: bool = True) -> list[str]:
    """What a docstring lacks: all of it or, where a room exports the name, arguments, result, refusals."""
    text = ast.get_docstring(function)
    if not text:
        return [f"{name} has no docstring"]
    if not exported:
        return []
    told_elsewhere = {"property", "cached_property", "setter", "command", "group", "overload"}
    if is_kernel(function) or function.name.endswith("_reference") or decorators(function) & told_elsewhere:
        return []
    doc = NumpyDocString(text)
    gaps = [f"{name}: no {what} under Parameters" for what in _undescribed(function, doc)]
    returned = function.returns
    nothing = returned is None or (isinstance(returned, ast.Constant) and returned.value is None)
    if not nothing and not (doc["Returns"] or doc["Yields"]):
        gaps.append(f"{name}: no Returns")
    raising = [node for node in ast.walk(function) if isinstance(node, ast.Raise) and node.exc]
    if raising and not doc["Raises"]:
        gaps.append(f"{name}: no Raises")
    return gaps


def _undescribed(function: Function, doc: NumpyDocString) -> list[str]:
    a = function.args
    arguments = [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, [a.vararg, a.kwarg])]
    described = {
        part.strip().lstrip("*")
        for section in ("Parameters", "Other Parameters")
        for parameter in doc[section]
        for part in parameter.name.split(",")
    }
    names = [argument.arg for argument in arguments]
    return [name for name in names if name not in described | {"self", "cls"} and not name.startswith("_")]


def imports_of_the_root(tree: ast.Module) -> list[str]:
    """Statements that take something but the version from the package itself instead of from a room."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [f"{node.lineno}: import {n.name}" for n in node.names if n.name == "cabledrive"]
        elif isinstance(node, ast.ImportFrom) and (node.level or node.module == "cabledrive"):
            names = [n.name for n in node.names if n.name != "__version__"]
            found += [f"{node.lineno}: from {'.' * node.level}{node.module or ''} import {n}" for n in names]
    return found


GENERIC = {"dict", "frozenset", "list", "set", "tuple", "type"}


def documented_types(tree: ast.Module) -> list[str]:
    """Public type variables and generic aliases with a string behind them: no reference can format it."""
    return [
        statement.targets[0].id
        for statement, after in pairwise(tree.body)
        if isinstance(statement, ast.Assign)
        and isinstance(statement.targets[0], ast.Name)
        and not statement.targets[0].id.startswith("_")
        and isinstance(after, ast.Expr)
        and isinstance(after.value, ast.Constant)
        and _names_a_type(statement.value)
    ]


def _names_a_type(value: ast.expr) -> bool:
    if isinstance(value, ast.Call):
        return isinstance(value.func, ast.Name) and value.func.id == "TypeVar"
    return (
        isinstance(value, ast.Subscript) and isinstance(value.value, ast.Name) and value.value.id in GENERIC
    )
