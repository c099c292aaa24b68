"""The help that a plan needs, and the answer of a search for less of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.design.changed import Kept, table_of
from drystone.model import Model
from drystone.sequence import Plan
from drystone.shells import Layout


class Help(NamedTuple):
    """The help that a plan needs, in order of what is less: fewer props, then fewer held blocks.

    Attributes
    ----------
    unplanned
        Whether there is no plan.
    impossible, propped, held
        Numbers of blocks; the first ones cannot be put in.
    together
        Number of blocks that are placed at once with another one.
    """

    unplanned: bool
    impossible: int
    propped: int
    held: int
    together: int

    @property
    def blocks(self) -> int:
        """Number of blocks that need help: propped, held or not to be put in."""
        return self.impossible + self.propped + self.held

    @classmethod
    def of(cls, found: Plan) -> Help:
        """What a plan needs."""
        return cls(not found.steps, len(found.impossible), *found.help)

    def __str__(self) -> str:
        if not any(self):
            return "every block stands when it is placed"
        some = counted(self.propped + self.impossible, "block")
        return f"{some} propped, {self.held} held"


def helped(found: Plan) -> Iterator[tuple[int, tuple[int, ...], str]]:
    """Blocks that need help, the first placed first, with the props beside them, and why."""
    for block, why in found.impossible.items():
        yield block, (), why
    done: set[int] = set()
    for step in found.steps:
        together = step.blocks if len(step.blocks) > 1 else ()
        for block in (*together, *step.props):
            if block not in done:
                done.add(block)
                yield block, tuple(b for b in step.props if b != block), step.why or "it is propped"


@dataclass(frozen=True, eq=False)
class Buildable(Answer):
    """A structure that was changed until it is built with less help, and its plan.

    Attributes
    ----------
    model
        With the changes.
    plan
        ``None`` where there is none.
    changes
        Those that were kept, in their order.
    log
        How it came about, one sentence each.
    tried
        Number of changes that were tried.
    before
        The help that was needed without the changes, where that is known.
    layout
        Of a shell, with a wedge for each bed line between two courses, from the springing.
    """

    model: Model
    plan: Plan | None
    changes: tuple[Kept, ...]
    log: tuple[str, ...]
    tried: int = 0
    before: Help | None = None
    layout: Layout | None = None

    def _summary(self) -> str:
        return self.message

    @property
    def help(self) -> Help | None:
        """What the plan needs."""
        return None if self.plan is None else Help.of(self.plan)

    @property
    def free(self) -> bool:
        """Whether every block is placed alone and stands at once."""
        return self.help is not None and not any(self.help)

    @property
    def message(self) -> str:
        """How it ended."""
        return self.log[-1]

    @property
    def title(self) -> str:
        """How it ended."""
        return self.message[0].upper() + self.message[1:]

    def sentences(self) -> Sequence[Sentence]:
        """Whether every block is free, how it ended, and how it came about."""
        role = Role.GOOD if self.free else Role.BAD
        told = (self.message, *self.log[:-1])
        return [Sentence("FREE" if self.free else "NOT FREE", role), *map(Sentence, told)]

    def tables(self) -> Sequence[Table]:
        """The changes that were kept."""
        return [table_of(self.changes)]

    def layers(self) -> Scene:
        """The plan."""
        if self.plan is None:
            raise InputError("there is no picture: there is no plan", remedy="try other changes")
        return self.plan.layers()

    def numbers(self) -> Mapping[str, Any]:
        """Whether every block is free, how it came about, and the plan."""
        return {
            "free": self.free,
            "message": self.message,
            "log": self.log,
            "tried": self.tried,
            "help": self.help and self.help._asdict(),
            "before": self.before and self.before._asdict(),
            "wedges": self.layout and self.layout.wedge,
            "plan": None if self.plan is None else self.plan.numbers(),
        }
