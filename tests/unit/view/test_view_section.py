"""A section plane: what lies between it and the eye is not drawn, on paper and on the page."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

import drystone
from drystone.base.errors import InputError
from drystone.cli import main, told
from drystone.cli.waiting import Waiting
from drystone.models import arch, tower
from drystone.results import Result
from drystone.view import LayerKind, save_figure, save_page, scene_of
from drystone.view.figure import draw
from drystone.view.section import behind, cut_at, plane_of


@pytest.fixture(scope="module")
def standing() -> Result:
    return drystone.check(arch(0.2, 6), friction=0.9)


def drawn(scene, **how):
    """Corners (p, 2) of all areas of blocks on the paper."""
    (first, *_) = [
        one for one in draw(scene, (5.0, 4.0), **how).axes[0].collections if one.zorder == 1
    ]
    return np.concatenate([path.vertices for path in first.get_paths()])


@pytest.mark.parametrize(("axis", "number"), [("x", 0), ("y", 1), ("z", 2)])
def test_no_layer_reaches_beyond_the_plane(standing, axis, number):
    scene = cut_at(scene_of(standing), axis)
    plane = plane_of(scene, scene.toward)
    assert plane is not None
    near = 2e-3 * scene.block_size
    for layer in scene.stages[0].layers:
        left = behind(layer, plane, scene.block_size)
        ends = [left.position]
        if left.kind is LayerKind.LINES:
            ends.append(left.position + left.vector)
        for end in ends:
            assert (plane.heights(end) <= near).all()
        assert left.count <= layer.count
        if left.value is not None and len(left.value):
            assert left.value.max() <= layer.value.max() * (1.0 + 1e-12)


def test_the_plane_takes_away_the_side_of_the_eye(standing):
    scene = scene_of(standing)
    front, right = np.array([0.0, -1.0, 0.0]), -1.0
    whole = drawn(scene, toward=front)
    from_front = drawn(cut_at(scene, "x=-0.2"), toward=front)
    assert np.ptp(from_front[:, 0]) < np.ptp(whole[:, 0])
    side = np.array([right, -0.2, 0.1])
    cut = cut_at(scene, "x=-0.2")
    assert plane_of(cut, side).normal.tolist() == [-1.0, 0.0, 0.0]
    assert plane_of(cut, -side).normal.tolist() == [1.0, 0.0, 0.0]


def test_the_thrust_line_in_the_plane_is_drawn(standing):
    scene = cut_at(scene_of(standing), "y")
    plane = plane_of(scene, scene.toward)
    network = next(one for one in scene.stages[0].layers if one.key == "network")
    assert behind(network, plane, scene.block_size).count == network.count


def test_every_kind_of_figure_is_cut(standing, tmp_path):
    for name, how in (("a.png", {}), ("b.svg", {"preset": "solid"}), ("c.pdf", {"explode": 0.4})):
        save_figure(standing, tmp_path / name, size=(3, 2), dpi=40, section="x", **how)
        assert (tmp_path / name).stat().st_size > 1000
    falling = drystone.check(arch(0.2, 6), friction=0.2)
    save_figure(falling, tmp_path / "d.svg", section="y", names=True)
    assert "first motion" in (tmp_path / "d.svg").read_text(encoding="utf-8")


def test_a_page_begins_with_the_section(tmp_path):
    save_page(tower(2), tmp_path / "a.html", section="z=0.5")
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'type="application/json">(.*?)</script>', text, re.S)[1])
    assert data["section"][0] == 2
    assert data["section"][1] == pytest.approx((0.5 - 1.0) / 1.0)


@pytest.mark.parametrize("wrong", ["q", "xy", "", "=1", "x=one", "x=nan", "z=7"])
def test_what_is_no_section_is_refused_in_words(wrong):
    with pytest.raises(InputError, match=r"section|coordinate"):
        cut_at(scene_of(tower(2)), wrong)


def test_the_command_line_cuts_both_pictures(capsys, tmp_path):
    model = tmp_path / "tower.json"
    drystone.write(drystone.Model.of(tower(2)), model)
    page, figure = tmp_path / "tower.html", tmp_path / "tower.png"
    files = ("--html", str(page), "--png", str(figure))
    assert main(["check", str(model), "--section", "z=0.5", *files]) == 0
    assert '"section":[2,' in page.read_text(encoding="utf-8")
    assert main(["check", str(model), "--section", "w", *files]) == 2
    assert "x=1.2" in capsys.readouterr().err
    assert main(["check", str(model), "--section", "z"]) == 2
    assert "add --html or --png" in capsys.readouterr().err


@pytest.mark.parametrize(
    "command",
    [["check"], ["limit", "tilt"], ["push"], ["mend", "--diagnose"], ["inspect"], ["fall"],
     ["limit", "thickness"]],
)  # fmt: skip
def test_a_section_beside_the_model_is_refused_before_any_work(
    command, capsys, tmp_path, monkeypatch
):
    if command == ["fall"]:
        pytest.importorskip("mujoco")
    model = "arch" if "thickness" in command else tmp_path / "tower.json"
    drystone.write(drystone.Model.of(tower(2)), tmp_path / "tower.json")
    monkeypatch.setattr(told.Pictures, "of", None)  # no picture is begun
    monkeypatch.setattr(Waiting, "stoppable", None)  # no analysis
    page = tmp_path / "a.html"
    assert main([*command, str(model), "--section", "z=9", "--html", str(page)]) == 2
    said = capsys.readouterr().err
    assert "z = 9 m does not pass through the model" in said
    assert "give z between" in said
    assert "%" not in said  # no progress of an analysis
    assert not page.exists()
