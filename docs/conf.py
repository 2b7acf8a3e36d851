"""Build of the documentation as a site: `python -m sphinx -W -b html docs site`."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "adapters"), str(ROOT / "tools")]

from mossar_stream import __version__  # noqa: E402 - found by the line above

project = "mossar-stream"
author = "The mossar-stream authors"
project_copyright = author
version = release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["cuts"]
nitpicky = False  # types of numpy and msgspec have no page here
default_role = "code"  # docstrings name things as Markdown does
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4

autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints = "signature"
napoleon_google_docstring = True
napoleon_numpy_docstring = False

html_theme = "furo"
html_title = "mossar-stream"
html_static_path: list[str] = []
html_show_sphinx = False
