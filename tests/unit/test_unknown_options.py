"""No option is ignored: one that is not known is refused, and the nearest known one is named."""

import copy
import dataclasses
import importlib
import inspect
import json
import pkgutil
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

import drystone
from drystone import InputError, Model
from drystone.base.settings import Options
from drystone.design import Parameter, tune
from drystone.limits import Imperfections
from drystone.mcp.answers import TOOLS, answer
from drystone.mcp.folder import MODEL, Folder
from drystone.models import tower
from drystone.sequence import plan

BESIDE: dict[str, tuple[Any, ...]] = {
    "assembly_envs": (1,),
    "combinations": ("actions.toml",),
    "dataset": ("data",),
    "imperfections": (Imperfections(offset=0.01),),
    "limit_load": (1.0,),
    "move_supports": ({0: (0.0, 0.0, -1.0)},),
    "shape": (list,),
    "settle": ({0: (0.0, 0.0, -0.01)},),
    "study": ({"friction": (0.6,)},),
    "thrust_bounds": (0,),
}
"""What a function is given by position behind a model."""
SEVERAL = {"check_many", "dataset"}
"""Functions of several models."""
OTHERWISE = {
    "interact": "each keyword is an argument of the function that it is given",
    "replace_block": "each keyword is an argument of Block, which Python refuses",
    "serve": "each keyword is an argument of Live, which Python refuses",
}


def public() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Every function that a room offers."""
    rooms = [one.name for one in pkgutil.walk_packages(drystone.__path__, "drystone.")]
    if find_spec("gymnasium") is None:
        rooms = [one for one in rooms if not one.startswith("drystone.gym")]
    seen = set()
    for name in ["drystone", *(one for one in rooms if "__main__" not in one)]:
        room = importlib.import_module(name) if _offers(name) else None
        for each in getattr(room, "__all__", ()):
            one = getattr(room, each)
            if inspect.isfunction(one) and one not in seen:
                seen.add(one)
                yield each, one


def keywords_of(one: Callable[..., Any], kind: Any) -> list[str]:
    """The parameters of a function that are of a kind."""
    return [each.name for each in inspect.signature(one).parameters.values() if each.kind is kind]


def _offers(name: str) -> bool:
    """Whether a module has a list of what it offers, without importing it."""
    place = Path(drystone.__file__).parent.joinpath(*name.split(".")[1:])
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    return "__all__" in file.read_text(encoding="utf-8")


OFFERED = list(public())
FUNCTIONS = {name: one for name, one in OFFERED if keywords_of(one, inspect.Parameter.VAR_KEYWORD)}
"""Those that take any keyword."""


def test_there_are_such_functions() -> None:
    assert len(FUNCTIONS) > 30
    assert set(OTHERWISE) <= FUNCTIONS.keys()


@pytest.mark.parametrize("name", sorted(FUNCTIONS.keys() - OTHERWISE))
def test_a_misspelt_option_of_a_function_is_refused(name: str) -> None:
    what = [tower(2)] if name in SEVERAL else tower(2)
    for wrong, right in (("frction", "friction"), ("suports", "supports"), ("unts", "units")):
        with pytest.raises(InputError, match=f"no argument '{wrong}'") as caught:
            FUNCTIONS[name](what, *BESIDE.get(name, ()), **{wrong: 0.5})
        known = inspect.signature(FUNCTIONS[name]).parameters["how"].annotation
        if "FileOptions" not in str(known) or right == "units":
            assert right in caught.value.remedy


def test_a_misspelt_keyword_of_a_function_is_refused_whatever_else_it_takes() -> None:
    held = {name: one for name, one in OFFERED if hasattr(one, "__wrapped__")}
    for one in [held[name] for name in held.keys() - OTHERWISE]:
        for right in keywords_of(one, inspect.Parameter.KEYWORD_ONLY):
            with pytest.raises(InputError, match=f"no argument '{right}x'; did .* {right}\\b"):
                one(**{f"{right}x": 1})


ERRORS = {"DrystoneError", "FormatError", "InputError", "MissingDependency"}


@pytest.mark.parametrize("name", sorted({*drystone.__all__} - ERRORS - {"Verdict"}))
def test_a_misspelt_argument_of_a_main_name_is_refused(name: str) -> None:
    """Python's own error does not name the nearest one before 3.13."""
    main = getattr(drystone, name)
    methods = [one for one in vars(main) if one[0] != "_"] if inspect.isclass(main) else []
    public = [getattr(main, one) for one in methods]
    for one in [main, *(one for one in public if inspect.isfunction(one) or inspect.ismethod(one))]:
        known = inspect.signature(one).parameters
        for right in known.keys() - {"self", "how"} if "changed" not in known else ():
            refused = f"^{one.__qualname__} has no argument '{right}x'; did .* {right}\\b"
            with pytest.raises(InputError, match=refused):
                one(**{f"{right}x": 1})


