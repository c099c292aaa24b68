"""The pattern and the blocks that ``drystone shell`` asks for, and the layouts it searches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

from drystone.base.errors import InputError
from drystone.cli import kinds
from drystone.cli.offered import Analysis, Of, Option
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.design import Buildable
    from drystone.shells import Layout, Shape, ShellBody


def _wedges(text: str) -> tuple[float, ...]:
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"is '{text}'", remedy="give numbers separated by commas") from error
    if not all(map(math.isfinite, found)):
        raise InputError(f"is {text}", remedy="give finite numbers")
    return found


@dataclass(frozen=True)
class ShellPattern:
    """How a surface is divided, and what its blocks are like."""

    blocks: Annotated[
        Analysis,
        Of(
            "drystone.shells.shell_by_name",
            ("courses", "blocks", "width", "joggle", "ground", "joints", "straight"),
            shown=("courses", "blocks", "width"),
        ),
    ]
    wedge: Annotated[
        tuple[float, ...] | None,
        Option(
            "Shift of bed joints, by the height of a course: -0.45 to 0.45 (0; with --straight "
            "what the curvatures ask for). One value, or one for each bed line between courses.",
            kind=kinds.OptionKind("WEDGE[,WEDGE...]", _wedges),
            expert=True,
        ),
    ] = None

    @property
    def any_courses(self) -> bool:
        """Whether the number of courses is not given."""
        return "courses" not in self.blocks.given

    @property
    def any_width(self) -> bool:
        """Whether neither the number nor the width of blocks is given."""
        return not {"blocks", "width"} & {*self.blocks.given}

    @property
    def straight(self) -> bool:
        """Whether inner faces are planar."""
        return self.blocks.given.get("straight", False)

    def refuse_two_ways(self) -> None:
        """Raise InputError where two options say the same thing."""
        if {"blocks", "width"} <= {*self.blocks.given}:
            raise InputError(
                "say the same thing", where="--blocks and --width", remedy="give one of them"
            )

    def layout(self, width: float, courses: int) -> Layout:
        """The division, with the width of blocks [m] and the courses where none are given."""
        from drystone.shells import Layout

        wedge, given = self.wedge, self.blocks.given
        shift = wedge[0] if wedge is not None and len(wedge) == 1 else wedge
        return Layout(
            courses=given.get("courses", courses),
            blocks=given.get("blocks"),
            width=width if self.any_width else given.get("width"),
            wedge=0.0 if wedge is None and not self.straight else shift,
        )

    def body(self, thickness: float | None) -> ShellBody:
        """What blocks of a thickness [m] are like."""
        from drystone.shells import Ground, Intrados, JointForm, ShellBody

        given = self.blocks.given
        return ShellBody(
            thickness=thickness,
            joggle_deg=given.get("joggle", 0.0),
            intrados=Intrados.STRAIGHT if self.straight else Intrados.OFFSET,
            joints=given.get("joints", JointForm.PLANE),
            ground=given.get("ground", Ground.SPRINGERS),
        )


_COURSES, _WIDTHS = (0.5, 0.75, 1.0), (1.6, 1.3, 1.0)
"""Courses and widths that are tried, by those that are used otherwise. Chosen."""


def _layouts_to_try(layout: Layout, pattern: ShellPattern) -> list[Layout]:
    """Layouts of several sizes, that with the fewest blocks first, and it without stagger."""
    found = []
    for share in _COURSES if pattern.any_courses else (1.0,):
        for width in _WIDTHS if pattern.any_width else (1.0,):
            one = layout
            if layout.courses is not None:
                one = replace(one, courses=round(share * layout.courses))
            if pattern.any_width and layout.width is not None:
                one = replace(one, width=width * layout.width)
            found.append(one)
    return [*found, replace(found[0], staggered=False)]


def find_buildable(
    shape: Shape,
    layout: Layout,
    body: ShellBody,
    pattern: ShellPattern,
    joints: Mapping[str, Any],
    waiting: Waiting,
    time_limit: float | None,
    workers: int | str,
) -> Buildable:
    """What needs the least help of a shell while it is built.

    Raises
    ------
    InputError
        Options contradict each other, or no layout can be built.
    """
    if pattern.straight:
        raise InputError(
            "ask for different wedges",
            where="--buildable and --straight",
            remedy="give one of them",
        )
    if pattern.wedge is not None and len(pattern.wedge) > 1:
        raise InputError(
            "searches a wedge for each course", where="--buildable",
            remedy="give --wedge one value, the shallowest",
        )  # fmt: skip
    from drystone import design  # work is imported when there is some
    from drystone.design.buildable import WEDGES

    least = WEDGES[0] if pattern.wedge is None else pattern.wedge[0]
    wedges = (least, *(one for one in WEDGES if abs(one) > abs(least)))
    waiting.stage("build", "searching what can be built")
    with waiting.keywords(time_limit, workers) as common:
        try:
            return design.make_buildable(
                shape,
                _layouts_to_try(layout, pattern),
                body,
                options=design.BuildableOptions(wedges=wedges, **joints),
                **common,
            )
        except InputError:
            if waiting.interrupted:  # before the first plan
                raise KeyboardInterrupt from None
            raise
