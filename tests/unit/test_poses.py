"""The poses in which one block stands on a plane."""

import json

import numpy as np
import pytest

from drystone import Block, InputError, check, find_poses, io, models
from drystone.cli import main
from drystone.geometry.convex_pieces import hull_of
from drystone.models import box, prism, stool, tower


def random_body(seed):
    point, triangle = hull_of(np.random.default_rng(seed).normal(size=(12, 3)))
    return Block(point, [tuple(face) for face in triangle.tolist()], f"body-{seed}")


BODIES = [
    box((1.0, 2.0, 3.0)),
    stool().blocks[1],
    models.burr().blocks[2],
    models.hooked_bar().blocks[1],
    *(random_body(seed) for seed in range(6)),
]


@pytest.mark.parametrize("block", BODIES, ids=lambda block: block.name)
def test_poses_and_their_shares_are_those_of_trimesh(block):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("networkx")
    hull = trimesh.convex.convex_hull(block.vertices)
    _, share = trimesh.poses.compute_stable_poses(hull, center_mass=block.centroid)
    found = find_poses(block)
    np.testing.assert_allclose(found.share, share, atol=1e-6)


@pytest.mark.parametrize("block", BODIES, ids=lambda block: block.name)
def test_a_block_stands_in_each_of_its_poses_up_to_its_margin(block):
    found = find_poses(block)
    assert found.share.sum() == pytest.approx(1.0)
    assert check(found.model, friction=5.0).stable
    for pose, height in zip(found.transform, found.height, strict=True):
        placed = block.transformed(pose[:3, :3], pose[:3, 3])
        assert placed.bounds[0, 2] == pytest.approx(0.0, abs=1e-9)
        np.testing.assert_allclose(placed.centroid, [0.0, 0.0, height], atol=1e-9)


def test_the_margin_of_a_box_is_the_tilt_at_which_it_topples():
    found = find_poses(box((1.0, 1.0, 2.0)))
    assert found.tilt_to_topple.round(3).tolist() == [45.0] * 4 + [26.565] * 2
    ends = 4.0 * np.arcsin(1.0 / 5.0) / (4.0 * np.pi)  # solid angle of a unit square at height 1
    assert found.share[-1] == pytest.approx(ends)


def test_a_leaning_prism_does_not_stand_on_its_foot():
    leaning = prism([(0, 0), (1, 0), (4, 3), (3, 3)], (0.0, 1.0))
    down = [pose[:3, :3] @ (0.0, 0.0, -1.0) for pose in find_poses(leaning).transform]
    assert not any(np.allclose(one, (0.0, 0.0, -1.0), atol=1e-6) for one in down)
    assert len(down) == 4


def test_one_of_several_blocks_is_named():
    assert find_poses(tower(2)).block.name == "block-1"
    assert find_poses(tower(3), block="block-2").block.name == "block-2"
    with pytest.raises(InputError, match="there are 3 blocks, and one is looked at; name it"):
        find_poses(tower(3))


def test_the_command_tells_and_draws_them(tmp_path, capsys):
    io.write(stool().subset(["stool"]), tmp_path / "stool.obj")
    page = tmp_path / "poses.html"
    assert main(["poses", str(tmp_path / "stool.obj"), "--html", str(page), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [row["pose"] for row in told["poses"]] == [1, 2, 3, 4, 5, 6]
    assert told["asked"]["file"].endswith("stool.obj")
    assert page.read_text("utf-8").startswith("<!doctype html>")
