"""How the site is built: ``sphinx-build -W docs build/site`` after ``pip install ".[docs]"``."""

import html
import inspect
import os
import re
import sys
from itertools import takewhile
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.ext.napoleon import NumpyDocstring
from sphinx.util.inspect import stringify_signature
from sphinx.util.nodes import make_refnode

import drystone

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "site"))
import gallery
from buttons import buttons
from reference import described, linked, section, write_reference

project = "drystone"
author = "The drystone developers"
copyright = f"2026, {author}"
version = release = drystone.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["gallery/GALLERY_HEADER.rst"]
sphinx_gallery_conf = gallery.SETTINGS
myst_enable_extensions = ["dollarmath", "deflist", "substitution"]
myst_heading_anchors = 3

autodoc_typehints = "none"  # the signature has them
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = [("Columns", "params_style")]
napoleon_use_rtype = False

nitpicky = True  # a reference to nothing is a warning, and with -W an error; classes: see below
nitpick_ignore_regex = [("py:class", ".*")]
"""Shapes, units, and types that are not public, in the place where Sphinx expects a class."""
nitpick_ignore = [("py:exc", "Stopped")]
"""Not public: it ends a search early and is caught before it reaches a caller."""

suppress_warnings = ["ref.python"]  # attributes of two classes may have one name

html_theme = "furo"
html_title = f"drystone {version}"
html_favicon = "images/favicon.svg"
html_static_path = ["site/site.css", "images/vault.png", "images/film.mp4"]
html_css_files = ["site.css"]
repository = os.environ.get("GITHUB_REPOSITORY", "")
"""OWNER/NAME, where a workflow of GitHub builds the site."""
owner, _, name = repository.partition("/")
html_baseurl = os.environ.get("DRYSTONE_SITE") or (
    f"https://{owner.lower()}.github.io/{name}/" if name else ""
)
"""The address of the site: pictures of links need it."""
myst_substitutions = {"buttons": buttons(repository)}
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = False

html_math_renderer = "mathml"  # read by every browser, without a script from elsewhere


def inline_math(self, node):
    """A formula in a line."""
    self.body.append(tex2mathml(node.astext()))
    raise SkipNode


def display_math(self, node):
    """A formula of its own."""
    self.body.append(tex2mathml(node.astext(), as_block=True))
    raise SkipNode


def social(*event):
    """What a link to a page shows elsewhere: its title, and the picture of a vault."""
    context = event[3]
    title = re.sub("<[^>]*>", "", context.get("title") or project)
    tags = {
        "title": f"{title} - {project}",
        "type": "website",
        "site_name": project,
        "description": "Does a structure of loose blocks stand by contact and friction alone?",
    }
    if html_baseurl:  # nobody follows the address of a picture that is not whole
        tags["image"] = html_baseurl.rstrip("/") + "/_static/vault.png"
        tags["image:alt"] = "A vault of 97 blocks that stands, with the force in every joint"
    context["metatags"] = context.get("metatags", "") + "".join(
        f'<meta property="og:{key}" content="{html.escape(value)}" />\n'
        for key, value in tags.items()
    )


def whole_description(*event):
    """Of a property or a field: a first line with a colon is no type, and it may have sections."""
    app, what, name, value, options, lines = event
    if what in ("attribute", "data", "property"):
        text = NumpyDocstring(lines, app.config, app, "method", name, value, options)
        lines[:] = ["..", "", *str(text).splitlines()]  # the comment hides the first line


def each_attribute(*event):
    """Attributes that are described together, one by one: else the second is shown as a type."""
    lines, told, within = event[-1], [], False
    for at, line in enumerate(lines):
        if at + 1 < len(lines) and re.fullmatch("-{3,}", lines[at + 1]):
            within = line == "Attributes"
        names, colon, kind = line.partition(" : ")
        if within and re.fullmatch(r"\w+(, \w+)+", names):
            rest = list(takewhile(lambda one: one[:1] == " ", lines[at + 1 :]))
            *others, line = [f"{one}{colon}{kind}" for one in names.split(", ")]
            told += [part for one in others for part in (one, *rest)]
        told.append(line)
    lines[:] = told


