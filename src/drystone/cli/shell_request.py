"""What ``drystone shell`` asks for: a surface, its pattern and its blocks, and what it searches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from drystone.base.errors import InputError
from drystone.cli import kinds
from drystone.cli.offered import MODEL, Analysis, Argument, Of, Option
from drystone.cli.waiting import Waiting

if TYPE_CHECKING:
    from collections.abc import Sequence

    from drystone.base.arrays import Floats
    from drystone.design import Buildable
    from drystone.shells import Layout, Patch, Shape, ShellBody, Side

_FOOT = 0.02
"""A side of a mesh is taken for its foot where none of it is higher above the lowest point, by the
size of the mesh, chosen."""


SIZES = ("span", "length", "rise", "thickness", "eye", "keystone")
"""Keywords of a shell by name that its surface has."""
_USED = {
    "barrel": {"--span", "--length", "--rise"},
    "cross": {"--span"},
    "pavilion": {"--span", "--eye", "--keystone"},
    "dome": {"--span", "--eye", "--keystone"},
    "free-edge": {"--span", "--length", "--rise"},
    "three-vaults": {"--span", "--rise"},
    "tri-dome": {"--span", "--rise", "--eye", "--keystone"},
    None: {"--supports", "--corners", "--units", "--up"},
}
"""Options of the surface that each kind has; None is a mesh file."""


def _vertices(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"is '{text}'", remedy="give numbers of vertices, from 0") from error


@dataclass(frozen=True)
class SurfaceRequest:
    """The surface that is asked for, and its size."""

    surface: Annotated[
        str,
        Argument(
            "SURFACE",
            "barrel, cross, pavilion, dome or tri-dome; free-edge or three-vaults, whose form is "
            "found; or an open mesh file.",
        ),
    ]
    supports: Annotated[
        str | None,
        Option(
            "Sides that a mesh stands on: bottom, top, left, right; separated by commas (the "
            "bottom and those that rise no higher).",
            MODEL,
            expert=True,
        ),
    ] = None
    corners: Annotated[
        tuple[int, ...] | None,
        Option(
            "Vertices of a mesh, from 0, that are its corners, in their order along its border: "
            "bottom left, bottom right, top right, top left; or the two ends of each support of a "
            "mesh of several legs (those of its lower sides).",
            MODEL,
            kind=kinds.OptionKind("NUMBER[,NUMBER...]", _vertices),
            expert=True,
        ),
    ] = None
    units: Annotated[
        str | None, Option("Unit of length of a mesh file (m).", MODEL, kind=kinds.UNIT,
                           expert=True)
    ] = None  # fmt: skip
    up: Annotated[
        Literal["z", "y"] | None,
        Option("Axis that points up in a mesh file (y in GLB, else z).", MODEL, expert=True),
    ] = None
    size: Annotated[
        Analysis,
        Of(
            "drystone.shells.shell_by_name",
            SIZES,
            shown=("span", "rise", "thickness"),
            group=MODEL,
        ),
    ] = None  # type: ignore[assignment]  # made by the command

    @property
    def sizes(self) -> Mapping[str, Any]:
        """The size that was given, by keywords of :func:`drystone.shells.shell_by_name`."""
        return {} if self.size is None else self.size.given


@dataclass(frozen=True)
class Surface:
    """The surface, and how it was made.

    Attributes
    ----------
    shape
    width : [m]
        Of its blocks where none is given: an eighth of its span, or of a way from foot to foot.
    courses
        Where none are given. Of the vaults of a mesh: so that blocks are twice as wide as high.
    notes
    """

    shape: Shape
    width: float
    courses: int
    notes: tuple[str, ...]


def surface_of(wanted: SurfaceRequest) -> Surface:
    """The surface asked for.

    Raises
    ------
    InputError
        A surface that is not known, or an option that it does not have.
    """
    from drystone.shells.shell_families import (
        SPAN,
        SURFACES,
        shape_by_name,
        usual_courses,
        usual_width,
    )

    kind = wanted.surface if wanted.surface in SURFACES else None
    if kind is None and not Path(wanted.surface).suffix:
        raise InputError(
            f"surface '{wanted.surface}' is not known",
            remedy=f"use {', '.join(SURFACES)} or a mesh file",
        )
    refuse_unused(wanted)
    if kind is None:
        return _from_mesh(wanted)
    span = wanted.sizes.get("span", SPAN)
    shape, notes = shape_by_name(kind, **wanted.sizes)
    return Surface(shape, usual_width(kind, span), usual_courses(kind), notes)


def refuse_unused(wanted: SurfaceRequest) -> None:
    """Raise InputError where an option is given that the surface does not have."""
    kind = wanted.surface if wanted.surface in _USED else None
    own = {name: getattr(wanted, name) for name in ("supports", "corners", "units", "up")}
    for name, value in {**wanted.sizes, **own}.items():
        _refuse(f"--{name}", name != "thickness" and value not in (None, False), kind)


def _refuse(option: str, given: bool, kind: str | None) -> None:
    if not given or option in _USED[kind]:
        return
    users = [one or "mesh files" for one, used in _USED.items() if option in used]
    what = "a mesh file" if kind is None else f"'{kind}'"
    raise InputError(f"is for {', '.join(users)}", where=option, remedy=f"leave it out for {what}")


def _from_mesh(wanted: SurfaceRequest) -> Surface:
    from drystone import shells
    from drystone.shells.shell_families import COURSES
    from drystone.shells.sources import surface_in_file

    points, faces, unit = surface_in_file(wanted.surface, wanted.units, wanted.up)
    name, supports, corners = Path(wanted.surface).name, wanted.supports, wanted.corners
    vaults = (supports is None or len(corners or ()) > 4) and shells.several_supports(
        points, faces, corners=corners
    )
    if vaults:
        return _sized(_vaults(wanted, points, faces), wanted, unit)
    fit = shells.patch_from_mesh(points, faces, corners=corners, name=name)
    notes = [f"the mesh is up to {1e3 * fit.deviation_max:.3g} mm from the patch fitted"]
    if supports is None:
        sides = _foot(fit.patch)
        names = ", ".join(side.value for side in sides)
        low = "its lowest sides" if len(sides) > 1 else "one side alone, its lowest"
        told = f"stands on {low} ({names}: names, not heights), assumed"
        notes.append(f"{told}: --supports names others")
    else:
        sides = [_side(text) for text in supports.split(",")]
    edges = tuple(shells.Edge(0, side) for side in sides)
    shape = shells.Shape((fit.patch,), (), edges, name=fit.patch.name)
    return _sized(Surface(shape, _width(fit.patch), COURSES, tuple(notes)), wanted, unit)


def _sized(made: Surface, wanted: SurfaceRequest, unit: str | None) -> Surface:
    """The surface, with a remark where its size is improbable."""
    from drystone.io.build import doubtful_size
    from drystone.shells import ShellBody, shape_volume
    from drystone.shells.shell_families import COURSES

    extent = max(patch.size for patch in made.shape.patches)
    thick = wanted.sizes.get("thickness", made.shape.default_thickness)
    weight = ShellBody().density * shape_volume(made.shape, thick)
    what = f"the surface is {extent:.3g} m across, and a shell {thick:.3g} m thick on it weighs"
    doubt = doubtful_size(what, extent, extent / COURSES, weight, unit)
    return replace(made, notes=(*made.notes, *doubt))


def _vaults(wanted: SurfaceRequest, points: Floats, faces: Sequence[Sequence[int]]) -> Surface:
    from drystone import shells

    if wanted.supports is not None:
        raise InputError(
            "names sides of a patch with four corners",
            where="--supports",
            remedy="leave it out, or name four --corners",
        )
    shape, farthest = shells.vaults_from_mesh(
        points, faces, corners=wanted.corners, name=Path(wanted.surface).name
    )
    told = (
        f"{len(shape.patches)} vaults from support to support, one at each open side",
        f"the vertices of the mesh are up to {1e3 * farthest:.3g} mm from them",
    )
    width, across = _width(*shape.patches), np.linspace(0.0, 1.0, 129)
    depth = min(_length(patch.point(across, 0.5)) for patch in shape.patches)
    return Surface(shape, width, max(2, round(2.0 * depth / width)), told)


def _foot(patch: Patch) -> list[Side]:
    """The bottom, and the other sides that rise no higher."""
    from drystone.shells import Side

    along = np.linspace(0.0, 1.0, 33)
    top = {side: float(patch.border(side, along)[:, 2].max()) for side in Side}
    return [side for side in Side if top[side] <= top[Side.BOTTOM] + _FOOT * patch.size]


def _width(*patches: Patch) -> float:
    """[m], an eighth of the longest bottom or top."""
    from drystone.shells import Side

    along = np.linspace(0.0, 1.0, 129)
    sides = (Side.BOTTOM, Side.TOP)
    return max(_length(patch.border(side, along)) for patch in patches for side in sides) / 8.0


def _length(line: Floats) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def _side(text: str) -> Side:
    from drystone.shells import Side

    known = [side.value for side in Side]
    if text.strip() not in known:
        raise InputError(
            f"'{text}' is not a side", where="--supports", remedy=f"name {', '.join(known)}"
        )
    return Side(text.strip())


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
