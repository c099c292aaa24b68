"""Joints changed until every block is placed alone and stands at once."""

import json

import numpy as np
import pytest

from drystone import InputError, check, io, plan
from drystone.cli import main
from drystone.design import RecutOptions, recut_joints
from drystone.models import corbelled_bridge, leaning_column, snake, tower


def test_a_wedge_lets_the_snake_be_built_block_by_block():
    assert plan(snake(), friction=0.66).counts["held"] == 2
    found = recut_joints(snake(), friction=0.66)
    assert found.free
    assert [one.kind for one in found.changes] == ["wedge"]
    assert plan(found.model).counts["free"] == 3
    assert found.model.assembly.volume.sum() == pytest.approx(snake().volume.sum())


def test_what_falls_is_recut_too():
    """Below its least friction, 0.3148, the key pushes the arms of the bridge apart."""
    assert check(corbelled_bridge(), friction=0.3).falls
    found = recut_joints(corbelled_bridge(), friction=0.3)
    assert found.free
    assert check(found.model).stable
    assert found.message == "every block is free: 1 joint changed, 1 change tried"


def test_each_joint_of_a_column_that_slides_is_turned():
    found = recut_joints(leaning_column(blocks=3), friction=0.12)
    assert found.free
    assert len(found.changes) == 3
    slope = np.rad2deg(np.arctan(0.12))
    normal = found.model.contacts.frame[:, 0]
    assert (np.rad2deg(np.arccos(np.abs(normal[:, 2]))) < slope + 10.0).all()


def test_what_needs_no_help_is_not_changed():
    found = recut_joints(tower(3))
    assert (found.tried, found.changes) == (0, ())
    assert found.message == "every block is free: 0 joints changed, 0 changes tried"


def test_it_ends_and_tells_why():
    column = leaning_column(blocks=2)
    found = recut_joints(column, friction=0.12, options=RecutOptions(angles_deg=(0.1,)))
    assert not found.free
    assert found.message.startswith("no change that is tried needs less help")
    found = recut_joints(column, friction=0.12, options=RecutOptions(most=2))
    assert found.message.startswith("the limit of changes was reached before all was free")
    assert (found.tried, len(found.changes)) == (2, 1)
    assert found.message.endswith("; 1 block propped, 0 held, before 2 blocks propped, 0 held")
    assert found.changes[0].description.startswith("-10 degrees; without help: ")
    found = recut_joints(column, friction=0.12, stop=lambda: True)
    assert not found.free
    assert found.message.startswith("it was interrupted before all was free")


@pytest.mark.parametrize("wrong", [{"angles_deg": (0.0,)}, {"angles_deg": (70.0,)}, {"most": 0}])
def test_bad_options_are_refused(wrong):
    with pytest.raises(InputError):
        RecutOptions(**wrong)


def test_the_command_writes_the_changed_model(tmp_path, capsys):
    path, out, page = (tmp_path / name for name in ("column.json", "recut.json", "built.html"))
    io.write(leaning_column(blocks=2), path)
    given = ["recut", str(path), "--friction", "0.12", "--out", str(out), "--html", str(page)]
    assert main([*given, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["free"]
    assert [one["kind"] for one in data["changes"]] == ["turn", "turn"]
    assert page.exists()
    assert plan(io.read(out)).counts["free"] == 2