def back_from_code(*event):
    """Links from a page of source back to the reference, where names are public ones."""
    app, page, _, context, _ = event
    if not page.startswith("_modules/"):
        return
    places = [(o.docname, place) for place, o in app.env.domains["py"].objects.items()]

    def mended(match):
        document, name = match[2].lstrip("./"), match[3].split(".")
        ends = ["." + ".".join(name[part:]) for part in range(1, len(name))]
        found = [p for end in ends for d, p in places if d == document and p.endswith(end)]
        return f"{match[1]}{match[2]}.html#{found[0] if found else match[3]}"

    context["body"] = re.sub(
        r'(class="viewcode-back" href=")([^"#]*)\.html#([^"]*)', mended, context["body"]
    )


def shared_parameters(*event):
    """Parameters of a function, all of them and in its order."""
    _, what, _, called, _, lines = event
    if what == "function" and "Parameters" in lines:
        begin, end = section(lines)
        told = described(called, lines).values()
        lines[begin:end] = [*(line for one in told for line in one), ""]


def own_arguments(*event):
    """The signature of a class: autodoc finds that of its base, which takes and checks any."""
    _, what, _, called, _, signature, _ = event
    if what != "class" or not (signature or "").startswith("(*_"):
        return None
    return stringify_signature(inspect.signature(called), show_annotation=False), None


def returned(*event):
    """What a function gives that does not say it: its annotation, with links."""
    _, what, _, called, _, lines = event
    if what not in ("function", "method") or "Returns" in lines or "Yields" in lines:
        return
    plain = inspect.unwrap(called)
    told = linked(inspect.signature(plain).return_annotation, plain)
    if ":class:" in told:
        rules = [i - 1 for i, line in enumerate(lines) if re.fullmatch("-{3,}", line)]
        after = [i for i in rules if lines[i] in ("Raises", "Notes", "Examples", "See Also")]
        at = after[0] if after else len(lines)
        lines[at:at] = ["", "Returns", "-------", told, ""]


def written_in(*event):
    """The module in which a function is written that a package exports, for its source."""
    _, package, name = event
    found = getattr(sys.modules.get(package), name, None)
    plain = inspect.unwrap(found) if callable(found) else None
    return plain.__globals__["__name__"] if inspect.isfunction(plain) else None


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


def rows_stay(*event):
    """Of what commands print sentences break their lines, rows of tables do not."""
    row, left_out = r'<span class="go"> .*</span>\n', r'<span class="go">\.\.\.</span>\n'
    context, rows = event[3], rf"{row}(?:(?:{left_out})?{row})*"
    body = context.get("body", "")
    context["body"] = re.sub(rows, lambda x: f'<span class="rows">{x[0][:-1]}</span>\n', body)


def without_links(*event):
    """Links of an included file to files that are not part of the site, as plain words."""
    content = event[-1]
    content[0] = re.sub(r"\[([^]]+)\]\((?!docs/|https?:)[^)]*\)", r"\1", content[0])


def setup(app: Sphinx) -> None:
    """What Sphinx calls when the site is built."""
    app.connect("include-read", without_links)
    app.connect("autodoc-process-signature", own_arguments)
    app.connect("autodoc-process-docstring", each_attribute, priority=390)
    app.connect("autodoc-process-docstring", whole_description, priority=400)
    app.connect("autodoc-process-docstring", shared_parameters, priority=400)
    app.connect("autodoc-process-docstring", returned, priority=395)
    app.connect("viewcode-follow-imported", written_in)
    app.connect("html-page-context", social)
    app.connect("html-page-context", back_from_code)
    app.connect("html-page-context", rows_stay)
    app.connect("missing-reference", by_last_name)
    app.add_html_math_renderer("mathml", (inline_math, None), (display_math, None))
    write_reference(HERE / "reference" / "api")
