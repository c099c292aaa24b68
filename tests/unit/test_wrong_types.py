"""Values of the wrong type end in one InputError that names them, and never in a traceback."""

import contextlib
import dataclasses
import inspect
import pkgutil
import re
import runpy
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from pathlib import Path
from typing import Any, get_args, get_origin

import numpy as np
import pytest

import drystone
from drystone import (
    Assembly,
    Block,
    CheckOptions,
    Contacts,
    InputError,
    LoadCase,
    Model,
    check,
    find_contacts,
    limits,
    plan,
    programs,
    sequence,
    solve_rbe,
)
from drystone.base.hints import hints_of
from drystone.base.settings import Options
from drystone.limits import Imperfections
from drystone.models import tower
from drystone.programs import RBEOptions
from drystone.report import write_report
from drystone.shells import Layout, ShellBody

TOWER = tower(2)
MODEL = Model.of(TOWER)
CONTACTS = MODEL.contacts
RESULT = check(MODEL)
ROOT = Path(__file__).parents[2]
WRONG = [
    42, 2.5, True, "x", None, [1, 2], {"a": 1}, object(), np.zeros(3), TOWER, CONTACTS, MODEL,
    1j, 10**400, [10**400, 0, 0], np.array([1.0, 2j, 0.0]), np.array(["a", "b"]), b"\0", -1e400,
    float("nan"), {1, 2},
]  # fmt: skip
ALL = tuple(getattr(CONTACTS, name) for name in Contacts.__dataclass_fields__)

CALLS: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
    "find_contacts": (find_contacts, (TOWER,)),
    "Model": (Model, (TOWER, CONTACTS)),
    "Model.of": (Model.of, (TOWER,)),
    "Model.with_load": (MODEL.with_load, (2.0,)),
    "Model.with_contacts": (MODEL.with_contacts, (CONTACTS,)),
    "Model.with_supports": (MODEL.with_supports, ("lowest",)),
    "Model.with_friction": (MODEL.with_friction, (0.5,)),
    "Model.subset": (MODEL.subset, ([0],)),
    "Assembly.with_fixed": (TOWER.with_fixed, ("block-0",)),
    "Assembly.with_density": (TOWER.with_density, (2000.0,)),
    "Assembly.index": (TOWER.index, ("block-0",)),
    "Assembly.transformed": (TOWER.transformed, (np.eye(3), (0.0, 0.0, 1.0))),
    "Block": (Block, (TOWER.blocks[0].vertices, TOWER.blocks[0].faces, "name", 2000.0)),
    "Contacts": (Contacts, ALL),
    "Contacts.select": (CONTACTS.select, ([0],)),
    "LoadCase": (LoadCase, (MODEL.load.wrench,)),
    "LoadCase.of": (LoadCase.of, (TOWER, 1.0)),
    "LoadCase.gravity": (LoadCase.gravity, (TOWER, 9.81, (0, 0, -1))),
    "LoadCase.tilt": (LoadCase.tilt, (TOWER, (1, 0, 0), 5.0, 9.81)),
    "LoadCase.seismic": (LoadCase.seismic, (TOWER, 0.1, 0.1, 9.81)),
    "LoadCase.point_load": (LoadCase.point_load, (TOWER, 1, (0, 0, 1), (0, 0, 1))),
    "LoadCase.line_load": (LoadCase.line_load, (TOWER, 1, (0, 0, 1), (0, 0, 1), (1, 0, 1))),
    "LoadCase.surface_load": (LoadCase.surface_load, (TOWER, 1, 5.0, [0])),
    "LoadCase.moment": (LoadCase.moment, (TOWER, 1, (0, 0, 1))),
    "LoadCase.extra_mass": (LoadCase.extra_mass, (TOWER, 1, 3.0)),
    "LoadCase.settlement": (LoadCase.settlement, (TOWER, 0, (0, 0, 1))),
    "LoadCase.combine": (LoadCase.combine, ([(1.0, MODEL.load)],)),
    "solve_rbe": (solve_rbe, (MODEL,)),
    "settle": (drystone.settle, (MODEL, {0: (0.0, 0.0, 0.01)})),
    "thrust_bounds": (limits.thrust_bounds, (MODEL, 0, (0, 0, 1))),
    "read": (drystone.read, ("absent.obj",)),
}


