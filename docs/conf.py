"""Configuration of Sphinx; `make docs` builds the site."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_extensions")]

import turbine_fenicsx  # noqa: E402

project = "turbine_fenicsx"
author = "the turbine_fenicsx authors"
copyright = author
version = release = turbine_fenicsx.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",  # the files of MathJax, so that pages need no network
    "docstrings",
    "generated",
]
exclude_patterns = ["_build"]
# Formulas carry the numbers of the paper by \tag.
myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 4

# Docstrings: Google style; one pair of backticks names something of the package, see docstrings.py.
default_role = "named"
highlight_language = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "ignore-module-all": True}
autodoc_typehints = "signature"
autodoc_type_aliases = {"Array": "Array", "BoolArray": "BoolArray", "Points": "Points"}
toc_object_entries_show_parents = "hide"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_numpy_docstring = False
napoleon_use_ivar = True

# Every name of this package that is linked to must exist, except private types in signatures.
# Names of other packages are not looked up, which would need the network.
nitpicky = True
nitpick_ignore_regex = [
    ("py:.*", r"(?!turbine_fenicsx\.).*"),
    ("py:class", r"turbine_fenicsx\..*\.(_\w+|[A-Z])"),
    (
        "py:class",
        r"turbine_fenicsx\.case\.(quantities\.require_number|section\.check_names)",
    ),  # checks, no classes
    # type variables, and types whose marks are no classes
    (
        "py:class",
        r"turbine_fenicsx\.foundation\.memo\.Value",
    ),
    (
        "py:class",
        r"turbine_fenicsx\.case\.(contradictions\.Method|files\.Result|mistakes\.Model)",
    ),
    ("py:class", r"turbine_fenicsx\..*\.Annotated\[.*"),
]

html_theme = "pydata_sphinx_theme"
html_title = f"turbine_fenicsx {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_sidebars = {
    "index": [],
    "tutorial": [],
    "paper": [],
    "verification": [],
}  # they have no pages below them
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": True,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
