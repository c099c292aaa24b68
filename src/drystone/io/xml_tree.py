"""XML files of scenes: parsed without entities, numbers with their place in errors."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.base.arrays import FARTHEST, Floats, unit
from drystone.base.errors import FormatError


def root_of(data: bytes, path: Path, tag: str, what: str) -> ET.Element:
    """The root element of a file, its tags without namespaces.

    Parameters
    ----------
    data, path
    tag
        That the root must have.
    what
        Name of the format, for errors.

    Raises
    ------
    FormatError
        No XML, with entities of its own, or with another root.
    """
    plain = data.replace(b"\0", b"")  # of UTF-16
    if b"<!DOCTYPE" in plain or b"<!ENTITY" in plain:
        raise FormatError("defines entities", where=str(path), remedy="save it without a DOCTYPE")
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise FormatError(
            f"is no XML: {error}", where=str(path), remedy="export it again"
        ) from error
    for one in root.iter():
        one.tag = one.tag.rpartition("}")[2]
    if root.tag != tag:
        raise FormatError(
            f"is XML, but no {what}: its root is '{root.tag}' in place of '{tag}'",
            where=str(path),
            remedy="check its suffix: .xml is MJCF, .urdf is URDF, .dae is COLLADA",
        )
    return root


def numbers(
    told: Mapping[str, str], key: str, count: int | None, default: Floats | None, where: str
) -> Floats:
    """The numbers (count,) of an attribute; any number of them where ``count`` is ``None``.

    Raises
    ------
    FormatError
        Missing without a default, other than numbers, or another number of them.
    """
    text = told.get(key)
    if text is None:
        if default is None:
            raise FormatError(f"has no '{key}'", where=where, remedy="write it")
        return default
    try:
        plain = text.isascii() and "_" not in text
        values = np.array([float(word) for word in text.split()] if plain else [np.nan])
    except ValueError:
        values = np.array([np.nan])
    if not (np.abs(values) <= FARTHEST).all() or (count is not None and len(values) != count):
        due = "numbers" if count is None else "a number" if count == 1 else f"{count} numbers"
        raise FormatError(f"'{key}' is '{text[:40]}'", where=where, remedy=f"write {due}")
    return values


def number_of(told: Mapping[str, str], key: str, default: float | None, where: str) -> float:
    """The first number of an attribute; see :func:`numbers`."""
    usual = None if default is None else np.array([default])
    values = numbers(told, key, None, usual, where)
    if not len(values):
        raise FormatError(f"'{key}' is empty", where=where, remedy="write a number")
    return float(values[0])


def pose_of(rotation: Floats, place: Floats) -> Floats:
    """A matrix (4, 4) of a rotation (3, 3) and a place (3,)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, place
    return pose


def quaternion(values: Floats, where: str) -> Floats:
    """The rotation (3, 3) of a quaternion (4,), its real part first.

    Raises
    ------
    FormatError
        It is zero.
    """
    if not values.any():
        raise FormatError("its quaternion is zero", where=where, remedy="write 1 0 0 0")
    return np.asarray(Rotation.from_quat(np.roll(values / np.abs(values).max(), -1)).as_matrix())


def along(z: Floats, where: str) -> Floats:
    """The least rotation (3, 3) of the z axis to a direction (3,)."""
    if not z.any():
        raise FormatError("a direction is zero", where=where, remedy="write another")
    way = unit(z[None])[0][0]
    if way[2] <= -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    return np.asarray(Rotation.align_vectors(way[None], np.eye(3)[2:])[0].as_matrix())


def axes(z: Floats, x: Floats, where: str) -> Floats:
    """The rotation (3, 3) to axes along x and z (3,), which are square to each other."""
    if not z.any():
        raise FormatError("two axes are parallel", where=where, remedy="write others")
    x, z = unit(np.stack([x, z]))[0]
    return np.stack([x, np.cross(z, x), z], axis=1)
