"""How values show themselves: every public type on one line."""

import base64
import enum
import gzip
import html
import inspect
import pkgutil
import subprocess
import sys
import typing
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import drystone
from benchmarks.sample_shells import sample_shell
from drystone import (
    InputError,
    LoadCase,
    Model,
    design,
    limits,
    loads,
    programs,
    seismic,
    sequence,
    settlement,
    shells,
    studies,
    view,
)
from drystone.answer import Sentence, Statement
from drystone.base.display import Card, shortened
from drystone.detection import (
    ContactReport,
    Detection,
    DetectionOptions,
    Resampled,
    Shortfall,
)
from drystone.fall import FallOptions
from drystone.io import FORMATS, read_file
from drystone.joints import force_network
from drystone.models import arch, box, burr, dome, shelf, tower, vault
from drystone.report import TitleBlock
from drystone.view import notebook
from tests.answers import one_of_each

INSIDE = {"cli", "gym", "geometry", "solvers", "formulations", "statics", "checks"}
INSIDE |= {"display", "settings"}
"""Rooms whose types no user meets."""


def public_types() -> set[type]:
    """Every class that a public module names, but errors, protocols and typed dictionaries."""
    modules = [drystone]
    for info in pkgutil.iter_modules(drystone.__path__, "drystone."):
        if info.name.split(".")[1] not in {*INSIDE, "__main__"}:
            modules.append(import_module(info.name))
    return {
        thing
        for module in modules
        for thing in (getattr(module, name) for name in getattr(module, "__all__", ()))
        if inspect.isclass(thing)
        and thing.__module__.startswith("drystone")
        and not issubclass(thing, Exception)
        and not inspect.isabstract(thing)
        and not getattr(thing, "_is_protocol", False)
        and not typing.is_typeddict(thing)
    }