def test_a_method_without_arguments_takes_none() -> None:
    with pytest.raises(InputError, match=r"^Result\.joints has no argument 'srt'; there are none$"):
        drystone.check(tower(2)).joints(srt=1)  # type: ignore[call-arg]
    with pytest.raises(InputError, match=r"^Contacts has no argument 'areas'; did you mean area"):
        Model.of(tower(2)).contacts.with_areas(1.0, areas=1)


def kinds_of_options(kind: type[Options] = Options) -> Iterator[type[Options]]:
    """All of them."""
    for one in kind.__subclasses__():
        yield from (one, *kinds_of_options(one))


def test_a_misspelt_field_of_options_is_refused() -> None:
    kinds = [*kinds_of_options()]
    assert len(kinds) > 30
    for kind in kinds:
        for field in dataclasses.fields(kind):  # type: ignore[arg-type]
            with pytest.raises(InputError, match=f"'{field.name}x'; did .* {field.name}\\b"):
                kind(**{f"{field.name}x": 1})


def test_a_misspelt_option_of_the_models_of_a_search_is_refused() -> None:
    with pytest.raises(InputError, match="no argument 'frction'; did you mean friction"):
        tune(partial(tower, 2), [Parameter("edge", 0.5, 1.0)], how={"frction": 0.5})


@pytest.mark.parametrize("how", [{"units": "mm"}, {"layers": ["a"]}])
def test_options_of_files_are_refused_where_poses_are_of_no_file(how: dict[str, Any]) -> None:
    for given in (tower(1), tower(1).blocks[0]):
        with pytest.raises(InputError, match="is of files"):
            drystone.find_poses(given, **how)


@pytest.mark.parametrize("tool", sorted(TOOLS))
def test_a_misspelt_argument_of_a_program_is_refused(tool: str, tmp_path: Path) -> None:
    drystone.write(Model.of(tower(2)), tmp_path / "tower.json")
    folder, of_model = Folder.of(tmp_path, 1.0), TOOLS[tool].of_model
    model = {"file": "tower.json"}
    for name in TOOLS[tool].arguments or ["axis"]:
        wrong = f"{name}x"
        said = answer(tool, {"model": model, wrong: 1} if of_model else {wrong: 1}, folder, 5.0)
        assert said["what"] == f"there is no argument '{wrong}'"
        assert name in said["remedy"] or not TOOLS[tool].arguments
    for name in MODEL if of_model else ():
        said = answer(tool, {"model": {**model, f"{name}x": 1}}, folder, 5.0)
        assert (said["where"], name in said["remedy"]) == ("model", True)


RECORDS = {"metadata", "options", "time_s"}
"""Objects of a file whose names are free."""


def objects(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The place of every object in a JSON value, but for those whose names are free."""
    if isinstance(value, dict) and not RECORDS & {*place}:
        yield place
        for key, one in value.items():
            yield from objects(one, (*place, key))
    elif isinstance(value, list):
        for number, one in enumerate(value[:2]):
            yield from objects(one, (*place, number))


def test_a_misspelt_name_anywhere_in_a_file_of_ours_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "tower.json"
    drystone.write(drystone.check(tower(2), load="block-1:10,0,0"), file)
    sound = json.loads(file.read_text(encoding="utf-8"))
    places = [*objects(sound)]
    assert len(places) > 6
    for place in places:
        wrong = at = copy.deepcopy(sound)
        for key in place:
            at = at[key]
        at["frction"] = 0.5
        file.write_text(json.dumps(wrong), encoding="utf-8")
        with pytest.raises(InputError, match="unknown field 'frction'; known are"):
            drystone.read(file)


def test_a_field_of_options_among_the_options_is_told_where_it_belongs() -> None:
    with pytest.raises(
        InputError, match=r"give options=PlanOptions\(rules=Rules\(hands=\.\.\.\)\)"
    ):
        plan(tower(2), hands=1)  # type: ignore[call-arg]


def test_a_field_of_the_options_is_told_where_it_belongs() -> None:
    for name, remedy in (("robust", r".robust\(\)"), ("seed", r"\(seed=...\)")):
        with pytest.raises(InputError, match=f"of its options; give options=CheckOptions{remedy}"):
            drystone.check(tower(2), **{name: 1})  # type: ignore[arg-type]
