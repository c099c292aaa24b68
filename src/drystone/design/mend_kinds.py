"""The kinds of mends: the changes of each that are tried on a region."""

from __future__ import annotations

import enum
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Floats, Ints, lengths
from drystone.base.display import rounded_up
from drystone.base.errors import InputError, counted
from drystone.base.units import quantity
from drystone.checks import first_motion_of
from drystone.design.bench import Bench, Held, Tried
from drystone.design.changed_model import acceleration_of, changed
from drystone.design.changes import (
    MOST,
    ROUGHEST,
    Change,
    ballast_change,
    block_added,
    friction_change,
    glue_changes,
    joint_change,
    props_at,
)
from drystone.design.margin import LARGE_REGION, SMALL_REGION, DesignMargin, quick_check
from drystone.design.needs import SEARCHED, Needs, props_of, pulls_of_region
from drystone.design.props import PropSeat, carries, find_props, struts
from drystone.design.search import least
from drystone.design.surgery import merge_blocks, thicken_blocks, thickness_of
from drystone.design.words import force_words, glue_words, listed, names_of, place, towards
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.supports import laid_ground
from drystone.ties import tied


class Take(enum.Enum):
    """Which of some changes that hold a region are told."""

    EACH = enum.auto()
    FIRST = enum.auto()
    SMALLEST = enum.auto()


@dataclass(frozen=True, eq=False)
class Tries:
    """Changes of one kind that are tried, and what is said if none of them holds the region.

    Attributes
    ----------
    changes
    why
        Empty where nothing is said.
    take
    known
        The least values that the diagnosis found without a margin, ``None`` where it found none;
        where left out it did not look for them. Searches that begin there save a tenth of the time
        of all mends.
    last
        Whether they are tried only where none before them holds it.
    told
        Makes the change that is said from the one that holds it.
    """

    changes: Sequence[Change]
    why: str
    take: Take = Take.EACH
    known: Sequence[float | None] | None = None
    last: bool = False
    told: Callable[[Change], Held] | None = None


@dataclass(frozen=True, eq=False)
class KnownNeeds:
    """What the changes of a region are proposed from.

    Attributes
    ----------
    bench
    needs
        What the diagnosis found that would hold it, without a margin.
    known
        Whether that is of the same local model: not where supports have moved.
    """

    bench: Bench
    needs: Needs
    known: bool


Proposals: TypeAlias = Iterator[Tries | Tried | str]
"""Changes to try, and why others are not tried."""


def held_by(kind: str, proposals: Proposals, asked: KnownNeeds) -> Iterator[Held]:
    """The changes of a kind that hold a region, with their least values; else it is noted why."""
    bench, holds = asked.bench, False
    for tries in proposals:
        if isinstance(tries, Tried):
            bench.tried.append(tries)
        elif isinstance(tries, str):
            bench.fail(kind, tries)
        elif not (tries.last and holds):
            found = _held(bench, tries, asked.known)
            holds = holds or bool(found)
            yield from found
            if not found and tries.why:
                bench.fail(kind, tries.why, *(one.make(one.steps[-1]) for one in tries.changes))


def _held(bench: Bench, tries: Tries, known: bool) -> list[Held]:
    """Those of some changes that hold a region."""
    changes = list(tries.changes)
    if known and tries.known is not None:
        pairs = zip(changes, tries.known, strict=True)
        changes = [change.above(value) for change, value in pairs if value is not None]
    if tries.take is Take.SMALLEST:
        best = bench.smallest(changes)
        return [] if best is None else [best]
    found: list[Held] = []
    for change in changes:
        value = bench.least(change)
        if value is not None:
            found.append((change, value) if tries.told is None else tries.told(change))
            if tries.take is Take.FIRST:
                break
    return found


_FIRST = 6
"""Number of struts of one block that are tried, the shortest first, and of pairs of blocks between
which a tie is tried: those that move apart fastest, that with the least pull times length by
virtual work first, and of equal ones that nearest the middle of the region."""

_TIES = 4
"""Number of ties that are tried together in a region. Chosen: two arches under a beam need two."""

_SLID = (0.2, 0.5, 1.0)
"""Slides that are tried before the least one is searched, by the way to the middle of the joint. It
is found to a tenth of that: at the least itself a block is about to tip."""

_SHARES = (0.1, 0.3, 1.0)
"""Increases of thickness by that of the block, and decreases of overhangs by those, that are tried
before the least one is searched."""


