"""What the contact search found, what it left out and why, and what would change that."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from drystone.detection.options import DetectionOptions
from drystone.detection.penetration import Penetration
from drystone.geometry.arrays import Bools, Floats, Ints

SHOWN = 8
"""Names listed in one line of the summary."""


class Reason(StrEnum):
    """Why two faces that nearly touch were not joined."""

    GAP = "too far apart"
    OVERLAP = "too deep in each other"
    ANGLE = "not parallel enough"
    WARP = "too warped"
    SLIVER = "overlap too narrow"
    HIDDEN = "another block lies between"


@dataclass(frozen=True)
class Missed:
    """Two faces that nearly touch, and were not joined.

    Attributes
    ----------
    block_a, block_b
        Positions, a < b.
    face_a, face_b
        Numbers of the faces in their blocks; the first where coplanar faces were merged.
    reason
    gap : [m]
        Smallest distance over the shared area, negative where they overlap.
    angle : [deg]
    area : [m2]
        Shared area in projection.
    needed
        What ``gap`` (for ``Reason.GAP`` and ``OVERLAP``) or ``angle`` [deg] (for ``ANGLE``) of the
        options would join them; NaN for other reasons.
    polygon : (c, 3) [m]
        The shared area, halfway between the faces.
    joined
        Whether the two blocks touch elsewhere.
    """

    block_a: int
    block_b: int
    face_a: int
    face_b: int
    reason: Reason
    gap: float
    angle: float
    area: float
    needed: float
    polygon: Floats
    joined: bool


@dataclass(frozen=True)
class ContactReport:
    """How the contacts came about.

    Attributes
    ----------
    names
        Of the blocks.
    options
    block_a, block_b, face_a, face_b : (m,)
        Blocks and (first) faces of each interface; -1 where the block touches with an edge or a
        corner.
    kind : (m,)
        3 for an area, 2 for a line, 1 for a point.
    area : (m,) [m2]
    gap : (m,) [m]
        Distance of the faces in the middle of the interface, negative where they overlap.
    warp : (m,) [m]
        Largest distance of a face corner from its plane, of the two faces.
    angle : (m,) [deg]
        Between the two faces.
    clipped : (m,) bool
        Whether the faces are within tolerance on a part of their common area only.
    merged : (m,)
        Number of pieces that were merged into the interface.
    missed
        Near misses.
    undirected
        Pairs that meet along parallel edges or in corners, where no direction can be told.
    isolated
        Blocks that touch nothing.
    penetrations
        Blocks that stand in each other.
    duplicates
        Pairs of blocks that are the same solid in the same place.
    parts
        Blocks that consist of several separate parts, and how many.
    repairs
        Per repaired block its position and what was mended.
    """

    names: tuple[str, ...]
    options: DetectionOptions
    block_a: Ints
    block_b: Ints
    face_a: Ints
    face_b: Ints
    kind: Ints
    area: Floats
    gap: Floats
    warp: Floats
    angle: Floats
    clipped: Bools
    merged: Ints
    missed: tuple[Missed, ...]
    undirected: tuple[tuple[int, int], ...]
    isolated: tuple[int, ...]
    penetrations: tuple[Penetration, ...]
    duplicates: tuple[tuple[int, int], ...]
    parts: tuple[tuple[int, int], ...]
    repairs: tuple[tuple[int, str], ...]

    @property
    def pair_count(self) -> int:
        """Number of pairs of blocks that touch."""
        return len(np.unique(self.block_a * len(self.names) + self.block_b))

    def suggestions(self) -> tuple[str, ...]:
        """What would join more pairs of blocks that do not touch yet, in plain words."""
        said = []
        apart = [m for m in self.missed if not m.joined]
        for reason, knob, unit, digits in (
            (Reason.GAP, "gap", "", 2),
            (Reason.ANGLE, "angle", " degrees", 2),
        ):
            needed: dict[tuple[int, int], float] = {}
            for miss in apart:
                if miss.reason is reason and not np.isnan(miss.needed):
                    pair = (miss.block_a, miss.block_b)
                    needed[pair] = min(miss.needed, needed.get(pair, np.inf))
            if needed:
                value = _rounded_up(max(needed.values()), digits)
                said.append(
                    f"raise {knob} from {getattr(self.options, knob):g} to {value:g}{unit}"
                    f" to join {_count(len(needed), 'more pair')}"
                )
        if self.penetrations:
            pairs = _count(len(self.penetrations), "pair")
            said.append(f"{pairs} of blocks overlap: move them apart in the model")
        if self.parts:
            said.append("split the parts into blocks of their own (drystone.repair.split_shells)")
        explained = {i for pair in self.undirected for i in pair}
        explained |= {i for p in self.penetrations for i in (p.block_a, p.block_b)}
        explained |= {i for miss in apart for i in (miss.block_a, miss.block_b)}
        lost = [self.names[i] for i in self.isolated if i not in explained]
        if lost:
            said.append(
                f"nothing is near {self._list(lost)}: is a block missing, or in other units?"
            )
        return tuple(said)

    def summary(self) -> list[str]:
        """The report as lines of text."""
        lines = [f"{_count(len(self.area), 'interface')} in {_count(self.pair_count, 'pair')}"]
        kinds = Counter(self.kind.tolist())
        if kinds[2] or kinds[1]:
            lines[0] += f", {_count(kinds[2], 'line')} and {_count(kinds[1], 'point')} among them"
        if len(self.gap):
            lines.append(
                f"gaps {_mm(self.gap.min())} to {_mm(self.gap.max())} mm,"
                f" warp up to {_mm(self.warp.max())} mm,"
                f" angles up to {round(float(self.angle.max()), 6):.3g} degrees"
            )
        if self.clipped.any():
            lines.append(
                f"{_count(int(self.clipped.sum()), 'interface')} within tolerance on a part only"
            )
        if (self.merged > 1).any():
            many = self.merged > 1
            lines.append(
                f"{int(self.merged[many].sum())} pieces merged into"
                f" {_count(int(many.sum()), 'interface')}"
            )
        lines += self._missed_lines()
        if self.undirected:
            shown = [f"{self.names[a]}-{self.names[b]}" for a, b in self.undirected]
            lines.append(
                f"{_count(len(shown), 'pair')} not joined, edge meets edge and the direction of"
                f" contact is open: {self._list(shown)}"
            )
        if self.isolated:
            lines.append(
                f"{_count(len(self.isolated), 'block')} touch nothing:"
                f" {self._list([self.names[i] for i in self.isolated])}"
            )
        for deep in sorted(self.penetrations, key=lambda p: -p.depth)[:SHOWN]:
            lines.append(
                f"blocks '{self.names[deep.block_a]}' and '{self.names[deep.block_b]}'"
                f" stand {_mm(deep.depth)} mm in each other"
            )
        if len(self.penetrations) > SHOWN:
            lines.append(f"and {len(self.penetrations) - SHOWN} more pairs stand in each other")
        lines += [
            f"blocks '{self.names[a]}' and '{self.names[b]}' are one block twice"
            for a, b in self.duplicates
        ]
        lines += [
            f"block '{self.names[i]}' consists of {count} separate parts" for i, count in self.parts
        ]
        lines += [f"block '{self.names[i]}': {what}" for i, what in self.repairs]
        return lines + [f"suggestion: {text}" for text in self.suggestions()]

    def _missed_lines(self) -> list[str]:
        apart: dict[Reason, set[tuple[int, int]]] = {}
        for miss in self.missed:
            if not miss.joined:
                apart.setdefault(miss.reason, set()).add((miss.block_a, miss.block_b))
        lines = []
        for reason, pairs in apart.items():
            shown = [f"{self.names[a]}-{self.names[b]}" for a, b in sorted(pairs)]
            lines.append(f"{_count(len(pairs), 'pair')} not joined, {reason}: {self._list(shown)}")
        beside = Counter(str(miss.reason) for miss in self.missed if miss.joined)
        lines += [
            f"{_count(count, 'overlap')} dropped between blocks that touch elsewhere, {reason}"
            for reason, count in beside.items()
        ]
        return lines

    def _list(self, items: list[str]) -> str:
        more = f" and {len(items) - SHOWN} more" if len(items) > SHOWN else ""
        return ", ".join(items[:SHOWN]) + more

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain lists, numbers and strings, for JSON."""
        name = self.names
        return {
            "options": {
                key: getattr(self.options, key)
                for key in ("gap", "angle", "warp", "sliver", "merge", "search")
            }
            | {"edges": str(self.options.edges)},
            "pairs": self.pair_count,
            "interfaces": [
                {
                    "blocks": [name[a], name[b]],
                    "faces": [_face(self.face_a[i]), _face(self.face_b[i])],
                    "kind": {3: "area", 2: "line", 1: "point"}[int(self.kind[i])],
                    "area": float(self.area[i]),
                    "gap": float(self.gap[i]),
                    "warp": float(self.warp[i]),
                    "angle": float(self.angle[i]),
                    "clipped": bool(self.clipped[i]),
                    "merged": int(self.merged[i]),
                }
                for i, (a, b) in enumerate(
                    zip(self.block_a.tolist(), self.block_b.tolist(), strict=True)
                )
            ],
            "missed": [
                {
                    "blocks": [name[m.block_a], name[m.block_b]],
                    "faces": [m.face_a, m.face_b],
                    "reason": str(m.reason),
                    "gap": m.gap,
                    "angle": m.angle,
                    "area": m.area,
                    "needed": None if np.isnan(m.needed) else m.needed,
                    "polygon": m.polygon.tolist(),
                    "joined": m.joined,
                }
                for m in self.missed
            ],
            "undirected": [[name[a], name[b]] for a, b in self.undirected],
            "isolated": [name[i] for i in self.isolated],
            "penetrations": [
                {"blocks": [name[p.block_a], name[p.block_b]], "depth": p.depth}
                for p in self.penetrations
            ],
            "duplicates": [[name[a], name[b]] for a, b in self.duplicates],
            "parts": [{"block": name[i], "count": count} for i, count in self.parts],
            "repairs": [{"block": name[i], "what": what} for i, what in self.repairs],
            "suggestions": list(self.suggestions()),
        }


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


def _face(number: Any) -> int | None:
    """A face number; none for the side of a contact that is an edge or a corner."""
    return int(number) if number >= 0 else None


def _mm(length: float) -> str:
    """A length [m] in millimetres, to a nanometre."""
    return f"{round(1e3 * float(length), 6) + 0.0:.3g}"


def _rounded_up(value: float, digits: int) -> float:
    """The next larger number with a few significant digits, so that it is enough."""
    step = 10.0 ** (np.floor(np.log10(value)) - digits + 1)
    return float((np.floor(value / step * (1.0 + 1e-9)) + 1.0) * step)


__all__ = ["ContactReport", "Missed", "Penetration", "Reason"]
