"""Cutting a monolithic shape into blocks that stand: propose a cut, check it, accept or reject it.

The cuts are made from the bottom up. All blocks below a cut are fixed. The part above is one block;
it must stand on the cut face by contact and friction. At each place the first proposed cut with
which it stands is taken.

Source: Kao et al. 2022 (design loop of stability-aware blocks).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drystone.assembly import Assembly, Block
from drystone.base.arrays import Floats, frozen_floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.geometry.body.split import Piece, split
from drystone.geometry.frames import rotation_about, unit
from drystone.model import Model
from drystone.results import Result
from drystone.sequence.stage.stage_checks import Check, check_both


@dataclass(frozen=True, eq=False)
class Cut(OneLine):
    """A plane, or a wedge of two planes, between a part below and a part above.

    Attributes
    ----------
    point : (3,) [m]
        On the plane; on the edge of the wedge.
    normal : (3,)
        Towards the part above.
    wedge_deg : [degrees]
        Angle of each plane of a wedge to the plane of ``normal``. Positive: the part above sits in
        a groove. Zero for a plane, negative for a ridge.
    edge : (3,)
        Direction of the wedge's edge.
    """

    point: Floats
    normal: Floats
    wedge_deg: float = 0.0
    edge: Floats | None = None

    def planes(self) -> tuple[Floats, Floats]:
        """Normals and points (p, 3) of the half spaces of the part above a plane or a groove."""
        point = frozen_floats(self.point, (3,), "point of a cut")
        normal = unit(self.normal, "normal of a cut")
        if self.wedge_deg == 0.0:
            return normal[None], point[None]
        if not abs(self.wedge_deg) < 60.0:
            raise InputError(f"a wedge of {self.wedge_deg} degrees", remedy="give -60 to 60")
        edge = np.zeros(3) if self.edge is None else np.asarray(self.edge, dtype=np.float64)
        edge = edge - (edge @ normal) * normal
        if np.linalg.norm(edge) < 1e-9:
            raise InputError("a wedge needs an edge across the normal", remedy="give its direction")
        sides = [rotation_about(edge, s * abs(self.wedge_deg)) @ normal for s in (1.0, -1.0)]
        return np.array(sides), np.stack([point, point])


@dataclass(frozen=True, eq=False)
class Trial(OneLine):
    """A cut that was tried at a place, and the result for the part above it."""

    place: int
    cut: Cut
    result: Result

    @property
    def accepted(self) -> bool:
        """Whether the part above stands on it."""
        return self.result.stable


@dataclass(frozen=True, eq=False)
class CutDesign(OneLine):
    """Blocks cut from one shape.

    Attributes
    ----------
    assembly
        From the bottom up; the lowest is fixed.
    trials
        In the order in which they were made; per place the last one was accepted.
    """

    assembly: Assembly
    trials: tuple[Trial, ...]

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """The accepted cuts."""
        return tuple(trial.cut for trial in self.trials if trial.accepted)


def cut_block(block: Block, cut: Cut) -> tuple[list[Block], list[Block]]:
    """The pieces above and below a cut, as blocks with names derived from the whole.

    Raises
    ------
    InputError
        The cut misses the block, or lies on a face of it.

    Examples
    --------
    >>> from drystone.models import box
    >>> above, below = cut_block(box((1.0, 1.0, 2.0)), Cut((0.5, 0.5, 0.5), (0.0, 0.0, 1.0)))
    >>> [float(piece.volume) for piece in (*above, *below)]
    [1.5, 0.5]
    """
    normals, points = cut.planes()
    if cut.wedge_deg < 0.0:  # a ridge is the groove of the part below, seen upside down
        below, above = split(block.vertices, block.faces, -normals, points)
    else:
        above, below = split(block.vertices, block.faces, normals, points)
    if not above or not below:
        raise InputError(f"the cut misses block '{block.name}'", remedy="move it into the block")
    return _blocks(above, block, "above"), _blocks(below, block, "below")


def design_cuts(
    block: Block,
    proposals: Sequence[Sequence[Cut]],
    *,
    friction: float = 0.6,
    check: Check = check_both,
    name: str = "c",
) -> CutDesign:
    """Cut a shape from the bottom up, at each place with the first cut that is accepted.

    Parameters
    ----------
    block
        The shape; its lowest part becomes the support.
    proposals
        Per place, from the bottom up, cuts in the order of preference.
    friction
    check
        Function that gives the verdict on the part above a cut.
    name
        Prefix of the block names ``c00-block``, ``c01-block`` and so on.

    Raises
    ------
    InputError
        With no cut of a place the part above stands, or a cut divides it into several parts.
    """
    if not proposals:
        raise InputError("no place to cut at", where="proposals")
    pieces: list[Block] = []
    trials: list[Trial] = []
    rest = block
    for place, choices in enumerate(proposals):
        for cut in choices:
            above, below = cut_block(rest, cut)
            if len(above) > 1 or len(below) > 1:
                raise InputError(
                    f"the cut at place {place} divides the shape into {len(above)} parts above and "
                    f"{len(below)} below",
                    remedy="turn it, or cut the parts one by one",
                )
            result = stands_on_cut(below[0], above[0], friction, check)
            trials.append(Trial(place, cut, result))
            if trials[-1].accepted:
                pieces.append(below[0].renamed(f"{name}{place:02d}-block"))
                rest = above[0]
                break
        else:
            raise InputError(
                f"none of {len(choices)} cuts at place {place} lets the part above stand",
                remedy="propose other cuts, or more friction",
            )
    pieces.append(rest.renamed(f"{name}{len(proposals):02d}-block"))
    return CutDesign(Assembly(tuple(pieces), np.arange(len(pieces)) == 0), tuple(trials))


def tilted_cuts(
    point: Floats, normal: Floats, edge: Floats, tilts_deg: Sequence[float], wedge_deg: float = 0.0
) -> tuple[Cut, ...]:
    """The cut rotated by several angles about an edge through its point."""
    axis, base = unit(edge, "edge"), unit(normal, "normal")
    return tuple(
        Cut(point, rotation_about(axis, tilt) @ base, wedge_deg, axis) for tilt in tilts_deg
    )


def stands_on_cut(below: Block, above: Block, friction: float, check: Check = check_both) -> Result:
    """The verdict on the part above a cut, with the part below fixed."""
    pair = Assembly((below.renamed("below"), above.renamed("above")), np.array([True, False]))
    return check(Model.of(pair, friction=friction))


def _blocks(pieces: Sequence[Piece], whole: Block, side: str) -> list[Block]:
    out = []
    for number, (vertices, faces) in enumerate(pieces):
        suffix = f"-{number}" if len(pieces) > 1 else ""
        used = sorted({i for face in faces for i in face})
        new = {old: i for i, old in enumerate(used)}
        loops = tuple(tuple(new[i] for i in face) for face in faces)
        name = f"{whole.name}-{side}{suffix}"
        out.append(Block(vertices[used], loops, name, whole.density, whole.metadata))
    return out
