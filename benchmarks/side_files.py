"""Damaged files beside the model: each is used or refused in one clear error, soon.

``python -m benchmarks.side_files [--inputs 20000] [--seed 0] [--only trials] [--keep FOLDER]``

What commands take beside their model: tables of joint capacities, the records that ``plan
--checkpoint``, ``tune --store``, ``study``, ``dataset`` and ``check_many(out=...)`` keep, cases of
``combine``, title blocks, trains, demands of earthquakes, meshes that a scene names, open meshes of
shells, one of several files of a model; and the calls of programs. They are damaged as
:mod:`benchmarks.fuzz` damages models. Half of the records have a right checksum, as if drystone had
written what they hold. Each input gets 10 CPU s and 1.5 GiB. Warnings are errors.
"""

from __future__ import annotations

import argparse
import contextlib
import io as text_io
import json
import logging
import random
import sys
import tempfile
import time
import tomllib
import warnings
import zlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import drystone
from benchmarks.fuzz import (
    Tally,
    TooSlowError,
    _cut,
    _deadline,
    _flip,
    _limited_memory,
    _number,
    _odd_json,
    _repeat,
    _restore_memory,
    _swap,
)
from drystone.base.errors import InputError
from drystone.cli.shell_request import SurfaceRequest, surface_of
from drystone.design import Parameter, TuneOptions, tune
from drystone.limits import limit_train
from drystone.loads import Fill, Train
from drystone.mcp.answers import TOOLS, answer
from drystone.mcp.folder import Folder
from drystone.models import arch, tower
from drystone.report import TitleBlock
from drystone.seismic import SeismicDemand, local_mechanism
from drystone.sequence import DatasetOptions, dataset, read_dataset
from drystone.studies import combinations, study

JOURNALS = ("checkpoint", "trials", "verdicts", "rows of a study", "data set")
"""Kinds whose records have a checksum."""
TOML = ("cases", "title block", "train", "demand")
LIMIT_S = 10.0
"""[CPU s]"""
CASES = b"""situations = ["EQU", "STR"]
[material]
friction = 1.25
[case.weight]
kind = "permanent"
load = "gravity"
[case.push]
kind = "variable"
psi = [0.7, 0.5, 0.3]
load = "block-1:10,0,0N"
group = "wind"
reversible = true
"""
TRAIN = b"""axles = ["9kN at 0m", "9kN at 0.3m"]
contact = "0.2m"
across = "0.5m"
source = "a cart"
"""
DEMAND = b"""code = "ec8"
ag = "0.15g"
soil = "B"
q = 2.0
confidence = 1.2
T1 = 0.3
psi = 0.5
gamma = 1.2
"""
TITLES = b'project = "Old bridge"\nauthor = "N. N."\n'
TABLE = b"block_a,block_b,tension,cohesion,shear\nblock-0,block-1,10,5.5,1e3\nblock-1,block-2,,0,\n"
SCENE = b"""<robot name="r"><link name="world"/><link name="a"><collision><geometry>
<mesh filename="m.obj" scale="1 2 1"/></geometry></collision></link>
<joint type="fixed"><parent link="world"/><child link="a"/></joint></robot>"""
CALLS: tuple[dict[str, Any], ...] = (
    {"tool": "check", "model": {"file": "tower.json", "friction": 0.5, "supports": "lowest"}},
    {"tool": "inspect", "model": {"file": "tower.json", "gap": "2mm", "edges": True}},
    {"tool": "limit", "model": {"file": "tower.json"}, "of": "tilt", "axis": "y", "width": 0.5},
    {
        "tool": "limit",
        "model": {"file": "tower.json"},
        "of": "load",
        "load": [{"kind": "force", "block": "block-1", "force": [1, 0, 0], "point": [0.5, 0.5, 1]}],
    },
    {"tool": "diagnose", "model": {"file": "tower.json", "load": "block-2:1kN"}, "needs": False},
    {"tool": "plan", "model": {"file": "tower.json"}, "hands": 1, "order": "course"},
    {"tool": "files"},
)


def _sheet() -> bytes:
    """An arched sheet as OBJ."""
    rows = [f"v {x} {y} {x * (4 - x) / 4}" for x in range(5) for y in range(4)]
    faces = [f"f {4 * i + j + 1} {4 * i + j + 5} {4 * i + j + 6} {4 * i + j + 2}"
             for i in range(4) for j in range(3)]  # fmt: skip
    return "\n".join([*rows, *faces, ""]).encode()


