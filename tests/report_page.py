"""The report of a few drives, made once in a process, and a reader of its HTML."""

from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cache
from html.parser import HTMLParser

from cabledrive.parameters import load_drive
from cabledrive.report import report_html

DRIVES = ("dissertation-1", "camera-line")
TIME = datetime(2020, 2, 3, 4, 5, 6, tzinfo=UTC)
VOID = {"meta", "link", "br", "img", "hr", "input"}


@cache
def page(*names):
    """The report of packaged drives, of two very different ones by default."""
    return report_html([load_drive(name).listed for name in names or DRIVES], written_at=TIME)


@dataclass
class Element:
    """An element of the page with what is inside it."""

    tag: str
    attributes: dict[str, str]
    children: list["Element"] = field(default_factory=list)
    words: list[str] = field(default_factory=list)

    def all(self, tag):
        """Every element of a kind below this one, in order."""
        found = []
        for child in self.children:
            found += [child] if child.tag == tag else []
            found += child.all(tag)
        return found

    @property
    def text(self):
        """All words in it, one space between them."""
        return " ".join(" ".join(self.words).split())


class Reader(HTMLParser):
    """Reads a page strictly: an end tag that does not close the last open element is an error."""

    def __init__(self, text):
        super().__init__()
        self.root = Element("page", {})
        self._open = [self.root]
        self.faults: list[str] = []
        self.feed(text)
        self.close()
        self.faults += [f"<{element.tag}> never closed" for element in self._open[1:]]

    def handle_starttag(self, tag, attrs):
        names = [name for name, _ in attrs]
        if len(set(names)) < len(names):
            self.faults.append(f"{self.getpos()}: <{tag}> has an attribute twice")
        element = Element(tag, {name: value or "" for name, value in attrs})
        self._open[-1].children.append(element)
        if tag not in VOID:
            self._open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag):
        if self._open[-1].tag != tag:
            self.faults.append(f"{self.getpos()}: </{tag}> closes <{self._open[-1].tag}>")
        else:
            self._open.pop()

    def handle_data(self, data):
        for element in self._open:
            element.words.append(data)


@cache
def read(*names):
    return Reader(page(*names))
