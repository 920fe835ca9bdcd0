"""The texts around what is translated."""

from jinja2 import Environment, PackageLoader, StrictUndefined

from cabledrive.export.translation.literals import Precision
from cabledrive.export.translation.nodes import mentions

EXPONENTS = {False: ("uint64_t", "0x7ff0000000000000u"), True: ("uint32_t", "0x7f800000u")}


def templates() -> Environment:
    """The shells around translated kernels, and models in other languages."""
    return Environment(
        loader=PackageLoader("cabledrive.export"), undefined=StrictUndefined, keep_trailing_newline=True
    )


def runtime_text(precision: Precision, text: str) -> str:
    """The few functions below the kernels, those that a text uses."""
    word, exponent = EXPONENTS[precision.single]
    template = templates().get_template("runtime.c.jinja")
    return template.render(word=word, exponent=exponent, used=lambda name: mentions(text, name))
