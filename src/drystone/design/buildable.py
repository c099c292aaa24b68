"""A shell whose blocks need the least help while it is built: what is asked for, what is found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from drystone.base.arrays import number
from drystone.base.display import OneLine, shortened
from drystone.base.errors import InputError, counted
from drystone.base.settings import Options
from drystone.contacts import DEFAULT_FRICTION
from drystone.sequence import Plan
from drystone.shells import Layout, Shell
from drystone.shells.wedge import LARGEST_WEDGE

WEDGES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.4)
"""Wedges that are tried, the shallowest first: those of the table of the vault, and one more."""


@dataclass(frozen=True)
class BuildableOptions(Options):
    """Options of :func:`make_buildable`.

    Attributes
    ----------
    wedges
        The wedges that a bed line may have, the shallowest first, all of one sign. See
        :class:`drystone.shells.Layout`.
    friction
        Coefficient of every joint.
    hands
        See :class:`drystone.sequence.Rules`.
    deepened
        Of several layouts, this many are deepened: those that need the least help with the
        shallowest wedges.
    """

    wedges: tuple[float, ...] = WEDGES
    friction: float = DEFAULT_FRICTION
    hands: int = 2
    deepened: int = 3

    def __post_init__(self) -> None:
        super().__post_init__()
        given: Any = self.wedges
        if not isinstance(given, list | tuple):
            raise InputError(
                f"wedges is {shortened(repr(given), 60)}", remedy="give numbers, the least first"
            )
        object.__setattr__(self, "wedges", tuple(number(one, "a wedge") for one in given))
        sizes = [abs(one) for one in self.wedges]
        rising = all(a < b for a, b in pairwise(sizes))
        one_sign = min(self.wedges, default=0.0) >= 0.0 or max(self.wedges) <= 0.0
        if not sizes or not rising or not one_sign or sizes[-1] > LARGEST_WEDGE:
            raise InputError(
                f"the wedges are {', '.join(f'{one:g}' for one in self.wedges) or 'none'}",
                remedy="give them of one sign, the shallowest first, each deeper than the last, "
                f"up to {LARGEST_WEDGE}",
            )
        self._refuse_below(1, "hands", "deepened")


@dataclass(frozen=True)
class BuildNeeds(OneLine):
    """The help that a shell needs while it is built course by course.

    Attributes
    ----------
    propped, held
        Numbers of blocks.
    """

    propped: int
    held: int

    def _summary(self) -> str:
        return f"{self.propped} propped, {self.held} held"

    @property
    def cost(self) -> tuple[int, int]:
        """Fewest props first, then fewest held blocks."""
        return self.propped, self.held


@dataclass(frozen=True)
class TriedLayout(OneLine):
    """A layout that was tried.

    Attributes
    ----------
    layout
    voussoirs
    shallow
        The help that is needed with the shallowest wedges; ``None`` where it cannot be built.
    deepened
        The same with the wedges that were found; ``None`` where they were not searched for.
    message
        Why it cannot be built.
    """

    layout: Layout
    voussoirs: int
    shallow: BuildNeeds | None
    deepened: BuildNeeds | None = None
    message: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""

        def told(needs: BuildNeeds | None) -> dict[str, int] | None:
            return None if needs is None else {"propped": needs.propped, "held": needs.held}

        return {
            "courses": self.layout.courses,
            "blocks": self.layout.blocks,
            "width": self.layout.width,
            "staggered": self.layout.staggered,
            "voussoirs": self.voussoirs,
            "shallow": told(self.shallow),
            "deepened": told(self.deepened),
            "message": self.message,
        }


@dataclass(frozen=True, eq=False)
class Buildable(OneLine):
    """A shell with the wedges with which its blocks need the least help.

    Attributes
    ----------
    shell
    plan
        Of the whole shell, course by course.
    layout
        With ``wedge``, one for each bed line between two courses.
    needs
        The help that the plan needs.
    before
        The help that the same layout needs with the shallowest wedges.
    tried
        All layouts.
    message
    """

    shell: Shell
    plan: Plan
    layout: Layout
    needs: BuildNeeds
    before: BuildNeeds
    tried: tuple[TriedLayout, ...]
    message: str

    def _summary(self) -> str:
        return self.message

    @property
    def wedges(self) -> tuple[float, ...]:
        """Of the bed lines between two courses, from the springing."""
        wedge: Any = self.layout.wedge
        return tuple(float(one) for one in wedge)

    def deepened(self, shallow: float) -> tuple[int, ...]:
        """The courses whose lower bed line has a deeper wedge than this."""
        return tuple(i + 1 for i, one in enumerate(self.wedges) if abs(one) > abs(shallow))

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "message": self.message,
            "propped": self.needs.propped,
            "held": self.needs.held,
            "before": {"propped": self.before.propped, "held": self.before.held},
            "voussoirs": len(self.shell.voussoirs),
            "wedges": list(self.wedges),
            "tried": [one.to_dict() for one in self.tried],
        }


def message_of(needs: BuildNeeds, before: BuildNeeds, deeper: Sequence[int], late: bool) -> str:
    """What was found, as a sentence."""
    if needs.cost == (0, 0):
        words = "every block stands when it is placed"
    else:
        words = f"{counted(needs.propped, 'block')} propped, {needs.held} held"
    if deeper:
        courses = ", ".join(str(one) for one in deeper)
        plural = "s" if len(deeper) > 1 else ""
        words += f", with deeper wedges below course{plural} {courses}"
    words += f"; {before.propped} propped and {before.held} held with the shallowest wedges"
    return words + ("; it was stopped before all was tried" if late else "")
