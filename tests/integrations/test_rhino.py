"""What the script and the component make of shapes and draw, without Rhino."""

from __future__ import annotations

import ast
import json
import re
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import drystone
from drystone.cli import main
from drystone.models import arch

FOLDER = Path(__file__).parents[2] / "integrations" / "rhino"


class Corners(list):
    """Vertices of a mesh."""

    def CombineIdentical(self, *_: bool) -> bool:  # noqa: N802  # the name in RhinoCommon
        """Those of the fake have nothing to combine."""
        return True


class Mesh:
    """A stand-in for a mesh of RhinoCommon: triangles and quadrangles only."""

    def __init__(self, block: drystone.Block | None = None, scale: float = 1.0):
        points = [] if block is None else scale * block.vertices
        self.Vertices = Corners(SimpleNamespace(X=x, Y=y, Z=z) for x, y, z in points)
        self.Faces = []
        for a, b, c, *rest in [] if block is None else block.faces:
            assert len(rest) < 2
            last = rest[0] if rest else c
            self.Faces.append(SimpleNamespace(A=a, B=b, C=c, D=last, IsTriangle=not rest))

    def Append(self, other: Mesh) -> None:  # noqa: N802  # the name in RhinoCommon
        """Take over another one."""
        self.Vertices, self.Faces = other.Vertices, other.Faces


class Document:
    """Rhinoscriptsyntax of a document in millimetres, whose objects are numbered."""

    filter = SimpleNamespace(surface=8, polysurface=16, mesh=32, extrusion=2**30)

    def __init__(self, assembly: drystone.Assembly, friction: float):
        self.meshes = [Mesh(block, 1000.0) for block in assembly.blocks]
        self.boxes = [1000.0 * block.vertices for block in assembly.blocks]
        self.supports = [i for i, fixed in enumerate(assembly.fixed) if fixed]
        self.friction, self.colours, self.said, self.open = friction, {}, [], []
        self.layers: dict[str, list[Any]] = {}

    def __getattr__(self, name: str) -> Any:
        """Rhino writes GetReal for what is get_real here."""
        return object.__getattribute__(self, re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower())

    def get_objects(self, message: str, *_: int, objects: Any = None, preselect: bool = False):
        return self.supports if objects else list(range(len(self.meshes)))

    def get_real(self, *_: Any) -> float:
        return self.friction

    def is_object_solid(self, one: int) -> bool:
        return one not in self.open

    def select_objects(self, some: list[int]) -> None:
        self.said.append(some)

    def message_box(self, text: str, *_: Any) -> None:
        self.said.append(text)

    def coercemesh(self, one: int) -> Mesh:
        return self.meshes[one]

    def bounding_box(self, one: int) -> Any:
        (x, y, z), (a, b, c) = self.boxes[one].min(axis=0), self.boxes[one].max(axis=0)
        return [(x, y, z), (a, y, z), (a, b, z), (x, b, z), (x, y, c), (a, y, c), (a, b, c)]

    def distance(self, start: Any, end: Any) -> float:
        return float(np.linalg.norm(np.subtract(start, end)))

    def object_color(self, one: int, colour: Any = None) -> Any:
        if colour is not None:
            self.colours[one] = colour
        return SimpleNamespace(**dict(zip("RGB", self.colours.get(one, (0, 0, 0)), strict=True)))

    def object_color_source(self, one: int, source: int) -> None:
        del self.colours[one]

    def add_layer(self, name: str, colour: Any) -> str:
        self.layers.setdefault(name, [])
        return name

    def objects_by_layer(self, name: str) -> list[Any]:
        return self.layers[name]

    def delete_objects(self, drawn: list[Any]) -> None:
        drawn.clear()

    def add_line(self, *ends: Any) -> Any:
        return ends

    def add_text_dot(self, text: str, at: Any) -> Any:
        return text, at

    def object_layer(self, one: Any, name: str) -> None:
        self.layers[name].append(one)

    def enable_redraw(self, on: bool) -> None: ...


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """Opens a document and gives the functions of the script; the program runs in this process."""
    unit = SimpleNamespace(ActiveDoc=SimpleNamespace(ModelUnitSystem="mm"))
    scale = SimpleNamespace(UnitScale=lambda one, other: {("mm", "m"): 0.001}[one, other])
    rhino = SimpleNamespace(
        RhinoDoc=unit,
        RhinoMath=scale,
        UnitSystem=SimpleNamespace(Meters="m"),
        Geometry=SimpleNamespace(Mesh=Mesh),
    )

    started = subprocess.run

    def run(line: list[str], **how: Any) -> Any:
        if line[0] != "drystone":
            return started(line, **how)
        capsys.readouterr()  # what the script printed before
        code = main(line[1:])
        told = capsys.readouterr()
        return SimpleNamespace(returncode=code, stdout=told.out, stderr=told.err)

    def open_document(document: Document) -> dict[str, Any]:
        monkeypatch.setitem(sys.modules, "Rhino", rhino)
        monkeypatch.setitem(sys.modules, "rhinoscriptsyntax", document)
        monkeypatch.setattr(subprocess, "run", run)
        monkeypatch.syspath_prepend(FOLDER)
        return runpy.run_path(str(FOLDER / "drystone_rhino.py"))

    return open_document