@pytest.mark.parametrize("name", CALLS)
def test_any_argument_of_another_type_is_refused_or_understood(name: str) -> None:
    """No other error than ours; what is understood (a number as a position) is an answer."""
    call, given = CALLS[name]
    tried = [((*given[:i], w, *given[i + 1 :]), {}) for i in range(len(given)) for w in WRONG]
    named = inspect.signature(call).parameters.values()
    tried += [(given, {p.name: w}) for p in named if p.kind is p.KEYWORD_ONLY for w in WRONG]
    refused = 0
    for arguments, keywords in tried:
        try:
            call(*arguments, **keywords)
        except InputError:
            refused += 1
    assert refused > len(given)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: check(TOWER, CONTACTS), r"check takes 1 argument by position, got 2.*Model\("),
        (lambda: check(TOWER, find_contacts(TOWER)), "check takes 1 argument by position, got 2"),
        (lambda: check(TOWER, CONTACTS, load=(0, 0, -9.81)), r"Model\(assembly, contacts, load\)"),
        (
            lambda: check(42),
            r"given is 42; give Model\(...\), Assembly\(...\), a text, a path or a list",
        ),
        (lambda: check(TOWER, frction=0.6), "no argument 'frction'; did you mean friction"),
        (lambda: check(MODEL, options=RBEOptions()), r"options is RBEOptions.*CheckOptions\("),
        (lambda: check(MODEL, options={"samples": 2}), r"give CheckOptions\("),
        (lambda: check(MODEL, progress=True), "progress is True; give a function"),
        (lambda: check(MODEL, stop=3), "stop is 3; give a function"),
        (
            lambda: plan(MODEL, executor=2),
            r"executor is 2; give Executor\(...\), a function or None",
        ),
        (lambda: plan(MODEL, check=3), "check is 3; give a function"),
        (lambda: plan(MODEL, checkpoint=3), "checkpoint is 3; give a text, a path or None"),
        (lambda: sequence.margins(MODEL), r"plan is Model\(.*give Plan\("),
        (
            lambda: limits.limit_load(MODEL, "x"),
            "no load case is called 'x'.*or write seismic:KX,KY",
        ),
        (
            lambda: limits.limit_load(MODEL, [1, "x"]),
            r"live is \[1, 'x'\]; give LoadCase\(...\), a text, a number or",
        ),
        (lambda: limits.limit_load(MODEL, (1, 0)), r"the load is \(1, 0\); give a load case"),
        (lambda: drystone.check_many(MODEL), r"models is Model\(.*give a list"),
        (
            lambda: drystone.check_many("tower.obj"),
            "models is 'tower.obj'; give a list",
        ),
        (lambda: Model.of(TOWER, friction="0.6"), "friction is '0.6'; give a number"),
        (lambda: Model.of(TOWER, load="1"), "the load is '1'; give a load case"),
        (lambda: check(tower(2).with_fixed([])), "no block is fixed; supports: 'lowest' would fix"),
        (lambda: check(tower(2), supports="block-*"), "every block is fixed, all 2"),
        (lambda: drystone.write(3, "tower.obj"), r"model is 3; give Model\(...\), Assembly"),
        (lambda: drystone.save_figure(MODEL, "tower"), "cannot be written without a suffix"),
        (
            lambda: limits.limit_thickness(tower(3), 2.0, 1.0),
            r"build is Assembly\(.*give a function",
        ),
        (lambda: limits.tilt_sweep(MODEL, 2.5), "directions is 2.5; give a whole number"),
        (lambda: limits.imperfections(MODEL, None), r"give Imperfections\("),
        (
            lambda: limits.imperfections(MODEL, limits.Imperfections(), draws="x"),
            "draws is 'x'; give a whole number",
        ),
        (lambda: drystone.settle(MODEL, (0, 0, -0.1)), "motion is .*; give a dictionary or None"),
        (lambda: drystone.settle(MODEL, {0: (0, 0, 1e308)}), r"'block-0': it is moved by 1e\+308"),
        (
            lambda: drystone.settle(MODEL, {0: (0, 0, 1e20)}),
            r"moved by 1e\+20 m and 0 rad",
        ),
        (lambda: drystone.write(MODEL, 42), "path is 42; give a text or a path"),
        (lambda: drystone.read("tower.obj", up=["z"]), "up is .*; give one of 'z', 'y'"),
        (lambda: check(MODEL, executor=int), "function starts is 0; give LocalWorkers"),
        (lambda: drystone.JointCapacity.dry(-1), "count is -1; give 0 or more"),
        (lambda: check(MODEL, only=3), "only is 3; give a text or a list of texts"),
        (lambda: check(MODEL, without=[None]), r"without is \[None\]; give a text"),
        (lambda: check(MODEL, isolate={1: 2}), r"isolate is \{1: 2\}; give a text"),
        (lambda: check(MODEL, crack=2.0), "crack is 2.0; give a text"),
        (lambda: check(MODEL, joint_capacity=5e3), "joint_capacity is 5000.0; give a text"),
        (lambda: check(MODEL, strength=[5e6]), r"strength is \[5000000.0\]; give a text, a number"),
        (lambda: drystone.diagnose(MODEL, result="x"), r"result is 'x'; give Result\("),
        (lambda: drystone.Structure(MODEL, each_s=None), "each_s is None; give a number"),
        (lambda: drystone.check_many([MODEL], each_s="x"), "each_s is 'x'; give a number"),
        (lambda: drystone.save_figure(MODEL, "a.svg", dpi="x"), "dpi is 'x'; give a number"),
        (
            lambda: drystone.save_figure(MODEL, "a.svg", explode="x"),
            "explode is 'x'; give a number",
        ),
        (
            lambda: drystone.save_figure(MODEL, "a.svg", arrow_scale=""),
            "arrow_scale is ''; give a number",
        ),
        (lambda: drystone.save_figure(MODEL, "a.svg", opacity=""), "opacity is ''; give a number"),
        (lambda: drystone.save_figure(MODEL, "a.svg", stage="x"), "stage is 'x'; give a whole"),
        (lambda: drystone.save_figure(MODEL, "a.svg", section=2), "section is 2; give a text"),
        (lambda: drystone.save_page(MODEL, "a.html", section=2), "section is 2; give a text"),
        (
            lambda: drystone.save_figure(MODEL, "a.svg", ax="x"),
            "ax is 'x'; give axes of matplotlib",
        ),
        (
            lambda: drystone.save_figure(MODEL, "a.svg", layers=3),
            "layers is 3; give a list of texts",
        ),
        (lambda: drystone.save_figure(MODEL, "a.svg", dark=np.ones(3)), "dark is .*; give True or"),
        (lambda: drystone.save_figure(MODEL, "a.svg", preset=[1]), r"preset is \[1\]; give a text"),
        (lambda: drystone.Structure(MODEL, robust="no"), "robust is 'no'; give True or False"),
        (lambda: drystone.read("a.obj", skip_defects="no"), "skip_defects is 'no'; give True or"),
        (lambda: drystone.read("a.obj", load={1: 2}), r"load is \{1: 2\}; give LoadCase\("),
        (lambda: limits.limit_thickness(tower, 2.0, 1.0, unit=3), "unit is 3; give a text"),
        (lambda: drystone.JointCapacity.of(3), "contacts is 3; give the .contacts of a model"),
        (lambda: drystone.JointCapacity.dry(1.5), "count is 1.5; give a whole number"),
        (lambda: LoadCase(MODEL.load.wrench, notes=3), "notes is 3; give a list of texts"),
        (lambda: Assembly(None), "a block"),
        (lambda: Model(TOWER, CONTACTS, notes=3), "notes is 3; give a list of texts"),
        (lambda: Model.of(TOWER, load=[[1, 2], [3]]), "load is .*; give LoadCase"),
        (
            lambda: Block(TOWER.blocks[0].vertices, TOWER.blocks[0].faces, metadata=3),
            "metadata is 3; give a dictionary",
        ),
    ],
)
def test_what_a_newcomer_writes_is_answered_with_a_remedy(
    call: Callable[[], object], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        call()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: CheckOptions(samples=2.5), "samples is 2.5; give a whole number"),
        (lambda: CheckOptions(samples=True), "samples is True; give a whole number"),
        (lambda: CheckOptions(samples=-1), "samples is -1; give 0 or more"),
        (lambda: CheckOptions(settle="yes"), "settle is 'yes'; give True or False"),
        (lambda: limits.LimitOptions(width="x"), "width is 'x'; give a number"),
        (lambda: RBEOptions(objective="cubic"), "give one of 'quadratic', 'linear'"),
        (lambda: RBEOptions(cone=8), r"cone is 8; give FrictionCone\("),
        (lambda: programs.Weights(tension=-1.0), "tension is -1; give 0 or more"),
        (lambda: programs.FrictionCone(sides=2.5), "sides is 2.5; give a whole number"),
        (lambda: limits.LimitOptions(scan=None), "scan is None; give a whole number"),
        (
            lambda: limits.Imperfections(friction_range=0.5),
            "friction_range is 0.5; give a list of numbers",
        ),
        (lambda: sequence.PlanOptions(width=0), "width is 0; give 1 or more"),
        (lambda: sequence.PlanOptions(patience=float("nan")), "patience is nan; give 0 or more"),
        (lambda: sequence.Rules(hands=1.5), "hands is 1.5; give a whole number"),
        (lambda: Layout(staggered=1), "staggered is 1; give True or False"),
        (lambda: ShellBody(ground="sand"), "ground is 'sand'; give one of 'blocks', 'springers'"),
    ],
)
def test_an_option_of_the_wrong_type_is_named(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        make()


def kinds_of_options(kind: type = Options) -> list[type]:
    """All of the package."""
    ours = [one for one in kind.__subclasses__() if one.__module__.startswith("drystone.")]
    below = sorted(ours, key=lambda one: one.__name__)
    return [one for each in below for one in (each, *kinds_of_options(each))]


for module in pkgutil.walk_packages(drystone.__path__, "drystone."):
    with contextlib.suppress(ImportError):  # an extra that is not here
        import_module(module.name)  # they are kinds of options only once they are loaded

NEEDED: dict[str, dict[str, object]] = {
    "Earth": {"side": "x", "weight": 18e3, "k": 0.3},
    "Fill": {"cover": 0.3, "weight": 2e4},
    "Train": {"name": "cart", "places": (0.0,), "loads": (1e3,)},
    "Robot": {"name": "arm"},
    **{one: {"block": "slab"} for one in ("ScaffoldItem", "Strut", "Rope", "Clamp")},
    "Centring": {"block": "slab", "face": np.eye(3)},
}
"""What has no default."""


@pytest.mark.parametrize("kind", kinds_of_options())
def test_any_field_of_another_type_is_refused_or_understood(kind: type) -> None:
    refused = 0
    for field in dataclasses.fields(kind):
        for wrong in [*WRONG, -1, -0.5, float("nan")]:
            try:
                kind(**{**NEEDED.get(kind.__name__, {}), field.name: wrong})
            except InputError:
                refused += 1
    assert refused > len(dataclasses.fields(kind))


def test_arrays_and_numbers_of_numpy_are_taken(tmp_path: Path) -> None:
    down = np.array([0.0, 0.0, -9.81])
    assert np.allclose(check(MODEL, gravity=down).model.load.wrench, MODEL.load.wrench)  # type: ignore[arg-type]
    drystone.write(TOWER, tmp_path / "tower.obj")
    read = drystone.read(tmp_path / "tower.obj", angle=np.float64(3.0), anyway=np.bool_(True))  # type: ignore[arg-type]
    assert read.origin.reading["angle"] == "3"


def test_errors_say_whatever_they_are_given() -> None:
    assert str(InputError(3, remedy=None)) == "3; None"  # type: ignore[arg-type]


def test_an_option_of_a_closed_set_may_be_given_by_its_value() -> None:
    assert RBEOptions(objective="linear").objective is programs.Objective.LINEAR  # type: ignore[arg-type]
    assert CheckOptions(samples=np.int64(3)).samples == 3  # type: ignore[arg-type]
    assert limits.LimitOptions(width=1).width == 1.0


def test_a_number_of_numpy_times_a_load_case_is_a_load_case() -> None:
    twice = np.float64(2.0) * MODEL.load
    assert isinstance(twice, LoadCase)
    assert np.array_equal(twice.wrench, 2.0 * MODEL.load.wrench)
    with pytest.raises(TypeError):
        MODEL.load * "x"
    with pytest.raises(TypeError):
        MODEL.load + 1.0  # type: ignore[operator]


def test_an_analysis_keeps_its_signature() -> None:
    parameters = inspect.signature(check).parameters
    assert list(parameters)[:2] == ["given", "options"]
    assert check.__module__ == "drystone.stability.verdict"
    assert isinstance(check(Assembly(TOWER.blocks, TOWER.fixed)), drystone.Result)


class Odd:
    """A value whose text is a fault of its own."""

    def __repr__(self) -> str:
        raise KeyError("x")


def nested() -> list[Any]:
    """A list in a list, deeper than Python writes it."""
    found: list[Any] = []
    for _ in range(100_000):
        found = [found]
    return found


@pytest.mark.parametrize("make", [nested, lambda: 10**5000, Odd], ids=["deep", "digits", "odd"])
def test_a_value_that_python_cannot_write_is_told_by_its_kind(make: Callable[[], Any]) -> None:
    value = make()
    kind = f"<{type(value).__name__}>"
    calls: list[tuple[Callable[[], object], str]] = [
        (lambda: check(value), f"given is {kind}|{kind} cannot be analysed"),
        (lambda: check(MODEL, friction=value), "friction is"),
        (lambda: check(MODEL, time_limit_s=value), "time_limit_s is"),
        (lambda: Assembly([value]), "is not a block"),
        (lambda: TOWER.index(value), "block"),
        (lambda: CheckOptions(samples=[value]), "samples is"),
        (lambda: drystone.JointCapacity.of_stress(value), "contacts is"),
        (lambda: drystone.save_figure(MODEL, "a.svg", ax=value), "ax is"),
        (lambda: drystone.JointCapacity.dry(-value if kind == "<int>" else value), "count is"),
    ]
    for call, words in calls:
        with pytest.raises(InputError, match=words) as caught:
            call()
        assert len(str(caught.value)) < 200


@pytest.mark.parametrize("bits", [59, 63, 70, 20_000])
def test_a_count_that_no_memory_holds_is_refused(bits: int) -> None:
    with pytest.raises(InputError, match=r"^count is .*; memory holds fewer$"):
        drystone.JointCapacity.dry(2**bits)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: MODEL.subset(np.array(7)), "there is no block 7"),
        (lambda: MODEL.contacts.select(2**63), "no such interfaces"),
        (lambda: drystone.JointCapacity.dry(2).select(2**63), "no such interfaces"),
        (lambda: drystone.JointCapacity.dry(2).select(5), "no such interfaces"),
        (lambda: drystone.JointCapacity.dry(2).scaled("2"), "the share is '2', not a number"),
        (lambda: check(MODEL).thrust_line(blocks=[]), "no blocks are given"),
        (lambda: Imperfections(tolerance=1e308), "give 0 or more, up to 1e+30"),
        (lambda: write_report(2**70, "x.html"), "answers"),
    ],
)
def test_odd_values_of_methods_are_refused(make: Callable[[], object], words: str) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        make()


