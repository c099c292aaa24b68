"""Kinds of scaffolding, their limits, and the items of one kind that hold one block."""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats, Ints, unit
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.model import Model
from drystone.sequence.scaffold_items import Centring, Clamp, Rope, ScaffoldItem, Strut
from drystone.sequence.scaffold_seats import Seat, first_met, seat_on

SLOPING = 0.3
"""Least cosine between a face that carries a block and the direction of its load; chosen, about 70
degrees."""


class Support(enum.Enum):
    """With what the blocks of a plan are held."""

    STRUT = "strut"
    """Struts under the lower face, one near each of its corners."""
    ROPE = "rope"
    """Ropes from the upper face up to one height, two from each of its corners, splayed."""
    CLAMP = "clamp"
    """One clamp, or hand, at the centroid."""
    CENTRING = "centring"
    """Centring under the lower face, with a stop below it where the block would slide off."""

    def words(self, count: int) -> str:
        """The kind, in plural where there are several."""
        return self.value if count == 1 or self is Support.CENTRING else f"{self.value}s"


@dataclass(frozen=True)
class ScaffoldOptions(Options):
    """What scaffolding may bear.

    Attributes
    ----------
    limit : [N] > 0
        Largest force of one strut, rope, clamp, or the centring under one block (none).
    moment : [N m] > 0
        Of one clamp.
    friction : coefficient >= 0
        Of centring, and of heads and feet of struts. Struts and ropes lean towards the normal of
        their face, as far as it holds.
    clear : [m] >= 0
        Height of the anchors of ropes above the highest block.
    foot
        Name of the block on which struts stand, and which bears their force. When left out: the
        first that a strut meets on its way down, else the ground.
    longest : [m] > 0
        Length of the longest strut (no limit).
    """

    limit: float = float("inf")
    moment: float = float("inf")
    friction: float = 0.6
    clear: float = 1.0
    foot: str | None = None
    longest: float = float("inf")


def items_of(
    model: Model,
    block: int,
    *,
    support: Support,
    options: ScaffoldOptions,
    surface: tuple[Floats, Ints],
) -> tuple[ScaffoldItem, ...]:
    """The items of one kind that hold one block.

    Struts and ropes lean towards the normal of their seat, as far as friction holds their feet.

    Parameters
    ----------
    model
        Complete: faces that are joints in it carry no item.
    block
    support
    options
    surface
        That of all blocks, by :func:`drystone.sequence.scaffold_seats.surface_triangles`.

    Raises
    ------
    InputError
        It has no free face that looks along, or against, the load; or a strut has nothing to stand
        on, or is too long.
    """
    name = model.assembly.names[block]
    if support is Support.CLAMP:
        return (Clamp(name, options.limit, options.moment),)
    total = model.load.wrench[model.assembly.free, :3].sum(axis=0)
    down = total / np.linalg.norm(total)
    least = SLOPING
    if support is Support.STRUT and options.foot is None:  # no steeper than its two ends hold
        least = min(max(least, math.cos(2.0 * math.atan(options.friction))), 1.0 - 1e-9)
    seat = seat_on(model, block, -down if support is Support.ROPE else down, least)
    if seat is None:
        raise InputError(
            f"no free face of it takes a {support.value}",
            where=f"block '{name}'",
            remedy="use a clamp",
        )
    depth = surface[0] @ down
    shortest = 1e-3 * float(model.assembly.size[block])
    if support is Support.CENTRING:
        ground = float(depth.max())
        return tuple(
            Centring(name, options.limit, face, options.friction, ground - face.mean(axis=0) @ down)
            for face in _carried(model, block, seat, options.friction)
        )
    if support is Support.ROPE:
        rise = np.maximum(seat.heads @ down - float(depth.min()) + options.clear, shortest)
        return tuple(
            Rope(name, options.limit, at, at + height * lead)
            for leads in _splayed(seat)
            for at, height, lead in zip(seat.heads, rise, leads, strict=True)
        )
    if options.foot is None:
        deep = np.maximum(float(depth.max()) - seat.heads @ down, shortest)
        lead = _lead(seat)
        ends = zip(seat.heads, seat.heads + np.outer(deep, lead), strict=True)
        struts = tuple(
            _standing(model, block, *between, options=options, surface=surface) for between in ends
        )
    else:
        under = model.assembly.index(options.foot)
        struts = tuple(
            Strut(name, options.limit, head.tolist(), foot.tolist(), options.foot, options.friction)
            for head, foot in _on_block(model, block, under, seat.heads, down, options.friction)
        )
    longest = max(strut.length for strut in struts)
    if longest > options.longest:
        raise InputError(
            f"its strut is {longest:.3g} m long, more than {options.longest:g} m",
            where=f"block '{name}'",
            remedy="allow longer struts, let them stand on a nearer block, or use a clamp",
        )
    return struts