def _support(asked: KnownNeeds) -> Proposals:
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


def _prop(asked: KnownNeeds) -> Proposals:
    """One prop, with the least force; else a few props that hold the region together."""
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
    seats = [one.seat for one in found.props]
    if not seats:
        yield f"no prop holds it: tried were {found.tried}"
        return

    words = partial(_prop_words, bench, seats)
    told = partial(_by_force, bench, len(seats), words)
    for smooth, why in ((True, ""), (False, "the best props do not keep the margin")):
        change = Change.single("prop", props_at(seats, smooth=smooth), "", added=len(seats))
        yield Tries([change], why, last=True, told=told)


_TOLD = 4
"""Props of a mend that are told. Chosen: 26 filled a screen and covered the picture."""


def _prop_words(bench: Bench, seats: Sequence[PropSeat], forces: Floats, points: Floats) -> str:
    """Props with their forces [N] and places [m] as text; equal forces are told once.

    Of many the largest: the mended model has a block for each.
    """
    each, model, where = [force_words(force) for force in forces], bench.local, list[str]()
    for seat, force, point in zip(seats, forces, points, strict=True):
        side = "under" if carries(model, seat.block, force) else "against"
        where.append(f"{side} {names_of(model, [seat.block])} at {place(point)}")
    if len(seats) > 1 and len(set(each)) == 1:
        return f"{len(seats)} props: each of {each[0]}, {', '.join(where)}"
    told = [f"{force} {at}" for force, at in zip(each, where, strict=True)]
    if len(told) > _TOLD:
        order = np.argsort(-lengths(forces), kind="stable")
        told = [told[i] for i in order[: _TOLD - 1]]
        told.append(f"and {len(seats) - len(told)} with less")
    some = ", ".join(told)
    if len(seats) > 1:
        return f"{len(seats)} props: {some}"
    return f"a prop of {some}{_steady(bench, seats[0].block, forces[0], points[0])}"


def _by_force(
    bench: Bench, count: int, words: Callable[[Floats, Floats], str], change: Change
) -> Held:
    """A change told by the forces [N] of its last joints at the margin."""
    make = change.make(0.0)
    forces, points = bench.largest_forces(make, count)
    told, total = words(forces, points), float(np.linalg.norm(forces, axis=1).sum())
    if bench.margin != DesignMargin():
        told += ": the largest force at the margin"
    return Change.single(change.kind, make, told, total, added=change.added), total


def _steady(bench: Bench, block: int, force: Floats, point: Floats) -> str:
    """The least steady force that holds a region which a prop holds that cannot give way."""
    if bench.large or bench.margin != DesignMargin():
        return ""
    local = bench.local
    push = LoadCase.point_load(local.assembly, block, force, point)

    def stands(share: float) -> bool:
        return bench.keeps_margin(local.with_load(local.load + share * push), quick=True)

    share = least(stands, (1.0,))
    size = quantity(rounded_up((share or 0.0) * math.hypot(*force), 2), "N")
    told = f", if it does not give: size it for this; the least steady force there is {size}"
    return told if share else ""


_Ends: TypeAlias = tuple[int, int]


