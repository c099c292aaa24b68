"""The questions, each with a name that says how its model is made.

Families of :mod:`drystone.models` at many parameters, wedges every 2 degrees, models within a
degree of published limits, piles, stages of assembly, joints that pull, shells, and walls of up to
2,000 blocks. ``--folder`` adds files of models, by their names.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.same_answers import asking
from benchmarks.same_answers.asking import Answer
from benchmarks.workloads import random_pile
from drystone import Assembly, JointCapacity, LoadCase, Model, models, read, shells
from drystone.geometry.frames import LEVEL_AXES
from drystone.reproduce.tilt_cases import studies

PARTS = ("verdicts", "limits", "plans", "mends", "settlements")
STEEP = float(np.tan(np.deg2rad(43.0)))
X, Y, XY30 = LEVEL_AXES["x"], LEVEL_AXES["y"], (1.7320508075688772, 1.0, 0.0)

Made = Callable[[], Model]
Family = tuple[str, Callable[[], Assembly], float]


@dataclass(frozen=True)
class Question:
    """What is asked.

    Attributes
    ----------
    part
        One of :data:`PARTS`.
    group
        For the sample, which takes some of each.
    name
    ask
    """

    part: str
    group: str
    name: str
    ask: Callable[[], Answer]

    @property
    def key(self) -> str:
        """The part and the name."""
        return f"{self.part} {self.name}"


def questions(folder: Path | None = None) -> dict[str, Question]:
    """All of them, by their keys."""
    listed = [*_verdicts(), *_limits(), *_plans(), *_mends(), *_settlements()]
    if folder is not None:
        listed += _of_files(folder)
    found = {one.key: one for one in listed}
    if len(found) != len(listed):
        raise SystemExit("two questions have the same name")
    return found


def answered(
    folder: Path | None, key: str, question: Question | None = None
) -> tuple[Answer, float]:
    """The answer to a question, and the CPU seconds that it took; also in another process."""
    asked = question or questions(folder)[key]
    began = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            answer = asked.ask()
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
    return answer, time.process_time() - began


def _verdicts() -> Iterator[Question]:
    groups = {
        "wedges": _wedges(),
        "published": _published(),
        "families": _families(),
        "tilted": _tilted(),
        "pushed": _pushed(),
        "piles": _piles(),
        "stages": _stages(),
        "capacity": _with_capacity(),
        "shells": _shells(),
        "large": _large(),
    }
    for group, made in groups.items():
        for name, model in made:
            yield Question("verdicts", group, name, partial(_verdict, model))


def _verdict(make: Made) -> Answer:
    return asking.verdict(make())


def _model(build: Callable[[], Assembly], mu: float) -> Model:
    return Model.of(build(), friction=mu)


def _at(build: Callable[[], Assembly], mu: float, axis: Any, tilt: float) -> Model:
    assembly = build()
    return Model.of(assembly, friction=mu, load=LoadCase.tilt(assembly, axis, tilt))


def _wedges() -> Iterator[tuple[str, Made]]:
    for kind in "abcd":
        build = partial(models.wedge, kind)
        for mu, name, axis, tilts in (
            (0.84, "x", X, range(0, 68, 2)),
            (0.84, "y", Y, range(0, 116, 4)),
            (0.84, "xy30", XY30, range(0, 68, 4)),
            (0.2, "x", X, range(0, 28, 2)),
            (0.2, "y", Y, range(2, 78, 6)),
        ):
            for tilt in tilts:
                yield f"wedge-{kind} mu {mu} {name} {tilt}", partial(_at, build, mu, axis, tilt)


def _published() -> Iterator[tuple[str, Made]]:
    for study in studies():
        for beside in (-1.0, -0.4, 0.4, 1.0):
            tilt = study.dem + beside
            make = partial(_at, study.build, study.friction, study.axis, tilt)
            yield f"{study.key} at {tilt:g}", make


def _families() -> Iterator[tuple[str, Made]]:
    for name, build, mu in [*_small(), *_masonry()]:
        yield name, partial(_model, build, mu)


def _small() -> list[Family]:
    found: list[Family] = []
    for mu in (0.2, 0.6, 2.0):
        found += [(f"H mu {mu}", models.h_model, mu), (f"A mu {mu}", models.a_model, mu)]
    for mu in (0.3, 0.6, 0.9, 1.2):
        found += [
            (f"shelf mu {mu}", models.shelf, mu),
            (f"bridge mu {mu}", models.bridge, mu),
            (f"bridge loaded mu {mu}", partial(models.bridge, load=True), mu),
            (f"snake mu {mu}", models.snake, mu),
        ]
    found += [(f"shelf fix {i}", partial(models.shelf, i), 0.9) for i in (1, 2, 3)]
    for mu in (0.1, 0.3, 0.6, 0.84):
        found += [(f"curve-3 mu {mu}", models.curve_three_blocks, mu)]
        for one in ("short", "long"):
            found.append((f"concave-{one} mu {mu}", partial(models.concave, one), mu))
        for one in ("short", "tall"):
            found.append((f"cube-curve-{one} mu {mu}", partial(models.cube_curve, one), mu))
    for angle in (10, 20, 30, 30.9, 31.1, 40):
        found.append((f"incline {angle}", partial(models.incline, angle), 0.6))
        found.append((f"two on incline {angle}", partial(models.two_blocks_on_incline, angle), 0.6))
    for count in (3, 6, 10):
        for share in (0.5, 0.95, 0.999, 1.001, 1.05):
            offsets = models.harmonic_offsets(count, share=share)
            found.append((f"overhang {count} {share}", partial(models.overhang, offsets), 0.6))
    found += [(f"tower {count}", partial(models.tower, count), 0.6) for count in (1, 5, 20, 60)]
    found += [
        ("stool", models.stool, 0.6),
        ("bayonet", models.bayonet, 0.4),
        ("burr", models.burr, 0.4),
        ("hooked bar", models.hooked_bar, 0.6),
        ("hooked bar, open", partial(models.hooked_bar, cheeks=False), 0.6),
        ("wedge-c longer", partial(models.wedge, "c", 0.2), 0.84),
        ("wedge-b longer", partial(models.wedge, "b", 0.1), 0.84),
    ]
    for flare in (5.0, 15.0, 30.0):
        found.append((f"dovetail {flare}", partial(models.dovetail, flare), 0.4))
    for seed in range(8):
        found.append((f"pack {seed}", partial(models.random_pack, 12 + 4 * seed, seed), 0.5))
    return found


def _masonry() -> list[Family]:
    found: list[Family] = []
    for ratio in (0.07, 0.09, 0.105, 0.108, 0.11, 0.15, 0.25):
        for count in (8, 17, 36):
            build = partial(models.arch, ratio, count)
            found.append((f"arch {ratio} {count}", build, STEEP))
    for mu in (0.2, 0.3, 0.395, 0.42, 0.5):
        found.append((f"arch mu {mu}", partial(models.arch, 0.2, 20), mu))
    for width in (0.3, 0.5, 0.7):
        build = partial(models.buttressed_arch, buttress_width=width)
        found.append((f"buttressed arch {width}", build, 0.6))
    for thick in (0.05, 0.08, 0.12, 0.25):
        for bonded in (False, True):
            build = partial(models.dome, thickness=thick, slices=10, rings=6, bonded=bonded)
            found.append((f"dome {thick} {'bonded' if bonded else 'stacked'}", build, 0.7))
    found += [(f"dome mu {mu}", models.dome, mu) for mu in (0.1, 0.2, 0.4, 0.84)]
    for ratio in (0.035, 0.041, 0.045, 0.06):
        found.append((f"lune {ratio}", partial(models.lune, ratio), STEEP))
    for thick in (0.15, 0.2, 0.3):
        build = partial(models.barrel_vault, thickness=thick, courses=11, blocks=4)
        found.append((f"barrel {thick}", build, 0.6))
    for mu in (0.2, 0.4, 0.6):
        found.append((f"barrel mu {mu}", partial(models.barrel_vault, courses=9, blocks=3), mu))
    for thick in (0.1, 0.18, 0.28):
        build = partial(models.vault, thickness=thick)
        found.append((f"vault {thick}", build, 0.7))
    for reach in (0.03, 0.04, 0.05, 0.06, 0.08):
        found.append((f"corbelled wall {reach}", partial(models.corbelled_wall, corbel=reach), 0.6))
    for lean in (2, 5, 8, 12, 16):
        build = partial(models.leaning_column, lean_deg=lean)
        found.append((f"leaning column {lean}", build, 0.6))
    for swing in (0.1, 0.25, 0.5):
        build = partial(models.winding_column, swing=swing)
        found.append((f"winding column {swing}", build, 0.6))
    for reach in (0.3, 0.45, 0.6):
        build = partial(models.corbelled_bridge, reach=reach)
        found.append((f"corbelled bridge {reach}", build, 0.6))
    for rows, length in ((1, 3), (3, 3), (6, 5), (10, 4), (4, 10)):
        found.append((f"wall {rows} {length}", partial(models.wall, rows, length), 0.6))
    return found


def _tilted() -> Iterator[tuple[str, Made]]:
    small = [
        ("arch", models.arch, STEEP, Y, (4, 8, 8.4, 15)),
        ("dome", partial(models.dome, slices=10, rings=6), 0.84, Y, (10, 20, 24, 30, 38, 45)),
        ("dome-160", partial(models.dome, slices=20, rings=8, bonded=True), 0.84, Y, (35.5, 43.7)),
        ("barrel", models.barrel_vault, 0.6, Y, (10, 20, 20.6, 20.8, 25)),
        ("barrel", models.barrel_vault, 0.6, X, (10, 20, 28)),
        ("wall", models.wall, 0.6, X, (10, 15, 20, 26)),
        ("wall", models.wall, 0.6, Y, (20, 25, 30, 32)),
        ("vault", models.vault, 0.7, X, (5, 12, 20)),
        ("vault", models.vault, 0.7, Y, (5, 12, 20)),
        ("snake", models.snake, 0.7, X, (5, 15, 30)),
        ("bridge", models.bridge, 0.9, Y, (5, 15, 30)),
        ("dovetail", models.dovetail, 0.4, Y, (15, 30, 60, 90)),
        ("bayonet", models.bayonet, 0.4, X, (20, 60, 120)),
        ("stool", models.stool, 0.6, XY30, (10, 25, 35)),
        ("pack", partial(models.random_pack, 16, 3), 0.6, XY30, (10, 25, 35)),
    ]
    for name, build, mu, axis, tilts in small:
        letter = {X: "x", Y: "y", XY30: "xy30"}[axis]
        for tilt in tilts:
            yield f"{name} {letter} {tilt}", partial(_at, build, mu, axis, tilt)


def _loaded(build: Callable[[], Assembly], mu: float, load: Callable[[Assembly], Any]) -> Model:
    assembly = build()
    return Model.of(assembly, friction=mu, load=load(assembly))


def _push(share: float, assembly: Assembly) -> LoadCase:
    return LoadCase.gravity(assembly) + LoadCase.seismic(assembly, share)


def _point(force: tuple[float, float, float], assembly: Assembly) -> LoadCase:
    """At the centroid of the highest free block."""
    height = np.where(assembly.fixed, -np.inf, assembly.centroid[:, 2])
    top = int(np.argmax(height))
    at = assembly.centroid[top].tolist()
    return LoadCase.gravity(assembly) + LoadCase.point_load(assembly, top, force, at)


def _pushed() -> Iterator[tuple[str, Made]]:
    families: list[Family] = [
        ("arch", partial(models.arch, 0.2, 20), STEEP),
        ("wall", models.wall, 0.65),
        ("dome", partial(models.dome, slices=10, rings=6), 0.7),
        ("barrel", partial(models.barrel_vault, courses=9, blocks=3), 0.7),
        ("buttressed arch", models.buttressed_arch, 0.6),
        ("tower", partial(models.tower, 6), 0.6),
    ]
    for name, build, mu in families:
        for share in (0.05, 0.15, 0.3, 0.6):
            make = partial(_loaded, build, mu, partial(_push, share))
            yield f"{name} seismic {share}", make
        for down in (1e2, 1e4, 1e6):
            make = partial(_loaded, build, mu, partial(_point, (0.2 * down, 0.0, -down)))
            yield f"{name} point {down:g}", make


def _piles() -> Iterator[tuple[str, Made]]:
    for seed in range(120):
        yield f"pile {seed}", partial(random_pile, seed)
    for seed in range(16):
        yield f"pile of 25 {seed}", partial(random_pile, seed, 25, 5, 20.0)
    for seed in range(6):
        yield f"pile of 50 {seed}", partial(random_pile, seed, 50, 16, 5.0)


def _stage(build: Callable[[], Assembly], mu: float, share: float) -> Model:
    """The supports, and the lowest share of the other blocks."""
    model = _model(build, mu)
    assembly = model.assembly
    free = np.flatnonzero(~assembly.fixed)
    height = assembly.centroid[free, 2].round(9)
    order = free[np.lexsort((free, height))]
    placed = order[: max(1, round(share * len(order)))]
    return model.subset(sorted([*np.flatnonzero(assembly.fixed).tolist(), *placed.tolist()]))


def _shell(kind: str, courses: int) -> Assembly:
    return shells.shell_by_name(
        kind, courses=courses, width=0.9, ground=shells.Ground.BLOCKS
    ).assembly


def _stages() -> Iterator[tuple[str, Made]]:
    families: list[Family] = [
        ("arch", partial(models.arch, 0.15, 16), STEEP),
        ("dome", partial(models.dome, slices=10, rings=6), 0.7),
        ("dome bonded", partial(models.dome, slices=10, rings=6, bonded=True), 0.7),
        ("vault", models.vault, 0.6),
        ("barrel", partial(models.barrel_vault, courses=9, blocks=3), 0.6),
        ("wall", partial(models.wall, 8, 5), 0.6),
        ("leaning column", models.leaning_column, 0.6),
        ("corbelled bridge", models.corbelled_bridge, 0.6),
        ("snake", models.snake, 0.7),
        ("bridge", models.bridge, 0.9),
    ]
    for name, build, mu in families:
        for share in (0.2, 0.4, 0.6, 0.8, 0.95):
            yield f"{name} lowest {share}", partial(_stage, build, mu, share)


def _glued(build: Callable[[], Assembly], mu: float, pull: float) -> Model:
    model = _model(build, mu)
    return model.with_capacity(JointCapacity.of_stress(model.contacts, tension=pull, brittle=False))


def _with_capacity() -> Iterator[tuple[str, Made]]:
    families: list[Family] = [
        ("arch", partial(models.arch, 0.08, 16), STEEP),
        ("overhang", partial(models.overhang, models.harmonic_offsets(5, share=1.2)), 0.6),
        ("leaning column", partial(models.leaning_column, lean_deg=14), 0.6),
        ("H", models.h_model, 0.6),
        ("shelf", models.shelf, 0.9),
        ("corbelled wall", partial(models.corbelled_wall, corbel=0.08), 0.6),
        ("vault", partial(models.vault, thickness=0.15), 0.6),
        ("dome", partial(models.dome, thickness=0.05, slices=10, rings=6), 0.3),
    ]
    for name, build, mu in families:
        for pull in (1e2, 1e3, 1e4, 1e5, 1e6):
            yield f"{name} pulls {pull:g}", partial(_glued, build, mu, pull)


def _shells() -> Iterator[tuple[str, Made]]:
    for kind in ("barrel", "cross", "pavilion", "dome", "free-edge", "three-vaults", "tri-dome"):
        build = partial(_shell, kind, 6)
        for mu in (0.3, 0.7):
            yield f"shell {kind} mu {mu}", partial(_model, build, mu)
        yield f"shell {kind} tilted 15", partial(_at, build, 0.7, XY30, 15.0)
        yield f"shell {kind} lowest 0.7", partial(_stage, build, 0.7, 0.7)


def _large() -> Iterator[tuple[str, Made]]:
    walls = {100: (10, 10), 400: (20, 20), 900: (30, 30), 2000: (45, 44)}
    for count, size in walls.items():
        yield f"wall of {count}", partial(_model, partial(models.wall, *size), 0.6)
    for tilt in (5.0, 12.0, 20.0):
        yield f"wall of 400 x {tilt:g}", partial(_at, partial(models.wall, 20, 20), 0.6, X, tilt)
    yield "wall of 2000 x 4", partial(_at, partial(models.wall, 45, 44), 0.6, X, 4.0)
    for rows in (49, 50, 51):
        yield f"wall {rows} 40", partial(_model, partial(models.wall, rows, 40), 0.6)
    many = partial(models.dome, slices=50, rings=40, bonded=True)
    yield "dome of 2000", partial(_model, many, 0.84)
    dome = partial(models.dome, slices=32, rings=20, bonded=True)
    barrel = partial(models.barrel_vault, courses=31, blocks=20, length=8.0)
    yield "dome of 640", partial(_model, dome, 0.84)
    yield "dome of 640 y 39", partial(_at, dome, 0.84, Y, 39.0)
    yield "barrel of 635", partial(_model, barrel, 0.6)
    yield "barrel of 635 y 14.3", partial(_at, barrel, 0.6, Y, 14.3)


def _limits() -> Iterator[Question]:
    families: list[tuple[str, Callable[[], Assembly], float, str]] = [
        *((f"wedge-{one}", partial(models.wedge, one), 0.84, "x y friction") for one in "ad"),
        *((f"wedge-{one}", partial(models.wedge, one), 0.2, "x y") for one in "abcd"),
        ("arch", partial(models.arch, 0.15, 12), STEEP, "x y load friction"),
        ("thick arch", partial(models.arch, 0.25, 9), 0.6, "y load friction"),
        ("tower", partial(models.tower, 4), 0.6, "x y load friction"),
        ("stool", models.stool, 0.6, "x y load friction"),
        ("incline", partial(models.incline, 20.0), 0.6, "y load friction"),
        ("two on incline", models.two_blocks_on_incline, 0.6, "y load friction"),
        ("wall", partial(models.wall, 4, 3), 0.6, "x y load friction"),
        ("wall of Ferris", partial(models.ferris_wall, 1), 0.65, "load"),
        ("corbelled wall", models.corbelled_wall, 0.6, "x y load friction"),
        ("concave-short", partial(models.concave, "short"), 0.84, "y friction"),
        ("snake", models.snake, 0.7, "x load friction"),
        ("leaning column", partial(models.leaning_column, lean_deg=5.0), 0.6, "x y load"),
        ("dovetail", models.dovetail, 0.4, "x load"),
        ("buttressed arch", models.buttressed_arch, 0.6, "y load friction"),
        ("dome", partial(models.dome, slices=8, rings=4), 0.7, "load friction"),
        ("barrel", partial(models.barrel_vault, courses=7, blocks=2), 0.6, "x y load friction"),
        ("lune", partial(models.lune, 0.06, 12), 0.7, "load"),
        ("pack", partial(models.random_pack, 8, 2), 0.6, "load"),
        ("overhang", partial(models.overhang, models.harmonic_offsets(4, share=0.8)), 0.6, "x y"),
    ]
    for name, build, mu, kinds in families:
        for kind in kinds.split():
            yield Question(
                "limits", name, f"{name} mu {mu:.3g} {kind}", partial(_limit, build, mu, kind)
            )


def _limit(build: Callable[[], Assembly], mu: float, kind: str) -> Answer:
    model = _model(build, mu)
    if kind == "load":
        return asking.limit(model, "load", LoadCase.seismic(model.assembly, 1.0))
    return asking.limit(model, "friction" if kind == "friction" else "tilt", kind)


def _plans() -> Iterator[Question]:
    families: list[Family] = [
        ("tower", partial(models.tower, 6), 0.6),
        ("arch", partial(models.arch, 0.15, 10), STEEP),
        ("arch of 16", partial(models.arch, 0.2, 16), STEEP),
        ("wall", partial(models.wall, 4, 4), 0.6),
        ("corbelled wall", models.corbelled_wall, 0.6),
        ("leaning column", models.leaning_column, 0.6),
        ("winding column", models.winding_column, 0.6),
        ("corbelled bridge", models.corbelled_bridge, 0.6),
        ("snake", models.snake, 0.7),
        ("bridge", models.bridge, 0.9),
        ("shelf", models.shelf, 0.9),
        ("curve-3", models.curve_three_blocks, 0.84),
        ("dovetail", models.dovetail, 0.4),
        ("stool", models.stool, 0.6),
        ("pack", partial(models.random_pack, 10, 1), 0.6),
        ("dome", partial(models.dome, slices=6, rings=3), 0.7),
        ("barrel", partial(models.barrel_vault, courses=5, blocks=2), 0.7),
        ("buttressed arch", partial(models.buttressed_arch, voussoirs=7, courses=3), 0.6),
        ("H", models.h_model, 0.6),
        ("falling arch", partial(models.arch, 0.07, 9), STEEP),
    ]
    for name, build, mu in families:
        yield Question("plans", "plans", name, partial(_plan, build, mu))
    for hands in (1, 3):
        build = partial(models.arch, 0.15, 8)
        name = f"arch with {hands} hands"
        yield Question("plans", "plans", name, partial(_plan, build, STEEP, hands=hands))
    yield Question(
        "plans", "plans", "wall by course", partial(_plan, models.wall, 0.6, order="course")
    )


def _plan(build: Callable[[], Assembly], mu: float, **rules: Any) -> Answer:
    return asking.plan_of(_model(build, mu), **rules)


def _mends() -> Iterator[Question]:
    families: list[Family] = [
        *((f"incline {a}", partial(models.incline, a), 0.4) for a in (25.0, 35.0)),
        ("two on incline", models.two_blocks_on_incline, 0.3),
        ("H", models.h_model, 0.6),
        ("A", models.a_model, 0.6),
        ("shelf", models.shelf, 0.9),
        ("overhang of 3", partial(models.overhang, models.harmonic_offsets(3, share=1.1)), 0.6),
        ("overhang of 5", partial(models.overhang, models.harmonic_offsets(5, share=1.05)), 0.6),
        ("arch of 6", partial(models.arch, 0.08, 6), STEEP),
        ("arch of 9", partial(models.arch, 0.08, 9), STEEP),
        ("slippery arch", partial(models.arch, 0.2, 7), 0.2),
        ("leaning column", partial(models.leaning_column, blocks=4, lean_deg=18.0), 0.6),
        ("winding column", partial(models.winding_column, blocks=5, swing=0.6), 0.6),
        ("corbelled wall", partial(models.corbelled_wall, 4, 2, corbel=0.12), 0.6),
        ("corbelled bridge", partial(models.corbelled_bridge, 2, reach=1.2), 0.6),
        ("slippery buttresses", partial(models.buttressed_arch, voussoirs=5, courses=2), 0.15),
        ("overhang of 2", partial(models.overhang, models.harmonic_offsets(2, share=1.2)), 0.1),
    ]
    for name, build, mu in families:
        yield Question("mends", "mends", name, partial(_mend, build, mu, None))
    for kind, tilt in (("a", 62.0), ("b", 65.0), ("d", 52.0)):
        build = partial(models.wedge, kind)
        name = f"wedge-{kind} tilted {tilt:g}"
        yield Question("mends", "mends", name, partial(_mend, build, 0.84, tilt))


def _mend(build: Callable[[], Assembly], mu: float, tilt: float | None) -> Answer:
    return asking.mends_of(_model(build, mu) if tilt is None else _at(build, mu, X, tilt), ())


def _settlements() -> Iterator[Question]:
    arch = partial(models.arch, 0.15, 12)
    for name, make, motion in (
        ("wedge-b x 50", partial(_at, partial(models.wedge, "b"), 0.84, X, 50.0), None),
        ("wedge-b x 62", partial(_at, partial(models.wedge, "b"), 0.84, X, 62.0), None),
        ("wedge-a y 90", partial(_at, partial(models.wedge, "a"), 0.84, Y, 90.0), None),
        ("curve-3 x 23", partial(_at, models.curve_three_blocks, 0.84, X, 23.0), None),
        ("snake x 15", partial(_at, models.snake, 0.7, X, 15.0), None),
        ("H", partial(_model, models.h_model, 0.6), None),
        ("arch", partial(_model, arch, STEEP), None),
        ("arch spread 0.01", partial(_model, arch, STEEP), (0.01, 0.0, 0.0)),
        ("arch spread 0.04", partial(_model, arch, STEEP), (0.04, 0.0, 0.0)),
        ("arch sinks 0.02", partial(_model, arch, STEEP), (0.0, 0.0, -0.02)),
        ("tower x 5", partial(_at, partial(models.tower, 4), 0.6, X, 5.0), None),
        ("pile 5", partial(random_pile, 5), None),
        ("pile 12", partial(random_pile, 12), None),
    ):
        yield Question("settlements", "settlements", name, partial(_settle, make, motion))


def _settle(make: Made, motion: tuple[float, float, float] | None) -> Answer:
    model = make()
    last = int(np.flatnonzero(model.assembly.fixed)[-1])
    return asking.settlement(model, None if motion is None else {last: motion})


def _of_files(folder: Path) -> Iterator[Question]:
    for path in sorted(one for one in folder.iterdir() if one.suffix in (".obj", ".json")):
        for tilt in (0.0, 10.0, 20.0):
            name = f"file {path.name} x {tilt:g}"
            yield Question("verdicts", "files", name, partial(_file, path, tilt))


def _file(path: Path, tilt: float) -> Answer:
    model = read(path, anyway=True)
    if tilt:
        model = model.with_load(LoadCase.tilt(model.assembly, X, tilt))
    return asking.verdict(model)