def test_the_script_draws_verdict_forces_and_what_falls_in_place_of_an_earlier_answer(
    opened: Any,
) -> None:
    assembly = arch(0.2, 4)
    document = Document(assembly, 0.05)
    script = opened(document)
    script["main"]()
    assert document.said == []
    ((told, _),) = document.layers["drystone::verdict"]
    falling = drystone.check(assembly, friction=0.05).falling
    assert told.startswith("UNSTABLE")
    assert 0 < len(falling) <= 4
    assert document.colours == {int(i): script["FALLS"] for i in falling}
    assert document.layers["drystone::forces"] == []
    document.friction = 0.7
    script["main"]()
    ((told, _),) = document.layers["drystone::verdict"]
    lines = np.array(document.layers["drystone::forces"])
    lengths = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)
    sizes = [np.linalg.norm(np.ptp(box, axis=0)) for box in document.boxes]
    assert told.startswith("STABLE")
    assert document.colours == {}
    assert len(lines) == 5
    assert lengths.max() == pytest.approx(max(np.delete(sizes, document.supports)))
    assert lines.mean(axis=1)[:, 2].max() == pytest.approx(1000.0, abs=100.0)  # the crown, in mm


def test_the_script_says_what_is_not_closed_and_what_the_program_refuses(opened: Any) -> None:
    document = Document(arch(0.2, 3), -1.0)
    script = opened(document)
    script["main"]()
    (said,) = document.said
    assert "friction" in said
    document.open, document.said = [1, 2], []
    script["main"]()
    assert document.said == [[1, 2], "2 objects are not closed: selected now"]
    assert document.layers == {}


def test_the_component_asks_the_server_about_the_same_model(
    opened: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assembly = arch(0.2, 8)
    document, path = Document(assembly, 0.7), tmp_path / "model.json"
    opened(document)
    asked = []

    def check(model: dict[str, Any]) -> dict[str, Any]:
        path.write_text(json.dumps(model["content"]))
        asked.append(drystone.read(path, friction=model["friction"]))
        falling = {"count": 1, "first": ["block-3"]}
        return {"verdict": "unstable", "message": "falls", "falling": falling}

    server = SimpleNamespace(Server=lambda link: SimpleNamespace(check=check))
    monkeypatch.setitem(sys.modules, "drystone_client", server)
    component = runpy.run_path(str(FOLDER / "drystone_grasshopper.py"))
    held = [document.meshes[i] for i in document.supports]
    free = [mesh for mesh in document.meshes if mesh not in held]
    assert component["asked"](free, held, 0.7, "link") == ("unstable", "falls", [free[3]])
    (model,) = asked
    assert np.allclose(sorted(model.assembly.volume), sorted(assembly.volume))
    assert model.assembly.fixed.tolist() == [False] * 8 + [True] * 2


@pytest.mark.parametrize("path", [*FOLDER.glob("*.py")], ids=lambda path: path.stem)
def test_the_python_of_rhino_8_can_read_the_files(path: Path) -> None:
    ast.parse(path.read_text("utf-8"), feature_version=(3, 9))
