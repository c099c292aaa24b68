"""Contacts and near misses on the page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from drystone.assembly import Assembly
from drystone.detection import find_contacts
from drystone.geometry.frames import rotation_about
from drystone.io import Inspection
from drystone.models import box, tower
from drystone.view import page_text, save_page

SLAB = box((4.0, 4.0, 0.5), (-2.0, -2.0, -0.5), "slab")


def test_near_misses_are_drawn_in_their_colour() -> None:
    model = Assembly((SLAB, box((1.0, 1.0, 1.0), (0.0, 0.0, 0.01), "cube")))
    scene = Inspection(model, find_contacts(model)).layers()
    missed = next(layer for layer in scene.stages[0].layers if layer.key == "missed")
    assert missed.colour == "missed"
    np.testing.assert_allclose(missed.position[:, 2], 0.005, atol=1e-12)
    assert "near misses" in page_text(scene)


def test_what_touches_is_not_missed() -> None:
    model = tower(3)
    keys = {
        layer.key for layer in Inspection(model, find_contacts(model)).layers().stages[0].layers
    }
    assert keys == {"interfaces"}


def test_line_contacts_are_drawn_as_lines() -> None:
    cube = box((1.0, 1.0, 1.0)).transformed(rotation_about([1.0, 0.0, 0.0], 45.0))
    model = Assembly((SLAB, cube))
    layers = Inspection(model, find_contacts(model)).layers().stages[0].layers
    lines = next(layer for layer in layers if layer.key == "lines")
    assert lines.vector is not None
    np.testing.assert_allclose(np.linalg.norm(lines.vector, axis=1), 1.0)


def test_the_whole_report_stands_beside_the_picture(tmp_path: Path) -> None:
    cubes = [box((1.0, 1.0, 1.0), (1.1 * i - 2.0, 0.0, 0.009 + 0.01 * i), f"c{i}") for i in (0, 1)]
    model = Assembly((SLAB, *cubes))
    found = find_contacts(model)
    save_page(Inspection(model, found), tmp_path / "page.html")
    _, panel = (tmp_path / "page.html").read_text(encoding="utf-8").split("Contact search", 1)
    for line in found.report.summary():
        assert f"<p>{line}</p>" in panel
    message = Inspection(model, found).layers().stages[0].message
    assert message.split("; ")[1] == f"suggestion: {found.report.suggestions()[0]}"
