"""Shapes with a formula: vaults, domes, flat plans for form finding; and shells by their names."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.errors import InputError
from drystone.shells.formfinding import find_form
from drystone.shells.patch import (
    Edge,
    Patch,
    PatchFunction,
    Seam,
    Shape,
    Side,
)
from drystone.shells.shell_of_blocks import Shell, build_shell
from drystone.shells.shell_options import Ground, Intrados, JointForm, Layout, ShellBody

_VAULT_THICKNESS = 0.075
"""Default thickness of a barrel vault, relative to its span. Chosen: 0.15 of the radius of a
semicircle, which stands from 0.1075 on (Milankovitch 1907). Flatter vaults need less."""


def barrel_vault(span: float = 6.0, length: float = 6.0, rise: float | None = None) -> Shape:
    """A vault over a rectangle: a segment of a cylinder, supported on two sides.

    Parameters
    ----------
    span : [m] > 0
        Along x.
    length : [m] > 0
        Along y.
    rise : [m] > 0
        Half the span when left out: a semicircle.

    Raises
    ------
    InputError
        A length that is not positive, or a rise above half the span.
    """
    rise = 0.5 * span if rise is None else rise
    if rise > 0.5 * span * (1.0 + 1e-12):
        raise InputError(
            f"the rise {rise} m is more than half the span", remedy=f"give {0.5 * span} m or less"
        )
    radius = (0.25 * span**2 + rise**2) / (2.0 * rise)
    half = math.asin(min(0.5 * span / radius, 1.0))
    patch = Patch(partial(_barrel, radius, half, length), name="barrel vault")
    supports = (Edge(0, Side.BOTTOM), Edge(0, Side.TOP))
    return Shape((patch,), (), supports, name="barrel vault", thickness=_VAULT_THICKNESS * span)


def _barrel(radius: float, half: float, length: float, u: Floats, v: Floats) -> Floats:
    """An arc of half an angle [radians] to each side of the crown, along y."""
    angle = half * (2.0 * u - 1.0)
    height = radius * (np.cos(angle) - np.cos(half))
    return np.stack([radius * np.sin(angle), length * v, height], axis=-1)


def dome(
    radius: float = 5.0,
    oculus: float = 1.0,
    springing_deg: float = 0.0,
    *,
    keystone: bool = False,
) -> Shape:
    """Part of a sphere about the z axis, its rings closed along v.

    Parameters
    ----------
    radius : [m] > 0
    oculus : [m] > 0
        Radius of the eye.
    springing_deg : [degrees] >= 0, < 90
        Latitude of the springing: 0 for a hemisphere.
    keystone
        Whether one block closes the eye.

    Raises
    ------
    InputError
        The eye is not smaller than the springing.
    """
    if oculus >= radius * math.cos(math.radians(springing_deg)):
        raise InputError(
            f"an eye of {oculus} m radius is not above a springing at {springing_deg} degrees",
            where="dome",
            remedy="make the eye smaller or the springing lower",
        )
    low, high = math.radians(springing_deg), math.acos(oculus / radius)
    return Shape(
        (Patch(partial(_sphere, radius, low, high), closed=True, name="dome"),),
        supports=(Edge(0, Side.BOTTOM),),
        keystone=(Edge(0, Side.TOP),) if keystone else (),
        name="dome",
    )


def _sphere(radius: float, low: float, high: float, u: Floats, v: Floats) -> Floats:
    """A sphere between two latitudes [radians]."""
    latitude, longitude = low + (high - low) * u, 2.0 * np.pi * v
    ring = radius * np.cos(latitude)
    return np.stack(
        [ring * np.cos(longitude), ring * np.sin(longitude), radius * np.sin(latitude)], axis=-1
    )


def cross_vault(span: float = 6.0, springing_deg: float = 25.0) -> Shape:
    """Two equal semicircular barrels that cross: four webs, groins between them, four corners.

    Parameters
    ----------
    span : [m] > 0
    springing_deg : [degrees] >= 5, <= 60
        Angle at which the webs begin; below it the corner is solid.
    """
    web = partial(_groined, 0.5 * span, math.radians(springing_deg))
    webs = tuple(Patch(partial(_turned, web, k), name=f"web {k}") for k in range(4))
    seams = tuple(
        Seam(Edge(k, Side.LEFT, 1.0, 0.5), Edge((k + 1) % 4, Side.LEFT, 0.0, 0.5)) for k in range(4)
    )
    supports = tuple(Edge(k, side) for k in range(4) for side in (Side.BOTTOM, Side.TOP))
    return Shape(webs, seams, supports, name="cross vault")


def _groined(radius: float, start: float, u: Floats, v: Floats) -> Floats:
    """A web of a cross vault, from its groin to its end, from an angle [radians] upwards."""
    angle = start + (np.pi - 2.0 * start) * u
    across = -radius * np.cos(angle)
    groin = np.abs(across)
    return np.stack([groin + v * (radius - groin), across, radius * np.sin(angle)], axis=-1)


def pavilion_vault(span: float = 6.0, eye: float = 1.0, *, keystone: bool = True) -> Shape:
    """A cloister vault: four barrel webs rising from the sides of a square.

    Parameters
    ----------
    span : [m] > 0
    eye : [m] > 0
        Width of the square opening at the crown.
    keystone
        Whether one block closes the eye.
    """
    if eye >= span:
        raise InputError(f"the eye, {eye} m, is as wide as the span, {span} m")
    web = partial(_cloistered, 0.5 * span, math.acos(eye / span))
    webs = tuple(Patch(partial(_turned, web, k), name=f"web {k}") for k in range(4))
    seams = tuple(Seam(Edge(k, Side.RIGHT), Edge((k + 1) % 4, Side.LEFT)) for k in range(4))
    return Shape(
        webs,
        seams,
        tuple(Edge(k, Side.BOTTOM) for k in range(4)),
        tuple(Edge(k, Side.TOP) for k in range(4)) if keystone else (),
        name="pavilion vault",
    )


def _cloistered(radius: float, high: float, u: Floats, v: Floats) -> Floats:
    """A web of a pavilion vault, from its side up to an angle [radians]."""
    angle = high * u
    reach = radius * np.cos(angle)
    return np.stack([reach, (2.0 * v - 1.0) * reach, radius * np.sin(angle)], axis=-1)


FOOT_DEG, WAIST, EDGE = 18.0, 0.64, 0.6
"""Of a tri-dome: half the angle of a foot, the least distance of the open edges from the axis by
that of the feet, and an exponent of these edges in plan. Chosen for its look."""


def tri_dome(
    span: float = 10.0, rise: float = 5.0, eye: float = 1.0, *, keystone: bool = True
) -> Shape:
    """A dome on three feet: a paraboloid about the z axis with three arched openings.

    Its three parts are alike, and join along seams above the openings. The shape is ours.

    Parameters
    ----------
    span : [m] > 0
        Diameter of the circle through the feet.
    rise : [m] > 0
        Height of the surface at the axis, if it had no eye.
    eye : [m] > 0
        Diameter of the opening at the crown.
    keystone
        Whether one block closes the eye.

    Raises
    ------
    InputError
        A length that is not positive, or an eye as wide as the part without openings.
    """
    reach, rim = 0.5 * span, 0.5 * eye
    waist = WAIST * reach
    if rim >= waist:
        raise InputError(
            f"an eye of {eye:g} m is too wide for a tri-dome over {span:g} m",
            remedy=f"make it narrower than {2.0 * waist:g} m",
        )
    above = (reach - waist) / (reach - rim)
    return Shape(
        tuple(
            Patch(partial(_leg, reach, rim, rise, turn), name=f"leg at {turn:g} degrees")
            for turn in (90.0, 210.0, 330.0)
        ),
        tuple(
            Seam(Edge(k, Side.RIGHT, above, 1.0), Edge((k + 1) % 3, Side.LEFT, above, 1.0))
            for k in range(3)
        ),
        tuple(Edge(k, Side.BOTTOM) for k in range(3)),
        tuple(Edge(k, Side.TOP) for k in range(3)) if keystone else (),
        name="tri-dome",
    )


def _leg(reach: float, rim: float, rise: float, turn: float, u: Floats, v: Floats) -> Floats:
    """A third of a tri-dome, its middle at an angle [degrees]."""
    sixth, foot, waist = math.pi / 3.0, math.radians(FOOT_DEG), WAIST * reach
    radius = reach + (rim - reach) * u
    up = np.clip((radius - waist) / (reach - waist), 0.0, 1.0)
    half = sixth - (sixth - foot) * up**EDGE
    angle = math.radians(turn) + half * (2.0 * v - 1.0)
    height = rise * (1.0 - (radius / reach) ** 2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)


def _turned(web: PatchFunction, quarters: int, u: Floats, v: Floats) -> Floats:
    """Points of a web turned by quarters about the z axis."""
    c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarters]
    return web(u, v) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def rectangular_plan(
    width: float, depth: float, *, open_sides: Sequence[Side] = (Side.TOP,)
) -> Shape:
    """A flat rectangle, supported on all sides except the open ones.

    Parameters
    ----------
    width : [m] > 0
        Along x, the way of v.
    depth : [m] > 0
        Along y, the way of u.
    open_sides
    """
    supports = tuple(Edge(0, side) for side in Side if side not in open_sides)
    patch = Patch(partial(_flat, width, depth), name="rectangle")
    return Shape((patch,), (), supports, name="rectangular plan")


def _flat(width: float, depth: float, u: Floats, v: Floats) -> Floats:
    """A rectangle, v along x and u along y."""
    return np.stack([width * v, depth * u, np.zeros_like(u)], axis=-1)


def three_legged_plan(reach: float = 6.0, waist: float = 2.5, foot: float = 2.4) -> Shape:
    """A flat plan of three legs that meet in the middle: three patches, three open sides.

    Parameters
    ----------
    reach : [m] > 0
        From the middle to the foot of a leg.
    waist : [m] > 0
        From the middle to the middle of an open side.
    foot : [m] > 0
        Width of a leg at its foot.
    """
    if waist >= reach:
        raise InputError(
            f"the waist, {waist:g} m, is not less than the reach, {reach:g} m",
            where="three-legged plan",
        )

    seams = tuple(
        Seam(Edge(k, Side.TOP, 0.5, 1.0), Edge((k + 1) % 3, Side.TOP, 0.5, 0.0)) for k in range(3)
    )
    supports = tuple(Edge(k, Side.BOTTOM) for k in range(3))
    legs = tuple(
        Patch(partial(_flat_leg, reach, waist, foot, turn), name=f"leg at {turn:g} degrees",
              breaks=(0.5,))
        for turn in (90.0, 210.0, 330.0)
    )  # fmt: skip
    return Shape(legs, seams, supports, name="three vaults")


def three_vault_plan(reach: float = 6.0, waist: float = 2.5, foot: float = 2.4) -> Shape:
    """The plan of :func:`three_legged_plan`, divided into three vaults from leg to leg.

    Each has its open side below and the middles of two legs above: its courses are arches from
    foot to foot.

    Parameters
    ----------
    reach, waist, foot : [m] > 0
        As there.
    """
    turn = np.radians([90.0, 210.0, 330.0])
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(3)], axis=1)
    side = 0.5 * foot * np.stack([-out[:, 1], out[:, 0], out[:, 2]], axis=1)
    feet = np.stack([reach * out - side, reach * out + side], axis=1)
    waists = -waist * np.roll(out, 1, axis=0)
    count, middle = len(feet), feet.mean(axis=1)
    after = np.roll(np.arange(count), -1)
    vaults = tuple(
        Patch(partial(_flat_vault, low, np.stack([middle[k], 0.0 * low[0], middle[after[k]]])),
              name=f"vault {k}", breaks=(0.5,))
        for k, low in enumerate(np.stack([feet[:, 1], waists, feet[after, 0]], axis=1))
    )  # fmt: skip
    seams = tuple(
        Seam(Edge(k, Side.TOP, 1.0, 0.5), Edge(int(after[k]), Side.TOP, 0.0, 0.5))
        for k in range(count)
    )
    supports = tuple(Edge(k, side) for k in range(count) for side in (Side.LEFT, Side.RIGHT))
    return Shape(vaults, seams, supports, name="three vaults")


def _flat_vault(low: Floats, high: Floats, u: Floats, v: Floats) -> Floats:
    """Between two lines of three points (3, 3): an open side, and two feet about the middle."""
    at = np.array([0.0, 0.5, 1.0])
    below, above = (
        np.stack([np.interp(v, at, line[:, axis]) for axis in range(3)], axis=1)
        for line in (low, high)
    )
    return (1.0 - u[:, None]) * below + u[:, None] * above


def _flat_leg(reach: float, waist: float, foot: float, turn: float, u: Floats, v: Floats) -> Floats:
    """A leg in plan at an angle [degrees], from its foot to the two waists that meet in it."""

    def towards(degrees: float) -> Floats:
        return np.array([math.cos(at := math.radians(turn + degrees)), math.sin(at), 0.0])

    out, side, U, V = reach * towards(0.0), 0.5 * foot * towards(90.0), u[:, None], v[:, None]
    low = out + (2.0 * V - 1.0) * side
    left, right = (1.0 - 2.0 * V) * towards(-60.0), (2.0 * V - 1.0) * towards(60.0)
    high = waist * np.where(V < 0.5, left, right)
    return (1.0 - U) * low + U * high


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
