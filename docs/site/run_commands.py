"""Run the commands that stand on the pages, as a reader would, and say which of them fail.

python docs/site/run_commands.py
python docs/site/run_commands.py --page how-to/loads --slow

Each page has a folder of its own, with a model under each name that the page uses. A command may
answer that something falls (exit code 1). Bad input (2) or a fault (70) is a failure. What needs an
extra that is missing (3) is counted as not run, and so is what takes long, unless ``--slow`` asks
for it.
"""

import argparse
import contextlib
import io
import json
import re
import shlex
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import drystone
from drystone import Assembly, Model, models
from drystone.cli import main as answer

DOCS = Path(__file__).parents[1]
STAYS = r"^(live (?!--client)|mcp )"
"""Commands that serve until they are ended."""
SLOW = (
    r"reproduce|--buildable|--vary|--auto|--aim volume|^tune|^shape|^sharpen|limit sweep|--draws"
    r"|^limit imperf|^push|^scaffold|--sweep|^plan vault|^mend|limit thickness|limit decay|--to \d"
    r"|limit tilt model"
)
"""Beginnings and options of commands that take more than a second or two."""
COMMAND = re.compile(
    r"^(?: {4}|\$ )(?:\S+/bin/)?drystone (.*?)(?: +# .*)?$"
    r"|^\| [^|]+ \| `drystone ([^`|]*\.json[^`|]*)` \|$",
    re.MULTILINE,
)
"""A line of its own, or the cell of a table, on a model."""
WRITES = re.compile(
    r"^```python\n((?:(?!```).)*?(?:write_text|^drystone\.write)\(.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
"""Python by which a page writes its files."""
SHOWN = re.compile(r"^```toml\n# (\S+\.toml)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
"""A file that a page shows, with its name."""


def commands_of(page: Path) -> list[str]:
    """The command lines of a page, in their order."""
    found = COMMAND.findall(page.read_text("utf-8").replace("\\\n", " "))
    return [line or cell for line, cell in found]


def bridge_of_names() -> Assembly:
    """An arch with a keystone on two piers, as the pages name them; its foot is at z = 0."""
    names = {"springer-left": "pier-1", "springer-right": "pier-2", "voussoir-04": "keystone"}
    built = models.arch(0.3, 7)
    blocks = tuple(replace(b, name=names.get(b.name, b.name)) for b in built.blocks)
    return Assembly(blocks, built.fixed)


def loaded() -> dict[str, object]:
    """The file of an arch with the load cases that the pages name."""
    down = {"kind": "gravity"}
    moves = {"kind": "settlement", "block": "pier-2", "motion": [0.01, 0, 0]}
    quake = {"kind": "seismic", "kx": 0.02}
    cases = {"dead": [down], "wind": [quake], "spread": [down, moves]}
    return {"loads": [{"name": name, "parts": parts} for name, parts in cases.items()]}


def moved(built: Assembly, matrix: Any) -> Assembly:
    """An assembly with its vertices multiplied by a matrix."""
    blocks = (replace(b, vertices=b.vertices @ matrix.T) for b in built.blocks)
    return Assembly(tuple(blocks), built.fixed)


def surface(matrix: Any) -> str:
    """The OBJ of half a cylinder, 2 m in radius and 4 m long, as an open mesh."""
    turns, rows = np.linspace(0, np.pi, 13), range(9)
    points = [(2 * np.cos(t), 0.5 * row, 2 * np.sin(t)) for row in rows for t in turns]
    corners = [13 * row + i + 1 for row in rows[1:] for i in range(12)]
    faces = [f"f {one} {one + 1} {one - 12} {one - 13}" for one in corners]
    return "\n".join([*("v {} {} {}".format(*(matrix @ one)) for one in points), *faces])


def drawing(built: Assembly) -> str:
    """The DXF of the front of each block, as a closed polyline on a layer of its own."""
    lines = ["0 SECTION", "2 ENTITIES"]
    for block, fixed in zip(built.blocks, built.fixed, strict=True):
        lines += ["0 LWPOLYLINE", f"8 {'supports' if fixed else block.name}", "90 4", "70 1"]
        lines += [
            f"{code} {x}"
            for point in block.vertices[:4, [0, 2]]
            for code, x in zip((10, 20), point, strict=True)
        ]
    return "\n".join([*lines, "0 ENDSEC", "0 EOF"]).replace(" ", "\n") + "\n"


def write_models(folder: Path, names: set[str], lines: str) -> None:
    """A model under each of the names that a page uses, with the axes and units that it tells."""
    families = {
        "arch": lambda: models.arch(0.2, 9),
        "vault": models.vault,
        "shelf": models.shelf,
        "bridge": models.bridge,
        "snake": models.snake,
        "wall": lambda: models.wall(3, 3),
        "gaps": lambda: models.arch(0.2, 9),
        "thin": lambda: models.arch(0.1, 11),
        "mended": lambda: models.arch(0.15, 11),
        "firm": lambda: models.arch(0.15, 11),
        "dome": models.dome,
    }
    for name in names:
        stem, path = name.split(".")[0], folder / name
        matrix = np.eye(3)
        if re.search(rf"{re.escape(name)}.* --up y", lines):
            matrix = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
        if re.search(rf"{re.escape(name)}.* --units mm", lines):
            matrix *= 1000.0
        if name == "tower.obj":
            drystone.write(Assembly((models.box((1.0, 1.0, 4.0)),), np.array([True])), path)
        elif name == "part.obj":
            drystone.write(Assembly((models.box((1.0, 2.0, 3.0)),)), path)
        elif name == "surface.obj":
            path.write_text(surface(matrix), "utf-8")
        elif path.suffix == ".dxf":
            path.write_text(drawing(bridge_of_names()), "utf-8")
        elif name == "model.json":
            drystone.write(Model.of(bridge_of_names(), friction=0.7), path)
            path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | loaded()), "utf-8")
        elif name == "joints.csv":
            row = "voussoir-02,voussoir-03,1000,500,"
            path.write_text(f"block_a,block_b,tension,cohesion,shear\n{row}\n", "utf-8")
        else:
            built = moved(families.get(stem, bridge_of_names)(), matrix)
            path.write_text("none", "utf-8")  # a command on it says which extra is missing
            with contextlib.suppress(drystone.MissingDependency):
                drystone.write(Model.of(built, friction=0.9 if stem == "shelf" else 0.7), path)


