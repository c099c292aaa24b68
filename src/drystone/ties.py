"""Ties: they pull two blocks together, and never press."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, lengths
from drystone.base.display import named
from drystone.base.errors import InputError, counted, located
from drystone.base.units import FORCES, measured, quantity
from drystone.contacts import DRAWN, Contacts, joined_contacts
from drystone.geometry.frames import frames_from_normals
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.loads.fill import Tops
from drystone.loads.load_words import position
from drystone.loads.placing import off_block
from drystone.model import Model

PLATE = 0.1
"""Side of the plate of a tie, and of the head of a prop, relative to the size of the block on it.
Chosen: a small jack."""

_End: TypeAlias = tuple[float, float, float] | None


def tied(
    model: Model,
    block: int,
    other: int,
    strength: float = NO_LIMIT,
    at: Sequence[float] | None = None,
    anchor: Sequence[float] | None = None,
    *,
    fill: bool = False,
) -> Model:
    """The model with a tie from a point (3,) [m] of a block to one of another, or their centroids.

    It is a joint without friction that presses the block towards the other one. It has the area of
    a plate, drawn together to a point, so that it resists no turn. It yields at its
    strength [N], as a joint crushes. What stands for ``fill`` is drawn together twice as much
    (:attr:`drystone.Contacts.of_fill`).

    Raises
    ------
    InputError
        Both points are one.
    """
    centroid = model.assembly.centroid
    start = centroid[block] if at is None else np.asarray(at)
    along = (centroid[other] if anchor is None else np.asarray(anchor)) - start
    length = float(np.linalg.norm(along))
    if length <= SAME * float(model.assembly.size[block]):
        raise InputError("has no length", remedy="give two different points")
    frame = frames_from_normals(along[None] / length)
    half = 0.5 * PLATE * float(model.assembly.size[block])
    point = 0.5 * DRAWN if fill else DRAWN
    square = point * half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    plate = Contacts(
        np.array([other]),
        np.array([block]),
        frame,
        np.array([4.0 * half**2]),
        np.zeros(1),
        start + square @ frame[0, 1:],
        np.zeros(4, dtype=np.intp),
        rod=np.array([0.0 if fill else length]),
    )
    if strength < NO_LIMIT or model.contacts.capacity is not None:
        whole = strength / point**2 if strength < NO_LIMIT else NO_LIMIT
        plate = plate.with_capacity(replace(JointCapacity.dry(1), compression=np.array([whole])))
    return model.with_contacts(joined_contacts(model.contacts, plate))


def with_ties(model: Model, ties: Iterable[tuple[str, str]]) -> Model:
    """The model with a tie from the first to the second block of each pair of names.

    Pairs with a block that is not there are left out.
    """
    for pair in ties:
        if all(name in model.assembly for name in pair):
            model = tied(model, *model.assembly.indices(list(pair)).tolist())
    return model


def with_tie_words(model: Model, given: Iterable[str]) -> Model:
    """The model with more ties, each as ``BLOCK:BLOCK``, with ``@X,Y,Z`` behind a block or not.

    ``:20kN`` at the end is its strength. ``fill``: :func:`with_resisting_fill`.

    Raises
    ------
    InputError
        There is no such block, both are one, the strength is no force above zero, it has no
        length, or no fill of the load resists.
    """
    for text in given:
        with located(f"tie {text[:60]}"):
            if text.strip() == "fill":
                model = with_resisting_fill(model)
            else:
                ends = _read(text, model.assembly)
                model = tied(_noted(model, *ends), *ends)
    return model


def with_resisting_fill(model: Model) -> Model:
    """The model with ties for what the fill of its load resists beyond its pressure.

    One on each free block that it presses sideways, to the nearest support: along the force that
    is missing to the passive pressure, where it acts, with its size as strength. Its torque about
    itself, on blocks that are skew, is left out. Fill that has ties resists nothing more.
    """
    assembly, load, contacts = model.assembly, model.load, model.contacts
    fills = [one for one in load.fills if one.passive > one.k and not contacts.of_fill.any()]
    supports = np.flatnonzero(assembly.fixed)
    if not fills or not len(supports):
        what = "no load is fill that resists" if not fills else "no support holds the fill"
        raise InputError(what, remedy=_RESISTING)
    for fill in fills:
        wrench = Tops.of(assembly, fill).resisting
        for block in np.flatnonzero(~assembly.fixed & wrench[:, :3].any(axis=1)).tolist():
            force, moment = wrench[block, :3], wrench[block, 3:]
            size = float(np.linalg.norm(force))
            at = assembly.centroid[block] + np.cross(force, moment) / size**2
            near = int(supports[lengths(assembly.centroid[supports] - at).argmin()])
            end = at + force / size * assembly.size[block]
            model = tied(model, block, near, size, at, end, fill=True)
    notes = tuple(note for note in model.notes if note not in fills[0].notes)  # it counts now
    return replace(model, notes=notes)


def _read(text: str, assembly: Assembly) -> tuple[int, int, float, _End, _End]:
    """The blocks of a tie, its strength [N], and its ends (3,) [m] where they are given."""
    known = "|".join(map(re.escape, sorted(assembly.names, key=len, reverse=True)))
    end = rf"\s*({known}|[^:@]*?)\s*(?:@([^:]*))?"  # names may have colons
    found = re.fullmatch(rf"{end}:{end}(?::([^:]*))?", text)
    if found is None:
        raise InputError("is no tie", remedy="write BLOCK:BLOCK:20kN, or fill")
    *ends, pull = found.groups()
    strength = NO_LIMIT if pull is None else measured(pull.strip(), FORCES, what="strength")
    if not strength > 0.0:
        raise InputError(f"strength is {pull}", remedy="give a force above zero, such as 20kN")
    names, places = ends[::2], ends[1::2]
    first, second = assembly.indices(names).tolist()
    if first == second or assembly.fixed[[first, second]].all():
        raise InputError("nothing is tied", remedy="name two blocks, one of them free")
    at, anchor = (position(one) if one else None for one in places)
    return first, second, strength, at, anchor


def _noted(model: Model, block: int, other: int, _: float, at: _End, anchor: _End) -> Model:
    """With a note on an end that lies outside a free block."""
    fixed, blocks = model.assembly.fixed, model.assembly.blocks
    ends = (i for i in ((block, at), (other, anchor)) if i[1] is not None and not fixed[i[0]])
    said = [note for i, place in ends for note in off_block(blocks[i], np.array([place]))]
    return replace(model, notes=(*model.notes, *said))


def joint_words(assembly: Assembly, contacts: Contacts, interface: int) -> tuple[str, str, str]:
    """What an interface is, which one of them, and what it does at its strength.

    Such as ``('joint', "joint of 'a' and 'b'", 'crushes')``.
    """
    a, b = (assembly.names[i] for i in contacts[interface].blocks)
    if contacts.of_fill[interface]:
        return "part of the fill", f"{_OF_FILL}'{b}'", "yields"
    what, fails = ("tie", "yields") if contacts.ties[interface] else ("joint", "crushes")
    return what, f"{what} of '{a}' and '{b}'", fails


_OF_FILL = "fill beside "
_RESISTING = (
    "give fill:cover=0.3m,weight=20kN/m3,passive=1 as a load (--load; a file of combinations can "
    "have the same as a case)"
)


def strengths(assembly: Assembly, contacts: Contacts) -> dict[str, float]:
    """The pull [N] at which each tie yields, by its blocks; infinite without a limit.

    Several of the same blocks are numbered.
    """
    ties = contacts.select(contacts.ties)
    pairs = [
        joint_words(assembly, ties, i)[1] if fill
        else ":".join(assembly.names[j] for j in reversed(ties[i].blocks))
        for i, fill in enumerate(ties.of_fill.tolist())
    ]  # fmt: skip
    again = [pairs[:i].count(pair) for i, pair in enumerate(pairs)]
    told = [f"{pair} ({n + 1})" if n else pair for pair, n in zip(pairs, again, strict=True)]
    return dict(zip(told, ties.tie_strength.tolist(), strict=True))


def ties_told(ties: Mapping[str, float]) -> str:
    """Ties with their strengths, in words; those of fill in one."""
    fill = {one: pull for one, pull in ties.items() if one.startswith(_OF_FILL)}
    told = [
        one if np.isinf(pull) else f"{one} {quantity(pull, 'N')}"
        for one, pull in ties.items()
        if one not in fill
    ]
    if fill:
        blocks = named([one.removeprefix(_OF_FILL) for one in fill], 2)
        ends = " to ".join(quantity(end(fill.values()), "N") for end in (min, max))
        told.append(f"fill: {counted(len(fill), 'horizontal tie')} of blocks {blocks}, {ends}")
    return ", ".join(told)
