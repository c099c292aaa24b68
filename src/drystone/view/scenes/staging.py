"""Results and assemblies as scenes: states of blocks, forces, marks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.errors import counted
from drystone.checks import block_speed, moving_joints
from drystone.contacts import Contacts
from drystone.design.regions import first_motion_of
from drystone.joints import HINGED, corner_pressure, force_network, hinged
from drystone.model import Model
from drystone.results import Result
from drystone.view.scenes.header import directions, facts_of, sentence
from drystone.view.scenes.scene import Layer, LayerKind, MarkerShape, Scene, SceneStage
from drystone.view.style.palette import State

NEGLIGIBLE = 1e-3
"""A prop force below this share of the largest load comes from the ground springs. It is not
shown."""

PLAYED = 0.3
"""Largest motion of a block in pictures, by the median size of the blocks; chosen by eye."""

_FAINT = 1e-2
"""Joints that carry less than this share of the largest normal force get no marker; chosen by eye:
they would be most of the markers of a large model."""

VIRTUAL = "Virtual displacement"


def result_scene(result: Result, source: str = "") -> Scene:
    """The scene of one result."""
    model = result.model
    stage = stage_of(result)
    facts = facts_of(model.assembly, model.contacts, model.load, source)
    title = f"drystone: {stage.headline.lower()}"
    return Scene(result.assembly, result.contacts, (stage,), title, facts)


def bare_scene(
    assembly: Assembly, contacts: Contacts | None, model: Model | None = None, source: str = ""
) -> Scene:
    """Blocks and their interfaces, without an analysis."""
    found = contacts if contacts is not None else Contacts.empty()
    load, notes = (None, ()) if model is None else (model.load, model.notes)
    state = np.where(assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)
    count = counted(len(assembly), "block")
    if contacts is not None:
        count += f", {counted(contacts.count, 'interface')}"
    stage = SceneStage("model", count, "; ".join(notes), state, layers=interface_layers(found))
    facts = facts_of(assembly, found, load, source)
    return Scene(assembly, found, (stage,), f"drystone: {count}", facts)


def stage_of(result: Result, label: str = "result") -> SceneStage:
    """A stage that shows one result."""
    assembly, contacts = result.assembly, result.contacts
    state = np.where(assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)
    state[list(result.falling)] = State.FALLING
    up, gravity = directions(assembly, result.load)
    needed = _needed(result)
    layers = [*interface_layers(contacts), *help_layer(assembly, needed)]
    stage = SceneStage(
        label, sentence(result), "; ".join([result.message, *result.model.notes]), state,
        result.verdict, prop=needed, up=up, gravity=gravity,
    )  # fmt: skip
    if result.falls:
        motion = _falling_motion(result)
        if motion is not None:
            layers += _fall_layers(result.model, motion)
        return replace(stage, motion=motion, plays=True, layers=tuple(layers))
    motion = result.mechanism
    if motion is None and result.displacement is not None:
        motion = seen(assembly, result.displacement)
    stage = replace(stage, motion=motion, motion_name=VIRTUAL)
    if result.force is None:
        return replace(stage, layers=tuple(layers))
    resultants = result.resultants
    return replace(
        stage,
        force=result.force,
        normal=resultants.normal,
        tangential=resultants.tangential,
        utilisation=result.utilisation,
        pressure_centre=resultants.position,
        layers=(*layers, *force_layers(result)),
    )


def _falling_motion(result: Result) -> Floats | None:
    """The first motion (n, 6) of what falls, as the diagnosis tells it.

    The mechanism of a result proves that it falls. It is one of many, and often not the one that
    begins. Where the props that the blocks need are known, the first motion follows from these.
    """
    if result.prop is None or not result.falling:
        return result.mechanism
    prop = np.zeros((len(result.model), 6))
    prop[list(result.falling)] = result.prop[list(result.falling)]
    return first_motion_of(result.model, prop)


def seen(assembly: Assembly, motion: Floats) -> Floats:
    """A motion (n, 6) whose size has no meaning, scaled to be visible."""
    largest = float(block_speed(assembly, motion).max(initial=0.0))
    size = float(np.median(assembly.size))
    return motion * (PLAYED * size / largest) if largest > 0.0 else motion


def _needed(result: Result) -> Floats | None:
    """The prop wrenches (n, 6) that are shown, zero for the other blocks."""
    if result.prop is None:
        return None
    force = np.linalg.norm(result.prop[:, :3], axis=1)
    largest = float(np.linalg.norm(result.load.wrench[:, :3], axis=1).max(initial=0.0))
    kept: Floats = np.where((force > NEGLIGIBLE * largest)[:, None], result.prop, 0.0)
    return kept


def interface_layers(contacts: Contacts, shown: Bools | None = None) -> tuple[Layer, ...]:
    """The areas where blocks touch; lines and points have no area and are left out.

    Parameters
    ----------
    contacts
    shown : (m,)
        Which of them; all when left out.
    """
    part, interface = _areas(contacts, shown)
    if part is None:
        return ()
    return (
        Layer(
            "interfaces", "interfaces", LayerKind.POLYGONS, "interface", part.point,
            start=part.start, interface=interface,
        ),
    )  # fmt: skip


def _areas(contacts: Contacts, shown: Bools | None) -> tuple[Contacts | None, Ints]:
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


def _fall_layers(model: Model, motion: Floats) -> tuple[Layer, ...]:
    """The hinges and the sliding joints of a first motion."""
    hinge, slide, place = moving_joints(model, motion)
    return _marks(place, hinge, "turns about an edge", slide, "slides")


def _marks(place: Floats, hinge: Bools, turns: str, slide: Bools, slides: str) -> tuple[Layer, ...]:
    made = []
    for key, label, colour, shape, chosen in (
        ("hinges", turns, "hinge", MarkerShape.DISC, hinge),
        ("sliding", slides, "help", MarkerShape.DIAMOND, slide),
    ):
        number = np.flatnonzero(chosen)
        if len(number):
            made.append(
                Layer(
                    key, label, LayerKind.MARKERS, colour, place[number], interface=number,
                    shape=shape,
                )
            )  # fmt: skip
    return tuple(made)


def force_layers(result: Result, shown: Bools | None = None) -> tuple[Layer, ...]:
    """The forces inside the blocks of a result.

    Parameters
    ----------
    result
    shown : (m,)
        Interfaces of which forces are shown; all when left out.
    """
    contacts = result.contacts
    if result.force is None or contacts.count == 0:
        return ()
    shown = np.ones(contacts.count, dtype=bool) if shown is None else shown
    normal = np.maximum(result.force[:, 0], 0.0)
    resultants, used = result.resultants, result.utilisation
    part, interface = _areas(contacts, shown)
    layers: list[Layer] = []
    if part is not None:
        corner = np.isin(contacts.interface, interface)
        for key, label, unit, value in (
            ("joint-force", "normal force at a corner", "N", normal),
            (
                "joint-pressure",
                "pressure at a corner",
                "Pa",
                corner_pressure(contacts, result.force),
            ),
            ("joint-use", "friction used", "", np.minimum(used, 1.0)[contacts.interface]),
        ):
            layers.append(
                Layer(
                    key, label, LayerKind.POLYGONS, "pressure", part.point, start=part.start,
                    value=np.maximum(value[corner], 0.0), unit=unit, interface=interface,
                )
            )  # fmt: skip
    made = force_network(result.assembly, contacts, resultants)
    kept = shown[made.interface]
    layers.append(
        Layer(
            "network", "force network", LayerKind.LINES, "network", made.start[kept],
            (made.end - made.start)[kept], value=made.force[kept], interface=made.interface[kept],
        )
    )  # fmt: skip
    carrying = shown & (resultants.normal > _FAINT * resultants.normal.max(initial=0.0))
    spent = (used > HINGED) & carrying
    turning = hinged(contacts, resultants) & carrying
    layers += _marks(
        resultants.position, turning, "hinge: presses on one edge", spent, "friction is spent"
    )
    return (*layers, *_arrow_layers(result, shown))


def _arrow_layers(result: Result, shown: Bools) -> list[Layer]:
    """Corner forces, pulls and resultants."""
    contacts, force = result.contacts, result.force
    if force is None:
        return []
    pull = np.maximum(-force[:, 0], 0.0)
    if result.tension is not None:
        pull = np.maximum(pull, result.tension)
    corner = shown[contacts.interface]
    pressing = np.flatnonzero((force[:, 0] > 0.0) & corner)
    pulled = np.flatnonzero((pull > 1e-9 * float(np.abs(force).max(initial=0.0))) & corner)
    which = np.flatnonzero(shown)
    resultants = result.resultants
    layers = [
        Layer(
            "pressure", "corner forces", LayerKind.ARROWS, "pressure", contacts.point[pressing],
            result.world_force()[pressing], interface=contacts.interface[pressing],
        ),
        Layer(
            "resultants", "resultants", LayerKind.ARROWS, "resultant", resultants.position[which],
            resultants.force[which], interface=which, width=1.8,
        ),
    ]  # fmt: skip
    if len(pulled):
        normal = contacts.frame[contacts.interface[pulled], 0]
        carried = result.tension is None and contacts.capacity is not None
        words = "tension that joints carry" if carried else "tension needed"
        layers.append(
            Layer(
                "tension", words, LayerKind.ARROWS, "help", contacts.point[pulled],
                pull[pulled, None] * normal, interface=contacts.interface[pulled], inward=True,
                width=2.0, group="help",
            )
        )  # fmt: skip
    return layers
