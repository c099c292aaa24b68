"""MJCF, the model format of MuJoCo: one file, meshes inside.

Its bodies are read with their poses, masses and friction.

What collides is read; a body without a joint is fixed, one with a free joint is a block. A mesh is
taken as it is, where MuJoCo takes its convex hull. Other joints, and elements that MuJoCo expands,
are refused: ``mujoco.mj_saveLastXML`` writes a scene in which they are expanded.

Source of the format: MuJoCo documentation, XML reference.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import cached_property, partial
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from scipy.spatial.transform import Rotation

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, number, unit
from drystone.base.errors import FormatError, InputError
from drystone.base.files import PathLike, write_text
from drystone.io.draft import Contents, Draft, Extras
from drystone.io.simulator_bodies import (
    MeshesBeside,
    Part,
    PlacedBody,
    bodies,
    box_part,
    cylinder_part,
    gravity_of,
    hull_part,
    model_of,
    placed,
    shapes_of_bodies,
    volume_of,
)
from drystone.io.xml_tree import along, axes, number_of, numbers, pose_of, quaternion, root_of
from drystone.loads import LoadCase
from drystone.model import Model

_TIME_STEP = 0.001
"""[s], chosen: contacts are stiff, and a block of 0.1 m falls over in a tenth of a second."""


def mjcf_text(model: Model, *, name: str = "drystone", contact_s: float = 0.02) -> str:
    """A model as MJCF.

    Fixed blocks are fixed to the world, free ones have a free joint, each with a mesh for every
    convex piece. None begins inside another; a comment in the file says how deep they were drawn in
    each other. The smallest friction coefficient of the model is used for all joints, since
    MuJoCo has one per body. Contacts have several points (multiccd). MuJoCo's options against creep
    (impratio, noslip) are not used: with them stable vaults flew apart.

    Parameters
    ----------
    model
        Its load is one acceleration of all masses.
    name
        Name of the model.
    contact_s : [s]
        Time constant of contacts; MuJoCo's own when left out. With a smaller value blocks creep
        less. But a statue of 399 blocks flew apart with 0.01, since its contacts were too stiff for
        the time step, and some large vaults did below 0.005.

    Raises
    ------
    InputError
        The load differs from block to block, or ``contact_s`` is not above zero.

    Examples
    --------
    >>> from drystone.models import tower
    >>> text = mjcf_text(Model.of(tower(2), friction=0.7))
    >>> text.count("<body"), text.count("<freejoint")
    (2, 1)
    """
    if not number(contact_s, "contact_s") > 0.0:
        raise InputError(f"contact_s is {contact_s}", remedy="give seconds above zero")
    found, said = bodies(model)
    friction = float(model.contacts.friction.min(initial=np.inf))
    friction = friction if np.isfinite(friction) else 0.6
    lines = [
        f"<mujoco model={quoteattr(name)}>",
        *([f"  <!-- {said} -->"] if said else []),
        f'  <option timestep="{_TIME_STEP:g}" gravity="{_numbers(gravity_of(model))}" '
        'cone="elliptic" solver="Newton" iterations="100" tolerance="1e-12">',
        '    <flag multiccd="enable"/>',
        "  </option>",
        '  <compiler inertiafromgeom="false" balanceinertia="true"/>',
        "  <default>",
        f'    <geom type="mesh" condim="3" friction="{friction:g} 0 0" solref="{contact_s:g} 1" '
        'solimp="0.99 0.999 0.0001" rgba="0.85 0.83 0.79 1"/>',
        "  </default>",
        "  <asset>",
    ]
    for body in found:
        for k, (point, _) in enumerate(body.pieces):
            mesh = quoteattr(f"{body.name}.{k}")
            lines.append(f'    <mesh name={mesh} vertex="{_numbers(point.ravel())}"/>')
    lines += ["  </asset>", "  <worldbody>", '    <light pos="0 0 20" dir="0 0 -1"/>']
    for body in found:
        lines.append(f'    <body name={quoteattr(body.name)} pos="{_numbers(body.place)}">')
        if not body.fixed:
            lines.append("      <freejoint/>")
        inertia = body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        lines.append(
            f'      <inertial pos="0 0 0" mass="{body.mass:.12g}" '
            f'fullinertia="{_numbers(inertia)}"/>'
        )
        for k in range(len(body.pieces)):
            colour = ' rgba="0.34 0.71 0.91 1"' if body.fixed else ""
            lines.append(f"      <geom mesh={quoteattr(f'{body.name}.{k}')}{colour}/>")
        lines.append("    </body>")
    lines += ["  </worldbody>", "</mujoco>", ""]
    return "\n".join(lines)


def write(contents: Contents, path: Path) -> None:
    """Write what a file holds as MJCF."""
    write_mjcf(model_of(contents), path)


def write_mjcf(
    model: Model, path: PathLike, *, name: str = "drystone", contact_s: float = 0.02
) -> None:
    """Write a model as MJCF, to a temporary name beside it that is then renamed.

    Parameters
    ----------
    model, name, contact_s
        See :func:`mjcf_text`.
    path
    """
    write_text(path, mjcf_text(model, name=name, contact_s=contact_s))


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.9g}" for value in values.tolist())


_USUAL_GRAVITY = np.array([0.0, 0.0, -9.81])
_DENSITY, _FRICTION = 1000.0, 1.0
"""[kg/m3] and coefficient where a geom has none. Source: MuJoCo documentation, XML reference."""
_EXPANDED = ("include", "replicate", "composite", "flexcomp", "attach")
_UNREAD = ("contact", "deformable", "tendon")
_EXPAND = "save the scene by mujoco.mj_saveLastXML, which expands it"


def read(data: bytes, path: Path) -> Draft:
    """Blocks of an MJCF file."""
    return _Reader(root_of(data, path, "mujoco", "MJCF"), path).draft()


class _Reader:
    """A scene on its way to a draft."""

    def __init__(self, root: ET.Element, path: Path) -> None:
        self.root, self.path = root, path
        self.compiler = {k: v for one in root.iter("compiler") for k, v in one.attrib.items()}
        self.found: list[PlacedBody] = []
        self.beside = MeshesBeside(path)
        self.classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for one in root.findall("default"):
            self._learn(one, self.classes["main"], "main")

    def draft(self) -> Draft:
        """The draft of all bodies."""
        for one in self.root.iter():
            if one.tag in _EXPANDED:
                raise FormatError(f"has '{one.tag}'", where=str(self.path), remedy=_EXPAND)
        for world in self.root.findall("worldbody"):
            self._inside(world, np.eye(4), None, "main", weighed=False)
        self._weld()
        shapes, notes = shapes_of_bodies(self.found, self.path)
        if len({min(body.friction) for body in self.found if body.friction}) > 1:
            notes.append("of two bodies MuJoCo takes the larger friction, a joint here the smaller")
        notes += [f"'{tag}' is not read" for tag in _UNREAD if self.root.find(tag) is not None]
        load, said = self._gravity()
        return Draft(tuple(shapes), "m", load, notes=(*notes, *said))

    def _gravity(self) -> tuple[partial[Extras] | None, list[str]]:
        """What makes the load of the file where it is not the usual one, and a note."""
        gravity = _USUAL_GRAVITY
        for one in self.root.findall("option"):
            gravity = numbers(one.attrib, "gravity", 3, gravity, f"{self.path}, option")
        if not gravity.any():
            return None, ["gravity is off in the file: 9.81 m/s2 along -z is assumed"]
        usual = bool((gravity == _USUAL_GRAVITY).all())
        return None if usual else partial(_loaded, gravity), []

    def _learn(self, element: ET.Element, above: dict[str, dict[str, str]], name: str) -> None:
        """Defaults of a class and of those within it."""
        own = {tag: dict(told) for tag, told in above.items()}
        for one in element:
            if one.tag != "default":
                own[one.tag] = own.get(one.tag, {}) | one.attrib
        self.classes[name] = own
        for one in element.findall("default"):
            self._learn(one, own, one.get("class", ""))

    def _told(self, element: ET.Element, name: str) -> dict[str, str]:
        """Attributes of an element with those of its class."""
        chosen = element.get("class", name)
        if chosen not in self.classes:
            raise FormatError(
                f"there is no class '{chosen}'", where=str(self.path), remedy="add its default"
            )
        return self.classes[chosen].get(element.tag, {}) | element.attrib

    def _inside(
        self, element: ET.Element, pose: Floats, of: PlacedBody | None, name: str, *, weighed: bool
    ) -> None:
        """Everything in a body, a frame or the world.

        Parameters
        ----------
        element
        pose : (4, 4)
        of
            What it moves with; ``None`` in the world.
        name
            Class of the elements that have none of their own.
        weighed
            Whether the mass of the body is known, so that its geoms add none.
        """
        name = element.get("childclass", name)
        for one in element:
            where = f"{self.path}, {one.tag} '{one.get('name', len(self.found))}'"
            if one.tag == "frame":
                at = pose @ self._pose(one.attrib, where)
                self._inside(one, at, of, name, weighed=weighed)
            elif one.tag == "body":
                at = pose @ self._pose(one.attrib, where)
                own = self._body(one, of, where, one.get("childclass", name))
                self._inside(one, at, own, name, weighed=one.find("inertial") is not None)
            elif one.tag == "geom":
                told = self._told(one, name)
                if told.get("contype") == "0" and told.get("conaffinity") == "0":
                    continue
                held = of
                if held is None:
                    usual = "ground" if told.get("type") == "plane" else f"geom-{len(self.found)}"
                    held = PlacedBody(told.get("name", usual), True, where)
                    self.found.append(held)
                self._geom(told, pose @ self._pose(told, where), held, where, weighed)

    def _body(self, body: ET.Element, of: PlacedBody | None, where: str, name: str) -> PlacedBody:
        """What a body moves with, its mass added: itself, or the body that it is joined to."""
        own, free = of, self._is_free(body, where, name)
        if own is None or own.fixed or free:
            own = PlacedBody(body.get("name", f"body-{len(self.found)}"), not free, where)
            self.found.append(own)
        inertial = body.find("inertial")
        if inertial is not None:
            own.mass += number_of(inertial.attrib, "mass", None, where)
        return own

    def _is_free(self, body: ET.Element, where: str, name: str) -> bool:
        kinds = [self._told(one, name).get("type", "hinge") for one in body.findall("joint")]
        kinds += ["free" for _ in body.findall("freejoint")]
        other = [kind for kind in kinds if kind != "free"]
        if other:
            raise FormatError(
                f"moves on a joint of type {other[0][:20]}, and blocks are loose or fixed",
                where=where,
                remedy="give it a freejoint, or no joint",
            )
        return bool(kinds)

    def _geom(
        self, told: dict[str, str], at: Floats, of: PlacedBody, where: str, weighed: bool
    ) -> None:
        kind = told.get("type", "sphere")
        of.friction.append(number_of(told, "friction", _FRICTION, where))
        if kind == "plane":
            if not of.fixed:
                raise FormatError("a plane cannot move", where=where, remedy="put it in the world")
            of.planes.append(at)
            return
        if kind == "mesh":
            named = told.get("mesh", "")
            if named not in self._meshes:
                what = f"there is no mesh '{named[:40]}'"
                raise FormatError(what, where=where, remedy="add its asset")
            made = self.beside.counted(self._meshes[named])
        else:
            solid, turned = _primitive(kind, told, where)
            made, at = [solid], at @ turned
        parts = [placed(part, at) for part in made]
        of.parts += parts
        if not weighed:
            density = number_of(told, "density", _DENSITY, where)
            usual = density * sum(volume_of(*part) for part in parts)
            of.mass += number_of(told, "mass", usual, where)

    @cached_property
    def _meshes(self) -> dict[str, list[Part]]:
        """Parts of each mesh of the assets, by name."""
        made: dict[str, list[Part]] = {}
        folder = self.compiler.get("meshdir", self.compiler.get("assetdir", ""))
        for place, one in enumerate(self.root.findall("asset/mesh")):
            told = self._told(one, "main")
            where = f"{self.path}, mesh '{told.get('name', place)}'"
            file = told.get("file", "")
            if file:
                name = f"{folder}/{file}" if folder else file
                parts = self.beside.parts(name, where)
            else:
                parts = [_inline(told, where)]
            scale = np.diag(numbers(told, "scale", 3, np.ones(3), where))
            turn = numbers(told, "refquat", 4, np.array([1.0, 0.0, 0.0, 0.0]), where)
            off = numbers(told, "refpos", 3, np.zeros(3), where)
            back = pose_of(quaternion(turn, where), off)
            sized = np.linalg.inv(back) @ pose_of(scale, np.zeros(3))
            made[told.get("name", Path(file).stem)] = [placed(part, sized) for part in parts]
        return made

    def _pose(self, told: dict[str, str], where: str) -> Floats:
        """The pose (4, 4) of an element in the one around it."""
        return pose_of(self._turn(told, where), numbers(told, "pos", 3, np.zeros(3), where))

    def _turn(self, told: dict[str, str], where: str) -> Floats:
        """The rotation (3, 3) of an element, in any of the ways to write it."""
        turn = 1.0 if self.compiler.get("angle") == "radian" else np.pi / 180.0
        if "quat" in told:
            return quaternion(numbers(told, "quat", 4, None, where), where)
        if "axisangle" in told:
            value = numbers(told, "axisangle", 4, None, where)
            vector = unit(value[None, :3])[0][0] * value[3] * turn
            return np.asarray(Rotation.from_rotvec(vector).as_matrix())
        if "euler" in told:
            order = self.compiler.get("eulerseq", "xyz")
            return _euler(order, turn * numbers(told, "euler", 3, None, where), where)
        if "xyaxes" in told:
            x, y = numbers(told, "xyaxes", 6, None, where).reshape(2, 3)
            return axes(np.cross(x, y), x, where)
        if "zaxis" in told:
            return along(numbers(told, "zaxis", 3, None, where), where)
        return np.eye(3)

    def _weld(self) -> None:
        """Bodies that an equality holds to the world are fixed; other equalities are refused."""
        names = {one.name: one for one in self.found}
        for one in self.root.findall("equality/*"):
            ends = {one.get("body1", ""), one.get("body2", "world")} - {"world"}
            if one.get("active") == "false":
                continue
            if one.tag != "weld" or len(ends) != 1 or not ends <= names.keys():
                raise FormatError(
                    f"has the equality '{one.tag}'",
                    where=str(self.path),
                    remedy="leave it out: only a weld of a body to the world is read",
                )
            names[ends.pop()].fixed = True


def _euler(order: str, angles: Floats, where: str) -> Floats:
    """The rotation (3, 3) of angles (3,) [rad] about axes: fixed ones where they are capitals."""
    if len(order) != 3 or set(order.lower()) - set("xyz"):
        raise FormatError(f"eulerseq is '{order[:20]}'", where=where, remedy="write xyz")
    matrix = np.eye(3)
    for axis, angle in zip(order, angles, strict=True):
        step = Rotation.from_rotvec(angle * np.eye(3)["xyz".index(axis.lower())]).as_matrix()
        matrix = matrix @ step if axis.islower() else step @ matrix
    return matrix


def _loaded(gravity: Floats, assembly: Assembly, _: float) -> Extras:
    size = float(np.linalg.norm(gravity))
    direction = (gravity[0], gravity[1], gravity[2])
    return None, (LoadCase.gravity(assembly, size, direction=direction),), ()


def _primitive(kind: str, told: dict[str, str], where: str) -> tuple[Part, Floats]:
    """A box or a cylinder about the origin, and where its ``fromto`` puts it (4, 4)."""
    count = {"box": 3, "cylinder": 2}.get(kind)
    if count is None or "mesh" in told:
        round_ = kind in ("sphere", "capsule", "ellipsoid")
        raise FormatError(
            f"is a geom of type {kind[:20]}" + (", which rolls" if round_ else ""),
            where=where,
            remedy="use boxes, cylinders, meshes and planes",
        )
    size, pose = numbers(told, "size", None, None, where), np.eye(4)
    if "fromto" in told:
        start, end = numbers(told, "fromto", 6, None, where).reshape(2, 3)
        pose = pose_of(along(start - end, where), 0.5 * (start + end))
        half = 0.5 * float(np.linalg.norm(end - start))
        size = np.array([*np.repeat(size[:1], count - 1), half])  # a box is square then, as there
    if len(size) < count or not (size[:count] > 0.0).all():
        raise FormatError(
            f"its size is '{told.get('size', '')[:40]}'", where=where, remedy=f"write {count} sizes"
        )
    if kind == "box":
        return box_part(size[:3]), pose
    return cylinder_part(size[0], size[1]), pose


def _inline(told: dict[str, str], where: str) -> Part:
    """A mesh whose vertices, and perhaps faces, are in the file."""
    values = numbers(told, "vertex", None, None, where)
    if len(values) % 3:
        raise FormatError(f"'vertex' has {len(values)} numbers", where=where, remedy="write x y z")
    point = values.reshape(-1, 3)
    if "face" not in told:
        return hull_part(point, where)
    face = numbers(told, "face", None, None, where)
    within = (face >= 0.0) & (face < len(point)) & (face == np.rint(face))
    if len(face) % 3 or not within.all():
        raise FormatError("'face' names no vertex", where=where, remedy="count from 0")
    return point, [tuple(one) for one in face.astype(int).reshape(-1, 3).tolist()]
