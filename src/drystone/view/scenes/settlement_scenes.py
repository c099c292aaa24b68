"""A settlement: a scene that plays it, and one of the blocks where it takes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.checks import block_speed
from drystone.contacts import Contacts
from drystone.geometry.frames import rotation_about
from drystone.settlement import SupportResponse
from drystone.view.scenes.header import facts_of
from drystone.view.scenes.palette import State
from drystone.view.scenes.scene import Layer, LayerKind, Scene, Stage
from drystone.view.scenes.staging import PLAYED, stage_of


def settlement_scene(settlement: SupportResponse, source: str = "") -> Scene:
    """A scene that compares the forces before and after, and plays the motion, enlarged.

    Examples
    --------
    >>> from drystone.settlement import support_response
    >>> from drystone.models import arch
    >>> moved = {"springer-right": (0.01, 0.0, 0.0)}
    >>> settled = support_response(arch(0.2, 8), moved, friction=0.7)
    >>> [stage.label for stage in settlement_scene(settled).stages]
    ['after', 'before']
    """
    result = settlement.result
    after = stage_of(result, "after")
    if result.displacement is not None:
        after = replace(
            after,
            headline=_headline(settlement),
            message=f"{after.message}; the motion is enlarged",
            motion=_enlarged(result.assembly, result.displacement)[0],
            motion_name="Settlement, enlarged",
            layers=(*after.layers, *_openings(settlement)),
        )
    title = f"drystone: {after.headline.lower()}"
    before = stage_of(settlement.before, "before")
    return Scene(
        result.assembly, result.contacts, (after, before), title, _facts(settlement, source)
    )


def moved_scene(settlement: SupportResponse, source: str = "") -> Scene:
    """The blocks moved, enlarged, so that a figure shows which joints open.

    Without an answer it is the scene of :func:`settlement_scene`.
    """
    result = settlement.result
    if result.displacement is None:
        return settlement_scene(settlement, source)
    motion, factor = _enlarged(result.assembly, result.displacement)
    blocks = []
    for block, at, move in zip(
        result.assembly.blocks, result.assembly.centroid, motion, strict=True
    ):
        angle = float(np.linalg.norm(move[3:]))
        turn = rotation_about(move[3:], float(np.rad2deg(angle))) if angle > 0.0 else np.eye(3)
        blocks.append(block.transformed(turn, at + move[:3] - turn @ at))
    state = np.where(result.assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)
    message = f"{result.message}; the motion is drawn {factor:.3g} times as large"
    headline = _headline(settlement)
    stage = Stage("after", headline, message, state, result.verdict)
    moved = Assembly(tuple(blocks), result.assembly.fixed)
    facts = _facts(settlement, source)
    return Scene(moved, Contacts.empty(), (stage,), f"drystone: {headline.lower()}", facts)


def _facts(settlement: SupportResponse, source: str) -> Mapping[str, str]:
    model = settlement.result.model
    facts = facts_of(model.assembly, model.contacts, model.load, source)
    motion = model.load.motion
    moved = [] if motion is None else np.flatnonzero(motion.any(axis=1)).tolist()
    names = ", ".join(model.assembly.names[i] for i in moved)
    return {**facts, "Supports that move": f"{names}, by at most {settlement.size:.3g} m"}


def _headline(settlement: SupportResponse) -> str:
    count = len(settlement.open_joints())
    return f"Settled: {count} joint{'' if count == 1 else 's'} open{'s' if count == 1 else ''}"


def _enlarged(assembly: Assembly, motion: Floats) -> tuple[Floats, float]:
    """The motion (n, 6) as pictures show it, and by how much it is enlarged."""
    factor = PLAYED * float(np.median(assembly.size)) / float(block_speed(assembly, motion).max())
    return motion * factor, factor


def _openings(settlement: SupportResponse) -> tuple[Layer, ...]:
    contacts = settlement.result.contacts
    opens = np.isin(np.arange(contacts.count), settlement.open_joints())
    opens &= np.diff(contacts.start) >= 3
    if not opens.any():
        return ()
    gaps = contacts.select(opens)
    return (
        Layer(
            "opening", "joints that open", LayerKind.POLYGONS, "help", gaps.point,
            start=gaps.start,
        ),
    )  # fmt: skip


__all__ = ["moved_scene", "settlement_scene"]