def test_numbers_of_other_kinds_are_taken_or_refused(tmp_path: Path) -> None:
    for g in (Decimal("9.81"), Fraction(981, 100), np.float64(9.81)):
        assert np.allclose(LoadCase.gravity(TOWER, g).wrench, MODEL.load.wrench)  # type: ignore[arg-type]
        assert np.allclose(LoadCase.seismic(TOWER, 0.1, g=g).acceleration, [0.981, 0, 0])  # type: ignore[arg-type]
    for wrong in (Decimal("NaN"), Decimal("sNaN"), float("nan")):
        with pytest.raises(InputError, match=r"time.limit"):
            check(MODEL, time_limit_s=wrong)  # type: ignore[arg-type]
        with pytest.raises(InputError, match="each_s is"):
            drystone.Structure(MODEL, each_s=wrong)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="give finite numbers"):
        MODEL.load * 1e308
    with pytest.raises(InputError, match="too large for a floating-point number"):
        LoadCase.seismic(TOWER, 1e308)
    with pytest.raises(InputError, match="give finite numbers"):
        LoadCase.extra_mass(TOWER, "block-1", 1e308)


def public_functions() -> list[str]:
    """Those of the reference that ``drystone`` itself does not have, but ``serve``, which waits."""
    rooms = runpy.run_path(str(ROOT / "docs" / "site" / "reference.py"))["ROOMS"].values()
    return sorted(
        f"{module}.{name}"
        for module in {one for many in rooms for one in many} - {"drystone"}
        for name in import_module(module).__all__
        if inspect.isfunction(getattr(import_module(module), name))
        and name not in (*drystone.__all__, "serve")
    )


