"""Results and assemblies as scenes: which block is what, which arrows stand where."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from drystone.arrays import Floats
from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.errors import InputError
from drystone.results import Result
from drystone.view.palette import State
from drystone.view.scene import Layer, LayerKind, Scene, Stage

Subject: TypeAlias = Result | Assembly | Scene

MANY_ARROWS = 3000
"""A layer of more arrows is hidden at first: they hide each other. Chosen by eye."""


NEGLIGIBLE = 1e-3
"""A prop force below this share of the largest load is the softness of the numerical ground, and is
not shown."""


def scene_of(subject: Subject, contacts: Contacts | None = None) -> Scene:
    """The scene of a result, of an assembly with or without contacts, or the scene itself.

    Raises
    ------
    InputError
        Contacts were given that are not those of the result, or that name other blocks.
    """
    if isinstance(subject, Assembly):
        found = contacts if contacts is not None else Contacts.empty()
        state = np.where(subject.fixed, State.SUPPORT, State.FREE).astype(np.intp)
        layers = interface_layers(found, visible=True)
        count = f"{len(subject)} blocks, {found.count} interfaces"
        stage = Stage("model", "", count, state, layers=layers)
        return Scene(subject, found, (stage,), f"drystone: {count}")
    if contacts is not None and contacts is not subject.contacts:
        raise InputError(
            "contacts other than those of the result", remedy="leave them out: a result has its own"
        )
    if isinstance(subject, Scene):
        return subject
    stage = stage_of(subject)
    title = f"drystone: {stage.headline.lower()}"
    return Scene(subject.assembly, subject.contacts, (stage,), title)


def stage_of(result: Result, label: str = "result") -> Stage:
    """A stage that shows one result."""
    assembly, contacts = result.assembly, result.contacts
    state = np.where(assembly.fixed, State.SUPPORT, State.FREE).astype(np.intp)
    falling = list(result.falling)
    state[falling] = State.FALLING
    headline = result.verdict.value.capitalize()
    if falling:
        verb = "falls" if len(falling) == 1 else "fall"
        headline += f": {len(falling)} of {len(assembly)} blocks {verb}"
    message = "; ".join([result.message, *result.model.notes])
    layers = interface_layers(contacts, visible=False)
    if result.force is None:
        return Stage(
            label, headline, message, state, result.verdict, result.mechanism,
            _needed(result), layers=layers,
        )  # fmt: skip
    resultants = result.resultants
    return Stage(
        label,
        headline,
        message,
        state,
        verdict=result.verdict,
        motion=result.mechanism,
        prop=_needed(result),
        normal=resultants.normal,
        tangential=resultants.tangential,
        utilisation=result.utilisation,
        layers=(*layers, *force_layers(result)),
    )


def _needed(result: Result) -> Floats | None:
    """The prop wrenches (n, 6) worth showing, zero for the other blocks."""
    if result.prop is None:
        return None
    force = np.linalg.norm(result.prop[:, :3], axis=1)
    largest = float(np.linalg.norm(result.load.wrench[:, :3], axis=1).max(initial=0.0))
    kept: Floats = np.where((force > NEGLIGIBLE * largest)[:, None], result.prop, 0.0)
    return kept


def interface_layers(contacts: Contacts, *, visible: bool) -> tuple[Layer, ...]:
    """The areas where blocks touch; lines and points have no area and are left out."""
    flat = np.diff(contacts.start) >= 3
    if not flat.any():
        return ()
    part = contacts if flat.all() else contacts.select(flat)
    return (
        Layer(
            "interfaces", "interfaces", LayerKind.POLYGONS, "interface", part.point,
            start=part.start, visible=visible,
        ),
    )  # fmt: skip


def force_layers(result: Result) -> tuple[Layer, ...]:
    """Corner forces, pulls and resultants of a result that has forces."""
    contacts = result.contacts
    if result.force is None or contacts.count == 0:
        return ()
    world = result.world_force()
    pull = np.maximum(-result.force[:, 0], 0.0)
    if result.tension is not None:
        pull = np.maximum(pull, result.tension)
    pulled = pull > 1e-9 * float(np.abs(result.force).max(initial=0.0))
    visible = contacts.corner_count <= MANY_ARROWS
    layers = [
        Layer(
            "pressure", "corner forces", LayerKind.ARROWS, "pressure", contacts.point,
            np.where((result.force[:, 0] >= 0.0)[:, None], world, 0.0), visible=visible,
        )
    ]  # fmt: skip
    if pulled.any():
        normal = contacts.frame[contacts.interface[pulled], 0]
        layers.append(
            Layer(
                "tension", "tension", LayerKind.ARROWS, "tension", contacts.point[pulled],
                pull[pulled, None] * normal, visible=True, inward=True, width=1.4,
            )
        )  # fmt: skip
    resultants = result.resultants
    layers.append(
        Layer(
            "resultants", "resultants", LayerKind.ARROWS, "resultant", resultants.position,
            resultants.force, visible=contacts.count <= MANY_ARROWS, width=1.8,
        )
    )  # fmt: skip
    return tuple(layers)
