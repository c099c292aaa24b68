"""The 100 scans of :mod:`benchmarks.regions`: models, and what grows or falls along each."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from benchmarks.workloads import XY30, Axis, X, Y, random_pile
from drystone import Assembly, Block, LoadCase, Model, models
from drystone.assembly import replace_block
from drystone.models import box, prism

STEEP = float(np.tan(np.deg2rad(43.0)))
DECADES = (-3.0, 3.0)
"""Powers of ten of the densities of what is heavy on light."""

STRIPS = (
    "meridian strips on the lower side hinge outwards; near the limit the blocks beside them slide"
    " and press on their sides with {} of their weight, before with {}: friction there holds them"
)
EXPLAINED = {
    "cap 7 x 2, 1": STRIPS.format("43 to 46 %", "2 to 14 %"),
    "cap 7 x 2, 2 from 48": (
        "two meridian strips on the lower side are held by friction on sides that press with 61 to"
        " 78 % of their weight; whether slips of 0.4 % lock depends on the path"
    ),
    "cap 5 x 2, 2 from 30": STRIPS.format("10 to 14 %", "1 to 2 %"),
    "pile 5": (
        "the centroid of its two upper blocks is 10 mm beyond the edge below and 0.43 m above it:"
        " a tilt of 1.46 degrees brings it back"
    ),
    "shelf y": (
        "blocks 9 and 10 slide off pieces with slopes of 47.8 and 50.1 degrees; friction of 0.9"
        " holds 42.0, so tilts of 5.8 and 8.1 hold them"
    ),
}
"""Scans along which the verdict changes more than once, and the mechanism."""

Built = Callable[[], Assembly]


@dataclass(frozen=True)
class Scan:
    """A model, and the values from one at which it should stand to one at which it should fall.

    Attributes
    ----------
    name
    build
    axis
        About which it is tilted.
    friction, tilt : [-], [degrees]
        The one that does not change is kept.
    along
        ``tilt``, which grows to ``most``, or ``friction``, which falls from 2 to 0.1.
    most : [degrees]
    """

    name: str
    build: Built
    axis: Axis
    friction: float = 0.0
    tilt: float = 0.0
    along: str = "tilt"
    most: float = 75.0

    @cached_property
    def assembly(self) -> Assembly:
        """The blocks, made once."""
        return self.build()

    def value(self, share: float) -> float:
        """The tilt [degrees] or the friction at a share (0 to 1) of the way."""
        if self.along == "tilt":
            return round(share * self.most, 3)
        return float(f"{2.0 * 0.05**share:.4g}")

    def model(self, value: float) -> Model:
        """The model at a value."""
        tilt, friction = (value, self.friction) if self.along == "tilt" else (self.tilt, value)
        load = LoadCase.tilt(self.assembly, self.axis, tilt)
        return Model.of(self.assembly, friction=friction, load=load)


def scans() -> list[Scan]:
    """All of them: 57 by tilt and 43 by friction."""
    by_tilt = [*_arches(), *_domes(), *_frames(), *_wedges(), *_piles(), *_heavy(), *_locked()]
    by_friction = [
        replace(one, name=f"{name} from {tilt:g}", along="friction", tilt=tilt)
        for name, tilts in FRICTION.items()
        for one in by_tilt
        if one.name == name
        for tilt in tilts
    ]
    return by_tilt + by_friction


FRICTION = {
    "arch 0.15 8 y": (0.0, 4.0, 10.0),
    "arch 0.2 13 y": (0.0, 8.0),
    "buttressed arch y": (0.0,),
    "lune y": (0.0,),
    "dome 6 x 3, 1 y": (0.0, 15.0, 30.0),
    "dome bonded 8 x 3, 1 y": (0.0, 20.0),
    "cap 7 x 2, 2": (0.0, 25.0, 36.0, 48.0),
    "cap 5 x 2, 2": (30.0,),
    "A-frame 55 x": (0.0, 5.0),
    "A-frame 65 y": (0.0, 10.0),
    "A-frame 70 y": (0.0,),
    "wedge a x": (30.0,),
    "wedge b longer x": (30.0, 50.0),
    "wedge c longer x": (20.0, 35.0),
    "pile 0": (0.0, 15.0),
    "pile 3": (10.0,),
    "heavy 0": (0.0, 10.0),
    "heavy 2": (10.0,),
    "heavy 5": (10.0,),
    "heavy arch": (0.0,),
    "dovetail 15 y": (30.0,),
    "concave short y": (20.0,),
    "hooked bar y": (20.0,),
    "H x": (0.0,),
    "A x": (0.0,),
    "shelf y": (0.0,),
    "bridge y": (0.0,),
    "snake x": (0.0,),
}
"""Scans by tilt that are also made by friction, and the tilts [degrees] that are kept."""


def _arches() -> Iterator[Scan]:
    for ratio, voussoirs in ((0.12, 8), (0.15, 8), (0.15, 13), (0.2, 8), (0.2, 13)):
        build = partial(models.arch, ratio, voussoirs)
        yield Scan(f"arch {ratio} {voussoirs} y", build, Y, STEEP, most=30.0)
    yield Scan("arch 0.15 8 x", partial(models.arch, 0.15, 8), X, 0.6, most=40.0)
    yield Scan("buttressed arch y", models.buttressed_arch, Y, 0.6, most=24.0)
    yield Scan("lune y", partial(models.lune, 0.06, 12), Y, 0.7, most=30.0)


def _domes() -> Iterator[Scan]:
    for friction in (0.6, 1.0, 2.0):
        build = partial(models.dome, slices=6, rings=3)
        yield Scan(f"dome 6 x 3, {friction:g} y", build, Y, friction)
    for friction in (0.6, 1.0):
        build = partial(models.dome, slices=8, rings=3, bonded=True)
        yield Scan(f"dome bonded 8 x 3, {friction:g} y", build, Y, friction)
    away = np.deg2rad(207.7 + 90.0)
    axis = (float(np.cos(away)), float(np.sin(away)), 0.0)
    for slices, friction in ((7, 2.0), (7, 1.0), (5, 2.0), (6, 1.5)):
        yield Scan(f"cap {slices} x 2, {friction:g}", partial(_cap, slices), axis, friction)


def _frames() -> Iterator[Scan]:
    for degrees in (55.0, 60.0, 65.0, 70.0):
        for name, axis in (("x", X), ("y", Y)):
            build = partial(_a_frame, degrees)
            yield Scan(f"A-frame {degrees:g} {name}", build, axis, 1.0, most=60.0)


def _wedges() -> Iterator[Scan]:
    for kind, longer in (("a", 0.0), ("b", 0.0), ("c", 0.0), ("b", 0.2), ("c", 0.2)):
        name = f"wedge {kind}{' longer' if longer else ''} x"
        yield Scan(name, partial(models.wedge, kind, longer), X, 0.84)
    yield Scan("wedge d xy30", partial(models.wedge, "d"), XY30, 0.84)


def _piles() -> Iterator[Scan]:
    for seed in range(9):
        turn = 0.7 * seed
        axis = (float(np.cos(turn)), float(np.sin(turn)), 0.0)
        friction = 0.1 * 20.0 ** (seed / 8.0)
        yield Scan(f"pile {seed}", partial(_pile, seed), axis, round(friction, 3), most=60.0)


def _heavy() -> Iterator[Scan]:
    for seed in range(6):
        build = partial(_decades, partial(_pile, 20 + seed, 6), seed)
        yield Scan(f"heavy {seed}", build, XY30, 0.6, most=50.0)
    build = partial(_decades, partial(models.arch, 0.2, 8), 9)
    yield Scan("heavy arch", build, Y, STEEP, most=30.0)


def _locked() -> Iterator[Scan]:
    yield Scan("dovetail 15 y", models.dovetail, Y, 0.4, most=120.0)
    yield Scan("hooked bar y", models.hooked_bar, Y, 0.6, most=90.0)
    yield Scan("concave short y", partial(models.concave, "short"), Y, 0.84)
    yield Scan("curve 3 x", models.curve_three_blocks, X, 0.84, most=50.0)
    yield Scan("bayonet x", models.bayonet, X, 0.4, most=150.0)
    yield Scan("H x", models.h_model, X, 0.6)
    yield Scan("A x", models.a_model, X, 0.6)
    yield Scan("shelf y", models.shelf, Y, 0.9)
    yield Scan("bridge y", models.bridge, Y, 0.9)
    yield Scan("snake x", models.snake, X, 0.7)


def _pile(seed: int, blocks: int = 8) -> Assembly:
    return random_pile(seed, blocks, 3, 0.0).assembly


def _decades(build: Built, seed: int) -> Assembly:
    """The same blocks, with random densities over six decades."""
    assembly = build()
    power = np.random.default_rng(seed).uniform(*DECADES, len(assembly))
    blocks = [
        replace_block(block, density=2000.0 * 10.0**one)
        for block, one in zip(assembly.blocks, power, strict=True)
    ]
    return Assembly(tuple(blocks), assembly.fixed)


def _a_frame(degrees: float) -> Assembly:
    """Two planks that lean against each other, whose feet are cut flat."""
    slope, wide = np.tan(np.deg2rad(degrees)), 0.25
    foot = 2.0 / slope
    section = [(foot, 0.0), (foot - wide, 0.0), (0.0, 2.0 - wide * slope), (0.0, 2.0)]
    right = prism(section, (-0.25, 0.25), "right")
    left = prism([(-x, z) for x, z in section], (-0.25, 0.25), "left")
    floor = box((8.0, 4.0, 1.0), (-4.0, -2.0, -1.0), name="floor")
    return Assembly((floor, left, right), np.array([True, False, False]))


def _cap(slices: int) -> Assembly:
    """Two rings of voussoirs, all free, on a disc of 24 sides."""
    shell = models.dome(1.0, 0.1734, 0.1747, slices, 2)
    angle = 2.0 * np.pi * np.arange(24) / 24
    rim = 1.3 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    disc = _disc(rim)
    blocks = (disc, *shell.blocks)
    return Assembly(blocks, np.arange(len(blocks)) == 0)


def _disc(rim: np.ndarray) -> Block:
    count, here = len(rim), range(len(rim))
    points = [np.column_stack([rim, np.full(count, z)]) for z in (-0.3, 0.0)]
    sides = [(i, (i + 1) % count, (i + 1) % count + count, i + count) for i in here]
    faces = (tuple(reversed(here)), tuple(i + count for i in here), *sides)
    return Block(np.concatenate(points), faces, "disc")
