"""The kinds of mends, and those of them that change blocks and joints."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from drystone.assembly import Block
from drystone.base.arrays import Floats, Ints, lengths, unit
from drystone.base.errors import InputError
from drystone.base.units import quantity
from drystone.design.bench import Bench, Held, Proposals, Take, Tried, Tries, held_by
from drystone.design.changed_model import acceleration_of, changed
from drystone.design.changes import (
    MOST,
    ROUGHEST,
    Change,
    ballast_change,
    friction_change,
    glue_change,
    glue_changes,
    joint_change,
)
from drystone.design.margin import LARGE_REGION, SMALL_REGION
from drystone.design.mends_beside import prop, support, tie, twins_of
from drystone.design.needs import SEARCHED, KnownNeeds, pulls_of_region
from drystone.design.props import tops_of
from drystone.design.surgery import (
    PARALLEL,
    free_sides,
    merge_blocks,
    thicken_blocks,
    thickened,
    thickness_of,
)
from drystone.design.words import glue_words, listed, names_of, towards
from drystone.model import Model
from drystone.supports import laid_ground

_SLID = (0.2, 0.5, 1.0)
"""Slides that are tried before the least one is searched, by the way to the middle of the joint. It
is found to a tenth of that: at the least itself a block is about to tip."""

_SHARES = (0.1, 0.3, 1.0)
"""Increases of thickness by that of the block, and decreases of overhangs by those, that are tried
before the least one is searched."""


def _kept(kind: str, what: str, names: str) -> Tried:
    return Tried(kind, f"{what} may not be changed (kept: {names})", f"with {names} kept")


def _friction(asked: KnownNeeds) -> Proposals:
    """The least friction of one joint, else of all that may be changed."""
    bench, count = asked.bench, asked.bench.local.contacts.count
    free = [k for k in range(count) if not bench.kept_at([k])]
    if not free:
        kept = _kept("friction", "its joints", bench.kept_at(range(count)))
        yield kept if count else "it touches no other block"
        return
    # no joint alone, and no margin, takes less than all joints take
    known = [asked.needs.friction] * len(free)
    each = [friction_change(bench.local, [k], f"in {bench.joint_name(k)}") for k in free]
    alone = len(free) == 1
    if len(bench.own) <= SMALL_REGION and not alone:
        yield Tries(each, "", known=known)
    every = each if alone else [friction_change(bench.local, free, "in all its joints")]
    which = "all its joints" if len(free) == count else "the joints that may change"
    why = f"it falls up to a coefficient of {ROUGHEST:g} in {which}"
    yield Tries(every, why, known=None if bench.large else known[:1], last=True)


def _slide(asked: KnownNeeds) -> Proposals:
    """The blocks of the region slid as one along a joint below, towards the middle of it."""
    bench, own = asked.bench, asked.bench.own
    stay = bench.kept(own)
    if stay:
        yield _kept("slide", "its blocks", stay)
        return

    def make(along: Floats, distance: float, model: Model, blocks: Ints, _: Ints) -> Model:
        some = {int(i): model.assembly.blocks[i] for i in blocks[own]}
        shift = distance * along
        return changed(model, {i: one.transformed(translation=shift) for i, one in some.items()})

    def words(way: Floats, distance: float) -> str:
        far = f"{1e3 * distance:.0f} mm towards {towards(way)}"
        return f"{names_of(bench.local, own)} slid by {far} on {names_of(bench.local, below)}"

    contacts, ways = bench.local.contacts, list(_ways_below(bench))
    below = sorted({other for other, _ in ways})
    outer = np.isin(contacts.block_a, own) != np.isin(contacts.block_b, own)
    changes = []
    for _, way in ways:
        far = math.hypot(*way)
        slid, told = partial(make, way / far), partial(words, way)
        steps = tuple(share * far for share in _SLID)
        changes.append(Change("slide", slid, told, steps, 0.1 * far, joints=int(outer.sum())))
    why = "it falls up to the middle of the joint below it" if ways else "no joint is below it"
    yield Tries(changes, why, Take.SMALLEST)
    yield Tries(_drawn_back(bench, below), "")


def _drawn_back(bench: Bench, below: list[int]) -> list[Change]:
    """Every block of the region drawn back above the blocks below, so that it overhangs less.

    Only where all joints lie along that way: each block then slides on the one below it.
    """
    local, own = bench.local, bench.own
    if len(own) < 2 or not below:
        return []
    mass, centroid, up = local.assembly.mass[own], local.assembly.centroid, -acceleration_of(local)
    way = mass @ centroid[own] / mass.sum() - centroid[below].mean(axis=0)
    way -= way @ up / (up @ up) * up
    if not way.any():
        return []
    way /= np.linalg.norm(way)
    if np.abs(local.contacts.frame[:, 0] @ way).max() > 1e-6:
        return []
    out = np.maximum((centroid[own] - centroid[below].mean(axis=0)) @ way, 0.0)

    def make(share: float, model: Model, blocks: Ints, _: Ints) -> Model:
        shifts = zip(blocks[own].tolist(), -share * out[:, None] * way, strict=True)
        some = model.assembly.blocks
        return changed(model, {i: some[i].transformed(translation=shift) for i, shift in shifts})

    def words(share: float) -> str:
        what = f"each of {names_of(local, own)} drawn back towards {towards(-way)}"
        far = f"the farthest by {1e3 * share * out.max():.0f} mm"
        return f"{what}, to overhang {100.0 * share:.0f} % less: {far}"

    return [Change("slide", make, words, _SHARES, 0.01, joints=local.contacts.count)]


def _ways_below(bench: Bench) -> Iterator[tuple[int, Floats]]:
    """Blocks on which the region lies, and the ways (3,) [m] to the middles of the joints there."""
    local, own = bench.local, bench.own
    mass = local.assembly.mass[own]
    middle = mass @ local.assembly.centroid[own] / mass.sum()
    for k, _, below, normal in _seats(local, own):
        way = local.contacts.centroid[k] - middle
        way -= way @ normal * normal
        if way.any():
            yield below, way


def _seats(model: Model, own: Collection[int]) -> Iterator[tuple[int, int, int, Floats]]:
    """The joints with which some blocks lie on others, their two blocks and their normals (3,)."""
    contacts, up = model.contacts, -acceleration_of(model)
    pairs = zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
    for k, (a, b) in enumerate(pairs):
        normal = contacts.frame[k, 0] * (1.0 if b in own else -1.0)
        if (a in own) != (b in own) and normal @ up > 0.5 * np.linalg.norm(up):
            yield (k, b, a, normal) if b in own else (k, a, b, normal)


def _joints(asked: KnownNeeds, kind: str) -> Proposals:
    """Joints rotated, made wedges or let in: each one in a small region, else all together."""
    bench, count = asked.bench, len(asked.bench.interfaces)
    small = len(bench.own) <= SMALL_REGION
    turn = asked.needs.turn
    known = [None if turn is None else turn.value] * 2 if kind == "turn" and small else None
    groups = [{k: 1.0} for k in range(count)] if small else [dict.fromkeys(range(count), 1.0)]
    for group in (*groups, *bench.alike()):
        last = small and len(group) > 1
        name = bench.joint_name(next(iter(group))) if len(group) == 1 else "all its joints"
        name = f"{bench.joints_named(list(group))}, each" if last else name
        stay = bench.kept_at(list(group))
        if stay:
            yield _kept(kind, name.rstrip(","), stay)
            continue
        try:
            sides = [
                joint_change(bench.local, kind, {k: sign * group[k] for k in group}, name)
                for sign in (1.0, -1.0)
            ]
        except InputError as error:
            yield str(error)
            continue
        most = sides[0].steps[-1]
        told = f"{most:g} degrees" if kind != "let-in" else f"{1e3 * most:.0f} mm"
        why = f"{name.rstrip(',')} up to {told}"
        yield Tries(sides, why, Take.SMALLEST, None if last else known, last=last)


def _thicker(asked: KnownNeeds) -> Proposals:
    """Thicker blocks of the region; where that does not hold the whole, all blocks.

    Members are of one thickness but for the least increase that is tried, and along one line, as
    piers below a ring are: each is tried alone, too, with what it lies on, and those together that
    are along one line, as piers and abutments. What slides gets thicker along its way, what falls
    in the plane of others.
    """
    bench = asked.bench
    own = [i for i in bench.own if not bench.kept([i])]
    if not own:
        yield _kept("thicker", "its blocks", bench.kept(bench.own))
        return
    motion, size = bench.motion[own], bench.local.assembly.size[own]
    turning = size * lengths(motion[:, 3:]) > 0.01 * lengths(motion[:, :3])
    ways, _ = unit(motion[:, :3])
    level = np.cross(ways, unit(acceleration_of(bench.local))[0])
    slides = np.where(lengths(level)[:, None] > 0.01, level, 0.0)
    axes = np.where(turning[:, None], motion[:, 3:], slides)
    _, turns, about = np.linalg.svd(axes, full_matrices=False)
    if (turns[1:] <= 0.01 * turns[0]).all():
        axes[~axes.any(axis=1)] = turns[0] * about[0]
    way, thick = unit(thickness_of(bench.local, own, axes)[1])
    some = np.flatnonzero(thick)
    if not len(some):
        yield f"{names_of(bench.local, own)} have no free faces to move"
        return
    own, axes, way, thick = [own[k] for k in some], axes[some], way[some], thick[some]

    def region(which: Ints, _: Model, blocks: Ints) -> tuple[list[int], Floats]:
        return blocks[np.array(own)[which]].tolist(), axes[which]

    def tries(grown: _Grown) -> Tries:
        make, words = partial(_thickened, grown), partial(_thicker_words, bench, grown)
        some, about = grown(bench.model, bench.blocks)
        along = _along(thickness_of(bench.model, some, about)[1])
        shares = listed([f"{100.0 * share:g}" for share in _SHARES])
        why = f"{shares} % more thickness of {names_of(bench.model, some)}{along}"
        return Tries([Change("thicker", make, words, _SHARES, 0.02)], why)

    order = np.argsort(thick, kind="stable")
    ends = np.flatnonzero(np.diff(thick[order]) > _SHARES[0] * thick[order][:-1]) + 1
    members = [part for one in np.split(order, ends) for part in _in_two_lines(np.sort(one), way)]
    for one in (*members, *_in_line(members, way)) if 1 < len(members) <= SMALL_REGION else ():
        yield tries(partial(region, one))
        line = (np.abs(way[one] @ way[one[0]]) > PARALLEL).all()
        below = _below(bench, [own[k] for k in one], axes[one[0]]) if line else ()
        if below:
            yield tries(partial(_with_names, below, axes[one[0]]))
    failed = len(bench.tried)
    yield tries(partial(region, np.arange(len(own))))
    if len(bench.tried) > failed and not bench.keep:
        yield tries(partial(_all_thicker, own, axes))


def _below(bench: Bench, own: list[int], axis: Floats) -> tuple[str, ...]:
    """Names of blocks of the local model and of all on which they lie, down to supports.

    Down to what has no free faces across the axis, too. None where these are of the region too, or
    may not be changed.
    """
    model, names = bench.model, bench.model.assembly.names
    some = [bench.region[i] for i in own]
    more, ends = some, np.flatnonzero(model.assembly.fixed).tolist()
    while more:
        below = sorted({other for _, _, other, _ in _seats(model, some)} - {*some, *ends})
        faces, _ = thickness_of(model, below, np.tile(axis, (len(below), 1)))
        more = [i for i, moved in zip(below, faces, strict=True) if moved]
        some += more
    new = set(some[len(own) :])
    return () if not new or new & {*bench.region, *bench.keep} else tuple(names[i] for i in some)


def _with_names(
    names: tuple[str, ...], axis: Floats, model: Model, _: Ints
) -> tuple[list[int], Floats]:
    """The blocks with these names, and the axis about which they turn for each."""
    grown = model.assembly.indices([one for one in names if one in model.assembly]).tolist()
    return grown, np.tile(axis, (len(grown), 1))


def _in_two_lines(member: Ints, way: Floats) -> list[Ints]:
    """The two parts of a member that get thicker along two lines, by ways (o, 3); else itself."""
    first = np.abs(way[member] @ way[member[0]]) > PARALLEL
    parts = [member[first], member[~first]]
    two = [len(one) > 0 and (np.abs(way[one] @ way[one[0]]) > PARALLEL).all() for one in parts]
    return parts if all(two) else [member]


def _in_line(members: list[Ints], way: Floats) -> Iterator[Ints]:
    """Members of a region, some but not all, that get thicker along one line, by ways (o, 3)."""
    for first in members:
        same = [one for one in members if (np.abs(way[one] @ way[first[0]]) > PARALLEL).all()]
        if 1 < len(same) < len(members) and same[0] is first:
            yield np.sort(np.concatenate(same))


def _all_thicker(
    own: list[int], axes: Floats, model: Model, blocks: Ints
) -> tuple[list[int], Floats]:
    """All free blocks, and supports no thicker than these, with the axes about which they turn."""
    most = np.linalg.svd(axes, full_matrices=False)[2][0] if axes.any() else np.zeros(3)
    about = np.tile(most, (len(model), 1))
    about[blocks[own]] = axes
    free = model.assembly.free.tolist()
    ends = set(np.flatnonzero(model.assembly.fixed).tolist()) - {laid_ground(model.assembly)}
    some = free + sorted(ends)
    thick = lengths(thickness_of(model, some, about[some])[1])
    wide = 1.01 * thick[: len(free)].max()
    grown = [i for i, far in zip(some, thick, strict=True) if 0.0 < far < wide]
    return grown, about[grown]


_Grown: TypeAlias = Callable[[Model, Ints], tuple[list[int], Floats]]
"""Blocks of a model that get thicker, and the axes (b, 3) about which they turn."""


def _thickened(grown: _Grown, share: float, model: Model, blocks: Ints, _: Ints) -> Model:
    some, axes = grown(model, blocks)
    return thicken_blocks(model, some, share, axes)


def _along(across: Floats) -> str:
    """The line, else the plane, along which some blocks get thicker by ways (b, 3), as text."""
    ways = unit(across)[0]
    if (np.abs(ways @ ways[0]) > PARALLEL).all():
        return f", along {towards(across[0]).lstrip('+-')}"
    flat = np.abs(ways).max(axis=0) < 0.01
    return f", in the plane {'xyz'.replace('xyz'[flat.argmax()], '')}" if flat.any() else ""


def _thicker_words(bench: Bench, grown: _Grown, share: float) -> str:
    model, (some, axes) = bench.model, grown(bench.model, bench.blocks)
    faces, across = thickness_of(model, some, axes)
    size = lengths(across)
    least, most = (quantity(size.min() * by, "m") for by in (1.0, 1.0 + share))
    thinnest = "" if size.max() < 1.01 * size.min() else "the thinnest "
    told = f"{names_of(model, some)} thicker by {100.0 * share:.0f} %, {thinnest}from {least} to "
    half = "half of it on each of two opposite free faces"
    free = "on the free faces that no earth and no fill presses"
    ways = {2: half, 1: "on one free face" if model.load.surface is None else free}
    count = np.array([len(sides) for sides in free_sides(model, some, faces)])
    parts = [
        (names_of(model, np.array(some)[own].tolist()), f"{how}{_along(across[own])}")
        for number, how in ways.items()
        if (own := count == number).any()
    ]
    both = "; ".join(f"{who} {how}" for who, how in parts)
    told += f"{most}: {both}" if len(parts) > 1 else f"{most}, {parts[0][1]}"
    with contextlib.suppress(InputError):  # of a share that is too large, of which no mend is made
        bodies = thickened(model, some, share, faces, across)
        below, far = _overhung(model, dict(zip(some, bodies, strict=True)), across)
        if below:
            told += f"; they overhang {names_of(model, below)} by {quantity(far, 'm')}"
            told += " (on wider ones less may do)"
    return told


def _overhung(model: Model, made: Mapping[int, Block], across: Floats) -> tuple[list[int], float]:
    """The blocks on which some that got thicker lie and which these overhang, and how far [m].

    That is measured in the plane of their joint, across (b, 3) the blocks that got thicker.
    """
    blocks, ways = model.assembly.blocks, dict(zip(made, across, strict=True))
    found: dict[int, float] = {}
    for k, own, other, normal in _seats(model, made):
        near, size = model.contacts.centroid[k], float(model.assembly.size[own])
        way, _ = unit(ways[own] - ways[own] @ normal * normal)
        reach = []
        for vertices in (made[own].vertices, blocks[own].vertices, blocks[other].vertices):
            on = np.abs((vertices - near) @ normal) < 1e-3 * size
            along = (vertices[on] if on.any() else vertices) @ way
            reach.append((along.max(), -along.min()))
        now, was, below = np.array(reach)
        far = float(np.where(now > was, now - below, 0.0).max())
        if far > 1e-3 * size:
            found[other] = max(found.get(other, 0.0), far)
    return sorted(found), max(found.values(), default=0.0)


def _ballast(asked: KnownNeeds) -> Proposals:
    """The least weight on one block of few; else on each of two.

    Those are the two that rise most when it falls, and twins that move apart, as the tops of piers
    that an arch pushes outward do: the two pairs farthest apart.
    """
    bench, ballast = asked.bench, asked.needs.ballast
    own, tops = len(bench.own), tops_of(bench.local, bench.own)
    if ballast is not None:
        on = bench.region.index(ballast.at[0])
        change = ballast_change(bench.local, own, {on: tops[on]})
        same = replace(change, steps=(ballast.value,), low=ballast.value)
        yield Tries([same], "the least weight does not keep the margin")
        return
    rise = bench.motion[:own, :3] @ -acceleration_of(bench.local)
    share = np.round(rise / (np.abs(rise).max() or 1.0), 6)
    two = sorted((i for i in tops if share[i] > 0.0), key=lambda i: -share[i])[:2]
    pairs = [*([two] if len(two) > 1 else []), *_spreading(bench, tops)]
    weight = float(
        bench.local.assembly.mass[:own].sum() * math.hypot(*acceleration_of(bench.local))
    )
    why = f"no weight up to {MOST:g} times the {quantity(weight, 'N')} of the region holds it"
    single = list(tops) if own <= SEARCHED else []
    where = [f"{'one of ' * (len(single) > 1)}{names_of(bench.local, single)}"] if single else []
    where += [f"each of {names_of(bench.local, pair)}" for pair in pairs]
    why += f" in the middle of the free top of {', or of '.join(where)}" if where else ": none fits"
    changes = [ballast_change(bench.local, own, {i: tops[i] for i in pair}) for pair in pairs]
    yield Tries(changes, why, Take.SMALLEST)


def _spreading(bench: Bench, tops: Mapping[int, Floats]) -> list[list[int]]:
    """Pairs of twins with free tops that move apart, the two farthest apart."""
    centroid, found = bench.local.assembly.centroid, list[tuple[float, list[int]]]()
    for i, j in twins_of(bench).tolist():
        way, far = unit(centroid[j] - centroid[i])
        if i in tops and j in tops and (bench.motion[j, :3] - bench.motion[i, :3]) @ way > 0.0:
            found.append((-round(far / bench.local.assembly.size.max(), 6), [i, j]))
    return [pair for _, pair in sorted(found)[:2]]


def _glue(asked: KnownNeeds) -> Proposals:
    """Glue in one joint: the least strength with which the region stands.

    In a larger region, the same glue in all joints that would pull.
    """
    bench = asked.bench
    at = {whole: k for k, whole in enumerate(bench.interfaces.tolist())}
    pulls = pulls_of_region(bench) if bench.large else asked.needs.pulls
    pulling = [(at[pull.interface], pull.force) for pull in pulls if pull.interface in at]
    changes = glue_changes(bench.local, len(bench.own), pulling, SMALL_REGION)
    free = {on: one for on, one in changes.items() if not bench.kept_at(on)}
    if not free:
        kept = _kept("glue", "its joints", bench.kept_at([k for on in changes for k in on]))
        yield kept if changes else "none of its joints would pull"
        return
    found = {frozenset(one.at): one.value for one in asked.needs.glue}
    known = [found.get(frozenset(bench.interfaces[list(on)].tolist())) for on in free]
    some = list(free.values())
    why = f"it falls with glue of {MOST:g} times its weight in any one of its joints"
    if len(bench.own) > SMALL_REGION:
        most = quantity(some[0].steps[-1], "N")
        why = f"it falls with glue of {most} in the {some[0].joints} joints that pull"
    yield Tries(some, why, known=None if bench.large else known)
    words = partial(glue_words, bench.local)
    both = [
        glue_change(
            on, some[0].steps, some[0].close, partial(words, on, name=bench.joints_named(on))
        )
        for on in map(tuple, bench.alike())
    ]
    yield Tries(both, "", last=True)


def _merge(asked: KnownNeeds) -> Proposals:
    """Two blocks made one."""
    bench = asked.bench
    contacts, fixed = bench.local.contacts, bench.local.assembly.fixed
    strengths = {frozenset(glue.at): glue.value for glue in asked.needs.glue}
    pairs = list(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))

    def make(ends: tuple[int, int], model: Model, blocks: Ints, _: Ints) -> Model:
        return merge_blocks(model, int(blocks[ends[0]]), int(blocks[ends[1]]))

    changes = []
    for a, b in dict.fromkeys(pairs):
        if bench.kept([a, b]):
            continue
        ends = (a, b) if fixed[a] or not fixed[b] else (b, a)
        own = [k for k, pair in enumerate(pairs) if {*pair} == {a, b}]
        held = strengths.get(frozenset(bench.interfaces[own].tolist()), 0.0)
        glue = glue_words(bench.local, own, held, whole=False)
        enough = f" ({glue} is enough)" if held > 0.0 else ""
        words = f"{names_of(bench.local, [a, b])} made one block{enough}"
        changes.append(Change.single("merge", partial(make, ends), words, held, joints=len(own)))
    why = "it falls with any two of its blocks made one"
    stay = bench.kept_at(range(contacts.count))
    if changes or not stay:
        yield Tries(changes, why)
    else:
        yield _kept("merge", "its blocks", stay)


_PROPOSED: Mapping[str, Callable[[KnownNeeds], Proposals]] = {
    "support": support,
    "prop": prop,
    "tie": tie,
    "friction": _friction,
    "slide": _slide,
    "turn": partial(_joints, kind="turn"),
    "wedge": partial(_joints, kind="wedge"),
    "let-in": partial(_joints, kind="let-in"),
    "thicker": _thicker,
    "ballast": _ballast,
    "glue": _glue,
    "merge": _merge,
}
"""What proposes the changes of each kind."""

_LARGEST = {
    **dict.fromkeys(("support", "merge"), SMALL_REGION),
    **dict.fromkeys(("slide", "turn", "wedge", "let-in", "ballast"), LARGE_REGION),
}
"""The largest number of blocks of a region on which a kind is tried, where there is one. Chosen: a
cut takes a twentieth of a second."""

KINDS = tuple(_PROPOSED)
"""The kinds of mends."""


def holding(kind: str, asked: KnownNeeds) -> Iterator[Held]:
    """The changes of a kind that hold a region, with their least values; else it is noted why."""
    bench = asked.bench
    largest = _LARGEST.get(kind, len(bench.own))
    if len(bench.own) > largest:
        what = f"not tried on a region of more than {largest} blocks"
        bench.tried.append(Tried(kind, what, "on so many blocks (drystone shape may help)"))
        return
    yield from held_by(bench, kind, _PROPOSED[kind](asked), asked.known)
