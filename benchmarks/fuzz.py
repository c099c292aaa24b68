"""Damaged files: every reader answers with a model or with one clear error, soon, and does no more.

``python -m benchmarks.fuzz [--inputs 100000] [--seed 0] [--only obj,ply] [--keep FOLDER]``

Files of all formats are made from small models and damaged: bits turned, bytes cut, doubled and
moved, numbers replaced by awkward ones, words of the format strewn in, values of a JSON file
replaced by others, archives that unpack to more than they are. Each input gets 5 CPU s and 1.5 GiB;
an audit hook watches for what a reader must not do: run code, start programs, open sockets, write.

3dm, STEP, IFC and USD are read by a program of its own for each file. Here that program is a fork
of this one, which has the library loaded already. How often it died is told too: a reader answers
that with an error.
"""

from __future__ import annotations

import argparse
import copy
import faulthandler
import json
import os
import random
import re
import runpy
import select
import signal
import subprocess
import sys
import tempfile
import time
import warnings
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import Any
from unittest import mock

import numpy as np

from benchmarks.solid_files import ifc_file, step_file, wall_of_layers
from drystone import io
from drystone.assembly import Assembly
from drystone.base.errors import InputError
from drystone.detection import find_contacts
from drystone.io import Contents
from drystone.loads import LoadCase
from drystone.models import arch, concave, tower

