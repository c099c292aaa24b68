"""The middle surface of a shell: patches, seams between them, supported sides."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.shells.lengths import arc_lengths
from drystone.shells.patch import Patch, Side, check_patch

_SEAM_GAP = 1e-4
"""Largest distance between the two sides of a seam, relative to the size of the patch. Chosen: far
below any block, far above the rounding of a spline."""

_SLENDERNESS = 30.0
"""Size of a patch divided by its thickness, where none is given. Chosen: a thick masonry shell."""


@dataclass(frozen=True)
class Edge:
    """A stretch of a patch's border.

    Parameters
    ----------
    patch
        Position of the patch in the shape.
    side
    start, end
        Positions along the side, in [0, 1]; start above end reverses the direction.
    """

    patch: int
    side: Side
    start: float = 0.0
    end: float = 1.0

    @property
    def low(self) -> float:
        """The smaller of start and end."""
        return min(self.start, self.end)

    @property
    def high(self) -> float:
        """The larger of start and end."""
        return max(self.start, self.end)


@dataclass(frozen=True)
class Seam:
    """Two stretches of border that are one curve, run in the same direction."""

    one: Edge
    other: Edge


@dataclass(frozen=True, eq=False)
class Shape(OneLine):
    """Patches joined along seams, supported on some of their sides.

    Parameters
    ----------
    patches
    seams
        Where patches meet; checked.
    supports
        Stretches of border on which the shell is supported.
    keystone
        Stretches of border around an opening that one block closes; empty for an open eye.
    name
    thickness : [m]
        Thickness of the shape, if known: that of form finding.

    Raises
    ------
    InputError
        A folded patch, a seam whose sides do not meet, or an edge of a patch or side that does not
        exist.
    """

    patches: tuple[Patch, ...]
    seams: tuple[Seam, ...] = ()
    supports: tuple[Edge, ...] = ()
    keystone: tuple[Edge, ...] = ()
    name: str = "shell"
    thickness: float | None = None

    def __post_init__(self) -> None:
        if not self.patches:
            raise InputError("a shape needs a patch")
        edges = [e for seam in self.seams for e in (seam.one, seam.other)]
        for edge in (*edges, *self.supports, *self.keystone):
            if not isinstance(edge, Edge):
                raise InputError(
                    f"a border stretch is {edge!r}",
                    where=f"shape '{self.name}'",
                    remedy="give Edge(patch, side)",
                )
            if not 0 <= edge.patch < len(self.patches):
                raise InputError(f"there is no patch {edge.patch}", where=f"shape '{self.name}'")
            if not (0.0 <= edge.low < edge.high <= 1.0):
                raise InputError(
                    f"a border stretch from {edge.start} to {edge.end} is not within 0 to 1",
                    where=f"shape '{self.name}', patch {edge.patch}, side {edge.side.value}",
                )
            if self.patches[edge.patch].closed and edge.side in (Side.LEFT, Side.RIGHT):
                raise InputError(
                    f"a closed patch has no side '{edge.side.value}'",
                    where=f"shape '{self.name}', patch {edge.patch}",
                    remedy="name its bottom or its top",
                )
        for patch in self.patches:
            check_patch(patch)
        for seam in self.seams:
            self._check_seam(seam)

    def _check_seam(self, seam: Seam) -> None:
        one, other = (_resample(self.points_along(e, 257), 33) for e in (seam.one, seam.other))
        gap = float(np.linalg.norm(one - other, axis=1).max())
        size = max(self.patches[e.patch].size for e in (seam.one, seam.other))
        if gap > _SEAM_GAP * size:
            raise InputError(
                f"the sides of a seam are {gap:.3g} m apart",
                where=(
                    f"shape '{self.name}', patches {seam.one.patch} ({seam.one.side.value}) and "
                    f"{seam.other.patch} ({seam.other.side.value})"
                ),
                remedy="give both patches the same border curve, run in the same direction",
            )

    @property
    def default_thickness(self) -> float:
        """[m], the thickness of the shape, else 1/30 of the size of its largest patch."""
        if self.thickness is not None:
            return self.thickness
        return max(patch.size for patch in self.patches) / _SLENDERNESS

    def points_along(self, edge: Edge, count: int) -> Floats:
        """(count, 3) [m] points of a stretch of border, evenly in its parameter."""
        along = np.linspace(edge.start, edge.end, count)
        return self.patches[edge.patch].border(edge.side, along)

    def supported_on(self, *supports: Edge) -> Shape:
        """The same shape on other supports."""
        return replace(self, supports=tuple(supports))


def _resample(points: Floats, count: int) -> Floats:
    """(count, 3) points evenly along a polyline (p, 3)."""
    length = arc_lengths(points)
    at = np.linspace(0.0, length[-1], count)
    return np.stack([np.interp(at, length, points[:, i]) for i in range(3)], axis=1)
