"""``drystone shell --buildable``: the layouts that are tried, the search, and what it tells."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from drystone.base.errors import InputError
from drystone.cli.shell_pattern import ShellPattern
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from drystone.design import Buildable
    from drystone.shells import Layout, Shape, ShellBody

_SIZES = (1.0, 0.75, 1.25)
"""Courses and widths that are tried, by those that are used otherwise. Chosen."""


def _layouts_to_try(layout: Layout, pattern: ShellPattern) -> list[Layout]:
    """The layout as it is, others of other sizes, and the first one without stagger."""
    courses = _SIZES if pattern.any_courses else (1.0,)
    widths = _SIZES if pattern.any_width else (1.0,)
    found = []
    for share in courses:
        for width in widths:
            one = layout
            if pattern.any_courses and layout.courses is not None:
                one = replace(one, courses=round(share * layout.courses))
            if pattern.any_width and layout.width is not None:
                one = replace(one, width=width * layout.width)
            found.append(one)
    return [*found, replace(layout, staggered=False)]


def find_buildable(
    shape: Shape,
    layout: Layout,
    body: ShellBody,
    pattern: ShellPattern,
    friction: float | None,
    waiting: Waiting,
    time_limit: float | None,
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
    sign = -1.0 if least < 0.0 else 1.0
    wedges = (least, *(sign * one for one in WEDGES if one > abs(least)))
    given: dict[str, Any] = {} if friction is None else {"friction": friction}
    waiting.stage("build", "searching what can be built")
    with waiting.keywords(time_limit) as common:
        try:
            return design.make_buildable(
                shape,
                _layouts_to_try(layout, pattern),
                body,
                options=design.BuildableOptions(wedges=wedges, **given),
                **common,
            )
        except InputError:
            if waiting.interrupted:  # before the first plan
                raise KeyboardInterrupt from None
            raise
