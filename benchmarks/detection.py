"""Contact detection: first right, then fast, beside the other packages of the field.

``python -m benchmarks.detection [--compas-cra PYTHON] [--compas-dem PYTHON] [--sizes 403,1988]
[--armadillo MODEL.json INTERFACES.json] [--strips]``; each PYTHON is that of an environment with
the package. Every run is a process of its own with one thread; seconds are those of the CPU, which
other work on the machine disturbs least, and ``wall`` is the shortest time on the clock.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

import drystone
from drystone import Assembly, io
from drystone.base.arrays import Floats
from drystone.detection import find_contacts
from drystone.geometry.frames import area_vectors
from drystone.model import Model
from drystone.models import cube_curve, curve_three_blocks, random_pack, wall

WALLS = {403: (13, 31, 1_122), 1_988: (28, 71, 5_767), 10_017: (63, 159, 29_608)}
"""Blocks: courses c, blocks per course l, and the ``c (l - 1) + (c - 1) (2 l - 1)`` joints of a
wall in toothed bond, every other course shifted by half a block and no half blocks."""
TIMED_OUT = 3_600
"""[s] that a peer gets."""
LIBRARIES = ("OPENBLAS", "OMP", "MKL", "NUMBA")
ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in LIBRARIES}


def one_wall(blocks: int) -> Assembly:
    courses, length, _ = WALLS[blocks]
    return wall(courses, length, bond="toothed")


def measure(blocks: int, repeats: int) -> dict[str, Any]:
    """Our own time: from blocks as read to contacts and report. The joints are counted first."""
    assembly = one_wall(blocks)
    expected = WALLS[blocks][2]
    seconds, clock = [], []
    for _ in range(repeats):
        fresh = Assembly(assembly.blocks, assembly.fixed)  # nothing kept from the last time
        begin, busy = time.perf_counter(), time.process_time()
        found = find_contacts(fresh)
        seconds.append(time.process_time() - busy)
        clock.append(time.perf_counter() - begin)
        assert found.contacts.count == expected, (found.contacts.count, expected)
    return {
        "contacts": expected,
        "seconds": float(np.median(seconds)),
        "wall": min(clock),
        "peak_gib": _peak_memory() / 2**30,
    }


def _peak_memory() -> float:
    """Largest resident size of this process so far [bytes]."""
    import resource

    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(size if sys.platform == "darwin" else 1024 * size)


def ours(blocks: int, repeats: int) -> dict[str, Any]:
    """:func:`measure` in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.detection", "--only", str(blocks), str(repeats)]
    return json.loads(_run(command))


