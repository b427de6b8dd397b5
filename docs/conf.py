"""How Sphinx builds the documentation: `make docs`, with every warning an error and nothing from the network."""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from pipeline.summary.versions import package_version  # noqa: E402  # found by the line above

project = "Gantry-Tau"
author = "The Gantry-Tau pipeline authors"
copyright = f"2026 {author}"  # noqa: A001  # Sphinx's own name
release = version = package_version()

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "from_code.sphinx_generated",
    "from_code.sphinx_mathml",
]
exclude_patterns = ["from_code"]
nitpicky = True
# Types are written as people read them, "array (n, 5)"; names of ours have to be there: see `from_code`.
nitpick_ignore_regex = [(r"py:.*", r"(?!pipeline\.[a-z_]+$).*")]

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 4
suppress_warnings = ["myst.strikethrough"]

default_role = "literal"
smartquotes = False  # "--" and quotes in prose belong to commands
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
add_module_names = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

html_theme = "furo"
html_title = f"Gantry-Tau {release}"
html_static_path = ["static"]
html_css_files = ["wide_tables.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
