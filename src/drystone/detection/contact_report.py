"""What the contact search found, what it left out and why, and suggestions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from drystone.base.arrays import Ints, places
from drystone.base.display import Card, first_of, named
from drystone.base.errors import counted
from drystone.base.table import Table
from drystone.detection.advice import suggestions
from drystone.detection.face_overlaps import Overlap, overlap_lines, require_apart
from drystone.detection.interfaces import Interfaces
from drystone.detection.misses import Inexact, Shortfall, inexact_lines
from drystone.detection.resample import Resampled, resampled_lines
from drystone.detection.tolerances import (
    SHOWN,
    DetectionOptions,
    Missed,
    Reason,
    millimetres,
    repair_lines,
)

_KINDS = {3: "area", 2: "line", 1: "point"}
"""Names of the kinds of interfaces."""

_BETWEEN = {
    "missed": ("gap", "angle", "area", "joined"),
    "inexact": ("error", "off"),
    "resampled": ("facets", "pieces", "points", "turn", "moved"),
    "shortfalls": ("area", "share", "gap", "angle"),
    "overlaps": ("depth", "volume", "share"),
}
"""What is found between two blocks, and what JSON has of each."""

Pair = TypeVar("Pair", Resampled, Missed, Inexact, Shortfall, Overlap)
"""What is found between two blocks."""
Known = TypeVar("Known", int, str)
"""What is known of a block."""


@dataclass(frozen=True)
class ContactReport(Card):
    """Where the contacts come from: faces, gaps, near misses, overlaps.

    Attributes
    ----------
    names
        Of the blocks.
    options
    interfaces
        With a row each: blocks, faces, area, gap, warp and angle.
    resampled
        Pairs whose curved joints have fewer interfaces than facets.
    missed
        Near misses, and joints that are within tolerance on a part only.
    farther
        Gaps wider than those of near misses that may be errors of the drawing all the same. They
        are for blocks that touch nothing, and no fall is proved by them.
    inexact
        Pairs that are joined although they are drawn beyond a tolerance.
    shortfalls
        Curved joints whose area was not completely found.
    undirected
        Pairs that meet, or nearly meet, along parallel edges or at corners, where the contact has
        no defined normal.
    isolated
        Blocks that touch nothing.
    overlaps
        Pairs of blocks that overlap deeper than the tolerance.
    parts
        Blocks that consist of separate parts, and the number of parts.
    repairs
        Per repaired block its position and the repair.
    """

    names: tuple[str, ...]
    options: DetectionOptions
    interfaces: Interfaces
    resampled: tuple[Resampled, ...]
    missed: tuple[Missed, ...]
    farther: tuple[Missed, ...]
    inexact: tuple[Inexact, ...]
    shortfalls: tuple[Shortfall, ...]
    undirected: tuple[tuple[int, int], ...]
    isolated: tuple[int, ...]
    overlaps: tuple[Overlap, ...]
    parts: tuple[tuple[int, int], ...]
    repairs: tuple[tuple[int, str], ...]

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        gap = self.interfaces.gap
        ends = [gap.min(), gap.max()] if len(gap) else []
        return self._summary(), {
            "gaps [mm]": " to ".join(millimetres(gap) for gap in ends),
            "touch nothing": named([self.names[i] for i in self.isolated], SHOWN),
            "suggestions": "; ".join(self.suggestions()),
        }

    def _summary(self) -> str:
        apart = len({(miss.block_a, miss.block_b) for miss in self.missed if not miss.joined})
        return (
            f"{counted(len(self.names), 'block')}, "
            f"{counted(self.interfaces.count, 'interface')} in "
            f"{counted(self.pair_count, 'pair')}, {counted(apart, 'pair')} missed, "
            f"{counted(len(self.overlaps), 'overlap')}"
        )

    @property
    def pair_count(self) -> int:
        """Number of pairs of blocks that touch."""
        found = self.interfaces
        return len(np.unique(found.block_a * len(self.names) + found.block_b))

    @property
    def overlaps_left(self) -> tuple[Overlap, ...]:
        """Overlaps of pairs that were not joined all the same."""
        inexact = {(pair.block_a, pair.block_b) for pair in self.inexact}
        return tuple(p for p in self.overlaps if (p.block_a, p.block_b) not in inexact)

    @property
    def unjoined(self) -> tuple[Missed, ...]:
        """Pairs that are near each other and were not joined, though no block lies between.

        What is drawn there may be meant to touch. An overlap without facing faces has no polygon.
        """
        near = [
            replace(miss, area=0.0, polygon=np.zeros((0, 3))) if miss.narrow else miss
            for miss in (*self.missed, *self.farther)
            if miss.reason is not Reason.HIDDEN
            and not (miss.joined and miss.reason is Reason.SLIVER)
        ]
        count = len(self.names)
        known = {miss.block_a * count + miss.block_b for miss in near}
        near += [
            Missed.overlap(pair.block_a, pair.block_b, pair.depth, joined=False)
            for pair in self.overlaps_left
            if pair.block_a * count + pair.block_b not in known
        ]
        return tuple(near)

    def of_blocks(self, blocks: Ints) -> ContactReport:
        """The report of some of the blocks, numbered anew in their order."""
        new = places(blocks, len(self.names))
        found = self.interfaces
        among = np.flatnonzero((new[found.block_a] >= 0) & (new[found.block_b] >= 0))
        found = found.take(among)
        found = replace(found, block_a=new[found.block_a], block_b=new[found.block_b])

        def between(pairs: tuple[Pair, ...]) -> tuple[Pair, ...]:
            return tuple(
                replace(one, block_a=int(new[one.block_a]), block_b=int(new[one.block_b]))
                for one in pairs
                if new[one.block_a] >= 0 and new[one.block_b] >= 0
            )

        def of_one(rows: tuple[tuple[int, Known], ...]) -> tuple[tuple[int, Known], ...]:
            return tuple((int(new[block]), known) for block, known in rows if new[block] >= 0)

        pairs = [(int(new[a]), int(new[b])) for a, b in self.undirected]
        touching = np.concatenate([found.block_a, found.block_b])
        alone = np.setdiff1d(np.arange(len(blocks)), touching)
        own: dict[str, Any] = {
            name: between(getattr(self, name)) for name in ("farther", *_BETWEEN)
        }
        return replace(
            self,
            names=tuple(self.names[b] for b in blocks),
            interfaces=found,
            undirected=tuple(pair for pair in pairs if min(pair) >= 0),
            isolated=tuple(alone.tolist()),
            parts=of_one(self.parts),
            repairs=of_one(self.repairs),
            **own,
        )

    def suggestions(self) -> tuple[str, ...]:
        """Sentences that say which options would join more pairs of blocks."""
        return suggestions(self)

    @property
    def bridged(self) -> list[str]:
        """A sentence on gaps, from a micrometre on, that a given tolerance makes joints."""
        widest, default = self.interfaces.gap.max(initial=0.0), DetectionOptions()
        given = self.options.gap_length is not None or self.options.gap > default.gap
        if not given or round(widest, 6) <= 0.0:
            return []
        return [f"joints across gaps of up to {millimetres(widest)} mm count as touching"]

    def summary(self) -> list[str]:
        """The report as lines of text."""
        lines = [
            f"{counted(self.interfaces.count, 'interface')} in {counted(self.pair_count, 'pair')}"
        ]
        found = self.interfaces
        kinds = Counter(found.kind.tolist())
        if kinds[2] or kinds[1]:
            lines[0] += f", {counted(kinds[2], 'line')} and {counted(kinds[1], 'point')} among them"
        if found.count:
            lines.append(
                f"gaps {millimetres(found.gap.min())} to {millimetres(found.gap.max())} mm,"
                f" warp up to {millimetres(found.warp.max())} mm,"
                f" angles up to {round(float(found.angle.max()), 6):.3g} degrees"
            )
        if found.clipped.any():
            lines.append(
                f"{counted(int(found.clipped.sum()), 'interface')} within tolerance on a part only"
            )
        lines += resampled_lines(self.resampled)
        lines += inexact_lines(self.names, self.inexact)
        lines += self._missed_lines()
        lines += first_of(
            [
                f"{100.0 * short.share:.2g} % of the curved joint of '{self.names[short.block_a]}'"
                f" and '{self.names[short.block_b]}' is missed, {short.area:.3g} m2: its two sides"
                " are meshed too differently"
                for short in sorted(self.shortfalls, key=lambda joint: -joint.share)
            ],
            most=SHOWN,
        )
        if self.undirected:
            shown = [f"{self.names[a]}-{self.names[b]}" for a, b in self.undirected]
            lines.append(
                f"{counted(len(shown), 'pair')} not joined, edge at edge or corner at corner, where"
                f" the contact has no defined normal: {named(shown, SHOWN)}"
            )
        if self.isolated:
            lines.append(
                f"{counted(len(self.isolated), 'block')}"
                f" {'touches' if len(self.isolated) == 1 else 'touch'} nothing:"
                f" {named([self.names[i] for i in self.isolated], SHOWN)}"
            )
        lines += overlap_lines(self.names, self.overlaps_left)
        lines += first_of(
            [f"block '{self.names[i]}' consists of {n} separate parts" for i, n in self.parts],
            most=SHOWN,
        )
        lines += repair_lines((self.names[i], what) for i, what in self.repairs)
        return lines + [f"suggestion: {text}" for text in self.suggestions()]

    def require_apart(self) -> None:
        """Refuse blocks that share more than a tenth of the smaller one.

        Raises
        ------
        InputError
            There are such blocks; the pair with the largest share is named.
        """
        require_apart(self.names, self.overlaps)

    def _missed_lines(self) -> list[str]:
        apart: dict[Reason, dict[tuple[int, int], Missed]] = {}
        for miss in self.missed:
            if not miss.joined:
                nearest = apart.setdefault(miss.reason, {})
                pair = (miss.block_a, miss.block_b)
                if pair not in nearest or _beyond(miss) < _beyond(nearest[pair]):
                    nearest[pair] = miss
        lines = []
        for reason, pairs in apart.items():
            shown = [
                f"{self.names[a]}-{self.names[b]}{_by_how_much(miss)}"
                for (a, b), miss in sorted(pairs.items(), key=lambda item: item[0])
            ]
            lines.append(
                f"{counted(len(pairs), 'pair')} not joined, {reason}: {named(shown, SHOWN)}"
            )
        beside = Counter(
            str(miss.reason)
            for miss in self.missed
            if miss.joined and miss.reason is not Reason.PARTLY
        )
        lines += [
            f"{counted(count, 'overlap')} dropped between blocks that touch elsewhere, {reason}"
            for reason, count in beside.items()
        ]
        return lines

    def table(self) -> Table:
        """A row per interface: blocks, faces, size, gap, warp and angle."""
        found = self.interfaces
        columns = {
            "block_a": [self.names[a] for a in found.block_a],
            "block_b": [self.names[b] for b in found.block_b],
            "face_a": [_face(face) for face in found.face_a],
            "face_b": [_face(face) for face in found.face_b],
            "kind": [_KINDS[kind] for kind in found.kind.tolist()],
        }
        columns |= {
            name: getattr(found, name)
            for name in ("area", "gap", "warp", "angle", "clipped", "merged")
        }
        return Table("interfaces", columns, {"area": "m2", "gap": "m", "warp": "m", "angle": "deg"})

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain lists, numbers and strings, for JSON."""
        name = self.names

        def rows(pairs: Sequence[Any], values: Sequence[str]) -> list[dict[str, Any]]:
            return [
                {"blocks": [name[one.block_a], name[one.block_b]]}
                | {key: getattr(one, key) for key in values}
                for one in pairs
            ]

        keys = ("gap", "angle", "warp", "sliver", "curve", "search")
        told: dict[str, Any] = {
            "options": {key: getattr(self.options, key) for key in keys}
            | {"edges": str(self.options.edges)},
            "pairs": self.pair_count,
            "interfaces": [
                {
                    "blocks": [row.pop("block_a"), row.pop("block_b")],
                    "faces": [row.pop("face_a"), row.pop("face_b")],
                    **row,
                }
                for row in self.table()
            ],
        }
        told |= {key: rows(getattr(self, key), values) for key, values in _BETWEEN.items()}
        for row, miss in zip(told["missed"], self.missed, strict=True):
            row |= {
                "faces": [_face(miss.face_a), _face(miss.face_b)],
                "reason": str(miss.reason),
                "needed": None if np.isnan(miss.needed) else miss.needed,
                "polygon": miss.polygon.tolist(),
            }
        return told | {
            "undirected": [[name[a], name[b]] for a, b in self.undirected],
            "isolated": [name[i] for i in self.isolated],
            "parts": [{"block": name[i], "count": count} for i, count in self.parts],
            "repairs": [{"block": name[i], "what": what} for i, what in self.repairs],
            "suggestions": list(self.suggestions()),
        }


def _beyond(miss: Missed) -> float:
    """The measure by which near misses of one reason are sorted."""
    return miss.angle if miss.reason is Reason.ANGLE else abs(miss.gap)


def _by_how_much(miss: Missed) -> str:
    """The distance or the angle beyond the tolerance, as text."""
    if miss.reason is Reason.ANGLE:
        return f" ({miss.angle:.3g} degrees)"
    if miss.reason in (Reason.GAP, Reason.OVERLAP):
        return f" ({millimetres(abs(miss.gap))} mm)"
    return ""


def _face(number: Any) -> int | None:
    """A face number; ``None`` for the side of a contact that is an edge or a corner."""
    return int(number) if number >= 0 else None
