"""Joints made wedges where tension appears: needed, all of them, and checked from their files."""

import json
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import Assembly, InputError, Model
from drystone.cli import main
from drystone.design import Changed, DesignMargin, SharpenOptions, sharpen
from drystone.design.sharpening import PlaneJoints
from drystone.models import arch, box, shelf, tower

THIN = Model.of(arch(0.08, voussoirs=4), friction=0.7)
"""It falls while its joints are plane."""


COARSE = SharpenOptions(step=20.0, close=4.0)
"""Quick to search for."""


@pytest.fixture(scope="module")
def sharpened() -> Changed:
    return sharpen(THIN, options=COARSE)


def test_a_thin_arch_stands_with_wedges_when_it_is_read_from_its_file(
    sharpened: Changed, tmp_path: Path
) -> None:
    assert not drystone.check(THIN).stable
    assert sharpened.stands
    assert len(sharpened.changes) > 0
    path = tmp_path / "wedged.json"
    drystone.write(sharpened.model, path)
    assert drystone.check(drystone.read(path)).stable


def test_every_sharpened_joint_is_needed(sharpened: Changed) -> None:
    margin, joints = DesignMargin(), PlaneJoints.of(THIN)
    for k in np.flatnonzero(sharpened.x):
        less = np.array(sharpened.x)
        less[k] = max(less[k] - COARSE.close, 0.0)
        found = drystone.check(joints.wedged(less), options=margin.options())
        assert not margin.meets(found)


def test_wedges_keep_the_sum_of_the_volumes_and_all_blocks(sharpened: Changed) -> None:
    before, after = THIN.assembly, sharpened.model.assembly
    assert after.names == before.names
    assert after.volume.sum() == pytest.approx(before.volume.sum(), rel=1e-9)


def test_the_same_sharpness_gives_the_same_blocks_whatever_was_cut_before(
    sharpened: Changed,
) -> None:
    joints = PlaneJoints.of(THIN)
    k = int(np.flatnonzero(sharpened.x)[0])
    without = np.where(np.arange(THIN.contacts.count) == k, 0.0, sharpened.x)
    joints.wedged(without)
    after = joints.wedged(sharpened.x)
    np.testing.assert_array_equal(after.contacts.point, sharpened.model.contacts.point)
    np.testing.assert_array_equal(after.assembly.centroid, sharpened.model.assembly.centroid)


def test_wedges_that_would_take_the_same_part_of_a_block_are_refused() -> None:
    plates = (box((1.0, 1.0, 1.0)), box((1.0, 1.0, 0.1), (0.0, 0.0, 1.0), "plate"),
              box((1.0, 1.0, 1.0), (0.0, 0.0, 1.1), "above"))  # fmt: skip
    thin = Model.of(Assembly(plates).with_fixed([0]), friction=0.6)
    with pytest.raises(InputError):
        PlaneJoints.of(thin).wedged(np.full(thin.contacts.count, 30.0))


def test_wedges_that_fit_alone_but_not_together_are_made_as_far_as_they_fit() -> None:
    few = SharpenOptions(step=20.0, most=20.0, close=5.0, margin=DesignMargin(robust=False))
    found = sharpen(shelf(), options=few, friction=0.9)
    assert not found.stands
    assert found.x.max() == 20.0


def test_what_stands_already_is_left_as_it_is() -> None:
    model = Model.of(tower(2), friction=0.6)
    found = sharpen(model)
    assert found.stands
    assert found.model is model
    assert not found.changes
    assert "stands already" in found.message


def test_where_no_joint_pulls_wedges_do_not_help_and_it_says_so() -> None:
    found = sharpen(Model.of(tower(2), friction=0.1).with_load((1.5, 0.0, -9.81)))
    assert not found.stands
    assert not found.changes
    assert "no joint that may be changed shows tension" in found.message


def test_where_the_largest_sharpness_is_not_enough_it_says_so() -> None:
    found = sharpen(THIN, options=SharpenOptions(step=5.0, most=5.0))
    assert not found.stands
    assert "allow sharper wedges" in found.message


def test_it_ends_when_it_is_asked_to() -> None:
    found = sharpen(THIN, stop=lambda: True)
    assert not found.stands
    assert "stopped" in found.message


def test_blocks_to_keep_keep_their_joints() -> None:
    every = tuple(THIN.assembly.names)
    with pytest.raises(InputError, match="no joint may be changed"):
        sharpen(THIN, options=SharpenOptions(keep=every))
    joints = PlaneJoints.of(THIN, frozenset([0]))
    ends = (THIN.contacts.block_a == 0) | (THIN.contacts.block_b == 0)
    np.testing.assert_array_equal(joints.usable, ~ends)


@pytest.mark.parametrize(
    "given",
    [
        {"step": 0.0},
        {"most": 85.0},
        {"step": 70.0},
        {"close": 0.0},
        {"least": -1.0},
        {"least": 61.0},
        {"close": float("nan")},
    ],
)
def test_options_that_make_no_sense_are_refused(given: dict[str, float]) -> None:
    with pytest.raises(InputError):
        SharpenOptions(**given)


def test_the_command_writes_the_model_and_tells_the_joints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, base = tmp_path / "out.json", tmp_path / "in.json"
    blocks = (box((1.0, 1.0, 1.0)), box((1.0, 1.0, 0.2), (0.7, 0.0, 1.0), "out"))
    drystone.write(Model.of(Assembly(blocks).with_fixed([0])), base)
    code = main(["sharpen", str(base), "--most", "20", "--out", str(out), "--json"])
    told = json.loads(capsys.readouterr().out)
    assert code == 1
    assert told["verdict"] == "unstable"
    assert told["changes"][0]["blocks"] == "box, out"
    assert out.exists()


def test_stable_for_some_stiffnesses_only_is_not_said_to_fall() -> None:
    found = sharpen(arch(0.08), friction=0.6)
    assert (found.result.stable, found.stands) == (True, False)
    assert "does not stand with 18 joints" in found.message
    assert "for all contact stiffnesses" in found.message