def usual(hint: Any) -> Any:
    """A value that an annotation allows, where one is known."""
    known = {
        Assembly: TOWER, Model: MODEL, Contacts: CONTACTS, drystone.Result: RESULT, float: 1.0,
        int: 1, str: "block-1", Block: TOWER.blocks[0], np.ndarray: np.ones((2, 6)),
    }  # fmt: skip
    kinds = [get_origin(one) or one for one in (*get_args(hint), hint)]
    return next((value for kind, value in known.items() if kind in kinds), None)


@pytest.mark.parametrize("name", public_functions())
def test_a_public_function_of_a_room_refuses_values_of_another_type(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    room, _, own = name.rpartition(".")
    call = getattr(import_module(room), own)
    hints, known = hints_of(inspect.unwrap(call)), inspect.signature(call).parameters
    named = [one for one in known.values() if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]
    given = {one.name: usual(hints.get(one.name)) for one in named if one.default is one.empty}
    for one in named:
        if one.name in ("how", "progress", "stop", "executor", "time_limit_s"):
            continue
        part = 2.5 if float not in (hints.get(one.name), *get_args(hints.get(one.name))) else -2.5
        for wrong in (part, "?", object(), np.array(["a", "b"]), 10**400, [1, 2]):
            with contextlib.suppress(InputError, drystone.MissingDependency):
                call(**{**given, one.name: wrong})
