"""Interfaces in a COMPAS file: polygons with a frame whose z axis goes from block to block.

Forces at the corners of interfaces, as solved COMPAS assemblies and models store them.

Each corner has ``c_np`` and ``c_nn``, compression and tension, and ``c_u`` and ``c_v`` along the
axes of the interface. They act on the block towards which the axis z of the interface points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from drystone.answer import Verdict
from drystone.assembly import Assembly
from drystone.base.arrays import FARTHEST, SAME, Bools, Floats, Ints
from drystone.base.ragged import Ragged
from drystone.checks import check_forces, unbalanced_wrench
from drystone.contacts import DEFAULT_FRICTION, Contacts
from drystone.geometry.frames import area_vector, area_vectors, frames_from_normals
from drystone.io.draft import Extras
from drystone.io.jsontext import Field
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.results import Result

SEARCH = "drystone_detection"
"""The attribute of a graph that says with which tolerances its contacts were searched."""


def data_of(field: Field) -> Field:
    """The data of an object, with or without the wrapper of its type."""
    if not isinstance(field.value, dict) or "dtype" not in field.value:
        return field
    return field["data"] if "data" in field.value else field["value"]


def reader(
    graph: Field, keys: Sequence[str], nodes: Sequence[str]
) -> Callable[[Assembly, float], Extras] | None:
    """A function that makes the contacts and forces of a graph's edges; ``None`` without any.

    Parameters
    ----------
    graph
    keys
        Attributes of the edges: ``interfaces``, before ``interface``, in compas_assembly;
        ``contacts`` in compas_model.
    nodes
        Node of each block, by position.
    """
    position = {node: i for i, node in enumerate(nodes)}
    stored: list[tuple[int, int, Field]] = []
    for start, neighbours in graph.get("edge", {}).items():
        for end, edge in neighbours.items():
            for key in keys:
                if not isinstance(edge.value, dict) or not edge.has(key):
                    continue
                listed = isinstance(edge[key].value, list)
                for interface in edge[key].elements() if listed else [edge[key]]:
                    if start not in position or end not in position:
                        raise edge.error("joins nodes that are no blocks")
                    stored.append((position[start], position[end], interface))
    if not stored:
        return None

    def finish(assembly: Assembly, scale: float) -> Extras:
        contacts, turned, backwards = _contacts(stored, assembly, scale)
        given = [_forces(interface) for _, _, interface in stored]
        found = forces_of(given, contacts, turned, backwards)
        return contacts, (), solved(assembly, contacts, found)

    return finish


def _contacts(
    stored: Sequence[tuple[int, int, Field]], assembly: Assembly, scale: float
) -> tuple[Contacts, Bools, Bools]:
    """The contacts, which frames were turned, and which loops of corners run backwards."""
    block_a = np.array([a for a, _, _ in stored], dtype=np.intp)
    block_b = np.array([b for _, b, _ in stored], dtype=np.intp)
    corners = [scale * _points(field) for _, _, field in stored]
    frame = np.stack(
        [_frame(field, points) for (_, _, field), points in zip(stored, corners, strict=True)]
    )
    middle = np.array([points.mean(axis=0) for points in corners])
    side_a = ((assembly.centroid[block_a] - middle) * frame[:, 0]).sum(axis=1)
    side_b = ((assembly.centroid[block_b] - middle) * frame[:, 0]).sum(axis=1)
    turned = (side_a > 0.0) & (side_b < 0.0)  # with some writers the normal points from b to a
    frame[turned] *= np.array([-1.0, 1.0, -1.0])[:, None]
    contacts, backwards = joined(block_a, block_b, corners, frame)
    return contacts, turned, backwards


def joined(
    block_a: Ints,
    block_b: Ints,
    corners: Sequence[Floats],
    frame: Floats,
    friction: float = DEFAULT_FRICTION,
) -> tuple[Contacts, Bools]:
    """Contacts of polygons whose corners may have either orientation about the normal.

    Parameters
    ----------
    block_a, block_b : (m,)
    corners
        Per interface (c, 3) [m].
    frame : (m, 3, 3)
    friction

    Returns
    -------
    contacts
    reversed : (m,) bool
        Interfaces whose corners are stored in reverse order.
    """
    start = Ragged.of(corners).start
    area = area_vectors(np.concatenate(list(corners)), start)
    signed = (area * frame[:, 0]).sum(axis=1)
    backwards = signed < 0.0
    ordered = [
        points[::-1] if back else points
        for points, back in zip(corners, backwards.tolist(), strict=True)
    ]
    contacts = Contacts(
        block_a,
        block_b,
        frame,
        np.abs(signed),
        np.full(len(corners), friction),
        np.concatenate(ordered),
        np.repeat(np.arange(len(corners)), np.diff(start)),
    )
    return contacts, backwards


def frame_of(xaxis: Floats, yaxis: Floats) -> Floats | None:
    """Rows n, u, v of a COMPAS frame made orthonormal; ``None`` if its axes are parallel."""
    if not max(np.abs(xaxis).max(), np.abs(yaxis).max()) < FARTHEST:
        return None
    normal = np.cross(xaxis, yaxis)
    size = float(np.linalg.norm(normal))
    if not 1e-12 < size < np.inf:
        return None
    normal = normal / size
    u = xaxis / np.linalg.norm(xaxis)
    return np.stack([normal, u, np.cross(normal, u)])


def _points(interface: Field) -> Floats:
    points = [data_of(point).floats(3) for point in data_of(interface)["points"].elements()]
    if not points:
        raise interface.error("has no points")
    corners = np.array(points)
    if not np.abs(corners).max() <= FARTHEST:
        raise interface.error("has a coordinate that is far too large")
    return corners


def _forces(interface: Field) -> Floats | None:
    """Components (c, 4) of the forces at the corners of an interface, if it has some."""
    inside = data_of(interface)
    if not inside.has("forces"):
        return None
    rows = [
        [corner.get(name, 0.0).number() for name in COMPONENTS]
        for corner in inside["forces"].elements()
    ]
    return np.array(rows).reshape(-1, len(COMPONENTS))


def _frame(interface: Field, points: Floats) -> Floats:
    """Rows n, u, v: the stored frame made orthonormal, or one about the polygon's own normal."""
    inside = data_of(interface)
    if not inside.has("frame"):
        area = area_vector(points)
        if not area.any():
            raise interface.error("has neither a frame nor an area")
        return frames_from_normals((area / np.linalg.norm(area))[None])[0]
    stored = data_of(inside["frame"])
    frame = frame_of(stored["xaxis"].floats(3), stored["yaxis"].floats(3))
    if frame is None:
        raise inside["frame"].error("has axes that span no plane")
    return frame


