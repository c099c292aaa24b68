"""Mends that change joints and blocks of a region: friction, planes, wedges, thickness, glue."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.errors import InputError
from drystone.design.bench import ALL, MANY, Bench, MendCandidate
from drystone.design.block_surgery import merge_blocks, thicken_blocks
from drystone.design.glue_needed import STRONGEST, GlueTrial, glue_trials, glued
from drystone.design.joint_changes import Change, change_of, joint_width, words_of
from drystone.design.missing import FRICTION, ROUGHEST, TURNED, TURNS
from drystone.design.words import friction_words, glue_words, names_of, newtons
from drystone.model import Model

_SHARPNESSES = (5.0, 10.0, 25.0, 45.0)
"""[degrees] Wedges that are tried before the least one is searched. A very small wedge locks rigid
blocks, but not real ones, so none below the first value is tried."""

_DEPTHS = (0.1, 0.25, 0.5, 1.0)
"""The same for blocks that are let into each other, relative to the width of the joint; none below
the first value, for the same reason."""

_THICKER = (0.1, 0.3, 1.0)
"""The same for the increase of thickness, relative to that of the block."""

_GLUE_SHARES = (0.01, 0.1, 0.3, 1.0)
"""Strengths of glue that are tried before the least one is searched, by the largest one."""


def friction_mends(bench: Bench) -> Iterator[MendCandidate]:
    """The least friction of one joint, else of all that may be changed."""
    contacts = bench.local.contacts
    own = contacts.friction
    if contacts.count == 0:
        bench.fail("friction", "it touches no other block")
        return
    free = [k for k in range(contacts.count) if bench.may_change(k)]
    if not free:
        stay = bench.kept(contacts.block_a, contacts.block_b)
        bench.fail("friction", f"its joints may not be changed (kept: {stay})")
        return
    groups = [[k] for k in free] if len(bench.own) <= MANY else []
    known = bench.region.needs.friction if bench.as_diagnosed else None
    hopeless = bench.as_diagnosed and known is None
    found = False
    for group in [*groups, *([free] if groups != [free] else [])]:
        if hopeless or (found and len(group) > 1):
            break
        low = FRICTION * float(np.floor(own[group].min() / FRICTION))
        steps = [x for x in (1.0, 2.0, ROUGHEST) if x > low]
        if known is not None:  # no joint alone, and no margin, takes less than all joints take
            low, steps = max(low, known - FRICTION), [known, *(x for x in steps if x > known)]
        value = bench.least(partial(_rougher, group), steps, FRICTION, low)
        if value is not None:
            found = True
            where = "in all its joints" if len(group) > 1 else f"in {bench.joint_name(group[0])}"
            yield MendCandidate(
                "friction",
                partial(friction_words, where),
                value,
                partial(_rougher, group),
                joints=len(group),
                most=ROUGHEST,
                close=FRICTION,
            )
    if not found:
        which = "all its joints" if len(free) == contacts.count else "the joints that may change"
        what = f"it falls up to a coefficient of {ROUGHEST:g} in {which}"
        bench.fail("friction", what, _rougher(free, ROUGHEST))


def _rougher(group: list[int], value: float) -> Change:
    """The least friction coefficient of some interfaces of a region."""

    def make(model: Model, _: Ints, interfaces: Ints) -> Model:
        friction = np.array(model.contacts.friction)
        at = interfaces[group]
        friction[at] = np.maximum(friction[at], value)
        return model.with_friction(friction)

    return make


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
            "wedge": (_SHARPNESSES, 0.25),
            "let-in": (tuple(share * width for share in _DEPTHS), 0.01 * width),
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

    value = bench.least(make, _THICKER, 0.02)
    if value is None:
        bench.fail(
            "thicker", f"up to {100.0 * _THICKER[-1]:g} % more thickness", make(_THICKER[-1])
        )
        return
    them = names_of(bench.model, bench.region.blocks)
    yield MendCandidate(
        "thicker", lambda x: f"{them} thicker by {100.0 * x:.0f} %", value, make,
        most=_THICKER[-1], close=0.02,
    )  # fmt: skip


def merge_mends(bench: Bench) -> Iterator[MendCandidate]:
    """Two blocks made one."""
    if len(bench.own) > MANY:
        bench.fail("merge", f"not tried on a region of more than {MANY} blocks")
        return
    contacts = bench.local.contacts
    strengths = {frozenset(glue.interfaces): glue.strength for glue in bench.region.needs.glue}
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
            held = strengths.get(frozenset(bench.interfaces[own].tolist()), 0.0)
            glued = f" ({glue_words(bench.local, own, held)} is enough)" if held > 0.0 else ""
            yield MendCandidate.single(
                "merge", f"{names_of(bench.local, [a, b])} made one block{glued}", held, make,
                joints=len(own),
            )  # fmt: skip
    if not tried:
        stay = bench.kept(contacts.block_a, contacts.block_b)
        bench.fail("merge", f"its blocks may not be changed (kept: {stay})")
    elif not found:
        bench.fail("merge", "it falls with any two of its blocks made one", *tried)


def glue_mends(bench: Bench) -> Iterator[MendCandidate]:
    """Glue in one joint: the least strength with which the region stands.

    In a larger region, the same glue in all joints that would pull.
    """
    at = {whole: k for k, whole in enumerate(bench.interfaces.tolist())}
    pulls = bench.region.needs.pulls
    pulling = [(at[pull.interface], pull.force) for pull in pulls if pull.interface in at]
    trials = glue_trials(bench.local, len(bench.own), pulling)
    if not trials:
        bench.fail("glue", "none of its joints would pull")
        return
    free = [trial for trial in trials if all(bench.may_change(k) for k in trial.interfaces)]
    if not free:
        joints = [k for trial in trials for k in trial.interfaces]
        ends = (bench.local.contacts.block_a[joints], bench.local.contacts.block_b[joints])
        bench.fail("glue", f"its joints may not be changed (kept: {bench.kept(*ends)})")
        return
    found = False
    for trial in free:
        value = _least_glue(bench, trial)
        if value is not None:
            found = True
            yield MendCandidate(
                "glue",
                partial(glue_words, bench.local, trial.interfaces),
                value,
                partial(_with_glue, trial.interfaces),
                joints=len(trial.interfaces),
                added=len(trial.interfaces),
                most=trial.most,
                close=trial.close,
            )
    if found:
        return
    what = f"it falls with glue of {STRONGEST:g} times its weight in any one of its joints"
    if len(bench.own) > MANY:
        count = len(free[0].interfaces)
        what = f"it falls with glue of {newtons(free[0].most)} in the {count} joints that pull"
    bench.fail("glue", what, *(_with_glue(trial.interfaces, trial.most) for trial in free))


def _least_glue(bench: Bench, trial: GlueTrial) -> float | None:
    """The least strength with which the region stands at the margin."""
    low, steps = 0.0, tuple(share * trial.most for share in _GLUE_SHARES)
    if bench.as_diagnosed and len(bench.own) <= ALL:
        # the least one without a margin is known
        joints = set(bench.interfaces[list(trial.interfaces)].tolist())
        known = [g.strength for g in bench.region.needs.glue if set(g.interfaces) == joints]
        if not known:
            return None
        low = known[0] - trial.close
        steps = (known[0], *(x for x in steps if x > known[0]))
    return bench.least(partial(_with_glue, trial.interfaces), steps, trial.close, low)


def _with_glue(joints: tuple[int, ...], strength: float) -> Change:
    """Glue in some interfaces of a local model."""

    def make(model: Model, _: Ints, interfaces: Ints) -> Model:
        return glued(model, interfaces[np.array(joints)], strength)

    return make
