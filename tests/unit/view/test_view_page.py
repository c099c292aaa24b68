from __future__ import annotations

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.contacts import Contacts
from drystone.models import box, tower
from drystone.view import Layer, LayerKind, Scene, SceneStage, State, page_text, save_page, scene_of
from drystone.view.page import SCRIPTS
from tests.unit.view.pictures import (
    EVIL,
    falling_tower,
    l_block,
    notched,
    page_data,
    pulled_tower,
    stacked,
)


def rebuilt(blocks: dict[str, np.ndarray]) -> list[tuple[np.ndarray, list[tuple[int, ...]]]]:
    """Vertices and faces of each block, from the flat arrays of a page."""
    points = np.split(blocks["point"], np.cumsum(blocks["points"])[:-1])
    loops = np.split(blocks["loop"], np.cumsum(blocks["corners"])[:-1])
    faces, done = [], 0
    for count in blocks["faces"]:
        faces.append([tuple(loop.tolist()) for loop in loops[done : done + count]])
        done += count
    return list(zip(points, faces, strict=True))


def test_the_page_holds_every_block_with_its_polygon_faces() -> None:
    assembly = notched()
    data = page_data(page_text(scene_of(assembly)))
    origin = np.array(data["origin"])
    for block, (points, faces) in zip(assembly.blocks, rebuilt(data["blocks"]), strict=True):
        assert np.abs(points + origin - block.vertices).max() < 1e-6
        assert tuple(faces) == block.faces
    assert data["blocks"]["names"] == list(assembly.names)
    assert data["blocks"]["mass"] == pytest.approx(assembly.mass)


def test_a_model_far_away_is_as_exact_as_one_at_the_origin() -> None:
    near = page_data(page_text(scene_of(notched())))["blocks"]["point"]
    moved = notched().transformed(translation=(1e4, -1e4, 250.0))
    far = page_data(page_text(scene_of(moved)))["blocks"]["point"]
    assert np.abs(near - far).max() < 1e-6


def test_triangles_fill_faces_and_edges_are_those_of_polygons() -> None:
    blocks = page_data(page_text(scene_of(Assembly((l_block(),)))))["blocks"]
    assert len(blocks["triangle"]) == sum(blocks["corners"] - 2)
    assert blocks["edges"].tolist() == [18]
    assert {tuple(sorted(e)) for e in blocks["edge"].tolist()} >= {(0, 1), (2, 3), (0, 6)}


def test_forces_and_motion_arrive_unchanged() -> None:
    result = pulled_tower()
    data = page_data(page_text(scene_of(result)))
    stage = data["stages"][0]
    assert stage["normal"] == pytest.approx(result.resultants.normal)
    assert stage["tangential"] == pytest.approx(result.resultants.tangential)
    assert stage["utilisation"] == pytest.approx(result.utilisation)
    layers = {layer["key"]: layer for layer in stage["layers"]}
    assert layers["pressure"]["vector"] == pytest.approx(result.world_force()[:7])
    force = layers["joint-force"]
    assert force["value"] == pytest.approx(np.maximum(result.force[:, 0], 0.0))
    assert force["top"] == 3000.0
    assert layers["tension"]["vector"] == pytest.approx(np.array([[0.0, 0.0, 500.0]]))
    assert layers["tension"]["inward"]
    assert layers["resultants"]["vector"] == pytest.approx(result.resultants.force)
    position = layers["resultants"]["position"] + np.array(data["origin"])
    assert position == pytest.approx(result.resultants.position, abs=1e-6)


def test_what_falls_is_shown_with_its_motion_and_without_forces() -> None:
    result = falling_tower()
    stage = page_data(page_text(scene_of(result)))["stages"][0]
    assert stage["state"].tolist() == [State.SUPPORT, State.FREE, State.FALLING]
    assert stage["motion"] == pytest.approx(result.mechanism)
    assert stage["plays"]
    assert stage["normal"] is None
    assert {layer["key"] for layer in stage["layers"]} <= {"interfaces", "hinges", "sliding"}


def test_the_headline_says_the_verdict_and_how_many_fall() -> None:
    stage = page_data(page_text(scene_of(falling_tower())))["stages"][0]
    assert stage["headline"] == "Falls: block 'top'"
    assert stage["message"] == "The top falls."
    assert stage["role"] == "bad"


def test_only_props_worth_having_are_shown() -> None:
    prop = np.zeros((3, 6))
    prop[1, 2], prop[2, 2] = 0.5, 20_000.0
    result = replace(falling_tower(), prop=prop)
    shown = page_data(page_text(scene_of(result)))["stages"][0]["prop"]
    assert shown[:, 2].tolist() == [0.0, 0.0, 20_000.0]


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        self.links += [v or "" for k, v in attrs if k in ("src", "href")]
        assert not any(name.startswith("on") for name, _ in attrs)


