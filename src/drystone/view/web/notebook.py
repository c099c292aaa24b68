"""Pictures in a notebook: the page of a value in a frame."""

from __future__ import annotations

import base64
import gzip
import html
import tempfile
import webbrowser
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.view.paper.figure import save_figure
from drystone.view.subjects import Subject, scene_of
from drystone.view.web.page import page_text, save_page

SIZE, DPI = (6.4, 4.4), 64
"""Size of a still picture [inches] and pixels per inch: 20 to 60 kB."""

MOST_BLOCKS = 3000
"""Largest number of blocks of a model that is drawn by default. Chosen: it takes less than a
second."""

MOST_BYTES = 200_000
"""Largest page that is shown by default [bytes]. Chosen: a notebook with 20 of them is 4 MB at
most. A larger one is replaced by a still picture."""

_UNPACKING = """<!doctype html><meta charset="utf-8"><body><script>
const packed = Uint8Array.from(atob("PACKED"), (letter) => letter.charCodeAt(0));
const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
new Response(stream).text().then((page) => {
  document.open();
  document.write(page);
  document.close();
});
</script>"""
"""A page that unpacks another page and replaces itself. Browsers support that since 2023."""

_ALLOWED = "allow-scripts allow-downloads"
"""Permissions of the page in its frame: it has no access to the notebook."""


class Frame(OneLine):
    """The page of a value in the frame of a notebook; it can be turned and clicked.

    Parameters
    ----------
    value
        A model, an assembly, a result, a limit, a plan, a settlement or a scene.
    height : [pixels]

    Raises
    ------
    InputError
        There is no picture of such a value.

    Examples
    --------
    >>> from drystone.models import tower
    >>> Frame(tower(3))._repr_html_()[:16]
    '<iframe srcdoc="'
    """

    def __init__(self, value: Subject, height: int = 480) -> None:
        self.scene, self.height = scene_of(value), height

    def _summary(self) -> str:
        return repr(self.scene)

    def _repr_html_(self) -> str:
        return _framed(packed(page_text(self.scene)), f"width:100%;height:{self.height}px")


def packed(page: str) -> str:
    """A page that unpacks ``page``: 52 kB instead of 135 for three blocks."""
    small = base64.b64encode(gzip.compress(page.encode("utf-8"), mtime=0)).decode("ascii")
    return _UNPACKING.replace("PACKED", small)


def _framed(page: str, style: str) -> str:
    """A page inside another one."""
    return (
        f'<iframe srcdoc="{html.escape(page)}" sandbox="{_ALLOWED}"'
        f' style="{style};border:0" title="drystone"></iframe>'
    )


def show(value: Subject, height: int = 480) -> None:
    """Show the page of a value: below the cell of a notebook, else in the browser.

    Parameters
    ----------
    value
        A model, an assembly, a result, a limit, a plan, a settlement or a scene.
    height : [pixels]
        In a notebook.

    Raises
    ------
    InputError
        There is no picture of such a value, or no browser; the error names the file then.
    """
    if in_notebook():
        import_module("IPython.display").display(Frame(value, height))
        return
    with tempfile.NamedTemporaryFile(prefix="drystone-", suffix=".html", delete=False) as file:
        path = Path(file.name)
    save_page(value, path)
    if not webbrowser.open(path.as_uri()):
        raise InputError("no browser was found", remedy=f"open {path} yourself")


def in_notebook() -> bool:
    """Whether this runs in a notebook."""
    if find_spec("IPython") is None:
        return False
    shell = import_module("IPython").get_ipython()
    return shell is not None and hasattr(shell, "kernel")


def beside(value: object) -> str:
    """The picture of a value: its page if that is small, else a still picture."""
    try:
        scene = scene_of(value)  # type: ignore[arg-type]
    except InputError:
        return ""
    if len(scene.assembly) > MOST_BLOCKS:
        return ""
    page = packed(page_text(scene))
    if len(page) <= MOST_BYTES:
        return _framed(page, "flex:1;min-width:20em;height:22em")
    return thumbnail(value)


def thumbnail(value: object) -> str:
    """A small still picture as an HTML image; empty if the value has none."""
    try:
        scene = scene_of(value)  # type: ignore[arg-type]
    except InputError:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "thumbnail.png"
        save_figure(scene, path, size=SIZE, dpi=DPI)
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="{html.escape(scene.title)}" src="data:image/png;base64,{data}">'
