"""Pictures inside a notebook: a still one beside a value, and the page in a frame."""

from __future__ import annotations

import base64
import html
import tempfile
from pathlib import Path

from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.view.paper.figure import save_figure
from drystone.view.scenes.subjects import Subject, scene_of
from drystone.view.web.page import page_text

SIZE, DPI = (6.4, 4.4), 64
"""Of a still picture [inches], [pixels per inch]: 20 to 60 kB, half of the page at most."""

MOST_BLOCKS = 3000
"""Blocks of a model that is drawn unasked, chosen: it takes less than a second."""


class Frame(OneLine):
    """The page of a value, which a notebook shows in a frame: it turns and answers clicks.

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
        page = html.escape(page_text(self.scene))
        style = f"width:100%;height:{self.height}px;border:0"
        allowed = "allow-scripts allow-downloads"
        return f'<iframe srcdoc="{page}" sandbox="{allowed}" style="{style}"></iframe>'


def thumbnail(value: object) -> str:
    """A small still picture as an HTML image; nothing where there is none to be drawn."""
    try:
        scene = scene_of(value)  # type: ignore[arg-type]
    except InputError:
        return ""
    if len(scene.assembly) > MOST_BLOCKS:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "thumbnail.png"
        save_figure(scene, path, size=SIZE, dpi=DPI)
        data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="{html.escape(scene.title)}" src="data:image/png;base64,{data}">'


__all__ = ["Frame", "thumbnail"]
