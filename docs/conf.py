"""The documentation as a site that needs no network: Sphinx with MyST, equations as MathML, fonts of the system."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent / "src")]

from kinemark.version import __version__

project = "Kinemark"
author = "the Kinemark developers"
copyright = "the Kinemark developers, Apache License 2.0"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "api",
    "benchmarks",
    "bibliography",
    "commands",
    "findings",
    "mathml",
    "methods",
    "offline",
]
exclude_patterns = ["_build", "_ext", "_generated"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
nitpicky = False

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
suppress_warnings = ["ref.python"]  # parts may use one short name each for a thing of their own
add_module_names = False

html_theme = "furo"
html_title = f"Kinemark {version}"
html_show_sourcelink = False
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_theme_options = {"source_view_link": "", "top_of_page_buttons": []}