def _tie(asked: KnownNeeds) -> Proposals:
    """Ties between the centroids of two blocks that move apart: they pull, and never press.

    One, else more: each between those that move apart fastest with the ties before it.
    """
    bench, local = asked.bench, asked.bench.local
    centroid, size = local.assembly.centroid, local.assembly.size.max()
    apart = _apart(bench, bench.motion)
    if not apart:
        yield "no blocks move apart"
        return
    fastest = max(rate for rate, _ in apart)

    def bulk(pair: tuple[float, _Ends]) -> tuple[float, float]:
        rate, (i, j) = pair
        far = float(np.linalg.norm(centroid[i] - centroid[j]))
        return round(far / size * fastest / rate, 6), _off(bench, pair[1])

    def make(ties: tuple[_Ends, ...], model: Model, blocks: Ints, _: Ints) -> Model:
        for i, j in ties:
            model = tied(model, int(blocks[i]), int(blocks[j]))
        return model

    def words(ties: tuple[_Ends, ...], forces: Floats, _: Floats) -> str:
        told = []
        for (i, j), force in zip(ties, forces, strict=True):
            far, pull = np.linalg.norm(centroid[i] - centroid[j]), math.hypot(*force)
            between = f"the middles of {names_of(local, [i, j])}, {far:.3g} m apart"
            told.append(f"{quantity(pull, 'N')} between {between}")
        several = f"{len(told)} ties that pull" if len(told) > 1 else "a tie that pulls"
        return f"{several} {listed(told)}"

    def tries(several: list[tuple[_Ends, ...]], why: str) -> Tries:
        of = {
            Change.single("tie", partial(make, ties), "", added=len(ties)): ties for ties in several
        }

        def told(change: Change) -> Held:
            return _by_force(bench, len(of[change]), partial(words, of[change]), change)

        return Tries(list(of), why, Take.FIRST, told=told)

    first = sorted(apart[:_FIRST], key=bulk)
    why = f"a tie between blocks that move apart, of {counted(len(first), 'pair')}"
    several: list[tuple[_Ends, ...]] = [(ends,) for _, ends in first]
    ties: tuple[_Ends, ...] = ()
    for count in range(2, _TIES + 2):
        failed = len(bench.tried)
        yield tries(several, why)
        if len(bench.tried) == failed or bench.large or not apart or count > _TIES:
            return
        ties = (*ties, apart[0][1])
        made = make(ties, local, np.arange(len(local)), np.arange(0))
        fallen = quick_check(bench.holds(made, bench.margin).model, bench.stop)
        if fallen.prop is None:
            return
        apart = _apart(bench, first_motion_of(fallen.model, fallen.prop), ties)
        several, why = [(*ties, ends) for _, ends in apart[:1]], f"{count} ties, each where most"


def _apart(bench: Bench, motion: Floats, ties: tuple[_Ends, ...] = ()) -> list[tuple[float, _Ends]]:
    """Pairs of blocks that move apart, the fastest first, of equal ones that nearest the middle."""
    local, own = bench.local.assembly, bench.own
    used = [i for ends in ties for i in ends]
    velocity = np.where(local.fixed[:, None], 0.0, motion[:, :3])
    found: list[tuple[float, _Ends]] = []
    for i in own:
        along = local.centroid - local.centroid[i]
        size = np.linalg.norm(along, axis=1)
        rate = ((velocity - velocity[i]) * along).sum(axis=1) / np.where(size > 0.0, size, 1.0)
        rate[[j for j in own if j <= i]] = 0.0  # each pair once
        rate[used] = 0.0
        if i not in used:
            found += [(float(rate[j]), (i, int(j))) for j in np.flatnonzero(rate > 0.0)]
    most = max((rate for rate, _ in found), default=1.0)
    return sorted(found, key=lambda pair: (-round(pair[0] / most, 6), _off(bench, pair[1])))


def _off(bench: Bench, ends: _Ends) -> float:
    """How far the middle of two blocks is from that of the region."""
    centroid = bench.local.assembly.centroid
    way = centroid[list(ends)].mean(axis=0) - centroid[bench.own].mean(axis=0)
    return float(np.linalg.norm(way))


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
    mass, up = local.assembly.mass[own], -acceleration_of(local)
    middle = mass @ local.assembly.centroid[own] / mass.sum()
    contacts = local.contacts
    for k, (a, b) in enumerate(zip(contacts.block_a, contacts.block_b, strict=True)):
        normal = contacts.frame[k, 0] * (1.0 if b in own else -1.0)
        way = contacts.centroid[k] - middle
        way -= way @ normal * normal
        if (a in own) != (b in own) and normal @ up > 0.5 * np.linalg.norm(up) and way.any():
            yield int(a if b in own else b), way


def _joints(asked: KnownNeeds, kind: str) -> Proposals:
    """Joints rotated, made wedges or let in: each one in a small region, else all together."""
    bench, count = asked.bench, len(asked.bench.interfaces)
    small = len(bench.own) <= SMALL_REGION
    turn = asked.needs.turn
    known = [None if turn is None else turn.value] * 2 if kind == "turn" and small else None
    for group in [[k] for k in range(count)] if small else [list(range(count))]:
        name = bench.joint_name(group[0]) if len(group) == 1 else "all its joints"
        stay = bench.kept_at(group)
        if stay:
            yield _kept(kind, name.rstrip(","), stay)
            continue
        try:
            sides = [joint_change(bench.local, kind, group, side, name) for side in (1.0, -1.0)]
        except InputError as error:
            yield str(error)
            continue
        most = sides[0].steps[-1]
        told = f"{most:g} degrees" if kind != "let-in" else f"{1e3 * most:.0f} mm"
        yield Tries(sides, f"{name.rstrip(',')} up to {told}", Take.SMALLEST, known)


