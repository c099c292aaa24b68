"""Numbers and names of blocks on a figure."""

from __future__ import annotations

import numpy as np

from drystone.answer.scene import State
from drystone.assembly import Block
from drystone.base.arrays import Floats
from drystone.view.ink import Sheet

_ALIKE = 0.9
"""Cosine of the angle up to which faces are one side of a block to a reader."""
_SIZE = 7.0
"""[points], letters of a label."""
LETTER, LINE = 0.6 * _SIZE / 72.0, 1.7 * _SIZE / 72.0
"""[inches], about the width of a letter and the height of a label."""
_LONGEST = 24
"""Letters of a name that are written."""


def draw_labels(sheet: Sheet, *, numbers: bool, names: bool) -> None:
    """Write numbers and names on the blocks; of labels that would touch, the nearest is written."""
    scene = sheet.scene
    given = scene.number if numbers and scene.number is not None else None
    if given is None and not names:
        return
    taken: list[tuple[float, float, float]] = []
    here = np.flatnonzero(sheet.stage.state != State.ABSENT)
    if sheet.plane is not None:
        here = here[sheet.plane.heights(scene.assembly.centroid[here]) <= 0.0]
    near = here[np.argsort(-(scene.assembly.centroid[here] @ sheet.eye), kind="stable")]
    for i in near.tolist():
        number = str(given[i]) if given is not None and given[i] > 0 else ""
        name = scene.assembly.names[i][:_LONGEST] if names else ""
        text = " ".join(one for one in (number, name) if one)
        if not text:
            continue
        place = sheet.project(shown_middle(scene.assembly.blocks[i], sheet.eye)[None])[0]
        x, y = float(place[0]) * sheet.scale, float(place[1]) * sheet.scale
        half = 0.5 * LETTER * (len(text) + 1)
        if any(abs(x - u) < half + w and abs(y - v) < LINE for u, v, w in taken):
            continue
        taken.append((x, y, half))
        sheet.axes.text(
            float(place[0]), float(place[1]), text, ha="center", va="center", fontsize=_SIZE,
            zorder=1e6, parse_math=False, color=sheet.colours["edge"],
            bbox={
                "boxstyle": "round,pad=0.15", "facecolor": sheet.colours["background"],
                "alpha": 0.75, "lw": 0,
            },
        )  # fmt: skip


def shown_middle(block: Block, toward: Floats) -> Floats:
    """Middle (3,) of the side of a block that an eye in some direction sees most of.

    A side is the face with the largest picture and those that turn as it does, within ALIKE.
    """
    triangles = np.array(
        [
            block.vertices[[face[0], face[i], face[i + 1]]]
            for face in block.faces
            for i in range(1, len(face) - 1)
        ]
    )
    normal = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    largest = normal[int(np.argmax(normal @ toward))]
    alike = normal @ largest > _ALIKE * np.linalg.norm(normal, axis=1) * np.linalg.norm(largest)
    weight = np.where(alike, normal @ toward, 0.0)
    middle: Floats = weight @ triangles.mean(axis=1) / weight.sum()
    return middle
