"""The gallery: examples that are run when the site is built, with figures and pages in them."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from drystone.view import Frame, save_figure

HERE = Path(__file__).parent
SHOWN: set[int] = set()
"""Figures that stand in the page of an example already."""


def figures(_: Any, variables: dict[str, Any], settings: dict[str, Any]) -> str:
    """Images of the figures that a block of an example has made.

    The first page in a frame is drawn too: the overview of the gallery shows the first image.
    """
    made = []
    for value in variables["example_globals"].values():
        if isinstance(value, Figure) and id(value) not in SHOWN:
            SHOWN.add(id(value))
            path = next(variables["image_path_iterator"])
            value.savefig(path, dpi=100.0, bbox_inches="tight")
            made.append(path)
    last = variables["example_globals"].get("___")
    if isinstance(last, Frame) and len(variables["image_path_iterator"]) == 0:
        save_figure(last.scene, next(variables["image_path_iterator"]), size=(5.6, 4.0), dpi=100.0)
    return figure_rst(made, settings["src_dir"])


def _get_sg_image_scraper() -> Any:
    """The name under which sphinx-gallery asks a module for its scraper."""
    return figures


SETTINGS = {
    "examples_dirs": str(HERE.parents[1] / "examples" / "gallery"),
    "gallery_dirs": "gallery",
    "backreferences_dir": "gallery/uses",
    "doc_module": ("drystone",),
    "filename_pattern": "/plot_",
    "within_subsection_order": "FileNameSortKey",
    "capture_repr": ("_repr_html_", "__repr__"),
    "image_scrapers": ("gallery",),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "reset_modules": (),
    "write_computation_times": False,
}
