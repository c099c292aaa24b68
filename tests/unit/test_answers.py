"""Every answer says five things of itself, keeps what was asked, and can be kept and copied."""

import copy
import html
import inspect
import json
import pickle
import pkgutil
import tempfile
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import drystone
from benchmarks.sample_shells import sample_shell
from drystone import LoadCase, Model, design, limits, seismic, sequence, shells, studies
from drystone.answer import Answer, Question, Role, Scene, Sentence, Statement
from drystone.answer.chart import Chart
from drystone.detection import gap_sweep
from drystone.fall import Film
from drystone.io import Inspection
from drystone.models import arch, box, tower
from drystone.reproduce import reproduce
from drystone.supports import own_blocks

RARE = Model.of(tower(2), friction=0.0).with_load((1.0, 0.0, -9.81))
SPECTRUM = seismic.Spectrum.ec8(1.0, "A")


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


def answers() -> Iterator[Answer]:
    """One of each."""
    stack = Model.of(tower(3), friction=0.6)
    yield drystone.check(stack)
    yield drystone.diagnose(RARE)
    coarse = limits.LimitOptions(width=5.0, scan=1)
    yield limits.limit_tilt(stack, options=coarse)
    yield limits.tilt_sweep(stack, 2, options=coarse)
    yield limits.limit_train(arch(0.3, 8), steps=1, friction=0.8)
    yield limits.thrust_bounds(stack, "block-0", (0.0, 0.0, 1.0))
    yield drystone.programs.find_forces(stack)
    yield from (sequence.interlocking(stack), sequence.gravity_region(stack, directions=4))
    file = Path(tempfile.mkdtemp()) / "cases.toml"
    file.write_text('situations = ["EQU"]\n[case.gravity]\nkind = "permanent"', encoding="utf-8")
    yield studies.combinations(stack, file)
    yield limits.imperfections(stack, limits.Imperfections(offset=0.01), draws=2)
    yield drystone.settle(tower(2))
    yield seismic.local_mechanism(tower(2), part="block-1", site=seismic.SeismicDemand(SPECTRUM))
    yield drystone.settlement.push(tower(2), friction=0.3, to=0.01)
    moves = {"springer-right": (0.01, 0.0, 0.0)}
    yield drystone.settlement.support_response(arch(0.2, 8), moves, friction=0.9)
    yield drystone.find_poses(box((1.0, 2.0, 3.0)))
    yield Film(Model.of(tower(2)), np.zeros(1), np.zeros((1, 2, 6)), True)
    order = drystone.plan(stack)
    yield from (order, sequence.scaffolding(order))
    robots = [sequence.Robot("left"), sequence.Robot("right")]
    yield from (sequence.handling(order, robots[:1]), sequence.take_turns(stack, robots=robots))
    yield sequence.margins(order, tilt_width=5.0, directions=1)
    with TemporaryDirectory() as folder:
        yield sequence.dataset([stack], folder, options=sequence.DatasetOptions(rows=2))
    yield sequence.sweep_friction(stack, [0.6], drystone.plan)
    yield reproduce("5.1.1")
    found = drystone.find_contacts(tower(3))
    yield Inspection(tower(3), found, gap_sweep(tower(3), [1e-4, 1e-3]))
    few = design.MendOptions(kinds=("friction", "ballast"))
    mends = design.find_mends(RARE, options=few)
    yield from (mends, mends.mends[0])
    yield from (design.sharpen(tower(2)), design.recut_joints(tower(2)))
    still = design.block_moves(RARE, ["block-1"], (1.0, 0.0, 0.0), 0.1)
    yield design.shape(tower(2), still)
    yield design.Changed.by_hand(stack, drystone.check(stack), "nothing")
    yield design.cut_until_free(box((1.0, 1.0, 2.0)), options=design.CutOptions(blocks=2))
    shell = sample_shell("barrel")
    yield shell
    eye, layout = shells.dome(3.0, 2.0), shells.Layout(courses=2, blocks=4)
    yield design.make_buildable(eye, layout, shells.ShellBody(thickness=0.5))
    count = [design.Parameter("count", choices=(2, 3))]
    yield design.tune(tower, count, options=design.TuneOptions(trials=1))


KINDS = sorted(kinds() - {Statement}, key=lambda kind: kind.__name__)


@pytest.fixture(scope="module")
def made() -> dict[type[Answer], Answer]:
    """One of each, made for the first test that asks: not while tests are collected."""
    return {type(one): one for one in answers()}


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
