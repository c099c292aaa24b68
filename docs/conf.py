"""How the site is built: ``sphinx-build -W -n docs site`` after ``pip install ".[docs]"``."""

import sys
from pathlib import Path

import drystone

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
from reference import write_reference

project = "drystone"
author = "The drystone developers"
version = release = drystone.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["reference.py"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3

autodoc_typehints = "none"  # the signature has them
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

suppress_warnings = ["ref.python"]  # attributes of two classes may have one name

html_theme = "furo"
html_title = f"drystone {version}"
html_static_path: list[str] = []

write_reference(HERE / "reference")