def run(line: str) -> tuple[int, str, float]:
    """Exit code of a command, what it said on the error stream, and its seconds."""
    began, said = time.perf_counter(), io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            code = answer(shlex.split(line))
        except SystemExit as ended:
            code = int(ended.code or 0)
    return code, said.getvalue().strip(), time.perf_counter() - began


def folders(pages: list[Path]) -> Iterator[tuple[Path, Path]]:
    """A folder for each page."""
    for page in pages:
        if commands_of(page):
            with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
                yield Path(name), page


def main() -> int:
    """Run them, and print each with its code."""
    parser = argparse.ArgumentParser(description="Run the commands of the pages.")
    parser.add_argument("--page", default="", help="only pages with this in their name")
    parser.add_argument("--slow", action="store_true", help="those too that take long")
    asked = parser.parse_args()
    pages = [page for page in sorted(DOCS.rglob("*.md")) if asked.page in page.as_posix()]
    count, left, failed = 0, 0, 0
    for folder, page in folders(pages):
        lines = commands_of(page)
        named = {name for line in lines for name in re.findall(r"[\w-]+\.\w+", line)}
        made = set(re.findall(r"(?:--out|--\w+) +(\S+\.\w+)", " ".join(lines)))
        read = {
            n for n in named if n.rsplit(".", 1)[1] in ("json", "obj", "stl", "3dm", "dxf", "csv")
        }
        write_models(
            folder,
            read - (made - {"joints.csv"}) | ({"mended.json", "firm.json"} & read),
            "\n".join(lines),
        )
        for name, block in SHOWN.findall(page.read_text("utf-8")):
            (folder / name).write_text(block, "utf-8")
        for block in WRITES.findall(page.read_text("utf-8")):
            exec(compile(block, page.name, "exec"), {})
        for line in lines:
            if re.search(STAYS, line):
                left += 1
                continue
            if not asked.slow and re.search(SLOW, line):
                left += 1
                continue
            code, said, seconds = run(line)
            missing = code == 3
            count, left = count + (not missing), left + missing
            wrong = code not in (0, 1, 3)
            failed += wrong
            mark = "FAILS" if wrong else "needs an extra" if missing else f"exit {code}"
            print(f"{page.relative_to(DOCS)}: drystone {line}: {mark}, {seconds:.1f} s", flush=True)
            if wrong:
                print(f"    {said}", flush=True)
    print(f"{count} commands run, {failed} failed, {left} not run")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