def values(folder: Path) -> Iterator[object]:
    """Real ones, from which all others can be reached."""
    yield from one_of_each().values()
    stands = drystone.check(vault(), friction=0.6)
    yield from (stands, stands.asked, stands.sentences()[0], TitleBlock(project="A wall"))
    yield from (stands.resultants, stands.joints(), stands.contacts[0])
    yield drystone.check(arch(), friction=0.9).thrust_line()
    yield drystone.check(shelf(), friction=0.9)
    yield design.Need(100.0, (0,))
    yield design.DiagnosisOptions(regions=3)
    few = design.MendOptions(kinds=("friction", "ballast"))
    rare = Model.of(tower(2), friction=0.0).with_load((1.0, 0.0, -9.81))
    yield from (few, design.RecutOptions(most=3))
    yield design.Kept("turn", ("a", "b"), "it is propped", 10.0)
    yield from (design.mend(tower(2)), design.SharpenOptions(step=5.0))
    still = design.block_moves(rare, ["block-1"], (1.0, 0.0, 0.0), 0.1)
    yield from (still, design.ShapeOptions(rounds=3))
    ring = Model.of(dome(slices=5, rings=3), friction=0.6)
    yield design.free_vertices(ring, 0.1, along=None, mirror="y")
    yield design.FamilyMoves.of(arch, {"thickness_ratio": 0.2}, {"thickness_ratio": 0.1})
    edge = design.Parameter("edge", 0.5, 2.0)
    count = design.Parameter("count", choices=(2, 3))
    yield from (edge, design.TuneOptions(trials=2))
    yield design.tune(tower, [edge, count], options=design.TuneOptions(trials=1))
    yield design.BuildableOptions(hands=1)
    yield drystone.JointCapacity.of(drystone.find_contacts(tower(3)).contacts, tension=1.0)
    apart = tower(3).blocks[2].transformed(translation=(0.0, 0.0, 0.02))
    yield drystone.find_contacts(drystone.Assembly((*tower(3).blocks[:2], apart)))
    sunk = tower(2).blocks[1].transformed(translation=(0.3, 0.0, -0.2))
    yield drystone.find_contacts(drystone.Assembly((tower(2).blocks[0], sunk)))
    pressed = tower(2).blocks[1].transformed(translation=(0.0, 0.0, -0.005))
    yield drystone.find_contacts(drystone.Assembly((tower(2).blocks[0], pressed)))
    yield Resampled(0, 1, 9, 4, 16, 3.0, 0.01)
    yield from (Statement((Sentence("All is said."),)), drystone.find_poses(box((1.0, 1.0, 2.0))))
    yield Shortfall(0, 1, 0.1, 0.2, 0.01, 3.0)
    settled = drystone.settle(tower(2))
    yield from (settled, settled.path, settlement.SettlementOptions(fall=0.2))
    site = seismic.SeismicDemand(seismic.Spectrum.ec8(1.0, "A"))
    yield from (site, site.spectrum, site.state, seismic.local_mechanism(tower(2), part="block-1"))
    cases = folder / "cases.toml"
    cases.write_text('[case.gravity]\nkind = "permanent"', encoding="utf-8")
    combined = studies.combinations(tower(2), cases)
    yield from (combined, studies.Action("gravity", "permanent", combined.each[0].load))
    yield FallOptions()
    stack = Model.of(tower(3), friction=0.6)
    yield drystone.programs.build_rbe(stack)
    yield limits.limit_friction(stack, options=limits.LimitOptions(width=0.2))
    yield drystone.programs.find_forces(stack, virtual=["kern"])
    push = LoadCase.seismic(stack.assembly, 1.0)
    yield from (loads.Train.named("lm1"), loads.Fill(0.3, 2e4), loads.Earth("x", 18e3, 0.3))
    yield limits.Tilt(stack, np.array([1.0, 0.0, 0.0]))
    yield from (
        limits.Friction(stack),
        limits.LoadFactor(stack, push),
        limits.Shrunk(stack),
        limits.Weakened(stack),
    )
    yield limits.Parametric(tower, Model.of)
    yield limits.Quantity("thickness", "m")
    order = drystone.plan(stack)
    yield from (order, sequence.Prop(1, 0, 2, np.ones(6)), sequence.Stage(2**300 - 1, 1))
    yield from (sequence.RemovalTest(order.model), sequence.Evaluator(order.model))
    structure = drystone.Structure(stack)
    yield from (structure, structure.stands_many(np.ones((1, 3), dtype=bool)))
    few = sequence.DatasetOptions(rows=1)
    rows = sequence.dataset([stack], folder / "data", options=few)
    yield from (few, rows, rows.orders[0])
    yield from (sequence.check_both, structure.stands([1]))
    yield sequence.freedom(np.array([[0.0, 0.0, 1.0]]), np.array([0.0, 0.0, 1.0]))
    yield from (sequence.find_path(stack, "block-2"), sequence.find_path(stack, "block-1"))
    yield sequence.find_path(Model.of(burr()), "x-low", options=sequence.PathOptions(effort=50))
    yield sequence.PathOptions()
    yield sequence.Strut("block-1", head=(0.0, 0.0, 1.0))
    yield sequence.Rope("block-1", anchor=(0.0, 0.0, 9.0))
    yield sequence.Centring("block-1", face=np.zeros((3, 3)))
    yield from (sequence.ScaffoldItem("block-1"), sequence.Clamp("block-1"))
    yield sequence.with_scaffold(stack, [sequence.Clamp("block-1")])
    yield sequence.ScaffoldOptions()
    yield sequence.Hold("b", "", "c", np.zeros(3), np.zeros(3))
    plane = design.Cut((0.5, 0.5, 0.5), (0.0, 0.0, 1.0))
    yield from (plane, design.cut_until_free(box((1.0, 1.0, 2.0)), [[plane]]))
    few = design.CutOptions(blocks=2)
    yield few
    yield from (sequence.LocalWorkers(2), sequence.DaskWorkers("tcp://127.0.0.1:8786"))
    shell = sample_shell("barrel")
    yield from (shell, shells.flat_faces(shell, 0), shells.schedule(shell))
    yield shells.cross_vault()
    yield shells.find_form(shells.rectangular_plan(6.0, 8.0), height=2.0)
    grid = [(x, y, 0.1 * x * x) for y in range(3) for x in range(3)]
    quads = [(i, i + 1, i + 4, i + 3) for i in (0, 1, 3, 4)]
    yield shells.patch_from_mesh(grid, quads, control=(3, 3))
    yield from (view.scene_of(stands), view.Frame(stands), view.PRESETS["forces"])
    yield force_network(stands.assembly, stands.contacts, stands.resultants)
    drystone.write(stands.model, folder / "vault.json")
    yield from (*FORMATS, read_file(folder / "vault.json"))
    yield from (programs.CRAOptions(), programs.PenaltyOptions(), sequence.PlanOptions())
    yield from (limits.LimitOptions(), limits.Imperfections())
    yield from (shells.ShellBody(), shells.Layout(), DetectionOptions())


class Reached:
    """What is inside of what, by type."""

    def __init__(self) -> None:
        self.found: dict[type, list[object]] = {}
        self.seen: set[int] = set()

    def look(self, value: object) -> None:
        """Remember a value and all that it holds."""
        if id(value) in self.seen:
            return
        self.seen.add(id(value))
        if isinstance(value, Mapping):
            value = tuple(value.values())
        if isinstance(value, tuple | list) and not hasattr(value, "_fields"):
            for one in value[:50]:
                self.look(one)
            return
        if not type(value).__module__.startswith("drystone"):
            return
        self.found.setdefault(type(value), []).append(value)
        if not isinstance(value, enum.Enum):
            for name, one in getattr(value, "__dict__", {}).items():
                if not name.startswith("_"):
                    self.look(one)


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[type, list[object]]:
    reached, kept = Reached(), []
    for value in values(tmp_path_factory.mktemp("values")):
        kept.append(value)  # alive, so that no other value gets its id
        reached.look(value)
    return reached.found


