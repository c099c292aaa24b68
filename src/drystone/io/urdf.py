"""URDF, the robot description of ROS: one link per block, meshes in OBJ files beside it.

Source of the format: ROS documentation, urdf/XML.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from xml.sax.saxutils import quoteattr

from drystone.base.arrays import Floats, Ints
from drystone.base.errors import FormatError
from drystone.base.files import Job, PathLike, write_text, write_together
from drystone.io.draft import Contents
from drystone.io.simulator_bodies import SimulatorBody, bodies, model_of
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
