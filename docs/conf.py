"""How the site is built: ``sphinx-build -W docs build/site`` after ``pip install ".[docs]"``."""

import re
import sys
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util.nodes import make_refnode

import drystone

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "site"))
import gallery
from reference import write_reference

project = "drystone"
author = "The drystone developers"
version = release = drystone.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["gallery/GALLERY_HEADER.rst"]
sphinx_gallery_conf = gallery.SETTINGS
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3

autodoc_typehints = "none"  # the signature has them
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

nitpicky = True  # a reference to nothing is a warning, and with -W an error; classes: see below
nitpick_ignore_regex = [("py:class", ".*")]
"""Shapes, units, and types that are not public, in the place where Sphinx expects a class."""
nitpick_ignore = [("py:exc", "Stopped")]
"""Not public: it ends a search early and is caught before it reaches a caller."""

suppress_warnings = ["ref.python"]  # attributes of two classes may have one name

html_theme = "furo"
html_title = f"drystone {version}"
html_static_path: list[str] = []

html_math_renderer = "mathml"  # read by every browser, without a script from elsewhere


def inline_math(self, node):
    """A formula in a line."""
    self.body.append(tex2mathml(node.astext()))
    raise SkipNode


def display_math(self, node):
    """A formula of its own."""
    self.body.append(tex2mathml(node.astext(), as_block=True))
    raise SkipNode


def by_last_name(app, env, node, content):
    """A reference to a public name by its last part: ``plan`` for drystone.plan."""
    if node.get("refdomain") != "py":
        return None
    last, objects = node["reftarget"].rsplit(".", 1)[-1], env.domains["py"].objects
    found = {o.node_id: o for name, o in objects.items() if name.rsplit(".", 1)[-1] == last}
    if len(found) != 1:
        return None
    (one,) = found.values()
    return make_refnode(app.builder, node["refdoc"], one.docname, one.node_id, content, last)


def without_links(*event):
    """Links of an included file to files that are not part of the site, as plain words."""
    content = event[-1]
    content[0] = re.sub(r"\[([^]]+)\]\((?!docs/|https?:)[^)]*\)", r"\1", content[0])


def setup(app: Sphinx) -> None:
    """What Sphinx calls when the site is built."""
    app.connect("include-read", without_links)
    app.connect("missing-reference", by_last_name)
    app.add_html_math_renderer("mathml", (inline_math, None), (display_math, None))
    write_reference(HERE / "reference" / "api")