class SideFiles:
    """What takes each kind of file, in a folder with sound models."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.model = folder, folder / "tower.json"
        drystone.write(drystone.Model.of(tower(3)), self.model)
        (folder / "scene.urdf").write_bytes(SCENE)
        drystone.write(tower(1), folder / "sound.obj")
        self.take: dict[str, tuple[str, Callable[[Path], object]]] = {
            "capacities": ("joints.csv", self._capacities),
            "checkpoint": ("plan", lambda path: drystone.plan(tower(3), checkpoint=path)),
            "trials": ("trials", self._trials),
            "verdicts": ("verdicts", self._verdicts),
            "rows of a study": ("rows", self._study),
            "data set": ("data/orders/00000.journal", self._dataset),
            "cases": ("cases.toml", lambda path: combinations(self.model, path).numbers()),
            "title block": ("title.toml", TitleBlock.read),
            "train": ("train.toml", self._train),
            "demand": ("demand.toml", self._demand),
            "mesh of a scene": ("m.obj", lambda _: drystone.io.read(folder / "scene.urdf")),
            "surface": ("sheet.obj", lambda path: surface_of(SurfaceRequest(str(path)))),
            "several": ("other.obj", self._several),
            "call": ("call.json", self._call),
        }

    def _capacities(self, path: Path) -> object:
        return drystone.read(self.model, joint_capacity=str(path))

    def _trials(self, path: Path) -> object:
        options = TuneOptions(trials=2, batch=2)
        return tune(partial(tower, 2), [Parameter("edge", 0.5, 2.0)], store=path, options=options)

    def _train(self, path: Path) -> object:
        train = Train.named(str(path))
        how = {"fill": Fill(0.3, 20e3), "steps": 1, "friction": 0.8}
        return limit_train(arch(0.3, 3), train=train, **how).numbers()

    def _demand(self, path: Path) -> object:
        site = SeismicDemand.named(path)
        return local_mechanism(tower(2), part="block-1", site=site).numbers()

    def _study(self, path: Path) -> object:
        return study(tower, {"count": [1, 2, 3]}, out=path, friction=0.6).cells()

    def _dataset(self, path: Path) -> object:
        path.parent.mkdir(parents=True, exist_ok=True)
        made = dataset([tower(3)], path.parents[1], options=DatasetOptions(rows=9), friction=0.6)
        return made.card(), read_dataset(path.parents[1]).card()

    def _verdicts(self, path: Path) -> object:
        return drystone.check_many([tower(1), tower(2)], out=path, friction=0.6)

    def _several(self, path: Path) -> object:
        return drystone.read([self.folder / "sound.obj", path], supports="lowest")

    def _call(self, path: Path) -> object:
        """A call as programs make it; what it answers can be written as JSON."""
        try:
            given = json.loads(path.read_bytes())
        except (ValueError, RecursionError):
            return None
        tool = given.pop("tool", None) if isinstance(given, dict) else None
        if not isinstance(tool, str) or tool not in TOOLS:
            return None
        said = answer(tool, given, Folder.of(self.folder, 1.0), 5.0)
        json.dumps(said, allow_nan=True)
        if "error" in said:
            raise InputError(said["error"])
        return said

    def samples(self) -> dict[str, list[bytes]]:
        """Sound files of every kind."""
        made = {"capacities": [TABLE], "surface": [_sheet()], "cases": [CASES]}
        made |= {"title block": [TITLES], "train": [TRAIN], "demand": [DEMAND]}
        for name in JOURNALS:
            file, take = self.take[name]
            take(self.folder / file)
            made[name] = [(self.folder / file).read_bytes()]
        made["mesh of a scene"] = made["several"] = [(self.folder / "sound.obj").read_bytes()]
        made["call"] = [json.dumps(one).encode() for one in CALLS]
        return made


def damaged(name: str, files: list[bytes], rng: random.Random) -> bytes:
    """One input."""
    data = rng.choice(files)
    if name == "call" and rng.random() < 0.8:
        return _odd_json(data, rng)
    if name in JOURNALS and rng.random() < 0.5:
        return _as_if_sound(data, rng)
    if name in TOML and rng.random() < 0.8:
        odd = json.loads(_odd_json(json.dumps(tomllib.loads(data.decode())).encode(), rng))
        return "\n".join(f"{_key(k)} = {_toml(v)}" for k, v in odd.items()).encode()
    for _ in range(rng.choice((1, 1, 1, 2, 4, 16))):
        data = rng.choice((_flip, _cut, _repeat, _swap, _number, _number))(data, rng)
    return data


def _key(name: str) -> str:
    return json.dumps(name)


def _toml(value: Any) -> str:
    """A value of JSON as one of TOML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def _as_if_sound(data: bytes, rng: random.Random) -> bytes:
    """Records with other values and the checksums that belong to them."""
    lines = data.splitlines()
    for _ in range(rng.choice((1, 1, 3))):
        at = rng.randrange(len(lines)) if rng.random() < 0.1 else rng.randrange(1, len(lines))
        text = _odd_json(lines[at].partition(b" ")[2], rng)
        lines[at] = b"%08x %s" % (zlib.crc32(text), text)
    return b"\n".join([*lines, b""])