def _carried(model: Model, block: int, seat: Seat, friction: float) -> Iterator[Floats]:
    """Outlines (c, 3) of the faces that centring carries.

    The seat; where it is steeper than friction holds, also the free face towards which it slides.
    """
    yield seat.outline
    cosine = float(seat.normal @ seat.along)
    if cosine < math.cos(math.atan(friction)):
        slope = unit(cosine * seat.normal - seat.along)[0]  # up the slope
        stop = seat_on(model, block, -slope, SLOPING)
        if stop is not None:
            yield stop.outline


def _lead(seat: Seat) -> Floats:
    """Where the struts or ropes of a seat lead (3,), one unit along the load.

    Half way between its normal and the load: so a slope of twice the angle of friction is held at
    both ends.
    """
    half = unit(seat.normal + seat.along)[0]
    return half / (half @ seat.along)


def _splayed(seat: Seat) -> Iterator[Floats]:
    """Where two ropes of each head lead (c, 3), one unit along the load, away from its middle.

    They lean by 65 degrees from the lead of the seat and no lower than :data:`SLOPING`. Ropes that
    lean less, or that are parallel, let blocks of vaults swing out sideways: of 71 stages of a
    shell of three vaults six did not stand with parallel ropes, two with a lean of 55 degrees.
    """
    axis = unit(_lead(seat))[0]
    away = seat.heads - seat.heads.mean(axis=0)
    away = unit(away - np.outer(away @ axis, axis))[0]
    across = np.cross(axis, away)
    for side in (1.0, -1.0):
        leads = axis + 1.5 * (away + side * across)
        leads += np.outer(np.maximum(SLOPING - leads @ seat.along, 0.0), seat.along)
        yield leads / (leads @ seat.along)[:, None]


def _standing(
    model: Model,
    block: int,
    head: Floats,
    foot: Floats,
    *,
    options: ScaffoldOptions,
    surface: tuple[Floats, Ints],
) -> Strut:
    """A strut towards the ground, which stands on the first block that it meets."""
    names = model.assembly.names
    met = first_met(surface, block, head, foot)
    if met is not None:
        axis = (head - foot) / np.linalg.norm(head - foot)
        if met.normal @ axis < math.cos(math.atan(options.friction)):
            raise InputError(
                f"a strut from '{names[met.block]}' would slide: its face there is too steep",
                where=f"block '{names[block]}'",
                remedy="use a clamp, or let the struts stand on another block",
            )
        foot = met.point
    on = None if met is None else names[met.block]
    return Strut(names[block], options.limit, head.tolist(), foot.tolist(), on, options.friction)


def _on_block(
    model: Model, block: int, under: int, heads: Floats, down: Floats, friction: float
) -> Iterator[tuple[Floats, Floats]]:
    """Heads and feet of struts that stand on one block."""
    names = model.assembly.names
    where = f"block '{names[block]}'"
    seat = seat_on(model, under, -down, SLOPING)
    if under == block or seat is None:
        why = "it does not stand on itself" if under == block else "it has no free upper face"
        raise InputError(
            f"'{names[under]}' carries no strut: {why}", where=where, remedy="name another block"
        )
    for head in heads:
        foot = seat.nearest(head)
        along = float((head - foot) @ seat.normal)
        aside = float(np.linalg.norm(head - foot - along * seat.normal))
        if not along > 0.0 or aside > friction * along:
            raise InputError(
                f"a strut from '{names[under]}' would slide: it leans by {aside:.3g} m on "
                f"{max(along, 0.0):.3g} m",
                where=where,
                remedy="name a block that lies lower, or nearer to the place below it",
            )
        yield head, foot
