"""The words of answers: verdicts, and sentences with what they are for."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from drystone.base.display import OneLine


class Verdict(enum.StrEnum):
    """The answer to "does it stand?". It never guesses."""

    STABLE = "stable"
    """Forces and a compatible motion were found and checked."""
    UNSTABLE = "unstable"
    """It falls, and a checked proof is attached."""
    UNDECIDED = "undecided"
    """Neither was found; the message says what was tried."""
    EQUILIBRIUM_EXISTS = "equilibrium exists"
    """RBE only: some forces balance the loads. Necessary for standing, not sufficient."""


class Role(enum.Enum):
    """What a sentence is for; each has a look."""

    GOOD = "good"
    """The verdict: it stands, it can be done."""
    BAD = "bad"
    """The verdict: it falls, it cannot be done."""
    UNSURE = "unsure"
    """The verdict: not decided."""
    PLAIN = "plain"
    """Anything else."""
    REMARK = "remark"
    """Something to bear in mind."""

    @classmethod
    def of(cls, verdict: Verdict) -> Role:
        """The role of a sentence with a verdict."""
        return {Verdict.STABLE: cls.GOOD, Verdict.UNSTABLE: cls.BAD}.get(verdict, cls.UNSURE)


@dataclass(frozen=True)
class Sentence(OneLine):
    """A sentence of an answer.

    Attributes
    ----------
    text
    role
    """

    text: str
    role: Role = Role.PLAIN