LIMIT_S = 5.0
MEMORY = 3 * 2**29
"""[bytes]"""
OUTSIDE = {"3dm": "rhino3dm", "step": "cascadio", "ifc": "ifcopenshell", "usd": "pxr.Usd"}
"""Package of each format whose library is of another language."""
LIMIT_OUTSIDE_S = 30.0
"""More than each of them may take by itself."""
SHARES = {
    "drystone": 0.32,
    "compas-assembly": 0.1,
    "compas-dem": 0.1,
    "obj": 0.18,
    "stl": 0.1,
    "ply": 0.1,
    "glb": 0.018,
    "dae": 0.01,
    "dxf": 0.01,
    "bricks": 0.02,
    "ldraw": 0.02,
    "3dm": 0.002,
    "step": 0.002,
    "ifc": 0.002,
    "usd": 0.004,
    "mjcf": 0.05,
    "urdf": 0.05,
    "folder": 0.02,
}
"""Of the inputs, by format."""
AWKWARD = (
    *("0", "-0", "1e308", "-1e308", "1e-320", "nan", "NaN", "inf", "-inf", "Infinity", "1e999"),
    *("99999999999999999999", "-1", "4294967295", "2147483648", "0x10", "1_0", "١", "1.", ".5"),
    *("true", "null", '""', "[]", "{}", "[[]]", '"x"', "1" * 400, "-" * 50, "9" * 5000),
)
SMALL = {
    "dae": (
        b'<COLLADA xmlns="a"><asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>'
        b'<library_geometries><geometry id="g"><mesh><source id="s"><float_array>0 0 0 1 0 0 0 1 0'
        b' 0 0 1</float_array><technique_common><accessor stride="3"/></technique_common></source>'
        b'<vertices id="v"><input semantic="POSITION" source="#s"/></vertices><polylist>'
        b'<input semantic="VERTEX" source="#v" offset="0"/><vcount>3 3 3 3</vcount>'
        b"<p>0 2 1 0 1 3 1 2 3 0 3 2</p></polylist></mesh></geometry></library_geometries>"
        b'<library_visual_scenes><visual_scene id="w"><node id="n"><rotate>0 0 1 30</rotate>'
        b'<scale>-1 1 2</scale><instance_geometry url="#g"/></node><node name="b">'
        b'<translate>9 0 0</translate><instance_node url="#n"/></node></visual_scene>'
        b'</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>',
    ),
    "dxf": (
        b"0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n5\n0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n2\nB\n"
        b"0\nLWPOLYLINE\n8\narch\n70\n1\n10\n0\n20\n0\n42\n0.3\n10\n2\n20\n0\n10\n2\n20\n3\n0\nENDBLK\n0\n"
        b"ENDSEC\n0\nSECTION\n2\nENTITIES\n0\nINSERT\n2\nB\n10\n9\n20\n0\n41\n-1\n50\n90\n70\n2\n44\n9\n"
        b"0\nCIRCLE\n8\nsupports\n10\n20\n20\n0\n40\n1\n0\nENDSEC\n0\nEOF\n",
        b"0\nSECTION\n2\nENTITIES\n0\nMESH\n8\na\n92\n4\n10\n0\n20\n0\n30\n0\n10\n1\n20\n0\n30\n0\n10\n0\n"
        b"20\n1\n30\n0\n10\n0\n20\n0\n30\n1\n93\n16\n90\n3\n90\n0\n90\n2\n90\n1\n90\n3\n90\n0\n90\n1\n90\n"
        b"3\n90\n3\n90\n1\n90\n2\n90\n3\n90\n3\n90\n0\n90\n3\n90\n2\n0\nPOLYLINE\n70\n1\n39\n2\n0\nVERTEX\n"
        b"10\n5\n20\n0\n0\nVERTEX\n10\n6\n20\n0\n0\nVERTEX\n10\n6\n20\n1\n0\nSEQEND\n0\nENDSEC\n0\nEOF\n",
    ),
    "bricks": (b"# two\n0 0 0 4 2\n1 0 1 4 2 90 2.3\n", b"2x4 (0,0,0)\n4x2 (1,1,1)\n"),
    "ldraw": (
        b"0 FILE a.ldr\n1 4 0 0 0 1 0 0 0 1 0 0 0 1 3001.dat\n1 16 80 0 0 0 0 1 0 1 0 -1 0 0 b\n"
        b"0 FILE b\n1 4 40 -24 10 1 0 0 0 1 0 0 0 1 3023.dat\n0 STEP\n0 NOFILE\n",
    ),
    "mjcf": (
        b"""<mujoco><compiler angle="degree"/><default><geom friction=".5"/>
<default class="b"><geom type="box" size=".1 .1 .1"/></default></default>
<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>
<worldbody><geom type="plane" size="1 1 1"/><body name="a" pos="0 0 .1" euler="0 0 30"><freejoint/>
<geom class="b"/><body quat="1 0 0 1"><geom type="cylinder" size=".05" fromto="0 0 .1 0 0 .3"/>
</body></body><body name="c" pos="1 0 0"><geom type="mesh" mesh="m"/></body>
</worldbody></mujoco>""",
    ),
    "urdf": (
        b"""<robot name="r"><link name="world"/>
<link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<link name="b"><inertial><mass value="5"/></inertial><collision><origin xyz="0 0 1" rpy="0 0 1"/>
<geometry><cylinder radius="0.4" length="1"/></geometry></collision></link>
<joint type="fixed"><parent link="world"/><child link="a"/></joint>
<joint type="floating"><parent link="world"/><child link="b"/></joint></robot>""",
    ),
    "step": (step_file(tower(2).blocks).encode(), step_file(concave("short").blocks[1:]).encode()),
    "ifc": (
        ifc_file(
            [
                ("IfcFooting", "foot", tower(3).blocks[0], ""),
                ("IfcBuildingElementPart", "stone", tower(3).blocks[1], "wall"),
                ("IfcBuildingElementPart", "stone", tower(3).blocks[2], "wall"),
                ("IfcDoor", "door", arch(voussoirs=5).blocks[2], ""),
            ]
        ).encode(),
    ),
    "usd": (
        b"""#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Cube "base" (prepend apiSchemas = ["PhysicsCollisionAPI"])
{
    double size = 100
}
def Plane "floor" (prepend apiSchemas = ["PhysicsCollisionAPI"])
{
    uniform token axis = "Y"
}
def Xform "top" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
{
    float physics:mass = 12
    double3 xformOp:translate = (5, 50, 0)
    float3 xformOp:scale = (-1, 2, 1)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]
    def Mesh "shape" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {
        int[] faceVertexCounts = [3, 3, 3, 3]
        int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]
        point3f[] points = [(0, 0, 0), (10, 0, 0), (0, 10, 0), (0, 0, 10)]
    }
    def Cylinder "round" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {
        double radius = 2
        double height = 3
        uniform token axis = "X"
    }
}
def PhysicsFixedJoint "held"
{
    rel physics:body0 = </top>
}
""",
    ),
}
"""Sound files of formats that are only read, or of which our own have not all."""
WORDS = {
    "dae": ("<node>", "</node>", "<p>1 2</p>", "<!DOCTYPE a>", '<instance_node url="#n"/>', "&lt;"),
    "dxf": ("0\nLINE", "70\n64", "0\nVERTEX", "210\n0.01", "42\n1e9", "0\nENDSEC", "71\n-5"),
    "bricks": ("1 1", "2x2 (0,0,0)", "0 0 0 99999 99999", "#"),
    "ldraw": ("0 FILE b", "0 NOFILE", "1 4 0 0 0 1 0 0 0 1 0 0 0 1 b", "2 24", "3004.dat"),
    "mjcf": ("<body>", "</body>", "<freejoint/>", '<geom mesh="m"/>', '<joint type="ball"/>'),
    "urdf": ("<link/>", "</link>", "<joint/>", '<mesh filename="x.obj"/>', '<origin xyz="1"/>'),
    "step": ("#9=FACETED_BREP('',#1);", "#1=PLANE('',#2);", "ENDSEC;", "$", "(#1,#1)", ".MILLI."),
    "ifc": ("#9=IFCWALL('a',$,$,$,$,$,$,$,$);", "#1=IFCDIRECTION((0.,0.));", "ENDSEC;", "(#1,#1)"),
    "usd": ('def Sphere "s" {}', "}", "rel a = </b>", "float a = (1", "over </top> {}", "class"),
    "obj": ("f -1 -2 -3", "o", "g", "o a", "v", "f", "curv 0 1", "call x", "\\", "l 1 2", "#"),
    "stl": ("solid x", "endsolid", "facet", "outer loop", "vertex 0 0 0", "endloop", "endfacet"),
    "ply": ("element vertex 9", "property list int int x", "end_header", "comment", "format"),
}
FORBIDDEN = (
    *("exec", "compile", "subprocess.Popen", "os.system", "os.exec", "os.fork", "os.posix_spawn"),
    *("socket.connect", "socket.bind", "pickle.find_class", "ctypes.dlopen", "os.remove"),
    *("os.rename", "os.mkdir", "os.rmdir", "shutil.rmtree", "webbrowser.open", "urllib.Request"),
)
"""Audit events that no reader has a reason for."""


