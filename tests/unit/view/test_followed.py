"""Scenes of blocks that were followed, and pages of very many blocks."""

from __future__ import annotations

import base64

import numpy as np
import pytest

import drystone
from drystone.answer.scene import State
from drystone.base.errors import InputError
from drystone.models import arch, box, tower, wedge
from drystone.settlement import Carrier, SettlementOptions, move_supports
from drystone.view import Scene, SceneStage, scene_of
from drystone.view import encode as encoding
from drystone.view.encode import LEFT_OUT, encode


def test_a_structure_that_settles_is_said_to_stand() -> None:
    # "stands for 0 of 1 tried" was the head of a picture of it
    hooked = wedge("c")
    load = drystone.LoadCase.tilt(hooked, (1.0, 0.0, 0.0), 40.0)
    options = drystone.CheckOptions(settlement=SettlementOptions(carrier=Carrier.MOVING))
    found = drystone.check(drystone.Model.of(hooked, friction=0.84, load=load), options=options)
    assert found.stable
    assert found.settlement is not None
    assert scene_of(found).stages[0].headline.startswith("Stands after settling")


def test_a_fall_that_was_followed_plays_its_positions():
    settled = drystone.settle(drystone.Model.of(arch(0.2, 6), friction=0.15))
    scene = scene_of(settled)
    assert len(scene.stages) == len(settled.paths)
    for stage, path in zip(scene.stages, settled.paths, strict=True):
        assert (stage.headline, stage.plays) == ("Falls", True)
        assert stage.path is not None
        assert stage.motion is not None
        assert np.array_equal(stage.path[-1], stage.motion)
        factor = np.linalg.norm(stage.motion) / np.linalg.norm(path.displacement)
        assert np.allclose(stage.motion, factor * path.displacement)
        falling = np.flatnonzero(stage.state == State.FALLING)
        assert set(falling.tolist()) == set(path.moving)
        assert ("times as long" in stage.message) == (factor > 1.0)
    data = encode(scene)
    states = len(scene.stages[0].path)  # type: ignore[arg-type]
    assert data["stages"][0]["path"]["shape"] == [states, len(scene.assembly), 6]


def test_what_rests_is_told_to_rest_and_does_not_play():
    settled = drystone.settle(drystone.Model.of(arch(0.2, 6), friction=0.7))
    for stage in scene_of(settled).stages:
        assert (stage.headline, stage.plays) == ("Comes to rest", False)
        assert "m, drawn" in stage.message


def test_a_path_without_a_motion_is_refused():
    blocks = tower(2)
    found = drystone.find_contacts(blocks).contacts
    stage = SceneStage("a", "", "", np.ones(2, dtype=np.intp), path=np.zeros((3, 2, 6)))
    with pytest.raises(InputError, match="its path has no motion"):
        Scene(blocks, found, (stage,))


def test_a_page_of_very_many_blocks_says_what_it_leaves_out(monkeypatch):
    result = drystone.check(drystone.Model.of(tower(3), friction=0.6))
    whole = encode(scene_of(result))
    monkeypatch.setattr(encoding, "MANY_BLOCKS", 2)
    light = encode(scene_of(result))
    assert "Left out" not in dict(whole["facts"])
    assert "corner forces" in dict(light["facts"])["Left out"]
    keys = {layer["key"] for layer in light["stages"][0]["layers"]}
    assert not keys & LEFT_OUT
    assert {"joint-force", "network"} <= keys
    assert light["stages"][0]["force"] is None
    assert light["stages"][0]["normal"] is not None


def test_a_page_of_very_many_joints_shows_sums_of_their_forces(monkeypatch):
    monkeypatch.setattr(encoding, "MANY_LINES", 2)
    data = encode(scene_of(drystone.check(drystone.Model.of(tower(4), friction=0.6))))
    layers = {layer["key"]: layer for layer in data["stages"][0]["layers"]}
    way = {}
    for key in ("network", "network-each"):
        raw = [
            base64.b64decode(data["blobs"][layers[key][of]["blob"]]) for of in ("vector", "value")
        ]
        vector, value = (np.frombuffer(one, "<f4") for one in raw)
        way[key] = value @ np.abs(vector.reshape(-1, 3))  # force by length
    assert way["network"] == pytest.approx(way["network-each"], rel=1e-5, abs=1e-3)
    assert layers["network"]["label"].endswith("summed over cells of 167 mm")
    hidden = {"network-each", "joint-force-each"}
    assert not any(layers[key]["visible"] for key in hidden)
    assert "joint-force" not in layers


def test_supports_that_move_too_far_play_the_fall_of_what_falls():
    left, right = box((1, 1, 1), name="left"), box((1, 1, 1), (1.4, 0, 0), name="right")
    plank = box((1.4, 0.5, 0.2), (0.6, 0.2, 1.0), name="plank")
    model = drystone.Model.of(drystone.Assembly((left, right, plank)).with_fixed([0, 1]))
    found = move_supports(model.with_friction([0.9, 0.05]), {"right": (0.7, 0.0, 0.0)})
    (stage,) = scene_of(found).stages
    assert stage.headline == "Falls when the supports have moved by 605 mm"
    assert stage.state.tolist() == [State.SUPPORT, State.SUPPORT, State.FALLING]
    assert len(stage.path) == len(found.states) + 1
    np.testing.assert_array_equal(stage.path[-1], found.fallen.positions)
    shown = scene_of(move_supports(model, {"right": (0.1, 0.0, 0.0)})).stages[0]
    assert State.FALLING not in shown.state
