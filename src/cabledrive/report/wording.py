"""Texts of the pages: Jinja templates with one macro for each, and filters for quantities."""

import re
from collections.abc import Callable, Iterable
from functools import cache, partial
from importlib import resources

import jinja2

from cabledrive.report.typesetting import number, quantity
from cabledrive.rig.setting import DEGREE

Say = Callable[..., str]

_FACTORS = {"deg": DEGREE, "mm": 1e-3, "um": 1e-6, "%": 1e-2}
_SPACES = re.compile(r"[ \n]+")


def texts(name: str, package: str = "cabledrive.report") -> Say:
    """Texts of ``templates/texts/NAME.txt`` of a package, one plain line each, by macro's name and values."""
    return partial(_said, package, name)


def _said(package: str, name: str, macro: str, /, **values: object) -> str:
    module = _template(package, name).module
    return _SPACES.sub(" ", str(getattr(module, macro)(**values))).strip(" ")


@cache
def _template(package: str, name: str) -> jinja2.Template:
    source = (resources.files(package) / "templates" / "texts" / f"{name}.txt").read_text(encoding="utf-8")
    return _environment().from_string(source)


@cache
def _environment() -> jinja2.Environment:
    # The page escapes its texts: here they are plain.
    environment = jinja2.Environment(autoescape=False, undefined=jinja2.StrictUndefined)
    environment.filters |= {
        "in": in_unit,
        "number": number,
        "quantity": quantity,
        "sentences": sentences,
        "largest": lambda values: max(abs(value) for value in values),
    }
    environment.globals["DEGREE"] = DEGREE
    return environment


def in_unit(value: float, unit: str, digits: int = 3) -> str:
    """A value in SI in a fixed unit: ``in_unit(0.0021, "mm")`` is "2.1 mm"."""
    return f"{value / _FACTORS.get(unit, 1.0):.{digits}g} {unit}"


def sentences(lines: Iterable[str]) -> str:
    """Lines as sentences."""
    return " ".join(f"{line[:1].upper()}{line[1:].rstrip('.')}." for line in lines)
