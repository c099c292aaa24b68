"""Mends that change joints and blocks of a region: friction, planes, wedges, glue, thickness."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.errors import InputError
from drystone.design.causes.diagnosis_words import names_of, newtons
from drystone.design.causes.missing import CLOSE, ROUGHEST, TURNED, TURNS
from drystone.design.mends.bench import ALL, MANY, Bench, MendCandidate
from drystone.design.surgery.block_surgery import merge_blocks, thicken_blocks
from drystone.design.surgery.joint_changes import Change, change_of, joint_width, words_of
from drystone.joint_capacity import JointCapacity
from drystone.model import Model

SHARPNESSES = (5.0, 10.0, 25.0, 45.0)
"""[degrees] Wedges that are tried before the least one is searched. A very small wedge locks rigid
blocks, but not real ones, so none below the first value is tried."""

DEPTHS = (0.1, 0.25, 0.5, 1.0)
"""The same for blocks that are let into each other, relative to the width of the joint; none below
the first value, for the same reason."""

THICKER = (0.1, 0.3, 1.0)
"""The same for the increase of thickness, relative to that of the block."""

STRENGTHS = (0.1, 1.0, 10.0)
"""The same for the strength of glue, relative to the weight of the region."""

SHARED = (1.0, 3.0, 10.0)
"""The same for glue in all joints that pull, relative to the largest pull."""


def friction_mends(bench: Bench) -> Iterator[MendCandidate]:
    """The least friction of one joint, else of all."""
    own = bench.local.contacts.friction
    count = len(own)
    if count == 0:
        bench.fail("friction", "it touches no other block")
        return
    groups = [[k] for k in range(count)] if len(bench.own) <= MANY else []
    found = False
    for group in [*groups, *([list(range(count))] if groups != [[0]] else [])]:
        if found and len(group) > 1:
            return

        def make(value: float, group: list[int] = group) -> Change:
            def rough(model: Model, _: Ints, interfaces: Ints) -> Model:
                friction = np.array(model.contacts.friction)
                at = interfaces[group]
                friction[at] = np.maximum(friction[at], value)
                return model.with_friction(friction)

            return rough

        low = float(own[group].min())
        steps = [x for x in (1.0, 2.0, ROUGHEST) if x > low]
        known = bench.region.needs.friction if len(group) == count else None
        if known is not None:  # the least one without a margin, to a hundredth
            low, steps = (1.0 - CLOSE) * known, [known, *(x for x in steps if x > known)]
        value = bench.least(make, steps, 0.01, low)
        if value is not None:
            found = True
            where = "in all its joints" if len(group) > 1 else f"in {bench.joint_name(group[0])}"
            yield MendCandidate(
                "friction",
                partial(_friction_words, where),
                value,
                make,
                joints=len(group),
                most=ROUGHEST,
                close=0.01,
            )
    if not found:
        bench.fail("friction", f"it falls up to a coefficient of {ROUGHEST:g} in all its joints",
                   make(ROUGHEST))  # fmt: skip


def joints_mends(bench: Bench, kind: str) -> Iterator[MendCandidate]:
    """Joints rotated, made wedges or let in: each one in a small region, else all together."""
    if len(bench.own) > ALL:
        bench.fail(kind, f"not tried on a region of more than {ALL} blocks")
        return
    count = len(bench.interfaces)
    groups = [[k] for k in range(count)] if len(bench.own) <= MANY else [list(range(count))]
    for group in groups:
        name = bench.joint_name(group[0]) if len(group) == 1 else "all its joints"
        if not all(bench.may_change(k) for k in group):
            contacts = bench.local.contacts
            stay = bench.kept(contacts.block_a[group], contacts.block_b[group])
            bench.fail(kind, f"{name.rstrip(',')} may not be changed (kept: {stay})")
            continue
        try:
            width = min(joint_width(bench.local, k) for k in group)
        except InputError as error:
            bench.fail(kind, str(error))
            continue
        steps, close = {
            "turn": (TURNS, TURNED),
            "wedge": (SHARPNESSES, 0.25),
            "let-in": (tuple(share * width for share in DEPTHS), 0.01 * width),
        }[kind]
        low = steps[0] if kind != "turn" else 0.0
        hopeless = False
        if kind == "turn" and len(bench.own) <= MANY and bench.as_diagnosed:
            # the least one without a margin is known
            known = bench.region.needs.turn
            hopeless = known is None
            if known is not None:
                low = known.angle - close
                steps = (known.angle, *(x for x in TURNS if x > known.angle))
        best: tuple[float, Callable[[float], Change]] | None = None
        for side in () if hopeless else (1.0, -1.0):
            make = partial(change_of, kind, group, side)
            within = [x for x in steps if best is None or x < best[0]]
            if best is not None:
                within.append(best[0] - close)
            value = bench.least(make, within, close, low)
            if value is not None:
                best = value, make
        most = f"{steps[-1]:g} degrees" if kind != "let-in" else f"{1e3 * steps[-1]:.0f} mm"
        if best is None:
            farthest = [change_of(kind, group, side, steps[-1]) for side in (1.0, -1.0)]
            bench.fail(kind, f"{name.rstrip(',')} up to {most}", *farthest)
            continue
        yield MendCandidate(
            kind, words_of(kind, name), best[0], best[1], joints=len(group),
            most=steps[-1], close=close,
        )  # fmt: skip


def thicker_mends(bench: Bench) -> Iterator[MendCandidate]:
    """Thicker blocks of the region."""
    if len(bench.own) > ALL:
        bench.fail("thicker", f"not tried on a region of more than {ALL} blocks")
        return
    if any(i in bench.keep for i in bench.region.blocks):
        stay = bench.kept(np.array(bench.own))
        bench.fail("thicker", f"its blocks may not be changed (kept: {stay})")
        return

    def make(share: float) -> Change:
        def thick(model: Model, blocks: Ints, _: Ints) -> Model:
            return thicken_blocks(model, blocks[bench.own].tolist(), share)

        return thick

    value = bench.least(make, THICKER, 0.02)
    if value is None:
        bench.fail("thicker", f"up to {100.0 * THICKER[-1]:g} % more thickness", make(THICKER[-1]))
        return
    them = names_of(bench.model, bench.region.blocks)
    yield MendCandidate(
        "thicker", lambda x: f"{them} thicker by {100.0 * x:.0f} %", value, make,
        most=THICKER[-1], close=0.02,
    )  # fmt: skip


def glue_mends(bench: Bench) -> Iterator[MendCandidate]:
    """Glue in one joint: the least strength with which the region stands.

    In a larger region, the same glue in all joints that would pull.
    """
    if len(bench.own) > MANY:
        yield from _glue_in_all(bench)
        return
    contacts = bench.local.contacts
    load = bench.local.load.wrench[bench.own, :3]
    weight = float(np.linalg.norm(load.sum(axis=0)))
    pairs = dict.fromkeys(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))
    found, tried = False, []
    for a, b in pairs:
        if {int(bench.blocks[a]), int(bench.blocks[b])} & bench.keep:
            continue
        own = np.flatnonzero((contacts.block_a == a) & (contacts.block_b == b))
        make = partial(_glued, own)
        steps = [share * weight for share in STRENGTHS]
        tried.append(make(steps[-1]))
        value = bench.least(make, steps, 0.01 * weight)
        if value is not None:
            found = True
            where = f"between {names_of(bench.local, [a, b])}"
            yield MendCandidate(
                "glue", partial(_glue_words, where), value, make, joints=len(own),
                most=steps[-1], close=0.01 * weight,
            )  # fmt: skip
    if not tried:
        stay = bench.kept(contacts.block_a, contacts.block_b)
        bench.fail("glue", f"its joints may not be changed (kept: {stay})")
    elif not found:
        bench.fail(
            "glue",
            f"it falls with glue of {STRENGTHS[-1]:g} times its weight in any one of its joints",
            *tried,
        )


def _glue_in_all(bench: Bench) -> Iterator[MendCandidate]:
    """Glue in all joints of a region that would pull, with one strength for all of them."""
    at = {whole: k for k, whole in enumerate(bench.interfaces.tolist())}
    pulls = [pull for pull in bench.region.needs.pulls if pull.interface in at]
    joints = [at[pull.interface] for pull in pulls]
    ends = (bench.local.contacts.block_a[joints], bench.local.contacts.block_b[joints])
    if not pulls:
        bench.fail("glue", "none of its joints would pull")
        return
    if bench.kept(*ends):
        bench.fail("glue", f"its joints may not be changed (kept: {bench.kept(*ends)})")
        return
    most = max(pull.force for pull in pulls)
    width = 0.1 if len(bench.own) > ALL else 0.02
    make, close = partial(_glued, np.array(joints)), width * most
    steps = [share * most for share in SHARED]
    value = bench.least(make, steps, close)
    if value is None:
        what = f"it falls with glue of {newtons(steps[-1])} in the {len(joints)} joints that pull"
        bench.fail("glue", what, make(steps[-1]))
        return
    where = f"in {len(joints)} joints, each of which"
    yield MendCandidate(
        "glue", partial(_glue_words, where), value, make, joints=len(joints),
        most=steps[-1], close=close,
    )  # fmt: skip


def _glued(own: Ints, strength: float) -> Change:
    """Glue in some interfaces, with a strength [N] each against pull and against shear."""

    def make(model: Model, _: Ints, interfaces: Ints) -> Model:
        contacts = model.contacts
        before = contacts.capacity or JointCapacity.of(contacts)
        tension, cohesion = np.array(before.tension), np.array(before.cohesion)
        at = interfaces[own]
        tension[at] = np.maximum(tension[at], strength)
        cohesion[at] = np.maximum(cohesion[at], strength)
        return model.with_capacity(JointCapacity(tension, cohesion, before.shear))

    return make


def _glue_words(where: str, value: float) -> str:
    carries = "carries" if where.endswith("which") else "that carries"
    return f"glue {where} {carries} a pull, and a shear, of {newtons(value)}"


def merge_mends(bench: Bench) -> Iterator[MendCandidate]:
    """Two blocks made one."""
    if len(bench.own) > MANY:
        bench.fail("merge", f"not tried on a region of more than {MANY} blocks")
        return
    contacts = bench.local.contacts
    pulls = {pull.interface: pull.force for pull in bench.region.needs.pulls}
    pairs = dict.fromkeys(zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True))
    found, tried = False, []
    for a, b in pairs:
        if {int(bench.blocks[a]), int(bench.blocks[b])} & bench.keep:
            continue
        fixed = bench.local.assembly.fixed
        first, second = (a, b) if fixed[a] or not fixed[b] else (b, a)

        def make(model: Model, blocks: Ints, _: Ints, one: int = first, two: int = second) -> Model:
            return merge_blocks(model, int(blocks[one]), int(blocks[two]))

        tried.append(make)
        if bench.stands(make):
            found = True
            own = [k for k in range(contacts.count) if {int(contacts.block_a[k]),
                   int(contacts.block_b[k])} == {a, b}]  # fmt: skip
            pull = sum(pulls.get(int(bench.interfaces[k]), 0.0) for k in own)
            strength = f", of which the joint has to pull {newtons(pull)}" if pull > 0.0 else ""
            yield MendCandidate.single(
                "merge", f"{names_of(bench.local, [a, b])} made one block{strength}", pull, make,
                joints=len(own),
            )  # fmt: skip
    if not tried:
        stay = bench.kept(contacts.block_a, contacts.block_b)
        bench.fail("merge", f"its blocks may not be changed (kept: {stay})")
    elif not found:
        bench.fail("merge", "it falls with any two of its blocks made one", *tried)


def _friction_words(where: str, value: float) -> str:
    return f"friction of {value:.2f} {where}".rstrip(",")


__all__ = ["friction_mends", "glue_mends", "joints_mends", "merge_mends", "thicker_mends"]
