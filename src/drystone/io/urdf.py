"""URDF, the robot description of ROS: one link per block, meshes in OBJ files beside it.

Its links are read as blocks.

A link that fixed joints hold to ``world``, or to a root without a shape, is fixed. One on a
floating joint is a block, with those that fixed joints hold to it. Other joints are refused, and so
is xacro, which has to be expanded first. Collision shapes are read, of a link without one its
visual shapes.

Source of the format: ROS documentation, urdf/XML.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TypeAlias
from xml.sax.saxutils import quoteattr

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import FormatError
from drystone.base.files import Job, PathLike, write_text, write_together
from drystone.io.draft import Contents, Draft
from drystone.io.simulator_bodies import (
    MeshesBeside,
    Part,
    PlacedBody,
    SimulatorBody,
    bodies,
    box_part,
    cylinder_part,
    model_of,
    placed,
    shapes_of_bodies,
)
from drystone.io.xml_tree import number_of, numbers, pose_of, root_of
from drystone.model import Model


def write(contents: Contents, path: Path) -> None:
    """Write what a file holds as URDF."""
    write_urdf(model_of(contents), path)


def write_urdf(model: Model, path: PathLike, *, name: str = "drystone") -> list[str]:
    """Write a model as URDF, with a folder of meshes whose name ends in ``_meshes``.

    The link ``world`` has a fixed joint to each fixed block and a floating joint to each free
    block. The format has no friction and no gravity.

    Parameters
    ----------
    model
    path
    name
        Name of the robot.

    Returns
    -------
    list of str
        The files that were written.
    """
    target = Path(path)
    folder = target.with_name(f"{target.stem}_meshes")
    found, said = bodies(model)
    if not target.parent.is_dir():
        raise FormatError(
            f"there is no folder '{target.parent}'", where=str(target), remedy="make it first"
        )
    jobs: list[Job] = []
    for body in found:
        for k, (point, triangle) in enumerate(body.pieces):
            text = _obj(point, triangle)
            jobs.append((folder / f"{body.name}.{k}.obj", partial(write_text, text=text)))
    jobs.append((target, partial(write_text, text=_urdf(found, folder.name, name, said))))
    return write_together(jobs, into=folder)


def _urdf(found: list[SimulatorBody], folder: str, name: str, said: str) -> str:
    lines = ['<?xml version="1.0"?>', f"<robot name={quoteattr(name)}>"]
    lines += [f"  <!-- {said} -->"] if said else []
    lines.append('  <link name="world"/>')
    for body in found:
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = body.inertia.tolist()
        lines += [
            f"  <link name={quoteattr(body.name)}>",
            "    <inertial>",
            f'      <mass value="{body.mass:.12g}"/>',
            f'      <inertia ixx="{xx:.9g}" ixy="{xy:.9g}" ixz="{xz:.9g}" iyy="{yy:.9g}" '
            f'iyz="{yz:.9g}" izz="{zz:.9g}"/>',
            "    </inertial>",
        ]
        for k in range(len(body.pieces)):
            mesh = quoteattr(f"{folder}/{body.name}.{k}.obj")
            for kind in ("visual", "collision"):
                lines.append(f"    <{kind}><geometry><mesh filename={mesh}/></geometry></{kind}>")
        x, y, z = body.place.tolist()
        kind = "fixed" if body.fixed else "floating"
        lines += [
            "  </link>",
            f"  <joint name={quoteattr('to-' + body.name)} type={quoteattr(kind)}>",
            '    <parent link="world"/>',
            f"    <child link={quoteattr(body.name)}/>",
            f'    <origin xyz="{x:.9g} {y:.9g} {z:.9g}" rpy="0 0 0"/>',
            "  </joint>",
        ]
    return "\n".join([*lines, "</robot>", ""])


def _obj(point: Floats, triangle: Ints) -> str:
    corners = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in point.tolist()]
    faces = [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangle.tolist()]
    return "\n".join([*corners, *faces, ""])


_WORLD = "world"
_Joints: TypeAlias = dict[str, tuple[str, bool, Floats]]
"""By link its parent, whether it floats, and its pose (4, 4) in that of the parent."""


def read(data: bytes, path: Path) -> Draft:
    """Blocks of a URDF file."""
    if b"xacro:" in data:
        raise FormatError(
            "is xacro, a program that makes URDF",
            where=str(path),
            remedy="expand it: xacro robot.urdf.xacro > robot.urdf",
        )
    root = root_of(data, path, "robot", "URDF")
    links = {one.get("name", ""): one for one in root.findall("link")}
    joints = _joints(root, links, path)
    made = [one for one in _bodies(links, joints, path) if one.parts or one.name in joints]
    shapes, notes = shapes_of_bodies(made, path)
    return Draft(tuple(shapes), "m", notes=tuple(notes))


def _bodies(links: dict[str, ET.Element], joints: _Joints, path: Path) -> Iterable[PlacedBody]:
    """What moves as one, and each fixed link."""
    bodies: dict[str, PlacedBody] = {}
    beside = MeshesBeside(path)
    for name, link in links.items():
        where = f"{path}, link '{name}'"
        pose, holder = _placed(name, joints, where)
        fixed = holder not in joints and (holder == _WORLD or not _shapes(links[holder]))
        group = name if fixed else holder
        body = bodies.setdefault(group, PlacedBody(group, fixed, where))
        body.fixed, body.where = fixed, where
        body.parts += _solids(link, pose, beside, where)
        body.mass += _mass(link, where)
    return bodies.values()


def _solids(link: ET.Element, pose: Floats, beside: MeshesBeside, where: str) -> list[Part]:
    """The solids of the shapes of a link, in the world."""
    own = [part for one in _shapes(link) for part in _parts(one, beside, where)]
    return [placed(part, pose) for part in own]


def _mass(link: ET.Element, where: str) -> float:
    """The mass [kg] of a link, zero where it has none."""
    weight = link.find("inertial/mass")
    return 0.0 if weight is None else number_of(weight.attrib, "value", None, where)


def _joints(root: ET.Element, links: dict[str, ET.Element], path: Path) -> _Joints:
    joints: _Joints = {}
    for one in root.findall("joint"):
        where = f"{path}, joint '{one.get('name', '')}'"
        ends = [one.find(end) for end in ("parent", "child")]
        parent, child = ("" if end is None else end.get("link", "") for end in ends)
        if parent not in links or child not in links or child in joints:
            raise FormatError(
                f"joins '{child}' to '{parent}'",
                where=where,
                remedy="name two links, and each as a child once",
            )
        kind = one.get("type", "")
        if kind not in ("fixed", "floating"):
            raise FormatError(
                f"is of type '{kind}', and blocks are loose or fixed",
                where=where,
                remedy="make it floating or fixed",
            )
        joints[child] = (parent, kind == "floating", _pose(one, where))
    return joints


def _placed(name: str, joints: _Joints, where: str) -> tuple[Floats, str]:
    """The pose (4, 4) of a link in the world, and the link that it moves with."""
    pose, holder, at = np.eye(4), "", name
    seen: set[str] = set()
    while at in joints:
        parent, floats, own = joints[at]
        pose = own @ pose
        if floats and not holder:
            holder = at
        if at in seen:
            raise FormatError("hangs on itself", where=where, remedy="make the joints a tree")
        seen.add(at)
        at = parent
    return pose, holder or at


def _shapes(link: ET.Element) -> list[ET.Element]:
    return link.findall("collision") or link.findall("visual")


def _parts(shape: ET.Element, beside: MeshesBeside, where: str) -> list[Part]:
    """The solids of a shape, in the frame of its link."""
    pose = _pose(shape, where)
    for one in shape.findall("geometry/*"):
        if one.tag == "box":
            return [placed(box_part(0.5 * _sizes(one, "size", 3, where)), pose)]
        if one.tag == "cylinder":
            radius, length = (float(_sizes(one, key, 1, where)[0]) for key in ("radius", "length"))
            return [placed(cylinder_part(radius, 0.5 * length), pose)]
        if one.tag == "mesh":
            name = one.get("filename", "").removeprefix("file://")
            if name.startswith("package://"):
                name = _in_package(name.removeprefix("package://"), beside.path)
            scale = np.diag(numbers(one.attrib, "scale", 3, np.ones(3), where))
            sized = pose @ pose_of(scale, np.zeros(3))
            return [placed(part, sized) for part in beside.parts(name, where)]
        rolls = ", which rolls" if one.tag in ("sphere", "capsule") else ""
        raise FormatError(
            f"has the shape '{one.tag}'{rolls}", where=where, remedy="use box, cylinder or mesh"
        )
    raise FormatError("a shape has no geometry", where=where, remedy="use box, cylinder or mesh")


def _in_package(name: str, path: Path) -> str:
    """The path of a mesh of a package from the folder of the file, which is in the package."""
    package, _, rest = name.partition("/")
    return rest if path.parent.name == package else f"../{rest}"


def _sizes(told: ET.Element, key: str, count: int, where: str) -> Floats:
    values = numbers(told.attrib, key, count, None, where)
    if not (values > 0.0).all():
        raise FormatError(f"'{key}' is not above zero", where=where, remedy="give metres")
    return values


def _pose(element: ET.Element, where: str) -> Floats:
    """The pose (4, 4) of the origin of a joint or a shape."""
    told = element.find("origin")
    if told is None:
        return np.eye(4)
    place = numbers(told.attrib, "xyz", 3, np.zeros(3), where)
    turn = Rotation.from_euler("xyz", numbers(told.attrib, "rpy", 3, np.zeros(3), where))
    return pose_of(turn.as_matrix(), place)
