"""Parts of pictures that several answers share: blocks, joints, marks, and what they need."""

from __future__ import annotations

import numpy as np

from drystone.answer.question import Question
from drystone.answer.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage, State
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.errors import counted
from drystone.checks import block_speed
from drystone.contacts import Contacts
from drystone.model import Model

PLAYED = 0.3
"""Largest motion of a block in pictures, by the median size of the blocks; chosen by eye."""


def state_of(assembly: Assembly) -> Ints:
    """State (n,) of the blocks where nothing was computed: free, or a support."""
    return np.where(assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)


def bare_scene(
    assembly: Assembly, contacts: Contacts | None = None, model: Model | None = None
) -> Scene:
    """Blocks and their interfaces, without an analysis."""
    found = contacts if contacts is not None else Contacts.empty()
    count = counted(len(assembly), "block")
    if contacts is not None:
        count += f", {counted(contacts.count, 'interface')}"
    notes = "" if model is None else "; ".join(model.notes)
    stage = SceneStage("model", count, notes, state_of(assembly), layers=interface_layers(found))
    asked = Question.of_blocks(assembly, found) if model is None else Question.of(model)
    return Scene(assembly, found, (stage,), f"drystone: {count}", asked.facts())


def enlargement(assembly: Assembly, motion: Floats) -> float:
    """The factor by which a motion (n, 6) is scaled to be visible."""
    largest = float(block_speed(assembly, motion).max(initial=0.0))
    return PLAYED * float(np.median(assembly.size)) / largest if largest > 0.0 else 1.0


def seen(assembly: Assembly, motion: Floats) -> Floats:
    """A motion (n, 6) whose size has no meaning, scaled to be visible."""
    return motion * enlargement(assembly, motion)


def interface_layers(contacts: Contacts, shown: Bools | None = None) -> tuple[Layer, ...]:
    """The areas where blocks touch; lines and points have no area and are left out.

    Parameters
    ----------
    contacts
    shown : (m,)
        Which of them; all when left out.
    """
    part, interface = areas(contacts, shown)
    if part is None:
        return ()
    return (
        Layer(
            "interfaces", "interfaces", LayerKind.POLYGONS, "interface", part.point,
            start=part.start, interface=interface,
        ),
    )  # fmt: skip


def areas(contacts: Contacts, shown: Bools | None) -> tuple[Contacts | None, Ints]:
    """The interfaces that have an area, and their numbers; ``None`` where there are none."""
    flat = np.diff(contacts.start) >= 3
    if shown is not None:
        flat = flat & shown
    number = np.flatnonzero(flat)
    return (contacts.select(flat) if len(number) else None), number


def help_layer(
    assembly: Assembly, wrench: Floats | None, label: str = "help needed"
) -> tuple[Layer, ...]:
    """The forces of props (n, 6) or hands, as an arrow that ends at each block."""
    if wrench is None:
        return ()
    needy = np.flatnonzero(np.linalg.norm(wrench[:, :3], axis=1) > 0.0)
    if len(needy) == 0:
        return ()
    return (
        Layer(
            "help", label, LayerKind.ARROWS, "help", assembly.centroid[needy], wrench[needy, :3],
            block=needy, single=True, width=2.4, group="help",
        ),
    )  # fmt: skip


def marks(
    place: Floats,
    hinge: Bools,
    turns: str,
    slide: Bools,
    slides: str,
    interface: Ints | None = None,
) -> tuple[Layer, ...]:
    """Markers at hinges and at sliding joints.

    Parameters
    ----------
    place : (j, 3) [m]
    hinge, slide : (j,)
    turns, slides
        What they are called.
    interface : (j,)
        Interfaces that the places belong to; all in their order when left out.
    """
    made = []
    for key, label, colour, shape, chosen in (
        ("hinges", turns, "hinge", MarkerShape.DISC, hinge),
        ("sliding", slides, "help", MarkerShape.DIAMOND, slide),
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
