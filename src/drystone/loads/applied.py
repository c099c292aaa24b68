"""A load case by where its loads act: an acceleration of all masses, and forces on blocks.

What an earthquake shakes: blocks, and the masses that they carry; no forces. Source: EN 1998-1,
3.2.4, and NTC 2018, 2.5.3: the masses of all gravity loads. By d'Alembert the force of each acts
at its place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, dot, lengths
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.geometry.polyhedron import fan_triangles
from drystone.loads.case import DOWN, STANDARD_GRAVITY, LoadCase
from drystone.loads.placing import CarriedMass


@dataclass(frozen=True, eq=False)
class AppliedLoads(OneLine):
    """Loads by where they act.

    Attributes
    ----------
    acceleration : (3,) [m/s2]
        That most of the masses have.
    words : (a,)
        What each of the other loads is.
    block : (a,)
        Blocks with other loads.
    point : (a, 3) [m]
        Where the force acts: as given, where that is off the block. Else a load case has the wrench
        of the block: of the line on which the force acts it is the point where it enters the block,
        or passes the centroid most closely. The centroid where there is no force.
    force : (a, 3) [N]
    moment : (a, 3) [N m], about the point
    earthquake, centre : (3,) [N], [m]
        The force of an earthquake on all masses, and where it acts, without a torque. On the masses
        that blocks carry it is not among the others.
    """

    acceleration: Floats
    words: tuple[str, ...]
    block: Ints
    point: Floats
    force: Floats
    moment: Floats
    earthquake: Floats
    centre: Floats

    def _summary(self) -> str:
        along = ", ".join(f"{x:.4g}" for x in self.acceleration + 0.0)
        return f"[{along}] m/s2, {counted(len(self.block), 'loaded block')}"

    def table(self, names: tuple[str, ...]) -> Table:
        """A row of an earthquake, and one per load; ``names`` are those of all blocks."""
        shaken = int(self.earthquake.any())
        columns = {
            "load": [*["earthquake"] * shaken, *self.words],
            "block": [*["earthquake"] * shaken, *(names[i] for i in self.block)],
            "point": np.vstack([*[self.centre] * shaken, self.point]),
            "force": np.vstack([*[self.earthquake] * shaken, self.force]),
            "moment": np.vstack([*[np.zeros(3)] * shaken, self.moment]),
        }
        return Table("loads", columns, {"point": "m", "force": "N", "moment": "N m"}, asked=True)


def applied_loads(assembly: Assembly, load: LoadCase, common: Floats | None = None) -> AppliedLoads:
    """The loads of a load case on free blocks, a row for each block: the sum of those on it.

    Parameters
    ----------
    assembly
    load
    common : (3,) [m/s2]
        The acceleration that is told apart; :func:`common_acceleration` when left out.

    Examples
    --------
    >>> from drystone.models import tower
    >>> assembly = tower(2)
    >>> load = LoadCase.gravity(assembly) + LoadCase.point_load(
    ...     assembly, "block-1", (0.0, 0.0, -1000.0), at=(0.2, 0.0, 2.0))
    >>> found = applied_loads(assembly, load)
    >>> found
    AppliedLoads([0, 0, -9.81] m/s2, 1 loaded block)
    >>> found.point.round(6).tolist(), found.moment.tolist()
    ([[0.2, 0.0, 2.0]], [[0.0, 0.0, 0.0]])
    """
    common = common_acceleration(assembly, load) if common is None else common
    rest, least = other_loads(assembly, load, common)
    block = np.flatnonzero(rest.any(axis=1))
    force, moment = rest[block, :3], rest[block, 3:]
    square = np.maximum(dot(force, force), 1e-300)[:, None]
    arm = np.cross(force, moment) / square
    along = dot(force, moment)[:, None] * force / square
    along = np.where(lengths(along)[:, None] > least * assembly.size[block, None], along, 0.0)
    left = np.where(lengths(force)[:, None] > 0.0, along, moment)
    point = _entered(assembly, block, assembly.centroid[block] + arm, force)
    if load.given is not None:
        others = applied_loads(assembly, load.beside_points, common)
        reach = np.trace(load.given[:, 1:], axis1=1, axis2=2)
        reach[others.block] += dot(others.point - assembly.centroid[others.block], others.force)
        at = assembly.centroid[block] + arm + (reach[block, None] / square) * force
        here = lengths(force) * lengths(load.given[block].reshape(-1, 12)) > 0.0
        point[here] = at[here]
    told = (load.name,) * len(block)
    return AppliedLoads(common, told, block, point, force, left, *_earthquake(assembly, load))


def loads_apart(assembly: Assembly, load: LoadCase, common: Floats | None = None) -> AppliedLoads:
    """The same, a row for each load as it was asked for, on each of its blocks.

    Forces at points act there. What is not known by its parts, as of wrenches, is one row a block.

    Examples
    --------
    >>> from drystone.models import tower
    >>> assembly = tower(2)
    >>> roof, wind = (LoadCase.point_load(assembly, 1, force, (0.2, 0.0, 2.0))
    ...               for force in ((0.0, 0.0, -1000.0), (300.0, 0.0, 0.0)))
    >>> found = loads_apart(assembly, LoadCase.gravity(assembly) + roof + wind)
    >>> found.words[1], found.force.tolist()
    ("300, 0, 0 N on 'block-1' at 0.2, 0, 2 m", [[0.0, 0.0, -1000.0], [300.0, 0.0, 0.0]])
    """
    common = common_acceleration(assembly, load) if common is None else common
    count, still = len(assembly), np.zeros(3)
    apart = (*load.each, *(x.as_given(assembly.free) for x in load.masses))
    each = [LoadCase(name=one.words, **one.on(count)) for one in apart]
    known = [one.wrench for one in each[: len(load.each)]]
    left, _ = other_loads(assembly, load.beside_masses, common, known)
    rest = "other loads" if each else load.name
    each.append(LoadCase(left, rest, given=None if known else load.given))
    found = [applied_loads(assembly, one, still) for one in each]
    words, block, point, force, moment = (
        np.concatenate([getattr(one, name) for one in found])
        for name in ("words", "block", "point", "force", "moment")
    )
    return AppliedLoads(
        common, tuple(words.tolist()), block, point, force, moment, *_earthquake(assembly, load)
    )


def other_loads(
    assembly: Assembly, load: LoadCase, common: Floats, known: Sequence[Floats] = ()
) -> tuple[Floats, float]:
    """Wrenches (n, 6) on free blocks beside some known (n, 6), and rounding of their forces [N].

    And beside ``common`` (3,) [m/s2], an acceleration of all masses, and what is shaken.
    """
    rest = load.wrench - sum(known)
    rest[:, :3] -= assembly.mass[:, None] * common
    for one in load.masses:
        rest -= one.pushed(one.shake)
    rest[assembly.fixed] = 0.0
    least = ROUNDING * max(float(np.abs(x[:, :3]).max(initial=0.0)) for x in (load.wrench, *known))
    rest[:, :3][np.abs(rest[:, :3]).max(axis=1) <= least] = 0.0
    rest[:, 3:][np.abs(rest[:, 3:]).max(axis=1) <= least * assembly.size] = 0.0
    return rest, least


def arms_of_loads(assembly: Assembly, load: LoadCase) -> Floats:
    """Sums (n, 3, 3) [N m] of arms from the centroid of each block times the forces there.

    They turn with the block, the forces keep their direction: of a block that has turned by R, the
    torque has changed by that of (R - 1) times them. Forces act at points given off blocks. Of
    others, what presses more down than sideways acts where it enters the block, as a roof; all else
    where it passes the centroid most closely.
    """
    applied = applied_loads(assembly, load.beside_masses.beside_points)
    arms = np.zeros((len(assembly), 3, 3)) if load.given is None else load.given[:, 1:].copy()
    arm, force = applied.point - assembly.centroid[applied.block], applied.force
    along = dot(arm, force) / np.maximum(dot(force, force), 1e-300)
    down = -force[:, 2] > lengths(force[:, :2])
    arm = arm - np.where(down, 0.0, along)[:, None] * force
    arms[applied.block] += arm[:, :, None] * force[:, None]
    for one in load.masses:
        arms += one.moment[:, :, None] * (one.gravity + one.shake)
    return arms


def _earthquake(assembly: Assembly, load: LoadCase) -> tuple[Floats, Floats]:
    """Its force (3,) [N] on free blocks and their masses, and its place (3,) [m]."""
    free = assembly.free
    along = load.shake / max(float(np.linalg.norm(load.shake)), 1e-300)
    parts = [(assembly.mass[free] * (load.shake @ along), assembly.centroid[free])]
    parts += [
        (one.mass[free] * (one.shake @ along), one.place(assembly)[free]) for one in load.masses
    ]
    pushed = float(sum(size.sum() for size, _ in parts))
    if pushed == 0.0:
        return np.zeros(3), np.zeros(3)
    return pushed * along, np.asarray(sum(size @ place for size, place in parts) / pushed)


def _entered(assembly: Assembly, block: Ints, point: Floats, force: Floats) -> Floats:
    """Where lines through points (a, 3) along forces (a, 3) enter blocks (a,), if they do.

    Source: Moller and Trumbore 1997, of a line and a triangle.
    """
    size = lengths(force)
    if not size.any():
        return point
    faces = assembly.subset(block).faces
    triangle, face = fan_triangles(faces)
    line = faces.owner[face]
    way = (force / np.maximum(size, 1e-300)[:, None])[line]
    sides = triangle[:, 1:] - triangle[:, :1]
    across = np.cross(way, sides[:, 1])
    volume = dot(sides[:, 0], across)
    area = lengths(np.cross(sides[:, 0], sides[:, 1]))
    crossed = np.abs(volume) > ROUNDING * area
    begin = point[line] - triangle[:, 0]
    turned = np.cross(begin, sides[:, 0])
    u, v, way_to = (
        np.divide(one, volume, out=np.full(len(line), np.inf), where=crossed)
        for one in (dot(begin, across), dot(way, turned), dot(sides[:, 1], turned))
    )
    hit = crossed & (np.minimum(u, v) >= -ROUNDING) & (u + v <= 1.0 + ROUNDING)
    first = np.full(len(block), np.inf)
    np.minimum.at(first, line[hit], way_to[hit])
    first = np.where(np.isfinite(first), first, 0.0)
    return point + (first / np.maximum(size, 1e-300))[:, None] * force


def is_vertical(load: LoadCase) -> bool:
    """Whether all forces act along z through the centroids of blocks."""
    level = np.abs(load.wrench[:, [0, 1, 3, 4, 5]]).max(initial=0.0)
    return bool(level <= 1e-12 * np.abs(load.wrench).max(initial=0.0))


def common_acceleration(assembly: Assembly, load: LoadCase) -> Floats:
    """The acceleration (3,) [m/s2] of all masses that the load case knows.

    Of a case that knows none, as that of a file: the acceleration of most free masses, if it is
    gravity's size within a fifth. Others are forces on blocks, and what blocks carry.
    """
    if load.acceleration.any():
        return load.acceleration
    free = ~assembly.fixed
    wrench = load.beside_masses.beside_points.wrench
    acceleration = wrench[free, :3] / assembly.mass[free, None]
    largest = float(np.abs(acceleration).max(initial=0.0))
    if largest == 0.0:
        return np.zeros(3)
    each, count = np.unique((acceleration / largest).round(9), axis=0, return_counts=True)
    far = np.abs(np.linalg.norm(each, axis=1) * largest - STANDARD_GRAVITY)
    each, count, far = (some[far <= 0.2 * STANDARD_GRAVITY] for some in (each, count, far))
    if not len(each):
        return np.zeros(3)
    chosen = each[np.lexsort((far, -count))[0]]
    alike = np.abs(acceleration / largest - chosen).max(axis=1) < 1e-8
    return acceleration[alike].mean(axis=0)


_KINDS = {"mass": "masses in kg", "load": "loads"}


@dataclass(frozen=True, eq=False)
class Shaken(OneLine):
    """What an earthquake shakes.

    Attributes
    ----------
    weights : [N]
        By kind: blocks, fill, resisting fill, masses in kg, loads.
    still : [N]
        Downward forces that are not shaken.
    pressed
        Whether faces are pressed sideways, as by earth: an earthquake adds to that.
    """

    weights: Mapping[str, float]
    still: float
    pressed: bool

    def _summary(self) -> str:
        return self.words

    @classmethod
    def of(cls, assembly: Assembly, load: LoadCase, blocks: Bools | None = None) -> Shaken | None:
        """That of a load case, on some free blocks (n,); ``None`` without an earthquake.

        Examples
        --------
        >>> from drystone.models import tower
        >>> few = tower(2)
        >>> load = LoadCase.gravity(few) + LoadCase.extra_mass(few, 1, 1000.0)
        >>> print(Shaken.of(few, load + LoadCase.seismic(few, 0.1)).words)
        the earthquake shakes 33.4 kN: 23.5 kN of blocks and 9.81 kN of masses in kg
        """
        if not load.shake.any():
            return None
        free = ~assembly.fixed if blocks is None else blocks & ~assembly.fixed
        weights = {"blocks": STANDARD_GRAVITY * float(assembly.mass[free].sum())}
        for one in load.masses:
            name = _KINDS.get(one.kind, one.kind)
            weights[name] = weights.get(name, 0.0) + STANDARD_GRAVITY * float(one.mass[free].sum())
        applied = applied_loads(assembly, load.beside_masses)
        down = -np.minimum(applied.force[free[applied.block], 2], 0.0).sum()
        still = float(down) if down > 1e-6 * sum(weights.values()) else 0.0
        push = 0.0 if load.surface is None else np.abs(load.surface.wrench[free, :2]).sum()
        pressed = bool(push > 1e-6 * sum(weights.values()))
        return cls({name: one for name, one in weights.items() if one}, still, pressed)

    @property
    def words(self) -> str:
        """What is shaken, and what is not."""
        parts = [f"{quantity(one, 'N')} of {name}" for name, one in self.weights.items()]
        total = quantity(sum(self.weights.values()), "N")
        told = f"{total}: {', '.join(parts[:-1])} and {parts[-1]}" if parts[1:] else "".join(parts)
        more = f"; {quantity(self.still, 'N')} of forces are not (--shaken)" if self.still else ""
        if self.pressed:
            more += "; level pressure (earth, fill, water) does not grow with it: "
            more += "k=active:30deg:0.1 is Mononobe-Okabe's at 0.1 g"
        if "resisting fill" in self.weights:
            more += "; passive pressure is the one given (passive=passive:30deg:0.1 is less)"
        return f"the earthquake shakes {told}{more}"


def with_shaken_weights(
    assembly: Assembly,
    load: LoadCase,
    g: float = STANDARD_GRAVITY,
    common: Floats | None = None,
) -> LoadCase:
    """A load case whose downward forces are weights of masses, where their lines enter blocks.

    Their masses are those by a gravity ``g`` [m/s2]. What is not shaken is ``common`` (3,) [m/s2],
    :func:`common_acceleration` when left out.

    Examples
    --------
    >>> from drystone.models import tower
    >>> few = tower(2)
    >>> roof = LoadCase.point_load(few, 1, (0.0, 0.0, -981.0))
    >>> with_shaken_weights(few, roof).masses
    (CarriedMass(load, 100 kg),)
    """
    applied = applied_loads(assembly, load.beside_masses, common)
    down = applied.force[:, 2] < 0.0
    if not down.any():
        return load
    mass = -applied.force[down, 2] / g
    gravity: Floats = g * np.array(DOWN)
    made = CarriedMass.at(assembly, "load", applied.block[down], mass, applied.point[down], gravity)
    made = made.shaken(load.shake)
    wrench = load.wrench + made.pushed(load.shake)
    left = np.ones((len(assembly), 1, 3))
    left[applied.block[down], :, 2] = 0.0
    given = None if load.given is None else load.given * left
    return replace(load, wrench=wrench, masses=(*load.masses, made), given=given, each=())