COMPONENTS = ("c_np", "c_nn", "c_u", "c_v")


def forces_of(
    stored: Sequence[Floats | None], contacts: Contacts, turned: Bools, backwards: Bools
) -> tuple[Floats, Floats] | None:
    """Forces (k, 3) on block b and tension (k,) [N] in the order of the corners of contacts.

    Parameters
    ----------
    stored
        Of each interface the components (c, 4) of its corners, or ``None``.
    contacts
    turned : (m,)
        The stored axis z points from block b to block a.
    backwards : (m,)
        The stored corners run in reverse order.

    Returns
    -------
    None where no interface has forces for each of its corners.
    """
    force, tension = np.zeros((contacts.corner_count, 3)), np.zeros(contacts.corner_count)
    any_forces = False
    for i, given in enumerate(stored):
        rows = slice(contacts.start[i], contacts.start[i + 1])
        if given is None or given.shape != (rows.stop - rows.start, len(COMPONENTS)):
            continue
        push, pull, u, v = (given[::-1] if backwards[i] else given).T
        force[rows] = np.column_stack([push - pull, -u if turned[i] else u, v])
        tension[rows] = np.maximum(pull, 0.0)
        any_forces = True
    return (force, tension) if any_forces else None


def solved(
    assembly: Assembly,
    contacts: Contacts,
    found: tuple[Floats, Floats] | None,
    displacement: Floats | None = None,
) -> tuple[Result, ...]:
    """The result of forces that were found elsewhere, under the gravity that fits them best.

    COMPAS stores neither the loads nor, in most files, the density with which it solved.

    Parameters
    ----------
    assembly
    contacts
    found
        What :func:`forces_of` made.
    displacement : (n, 6) [m, rad]

    Returns
    -------
    One result, or none where there are no forces.
    """
    if found is None:
        return ()
    force, tension = found
    nothing = Model(assembly, contacts, LoadCase(np.zeros((len(assembly), 6)), "none"))
    pushed = unbalanced_wrench(nothing, force)[0][assembly.free, :3]
    mass = assembly.mass[assembly.free]
    gravity = -(mass @ pushed) / (mass @ mass)
    model = Model(assembly, contacts, gravity.tolist())
    residuals = check_forces(model, force)
    pulls = bool((tension > SAME * np.abs(force).max()).any())
    balanced = residuals.equilibrium <= SAME
    told = f"the forces of the file balance a gravity of {np.linalg.norm(gravity):.4g} m/s2"
    if not balanced:
        told = "the forces of the file do not balance the weights of its blocks"
    elif pulls:
        told += ", with tension"
    stands = balanced and not pulls
    return (
        Result(
            "file", Verdict.EQUILIBRIUM_EXISTS if stands else Verdict.UNDECIDED, model, told,
            force=force, tension=tension if pulls else None, displacement=displacement,
            residuals=residuals,
        ),
    )  # fmt: skip
