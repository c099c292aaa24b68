"""Parts of pictures that several answers share: blocks, joints, marks, and what they need."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np

from drystone.answer.question import Question, directions
from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.assembly import Assembly
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, dot, lengths
from drystone.base.errors import counted
from drystone.base.units import quantity
from drystone.checks import block_speed
from drystone.contacts import Contacts
from drystone.geometry.frames import frames_from_normals
from drystone.geometry.surface import worth_drawing
from drystone.loads import LoadCase
from drystone.loads.applied import AppliedLoads, applied_loads
from drystone.loads.case import STANDARD_GRAVITY
from drystone.model import Model

PLAYED = 0.3
"""Largest motion of a block in pictures, by the median size of the blocks; chosen by eye."""

_BARB = 0.06
"""Longest head of an arrow of pressure, by the same size; chosen by eye."""


def state_of(assembly: Assembly) -> Ints:
    """State (n,) of the blocks where nothing was computed: free, or a support."""
    return np.where(assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)


def bare_scene(model: Model) -> Scene:
    """Blocks, their interfaces, ties and loads, without an analysis."""
    scene = scene_of_blocks(model.assembly, model.contacts)
    stage, drawn = scene.stages[0], load_layers(model.assembly, model.load)
    drawn = (*tie_layer(model.assembly, model.contacts), *drawn)
    message, layers = "; ".join(worth_drawing(model.notes)), (*stage.layers, *drawn)
    told = replace(stage, message=message, layers=layers)
    return replace(scene, stages=(told,), facts=Question.of(model).facts())


def scene_of_blocks(assembly: Assembly, contacts: Contacts | None) -> Scene:
    """Blocks, and their interfaces where these are known."""
    count = counted(len(assembly), "block")
    if contacts is not None:
        count += f", {counted(contacts.count, 'interface')}"
    found = contacts if contacts is not None else Contacts.empty()
    stage = SceneStage("model", count, "", state_of(assembly), layers=interface_layers(found))
    scene = Scene(assembly, found, (stage,), f"drystone: {count}")  # refuses contacts of others
    return replace(scene, facts=Question.of_blocks(assembly, found).facts())


def enlargement(assembly: Assembly, motion: Floats) -> float:
    """The factor by which a motion (n, 6) is scaled to be visible."""
    largest = float(block_speed(assembly, motion).max(initial=0.0))
    return PLAYED * float(np.median(assembly.size)) / largest if largest > 0.0 else 1.0


def seen(assembly: Assembly, motion: Floats) -> Floats:
    """A motion (n, 6) whose size has no meaning, scaled to be visible."""
    return motion * enlargement(assembly, motion)


def interface_layers(
    contacts: Contacts,
    shown: Bools | None = None,
    key: str = "interfaces",
    label: str = "interfaces",
    colour: str = "interface",
) -> tuple[Layer, ...]:
    """The areas where blocks touch; lines and points have no area and are left out.

    Parameters
    ----------
    contacts
    shown : (m,)
        Which of them; all when left out.
    key, label, colour
        Of the layer.
    """
    part, interface = areas(contacts, shown)
    if part is None:
        return ()
    return (
        Layer(
            key, label, LayerKind.POLYGONS, colour, part.point, start=part.start,
            interface=interface,
        ),
    )  # fmt: skip


def areas(contacts: Contacts, shown: Bools | None) -> tuple[Contacts | None, Ints]:
    """The interfaces that have an area, and their numbers; ``None`` where there are none."""
    flat = np.diff(contacts.start) >= 3
    if shown is not None:
        flat = flat & shown
    number = np.flatnonzero(flat)
    return (contacts.select(flat) if len(number) else None), number


def load_layers(assembly: Assembly, load: LoadCase) -> tuple[Layer, ...]:
    """What is applied beside the weight: forces, moments, and an acceleration of all masses.

    A force is an arrow that ends where it acts, a traction on faces a field of lines. A moment is
    three quarters of a circle about its axis, in its sense. The part across the weight of an
    acceleration that most masses have is one arrow, with the sum of their forces, that ends at
    their centre.
    """
    turns = np.zeros_like(load.wrench)  # as given: beside a force they would only shift its line
    for one in load.each:
        np.add.at(turns, one.block, one.wrench * ~one.wrench[:, :3].any(axis=1, keepdims=True))
    least = ROUNDING * np.abs(load.wrench[:, :3]).max(initial=0.0) * assembly.size
    turns[np.abs(turns[:, 3:]).max(axis=1) <= least] = 0.0
    on_faces = 0.0 if load.surface is None else load.surface.wrench
    alone = replace(load, wrench=load.wrench - on_faces - turns)
    applied, turning = (applied_loads(assembly, x) for x in (alone, LoadCase(turns)))
    layers = []
    pushed = np.flatnonzero(applied.force.any(axis=1))
    if len(pushed):
        layers.append(
            Layer(
                "loads", "loads", LayerKind.ARROWS, "load", applied.point[pushed],
                applied.force[pushed], block=applied.block[pushed], single=True, width=2.0,
                group="loads",
            )
        )  # fmt: skip
    block, at, moment = (
        np.concatenate([getattr(one, name)[one.moment.any(axis=1)] for one in (applied, turning)])
        for name in ("block", "point", "moment")
    )
    if len(block):
        most = quantity(float(lengths(moment).max()), "N m")
        start, way = _turns(assembly, block, moment)
        layers.append(
            Layer(
                "moments", f"moments, up to {most}", LayerKind.LINES, "load",
                (at[:, None] + start).reshape(-1, 3), way.reshape(-1, 3),
                block=np.repeat(block, start.shape[1]), width=2.0,
            )
        )  # fmt: skip
    layers += _surface_layer(assembly, load)
    return (*layers, *_body_layer(assembly, load, applied))


def _surface_layer(assembly: Assembly, load: LoadCase) -> tuple[Layer, ...]:
    """Tractions on faces as fields: arrows that end on them, their tails joined.

    Where faces meet there is one arrow, the mean of theirs, so that their fields do not cross.
    """
    field = load.surface
    if field is None or not field.traction.any():
        return ()
    most = float(lengths(field.traction.reshape(-1, 3)).max())
    size = float(np.median(assembly.size))
    push = 0.6 * size / most * field.traction
    place = (field.point.reshape(-1, 3) / (1e-6 * size)).round()
    place, alike = np.unique(place, axis=0, return_inverse=True)
    total = np.zeros((len(place), 3))
    np.add.at(total, alike.ravel(), push.reshape(-1, 3))
    push = (total / np.bincount(alike.ravel())[:, None])[alike.ravel()].reshape(-1, 2, 3)
    tails, along = field.point - push, field.point[:, 1] - field.point[:, 0]
    reach = lengths(push.reshape(-1, 3)).reshape(-1, 2, 1)
    aside = along[:, None] / np.maximum(lengths(along), 1e-300)[:, None, None]
    head = np.minimum(0.35 * reach, _BARB * size)
    barb = [head * (-push / np.maximum(reach, 1e-300) + side * aside) for side in (0.4, -0.4)]
    start = np.concatenate(
        [tails[:, 0], tails[:, 1], tails[:, 0], *2 * [*field.point.swapaxes(0, 1)]]
    )
    way = [
        push[:, 0],
        push[:, 1],
        tails[:, 1] - tails[:, 0],
        *(one[:, i] for one in barb for i in (0, 1)),
    ]
    label = f"pressure on faces, up to {quantity(most, 'Pa')}"
    return (
        Layer(
            "surface", label, LayerKind.LINES, "load", start, np.concatenate(way),
            block=np.tile(field.block, 7), width=0.7,
        ),
    )  # fmt: skip


def tie_layer(
    assembly: Assembly, contacts: Contacts, words: str = "", shown: Bools | None = None
) -> tuple[Layer, ...]:
    """The ties among some interfaces (m,), or all but those of fill, as lines from end to end.

    Without words their least strength is told.
    """
    ties = np.flatnonzero(contacts.ties & (~contacts.of_fill if shown is None else shown))
    if not ties.size:
        return ()
    if not words:
        least = float(contacts.tie_strength[ties].min())
        limit = f" of {quantity(least, 'N')}" if least < np.inf else ""
        words = f"{'a tie' if ties.size == 1 else 'ties'}{limit}"
    start, along = contacts.centroid[ties], contacts.frame[ties, 0]
    away = dot(assembly.centroid[contacts.block_a[ties]] - start, along)
    far = np.where(away > 0.0, away, assembly.size[contacts.block_b[ties]])
    far = np.where(contacts.rod[ties] > 0.0, contacts.rod[ties], far)[:, None] * along
    return (
        Layer(
            "tie-forces", words, LayerKind.LINES, "added", start + far, -far,
            interface=ties, width=2.0,
        ),
    )  # fmt: skip


def _turns(assembly: Assembly, block: Ints, moment: Floats) -> tuple[Floats, Floats]:
    """Sides (a, s, 3) of three quarters of a circle about moments (a, 3), with a head at the end.

    Returns the starts of the sides, from the middle of the circle, and the sides.
    """
    frame = frames_from_normals(moment / lengths(moment)[:, None])
    angle = np.linspace(0.0, 1.5 * np.pi, 13)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    head = np.array([[-0.25, -0.75], [-0.25, -1.25]])  # beside the end, at (0, -1)
    flat_start = np.concatenate([rim[:-1], rim[[-1, -1]]])
    flat_end = np.concatenate([rim[1:], head])
    radius = 0.35 * assembly.size[block][:, None, None]
    start = radius * np.einsum("si,aij->asj", flat_start, frame[:, 1:])
    end = radius * np.einsum("si,aij->asj", flat_end, frame[:, 1:])
    return start, end - start


def _body_layer(assembly: Assembly, load: LoadCase, applied: AppliedLoads) -> tuple[Layer, ...]:
    up, _ = directions(assembly, load)
    acceleration = applied.acceleration
    free = np.flatnonzero(~assembly.fixed)
    mass = assembly.mass[free]
    across = acceleration - (acceleration @ up) * up
    size = float(np.linalg.norm(across))
    if size <= 1e-9 * float(np.linalg.norm(acceleration)):
        return ()
    force, centre = applied.earthquake, applied.centre
    if not force.any():
        force, centre = mass.sum() * across, mass @ assembly.centroid[free] / mass.sum()
    return (
        Layer(
            "acceleration", f"acceleration of all masses, {size / STANDARD_GRAVITY:.3g} g",
            LayerKind.ARROWS, "load", centre[None], force[None], single=True, width=4.0,
            group="acceleration",
        ),
    )  # fmt: skip


def help_layer(
    assembly: Assembly, wrench: Floats | None, label: str = "help needed"
) -> tuple[Layer, ...]:
    """The forces of props (n, 6) or hands, as an arrow that ends at each block."""
    if wrench is None:
        return ()
    needy = np.flatnonzero(np.linalg.norm(wrench[:, :3], axis=1) > 0.0)
    if len(needy) == 0:
        return ()
    if len(needy) > 1:  # one alone holds less, or nothing
        label += f" on {len(needy)} blocks at once"
    return (
        Layer(
            "help", label, LayerKind.ARROWS, "help", assembly.centroid[needy], wrench[needy, :3],
            block=needy, single=True, width=2.4, group="help",
        ),
    )  # fmt: skip


Marked: TypeAlias = tuple[str, str, Bools]
"""The key of a layer of marks, its label, and which joints (j,) have one."""


def marks(
    place: Floats, turns: Marked, slides: Marked, interface: Ints | None = None
) -> tuple[Layer, ...]:
    """Discs at edges about which joints turn, and diamonds where they slide.

    Parameters
    ----------
    place : (j, 3) [m]
    turns, slides
    interface : (j,)
        Interfaces that the places belong to; all in their order when left out.
    """
    made = []
    for (key, label, chosen), colour, shape in (
        (turns, "hinge", MarkerShape.DISC),
        (slides, "help", MarkerShape.DIAMOND),
    ):
        number = np.flatnonzero(chosen)
        if len(number):
            made.append(
                Layer(
                    key, label, LayerKind.MARKERS, colour, place[number],
                    interface=number if interface is None else interface[number], shape=shape,
                )
            )  # fmt: skip
    return tuple(made)
