"""Irregular stones beside the same question of forces: ``python -m benchmarks.irregular``.

Voronoi cells of random points, walls of random polygons, and rubble: convex hulls of points that
were scanned on the faces of such cells. For each size and friction: the verdict, the CPU seconds of
a default check, of one with all stiffnesses, and of RBE on the same model. Exit code 1 where one is
undecided, where RBE says that no forces balance what does not fall, or finds forces where it is
said that there are none.
"""

from __future__ import annotations

import argparse
import fnmatch
import sys
import time
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import ConvexHull, Voronoi

from benchmarks.machine import description
from benchmarks.workloads import voronoi_stones
from drystone import Assembly, Model, Verdict, check, models, solve_rbe
from drystone.base.arrays import Floats
from drystone.results import Result
from drystone.stability import CheckOptions
from drystone.stability.problem import UNBALANCED

SIZES = (60, 150, 500, 1_000, 5_000)
FRICTIONS = (0.3, 0.5, 0.7, 1.0)
POINTS = 80
"""Scanned on each stone."""


def polygon_wall(count: int, seed: int = 1) -> Assembly:
    """A wall of 4 by 2 m, 0.5 m thick, of random polygons, those below fixed."""
    points = np.random.default_rng(seed).random((count, 2)) * [4.0, 2.0]
    for _ in range(2):  # to the centres of their cells: fewer slivers
        points = np.array([cell.mean(axis=0) for cell in _cells(points)])
    stones = [models.prism(cell, (0.0, 0.5), f"stone-{i}") for i, cell in enumerate(_cells(points))]
    return _on_ground(Assembly(tuple(stones)))


def _cells(points: Floats) -> list[Floats]:
    """The corners (c, 2) of the Voronoi cell of each point (n, 2) in 4 by 2 m, around it."""
    images = [points]
    for axis, size in enumerate((4.0, 2.0)):
        for side in (0.0, 2.0 * size):
            image = points.copy()
            image[:, axis] = side - image[:, axis]
            images.append(image)
    found = Voronoi(np.concatenate(images))
    corners = [found.vertices[found.regions[found.point_region[i]]] for i in range(len(points))]
    return [one[ConvexHull(one).vertices] for one in corners]


def rubble(count: int, seed: int = 1) -> Assembly:
    """Convex hulls of points scanned on the faces of Voronoi stones, those below fixed."""
    draw = np.random.default_rng(seed)
    stones = []
    for stone in voronoi_stones(count, seed).blocks:
        corners = np.asarray(stone.vertices)
        facets = corners[ConvexHull(corners).simplices]
        sides = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
        area = np.linalg.norm(sides, axis=1)
        chosen = draw.choice(len(facets), POINTS, p=area / area.sum())
        share = draw.dirichlet(np.ones(3), POINTS)
        scanned = np.einsum("pc,pcx->px", share, facets[chosen])
        hull = scanned[ConvexHull(scanned).simplices]
        stones.append(models.welded(hull, stone.name))
    return _on_ground(Assembly(tuple(stones)))


def _on_ground(assembly: Assembly) -> Assembly:
    return assembly.with_fixed(np.flatnonzero(assembly.bounds[:, 0, 2] < 1e-9).tolist())


FAMILIES: dict[str, Callable[[int], Assembly]] = {
    "voronoi": voronoi_stones,
    "polygons": polygon_wall,
    "rubble": rubble,
}


def _timed(ask: Callable[[], Result]) -> tuple[Result, float]:
    began = time.process_time()
    return ask(), time.process_time() - began


def right(found: Result, forces: Verdict) -> bool:
    """Whether a result decides, and agrees with what RBE says of forces."""
    if forces is Verdict.UNSTABLE:
        return found.verdict is Verdict.UNSTABLE
    proved_none = UNBALANCED in found.message and forces is Verdict.EQUILIBRIUM_EXISTS
    return found.verdict is not Verdict.UNDECIDED and not proved_none


def main(given: Sequence[str] | None = None) -> int:
    """A line for each model."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="*", help="of the names, as 'voronoi-500 1.0'")
    chosen = parser.parse_args(given)
    print(description())
    print(f"{'model':20} {'corners':>7} {'check':>7} {'all':>7} {'RBE':>7} {'ratio':>6}")
    wrong = 0
    for name, build in FAMILIES.items():
        for size in SIZES:
            asked = [mu for mu in FRICTIONS if fnmatch.fnmatch(f"{name}-{size} {mu}", chosen.only)]
            assembly = build(size) if asked else None
            for friction in asked:
                assert assembly is not None
                model = Model.of(assembly, friction=friction)
                found, plain_s = _timed(lambda: check(model))  # noqa: B023
                robust, all_s = _timed(lambda: check(model, options=CheckOptions.robust()))  # noqa: B023
                forces, rbe_s = _timed(lambda: solve_rbe(model))  # noqa: B023
                good = right(found, forces.verdict)
                wrong += not (good and robust.verdict is found.verdict)
                print(
                    f"{name}-{size} {friction:<4} {model.contacts.corner_count:7} {plain_s:7.2f}"
                    f" {all_s:7.2f} {rbe_s:7.2f} {plain_s / rbe_s:6.2f} {found.verdict.value};"
                    f" {forces.verdict.value}; {found.message[:90]}",
                    flush=True,
                )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
