"""USD in: the rigid bodies of a stage are blocks, what has no rigid body is fixed.

Meshes, cubes, cylinders and planes are read, those that collide where the stage says which do; with
unit and upward axis of the stage, masses, densities and friction. In a stage without rigid bodies
nothing is fixed. The file is read alone: what it refers to has to be in it. Needs usd-core.

Source of the format: OpenUSD documentation, UsdGeom and UsdPhysics.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import numpy as np

from drystone.base.arrays import FARTHEST, Floats
from drystone.base.errors import FormatError, require
from drystone.io.draft import Draft
from drystone.io.jsontext import Field, parse
from drystone.io.outside import Unfolded, content_of
from drystone.io.simulator_bodies import (
    Part,
    PlacedBody,
    box_part,
    cylinder_part,
    placed,
    shapes_of_bodies,
)

PROGRAM = Path(__file__).with_name("usd_extract.py")
WALL_S = 10.0
_UP = {
    "Z": np.eye(4),
    "Y": np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]]),
}
_ALONG = {
    "X": np.array([[0, 0, 1.0, 0], [1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]]),
    "Y": np.array([[0, 1.0, 0, 0], [0, 0, 1.0, 0], [1.0, 0, 0, 0], [0, 0, 0, 1.0]]),
    "Z": np.eye(4),
}
"""Rotations of the z axis to the axis of a cylinder or a plane."""


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a USD file."""
    require("pxr", "usd", "reading USD")
    if path.suffix.lower() == ".usdz":
        _refuse_packed(data, path)
    top = parse(content_of(data, path, PROGRAM, {"suffix": path.suffix.lower()}, WALL_S), path)
    if top.has("error"):
        raise _unread(top, path)
    for joint in top["joints"].elements():
        raise FormatError(
            f"has a joint of type {joint.text()}, and blocks are loose or fixed",
            where=str(path),
            remedy="leave it out, or make it a fixed joint to the world",
        )
    scale, up = top["scale"].number(), top["up"].text()
    if not scale > 0.0 or up not in _UP:
        raise FormatError("has an odd unit or axis", where=str(path), remedy="set metersPerUnit")
    world = np.diag([scale, scale, scale, 1.0]) @ _UP[up]
    moves = top["moves"].boolean()
    bodies: list[PlacedBody] = []
    unfolded = Unfolded(path)
    for one in top["bodies"].elements():
        bodies.append(_body(one, world, moves, path))
        for point, faces in bodies[-1].parts:
            unfolded.take(len(point), len(faces))
    shapes, notes = shapes_of_bodies(bodies, path)
    if not moves:
        notes.append("it has no rigid bodies: nothing is fixed but planes")
    return Draft(tuple(shapes), "m", notes=tuple(notes))


def _unread(top: Field, path: Path) -> FormatError:
    """Why a stage cannot be read."""
    if what := top["error"].text():
        remedy = "flatten it into one file: usdcat --flatten IN --out OUT.usdc"
        return FormatError(what, where=str(path), remedy=remedy)
    if not top.has("line"):
        remedy = "export it again, or check its suffix"
        return FormatError("is no USD file that can be read", where=str(path), remedy=remedy)
    where = f"{path}, line {top['line'].text()}"
    what = f"'{top['text'].text()[:40]}' is no USD text"
    return FormatError(what, where=where, remedy="mend this line or the one before it")


def _refuse_packed(data: bytes, path: Path) -> None:
    """Refuse an archive that would unpack to more than it holds: files of USDZ are not packed."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            unpacked = sum(one.file_size for one in archive.infolist())
    except (zipfile.BadZipFile, ValueError, NotImplementedError) as error:
        raise FormatError("is no USDZ archive", where=str(path), remedy="save it again") from error
    if unpacked > len(data):
        raise FormatError(
            "its files are packed, which USDZ does not allow",
            where=str(path),
            remedy="save it again, such as by usdzip",
        )


def _body(one: Field, world: Floats, moves: bool, path: Path) -> PlacedBody:
    """A body with its planes."""
    where = f"{path}, prim '{one['path'].text()}'"
    fixed = moves and not one["free"].boolean()
    body = PlacedBody(one["name"].text(), fixed, where, mass=max(one["mass"].number(), 0.0))
    for part in one["parts"].elements():
        matrix = world @ part["matrix"].floats(4, 4).T
        if part["kind"].text() == "Plane":
            pose = matrix @ _ALONG.get(part["axis"].text(), np.eye(4))
            size = np.abs(pose[:3, :3]).max(axis=0)
            if not (size > 0.0).all() or not (np.abs(pose) <= FARTHEST).all():
                raise FormatError(
                    "a plane has no size, or is too far away",
                    where=where,
                    remedy="scale it otherwise",
                )
            pose[:3, :3] /= size  # squares of a tiny size would be zero
            pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)
            body.planes.append(pose)
        else:
            body.parts.append(placed(_part(part, where), matrix))
    if (density := one["density"].number()) > 0.0:
        body.density = density
    body.friction += [each.number() for each in one["friction"].elements()]
    return body


def _part(part: Field, where: str) -> Part:
    kind = part["kind"].text()
    if kind == "Cube":
        half = 0.5 * part["size"].number()
        return box_part(np.full(3, half))
    if kind == "Cylinder":
        solid = cylinder_part(part["radius"].number(), 0.5 * part["height"].number())
        return placed(solid, _ALONG.get(part["axis"].text(), np.eye(4)))
    if kind != "Mesh":
        rolls = ", which rolls" if kind in ("Sphere", "Capsule") else ""
        raise FormatError(
            f"is a {kind}{rolls}", where=where, remedy="use meshes, cubes, cylinders and planes"
        )
    return _mesh(part, where)


def _mesh(part: Field, where: str) -> Part:
    points = part["points"].floats(None, 3)
    corner = [each.integer() for each in part["faceVertexIndices"].elements()]
    count = [each.integer() for each in part["faceVertexCounts"].elements()]
    within = all(0 <= each < len(points) for each in corner) and min(count, default=3) >= 3
    if not within or sum(count) != len(corner):
        raise FormatError("a face has a vertex that does not exist", where=where, remedy="mend it")
    faces, at = [], 0
    turned = -1 if part["orientation"].text() == "leftHanded" else 1
    for each in count:
        faces.append(tuple(corner[at : at + each][::turned]))
        at += each
    return points, faces
