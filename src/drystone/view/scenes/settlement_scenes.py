"""Settlements as scenes: effects of moving supports, and blocks followed to rest or into a fall."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drystone.answer.asked import Asked, directions
from drystone.answer.drawing import PLAYED, interface_layers, state_of
from drystone.answer.scene import Layer, LayerKind, Scene, SceneStage, State
from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.checks import block_speed
from drystone.contacts import Contacts
from drystone.geometry.frames import rotation_about
from drystone.results import Verdict
from drystone.settlement import Outcome, Settlement, SettlementPath, SupportResponse

MOST_STATES, MOST_POSITIONS = 60, 100_000
"""Frames of a path. Chosen: it looks smooth, and adds 3 MB to a page."""


def settlement_scene(settlement: SupportResponse) -> Scene:
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
    after = result.stage("after")
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
    before = settlement.before.stage("before")
    return Scene(result.assembly, result.contacts, (after, before), title, _facts(settlement))


def moved_scene(settlement: SupportResponse) -> Scene:
    """The blocks moved, enlarged, so that a figure shows which joints open.

    Without an answer it is the scene of :func:`settlement_scene`.
    """
    result = settlement.result
    if result.displacement is None:
        return settlement_scene(settlement)
    motion, factor = _enlarged(result.assembly, result.displacement)
    state = state_of(result.assembly)
    message = f"{result.message}; the motion is drawn {factor:.3g} times as large"
    headline = _headline(settlement)
    stage = SceneStage("after", headline, message, state, result.verdict)
    moved = moved_assembly(result.assembly, motion)
    facts = _facts(settlement)
    return Scene(moved, Contacts.empty(), (stage,), f"drystone: {headline.lower()}", facts)


def moved_assembly(assembly: Assembly, motion: Floats) -> Assembly:
    """The blocks after a motion (n, 6) [m, rad]: translation, and rotation about the centroid."""
    blocks = []
    for block, at, move in zip(assembly.blocks, assembly.centroid, motion, strict=True):
        angle = float(np.linalg.norm(move[3:]))
        turn = rotation_about(move[3:], float(np.rad2deg(angle))) if angle > 0.0 else np.eye(3)
        blocks.append(block.transformed(turn, at + move[:3] - turn @ at))
    return Assembly(tuple(blocks), assembly.fixed)


def followed_scene(settlement: Settlement) -> Scene:
    """A scene that plays the motion of the blocks; a stage for each carrier of the ends of joints.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import arch
    >>> settled = drystone.settle(drystone.Model.of(arch(0.2, 6), friction=0.7))
    >>> {stage.headline for stage in followed_scene(settled).stages}
    {'Comes to rest'}
    """
    model = settlement.model
    stages = tuple(_followed(settlement, one) for one in settlement.paths)
    facts = Asked.of(model).facts()
    title = f"drystone: {settlement.outcome.value}"
    return Scene(model.assembly, model.contacts, stages, title, facts)


def _followed(settlement: Settlement, path: SettlementPath) -> SceneStage:
    carried = f"ends of joints on the {path.carrier.value} block"
    several = len(settlement.paths) > 1
    differ = settlement.outcome is Outcome.ENDS_DECIDE
    model, last = path.model, path.displacement
    assembly = model.assembly
    state = state_of(assembly)
    falls = path.outcome in (Outcome.FALLS, Outcome.DISPLACED)
    if falls:
        state[list(path.moving)] = State.FALLING
    moved = float(block_speed(assembly, last).max(initial=0.0))
    seen = PLAYED * float(np.median(assembly.size))
    factor = max(seen / moved, 1.0) if moved > 0.0 else 1.0
    many = len(path.positions)
    kept = max(2, min(many, MOST_STATES, MOST_POSITIONS // max(len(assembly), 1)))
    states = path.positions[np.unique(np.linspace(0, many - 1, kept).round().astype(int))]
    told = f"the largest displacement of a corner is {moved:.3g} m"
    if factor > 1.0:
        told += f", drawn {factor:.3g} times as long"
    up, gravity = directions(assembly, model.load)
    verdict = {Outcome.RESTS: Verdict.STABLE, Outcome.FALLS: Verdict.UNSTABLE}
    name = path.outcome.value
    headline = f"Undecided: {name} with the {carried}" if differ else name[0].upper() + name[1:]
    return SceneStage(
        carried if several else "settlement",
        headline,
        f"{settlement.message}; {told}",
        state,
        Verdict.UNDECIDED if differ else verdict.get(path.outcome, Verdict.UNDECIDED),
        motion=factor * last if moved > 0.0 else None,
        path=factor * states if moved > 0.0 and len(states) > 1 else None,
        motion_name="Settlement" if factor == 1.0 else "Settlement, enlarged",
        plays=falls,
        up=up,
        gravity=gravity,
        layers=interface_layers(model.contacts),
    )


def _facts(settlement: SupportResponse) -> Mapping[str, str]:
    model = settlement.result.model
    facts = Asked.of(model).facts()
    motion = model.load.motion
    moved = [] if motion is None else np.flatnonzero(motion.any(axis=1)).tolist()
    names = ", ".join(model.assembly.names[i] for i in moved)
    return {**facts, "Supports that move": f"{names}, by at most {settlement.size:.3g} m"}


def _headline(settlement: SupportResponse) -> str:
    count = len(settlement.open_joints())
    return f"Settled: {count} joint{'' if count == 1 else 's'} open{'s' if count == 1 else ''}"


def _enlarged(assembly: Assembly, motion: Floats) -> tuple[Floats, float]:
    """The motion (n, 6) in pictures, and the factor by which it is enlarged."""
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
