"""What is set up of scaffolding, as layers of a picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drystone.answer import Layer, LayerKind, MarkerShape
from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.sequence.scaffold_items import Centring, Rope, ScaffoldItem, Strut
from drystone.sequence.scaffold_places import Support

_WIDE = 3.0
"""Width of a strut or a rope, by that of other lines; chosen by eye."""


def scaffold_layers(
    items: Sequence[ScaffoldItem], support: Support, assembly: Assembly
) -> tuple[Layer, ...]:
    """Bars of struts and ropes, edges of centring, a mark for each clamp."""
    if not items:
        return ()
    label = f"{len(items)} {support.words(len(items))}"
    ends: list[tuple[Floats, Floats]] = []
    for item in items:
        if isinstance(item, Strut):
            ends.append((np.array([item.foot]), np.array([item.head])))
        elif isinstance(item, Rope):
            ends.append((np.array([item.at]), np.array([item.anchor])))
        elif isinstance(item, Centring):
            ends.append((item.face, np.roll(item.face, -1, axis=0)))
    if not ends:
        block = assembly.indices([item.block for item in items])
        place = assembly.centroid[block]
        mark = MarkerShape.DIAMOND
        return (Layer("scaffold", label, LayerKind.MARKERS, "added", place, shape=mark),)
    start, end = (np.concatenate(side) for side in zip(*ends, strict=True))
    return (Layer("scaffold", label, LayerKind.LINES, "added", start, end - start, width=_WIDE),)