@dataclass
class Tally:
    """What became of the inputs.

    Attributes
    ----------
    outcomes
        Number by format and kind of outcome.
    failures
        Each a format, the number of the input and what went wrong.
    slowest
        [s] by format.
    ends
        How programs of a file ended that did not answer: a signal, or what was raised.
    """

    outcomes: Counter[tuple[str, str]] = field(default_factory=Counter)
    failures: list[tuple[str, int, str]] = field(default_factory=list)
    slowest: dict[str, float] = field(default_factory=dict)
    ends: Counter[str] = field(default_factory=Counter)


class TooSlowError(Exception):
    """An input took longer than :data:`LIMIT_S`."""


@cache
def samples() -> dict[str, list[bytes]]:
    """Sound files of every format, as bytes."""
    models = [tower(2), concave("short"), arch(voussoirs=5)]
    made: dict[str, list[bytes]] = {name: [] for name in SHARES}
    with tempfile.TemporaryDirectory() as folder:
        for model in models:
            contacts = find_contacts(model).contacts
            full = Contents(model, contacts, (LoadCase.gravity(model),))
            for name in SHARES.keys() - SMALL.keys() - {"folder"}:
                made[name] += _written(full, name, Path(folder))
    for name, package in OUTSIDE.items():
        if find_spec(package.partition(".")[0]) is None:
            made.pop(name, None)
    if "ifc" in made:
        layers = [("granite", "stone", 0.2), ("brick", "brick", 0.3)]
        made["ifc"].append(wall_of_layers(layers)[0].to_string().encode())
    made["stl"].append(_binary_stl(models[0]))
    given = made["compas-dem"]
    made["compas-dem"] = [*given, *map(_analysis, given), *map(_problem, given)]
    made["compas-assembly"] += [one for data in made["compas-assembly"] for one in _untyped(data)]
    made["folder"] = [_folder(models[2])]
    for name, files in SMALL.items():
        if name in made:
            made[name] += files
    return {name: files for name, files in made.items() if files}


def _written(model: Contents, name: str, folder: Path) -> list[bytes]:
    path = folder / f"model.{io.format_of('x', name).suffixes[0]}"
    try:
        io.write(model, path, format=name)
    except ImportError:
        return []
    return [path.read_bytes()]