def test_every_public_value_is_one_line_that_names_its_type(
    found: dict[type, list[object]],
) -> None:
    wrong = {
        (kind.__name__, told)
        for kind, some in found.items()
        if not issubclass(kind, enum.Enum)
        for one in some
        for told in (repr(one), str(one))
        if len(told) > 200 or "\n" in told or not repr(one).startswith(kind.__name__)
    }
    assert wrong == set()


def test_every_public_type_is_among_them(found: dict[type, list[object]]) -> None:
    missing = public_types() - set(found)
    assert {kind.__name__ for kind in missing if not issubclass(kind, enum.Enum)} == set()


def cards() -> list[Card]:
    """One of each type that a notebook shows as a card."""
    stack = Model.of(tower(3), friction=0.6)
    return [
        stack,
        stack.assembly,
        drystone.find_contacts(tower(3)),
        drystone.find_contacts(tower(3)).report,
    ]


def test_a_card_has_a_sentence_numbers_and_where_blocks_are_known_a_small_picture() -> None:
    shown = {type(card): card._repr_html_() for card in cards()}
    assert found_subclasses(Card) == set(shown)
    for kind, text in shown.items():
        assert text.count("<b>") == 1
        assert f"<b>{kind.__name__}</b>" in text
        assert len(text) < 100_000
        assert text.count("<iframe") == (0 if kind in (Detection, ContactReport) else 1)


def test_an_answer_shows_its_sentences_tables_picture_and_what_was_asked() -> None:
    text = drystone.check(shelf(), friction=0.9)._repr_html_()
    assert "<b>Falls: 2 of 11 blocks</b>" in text
    assert "UNSTABLE" in text
    assert "forces could balance the loads" in text
    assert "<td><bdi>block-9</bdi></td>" in text
    assert "friction 0.9 \N{MIDDLE DOT} gravity" in text
    assert text.count("<iframe") == 1
    assert "largest force" not in text
    assert "largest force" in drystone.check(tower(3))._repr_html_()


def found_subclasses(kind: type) -> set[type]:
    """All types that inherit from one."""
    return {one for sub in kind.__subclasses__() for one in (sub, *found_subclasses(sub))}


def test_names_of_blocks_cannot_become_markup_in_a_card() -> None:
    wild = drystone.Assembly([box((1.0, 1.0, 1.0), name="<b>&")]).with_fixed(0)
    assert "&lt;b&gt;&amp;" in wild._repr_html_()
    assert wild._repr_html_().count("<b>") == 1


def test_a_large_model_is_not_drawn_unasked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebook, "MOST_BLOCKS", 2)
    assert "<iframe" not in tower(3)._repr_html_()
    assert "<iframe" in tower(2)._repr_html_()


def test_a_large_page_is_replaced_by_a_still_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    stack = tower(3)
    assert len(stack._repr_html_()) < 100_000
    monkeypatch.setattr(notebook, "MOST_BYTES", 1000)
    shown = stack._repr_html_()
    assert "<iframe" not in shown
    assert '<img alt="drystone: 3 blocks' in shown


def test_a_frame_holds_the_page_packed() -> None:
    stack = Model.of(tower(3))
    frame = view.Frame(stack)
    page, shown = view.page_text(frame.scene), frame._repr_html_()
    loader = html.unescape(shown.split('"')[1])
    data = loader.partition('atob("')[2].partition('"')[0]
    assert gzip.decompress(base64.b64decode(data)).decode() == page
    assert len(shown) < 0.5 * len(page)
    assert notebook.beside(42) == notebook.thumbnail(42) == ""
    with pytest.raises(InputError, match="no picture of 42; give a model"):
        view.Frame(42)  # type: ignore[arg-type]


def test_showing_a_value_loads_no_plotting() -> None:
    code = (
        "import sys, drystone; model = drystone.Model.of(drystone.models.tower(2));"
        "repr(model); early = 'matplotlib' in sys.modules; model._repr_html_();"
        "print(early, 'matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "False"]


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (drystone.CheckOptions(), "CheckOptions()"),
        (drystone.CheckOptions(samples=2), "CheckOptions(samples=2)"),
        (
            drystone.programs.RBEOptions(objective="linear"),
            "RBEOptions(objective=Objective.LINEAR)",
        ),  # type: ignore[arg-type]
        (limits.LimitOptions(width=0.1), "LimitOptions(width=0.1)"),
    ],
)
def test_options_show_what_differs_from_the_defaults(value: object, shown: str) -> None:
    assert repr(value) == shown


def test_a_long_line_is_cut_and_a_broken_one_joined() -> None:
    assert shortened("a\n  b") == "a b"
    assert shortened("x" * 500, 20) == "x" * 17 + "..."
    long = repr(drystone.Result("check", drystone.Verdict.UNSTABLE, Model.of(tower(2)), "x" * 500))
    assert (len(long), long[-4:]) == (180, "...)")


def test_a_list_without_entries_is_as_the_tuple_that_is_the_default() -> None:
    given = sequence.Rules(before=[], reach=[], hands=1)
    assert drystone.plan(tower(2), options=sequence.PlanOptions(rules=given)).asked.options == {
        "hands": "1"
    }
