"""What the speed benchmark measures: models, loads, the verdict that each must get, and the aim."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import partial
from pathlib import Path

import numpy as np
from scipy.spatial import Voronoi

from drystone import Assembly, Contacts, LoadCase, Model, Verdict, models
from drystone.base.arrays import Floats
from drystone.detection import find_contacts
from drystone.io import read
from drystone.models import welded

X, Y, XY30 = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.7320508075688772, 1.0, 0.0)

Axis = tuple[float, float, float]


class Task(Enum):
    """What is asked of a model."""

    VERDICT = "verdict"
    BALANCE = "equilibrium"
    TILT = "tilt limit"
    PILES = "verdicts of random piles"


@dataclass(frozen=True)
class Workload:
    """One row of the tables.

    Attributes
    ----------
    key
        Name, without spaces.
    group
        The table that it belongs to.
    build
    friction
    expected
        The only verdict that counts. It is proved anew in every run: forces and motion by their
        residuals, a fall by its mechanism.
    axis, tilt_deg
        The assembly is turned counter-clockwise about the axis.
    task
    aim_s : [s]
        For the analysis alone; None where there is none.
    whole_aim_s : [s]
        With all stiffnesses.
    peer
        Whether the peer is asked too.
    large
        Whether one answer takes so long that all stiffnesses are timed on demand only.
    """

    key: str
    group: str
    build: Callable[[], Assembly]
    friction: float
    expected: Verdict
    axis: Axis = Y
    tilt_deg: float = 0.0
    task: Task = Task.VERDICT
    aim_s: float | None = None
    whole_aim_s: float | None = None
    peer: bool = False
    large: bool = False

    def find(self, assembly: Assembly) -> Contacts:
        """The contacts of the model."""
        return find_contacts(assembly, friction=self.friction).contacts

    def load(self, assembly: Assembly) -> LoadCase:
        """Self-weight, turned."""
        return LoadCase.tilt(assembly, self.axis, self.tilt_deg)


LARGE = 2_000
"""Blocks from which on a model is large."""

STANDS, FALLS = Verdict.STABLE, Verdict.UNSTABLE

WALLS = {
    25: (5, 5),
    50: (7, 7),
    100: (10, 10),
    400: (20, 20),
    2_000: (45, 44),
    3_630: (60, 60),
    10_000: (100, 100),
}
"""Courses and block lengths per course, by about the number of blocks."""

WALL_AIMS = {100: 0.1, 400: 0.4, 2_000: 3.0, 10_000: 8.0}
WHOLE_AIMS = {2_000: 6.0, 3_630: 10.0}
BEYOND_AIM_S = 5.0

DOMES = {160: (20, 8), 640: (32, 20), 2_000: (50, 40)}
"""Blocks per ring and rings; bonded, 5 m, 0.5 to 0.25 m thick, an oculus of 1 m."""

VAULTS = {97: (15, 6, 4.0), 635: (31, 20, 8.0), 2_070: (41, 50, 16.0)}
"""Courses, block lengths per course and length; semicircular, 2 m, 0.3 m thick, staggered."""

TILTS = {
    "dome-160": (35.5, 43.7),
    "dome-640": (33.2, 39.0),
    "dome-2000": (28.0, 38.5),
    "vault-97": (20.3, 20.8),
    "vault-635": (13.8, 14.3),
    "vault-2070": (11.8, 12.9),
}
"""Tilts about y [degrees] at which a model stands with uniform contact stiffness, and at which it
has no equilibrium; found by bisection, the largest models more coarsely. Between them a dome may
stand with some stiffness only."""


def small() -> list[Workload]:
    """The small models of Kao 2023 (doctoral dissertation, ETH Zurich), either side of a fall."""
    add = partial(Workload, group="small", aim_s=0.02, peer=True)
    steep = float(np.tan(np.deg2rad(43.0)))
    rest: list[tuple[str, Callable[[], Assembly], float, Verdict]] = [
        *((f"type-{kind}", partial(models.wedge, kind), 0.84, STANDS) for kind in "abcd"),
        ("h", models.h_model, 0.6, FALLS),
        ("a", models.a_model, 0.6, FALLS),
        ("shelf", models.shelf, 0.9, FALLS),
        ("arch", models.arch, steep, STANDS),
        ("concave-short", partial(models.concave, "short"), 0.84, STANDS),
        ("concave-long", partial(models.concave, "long"), 0.84, STANDS),
        ("curve-3-blocks", models.curve_three_blocks, 0.84, STANDS),
        ("cube-curve-short", partial(models.cube_curve, "short"), 0.84, STANDS),
        ("cube-curve-tall", partial(models.cube_curve, "tall"), 0.84, STANDS),
    ]
    tilted: list[tuple[str, Callable[[], Assembly], float, Axis, float, float]] = [
        ("type-a", partial(models.wedge, "a"), 0.84, X, 58.0, 60.0),
        ("type-c", partial(models.wedge, "c"), 0.84, X, 35.0, 47.5),
        ("type-d", partial(models.wedge, "d"), 0.20, Y, 41.0, 41.6),
        ("arch", models.arch, steep, Y, 8.0, 8.4),
        ("curve-3-blocks", models.curve_three_blocks, 0.84, Y, 8.0, 9.5),
    ]
    found = [add(key, build=b, friction=mu, expected=e) for key, b, mu, e in rest]
    for key, build, mu, axis, low, high in tilted:
        for angle, expected in ((low, STANDS), (high, FALLS)):
            name = f"{key}@{angle:g}"
            found.append(
                add(name, build=build, friction=mu, expected=expected, axis=axis, tilt_deg=angle)
            )
    return found


def walls() -> list[Workload]:
    """Running-bond walls, 0.4 x 0.2 x 0.2 m."""
    found = [
        Workload(
            f"wall-{count}",
            "walls",
            partial(models.wall, *shape),
            0.6,
            STANDS,
            aim_s=WALL_AIMS.get(count),
            whole_aim_s=WHOLE_AIMS.get(count),
            peer=count <= 400,
            large=count >= LARGE and count not in WHOLE_AIMS,
        )
        for count, shape in WALLS.items()
    ]
    balance = Workload(
        "wall-10000-equilibrium",
        "walls",
        partial(models.wall, *WALLS[10_000]),
        0.6,
        Verdict.EQUILIBRIUM_EXISTS,
        task=Task.BALANCE,
        large=True,
        aim_s=30.0,
    )
    return [*found, balance]


def shells() -> list[Workload]:
    """Domes and barrel vaults at rest, and either side of their limit."""
    builds: list[tuple[str, int, Callable[[], Assembly], float]] = [
        *(
            ("dome", count, partial(models.dome, slices=s, rings=r, bonded=True), 0.84)
            for count, (s, r) in DOMES.items()
        ),
        *(
            ("vault", count, partial(models.barrel_vault, courses=c, blocks=b, length=y), 0.6)
            for count, (c, b, y) in VAULTS.items()
        ),
    ]
    found: list[Workload] = []
    for family, count, build, mu in builds:
        name = f"{family}-{count}"
        model = partial(Workload, group=family, build=build, friction=mu, large=count >= LARGE)
        found.append(model(name, expected=STANDS, peer=count <= 160))
        for tilt, expected in zip(TILTS[name], (STANDS, FALLS), strict=True):
            aim = BEYOND_AIM_S if expected is FALLS and count >= LARGE else None
            name_at = f"{name}@{tilt:g}"
            found.append(model(name_at, expected=expected, tilt_deg=tilt, aim_s=aim))
    return found


def limits() -> list[Workload]:
    """The tilt limit of the arch, to 0.05 degree; 8.2 degrees in Kao 2023."""
    mu = float(np.tan(np.deg2rad(43.0)))
    return [
        Workload("arch-tilt-limit", "limits", models.arch, mu, STANDS, task=Task.TILT, aim_s=0.5)
    ]


def random_pile(seed: int, blocks: int = 10, most: int = 3, steepest: float = 40.0) -> Model:
    """Boxes of random size in up to ``most`` columns on a slab, tilted by a random angle.

    ``steepest`` is the largest angle [degrees].
    """
    rng = np.random.default_rng((seed, blocks))
    columns = int(rng.integers(1, most + 1))
    width = rng.uniform(0.3, 1.0, columns)
    place = np.cumsum(width + np.where(rng.random(columns) < 0.5, 0.0, 0.2)) - width
    top = np.zeros(columns)
    made = [models.box((1.0 + most, 1.5, 0.3), (-0.5, -0.25, -0.3), name="ground")]
    for number in range(blocks):
        at = number % columns
        size = (float(width[at]), rng.uniform(0.4, 1.0), rng.uniform(0.2, 0.8))
        corner = (float(place[at]), rng.uniform(0.0, 1.0 - size[1]), float(top[at]))
        density = rng.uniform(500.0, 3000.0)
        made.append(models.box(size, corner, name=f"block-{number}", density=density))
        top[at] += size[2]
    assembly = Assembly(tuple(made), np.arange(len(made)) == 0)
    turn, friction = rng.uniform(0.0, 2.0 * np.pi), float(rng.uniform(0.1, 1.0))
    axis = (np.cos(turn), np.sin(turn), 0.0)
    load = LoadCase.tilt(assembly, axis, float(rng.uniform(0.0, steepest)))
    return Model.of(assembly, friction=friction, load=load)


PILES = 100


def piles() -> list[Workload]:
    """A hundred random piles of ten blocks, one verdict each."""
    return [
        Workload(
            f"piles-{PILES}",
            "piles",
            lambda: random_pile(0).assembly,
            0.0,
            STANDS,
            task=Task.PILES,
            aim_s=0.01 * PILES,
        )
    ]


def armadillo(path: Path) -> list[Workload]:
    """The Armadillo vault, 399 blocks of which 33 are fixed, from a model file."""
    build: Callable[[], Assembly] = partial(_assembly, path)
    of_vault = partial(Workload, "armadillo", "armadillo", build, 0.84, STANDS)
    return [of_vault(aim_s=1.0, whole_aim_s=0.7, peer=True)]


def _assembly(path: Path) -> Assembly:
    return read(path).assembly


def workloads(path: Path | None = None) -> dict[str, Workload]:
    """All of them, by name; the Armadillo where its file is given."""
    found = [*small(), *piles(), *walls(), *shells(), *limits()]
    if path is not None:
        found = [*armadillo(path), *found]
    return {work.key: work for work in found}


def voronoi_stones(count: int, seed: int = 1) -> Assembly:
    """Irregular stones: the Voronoi cells of random points in a cube of 2 m, those below fixed."""
    points = 2.0 * np.random.default_rng(seed).random((count, 3))
    images = [points]
    for axis in range(3):
        for side in (0.0, 4.0):
            image = points.copy()
            image[:, axis] = side - image[:, axis]
            images.append(image)
    cells = Voronoi(np.concatenate(images))
    loops: list[list[Floats]] = [[] for _ in points]
    for pair, ridge in zip(cells.ridge_points.tolist(), cells.ridge_vertices, strict=True):
        for cell in pair:
            if cell < count:
                loops[cell].append(cells.vertices[ridge])
    stones = tuple(welded(faces, f"stone-{i}") for i, faces in enumerate(loops))
    assembly = Assembly(stones)
    return assembly.with_fixed(np.flatnonzero(assembly.bounds[:, 0, 2] < 1e-9).tolist())