def _untyped(assembly: bytes) -> list[bytes]:
    """An assembly of COMPAS as a network and as lists of lists of meshes."""
    graph = json.loads(assembly)["data"]["graph"]["data"]
    meshes = [node["block"] for node in graph["node"].values()]
    return [json.dumps(one).encode() for one in (graph, [meshes[:1], [meshes[1:]]])]


def _folder(model: Assembly) -> bytes:
    """The files of a folder one after the other, each below a line with its name."""
    with tempfile.TemporaryDirectory() as place:
        files = [Path(place) / name for name in ("stone-9.obj", "stone-10.stl", "stone-11.json")]
        for i, file in enumerate(files):
            io.write(model.subset([i]), file)
        return b"".join(b"=== %s\n%s\n" % (one.name.encode(), one.read_bytes()) for one in files)


def _problem(model: bytes) -> bytes:
    """A problem of compas_dem 0.5, which has its model and one set of conditions."""
    push = {"block_index": 1, "force": [5.0, 0.0, 0.0], "moment": None, "point": [0.5, 0.5, 1.0]}
    square = {"points": [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]]}
    area = {"dtype": "a/Polygon", "data": square}
    press = {"block_index": 1, "polygon": area, "magnitude": 2.0, "direction": None}
    held = {"block_index": 0, "translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0]}
    group = {"g": 9.81, "point_loads": [push], "surface_loads": [press], "displacements": [held]}
    whole = {
        "name": "Problem",
        "model": json.loads(model),
        "boundary_conditions": {"dtype": "a/BoundaryConditions", "data": group},
        "contact_properties": {"contact_model": {"dtype": "a/MohrCoulomb", "data": {"mu": 0.3}}},
    }
    return json.dumps({"dtype": "a/Problem", "data": whole}).encode()


def _analysis(model: bytes) -> bytes:
    """An analysis of compas_dem with a block model in it."""
    load = {"block_index": 1, "force": [5.0, 0.0, 0.0], "point": [0.5, 0.5, 1.0]}
    move = {"block_index": 0, "translation": [None, None, -0.1], "rotation": [0.0, 0.0, 0.1]}
    press = {"block_index": 1, "face_index": 0, "load": [0.0, 0.0, -1.0]}
    group = {"g": 9.0, "point_loads": [load], "displacements": [move], "surface_loads": [press]}
    law = {"contact_model": {"dtype": "a/MohrCoulomb", "data": {"phi": 30.0}}}
    problem = {"name": "live", "boundary_conditions": [group], "contact_properties": law}
    whole = {"model": json.loads(model), "problems": [problem]}
    return json.dumps({"dtype": "a/Analysis", "data": whole}).encode()


def _binary_stl(model: Assembly) -> bytes:
    faces = model.faces
    corner = np.concatenate(
        [faces.point[faces.loop[[a, a + 1, a + 2, a, a + 2, a + 3]]] for a in faces.start[:-1]]
    ).reshape(-1, 9)
    record = np.zeros(len(corner), np.dtype([("n", "<f4", 3), ("c", "<f4", 9), ("s", "<u2")]))
    record["c"] = corner
    return bytes(80) + len(corner).to_bytes(4, "little") + record.tobytes()


def damaged(name: str, files: list[bytes], rng: random.Random) -> bytes:
    """One input."""
    data = rng.choice(files)
    if name.startswith(("drystone", "compas")) and rng.random() < 0.5:
        return _odd_json(data, rng)
    if name in ("mjcf", "urdf", "dae") and rng.random() < 0.5:
        return _odd_xml(data, rng)
    kinds: list[Callable[[bytes, random.Random], bytes]] = [_flip, _cut, _repeat, _swap]
    if name in WORDS or name.startswith(("drystone", "compas", "folder")):
        kinds += [_number, _number]
    for _ in range(rng.choice((1, 1, 1, 2, 4, 16))):
        data = rng.choice(kinds)(data, rng)
    if name in WORDS and rng.random() < 0.3:
        lines = data.split(b"\n")
        lines.insert(rng.randrange(len(lines) + 1), rng.choice(WORDS[name]).encode())
        data = b"\n".join(lines)
    return data


def _flip(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        if out:
            out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def _cut(data: bytes, rng: random.Random) -> bytes:
    a = rng.randrange(len(data) + 1)
    return data[:a] if rng.random() < 0.3 else data[:a] + data[a + rng.choice((1, 2, 7, 64)) :]


def _repeat(data: bytes, rng: random.Random) -> bytes:
    a = rng.randrange(len(data) + 1)
    b = min(len(data), a + rng.choice((1, 4, 50, 500)))
    return data[:b] + data[a:b] * rng.choice((1, 2, 20)) + data[b:]


def _swap(data: bytes, rng: random.Random) -> bytes:
    a, b = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return data[b:] + data[a:b] + data[:a]


def _number(data: bytes, rng: random.Random) -> bytes:
    """One number replaced by an awkward one."""
    a = rng.randrange(len(data) + 1)
    digits = b"0123456789.-+e"
    while a < len(data) and data[a] not in digits:
        a += 1
    b = a
    while b < len(data) and data[b] in digits:
        b += 1
    return data[:a] + rng.choice(AWKWARD).encode() + data[b:]


def _odd_json(data: bytes, rng: random.Random) -> bytes:
    """Some values of a JSON file replaced, removed or doubled."""
    content = json.loads(data)
    for _ in range(rng.choice((1, 1, 2, 5))):
        at, key = _somewhere(content, rng)
        if at is None:
            break
        action = rng.random()
        if action < 0.2:
            del at[key]
        elif action < 0.3 and isinstance(at, list):
            at.insert(key, at[key])
        else:
            at[key] = rng.choice(
                (None, True, -1, 0, 1.5, 10**30, "x", "", [], {}, [[]], float("nan"), [1e308] * 3)
            )
    return json.dumps(content).encode()


def _odd_xml(data: bytes, rng: random.Random) -> bytes:
    """Some elements of an XML file removed, doubled or moved, and values of theirs replaced."""
    root = ET.fromstring(data)
    for _ in range(rng.choice((1, 1, 2, 5))):
        every = [one for one in root.iter() if len(one)]
        holder = rng.choice(every)
        one = rng.choice(list(holder))
        action = rng.random()
        if action < 0.1:
            holder.remove(one)
        elif action < 0.2:
            rng.choice(every).append(copy.deepcopy(one))
        elif one.attrib and action < 0.9:
            key = rng.choice(list(one.attrib))
            words = one.attrib[key].split() or [""]
            words[rng.randrange(len(words))] = rng.choice((*AWKWARD, "", "2", "-0.5", "a", "b"))
            one.attrib[key] = " ".join(words)
        else:
            one.text = rng.choice((*AWKWARD, "1 2 3"))
    return ET.tostring(root)


def _somewhere(content: Any, rng: random.Random) -> tuple[Any, Any]:
    """A container in the tree and a key in it, shallow ones as likely as deep ones."""
    at, key = None, None
    value = content
    while isinstance(value, dict | list) and value:
        at = value
        key = rng.choice(list(value)) if isinstance(value, dict) else rng.randrange(len(value))
        value = at[key]
        if rng.random() < 0.25:
            break
    return at, key


class Watch:
    """Notes what the running reader must not do. There is one, since hooks cannot be removed."""

    def __init__(self) -> None:
        self.active = False
        self.seen: list[str] = []
        sys.addaudithook(self._hook)

    def _hook(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.active:
            return
        if event in FORBIDDEN and not (event in ("compile", "exec") and self._reads_annotations()):
            self.seen.append(f"{event} {str(arguments)[:80]}")
        if event == "open" and isinstance(arguments[1], str) and set(arguments[1]) & set("wax+"):
            self.seen.append(f"open {str(arguments)[:80]}")

    def _reads_annotations(self) -> bool:
        """Whether it is an annotation of ours that is compiled, after an error."""
        self.active = False  # to look is an event too
        caller = sys._getframe(2).f_code.co_filename
        self.active = True
        return caller.endswith("typing.py")


@cache
def watching() -> Watch:
    """The watch of this process."""
    return Watch()


def run(
    inputs: int,
    seed: int,
    only: tuple[str, ...] = (),
    keep: Path | None = None,
    outside_s: int | None = None,
) -> Tally:
    """Read ``inputs`` damaged files and tally what became of them.

    Parameters
    ----------
    inputs
    seed
    only
        Formats; all when empty.
    keep
        Folder for the inputs that failed.
    outside_s : [s]
        CPU time after which a program of its own is given up, where that is not the usual one.
    """
    files = samples()
    tally = Tally()
    watch = watching()
    names = [name for name in files if not only or name in only]
    for name in OUTSIDE.keys() & names:
        import_module(OUTSIDE[name])
    programs = _Forks(tally, outside_s)
    before = None
    try:
        with (
            mock.patch("subprocess.run", programs.run),
            tempfile.TemporaryDirectory() as folder,
            warnings.catch_warnings(),
        ):
            _warm_up({name: files[name] for name in names})
            tally.ends.clear()
            before = _limited_memory()
            warnings.simplefilter("error")
            for number, name, data in _inputs(files, inputs, seed, names):
                _one(name, number, data, Path(folder), tally, watch, keep)
    finally:
        _restore_memory(before)
    return tally


def _inputs(
    files: dict[str, list[bytes]], inputs: int, seed: int, names: list[str]
) -> Iterator[tuple[int, str, bytes]]:
    weights = [SHARES[name] for name in names]
    for number in range(inputs):
        rng = random.Random(f"{seed}-{number}")
        (name,) = rng.choices(names, weights)
        yield number, name, damaged(name, files[name], rng)


def _warm_up(files: dict[str, list[bytes]]) -> None:
    """Everything that is imported late is imported now, outside the watch."""
    with tempfile.TemporaryDirectory() as folder:
        for name, sound in files.items():
            for data in (*sound, sound[0][: len(sound[0]) // 2]):
                try:
                    io.read(file_of(name, data, Path(folder)))
                except InputError:
                    continue


def file_of(name: str, data: bytes, folder: Path) -> Path:
    """Write the bytes of a file of a format to a folder."""
    if name == "folder":
        return _unpacked(data, folder / "parts")
    path = folder / f"model{io.format_of('x', name).suffixes[0]}"
    path.write_bytes(data)
    return path


def _unpacked(data: bytes, folder: Path) -> Path:
    """A folder with the files that follow each other in the data, and none besides."""
    folder.mkdir(exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    first, *others = re.split(rb"^=== ([\w. -]{1,60})\n", data, flags=re.MULTILINE)
    for name, content in zip(others[::2], others[1::2], strict=True):
        (folder / name.decode()).write_bytes(content)
    if first:
        (folder / "first.obj").write_bytes(first)
    return folder


def _one(
    name: str,
    number: int,
    data: bytes,
    folder: Path,
    tally: Tally,
    watch: Watch,
    keep: Path | None,
) -> None:
    path = file_of(name, data, folder)
    there = sorted(p.name for p in folder.iterdir())
    limit = LIMIT_OUTSIDE_S if name in OUTSIDE else LIMIT_S
    begin = time.perf_counter()
    wrong = ""
    try:
        with _deadline(limit, busy=name not in OUTSIDE):
            watch.active = name not in OUTSIDE
            io.read(path)
        outcome = "model"
    except InputError as error:
        outcome = type(error).__name__
        if isinstance(error.__cause__, MemoryError):
            wrong = "asks for too much memory"
        if "\n" in str(error) or len(str(error)) > 1000:
            wrong = "error of several lines"
    except TooSlowError:
        outcome, wrong = "hang", f"more than {limit} s"
    except Exception as error:  # any other kind is what is looked for
        outcome, wrong = "other", f"{type(error).__name__}: {error}"
    finally:
        watch.active = False
    spent = time.perf_counter() - begin
    tally.slowest[name] = max(spent, tally.slowest.get(name, 0.0))
    tally.outcomes[name, outcome] += 1
    if watch.seen:
        wrong = f"did {watch.seen[0]}"
        watch.seen.clear()
    if sorted(p.name for p in folder.iterdir()) != there:
        wrong = "left a file"
    if wrong:
        tally.failures.append((name, number, wrong))
        if keep is not None:
            keep.mkdir(parents=True, exist_ok=True)
            (keep / f"{number}-{name}{path.suffix}").write_bytes(data)


class _Forks:
    """Runs the program of a file as a fork of this process, in place of ``subprocess.run``."""

    def __init__(self, tally: Tally, most_s: int | None = None) -> None:
        self.tally, self.most_s = tally, most_s
        self.contents: dict[str, Callable[[bytes, Any], Any]] = {}

    def run(
        self, command: list[str], *, input: bytes, timeout: float, **_: object
    ) -> subprocess.CompletedProcess[bytes]:
        """What the program writes, and 0 if it ended well."""
        program, cpu_s, options = command[-3:]
        if program not in self.contents:
            self.contents[program] = runpy.run_path(program)["content"]
        end, begin = os.pipe()
        child = os.fork()
        if not child:
            os.close(end)
            most_s = int(cpu_s) if self.most_s is None else self.most_s
            _child(begin, self.contents[program], input, json.loads(options), most_s)
        os.close(begin)
        out = b""
        last = time.perf_counter() + timeout
        try:
            while select.select([end], [], [], max(0.0, last - time.perf_counter()))[0]:
                part = os.read(end, 2**20)
                out += part
                if not part:
                    break
            else:
                os.kill(child, signal.SIGKILL)
                raise subprocess.TimeoutExpired(command, timeout)
        finally:
            os.close(end)
            status = os.waitpid(child, 0)[1]
        code = os.waitstatus_to_exitcode(status)
        if code:
            name = signal.Signals(-code).name if code < 0 else out.decode("utf-8", "replace")
            self.tally.ends[f"{Path(program).stem}: {name}"] += 1
        return subprocess.CompletedProcess(command, code, out, b"")


def _child(
    out: int, content: Callable[[bytes, Any], Any], data: bytes, options: Any, cpu_s: int
) -> None:
    """Write what a function makes of a file, and end this process."""
    code = 1
    try:
        faulthandler.disable()
        signal.signal(signal.SIGALRM, signal.SIG_IGN)
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.dup2(nothing, 2)
        _limited_memory(2**31)
        _limited_cpu(cpu_s)
        found = content(data, options)
        answer, code = found if isinstance(found, bytes) else json.dumps(found).encode(), 0
    except BaseException as error:  # a fork ends here, whatever it was
        answer = f"{type(error).__name__}: {str(error)[:80]}".encode()
    with os.fdopen(out, "wb") as pipe:
        pipe.write(answer)
    os._exit(code)


def _limited_cpu(most_s: int) -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_CPU, (most_s, most_s + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class _deadline:  # noqa: N801  # reads as a verb
    """Ends what takes longer, where the system has alarms; ``busy`` counts CPU time only."""

    def __init__(self, seconds: float, busy: bool = False) -> None:
        self.seconds, self.kind = seconds, "PROF" if busy else "REAL"

    def __enter__(self) -> None:
        if hasattr(signal, "setitimer"):
            number = signal.SIGPROF if self.kind == "PROF" else signal.SIGALRM
            signal.signal(number, self._ring)
            signal.setitimer(getattr(signal, f"ITIMER_{self.kind}"), self.seconds)

    def __exit__(self, *_: object) -> None:
        if hasattr(signal, "setitimer"):
            signal.setitimer(getattr(signal, f"ITIMER_{self.kind}"), 0.0)

    @staticmethod
    def _ring(_: int, __: FrameType | None) -> None:
        raise TooSlowError


def _limited_memory(most: int = MEMORY) -> tuple[int, int] | None:
    try:
        import resource
    except ImportError:  # Windows
        return None
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    used = pages * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + most, before[1]))
    return before


def _restore_memory(before: tuple[int, int] | None) -> None:
    if before is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, before)


def main() -> int:
    """Run, print a table, and fail when anything else than a model or a clear error came back."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", type=Path, default=None)
    chosen = parser.parse_args()
    only = tuple(name for name in chosen.only.split(",") if name)
    begin = time.perf_counter()
    tally = run(chosen.inputs, chosen.seed, only, chosen.keep)
    spent = time.perf_counter() - begin
    kinds = sorted({kind for _, kind in tally.outcomes})
    print("| format | " + " | ".join(kinds) + " | slowest [s] |")
    print("|---" * (len(kinds) + 2) + "|")
    for name in sorted(tally.slowest):
        counts = " | ".join(f"{tally.outcomes[name, kind]:,}" for kind in kinds)
        print(f"| {name} | {counts} | {tally.slowest[name]:.2f} |")
    print(f"{sum(tally.outcomes.values()):,} inputs in {spent:.0f} s, seed {chosen.seed}")
    for name, times in sorted(tally.ends.items()):
        print(f"ended without an answer, {times:,} times: {name}")
    for name, number, wrong in tally.failures[:20]:
        print(f"FAILED {name} input {number}: {wrong}")
    print(f"{len(tally.failures)} failures")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
