"""Tests that a page of the documentation names."""

import re

SPAN = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
TEST = re.compile(r"((?:tests|reproduction|tools)/[\w/]+\.py)?(?:::(\w+))?")


def named_tests(text):
    """Files and functions; one without a file is of the line's file, or of the one named for its table."""
    common = re.search(r"`(tests/\S+)` unless another test is named", text)
    for line in text.splitlines():
        file = common[1] if common else ""
        for span in SPAN.findall(line):
            if (found := TEST.fullmatch(span)) and any(found.groups()):
                file = found[1] or file
                yield file, found[2]
