"""Joint capacities in words: one for all joints, or a table."""

from __future__ import annotations

import csv
from dataclasses import replace
from typing import Any

import numpy as np

from drystone.base import units
from drystone.base.errors import InputError, located
from drystone.base.files import read_bytes
from drystone.joint_capacity import DRY, NO_LIMIT, JointCapacity
from drystone.model import Model

_WHERE = "joint_capacity"
_EXAMPLE = "tension=0.1MPa,cohesion=0.2MPa or compression=5MPa"


def with_joint_capacity(model: Model, text: str) -> Model:
    """The model with the capacities of the option.

    Raises
    ------
    InputError
        It cannot be read, or names blocks that do not touch.
    """
    words, brittle = law_of(text)
    read = _of_table if words.lower().endswith(".csv") else _of_words
    found = read(model, words)
    if brittle is None:
        return model.with_capacity(found)
    if not found.law:
        raise InputError(
            f"'{text[:60]}' has no mortar that breaks or yields",
            where=_WHERE,
            remedy=f"give tension or cohesion, such as {_EXAMPLE}",
        )
    return model.with_capacity(replace(found, brittle=brittle))


def with_strength(model: Model, given: str | float) -> Model:
    """The model whose joints all crush under a pressure, in words or in Pa.

    Raises
    ------
    InputError
        It is none above zero.
    """
    where = "strength"
    with located(where):
        zero = not str(given).strip("0. ")  # it is refused in any unit
        plain = 1.0 if zero or not isinstance(given, str) else np.nan
        pressure = units.measured(str(given), units.PRESSURES, plain, where)
    if not 0.0 < pressure < np.inf:
        raise InputError(f"is {given}", where=where, remedy="give more than zero, such as 5MPa")
    before = model.contacts.capacity or JointCapacity.dry(model.contacts.count)
    return model.with_capacity(replace(before, compression=pressure * model.contacts.area))


def law_of(text: str) -> tuple[str, bool | None]:
    """The words without a last ``brittle`` or ``ductile``, and whether it is brittle, if told."""
    words, _, last = text.rpartition(",")
    known = {"brittle": True, "ductile": False}
    return (words, known[last.strip()]) if last.strip() in known else (text, None)


def _of_words(model: Model, text: str) -> JointCapacity:
    known = units.PRESSURES | units.FORCES, units.MOMENTS
    found: dict[str, float] = {}
    stress: dict[str, bool] = {}
    for part in text.split(","):
        name, equals, value = (one.strip() for one in part.partition("="))
        if not equals or name not in (*DRY, "moment") or name in found:
            raise InputError(f"'{part}' is no capacity", where=_WHERE, remedy=f"write {_EXAMPLE}")
        with located(_WHERE):
            found[name] = units.measured(value, known[name == "moment"], what=name)
        stress[name] = value.endswith("Pa")
    if found.get("compression", 1.0) <= 0.0:
        remedy = "give more than zero, such as 5MPa"
        raise InputError(f"compression is {found['compression']:g}", where=_WHERE, remedy=remedy)
    area = model.contacts.area
    strength: dict[str, Any] = {}
    forces: dict[str, Any] = {
        name: value * area if stress[name] else value for name, value in found.items()
    }
    if "compression" in forces:  # of edges, which have no area, it is zero
        strength = {"compression": np.broadcast_to(forces.pop("compression"), area.shape)}
    with located(_WHERE):
        return replace(JointCapacity.of(model.contacts, **forces), **strength)


def _of_table(model: Model, path: str) -> JointCapacity:
    lines = read_bytes(path).decode("utf-8-sig", "replace").splitlines()
    try:
        rows = list(csv.reader(lines, strict=True))
    except csv.Error as error:
        raise InputError(f"is no table: {error}", where=path, remedy="save it as CSV") from error
    expected = ["block_a", "block_b", *DRY]
    columns = [one.strip() for one in rows[0]] if rows else []
    known = columns[:2] == expected[:2] and set(columns) <= set(expected)
    if not known or len(set(columns)) < len(columns) or len(columns) < 3:
        raise InputError("has another first line", where=path, remedy=f"write {','.join(expected)}")
    contacts, names = model.contacts, model.assembly.names
    place = {name: i for i, name in enumerate(names)}
    told: dict[frozenset[int], int] = {}
    values: dict[str, Any] = {name: np.full(contacts.count, dry) for name, dry in DRY.items()}
    for number, row in enumerate(rows[1:], start=2):
        if not row:
            continue
        where = f"{path}, line {number}"
        if len(row) != len(columns):
            raise InputError(f"has {len(row)} values", where=where, remedy=f"give {len(columns)}")
        ends = [place.get(one.strip(), -1) for one in row[:2]]
        if min(ends) < 0:
            raise InputError("names no block", where=where, remedy="see 'drystone inspect'")
        own = ((contacts.block_a == ends[0]) & (contacts.block_b == ends[1])) | (
            (contacts.block_a == ends[1]) & (contacts.block_b == ends[0])
        )
        if not own.any():
            raise InputError("names two blocks that do not touch", where=where)
        if (first := told.setdefault(frozenset(ends), number)) < number:
            raise InputError(
                f"names the joint of line {first} again", where=where, remedy="give it once"
            )
        area = np.where(own, contacts.area, 0.0)
        share = area / area.sum() if area.any() else own / own.sum()
        for name, text in zip(columns[2:], row[2:], strict=True):
            if not text.strip():
                continue
            try:
                value = float(text)
            except ValueError:
                value = np.nan
            if not value >= 0.0:
                raise InputError(
                    f"{name} '{text[:40]}' is no number from 0 on", where=where, remedy="give N"
                )
            if name == "compression" and value == 0.0:
                remedy = "give N above 0, or an empty cell: it does not crush then"
                raise InputError("compression is 0", where=where, remedy=remedy)
            values[name][own] = NO_LIMIT if value >= NO_LIMIT else value * share[own]
    with located(path):
        return JointCapacity(**values)
