"""Statements of C as a tree, in which every local is declared where it is first needed."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from cabledrive.export.translation.types import Kind

Block = list["Node"]


@dataclass(eq=False)
class Node:
    """A statement: ``text``, or the head of the blocks inside it.

    ``target``: the local that it sets; ``value``: to what; ``pure``: whether the value changes nothing;
    ``loop``: whether its block is run many times.
    """

    text: str = ""
    target: str = ""
    value: str = ""
    pure: bool = True
    loop: bool = False
    blocks: list[Block] = field(default_factory=list)
    declared: str = ""

    def reads(self, name: str) -> bool:
        """Whether the statement itself, without its blocks, mentions a name other than to set it."""
        return mentions(self.text, name) or mentions(self.value, name)


def mentions(text: str, name: str) -> bool:
    """Whether a text holds an identifier."""
    return re.search(rf"\b{re.escape(name)}\b", text) is not None


def walk(block: Block) -> Iterator[Node]:
    """Every statement, in order."""
    for node in block:
        yield node
        for inner in node.blocks:
            yield from walk(inner)


def drop_unread(block: Block, names: set[str]) -> None:
    """Take out what is set and never read; a call that changes something stays."""
    changed = True
    while changed:
        changed = False
        for name in sorted(names):
            if any(node.reads(name) for node in walk(block)):
                continue
            for inner in _all_blocks(block):
                for node in [one for one in inner if one.target == name]:
                    changed = True
                    if node.pure:
                        inner.remove(node)
                    else:
                        node.text, node.target, node.value = f"(void){node.value};", "", ""


def _all_blocks(block: Block) -> Iterator[Block]:
    yield block
    for node in block:
        for inner in node.blocks:
            yield from _all_blocks(inner)


def declare(block: Block, types: dict[str, Kind], written: Callable[[str, Kind], str]) -> None:
    """Give every local its declaration, in the innermost block that holds it; ``written``: type in C."""
    for name, kind in types.items():
        _place(block, name, written(name, kind))


def _place(block: Block, name: str, kind: str) -> None:
    used = [node for node in block if _inside(node, name)]
    if not used:
        return
    first = used[0]
    if len(used) == 1 and first.blocks and not first.reads(name):
        inner = [one for one in first.blocks if any(_inside(node, name) for node in one)]
        if len(inner) == 1 and (not first.loop or _begins_by_setting(inner[0], name)):
            _place(inner[0], name, kind)
            return
    if first.target == name and not mentions(first.value, name):
        first.declared = kind
    else:  # set in branches: C wants it above them
        start = "NULL" if kind.endswith("*") else "false" if kind == "bool " else "0"
        block.insert(block.index(first), Node(text=f"{kind}{name} = {start};"))


def _inside(node: Node, name: str) -> bool:
    return any(one.target == name or one.reads(name) for one in walk([node]))


def _begins_by_setting(block: Block, name: str) -> bool:
    first = next(node for node in block if _inside(node, name))
    return first.target == name and not mentions(first.value, name)


def printed(block: Block, depth: int = 1) -> list[str]:
    """Lines of C."""
    lines, pad = [], "    " * depth
    for node in block:
        if node.target:
            lines.append(f"{pad}{node.declared}{node.target} = {node.value};")
        elif not node.blocks:
            lines.append(pad + node.text)
        else:
            lines.append(f"{pad}{node.text} {{")
            lines += printed(node.blocks[0], depth + 1)
            for other in node.blocks[1:]:
                if other:
                    lines.append(f"{pad}}} else {{")
                    lines += printed(other, depth + 1)
            lines.append(pad + "}")
    return lines
