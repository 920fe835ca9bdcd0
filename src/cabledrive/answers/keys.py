"""Keys of JSON that a result declares, with their kinds, and why a value may be absent."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import reduce
from math import isfinite
from typing import Any

from cabledrive.answers.figures import Row, inside, key_of

NOT_FINITE = "not a finite number"
HOLDING = ("", "object", "rows", "map")
"""Kinds of what has parts; the first is that of a class's attribute."""
_BRACES = re.compile(r"(\w+)\{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}")
"""A key and what its braces hold, braces inside included."""


@dataclass(frozen=True)
class Keys:
    """Keys of an object of JSON, declared once beside what makes it: they make the object and its schema.

    ``names``: attributes of the class ``of``, apart by blanks, as "key=name" where the key is another,
    "key=name.part" of a part of one; with "?" behind it where it is left out when there is nothing; "*": the
    figures that the result declares; "**": all its fields. Of a result that is made as a dictionary kinds
    stand before the keys, "text: motor number: torque speed?": text, note (left out where there is none),
    flag, count, number, numbers, texts, rows, object, map, any; braces hold the keys of an object, of each
    row or value of a map, which may be of a kind as well: "map: units=text". ``whys``: by key, inside too,
    why a value may be None, or the attribute that says so behind a point; ``parts``: likewise what is inside,
    keys, a class or several as a tuple; ``also``: other keys of the same object; ``figures``: figures for
    people that are keys as well, those behind points of the part that they lie in.
    """

    names: str
    whys: Mapping[str, str] = field(default_factory=dict)
    parts: Mapping[str, Any] = field(default_factory=dict)
    also: tuple["Keys", ...] = ()
    of: type = dict
    figures: tuple[Row, ...] = ()

    def __post_init__(self) -> None:
        found = {key: Keys(names, self.whys, self.parts) for key, names in _BRACES.findall(self.names)}
        parts = {**self.parts, **found}
        for key, part in parts.items():
            if isinstance(part, Keys) and (more := inside(self.figures, key)):
                parts[key] = replace(part, figures=tuple(dict.fromkeys((*part.figures, *more))))
        object.__setattr__(self, "parts", parts)
        object.__setattr__(self, "names", _BRACES.sub(r"\1", self.names))

    def __call__(self, own: Any) -> dict[str, Any]:
        """The object of a result; what is a dictionary already keeps its order and gets its reasons."""
        found: dict[str, Any] = {}
        if isinstance(own, Mapping):
            known = {key: (why, kind) for key, _, _, why, kind in self.each()}
            for key, value in own.items():
                why, kind = known.get(key, ("", ""))
                if value is not None or f"{key}_reason" in own or not (why or kind == "note"):
                    found[key] = self._inside(key, value)
                elif why:
                    found |= _absent(key, why)
            for other in self.also:
                found = other(found)
            return found
        missing = getattr(own, "missing", {})
        for key, name, optional, why, _ in self.each():
            value = reduce(_part, name.split("."), own)
            if optional and not value:
                continue
            why = missing.get(name, getattr(own, why[1:]) if why.startswith(".") else why)
            if isinstance(value, float) and not isfinite(value):
                value, why = None, why or NOT_FINITE
            found |= _absent(key, why) if value is None and why else {key: self._inside(key, value)}
        return found

    def _inside(self, key: str, value: Any) -> Any:
        part = self.parts.get(key)
        why, kind = next(((why, kind) for name, _, _, why, kind in self.each() if name == key), ("", ""))
        if kind == "map" and why and value:  # figures by free names
            lost = [name for name, one in value.items() if one is None]
            return {**value, **{f"{name}_reason": why for name in lost}}
        if not isinstance(part, Keys) or value is None or kind not in HOLDING:
            return value
        if isinstance(value, (list, tuple)):
            return [part(one) for one in value]
        if part.of is dict:
            many = kind == "map"
        else:  # a mapping of results, not one result that is plain already
            many = isinstance(value, Mapping) and all(isinstance(one, part.of) for one in value.values())
        return {name: part(one) for name, one in value.items()} if many else part(value)

    def each(self) -> Iterator[tuple[str, str, bool, str, str]]:
        """Key, attribute, whether it may be left out, why it may be None, kind of one without a class."""
        kind = ""
        for word in self.names.split():
            if word in ("*", "**"):
                for own in fields(self.of):
                    if own.compare if word == "**" else own.metadata.get("under"):
                        note, why = own.name.endswith("_reason"), own.metadata.get("why", "")
                        yield key_of(own), own.name, note, why, ""
            elif word.endswith(":"):
                kind = word[:-1]
            else:
                key, _, name = word.rstrip("?").partition("=")
                why = self.whys.get(key, "")
                yield key, name or key, word.endswith("?") or (kind == "note" and not why), why, kind
        for row in self.figures:
            if "." not in row.key:
                kind, why = "count" if row.form == "d" else row.kind.rstrip("?"), self.whys.get(row.key, "")
                yield row.key, row.key, row.kind.endswith("?") or (kind == "note" and not why), why, kind


def _absent(key: str, why: str) -> dict[str, Any]:
    return {key: None, f"{key}_reason": why}


def _part(own: Any, name: str) -> Any:
    """An attribute, or an item by its number."""
    return own[int(name)] if name.isdigit() else getattr(own, name)
