"""The checks of a step of a plan, and of what it would be without its help."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from drystone.base.arrays import Floats
from drystone.base.display import named
from drystone.sequence.evaluation import Evaluator
from drystone.sequence.plan_steps import Step
from drystone.sequence.stages import Stage, StageAnswer, mask_of


def checked_step(
    evaluator: Evaluator,
    before: int,
    blocks: tuple[int, ...],
    motion: Floats,
    standing: int,
    props: tuple[int, ...],
    near: tuple[int, int] | None = None,
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
    near
        Blocks in place and held blocks of a similar stage that was checked.
    """
    sure = partial(evaluator.answer, forces=True, checked=evaluator.model.small)
    after = Stage(before | mask_of(blocks), mask_of(props), False, near)
    answer = sure(after)
    during = []
    placed, propped = before, standing | mask_of(props)
    for number, block in enumerate(blocks[:-1]):
        placed |= 1 << block
        held = mask_of(blocks[: number + 1]) | propped & placed
        stage = Stage(placed, held, False, (after.placed, after.held))
        during.append(sure(stage))
    return Step(blocks, motion, props, after.placed, answer, tuple(during))


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
    alone, near = [], (step.placed, props)
    if len(step.blocks) > 1:
        first = step.placed & ~mask_of(step.blocks[1:])
        alone.append(Stage(first, (props | standing) & first, False, near))
    if props & ~standing:
        alone.append(Stage(step.placed, props & standing, False, near))
    found = (evaluator.answer(stage) for stage in alone)
    names = evaluator.model.assembly.names
    told = [falling_words(one, names) + one.message for one in found if not one.stands]
    return "without help: " + "; then ".join(told) if told else ""


def falling_words(answer: StageAnswer, names: Sequence[str]) -> str:
    """The blocks that fall, followed by a semicolon; empty if unknown."""
    falling = [names[block] for block in answer.falling]
    verb = "falls" if len(falling) == 1 else "fall"
    return f"{named(falling)} {verb}; " if falling else ""
