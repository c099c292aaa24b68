"""Random pairs of blocks made of unit cubes: which overlap is known from the cubes alone.

``python -m benchmarks.overlaps [--pairs 5000] [--seed 0]`` prints how many overlaps the contact
search missed and how many it made up, for every kind of pair.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from drystone import Assembly, Block, InputError
from drystone.detection import find_contacts
from drystone.geometry.frames import rotation_about
from drystone.geometry.halfedge import merge_coplanar

Cell = tuple[int, int, int]
KINDS = ("anywhere", "touching", "overlapping", "nested")
MOST_CELLS = 8
"""Cubes of a block."""


@dataclass(frozen=True)
class Pair:
    """Two blocks, and the volume [m3] that they share."""

    kind: str
    turned: bool
    assembly: Assembly
    shared: int


def random_pairs(count: int, seed: int) -> Iterator[Pair]:
    """Pairs of all kinds, in turn; half of them turned and far from the origin.

    Of half of the blocks coplanar faces are merged, of the others every square is a face.
    """
    random = np.random.default_rng(seed)
    made = 0
    while made < count:
        kind = KINDS[made % len(KINDS)]
        one = _cells(random, int(random.integers(1, MOST_CELLS)))
        other = _beside(random, kind, one)
        shared = len(one & other)
        if kind == "touching" and (shared or not _touch(one, other)):
            continue
        if kind == "overlapping" and not shared:
            continue
        try:
            blocks = [_block(random, cells, name) for cells, name in ((one, "a"), (other, "b"))]
        except InputError:  # cubes that meet in an edge or a corner only are no block
            continue
        turned = made % 8 >= 4
        if turned:
            rotation = rotation_about(random.normal(size=3), random.uniform(0.0, 180.0))
            shift = random.normal(size=3) * 100.0
            blocks = [block.transformed(rotation, shift) for block in blocks]
        yield Pair(kind, turned, Assembly(tuple(blocks)), shared)
        made += 1


def right(pair: Pair) -> bool:
    """Whether the contact search reports what the pair shares, and nothing else."""
    found = find_contacts(pair.assembly).report.overlaps
    if pair.shared == 0:
        return not found
    return len(found) == 1 and abs(found[0].volume - pair.shared) < 1e-9 and found[0].depth > 0.1


def _cells(random: np.random.Generator, count: int) -> set[Cell]:
    """A connected set of cells."""
    cells = {(0, 0, 0)}
    while len(cells) < count:
        cell = sorted(cells)[random.integers(len(cells))]
        cells.add(sorted(_neighbours(cell))[random.integers(6)])
    return cells


def _neighbours(cell: Cell) -> set[Cell]:
    x, y, z = cell
    return {
        (x + 1, y, z), (x - 1, y, z), (x, y + 1, z), (x, y - 1, z), (x, y, z + 1), (x, y, z - 1)
    }  # fmt: skip


def _touch(one: set[Cell], other: set[Cell]) -> bool:
    return any(_neighbours(cell) & other for cell in one)


def _beside(random: np.random.Generator, kind: str, one: set[Cell]) -> set[Cell]:
    """Cells of the second block: some of the first, in a connected part, or others."""
    if kind == "nested":
        part = {sorted(one)[random.integers(len(one))]}
        for _ in range(int(random.integers(0, len(one)))):
            rim = sorted({n for cell in part for n in _neighbours(cell)} & one - part)
            part |= {rim[random.integers(len(rim))]} if rim else set()
        return part
    x, y, z = random.integers(-3, 4, 3).tolist()
    cells = _cells(random, int(random.integers(1, MOST_CELLS)))
    return {(a + x, b + y, c + z) for a, b, c in cells}


def _block(random: np.random.Generator, cells: set[Cell], name: str) -> Block:
    """The cells as a block."""
    number: dict[Cell, int] = {}
    faces = []
    for cell in sorted(cells):
        for axis, end in product(range(3), (0, 1)):
            beyond = list(cell)
            beyond[axis] += 2 * end - 1
            if tuple(beyond) in cells:
                continue
            loop = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = list(cell)
                corner[axis] += end
                corner[(axis + 1) % 3] += u
                corner[(axis + 2) % 3] += v
                loop.append(number.setdefault(tuple(corner), len(number)))
            faces.append(tuple(loop if end else loop[::-1]))
    point = np.array(list(number), dtype=np.float64)
    if random.random() < 0.5:
        (faces,) = merge_coplanar([point], [faces], 1e-9)
        used = sorted({i for face in faces for i in face})
        new = {old: i for i, old in enumerate(used)}
        point, faces = point[used], [tuple(new[i] for i in face) for face in faces]
    return Block(point, tuple(faces), name=name)


def main() -> None:
    """Count the wrong answers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    count: dict[tuple[str, str], list[int]] = defaultdict(lambda: [0, 0, 0, 0])
    begin = time.process_time()
    for pair in random_pairs(asked.pairs, asked.seed):
        row = count[pair.kind, "turned" if pair.turned else "aligned"]
        row[0] += 1
        row[1] += pair.shared > 0
        if not right(pair):
            row[2 if pair.shared else 3] += 1
    seconds = time.process_time() - begin
    print(
        "| pairs | placed | number | overlap | missed | false alarms |\n|---|---|---|---|---|---|"
    )
    for (kind, placed), row in sorted(count.items()):
        print(f"| {kind} | {placed} | " + " | ".join(f"{n:,}" for n in row) + " |")
    print(f"\n{1e3 * seconds / asked.pairs:.1f} ms of CPU a pair, making it included")


if __name__ == "__main__":
    main()
