"""What ``import drystone`` offers: its names, what they say of themselves, and that it is true."""

import ast
import copy
import importlib
import inspect
import pickle
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import drystone

PACKAGE = Path(drystone.__file__).parent
MODULES = sorted(
    ".".join(("drystone", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(
        ".__init__"
    )
    for path in PACKAGE.rglob("*.py")
    if path.name != "__main__.py"
)


ROOMS = [
    "design",
    "detection",
    "fall",
    "limits",
    "models",
    "report",
    "seismic",
    "sequence",
    "settlement",
    "shells",
    "stability",
    "studies",
    "view",
]


def source(module: str) -> str:
    """Text of a module, found without importing it."""
    path = PACKAGE.joinpath(*module.split(".")[1:])
    file = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    return file.read_text(encoding="utf-8")


WITH_EXAMPLES = [module for module in MODULES if ">>> " in source(module)]
"""They are run with the pages: ``docs/site/test_pages.py``."""


def declared(tree: ast.Module) -> dict[str, str]:
    """Home of each name that ``drystone/__init__.py`` imports for type checkers."""
    (block,) = [
        node
        for node in tree.body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    ]
    return {
        alias.asname or alias.name: node.module or ""
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def test_all_is_what_is_visible() -> None:
    """In a fresh interpreter: other tests import modules, which then are visible as well."""
    code = "import drystone; print(*(n for n in dir(drystone) if not n.startswith('_')))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == sorted([*drystone.__all__, *ROOMS])


def test_a_star_import_brings_every_public_name() -> None:
    names: dict[str, object] = {}
    exec("from drystone import *", names)
    assert set(drystone.__all__) <= set(names)


def test_type_checkers_see_the_same_names_in_the_same_places() -> None:
    homes = declared(ast.parse(source("drystone")))
    assert set(homes) == set(drystone.__all__)
    for name, module in homes.items():
        assert getattr(drystone, name) is getattr(importlib.import_module(module), name)


def test_packages_are_there_after_import() -> None:
    """In a fresh interpreter: other tests import packages, which then are there as well."""
    code = "import drystone; print(*(getattr(drystone, room).__name__ for room in ROOMS))"
    code = f"ROOMS = {ROOMS}; {code}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [f"drystone.{room}" for room in ROOMS]


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(AttributeError, match="no attribute 'chek'"):
        drystone.chek  # noqa: B018


@pytest.mark.parametrize("name", drystone.__all__)
def test_every_public_name_says_what_it_is(name: str) -> None:
    """In its own words: a docstring that is inherited, or made by dataclass, says nothing."""
    value = getattr(drystone, name)
    words = value.__dict__.get("__doc__") if inspect.isclass(value) else value.__doc__
    assert words
    assert not words.startswith(f"{name}(")


def test_there_are_examples() -> None:
    assert len(WITH_EXAMPLES) > 20


def test_the_version_stands_in_one_place() -> None:
    """The build takes it from the package; no other file of the project may say another."""
    checkout = Path(__file__).parents[2]  # the package under test may be installed elsewhere
    project = tomllib.loads((checkout / "pyproject.toml").read_text("utf-8"))
    assert project["project"]["dynamic"] == ["version"]
    assert "version" not in project["project"]
    source = checkout / project["tool"]["hatch"]["version"]["path"]
    assert source == checkout / "src" / "drystone" / "__init__.py"
    assert f'__version__ = "{drystone.__version__}"' in source.read_text("utf-8")


@pytest.mark.parametrize("room", ["", *ROOMS])
def test_every_public_name_can_be_pickled_and_copied(room: str) -> None:
    """So that it can be sent through a pool of processes."""
    home = importlib.import_module(".".join(filter(None, ("drystone", room))))
    for name in home.__all__:
        value = getattr(home, name)
        assert type(pickle.loads(pickle.dumps(value))) is type(value), name
        assert type(copy.deepcopy(value)) is type(value), name
