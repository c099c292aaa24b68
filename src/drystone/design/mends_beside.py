"""What may stand beside the blocks of a region to hold it: a block below, props, ties."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, dot, lengths, unit
from drystone.base.display import rounded_up
from drystone.base.errors import counted
from drystone.base.units import quantity
from drystone.checks import first_motion_of
from drystone.design.bench import ALIKE, Bench, Held, Proposals, Take, Tries
from drystone.design.changed_model import acceleration_of, usual_friction
from drystone.design.changes import Change, block_added, props_at
from drystone.design.margin import LARGE_REGION, SMALL_REGION, DesignMargin, quick_check
from drystone.design.needs import KnownNeeds, props_of
from drystone.design.props import PropSeat, carries, find_props, seats, struts
from drystone.design.search import least
from drystone.design.words import NAMED, force_words, listed, names_of, place
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.sequence.scaffold_seats import Landing, along, first_met, surface_triangles
from drystone.supports import props_of as added_props
from drystone.ties import tied

_FIRST = 6
"""Number of struts of one block that are tried, the shortest first, of pairs of shores, and of
pairs of blocks between which a tie is tried: those that move apart fastest, that with the least
pull times length by virtual work first, and of equal ones that nearest the middle of the region.
Before these two blocks that alone are alike and level, opposite each other, if that is at most
twice as much."""

_LEVEL = 0.5
"""A prop is level where its direction is less than 30 degrees from that. Chosen."""

_END = 0.9
"""Where a tie at an end of a block begins, by the way from its middle to that. Chosen."""

_TIES = 4
"""Number of ties that are tried together in a region. Chosen: two arches under a beam need two."""


def support(asked: KnownNeeds) -> Proposals:
    """A block below that fits between a block of the region and another one."""
    bench, changes = asked.bench, []
    for i, whole in enumerate(bench.region):
        for length, on, body in struts(bench.model, whole, bench.motion[i])[:_FIRST]:
            size = f"a block of {body.volume:.3g} m3, {length:.3g} m long,"
            ends = " and ".join(names_of(bench.model, [end]) for end in (on, whole))
            words = f"{size} between {ends}"
            change = Change.single("support", block_added(body), words, length, added=1)
            changes.append(replace(change, beyond=() if on in bench.blocks else (on,)))
    why = f"{len(changes)} blocks that fit were tried, the shortest first"
    if not changes:
        why = "no block fits between it and another one"
        if "ground" not in bench.model.assembly:
            why += "; the supports 'ground' lay a plane below, on which one may stand"
    yield Tries(changes, why, Take.FIRST)


def prop(asked: KnownNeeds) -> Proposals:
    """One prop, with the least force, and a pair of shores; else a few that hold it together."""
    bench, found = asked.bench, asked.needs.props
    if bench.large:
        found = props_of(bench, asked.needs)
    elif asked.known:
        at = np.zeros(len(bench.model), dtype=np.intp)
        at[list(bench.region)] = bench.own
        found = found.renumbered(at)
    else:
        first = bench.own[:SMALL_REGION]
        found = find_props(bench.local, bench.own, bench.motion, bench.stop, single=first)
    alone, pairs = [one.seat for one in found.props], _shores(bench)
    failed = "" if alone else f"no prop holds it: tried were {found.tried}"

    def tries(several: list[list[PropSeat]], why: str, *, smooth: bool = True) -> Tries:
        words: _Words = {}
        for some in several:
            single = Change.single("prop", props_at(some, smooth=smooth), "", added=len(some))
            rest = found.props[0].rest if some is alone else None
            words[replace(single, rest=rest)] = partial(_prop_words, bench, some)
        told = partial(_by_force, bench, words)
        return Tries(list(words), why, Take.FIRST, last=not smooth, told=told)

    if alone:
        yield tries([alone], "")
        yield tries([alone], "the best props do not keep the margin", smooth=False)
    if len(alone) < 2:  # two hold it in its place
        yield tries(pairs[:_FIRST], failed)


def _shores(bench: Bench) -> list[list[PropSeat]]:
    """Pairs of places for level props against opposite sides of blocks that are alike.

    As two raking shores against walls that spread: the most level ones first, then the highest.
    """
    local = bench.local
    some = [] if bench.large else bench.own
    places = [one for i in some for one in seats(local, i, bench.motion[i])]
    if not places:
        return []
    block = np.array([one.block for one in places])
    level, steep = _parted(bench, np.array([one.normal for one in places]))
    _, high = _parted(bench, np.array([one.middle for one in places]))
    size, volume = local.assembly.size[block], local.assembly.volume[block]
    off = np.abs(level[:, None] + level).max(axis=2) + np.abs(steep[:, None] - steep)
    off += np.abs(np.subtract.outer(high, high)) / size + np.abs(volume[:, None] / volume - 1.0)
    pairs = np.argwhere(np.triu(off < ALIKE) & (np.abs(steep) < _LEVEL) & (block[:, None] != block))
    first = np.lexsort((-np.take(high, pairs[:, 0]), np.round(np.abs(steep[pairs[:, 0]]), 6)))
    return [[places[i], places[j]] for i, j in pairs[first].tolist()]


def _prop_words(bench: Bench, some: Sequence[PropSeat], forces: Floats, points: Floats) -> str:
    """Props with their forces [N] and places [m] as text; equal forces are told once.

    Of many the largest: the mended model has a block for each.
    """
    each, model, where = [force_words(force) for force in forces], bench.local, list[str]()
    for seat, force, point in zip(some, forces, points, strict=True):
        side = "under" if carries(model, seat.block, force) else "against"
        where.append(f"{side} {names_of(model, [seat.block])} at {place(point)}")
    if len(some) > 1 and len(set(each)) == 1:
        return f"{len(some)} props: each of {each[0]}, {', '.join(where)}"
    told = [f"{force} {at}" for force, at in zip(each, where, strict=True)]
    if len(told) > NAMED:  # 26 filled a screen and covered the picture
        order = np.argsort(-lengths(forces), kind="stable")
        told = [told[i] for i in order[: NAMED - 1]]
        told.append(f"and {len(some) - len(told)} with less")
    parts = ", ".join(told)
    if len(some) > 1:
        return f"{len(some)} props: {parts}"
    steady = _steady(bench, some[0].block, forces[0], points[0])
    return f"a prop of {parts}{steady}{_buttress(bench, some[0].block, forces[0], points[0])}"


_Words: TypeAlias = dict[Change, Callable[[Floats, Floats], str]]
"""Changes, and their words by the forces (p, 3) [N] of what they add and where these act [m]."""


def _by_force(bench: Bench, words: _Words, change: Change) -> Held:
    """A single change told by the forces of what it adds, at the margin."""
    forces, points = bench.largest_forces(change)
    told, total = words[change](forces, points), float(np.linalg.norm(forces, axis=1).sum())
    if bench.margin != DesignMargin():
        told += ": the largest force at the margin"
    return replace(change, words=lambda _: told, steps=(total,), low=total), total


def _steady(bench: Bench, block: int, force: Floats, point: Floats, what: str = "pushes") -> str:
    """The least steady force of a jack that holds a region, at most that of the prop or tie."""
    if bench.large or bench.margin != DesignMargin():
        return ""
    local = bench.local
    push = LoadCase.point_load(local.assembly, block, force, point)

    def stands(share: float) -> bool:
        return bench.keeps_margin(local.with_load(local.load + share * push), quick=True)

    share, size = least(stands, (1.0,)) or 0.0, math.hypot(*force)
    told = quantity(min(rounded_up(share * size, 2), size), "N")
    return f"; a jack that {what} by a steady {told} holds it" if share else ""


def _buttress(bench: Bench, block: int, force: Floats, point: Floats) -> str:
    """A buttress of the same stone in place of a level prop: how deep it neither tips nor slides.

    It is as high as the prop is above the foot of the region, and as wide as the block, up to 1 m:
    weight x depth / 2 = force x height, and force = friction x weight.
    """
    model, blocks = bench.local, bench.local.assembly.blocks
    (level,), (rise,) = _parted(bench, force[None])
    push, weight = math.hypot(*level), math.hypot(*_gravity(bench)) * blocks[block].density
    feet = _parted(bench, np.concatenate([blocks[i].vertices for i in bench.own]))[1]
    high = float(_parted(bench, point[None])[1][0] - feet.min())
    if abs(rise) > _LEVEL * math.hypot(*force) or not weight or high <= 0.0:
        return ""
    across, _ = unit(np.cross(_gravity(bench), level))
    wide = min(float(np.ptp(blocks[block].vertices @ across)), 1.0)
    tips, slides = math.sqrt(2.0 * push / (weight * wide)), push / (weight * wide * high)
    deep = rounded_up(max(tips, slides / usual_friction(model)), 2)
    size = f"{wide:.2g} m wide, {deep:g} m deep and as high"
    return f"; or a buttress of the same stone, {size}"


_Ends: TypeAlias = tuple[int, int]
_Back: TypeAlias = tuple[Floats, Landing]
"""A tie: where it begins (3,) [m], and where it ends."""


def tie(asked: KnownNeeds) -> Proposals:
    """Ties: they pull, and never press.

    One from a block back to what stands behind it, one between the centroids of two blocks that
    move apart; else more: each between those that move apart fastest with the ties before it.
    """
    bench, local = asked.bench, asked.bench.local
    centroid, size = local.assembly.centroid, local.assembly.size.max()
    held, back = list[Change](), _tied_back(bench)

    def told(words: _Words, change: Change) -> Held:
        held.append(change)
        return _by_force(bench, words, change)

    yield Tries(list(back), "", Take.FIRST, told=partial(told, back))
    rate, apart = _apart(bench, bench.motion)
    if not len(apart):
        yield from () if held else ("no blocks move apart",)
        return
    far = lengths(centroid[apart[:, 0]] - centroid[apart[:, 1]])
    bulk = np.round(far / size * (rate.max() / rate) / ALIKE)

    def make(ties: tuple[_Ends, ...], model: Model, blocks: Ints, _: Ints) -> Model:
        for i, j in ties:
            model = tied(model, int(blocks[i]), int(blocks[j]))
        return model

    hoops: _Words = {
        Change.single("tie", partial(make, ring), "", added=1): partial(_hoop_words, bench, ring)
        for ring in _rings(bench)
    }
    yield Tries(list(hoops), "", Take.FIRST, told=partial(told, hoops))
    touching = {*zip(local.contacts.block_a.tolist(), local.contacts.block_b.tolist(), strict=True)}

    def through(ends: _Ends) -> tuple[str, int, bool]:
        """What a tie lies in, in words, through how many joints, and whether it is a dowel."""
        (start, end), pair = centroid[[*ends]], bench.blocks[[*ends]].tolist()
        free, pierced = along(bench.model.assembly, start, end, pair)
        said = f" through {names_of(bench.model, pierced)}" if pierced else ""
        if {ends, ends[::-1]} & touching:
            return said or " through their joint", len(pierced) + 1, True
        within = free <= 0.01 * math.dist(start, end)
        said += "" if within else f", {free:.3g} m of it in the open"
        return said, len(pierced) + (within and bool(pierced)), within and bool(pierced)

    def words(ties: tuple[_Ends, ...], forces: Floats, _: Floats) -> str:
        each, dowels = [], True
        for ends, force in zip(ties, forces, strict=True):
            lies, _joints, dowel = through(ends)
            between = f"the middles of {names_of(local, ends)}, {math.dist(*centroid[[*ends]]):.3g}"
            each.append(f"{quantity(math.hypot(*force), 'N')} between {between} m apart{lies}")
            dowels &= dowel
        what = "dowel" if dowels else "tie"
        several = f"{len(each)} {what}s that pull" if len(each) > 1 else f"a {what} that pulls"
        return f"{several} {listed(each)}"

    def tries(several: list[tuple[_Ends, ...]], why: str) -> Tries:
        of: _Words = {}
        for ties in several:
            joints = sum(through(ends)[1] for ends in ties)
            single = Change.single("tie", partial(make, ties), "", 0.0, joints, len(ties))
            of[single] = partial(words, ties)
        return Tries(list(of), why, Take.FIRST, told=partial(told, of))

    beside = np.array([bool({(i, j), (j, i)} & touching) for i, j in apart.tolist()])  # tried last
    # from the middle a tie is half as long as between opposite blocks, and pulls aside
    twins = (apart[:, None] == twins_of(bench)).all(axis=2).any(axis=1)
    aside = ~(twins & (bulk <= 2.0 * bulk.min()))
    first = apart[np.lexsort((_off(bench, apart), bulk, aside, beside))].tolist()
    why = "" if held else f"a tie between blocks that move apart, of {counted(len(first), 'pair')}"
    why += f", or to what stands behind, of {counted(len(back), 'block')}" if why and back else ""
    several: list[tuple[_Ends, ...]] = [((i, j),) for i, j in first]
    ties: tuple[_Ends, ...] = ()
    for count in range(2, _TIES + 2):
        failed = len(bench.tried)
        yield tries(several, why)
        if len(bench.tried) == failed or bench.large or not len(apart) or count > _TIES:
            return
        ties = (*ties, (int(apart[0, 0]), int(apart[0, 1])))
        made = make(ties, local, np.arange(len(local)), np.arange(0))
        fallen = quick_check(bench.holds(made, bench.margin).model, bench.stop)
        if fallen.prop is None:
            return
        apart = _apart(bench, first_motion_of(fallen.model, fallen.prop), ties)[1]
        several = [(*ties, (i, j)) for i, j in apart[:1].tolist()]
        why = f"{count} ties, each where most"


def _tied_back(bench: Bench) -> _Words:
    """Ties from blocks to others beyond the region that these do not touch, with their words.

    Each is level, against the first motion of its block, and ends where it meets the other one: one
    from the middle, else one from each end. That with the least pull times length by virtual work
    comes first.
    """
    model = bench.model
    level = _parted(bench, bench.motion[bench.own, :3])[0]
    speed, most = lengths(level), float(lengths(level).max())
    triangles, owner = surface_triangles(model.assembly)
    beyond = ~np.isin(owner, bench.region) & ~added_props(model.assembly)[owner]
    surface = triangles[beyond], owner[beyond]
    found: list[tuple[float, float, int, list[_Back]]] = []
    for i in np.argsort(-speed, kind="stable")[:LARGE_REGION].tolist():
        ties = _back(bench, surface, i, -level[i] / speed[i]) if speed[i] > ALIKE * most else []
        if ties:
            far = sum(float(np.linalg.norm(met.point - at)) for at, met in ties)
            bulk = round(far / model.assembly.size.max() * most / speed[i] / ALIKE)
            found.append((bulk, _off(bench, np.array([[i, i]]))[0], i, ties))

    made: _Words = {}
    for _, _, i, ties in sorted(found, key=lambda one: one[:2])[:_FIRST]:
        make = partial(_tie_back, model.assembly, bench.region[i], ties)
        change = Change.single("tie", make, "", added=len(ties))
        new = {met.block for _, met in ties} - set(bench.blocks.tolist())
        made[replace(change, beyond=tuple(sorted(new)))] = partial(_back_words, bench, i, ties)
    return made


def _tie_back(whole: Assembly, block: int, ties: list[_Back], model: Model, *_: Ints) -> Model:
    """A model, whole or local, with ties of a block of the whole."""
    for at, met in ties:
        one, other = model.assembly.indices([whole.names[i] for i in (block, met.block)]).tolist()
        model = tied(model, one, other, at=at.tolist(), anchor=met.point.tolist())
    return model


def _back_words(bench: Bench, block: int, ties: list[_Back], forces: Floats, points: Floats) -> str:
    """Ties of a block with their forces [N] as text; of a single one the least steady pull, too."""
    told, model = list[str](), bench.model
    for (at, met), force in zip(ties, forces, strict=True):
        free, _ = along(model.assembly, at, met.point, ())
        ends = f"from {place(at)} to {names_of(model, [met.block])} at {place(met.point)}"
        told.append(f"{quantity(math.hypot(*force), 'N')} {ends}, {free:.3g} m of it in the open")
    what = f"{len(ties)} ties that pull" if len(ties) > 1 else "a tie that pulls"
    said = f"{what} {names_of(model, [bench.region[block]])} back by {listed(told)}"
    return said + (_steady(bench, block, forces[0], points[0], "pulls") if len(ties) == 1 else "")


def _back(bench: Bench, surface: tuple[Floats, Ints], block: int, way: Floats) -> list[_Back]:
    """Ties along a level direction (3,) from a block to others that it does not touch."""
    own, whole = bench.local.assembly, bench.region[block]
    a, b = bench.model.contacts.block_a, bench.model.contacts.block_b
    beside = {*a[b == whole].tolist(), *b[a == whole].tolist()}
    far = float(np.linalg.norm(np.ptp(bench.model.assembly.bounds, axis=(0, 1))))
    middle = own.centroid[block]
    across = np.cross(_gravity(bench), way)
    along = (own.blocks[block].vertices - middle) @ across / (across @ across)
    ends = [middle + _END * share * across for share in (along.min(), along.max())]
    for starts in ([middle], ends):
        met = [(at, first_met(surface, whole, at, at + far * way)) for at in starts]
        ties = [(at, one) for at, one in met if one is not None and one.block not in beside]
        if len(ties) == len(starts):
            return ties
    return []


def _gravity(bench: Bench) -> Floats:
    """The acceleration (3,) [m/s2] of masses, without that of an earthquake."""
    return acceleration_of(bench.local) - bench.local.load.shake


def _parted(bench: Bench, ways: Floats) -> tuple[Floats, Floats]:
    """Directions (w, 3) without their part along gravity, and that (w,), upwards."""
    down = _gravity(bench)
    up = -down / max(float(np.linalg.norm(down)), np.finfo(float).tiny)
    rise: Floats = ways @ up
    return ways - rise[:, None] * up, rise


def _apart(bench: Bench, motion: Floats, ties: tuple[_Ends, ...] = ()) -> tuple[Floats, Ints]:
    """The pairs (p, 2) of blocks that move apart fastest, with how fast (p,).

    Of equal ones those nearest the middle of the region come first; the fastest pair of twins is
    among them.
    """
    local = bench.local.assembly
    used = [i for ends in ties for i in ends]
    used += [i for i in np.flatnonzero(local.fixed).tolist() if lies_under_all(local, i)]
    velocity = np.where(local.fixed[:, None], 0.0, motion[:, :3])
    rate = np.zeros((len(local), len(local)))
    for i in bench.own:
        along = local.centroid[i + 1 :] - local.centroid[i]  # each pair once
        size = lengths(along)
        apart = dot(velocity[i + 1 :] - velocity[i], along) / np.where(size > 0.0, size, 1.0)
        rate[i, i + 1 :] = np.maximum(apart, 0.0)
    rate[used] = rate[:, used] = 0.0
    level = np.round(rate / max(rate.max(initial=0.0), np.finfo(float).tiny) / ALIKE)
    few = max(level.size - _FIRST, 0)
    ends = np.argwhere((rate > 0.0) & (level >= np.partition(level, few, axis=None)[few]))
    twins = twins_of(bench)
    twins = twins[rate[tuple(twins.T)] > 0.0]

    def fastest(pairs: Ints, count: int) -> Ints:
        return pairs[np.lexsort((_off(bench, pairs), -level[tuple(pairs.T)]))[:count]]

    first = fastest(ends, _FIRST)
    more = [pair for pair in fastest(twins, 1) if not (first == pair).all(axis=1).any()]
    first = np.concatenate([first, np.array(more, dtype=np.intp).reshape(-1, 2)])
    return rate[tuple(first.T)], first


def twins_of(bench: Bench) -> Ints:
    """Pairs (p, 2) of blocks of the region that alone have their volume and their height."""
    own, like = _alike(bench)
    alone = like.sum(axis=1) == 2
    return own[np.argwhere(np.triu(like, 1) & alone & alone[:, None])]


def _alike(bench: Bench) -> tuple[Ints, Bools]:
    """The blocks (o,) of the region, and which (o, o) of them have one volume and one height."""
    own, blocks = np.sort(bench.own), bench.local.assembly
    volume, height = blocks.volume[own], blocks.centroid[own, 2] / blocks.size[own].max()
    like = np.isclose(volume, volume[:, None], rtol=ALIKE, atol=0.0)
    return own, like & (np.abs(height - height[:, None]) < ALIKE)


def _rings(bench: Bench) -> list[tuple[_Ends, ...]]:
    """Ties around round rings of blocks alike that move outwards, the fastest ring first."""
    (own, like), centroid = _alike(bench), bench.local.assembly.centroid
    found: list[tuple[float, tuple[_Ends, ...]]] = []
    for row in np.unique(like, axis=0):
        some = own[row]
        way, far = unit(centroid[some, :2] - centroid[some, :2].mean(axis=0))
        out = float(dot(bench.motion[some, :2], way).mean())
        if len(some) > 4 and np.ptp(far) < ALIKE * far.max() and out > 0.0:  # four are two arches
            ring = some[np.argsort(np.arctan2(way[:, 1], way[:, 0]), kind="stable")]
            ends = zip(ring.tolist(), np.roll(ring, -1).tolist(), strict=True)
            found.append((round(-out, 9), tuple(ends)))
    return [ends for _, ends in sorted(found)[:_FIRST]]


def _hoop_words(bench: Bench, ring: tuple[_Ends, ...], forces: Floats, _: Floats) -> str:
    """Ties around a ring as text, with the largest of their forces [N]."""
    most, middle = quantity(float(lengths(forces).max()), "N"), [i for i, _ in ring]
    return (
        f"a ring of {len(ring)} ties between the middles of {names_of(bench.local, middle)}, of "
        f"which each pulls at most {most}"
    )


def lies_under_all(assembly: Assembly, block: int) -> bool:
    """Whether a block spreads below all others, as ground does: a tie has no end in its middle."""
    low, high = assembly.bounds[:, 0], assembly.bounds[:, 1]
    return bool(
        (low[block, :2] <= low[:, :2].min(axis=0)).all()
        and (high[block, :2] >= high[:, :2].max(axis=0)).all()
        and high[block, 2] <= np.delete(low[:, 2], block).min(initial=np.inf)
    )


def _off(bench: Bench, ends: Ints) -> Floats:
    """How far the middles of pairs of blocks (p, 2) are from that of the region: (p,) [m]."""
    centroid = bench.local.assembly.centroid
    return lengths(centroid[ends].mean(axis=1) - centroid[bench.own].mean(axis=0))
