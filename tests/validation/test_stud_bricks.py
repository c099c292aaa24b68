"""Stud-and-tube bricks: the eight labelled designs of StableLego (arXiv 2402.10711).

The shares of the largest pull are those of a linear program for the same contact points.
"""

from pathlib import Path

import numpy as np
import pytest

import drystone
from benchmarks.field.stud_bricks import DESIGNS
from drystone import FormatError, JointCapacity, Verdict, solve_rbe
from drystone.joint_capacity import NO_LIMIT
from drystone.programs import RBEOptions

GRAVITY = 9.8 / 9.81
"""The data set uses 9.8 m/s2."""


def read(folder: Path, lines):
    (folder / "design.bricks").write_text("\n".join(lines) + "\n")
    return drystone.read(folder / "design.bricks", load=GRAVITY)


@pytest.mark.parametrize("name", DESIGNS)
def test_the_labelled_designs(tmp_path, name):
    design = DESIGNS[name]
    share = design.share
    model = read(tmp_path, design.lines)
    result = solve_rbe(model, options=RBEOptions.feasibility())
    assert design.stands == (share < 1.0)
    assert result.verdict is (Verdict.EQUILIBRIUM_EXISTS if design.stands else Verdict.UNSTABLE)
    given = model.contacts.capacity
    for factor, holds in ((1.001 * share, True), (0.999 * share, False)):
        pull = JointCapacity(factor * given.tension, given.cohesion)
        found = solve_rbe(model.with_capacity(pull), options=RBEOptions.feasibility())
        assert found.verdict is (Verdict.EQUILIBRIUM_EXISTS if holds else Verdict.UNSTABLE)


@pytest.mark.parametrize("name", DESIGNS)
def test_the_full_verdict_agrees(tmp_path, name):
    design = DESIGNS[name]
    result = drystone.check(read(tmp_path, design.lines))
    assert result.verdict is (Verdict.STABLE if design.stands else Verdict.UNSTABLE)
    # without friction one stiffness decides: the static theorem of limit analysis
    assert (result.samples.tried, result.samples.standing) == (1, int(design.stands))


def test_a_list_is_read_with_rotations_remarks_and_usual_masses(tmp_path):
    model = read(tmp_path, ["# a wall", "", "0 0 0 4 2", "0 0 1 4 2 90  # crosswise", "5 0 0 1 1"])
    assert model.assembly.names == ("brick-000", "brick-001", "brick-002", "ground")
    assert model.assembly.fixed.tolist() == [False, False, False, True]
    assert model.assembly.mass[:3] == pytest.approx([2.16e-3, 2.16e-3, 0.39e-3])
    extent = model.assembly.bounds[1, 1] - model.assembly.bounds[1, 0]
    assert extent == pytest.approx([2 * 7.8e-3, 4 * 7.8e-3, 9.6e-3])
    pairs = list(zip(model.contacts.block_a.tolist(), model.contacts.block_b.tolist(), strict=True))
    assert pairs.count((3, 0)) == 8
    assert pairs.count((0, 1)) == 4  # of eight studs under it four meet a brick
    assert pairs.count((3, 2)) == 1


def test_bricks_side_by_side_press_each_other(tmp_path):
    model = read(tmp_path, ["0 0 0 2 2", "2 0 0 2 2", "0 2 0 2 2"])
    beside = model.contacts.capacity.tension == 0.0
    assert beside.sum() == 4
    assert model.contacts.area[beside].sum() == pytest.approx(4 * 7.8e-3 * 9.6e-3)
    for i in np.flatnonzero(beside):
        a, b = model.contacts.block_a[i], model.contacts.block_b[i]
        way = model.assembly.centroid[b] - model.assembly.centroid[a]
        assert model.contacts.frame[i, 0] @ way > 0.0
        face = model.contacts.polygon(i)
        turn = np.cross(face[1] - face[0], face[2] - face[1])
        assert turn @ model.contacts.frame[i, 0] > 0.0
    assert (model.contacts.capacity.cohesion[~beside] == NO_LIMIT).all()


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["0 0 0 4"], "design.bricks, line 1: '0 0 0 4' is no brick"),
        (["0 0 0 4 2 45"], "the rotation is 45 degrees"),
        (["0 0 -1 4 2"], "is no brick"),
        (["0 0 0 0 2"], "is no brick"),
        (["0 1 2 4 90 2.3"], "is no brick"),
        (["0 0 0 4 2 " + "9" * 5000], "is no brick"),
        (["0 0 0 4 2 0 0"], "its mass is zero"),
        (["0 0 0 4 2", "2 1 0 4 2"], "bricks 0 and 1 are both at stud 2 1"),
        (["0 0 1 4 2"], "has no brick on the ground"),
        (["# nothing"], "holds no brick"),
        (["0 0 0 4 2 0 1e9"], "is no brick"),
    ],
)
def test_bad_lists_are_refused(tmp_path, lines, words):
    with pytest.raises(FormatError, match=words):
        read(tmp_path, lines)