def test_a_name_that_looks_like_markup_is_harmless() -> None:
    plain, evil = Tags(), Tags()
    plain.feed(page_text(scene_of(falling_tower())))
    text = page_text(scene_of(falling_tower(("foot", EVIL, "top \ud800"))))
    evil.feed(text)
    assert evil.seen == plain.seen
    assert page_data(text)["blocks"]["names"][1] == EVIL
    assert "<b onclick" not in text


def test_the_page_asks_nothing_of_the_network() -> None:
    text = page_text(scene_of(falling_tower()))
    text = text.replace("http://www.w3.org/2000/svg", "")  # the name of a format, never asked for
    assert not re.search(r"https?://|//[a-z0-9.-]+\.[a-z]{2,}|@import|\burl\((?!#)", text)
    assert not re.search(r"\b(fetch|XMLHttpRequest|WebSocket|importScripts|sendBeacon)\b", text)
    assert "default-src 'none'" in text
    tags = Tags()
    tags.feed(text)
    assert tags.links == ["data:,"]


def test_no_script_can_end_its_own_element() -> None:
    static = resources.files("drystone.view").joinpath("static")
    names = {entry.name for entry in static.iterdir()}
    assert names == {*SCRIPTS, "page.css", "page.html", "unpacking.html", "widget.js"}
    for name in (*SCRIPTS, "widget.js"):
        text = static.joinpath(name).read_text(encoding="utf-8")
        assert "</script" not in text.lower()
        assert "innerHTML" not in text
        assert "{{" not in text


def test_every_control_has_a_name_for_those_who_cannot_see_it() -> None:
    text = page_text(scene_of(falling_tower()))
    for tag in re.findall(r"<(?:input|canvas|section|aside)\b[^>]*>", text):
        if 'aria-hidden="true"' in tag:
            continue
        label = re.search(r'id="([^"]+)"', tag)
        assert "aria-label" in tag or (label and f'for="{label.group(1)}"' in text), tag


def test_stages_play_an_assembly_sequence() -> None:
    assembly = tower(3)
    contacts = stacked([1.0, 2.0], (0.0, 0.0, 1.0, 1.0))
    states = [
        [State.SUPPORT, State.ABSENT, State.ABSENT],
        [State.SUPPORT, State.PROPPED, State.ABSENT],
        [State.SUPPORT, State.FREE, State.HELD],
    ]
    missed = Layer(
        "missed", "missed contacts", LayerKind.POLYGONS, "missed",
        contacts.point, start=contacts.start,
    )  # fmt: skip
    stages = tuple(
        SceneStage(f"step {i}", "", "", np.array(s), layers=(missed,)) for i, s in enumerate(states)
    )
    data = page_data(page_text(Scene(assembly, contacts, stages, "sequence")))
    assert [stage["state"].tolist() for stage in data["stages"]] == states
    assert {str(int(s)) for row in states for s in row if s} <= set(data["states"])
    layer = data["stages"][2]["layers"][0]
    assert layer["colour"] == "missed"
    assert layer["triangle"].tolist() == [[0, 1, 2], [0, 2, 3]] * 2
    again = sum(json.dumps(s, default=str).count("missed") for s in data["stages"])
    assert again >= 3


def test_equal_arrays_are_stored_once() -> None:
    contacts = stacked([1.0, 2.0], (0.0, 0.0, 1.0, 1.0))
    stage = SceneStage("s", "", "", np.full(3, State.FREE))
    one = len(page_text(Scene(tower(3), contacts, (stage,))))
    layer = Layer("l", "l", LayerKind.POLYGONS, "missed", contacts.point, start=contacts.start)
    with_one = SceneStage("s", "", "", np.full(3, State.FREE), layers=(layer,))
    two = page_text(Scene(tower(3), contacts, (with_one, with_one)))
    assert two.count('"triangle":{"blob":') == 3
    assert len(two) - one < 1500


def test_a_wall_of_two_thousand_blocks_stays_small() -> None:
    blocks = tuple(
        box((1.0, 0.5, 0.5), (i + 0.5 * (k % 2), 0.0, 0.5 * k), f"b{k}-{i}")
        for k in range(40)
        for i in range(50)
    )
    text = page_text(scene_of(Assembly(blocks)))
    assert len(text) < 150 * len(blocks) * 3


def test_contacts_of_another_model_are_refused() -> None:
    contacts = stacked([1.0, 2.0], (0.0, 0.0, 1.0, 1.0))
    with pytest.raises(InputError, match="blocks that the assembly does not have"):
        scene_of(tower(2), contacts)
    with pytest.raises(InputError, match="a result has its own"):
        scene_of(falling_tower(), contacts)
    result = falling_tower()
    assert scene_of(result, result.contacts).contacts is result.contacts


def test_a_layer_with_an_unknown_colour_is_refused() -> None:
    with pytest.raises(InputError, match="choose one of"):
        Layer("x", "x", LayerKind.LINES, "mauve", np.zeros((1, 3)), np.zeros((1, 3)))


def test_the_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    path = tmp_path / "model.html"
    path.write_text("old")
    save_page(tower(2), path, Contacts.empty())
    assert path.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(InputError, match="cannot be written"):
        save_page(tower(2), tmp_path / "missing" / "model.html")