def _thicker(asked: KnownNeeds) -> Proposals:
    """Thicker blocks of the region; where that does not hold the whole, all blocks."""
    bench, own = asked.bench, asked.bench.own
    stay = bench.kept(own)
    if stay:
        yield _kept("thicker", "its blocks get thicker together, and some", stay)
        return
    motion, size = bench.motion[own], bench.local.assembly.size[own]
    turning = size * lengths(motion[:, 3:]) > 0.01 * lengths(motion[:, :3])
    axes = np.where(turning[:, None], motion[:, 3:], 0.0)

    def region(_: Model, blocks: Ints) -> tuple[list[int], Floats]:
        return blocks[own].tolist(), axes

    def every(model: Model, blocks: Ints) -> tuple[list[int], Floats]:
        most = np.linalg.svd(axes)[2][0] if axes.any() else np.zeros(3)
        about = np.tile(most, (len(model), 1))
        about[blocks[own]] = axes
        free = model.assembly.free.tolist()
        ends = set(np.flatnonzero(model.assembly.fixed).tolist()) - {laid_ground(model.assembly)}
        wide = max(_thick(model, i, about[i]) for i in free)
        grown = free + [i for i in sorted(ends) if _thick(model, i, about[i]) < 1.01 * wide]
        return grown, about[grown]

    why = f"{listed([f'{100.0 * share:g}' for share in _SHARES])} % more thickness"
    for grown in (region,) if bench.keep else (region, every):
        failed = len(bench.tried)
        make, words = partial(_thickened, grown), partial(_thicker_words, bench, grown)
        yield Tries([Change("thicker", make, words, _SHARES, 0.02)], why)
        if len(bench.tried) == failed:
            return


def _thick(model: Model, block: int, axis: Floats) -> float:
    return float(np.linalg.norm(thickness_of(model, block, axis)[1]))


_Grown: TypeAlias = Callable[[Model, Ints], tuple[list[int], Floats]]
"""Blocks of a model that get thicker, and the axes (b, 3) about which they turn."""


def _thickened(grown: _Grown, share: float, model: Model, blocks: Ints, _: Ints) -> Model:
    some, axes = grown(model, blocks)
    return thicken_blocks(model, some, share, axes)


def _thicker_words(bench: Bench, grown: _Grown, share: float) -> str:
    model, (some, axes) = bench.model, grown(bench.model, bench.blocks)
    across = np.array([thickness_of(model, *one)[1] for one in zip(some, axes, strict=True)])
    size = lengths(across)
    least, most = (quantity(size.min() * by, "m") for by in (1.0, 1.0 + share))
    thinnest = "" if size.max() < 1.01 * size.min() else "the thinnest "
    told = f"{names_of(model, some)} thicker by {100.0 * share:.0f} %, {thinnest}from {least} to "
    told += f"{most}, half of it on each of two opposite free faces"
    if (np.abs(across @ across[0]) > 0.99 * size * size[0]).all():
        told += f", along {towards(across[0]).lstrip('+-')}"
    ends = bench.blocks[bench.local.assembly.fixed].tolist()
    rest = [i for i in ends if i not in some and i != laid_ground(model.assembly)]
    return (
        f"{told}; they overhang {names_of(model, rest)} where these are no wider" if rest else told
    )


def _ballast(asked: KnownNeeds) -> Proposals:
    """The least weight on one block."""
    bench, ballast = asked.bench, asked.needs.ballast
    if ballast is None:
        yield f"no weight up to {MOST:g} times its own on one block holds it"
        return
    at = bench.region.index(ballast.at[0])
    change = ballast_change(bench.local, len(bench.own), at)
    same = replace(change, steps=(ballast.value,), low=ballast.value)
    yield Tries([same], "the least weight does not keep the margin")


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
    "support": _support,
    "prop": _prop,
    "tie": _tie,
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
    **dict.fromkeys(("slide", "turn", "wedge", "let-in"), LARGE_REGION),
    "ballast": SEARCHED,
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
    yield from held_by(kind, _PROPOSED[kind](asked), asked)
