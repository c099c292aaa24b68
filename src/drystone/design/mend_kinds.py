"""The kinds of mends: for each, the changes that hold a region, and what did not do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.errors import InputError, counted
from drystone.design.bench import ALL, MANY, Bench
from drystone.design.block_surgery import merge_blocks, thicken_blocks
from drystone.design.changes import (
    HEAVIEST,
    ROUGHEST,
    STRONGEST,
    Change,
    Surgery,
    ballasted,
    block_added,
    friction_change,
    glue_changes,
    joint_change,
    props_at,
    tied,
)
from drystone.design.needs import SEARCHED
from drystone.design.props import find_props
from drystone.design.struts import struts
from drystone.design.words import glue_words, names_of, newtons, place
from drystone.model import Model

_STRUTS = 6
"""Number of struts of one block that are tried, the shortest first."""

_TIES = 6
"""Number of pairs of blocks between which a tie is tried, those that move apart fastest first."""

_THICKER = (0.1, 0.3, 1.0)
"""Increases of thickness that are tried before the least one is searched, relative to that of the
block."""

Held: TypeAlias = Iterator[tuple[Change, float]]
"""Changes that hold the region of a bench in its local model, with their least values."""


def _support(bench: Bench) -> Held:
    """A block below that fits between a block of the region and another one."""
    if len(bench.own) > MANY:
        bench.fail("support", f"not tried on a region of more than {MANY} blocks")
        return
    changes = []
    for whole in bench.region.blocks:
        for strut in struts(bench.model, whole, bench.motion[whole])[:_STRUTS]:
            on, held = (names_of(bench.model, [i]) for i in (strut.on, whole))
            size = f"a block of {strut.body.volume:.3g} m3, {strut.length:.3g} m long,"
            words = f"{size} between {on} and {held}"
            make = block_added(strut.body)
            change = Change.single("support", make, words, strut.length, added=1)
            beyond = () if strut.on in bench.blocks else (strut.on,)
            changes.append(replace(change, beyond=beyond))
    why = f"{len(changes)} blocks that fit were tried, the shortest first"
    for change in changes:
        if bench.least(change) is not None:
            yield change, change.steps[0]
            return
    bench.fail("support", why)


def _prop(bench: Bench) -> Held:
    """One prop, with the least force; else a few props that hold the region together."""
    found = bench.region.needs.props
    if bench.as_diagnosed:
        at = np.zeros(len(bench.model), dtype=np.intp)
        at[list(bench.region.blocks)] = bench.own
        found = found.renumbered(at)
    else:
        motion = bench.motion[bench.blocks]
        found = find_props(bench.local, bench.own, motion, bench.stop, single=bench.own[:MANY])
    chosen = [one.seat for one in found.props]
    if not chosen:
        bench.fail("prop", f"no prop holds it: tried were {found.tried}")
        return
    change = Change.single("prop", props_at(chosen), "", added=len(chosen))
    if bench.least(change) is None:
        bench.fail("prop", "the best props do not keep the margin")
        return
    sizes, points = bench.largest_forces(props_at(chosen), len(chosen))
    told = [
        f"{newtons(size)} against {names_of(bench.local, [seat.block])} at {place(point)}"
        for seat, size, point in zip(chosen, sizes.tolist(), points, strict=True)
    ]
    kind = "a prop of " if len(chosen) == 1 else f"{len(chosen)} props: "
    yield _of_force(change, float(sizes.sum()), kind + ", ".join(told))


def _of_force(change: Change, force: float, words: str) -> tuple[Change, float]:
    """A change with nothing to vary, told by the force [N] that it then carries."""
    return Change.single(change.kind, change.make(0.0), words, force, added=change.added), force


def _tie(bench: Bench) -> Held:
    """A tie between the centroids of two blocks that move apart: it pulls, and never presses."""
    centroid, velocity = bench.local.assembly.centroid, bench.motion[bench.blocks, :3]
    fixed = bench.local.assembly.fixed
    apart = []
    for i in bench.own:
        for j in range(len(bench.blocks)):
            if j == i or (j in bench.own and j < i):
                continue
            along = centroid[j] - centroid[i]
            other = np.zeros(3) if fixed[j] else velocity[j]
            rate = float((other - velocity[i]) @ along / np.linalg.norm(along))
            apart.append((rate, i, j))
    fastest = sorted((one for one in apart if one[0] > 0.0), reverse=True)[:_TIES]

    def make(ends: tuple[int, int], model: Model, blocks: Ints, _: Ints) -> Model:
        return tied(model, int(blocks[ends[0]]), int(blocks[ends[1]]))

    changes = [
        Change.single("tie", partial(make, (i, j)), names_of(bench.local, [i, j]), added=1)
        for _, i, j in fastest
    ]
    why = "no blocks move apart"
    if changes:
        why = f"a tie between blocks that move apart, of {counted(len(changes), 'pair')}"
    for change, _ in bench.holding("tie", changes, why):
        size = float(bench.largest_forces(change.make(0.0), 1)[0][0])
        words = f"a tie that pulls {newtons(size)} between {change.words(0.0)}"
        yield _of_force(change, size, words)
        return


def _friction(bench: Bench) -> Held:
    """The least friction of one joint, else of all that may be changed."""
    contacts = bench.local.contacts
    if contacts.count == 0:
        bench.fail("friction", "it touches no other block")
        return
    free = [k for k in range(contacts.count) if bench.may_change(k)]
    if not free:
        stay = bench.kept(contacts.block_a, contacts.block_b)
        bench.fail("friction", f"its joints may not be changed (kept: {stay})")
        return
    every = tuple(free)
    changes: dict[tuple[int, ...], Change] = {}
    if len(bench.own) <= MANY:
        for k in free:
            changes[(k,)] = friction_change(bench.local, [k], f"in {bench.joint_name(k)}")
    if every not in changes:
        changes[every] = friction_change(bench.local, free, "in all its joints")
    # no joint alone, and no margin, takes less than all joints take
    known, held = bench.region.needs.friction, False
    for on, change in changes.items():
        if held and len(on) > 1:
            break
        for new in bench.from_known(change, known):
            value = bench.least(new)
            if value is not None:
                held = True
                yield new, value
    if not held:
        which = "all its joints" if len(free) == contacts.count else "the joints that may change"
        what = f"it falls up to a coefficient of {ROUGHEST:g} in {which}"
        bench.fail("friction", what, changes[every].make(ROUGHEST))


def _joints(bench: Bench, kind: str) -> Held:
    """Joints rotated, made wedges or let in: each one in a small region, else all together."""
    if len(bench.own) > ALL:
        bench.fail(kind, f"not tried on a region of more than {ALL} blocks")
        return
    count = len(bench.interfaces)
    for group in [[k] for k in range(count)] if len(bench.own) <= MANY else [list(range(count))]:
        name = bench.joint_name(group[0]) if len(group) == 1 else "all its joints"
        if not all(bench.may_change(k) for k in group):
            contacts = bench.local.contacts
            stay = bench.kept(contacts.block_a[group], contacts.block_b[group])
            bench.fail(kind, f"{name.rstrip(',')} may not be changed (kept: {stay})")
            continue
        try:
            sides = [joint_change(bench.local, kind, group, side, name) for side in (1.0, -1.0)]
        except InputError as error:
            bench.fail(kind, str(error))
            continue
        changes = sides
        if kind == "turn" and len(bench.own) <= MANY:
            turn = bench.region.needs.turn
            known = None if turn is None else turn.value
            changes = [one for side in sides for one in bench.from_known(side, known)]
        best: tuple[Change, float] | None = None
        for change in changes:
            value = bench.least(change, np.inf if best is None else best[1])
            best = best if value is None else (change, value)
        if best is not None:
            yield best
        else:
            most = sides[0].steps[-1]
            told = f"{most:g} degrees" if kind != "let-in" else f"{1e3 * most:.0f} mm"
            farthest = [side.make(most) for side in sides]
            bench.fail(kind, f"{name.rstrip(',')} up to {told}", *farthest)


def _thicker(bench: Bench) -> Held:
    """Thicker blocks of the region."""
    if len(bench.own) > ALL:
        bench.fail("thicker", f"not tried on a region of more than {ALL} blocks")
        return
    if any(i in bench.keep for i in bench.region.blocks):
        stay = bench.kept(np.array(bench.own))
        bench.fail("thicker", f"its blocks may not be changed (kept: {stay})")
        return

    def make(share: float) -> Surgery:
        return lambda model, blocks, _: thicken_blocks(model, blocks[bench.own].tolist(), share)

    def words(share: float) -> str:
        return f"{names_of(bench.model, bench.region.blocks)} thicker by {100.0 * share:.0f} %"

    why = f"up to {100.0 * _THICKER[-1]:g} % more thickness"
    yield from bench.holding("thicker", [Change("thicker", make, words, _THICKER, 0.02)], why)


def _ballast(bench: Bench) -> Held:
    """The least weight on one block."""
    ballast = bench.region.needs.ballast
    if ballast is None:
        what = f"no weight up to {HEAVIEST:g} times its own on one block holds it"
        if len(bench.own) > SEARCHED:
            what = f"not tried on a region of more than {SEARCHED} blocks"
        bench.fail("ballast", what)
        return
    weight, at = ballast.value, bench.region.blocks.index(ballast.at[0])

    def make(model: Model, blocks: Ints, _: Ints) -> Model:
        return ballasted(model, int(blocks[at]), weight)

    words = f"a weight of {newtons(weight)} on {names_of(bench.model, ballast.at)}"
    change = Change.single("ballast", make, words, weight, added=1)
    if bench.least(change) is not None:
        yield change, weight
    else:
        bench.fail("ballast", "the least weight does not keep the margin")


def _glue(bench: Bench) -> Held:
    """Glue in one joint: the least strength with which the region stands.

    In a larger region, the same glue in all joints that would pull.
    """
    at = {whole: k for k, whole in enumerate(bench.interfaces.tolist())}
    pulls = bench.region.needs.pulls
    pulling = [(at[pull.interface], pull.force) for pull in pulls if pull.interface in at]
    changes = glue_changes(bench.local, len(bench.own), pulling, MANY)
    if not changes:
        bench.fail("glue", "none of its joints would pull")
        return
    free = {on: one for on, one in changes.items() if all(bench.may_change(k) for k in on)}
    if not free:
        joints = [k for on in changes for k in on]
        ends = (bench.local.contacts.block_a[joints], bench.local.contacts.block_b[joints])
        bench.fail("glue", f"its joints may not be changed (kept: {bench.kept(*ends)})")
        return
    known = {frozenset(one.at): one.value for one in bench.region.needs.glue}
    held = False
    for on, change in free.items():
        least = known.get(frozenset(bench.interfaces[list(on)].tolist()))
        asked = bench.from_known(change, least) if len(bench.own) <= ALL else [change]
        for new in asked:
            value = bench.least(new)
            if value is not None:
                held = True
                yield new, value
    if not held:
        what = f"it falls with glue of {STRONGEST:g} times its weight in any one of its joints"
        if len(bench.own) > MANY:
            (one,) = free.values()
            most = newtons(one.steps[-1])
            what = f"it falls with glue of {most} in the {one.joints} joints that pull"
        bench.fail("glue", what, *(one.make(one.steps[-1]) for one in free.values()))


def _merge(bench: Bench) -> Held:
    """Two blocks made one."""
    if len(bench.own) > MANY:
        bench.fail("merge", f"not tried on a region of more than {MANY} blocks")
        return
    contacts, fixed = bench.local.contacts, bench.local.assembly.fixed
    strengths = {frozenset(glue.at): glue.value for glue in bench.region.needs.glue}
    pairs = list(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))

    def make(ends: tuple[int, int], model: Model, blocks: Ints, _: Ints) -> Model:
        return merge_blocks(model, int(blocks[ends[0]]), int(blocks[ends[1]]))

    changes = []
    for a, b in dict.fromkeys(pairs):
        if {int(bench.blocks[a]), int(bench.blocks[b])} & bench.keep:
            continue
        ends = (a, b) if fixed[a] or not fixed[b] else (b, a)
        own = [k for k, pair in enumerate(pairs) if {*pair} == {a, b}]
        held = strengths.get(frozenset(bench.interfaces[own].tolist()), 0.0)
        enough = f" ({glue_words(bench.local, own, held)} is enough)" if held > 0.0 else ""
        words = f"{names_of(bench.local, [a, b])} made one block{enough}"
        changes.append(Change.single("merge", partial(make, ends), words, held, joints=len(own)))
    why = "it falls with any two of its blocks made one"
    if not changes:
        stay = bench.kept(contacts.block_a, contacts.block_b)
        why = f"its blocks may not be changed (kept: {stay})"
    yield from bench.holding("merge", changes, why)


MAKERS: Mapping[str, Callable[[Bench], Held]] = {
    "support": _support,
    "prop": _prop,
    "tie": _tie,
    "friction": _friction,
    "turn": partial(_joints, kind="turn"),
    "wedge": partial(_joints, kind="wedge"),
    "let-in": partial(_joints, kind="let-in"),
    "thicker": _thicker,
    "ballast": _ballast,
    "glue": _glue,
    "merge": _merge,
}
"""What finds the changes of each kind that hold a region."""

KINDS = tuple(MAKERS)
"""The kinds of mends."""
