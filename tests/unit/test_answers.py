"""Every answer says five things of itself, keeps what was asked, and can be kept and copied."""

import copy
import html
import inspect
import json
import pickle
import pkgutil
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import drystone
from drystone import LoadCase, Model, design, limits
from drystone.answer import Answer, Question, Role, Scene, Sentence, Statement
from drystone.answer.chart import Chart
from drystone.models import tower
from drystone.supports import own_blocks
from tests.answers import one_of_each


def kinds() -> set[type[Answer]]:
    """Every public class of answers."""
    found = set()
    for info in pkgutil.iter_modules(drystone.__path__, "drystone."):
        if info.name.rpartition(".")[2] in ("__main__", "cli", "gym", "mcp"):
            continue
        room = import_module(info.name)
        for name in getattr(room, "__all__", ()):
            thing = getattr(room, name)
            if inspect.isclass(thing) and issubclass(thing, Answer):
                found.add(thing)
    return {one for one in found if not inspect.isabstract(one)}


KINDS = sorted(kinds() - {Statement}, key=lambda kind: kind.__name__)


@pytest.fixture(scope="module")
def made() -> dict[type[Answer], Answer]:
    """Made for the first test that asks: not while tests are collected."""
    return one_of_each()


def test_every_public_kind_is_here(made: dict[type[Answer], Answer]) -> None:
    assert set(KINDS) == set(made)


def test_a_statement_is_an_answer_without_a_model() -> None:
    one = Statement((Sentence("Three files were written.", Role.GOOD),), values={"files": 3})
    assert (one.title, one.code) == ("Three files were written.", 0)
    for again in (one, copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert json.loads(json.dumps(again.to_dict()))["files"] == 3
    with pytest.raises(drystone.InputError, match="has no picture"):
        one.layers()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_an_answer_says_five_things_of_itself(
    made: dict[type[Answer], Answer], kind: type[Answer]
) -> None:
    one = made[kind]
    assert one.title
    first, *_ = one.sentences()
    assert first.role in (Role.GOOD, Role.BAD, Role.UNSURE)
    assert (one.code == 0) == (first.role is Role.GOOD)
    keys = [table.key for table in one.tables()]
    assert len(set(keys)) == len(keys)
    assert set(keys).isdisjoint(one.numbers())
    assert all(table.cells()[0] for table in one.tables())
    if not isinstance(one, design.Tuned):  # of many models
        scene = one.layers()
        assert scene.stages
        assert scene.facts["Blocks"] == f"{own_blocks(one.assembly).sum()}"
    assert isinstance(one.figure(), Scene | Chart)
    assert html.escape(one.title) in one._repr_html_()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_an_answer_is_plain_in_json_and_the_same_in_a_copy(
    made: dict[type[Answer], Answer], kind: type[Answer]
) -> None:
    one = made[kind]
    told = json.dumps(one.to_dict(), allow_nan=False)
    for again in (copy.copy(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
        assert json.dumps(again.to_dict(), allow_nan=False) == told
    assert json.loads(told)["asked"]["version"] == drystone.__version__


def test_an_answer_says_what_was_asked(tmp_path: Path) -> None:
    drystone.write(tower(3), tmp_path / "tower.obj")
    model = drystone.read(tmp_path / "tower.obj", supports="lowest", friction=0.7, units="cm")
    push = LoadCase.point_load(model.assembly, "block-2", (1e-3, 0.0, 0.0), (0.0, 0.0, 0.02))
    model = model.with_load(model.load + push)
    asked = drystone.check(model, options=drystone.CheckOptions(samples=2)).asked
    assert asked.file == str(tmp_path / "tower.obj")
    assert len(asked.sha256) == 64
    assert asked.reading == {"units": "cm", "supports": "lowest", "friction": "0.7"}
    assert asked.supports == ("block-0",)
    assert asked.friction == (0.7, 0.7)
    np.testing.assert_allclose(asked.acceleration, (0.0, 0.0, -9.81))
    (load,) = asked.loads
    assert load["block"] == "block-2"
    np.testing.assert_allclose(load["force"], (1e-3, 0.0, 0.0), atol=1e-12)
    assert asked.load == "gravity + 0.001, 0, 0 N on 'block-2' at 0, 0, 0.02 m"
    assert asked.options == {"samples": "2"}
    assert "tower.obj" in asked.line()
    assert "friction 0.7" in asked.line()


def test_where_joints_differ_in_friction_the_joints_with_the_least_are_named() -> None:
    asked = Question.of(Model.of(tower(4)).with_friction((0.5, 0.0, 0.5)))
    assert "friction 0 to 0.5 (least between block-1 and block-2)" in asked.line()
    assert "friction 0.5 \N{MIDDLE DOT}" in Question.of(Model.of(tower(4), friction=0.5)).line()


def test_both_sides_of_a_limit_are_one_step_away(made: dict[type[Answer], Answer]) -> None:
    found = made[limits.Limit]
    assert isinstance(found, limits.Limit)
    assert (found.stands, found.falls) == (found.best.stands, found.best.falls)
