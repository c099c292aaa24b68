"""Mends that add something to a region: a support, props, a tie, ballast."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from drystone.base.arrays import Ints
from drystone.base.errors import counted
from drystone.contacts import Contacts, joined_contacts
from drystone.design.bench import MANY, Bench, MendCandidate
from drystone.design.joint_changes import Change, with_block
from drystone.design.missing import HEAVIEST, SEARCHED, ballasted
from drystone.design.props import HEAD, PropSeat, find_props, with_props
from drystone.design.struts import struts
from drystone.design.words import names_of, newtons, place
from drystone.geometry.frames import frames_from_normals
from drystone.model import Model

_STRUTS = 6
"""Number of struts of one block that are tried, the shortest first."""

_TIES = 6
"""Number of pairs of blocks between which a tie is tried, those that move apart fastest first."""

POINT = 0.01
"""Size of the corners of a tie by its own, chosen."""


def support_mends(bench: Bench) -> Iterator[MendCandidate]:
    """A block below that fits between a block of the region and another one."""
    if len(bench.own) > MANY:
        bench.fail("support", f"not tried on a region of more than {MANY} blocks")
        return
    number = 0
    for i in bench.own:
        whole = bench.region.blocks[i]
        for strut in struts(bench.model, whole, bench.motion[whole])[:_STRUTS]:
            number += 1

            make = partial(with_block, strut.body)
            if strut.on in bench.blocks:
                stands = bench.stands(make)
            else:  # it stands on a block that the region does not touch
                wide = bench.model.subset([*bench.blocks.tolist(), strut.on])
                wide = wide.with_supports(list(range(len(bench.own), len(wide))))
                stands = bench.keeps_margin(with_block(strut.body, wide), quick=True)
            if stands:
                on = names_of(bench.model, [strut.on])
                size = strut.body.volume
                yield MendCandidate.single(
                    "support",
                    f"a block of {size:.3g} m3, {strut.length:.3g} m long, between {on} and "
                    f"{names_of(bench.model, [whole])}",
                    strut.length,
                    make,
                    joints=0,
                    added=1,
                )
                return
    bench.fail("support", f"{number} blocks that fit were tried, the shortest first")


def prop_mends(bench: Bench) -> Iterator[MendCandidate]:
    """One prop, with the least force; else a few props that hold the region together."""
    if bench.as_diagnosed:
        found = bench.region.needs.props
        at = {whole: i for i, whole in enumerate(bench.region.blocks)}
        chosen = [replace(one.seat, block=at[one.block]) for one in found.props]
    else:
        motion = bench.motion[bench.blocks]
        found = find_props(bench.local, bench.own, motion, bench.stop, single=bench.own[:MANY])
        chosen = [one.seat for one in found.props]
    if not chosen:
        bench.fail("prop", f"no prop holds it: tried were {found.tried}")
        return
    make = partial(_propped, chosen)
    if not bench.stands(make):
        bench.fail("prop", "the best props do not keep the margin")
        return
    sizes, points = bench.largest_forces(make, len(chosen))
    force = float(sizes.sum())
    told = [
        f"{newtons(size)} against {names_of(bench.local, [seat.block])} at {place(point)}"
        for seat, size, point in zip(chosen, sizes.tolist(), points, strict=True)
    ]
    kind = "a prop of " if len(chosen) == 1 else f"{len(chosen)} props: "
    yield MendCandidate.single("prop", kind + ", ".join(told), force, make, added=len(chosen))


def _propped(chosen: Sequence[PropSeat], model: Model, blocks: Ints, _: Ints) -> Model:
    return with_props(model, [replace(one, block=int(blocks[one.block])) for one in chosen])


def tie_mends(bench: Bench) -> Iterator[MendCandidate]:
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
    tried: list[Change] = []
    for _, i, j in fastest:

        def make(model: Model, blocks: Ints, _: Ints, one: int = i, other: int = j) -> Model:
            return tied(model, int(blocks[one]), int(blocks[other]))

        tried.append(make)
        if bench.stands(make):
            size = float(bench.largest_forces(make, 1)[0][0])
            yield MendCandidate.single(
                "tie",
                f"a tie that pulls {newtons(size)} between {names_of(bench.local, [i, j])}",
                size,
                make,
                added=1,
            )
            return
    what = "no blocks move apart"
    if tried:
        what = f"a tie between blocks that move apart, of {counted(len(tried), 'pair')}"
    bench.fail("tie", what, *tried)


def tied(model: Model, block: int, other: int) -> Model:
    """The model with a tie from the centroid of a block to that of another one.

    It is a joint without friction that presses the block towards the other one. It has the area of
    the head of a prop, drawn together to a point at the centroid, so that it resists no turn.
    """
    centroid = model.assembly.centroid
    along = centroid[other] - centroid[block]
    frame = frames_from_normals((along / np.linalg.norm(along))[None])
    half = 0.5 * HEAD * float(model.assembly.size[block])
    square = POINT * half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    plate = Contacts(
        np.array([other]),
        np.array([block]),
        frame,
        np.array([4.0 * half**2]),
        np.zeros(1),
        centroid[block] + square @ frame[0, 1:],
        np.zeros(4, dtype=np.intp),
    )
    return model.with_contacts(joined_contacts(model.contacts, plate))


def ballast_mends(bench: Bench) -> Iterator[MendCandidate]:
    """The least weight on one block."""
    ballast = bench.region.needs.ballast
    if ballast is None:
        what = f"no weight up to {HEAVIEST:g} times its own on one block holds it"
        if len(bench.own) > SEARCHED:
            what = f"not tried on a region of more than {SEARCHED} blocks"
        bench.fail("ballast", what)
        return
    at = bench.region.blocks.index(ballast.block)

    def make(model: Model, blocks: Ints, _: Ints) -> Model:
        return ballasted(model, int(blocks[at]), ballast.force)

    if bench.stands(make):
        name = names_of(bench.model, [ballast.block])
        yield MendCandidate.single(
            "ballast", f"a weight of {newtons(ballast.force)} on {name}", ballast.force, make,
            added=1,
        )  # fmt: skip
    else:
        bench.fail("ballast", "the least weight does not keep the margin")
