"""A result as a stage of a picture: what falls, how it moves, and the forces inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from drystone.answer import Role
from drystone.answer.drawing import (
    areas,
    help_layer,
    interface_layers,
    load_layers,
    marks,
    seen,
    state_of,
    tie_layer,
)
from drystone.answer.question import directions
from drystone.answer.scene import Layer, LayerKind, SceneStage, State
from drystone.answer.sentences import Verdict
from drystone.base.arrays import Bools, Floats, lengths
from drystone.base.units import quantity
from drystone.checks import corner_motion, first_motion_of, moving_joints, turning_joints
from drystone.geometry.surface import worth_drawing
from drystone.joints import (
    FAINT,
    HINGED,
    Resultants,
    by_joint,
    corner_pressure,
    force_network,
    hinged,
)
from drystone.results.solution import Solution, reaction_layer

NEGLIGIBLE = 1e-3
"""A prop force below this share of the largest load of a free block comes from the ground springs.
It is not shown."""

_EYE = np.array([0.7, -0.7, 0.14])
"""From the model to the eye, about, as a picture opens."""

VIRTUAL = "Virtual displacement"


def stage_of(result: Solution, headline: str, label: str = "result") -> SceneStage:
    """A stage that shows one result."""
    assembly, contacts = result.assembly, result.contacts
    state = state_of(assembly)
    state[list(result.falling)] = State.FALLING
    up, gravity = directions(assembly, result.load)
    needed = _needed(result)
    layers = [*interface_layers(contacts), *help_layer(assembly, needed)]
    if result.force is None:
        layers += tie_layer(assembly, contacts)
    layers += load_layers(assembly, result.load)
    stage = SceneStage(
        label, headline, "; ".join([result.message, *worth_drawing(result.model.notes)]), state,
        Role.of(result.verdict), prop=needed, up=up, gravity=gravity,
    )  # fmt: skip
    if result.verdict is Verdict.UNSTABLE:
        motion = _falling_motion(result)
        if motion is not None:
            layers += _fall_layers(result, motion)
        known = {layer.key for layer in layers}  # the joints that move are marked already
        layers += [one for one in force_layers(result) if one.key not in known]
        return replace(stage, motion=motion, plays=True, layers=tuple(layers))
    motion = result.mechanism
    if motion is None and result.displacement is not None:
        motion = seen(assembly, result.displacement)
    stage = replace(stage, motion=motion, motion_name=VIRTUAL)
    if result.force is None:
        return replace(stage, layers=tuple(layers))
    resultants, used = by_joint(contacts, result.resultants, result.utilisation)
    joint = contacts.joint
    return replace(
        stage,
        force=result.force,
        normal=resultants.normal[joint],
        tangential=resultants.tangential[joint],
        utilisation=used[joint],
        pressure_centre=resultants.position[joint],
        layers=(*layers, *force_layers(result)),
    )


def _falling_motion(result: Solution) -> Floats | None:
    """The first motion (n, 6) of what falls, as the diagnosis tells it.

    The mechanism of a result proves that it falls. It is one of many, and often not the one that
    begins. Where the props that the blocks need are known, the first motion follows from these.
    """
    if result.prop is None or not result.falling:
        return result.mechanism
    prop = np.zeros((len(result.model), 6))
    prop[list(result.falling)] = result.prop[list(result.falling)]
    return first_motion_of(result.model, prop)


def _needed(result: Solution) -> Floats | None:
    """The prop wrenches (n, 6) that are shown, zero for the other blocks."""
    if result.prop is None:
        return None
    force = np.linalg.norm(result.prop[:, :3], axis=1)
    load = result.load.wrench[result.assembly.free, :3]
    largest = float(np.linalg.norm(load, axis=1).max(initial=0.0))
    return np.where((force > NEGLIGIBLE * largest)[:, None], result.prop, 0.0)


def first_motion_words(result: Solution) -> str:
    """What joints do in the first motion of what falls, and towards where all slide.

    Examples
    --------
    >>> from drystone.limits import limit_tilt
    >>> from drystone.models import tower
    >>> first_motion_words(limit_tilt(tower(2), "x", friction=0.6).best.falling)
    'slides towards -y'
    """
    motion = _falling_motion(result)
    if motion is None:
        return ""
    hinge, slide, _ = moving_joints(result.model, motion)
    turns = turning_joints(result.model, motion, slide)
    kinds = (
        ("turns about an edge", hinge), ("turns on a joint", turns), ("slides", slide & ~turns),
    )  # fmt: skip
    told = [words for words, some in kinds if some.any()]
    each = motion[list(result.falling), :2]
    way = each.sum(axis=0)
    along = int(np.abs(way).argmax())
    if told == ["slides"] and abs(way[along]) > 0.99 * lengths(each).sum():
        told = [f"slides towards {'-' if way[along] < 0.0 else ''}{'xy'[along]}"]
    return " and ".join(told)


def _fall_layers(result: Solution, motion: Floats) -> tuple[Layer, ...]:
    """The hinges and the sliding joints of a first motion."""
    hinge, slide, place = moving_joints(result.model, motion, _EYE)
    corners = corner_motion(result.assembly, result.contacts, motion)
    corners = corners[slide[result.contacts.interface]]
    rises = corners[:, 0].sum() > 0.1 * lengths(corners[:, 1:]).sum()  # else it is drawn as it is
    opens = "; drawn opening by the angle of friction, real sliding does not" if rises else ""
    turns = "hinges", "turns about an edge", hinge
    return marks(place, turns, ("sliding", f"slides{opens}", slide))


def force_layers(result: Solution, shown: Bools | None = None) -> tuple[Layer, ...]:
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
    resultants, used = by_joint(contacts, result.resultants, result.utilisation)
    joint = contacts.joint
    first = np.unique(joint, return_index=True)[1]
    part, interface = areas(contacts, shown)
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
            (
                "joint-use",
                "friction used",
                "",
                np.minimum(used, 1.0)[joint][contacts.interface],
            ),
        ):
            layers.append(
                Layer(
                    key, label, LayerKind.POLYGONS, "pressure", part.point, start=part.start,
                    value=np.maximum(value[corner], 0.0), unit=unit, interface=interface,
                )
            )  # fmt: skip
    made = force_network(result.assembly, contacts.joints, resultants)
    # beside tension a resultant can be far from its joint
    longest = lengths(np.diff(result.assembly.bounds, axis=1)[:, 0]).max()
    kept = shown[first[made.interface]] & (lengths(made.end - made.start) <= longest)
    layers.append(
        Layer(
            "network", "force network (normal forces)", LayerKind.LINES, "network",
            made.start[kept], (made.end - made.start)[kept], value=made.force[kept],
            interface=first[made.interface[kept]],
        )
    )  # fmt: skip
    ties = np.flatnonzero(shown & contacts.ties)
    if len(ties):
        pull = quantity(float(resultants.normal[joint[ties]].max()), "N")
        words = f"ties, which pull up to {pull}" if ties.size > 1 else f"a tie, which pulls {pull}"
        if contacts.of_fill[ties].all():
            words = f"fill, which resists up to {pull}"
        layers += tie_layer(result.assembly, contacts, words, shown)
    carrying = shown[first] & (resultants.normal > FAINT * resultants.normal.max(initial=0.0))
    pulled = np.bincount(joint[contacts.interface], _pull(result.force, result.tension))
    turning = pulled <= (1.0 - HINGED) * resultants.normal  # else the resultant is beyond the rim
    turning &= hinged(contacts.joints, resultants) & carrying
    hinges, turns = _heaviest(turning, resultants.normal)
    spent, slides = _heaviest((used > HINGED) & carrying, resultants.normal)
    layers += marks(
        resultants.position,
        ("edges", f"force at an edge, where it would turn first{turns}", hinges),
        ("spent", f"friction fully used{slides}", spent), first,
    )  # fmt: skip
    if shown.all():
        layers += reaction_layer(result, resultants)
    return (*layers, *_arrow_layers(result, resultants, shown))


def _heaviest(chosen: Bools, normal: Floats, most: int = 24) -> tuple[Bools, str]:
    """Of some joints those that carry most, and words where they are not all.

    114 marks on a vault of 399 blocks hid its forces.
    """
    order = np.argsort(-np.where(chosen, normal, 0.0), kind="stable")
    few = chosen & np.isin(np.arange(len(chosen)), order[:most])
    return few, "" if few.sum() == chosen.sum() else f", the most loaded of {chosen.sum()}"


def _pull(force: Floats, tension: Floats | None) -> Floats:
    """Tension (c,) [N] at each corner."""
    pull: Floats = np.maximum(-force[:, 0], 0.0)
    return pull if tension is None else np.maximum(pull, tension)


def _arrow_layers(result: Solution, resultants: Resultants, shown: Bools) -> list[Layer]:
    """Corner forces, pulls and resultants."""
    contacts, force = result.contacts, result.force
    if force is None:
        return []
    pull = _pull(force, result.tension)
    corner = shown[contacts.interface]
    pressing = np.flatnonzero((force[:, 0] > 0.0) & corner)
    pulled = np.flatnonzero((pull > 1e-9 * float(np.abs(force).max(initial=0.0))) & corner)
    first = np.unique(contacts.joint, return_index=True)[1]
    which = np.flatnonzero(shown[first])
    layers = [
        Layer(
            "pressure", "corner forces", LayerKind.ARROWS, "pressure", contacts.point[pressing],
            result.world_force()[pressing], interface=contacts.interface[pressing],
        ),
        Layer(
            "resultants", "resultants", LayerKind.ARROWS, "resultant", resultants.position[which],
            resultants.force[which], interface=first[which], width=1.8,
        ),
    ]  # fmt: skip
    if len(pulled):
        normal = contacts.frame[contacts.interface[pulled], 0]
        carried = result.tension is None and contacts.capacity is not None
        words = f"tension {'that joints carry' if carried else 'needed'} at a corner"
        layers.append(
            Layer(
                "tension", words, LayerKind.ARROWS, "help", contacts.point[pulled],
                pull[pulled, None] * normal, interface=contacts.interface[pulled], inward=True,
                width=2.0, group="help",
            )
        )  # fmt: skip
    return layers
