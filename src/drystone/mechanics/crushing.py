"""Joints that crush: their stress blocks in a program, from inside.

What a face carries is the convex hull of the parts beyond a line under its strength; see
:mod:`drystone.geometry.stress_block`. A program has some of these parts, so its forces never exceed
the strength. The multipliers of its rows are planes over the faces. The part where a plane is
positive is the one that is missing most, and the work that it takes up bounds what all missing
parts can add. Parts are added until that is negligible.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats, Ints, dot, lengths
from drystone.base.ragged import Ragged
from drystone.contacts import Contacts
from drystone.geometry.stress_block import cut_off, stress_block


@dataclass(frozen=True, eq=False)
class Crushing:
    """The faces of finite strength, and the parts of them that a program knows.

    Attributes
    ----------
    corner : (c,)
        Corners of the problem, face after face.
    start : (j + 1,)
        Face i has the corners ``start[i]`` to ``start[i + 1] - 1`` of them.
    place : (c, 2)
        Of each corner from the centroid of its face, by the root of its area.
    strength : (j,)
        Force that the whole face carries, by the unit of force.
    face : (g,)
        The face of each part.
    part : (g, 3)
        Area and first moments of each part, by those of a face of unit area.
    """

    corner: Ints
    start: Ints
    place: Floats
    strength: Floats
    face: Ints
    part: Floats

    @classmethod
    def of(cls, contacts: Contacts, force_unit: float) -> Crushing | None:
        """That of some joints; None where none has a finite strength."""
        finite = np.flatnonzero(contacts.crushes)
        if not len(finite) or contacts.capacity is None:
            return None
        loops, corner, flat = contacts.flat_corners(finite)
        area = contacts.area[finite]
        flat /= loops.spread(np.sqrt(np.where(area > 0.0, area, 1.0)))[:, None]
        strength = contacts.capacity.compression[finite] / force_unit
        none = np.zeros(0, dtype=np.intp), np.zeros((0, 3))
        made = cls(corner, loops.start, flat, strength, *none)
        made = made._with(np.arange(len(finite)), np.tile([1.0, 0.0, 0.0], (len(finite), 1)))
        # strips along the longest edge and across it, as those of arches and walls are
        edge = flat[loops.following] - flat
        longest = np.lexsort((-lengths(edge), loops.owner))[loops.first]
        along = edge[longest] / np.maximum(lengths(edge[longest]), 1e-300)[:, None]
        for side in (along, -along, along[:, ::-1] * (1.0, -1.0), along[:, ::-1] * (-1.0, 1.0)):
            height = dot(flat, loops.spread(side))
            high, low = loops.max(height), loops.min(height)
            for share in (0.01, 0.03, 0.1, 0.2, 0.35, 0.55, 0.8):
                plane = np.column_stack([share * (high - low) - high, side])
                made = made._with(np.arange(len(finite)), plane)
        return made

    def __len__(self) -> int:
        """Number of faces, j."""
        return len(self.strength)

    def _with(self, faces: Ints, plane: Floats) -> Crushing:
        """The same with the parts where planes (f, 3) over some faces (f,) are positive."""
        loops, row = Ragged(self.start).take(faces)
        part = cut_off(self.place[row], loops.start, plane)
        return replace(
            self,
            face=np.concatenate([self.face, faces]),
            part=np.concatenate([self.part, part]),
        )

    def missing(self, plane: Floats) -> Floats:
        """What the whole faces take up more than the known parts (j,), on planes (j, 3)."""
        known = np.zeros(len(self))
        np.maximum.at(known, self.face, dot(self.part, plane[self.face]))
        all_of_it = dot(cut_off(self.place, self.start, plane), plane)
        return self.strength * np.maximum(all_of_it - known, 0.0)

    def refined(self, plane: Floats, normal: Floats | None = None) -> Crushing:
        """The same with the parts where planes (j, 3) are positive, of faces that miss them.

        Also with the stress blocks of normal forces (c,): hinges move from face to face. With them
        the bridge of the tests takes 7 to 10 rounds, without them 14 to 18.
        """
        gap = self.missing(plane)
        short = np.flatnonzero(gap > 1e-3 * gap.max())
        made = self._with(short, plane[short])
        if normal is None:
            return made
        loops = Ragged(self.start)
        whole = loops.sum(normal)
        some = np.flatnonzero(whole > 1e-3 * self.strength)
        part, row = loops.take(some)
        at = part.sum(normal[row, None] * self.place[row]) / whole[some, None]
        return made._with(some, stress_block(self.place[row], part.start, at)[1])
