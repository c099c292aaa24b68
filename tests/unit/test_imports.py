"""Which module imports which: no circles, and names by which a file is found."""

import ast
import functools
import subprocess
import sys
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import drystone

ROOT = Path(drystone.__file__).parent


def module(path: Path) -> str:
    parts = path.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module(path): path for path in ROOT.rglob("*.py")}


@functools.cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def imported(path: Path) -> set[str]:
    """Modules of the package that a module imports when it is loaded, or for its types."""
    found: set[str] = set()
    waiting: list[ast.stmt] = list(tree(path).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.ImportFrom) and node.module:
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in MODULES else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.If | ast.Try):
            waiting += node.body
    return found & set(MODULES)


def test_no_modules_import_each_other_in_a_circle() -> None:
    """The package itself is left out: it only names what is loaded later."""
    graph = {name: imported(path) - {name, "drystone"} for name, path in MODULES.items()}
    assert len(graph) > 200
    TopologicalSorter(graph).prepare()


def test_a_file_is_found_by_its_name_alone() -> None:
    count = Counter(path.name for path in MODULES.values())
    assert {name for name in count if count[name] > 1} == {"__init__.py"}


def test_a_public_class_has_a_name_of_its_own() -> None:
    nodes = [node for path in MODULES.values() for node in tree(path).body]
    classes = [node.name for node in nodes if isinstance(node, ast.ClassDef)]
    assert len(classes) > 200
    assert [n for n, count in Counter(classes).items() if count > 1 and n[0] != "_"] == []


EXTRAS = (
    "anyio anywidget cascadio casadi compas compas_assembly compas_dem distributed gymnasium "
    "ifcopenshell imageio_ffmpeg mcp mujoco networkx optuna pandas piqp pxr pyarrow pydantic "
    "pyvista reportlab rhino3dm trimesh"
)


def test_only_environments_and_the_protocol_need_an_extra_to_be_loaded() -> None:
    code = """
import importlib, sys
sys.modules.update(dict.fromkeys(sys.argv[1].split()))  # as if they were not installed
for name in sys.argv[2].split():
    try:
        importlib.import_module(name)
    except ImportError:
        print(name)
"""
    names = " ".join(name for name in MODULES if not name.endswith("__main__"))
    ran = subprocess.run(
        [sys.executable, "-c", code, EXTRAS, names], capture_output=True, text=True, check=True
    )
    failed = [name for name in ran.stdout.split() if not name.startswith("drystone.gym")]
    assert failed == ["drystone.mcp.tools"]


def test_without_docstrings_no_option_is_taken_unchecked() -> None:
    """Ranges of options are those of the documentation, which ``python -OO`` takes away."""
    code = "from drystone.detection import DetectionOptions as o; o(gap=-1.0)"  # loads little
    ran = subprocess.run([sys.executable, "-OO", "-c", code], capture_output=True, text=True)
    assert "python -OO takes the docstrings away, by which options are checked" in ran.stderr
    ran = subprocess.run([sys.executable, "-O", "-c", code], capture_output=True, text=True)
    assert "gap is -1" in ran.stderr
