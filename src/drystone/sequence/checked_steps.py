"""Steps of a plan, with the answers of their stages, and the reason of their help."""

from __future__ import annotations

from collections.abc import Sequence

from drystone.base.arrays import Floats
from drystone.sequence.plans import Step
from drystone.sequence.stage.evaluation import Evaluator
from drystone.sequence.stage.stages import Answer, Stage, mask_of

CHECKED = 500
"""Largest number of corners of a model with which screened stages of a plan are also checked, and
with which the complete structure may stand after settling."""
LISTED = 6
"""Number of falling blocks named in a message."""


def checked_step(
    evaluator: Evaluator,
    before: int,
    blocks: tuple[int, ...],
    motion: Floats,
    standing: int,
    props: tuple[int, ...],
) -> Step:
    """A step, with the answers of its stages.

    Parameters
    ----------
    evaluator
    before
        Blocks in place before it, as bits.
    blocks
        In the order of placement.
    motion : (b, 3) unit
    standing
        Blocks that are propped before it, as bits.
    props
        Blocks that are propped after it.
    """
    checked = evaluator.model.contacts.corner_count <= CHECKED
    during = []
    placed, propped = before, standing | mask_of(props)
    for number, block in enumerate(blocks[:-1]):
        placed |= 1 << block
        stage = Stage(placed, mask_of(blocks[: number + 1]) | propped & placed)
        during.append(evaluator.answer(stage, forces=True, checked=checked))
    placed = before | mask_of(blocks)
    answer = evaluator.answer(Stage(placed, mask_of(props)), forces=True, checked=checked)
    return Step(blocks, motion, props, placed, answer, tuple(during))


def without_help(evaluator: Evaluator, step: Step, standing: int) -> str:
    """The result of a step without its hands and without its new props, as text.

    Parameters
    ----------
    evaluator
    step
    standing
        Blocks that are propped before it, as bits.
    """
    props = mask_of(step.props)
    alone = []
    if len(step.blocks) > 1:
        first = step.placed & ~mask_of(step.blocks[1:])
        alone.append(Stage(first, (props | standing) & first))
    if props & ~standing:
        alone.append(Stage(step.placed, props & standing))
    found = (evaluator.answer(stage) for stage in alone)
    names = evaluator.model.assembly.names
    return "; ".join(
        "without help: " + falling_words(one, names) + one.message
        for one in found
        if not one.stands
    )


def falling_words(answer: Answer, names: Sequence[str]) -> str:
    """The blocks that fall, followed by a semicolon; empty if unknown."""
    falling = answer.falling
    if not falling:
        return ""
    if len(falling) == 1:
        return f"{names[falling[0]]} falls; "
    more = f" and {len(falling) - LISTED} more" if len(falling) > LISTED else ""
    return f"{', '.join(names[b] for b in falling[:LISTED])}{more} fall; "


__all__ = ["CHECKED", "checked_step", "falling_words", "without_help"]
