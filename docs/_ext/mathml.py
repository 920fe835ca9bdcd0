"""Formulas as MathML, made while the pages are built: shown without a script and without a network."""

import re
from html import unescape
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import SphinxError
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator

SAME = {r"\dots": r"\ldots", r"\big": r"\bigl", r"\Big": r"\Bigl", r"\bigg": r"\biggl", r"\Bigg": r"\Biggl"}

NAMESPACE = "http://www.w3.org/1998/Math/MathML"
ACCENTS = set("\u02d9\u00a8\u02c6~\u02c9\u00af\u2192^")  # dots, hat, tilde, bars, arrow

NAMED = re.compile(r"&(?!(?:amp|lt|gt|quot);)[A-Za-z]+;")  # entities that HTML knows and XML does not


def mathml(latex: str, block: bool) -> str:
    """One formula; names that the converter lacks are replaced by those it knows."""
    known = re.sub(r"\\[A-Za-z]+", lambda name: SAME.get(name[0], name[0]), latex)
    known = re.sub(r"\\tag\{([^}]*)\}", r"\\qquad \\text{(\1)}", known)
    known = re.sub(r"(\\[dt]?frac)(\d)(\d)", r"\1{\2}{\3}", known)  # else \frac12 is 12 over what follows
    if block and (r"\\" in known or "&" in known) and r"\begin{" not in known:
        known = rf"\begin{{aligned}}{known}\end{{aligned}}"
    try:
        return subscripts_beside(str(tex2mathml(known, as_block=block)))
    except MathError as error:
        raise SphinxError(f"formula not understood: {error}\n{latex}") from error


def subscripts_beside(text: str) -> str:
    """The converter puts the subscript of an accented letter under it; here it goes beside it."""
    ElementTree.register_namespace("", NAMESPACE)
    root = ElementTree.fromstring(NAMED.sub(lambda name: unescape(name[0]), text))
    for node in root.iter(f"{{{NAMESPACE}}}munderover"):
        base, below, above = list(node)
        if (above.text or "").strip() in ACCENTS:
            accented = ElementTree.Element(f"{{{NAMESPACE}}}mover", accent="true")
            accented.extend([base, above])
            for child in (base, below, above):
                node.remove(child)
            node.tag = f"{{{NAMESPACE}}}msub"
            node.extend([accented, below])
    return ElementTree.tostring(root, encoding="unicode")


def visit_inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(mathml(node.astext(), block=False))
    raise nodes.SkipNode


def visit_block(self: HTML5Translator, node: nodes.math_block) -> None:
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if node["number"]:
        self.body.append(f'<span class="eqno">({get_node_equation_number(self, node)})</span>')
    self.body.append(mathml(node.astext(), block=True) + "</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
