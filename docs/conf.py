"""Sphinx configuration: MyST pages, reference from the docstrings, nothing fetched from a network."""

import os
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))
os.environ["NUMBA_DISABLE_JIT"] = "1"  # a compiled kernel has no signature that autodoc could show

project = "cabledrive"
author = "cabledrive developers"
copyright = "2026, cabledrive developers"
version = release = installed_version("cabledrive")

extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "mathml", "reference"]
exclude_patterns = ["_ext"]

myst_enable_extensions = ["amsmath", "attrs_block", "attrs_inline", "deflist", "dollarmath"]
myst_heading_anchors = 3

add_module_names = False  # the page and its headings name them
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings state types with shapes and units
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 90
numpydoc_show_class_members = False

suppress_warnings = ["ref.citation"]  # References at the end of a docstring need not be cited above

html_theme = "furo"
html_math_renderer = "mathml"
html_title = f"cabledrive {release}"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_show_sphinx = False
html_copy_source = False
html_show_sourcelink = False
