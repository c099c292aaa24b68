"""Shells by the name of their surface."""

from __future__ import annotations

from collections.abc import Callable

from drystone.base.errors import InputError
from drystone.shells.formfinding import find_form
from drystone.shells.patch import Shape
from drystone.shells.shell_families import (
    barrel_vault,
    cross_vault,
    dome,
    pavilion_vault,
    rectangular_plan,
    three_vault_plan,
    tri_dome,
)
from drystone.shells.shell_of_blocks import Shell, build_shell
from drystone.shells.shell_options import Ground, Intrados, JointForm, Layout, ShellBody

SPAN, EYE = 6.0, 1.0
"""[m] Where none is given."""

COURSES = 12
"""Courses where neither their number nor their height is given."""

SHARE = 8.0
"""The width of blocks is the span divided by this where none is given."""


def usual_width(kind: str, span: float = SPAN) -> float:
    """[m], an eighth of the span; from foot to foot of three vaults it is about twice as far."""
    return (2.0 if kind == "three-vaults" else 1.0) * span / SHARE


def usual_courses(kind: str) -> int:
    """12, or 8 of three vaults, whose courses are arches of many blocks."""
    return 8 if kind == "three-vaults" else COURSES


SURFACES = ("barrel", "cross", "pavilion", "dome", "free-edge", "three-vaults", "tri-dome")
"""Surfaces that are known by name."""


def shape_by_name(
    kind: str,
    *,
    span: float = SPAN,
    length: float | None = None,
    rise: float | None = None,
    eye: float = EYE,
    keystone: bool = False,
    thickness: float | None = None,
) -> tuple[Shape, tuple[str, ...]]:
    """A surface by its name, and notes on how it was found.

    Parameters
    ----------
    kind
    span : [m]
        Or diameter.
    length : [m]
        Of a barrel, depth of a free-edge plan.
    rise : [m]
        Of a barrel or a tri-dome, height of a form that is found.
    eye : [m]
        Diameter of the opening of a dome, tri-dome or pavilion vault.
    keystone
        Close the opening with one block.
    thickness : [m]
        With which a form is found.
    """
    known: dict[str, Callable[[], Shape]] = {
        "barrel": lambda: barrel_vault(span, span if length is None else length, rise),
        "cross": lambda: cross_vault(span),
        "pavilion": lambda: pavilion_vault(span, eye, keystone=keystone),
        "dome": lambda: dome(0.5 * span, 0.5 * eye, keystone=keystone),
        "tri-dome": lambda: tri_dome(
            span, 0.5 * span if rise is None else rise, eye, keystone=keystone
        ),
    }
    if kind in known:
        return known[kind](), ()
    if kind == "free-edge":
        plan = rectangular_plan(span, span * 5.0 / 6.0 if length is None else length)
    else:
        plan = three_vault_plan(span, span * 2.5 / 6.0, span * 0.4)
    form = find_form(plan, height=0.3 * span if rise is None else rise, thickness=thickness)
    return form.shape, (f"form found in {form.rounds} rounds, {form.height:.3f} m high",)


def shell_by_name(
    surface: str,
    span: float = SPAN,
    length: float | None = None,
    rise: float | None = None,
    thickness: float | None = None,
    eye: float = EYE,
    keystone: bool = False,
    courses: int | None = None,
    blocks: int | None = None,
    width: float | None = None,
    wedge: float | None = None,
    joggle: float = 0.0,
    joints: JointForm = JointForm.PLANE,
    straight: bool = False,
    ground: Ground = Ground.SPRINGERS,
) -> Shell:
    """A shell of blocks on a surface that is known by name.

    Parameters
    ----------
    surface
        barrel, cross, pavilion, dome, free-edge, three-vaults or tri-dome.
    span : [m] > 0
        Span or diameter.
    length : [m] > 0
        Of a barrel, or depth of a free-edge plan.
    rise : [m] > 0
        Of a barrel or a tri-dome, or height of a form that is found.
    thickness : [m]
        Half of it is on each side of the surface; when left out it is 0.075 of the span of a
        barrel, else 1/30 of the size.
    eye : [m] > 0
        Diameter of the opening at the crown.
    keystone
        Close the opening with one block.
    courses
        Number of courses (12; legs have fewer).
    blocks
        Blocks in each course.
    width : [m]
        Of the blocks, in place of their number; when left out it is an eighth of the span, a
        quarter for three vaults.
    wedge
        See :class:`drystone.shells.Layout`. When left out 0, or what planar inner faces need.
    joggle : [degrees]
        Slope of hooks in bed joints, 10 to 25 or -25 to -10, 0 for none.
    joints
        Make each joint plane, or keep a warped one as two triangles, faceted.
    straight
        Make the inner face of every block planar.
    ground
        What is fixed: the springers themselves, or blocks added under them.

    Raises
    ------
    InputError
        The surface is not known, or the blocks cannot be built.

    Examples
    --------
    >>> shell_by_name("barrel", courses=6, blocks=4, thickness=0.4)
    Shell('barrel vault', 27 voussoirs, Assembly(27 blocks, 9 fixed))
    """
    if surface not in SURFACES:
        raise InputError(f"surface '{surface}' is not known", remedy=f"use {', '.join(SURFACES)}")
    shape, _ = shape_by_name(
        surface,
        span=span,
        length=length,
        rise=rise,
        eye=eye,
        keystone=keystone,
        thickness=thickness,
    )
    layout = Layout(
        courses=usual_courses(surface) if courses is None else courses,
        blocks=blocks,
        width=usual_width(surface, span) if blocks is None and width is None else width,
        wedge=0.0 if wedge is None and not straight else wedge,
    )
    body = ShellBody(
        thickness=thickness,
        joggle_deg=joggle,
        intrados=Intrados.STRAIGHT if straight else Intrados.OFFSET,
        joints=joints,
        ground=ground,
    )
    return build_shell(shape, layout, body)