def theirs(package: str, python: str, blocks: int) -> dict[str, Any]:
    """A peer's time on the same wall."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wall.json"
        data = [
            {"vertices": b.vertices.tolist(), "faces": [list(f) for f in b.faces]}
            for b in one_wall(blocks).blocks
        ]
        path.write_text(json.dumps({"blocks": data}), encoding="utf-8")
        script = Path(__file__).with_name("peers.py")
        try:
            return json.loads(_run([python, str(script), package, str(path)]).splitlines()[-1])
        except subprocess.TimeoutExpired:
            return {"version": "", "contacts": 0, "seconds": float(TIMED_OUT)}


def _run(command: Sequence[str]) -> str:
    done = subprocess.run(
        command,
        env=os.environ | ONE_THREAD,
        capture_output=True,
        text=True,
        timeout=TIMED_OUT,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{done.stderr[-2_000:]}")
    return done.stdout


def walls(sizes: Sequence[int], repeats: int, peers: dict[str, str]) -> None:
    """The table of the walls, pair by pair in the same run."""
    print(f"{'blocks':>7} {'joints':>7} {'drystone':>10} {'wall':>8} {'peak GiB':>9}", end="")
    print("".join(f" {name:>12} {'joints':>7} {'times':>6}" for name in peers))
    times = []
    for blocks in sizes:
        mine = ours(blocks, repeats)
        times.append(mine["seconds"])
        print(
            f"{blocks:>7,} {mine['contacts']:>7,} {mine['seconds']:>8.3f} s {mine['wall']:>6.3f} s"
            f" {mine['peak_gib']:>9.2f}",
            end="",
            flush=True,
        )
        for package, python in peers.items():
            other = theirs(package, python, blocks)
            print(
                f" {other['seconds']:>10.2f} s {other['contacts']:>7,}"
                f" {other['seconds'] / mine['seconds']:>6.0f}",
                end="",
                flush=True,
            )
        print()
    if len(sizes) > 1:
        slope = np.polyfit(np.log(sizes), np.log(times), 1)[0]
        print(f"growth: time ~ blocks^{slope:.2f}")


def pack(count: int = 10_000, sample: int = 300) -> None:
    """Random boxes: the contacts of a sample of blocks against intervals of all others."""
    assembly = random_pack(count, seed=1)
    begin = time.process_time()
    contacts = find_contacts(assembly).contacts
    seconds = time.process_time() - begin
    area: dict[tuple[int, int], float] = {}
    for i, pair in enumerate(
        zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    ):
        assert pair not in area, f"two interfaces between boxes {pair}"
        area[pair] = float(contacts.area[i])
    low, high = assembly.bounds[:, 0], assembly.bounds[:, 1]
    touching = set()
    chosen = np.random.default_rng(0).choice(count, sample, replace=False).tolist()
    for block in chosen:
        shared = np.minimum(high[block], high) - np.maximum(low[block], low)
        flat = np.abs(shared) < 1e-12
        wide = np.where(flat, 1.0, shared)
        for other in np.flatnonzero((flat.sum(axis=1) == 1) & (wide > 0.0).all(axis=1)).tolist():
            pair = (min(block, other), max(block, other))
            touching.add(pair)
            assert abs(area[pair] - wide[other].prod()) < 1e-12, f"area of {pair}"
    of_sample = {pair for pair in area if not set(chosen).isdisjoint(pair)}
    assert of_sample == touching, f"{len(of_sample ^ touching)} pairs differ"
    print(
        f"random pack of {count:,}: {contacts.count:,} contacts in {seconds:.2f} s;"
        f" the {len(touching):,} of {sample} boxes are those of a brute-force check"
    )


def skew_area(first: Floats, second: Floats, normal: Floats) -> float:
    """Common area of two faces in the way of the published interfaces.

    They were found in frames with an edge of the first face and the cross product of its normal
    with that edge as axes, seen along the face's normal. Where the face is warped its edge is not
    square to its normal: the view is oblique, and the area larger by the cosine of that angle.

    Parameters
    ----------
    first, second : (c, 3) [m]
    normal : (3,) unit
        Of the stored interface: it tells which edge was taken.
    """
    vector = area_vectors(first, np.array([0, len(first)]))[0]
    along = vector / np.linalg.norm(vector)
    edges = np.roll(first, -1, axis=0) - first
    across = np.cross(along, edges)
    planes = np.cross(edges, across)
    planes /= np.linalg.norm(planes, axis=1)[:, None]
    edge = int(np.argmax(np.abs(planes @ normal)))
    axes = np.stack([edges[edge], across[edge]])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    view = np.linalg.inv(np.stack([*axes, along]).T)[:2].T
    one, other = (shapely.Polygon((face - first[0]) @ view) for face in (first, second))
    return float(one.intersection(other).area)


def armadillo(model: str, stored: str, repeats: int) -> None:
    """The stored interfaces of a published model: all found, and their areas."""
    assembly = io.read(model).assembly
    seconds = []
    for _ in range(max(repeats, 5)):
        fresh = Assembly(assembly.blocks, assembly.fixed)
        begin = time.process_time()
        report = find_contacts(fresh).report
        seconds.append(time.process_time() - begin)
    found = {
        pair: i
        for i, pair in enumerate(
            zip(report.interfaces.block_a.tolist(), report.interfaces.block_b.tolist(), strict=True)
        )
    }
    assert len(found) == len(report.interfaces.area), "two interfaces between two blocks"
    rows = []
    for entry in json.loads(Path(stored).read_text(encoding="utf-8"))["interfaces"]:
        first, second = (assembly.index(name) for name in entry["blocks"])
        at = found.pop((min(first, second), max(first, second)))
        face = dict(
            zip(
                (int(report.interfaces.block_a[at]), int(report.interfaces.block_b[at])),
                (int(report.interfaces.face_a[at]), int(report.interfaces.face_b[at])),
                strict=True,
            )
        )
        corners = [
            assembly.blocks[i].vertices[list(assembly.blocks[i].faces[face[i]])]
            for i in (first, second)
        ]
        points = np.array(entry["points"])
        vector = area_vectors(points, np.array([0, len(points)]))[0]
        area = float(np.linalg.norm(vector))
        rows.append((area, report.interfaces.area[at], skew_area(*corners, vector / area)))
    areas, own, skew = np.array(rows).T
    missing = np.abs(own - areas)
    held = sum(bool(assembly.fixed[a] and assembly.fixed[b]) for a, b in found)
    print(
        f"{Path(model).name}: {len(assembly)} blocks, all {len(areas):,} stored pairs found"
        f" in {np.median(seconds):.3f} s; median area difference {np.median(missing):.1e} m2,"
        f" relative {np.median(missing / areas):.1e}; {len(found)} further pairs,"
        f" {held} of them between supports; the stored areas are those of oblique views of warped"
        f" faces, to {np.median(np.abs(skew - areas) / areas):.1e} (median) and"
        f" {np.max(np.abs(skew - areas) / areas):.1e} (largest)"
    )


def strips() -> None:
    """Limit tilt of the curved models against the number of strips of their joints."""
    from drystone.limits import LimitOptions, limit_tilt

    print("strips  joints  curve-3-blocks about y  joints  cube-curve about -x")
    for count in (5, 10, 20, 40):
        line = f"{count:>6}"
        for model, axis in ((curve_three_blocks(count), "y"), (cube_curve(strips=count), "-x")):
            contacts = find_contacts(model, friction=0.84).contacts
            limit = limit_tilt(
                Model(model, contacts), axis, upper=90.0, options=LimitOptions(width=0.1)
            )
            value = limit.best.value
            reached = "above 90" if value is None else f"{value:.1f}"
            line += f"  {contacts.count:>6}  {reached:>22}"
        print(line, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--compas-cra", metavar="PYTHON")
    parser.add_argument("--compas-dem", metavar="PYTHON")
    parser.add_argument("--sizes", default=",".join(map(str, WALLS)))
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--armadillo", nargs=2, metavar=("MODEL", "INTERFACES"))
    parser.add_argument("--strips", action="store_true")
    parser.add_argument("--only", nargs=2, type=int, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.only:
        print(json.dumps(measure(*asked.only)))
        return
    print(
        f"drystone {drystone.__version__}, numpy {np.__version__}, Python"
        f" {platform.python_version()}, {platform.processor() or platform.machine()}, one thread"
    )
    peers = {
        name: python
        for name, python in (("compas_cra", asked.compas_cra), ("compas_dem", asked.compas_dem))
        if python
    }
    walls([int(size) for size in asked.sizes.split(",")], asked.repeats, peers)
    pack()
    if asked.armadillo:
        armadillo(*asked.armadillo, asked.repeats)
    if asked.strips:
        strips()


if __name__ == "__main__":
    main()
