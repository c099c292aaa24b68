"""The printed page about joints."""

import re
from pathlib import Path

import numpy as np
import pytest

from drystone import Assembly, InputError, JointCapacity, LoadCase, Result, Verdict, solve_rbe
from drystone.assembly import Block
from drystone.model import Model
from drystone.models import arch, tower
from drystone.report import save_joints
from tests.oracle import touching_faces


def solved(assembly: Assembly) -> Result:
    return solve_rbe(Model(assembly, touching_faces(assembly, 0.7)))


def test_the_page_shows_the_worst_joints_and_asks_nothing_of_the_network(tmp_path: Path) -> None:
    path = tmp_path / "joints.html"
    save_joints(solved(arch(0.2, 9)), path, worst=4)
    text = path.read_text(encoding="utf-8")
    assert text.count("<figure>") == 1
    assert text.count(" m wide, ") == 2 * 4  # below it, and for those who do not see it
    assert text[text.index("<tbody>") :].count("<tr>") == 4
    assert "strength use" not in text
    assert not re.search(r"https?://|@import", text)
    assert [p.name for p in tmp_path.iterdir()] == ["joints.html"]


def test_the_page_tells_how_much_of_a_strength_is_used(tmp_path: Path) -> None:
    model = Model(arch(0.2, 9), touching_faces(arch(0.2, 9), 0.7))
    strong = JointCapacity.of_stress(model.contacts, compression=1e6)
    save_joints(solve_rbe(model.with_capacity(strong)), tmp_path / "joints.html", worst=1)
    assert "strength use" in (tmp_path / "joints.html").read_text(encoding="utf-8")


def test_names_of_blocks_cannot_become_markup(tmp_path: Path) -> None:
    plain = tower(2)
    named = [Block(b.vertices, b.faces, f"<b>{i}&") for i, b in enumerate(plain.blocks)]
    path = tmp_path / "joints.html"
    save_joints(solved(Assembly(tuple(named), plain.fixed)), path)
    text = path.read_text(encoding="utf-8")
    assert "<b>" not in text
    assert "&lt;b&gt;1&amp;" in text


def test_lines_and_points_have_a_plan_too(tmp_path: Path) -> None:
    from drystone.virtual import shift, shrink

    assembly = tower(2)
    joints = touching_faces(assembly, 0.7)
    for reduced in (shift(joints, (1.0, 0.0, 0.0), 0.0), shrink(joints, 0.0)):
        result = solve_rbe(Model(assembly, reduced, LoadCase.gravity(assembly)))
        path = tmp_path / "joints.html"
        if result.force is not None:
            save_joints(result, path)
            told = re.sub('base64,[^"]*', "", path.read_text(encoding="utf-8"))
            assert "nan" not in told
    assert path.exists()


def test_without_forces_there_is_no_page(tmp_path: Path) -> None:
    assembly = tower(2)
    joints = touching_faces(assembly, 0.7)
    empty = Result("rbe", Verdict.UNSTABLE, Model(assembly, joints, LoadCase.gravity(assembly)))
    with pytest.raises(InputError, match="no forces"):
        save_joints(empty, tmp_path / "joints.html")
    assert list(tmp_path.iterdir()) == []


def test_a_plan_tells_where_its_directions_point(tmp_path: Path) -> None:
    path = tmp_path / "joints.html"
    save_joints(solved(tower(2)), path)  # the joint is level: u and v are along x and y
    found = re.search(r"wide, right: ([+-])([xy]), up: ([+-])([xy])<", path.read_text("utf-8"))
    assert found is not None
    right, up = (
        float(f"{sign}1") * np.eye(3)["xyz".index(axis)]
        for sign, axis in (found.groups()[:2], found.groups()[2:])
    )
    assert np.cross(right, up).tolist() == [0.0, 0.0, 1.0]  # seen against the normal, from above