def run(inputs: int, seed: int, only: tuple[str, ...] = (), keep: Path | None = None) -> Tally:
    """Use ``inputs`` damaged files and tally what became of them.

    Parameters
    ----------
    inputs
    seed
    only
        Kinds; all when empty.
    keep
        Folder for the inputs that failed.
    """
    tally = Tally()
    journals = logging.getLogger("drystone.base.journal")
    level = journals.level
    journals.setLevel(logging.ERROR)  # cut records are told
    with tempfile.TemporaryDirectory() as place, warnings.catch_warnings():
        warnings.simplefilter("error")
        side = SideFiles(Path(place))
        files = side.samples()
        names = [name for name in files if not only or name in only]
        for name in names:
            for data in files[name]:
                _one(side, name, -1, data, Tally(), None)
        before = _limited_memory()
        try:
            for number in range(inputs):
                rng = random.Random(f"{seed}-{number}")
                name = rng.choice(names)
                _one(side, name, number, damaged(name, files[name], rng), tally, keep)
        finally:
            _restore_memory(before)
            journals.setLevel(level)
    return tally


def _one(
    side: SideFiles, name: str, number: int, data: bytes, tally: Tally, keep: Path | None
) -> None:
    file, take = side.take[name]
    path = side.folder / file
    path.write_bytes(data)
    there = sorted(side.folder.iterdir())
    begin = time.process_time()
    wrong = ""
    try:
        with _deadline(LIMIT_S, busy=True), contextlib.redirect_stdout(text_io.StringIO()):
            take(path)
        outcome = "used"
    except InputError as error:
        outcome = type(error).__name__
        if "\n" in str(error) or len(str(error)) > 1000:
            wrong = "error of several lines"
    except TooSlowError:
        outcome, wrong = "hang", f"more than {LIMIT_S:g} CPU s"
    except Exception as error:  # any other kind is what is looked for
        outcome, wrong = "other", f"{type(error).__name__}: {error}"
    tally.slowest[name] = max(time.process_time() - begin, tally.slowest.get(name, 0.0))
    tally.outcomes[name, outcome] += 1
    if sorted(side.folder.iterdir()) != there:
        wrong = "left a file"
    if wrong:
        tally.failures.append((name, number, wrong))
        if keep is not None:
            keep.mkdir(parents=True, exist_ok=True)
            (keep / f"{number}-{Path(file).name}").write_bytes(data)


def main() -> int:
    """Run, print the counts, and fail where something else than an answer came back."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--inputs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="")
    parser.add_argument("--keep", type=Path)
    chosen = parser.parse_args()
    begin = time.process_time()
    only = tuple(filter(None, chosen.only.split(",")))
    tally = run(chosen.inputs, chosen.seed, only, chosen.keep)
    for (name, outcome), count in sorted(tally.outcomes.items()):
        print(f"{name}: {outcome} {count:,}, slowest {tally.slowest[name]:.2f} CPU s")
    total = sum(tally.outcomes.values())
    print(f"{total:,} inputs in {time.process_time() - begin:.0f} CPU s, seed {chosen.seed}")
    for name, number, wrong in tally.failures[:40]:
        print(f"FAILED {name} input {number}: {' '.join(wrong.split())[:300]}")
    print(f"{len(tally.failures)} failures")
    return 1 if tally.failures else 0


if __name__ == "__main__":
    sys.exit(main())
