"""Kinds of scaffolding, their limits, and the items of one kind that hold one block."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
import shapely
import shapely.ops

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.base.settings import Options
from drystone.free_faces import free_parts
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.polygon import area_vector
from drystone.model import Model
from drystone.sequence.scaffold_items import Centring, Clamp, Rope, ScaffoldItem, Strut

INSET = 0.6
"""Distance of heads and knots from the middle of their face, by that of its corners; chosen, well
inside the face."""
SLOPING = 0.3
"""Least cosine between a face that carries a block and the direction of its load; chosen, about 70
degrees."""


LEAST_FREE = 0.05
"""Least share of a face that must be free of joints for an item; chosen."""


class Support(enum.Enum):
    """With what the blocks of a plan are held."""

    STRUT = "strut"
    """Struts along the load under the lower face, one near each of its corners."""
    ROPE = "rope"
    """Ropes along the load from the upper face up to one height."""
    CLAMP = "clamp"
    """One clamp, or hand, at the centroid."""
    CENTRING = "centring"
    """Centring under the lower face."""

    def words(self, count: int) -> str:
        """The kind, in plural where there are several."""
        return self.value if count == 1 or self is Support.CENTRING else f"{self.value}s"

    @classmethod
    def named(cls, support: Support | str) -> Support:
        """The kind of a name.

        Raises
        ------
        InputError
            It is not known.
        """
        try:
            return cls(support)
        except ValueError as error:
            known = ", ".join(one.value for one in cls)
            raise InputError(f"support '{support}' is not known", remedy=f"use {known}") from error


@dataclass(frozen=True)
class ScaffoldOptions(Options):
    """What scaffolding may bear, and what it costs.

    Attributes
    ----------
    limit : [N] > 0
        Largest force of one strut, rope, clamp, or the centring under one block (none).
    moment : [N m]
        Of one clamp.
    friction
        Between centring and blocks.
    clear : [m]
        Height of the anchors of ropes above the highest block.
    foot
        Name of the block on which struts stand, and which bears their force; the ground when left
        out. Where a strut leans, ``friction`` must hold its foot.
    longest : [m] > 0
        Length of the longest strut (no limit).
    stage_cost
        Of a metre for one stage. A clamp counts as one metre.
    move_cost
        Of setting up what holds one block, once.
    """

    limit: float = float("inf")
    moment: float = float("inf")
    friction: float = 0.6
    clear: float = 1.0
    foot: str | None = None
    longest: float = float("inf")
    stage_cost: float = 1.0
    move_cost: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._refuse_unless_positive("limit", "moment", "longest")
        self._refuse_below(0.0, "friction", "clear", "stage_cost", "move_cost")


def items_of(
    model: Model, block: int, *, support: Support, options: ScaffoldOptions
) -> tuple[ScaffoldItem, ...]:
    """The items of one kind that hold one block.

    Parameters
    ----------
    model
        Complete: faces that are joints in it carry no item.
    block
    support
    options

    Raises
    ------
    InputError
        It has no free face that looks along, or against, the load.
    """
    name = model.assembly.names[block]
    if support is Support.CLAMP:
        return (Clamp(name, options.limit, options.moment),)
    total = model.load.wrench[model.assembly.free, :3].sum(axis=0)
    down = total / np.linalg.norm(total)
    facing = -1.0 if support is Support.ROPE else 1.0
    face = _free_face(model, block, facing * down)
    if face is None:
        raise InputError(
            f"no free face of it takes a {support.value}",
            where=f"block '{name}'",
            remedy="use a clamp",
        )
    heights = [float((one.vertices @ down).max()) for one in model.assembly.blocks]
    ground, top = max(heights), min(float((b.vertices @ down).min()) for b in model.assembly.blocks)
    points = _inset(face)
    if support is Support.CENTRING:
        height = ground - float(face.mean(axis=0) @ down)
        return (Centring(name, options.limit, face, options.friction, height),)
    if support is Support.ROPE:
        return tuple(
            Rope(name, options.limit, at, at - (at @ down - top + options.clear) * down)
            for at in points
        )
    feet = [(head, _foot_of(model, block, head, down, ground, options)) for head in points]
    struts = tuple(
        Strut(name, options.limit, head, foot.tolist(), options.foot) for head, foot in feet
    )
    longest = max(strut.length for strut in struts)
    if longest > options.longest:
        raise InputError(
            f"its strut is {longest:.3g} m long, more than {options.longest:g} m",
            where=f"block '{name}'",
            remedy="allow longer struts, let them stand on a nearer block, or use a clamp",
        )
    return struts


def _foot_of(
    model: Model, block: int, head: Floats, down: Floats, ground: float, options: ScaffoldOptions
) -> Floats:
    """The foot (3,) [m] of a strut, on the ground or on the block that the options name."""
    if options.foot is None:
        reach = 1e-3 * float(model.assembly.size[block])
        return np.asarray(head + max(ground - float(head @ down), reach) * down)
    names, under = model.assembly.names, model.assembly.index(options.foot)
    where = f"block '{names[block]}'"
    face = _free_face(model, under, -down)
    if under == block or face is None:
        why = "it does not stand on itself" if under == block else "it has no free upper face"
        raise InputError(
            f"'{names[under]}' carries no strut: {why}", where=where, remedy="name another block"
        )
    flat = _inset(face)
    normal = area_vector(flat)
    normal /= np.linalg.norm(normal)
    across = frames_from_normals(normal[None])[0, 1:]
    below = head - ((head - flat[0]) @ normal) / (down @ normal) * down
    place = shapely.Point((below - flat[0]) @ across.T)
    shape = shapely.Polygon((flat - flat[0]) @ across.T)
    near = shapely.get_coordinates(shapely.ops.nearest_points(shape, place)[0])[0]
    foot: Floats = flat[0] + near @ across
    along = float((head - foot) @ normal)
    aside = float(np.linalg.norm(head - foot - along * normal))
    if not along > 0.0 or aside > options.friction * along:
        raise InputError(
            f"a strut from '{names[under]}' would slide: it leans by {aside:.3g} m on "
            f"{max(along, 0.0):.3g} m",
            where=where,
            remedy="name a block that lies lower, or nearer to the place below it",
        )
    return foot


def _inset(face: Floats) -> Floats:
    """The corners of a face, moved towards its middle."""
    middle = face.mean(axis=0)
    return np.asarray(middle + INSET * (face - middle))


def _free_face(model: Model, block: int, direction: Floats) -> Floats | None:
    """The part (c, 3) of a face without joints that looks most along a direction, by its area."""
    faces = [
        (part.area * float(part.normal @ direction), part)
        for part in free_parts(model, block, away=0.0)
        if part.normal @ direction > SLOPING and part.share > LEAST_FREE
    ]
    return max(faces, key=lambda one: one[0])[1].outline if faces else None
