"""A vault with curved joints beside its plane twin: ``python -m benchmarks.curved [--all-facets]``.

CPU seconds of search, check, limit tilt and the whole plan; ``benchmarks.live`` has the live page.
``--all-facets`` takes every facet as an interface, which takes minutes.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np

import drystone
from drystone import Assembly, Block, Model
from drystone.base.arrays import Floats
from drystone.detection import DetectionOptions, find_contacts

T = TypeVar("T")


def curved_vault(
    courses: int = 15,
    length: int = 10,
    *,
    facets: int = 3,
    deep: int = 3,
    plane: bool = False,
    radius: float = 2.0,
    thickness: float = 0.3,
    wave: float = 0.35,
) -> Assembly:
    """A barrel vault of voussoirs in running bond, whose axis winds in plan by one wave.

    The first and the last course are supports.

    Parameters
    ----------
    courses, length
        Voussoirs around the barrel, and along an odd course.
    facets, deep
        Facets of a voussoir each way along the surface, and through the thickness; each is two
        triangles.
    plane
        The twin with plane joints: the radius has the wave, and joints are cut radially.
    radius, thickness, wave : [m]
    """

    def point(u: float, v: float, w: float) -> Floats:
        turn, bend = np.pi * (1.0 - u), wave * np.sin(2.0 * np.pi * v)
        out = np.array([np.cos(turn), 0.0, np.sin(turn)])
        away = (w - 0.5) * thickness
        at = np.array([0.0, 0.6 * length * v, 0.0])
        if plane:
            return at + (radius + bend + away) * out
        rate = 2.0 * np.pi * wave * np.cos(2.0 * np.pi * v) / (0.6 * length)
        normal = out - np.array([0.0, rate * out[0], 0.0])
        along_x: Floats = at + np.array([bend, 0.0, 0.0])
        return along_x + radius * out + away * normal / np.linalg.norm(normal)

    blocks, fixed = [], []
    for course in range(courses):
        cuts = np.arange(length + 1) / length
        if course % 2:
            cuts = np.concatenate([[0.0], (np.arange(length) + 0.5) / length, [1.0]])
        u = np.linspace(course, course + 1, facets + 1) / courses
        for k, (begin, end) in enumerate(pairwise(cuts)):
            v = np.linspace(begin, end, facets + 1)
            blocks.append(_voussoir(point, (u, v, np.linspace(0.0, 1.0, deep + 1)), course, k))
            fixed.append(course in (0, courses - 1))
    return Assembly(tuple(blocks), np.array(fixed))


def _voussoir(
    point: Callable[[float, float, float], Floats],
    grid: tuple[Floats, Floats, Floats],
    course: int,
    number: int,
) -> Block:
    """The block between the first and the last values of three parameters, in triangles."""
    place: dict[tuple[int, ...], int] = {}
    vertices: list[Floats] = []

    def vertex(at: tuple[int, ...]) -> int:
        if at not in place:
            place[at] = len(vertices)
            vertices.append(point(*(float(grid[axis][i]) for axis, i in enumerate(at))))
        return place[at]

    faces = []
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, len(grid[axis]) - 1):
            for i in range(len(grid[one]) - 1):
                for j in range(len(grid[other]) - 1):
                    quad = []
                    for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        at = [0, 0, 0]
                        at[axis], at[one], at[other] = end, i + di, j + dj
                        quad.append(vertex(tuple(at)))
                    quad = quad[::-1] if end == 0 else quad
                    faces += [tuple(quad[:3]), (quad[0], *quad[2:])]
    corner = np.array(vertices)
    volume = sum(float(corner[a] @ np.cross(corner[b], corner[c])) for a, b, c in faces)
    turned = faces if volume > 0.0 else [face[::-1] for face in faces]
    return Block(corner, tuple(turned), f"{course}-{number}")


def spent(work: Callable[[], T]) -> tuple[T, float]:
    """What work makes, and the CPU seconds that it takes."""
    begin = time.process_time()
    made = work()
    return made, time.process_time() - begin


def measure(assembly: Assembly, options: DetectionOptions) -> list[float]:
    """CPU seconds of search, check, limits about x and y, and the whole plan."""
    found, search = spent(lambda: find_contacts(assembly, options=options))
    contacts = found.contacts
    print(f"  {contacts.count:,} interfaces, {contacts.corner_count:,} corners", flush=True)
    model = Model(assembly, contacts)
    drystone.check(model)
    checks = spent(lambda: drystone.check(Model(assembly, contacts)))[1]
    limits = []
    for axis in ("x", "y"):
        limit, seconds = spent(lambda axis=axis: drystone.limit_tilt(model, axis=axis))
        print(f"  limit tilt about {axis}: {limit.best.stands:.2f} to {limit.best.falls:.2f}")
        limits.append(seconds)
    plan = spent(lambda: drystone.plan(model))[1]
    return [search, checks, *limits, plan]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all-facets", action="store_true")
    options = DetectionOptions(curve=0.0) if parser.parse_args(arguments).all_facets else None
    drystone.limit_tilt(Model.of(curved_vault(5, 3, plane=True)))
    columns = ("search", "check", "tilt x", "tilt y", "plan")
    print("plane twin")
    twin = measure(curved_vault(plane=True), DetectionOptions.of(options))
    for name, deep in (("3 facets", 1), ("3 x 3 facets", 3)):
        print(name)
        times = measure(curved_vault(deep=deep), DetectionOptions.of(options))
        for column, one, other in zip(columns, times, twin, strict=True):
            print(f"  {column:<7} {one:8.2f} s {other:8.2f} s {one / other:6.1f}")


if __name__ == "__main__":
    main()
