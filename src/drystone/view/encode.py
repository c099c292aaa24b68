"""A scene as the data of a page: plain JSON, arrays as base64 of little-endian numbers.

The format (``format`` "drystone-page", ``version`` 2):

``blobs``
    Base64 texts. An array is ``{"blob": i, "type": "f4", "shape": [...]}``; equal arrays share one.
``origin``
    [m]; every position is relative to it, so that 32 bits are exact far from the world's origin.
``half``
    [m], half the sides of the box around the model.
``toward``
    From the model to the eye at first; ``flat`` where that is a parallel projection.
``facts``, ``made``
    What was asked, as pairs of a name and a text; the date and the version of drystone.
``blocks``
    names, ``number`` (0 for none), mass, volume, centroid, ``away`` [m] where the block goes when
    the model is taken apart, and the flat surface: ``point`` with ``points`` per block; ``faces``
    per block, ``corners`` per face, ``loop`` (counted within its block), ``triangle`` (counted
    within its face), ``edge`` (counted within its block) with ``edges`` per block.
``contacts``
    Blocks a and b, area, friction, ``centroid`` and ``frame`` (nine numbers) of each interface, its
    ``corners`` and their ``point``; ``kern`` with ``kerns`` corners per interface.
``states``, ``colours``, ``ramp``
    What the numbers in a stage's ``state``, the roles of its layers and the scale of forces look
    like, light and dark.
``presets``, ``preset``
    Pictures by key, each with label, layers, opacity, numbers and ghost; the one shown at first.
``opens``
    Number of the stage that is shown first.
``section``
    Axis and place of the section that is shown first, from -1 to 1 across the model; or null.
``stages``
    Each with label, headline, ``asked`` in one line, message, role, facts, ``state`` per block,
    the optional arrays of :class:`drystone.answer.SceneStage`, and ``layers``. ``scale``
    of a layer is how long [m] an arrow of 1 N is, ``top`` the end of its colour bar. The motion
    of a ``virtual`` one happens nowhere.
"""

from __future__ import annotations

import base64
import json
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drystone.answer.question import asked_line
from drystone.answer.scene import Layer, LayerKind, Scene, SceneStage
from drystone.base.arrays import Floats, Ints, frozen
from drystone.base.ragged import Ragged, sum_by_owner
from drystone.base.units import quantity
from drystone.checks import FORCE_TOLERANCE
from drystone.contacts import Contacts
from drystone.geometry.halfedge import sharp_edges
from drystone.geometry.kern import kern
from drystone.geometry.polyhedron import Faces
from drystone.geometry.triangulate import triangulate
from drystone.joints import forces_around
from drystone.results.stage import VIRTUAL
from drystone.view.exploded import ways_apart
from drystone.view.palette import (
    FORCE_RAMP,
    KNOWN,
    PRESETS,
    ROLE_COLOUR,
    STATE_COLOUR,
    STATE_LABEL,
    first_preset,
    hexadecimal,
)
from drystone.virtual import local_corners

FORMAT = "drystone-page"
_MANY_INTERFACES = 20_000
"""With more interfaces the kerns are left out: they take seconds."""


class _Blobs:
    """Arrays for the page; equal arrays are stored once."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._known: dict[bytes, int] = {}

    def floats(self, values: Any) -> dict[str, Any]:
        """32-bit numbers."""
        return self._add(np.asarray(values, dtype="<f4"), "f4")

    def counts(self, values: Any) -> dict[str, Any]:
        """Whole numbers from zero, in the smallest type that holds them."""
        array = np.asarray(values)
        largest = int(array.max(initial=0))
        size = 1 if largest < 2**8 else 2 if largest < 2**16 else 4
        return self._add(array.astype(f"<u{size}"), f"u{size}")

    def _add(self, array: NDArray[Any], kind: str) -> dict[str, Any]:
        raw = array.tobytes()
        if raw not in self._known:
            self._known[raw] = len(self.texts)
            self.texts.append(base64.b64encode(raw).decode("ascii"))
        return {"blob": self._known[raw], "type": kind, "shape": list(array.shape)}


MANY_BLOCKS = 20_000
"""With more blocks a page leaves out the details of joints. Chosen: with all of it a page
of 100,000 blocks is 170 MB."""

LEFT_OUT = frozenset({"joint-pressure", "joint-use", "pressure", "resultants"})
"""Layers that such a page does not have."""


def _lightened(scene: Scene) -> Scene:
    """The scene of a page; with very many blocks without details, and with a note."""
    count = len(scene.assembly)
    if count <= MANY_BLOCKS:
        return scene
    stages = tuple(
        replace(
            one,
            force=None,
            layers=tuple(layer for layer in one.layers if layer.key not in LEFT_OUT),
        )
        for one in scene.stages
    )
    told = (
        f"with more than {MANY_BLOCKS:,} blocks: corner forces, resultants, pressure, friction at"
        " corners, kerns"
    )
    return replace(scene, stages=stages, facts={**scene.facts, "Left out": told})


MANY_LINES = 20_000
"""Lines of a force network, two for each joint, above which a picture shows their sums: those of
10,050 blocks were a moire, and came 6 s after a page was opened without a graphics card."""
_CELLS = 24
"""Cells of such sums along the longest side of the model. Chosen: 15 pixels each on a phone."""
_SEEN = 0.1
"""Least force of a cell that is drawn, by the largest one."""


def _summed(scene: Scene) -> Scene:
    """The scene with the sums of force networks of very many joints in place of each line.

    The lines, and the forces at corners, are layers that are not shown at first.
    """
    cell = float(np.ptp(scene.bounds, axis=0).max()) / _CELLS

    def shown(stage: SceneStage) -> SceneStage:
        named = {layer.key: layer for layer in stage.layers}
        network = named.get("network")
        if network is None or len(network.position) <= MANY_LINES:
            return stage
        each = replace(network, key="network-each", label=f"{network.label} of each joint")
        named["network"] = _sums(network, cell)
        named["network-each"] = replace(each, visible=False)
        if "joint-force" in named:
            force = replace(named.pop("joint-force"), key="joint-force-each", visible=False)
            named[force.key] = force
        return replace(stage, layers=tuple(named.values()))

    return replace(scene, stages=tuple(map(shown, scene.stages)))


def _sums(network: Layer, cell: float) -> Layer:
    """Principal forces in the cells of a grid, each through the middle of the forces there.

    The sum of ``F l d d'`` over the lines in a cell, of force F, length l and direction d, is the
    mean stress times the volume; by the side of the cell it is the force that passes through it.
    """
    assert network.vector is not None
    assert network.value is not None
    length = np.maximum(np.linalg.norm(network.vector, axis=1), 1e-12 * cell)
    middle = network.position + 0.5 * network.vector
    index = np.floor((middle - middle.min(axis=0)) / cell)
    _, row = np.unique(index, axis=0, return_inverse=True)
    weight = network.value * length
    dyad = np.einsum("p,pi,pj->pij", network.value / length, network.vector, network.vector)
    flat = np.column_stack([weight, weight[:, None] * middle, dyad.reshape(-1, 9)])
    total = sum_by_owner(flat, row, int(row.max(initial=-1)) + 1)
    force, axes = np.linalg.eigh(total[:, 4:].reshape(-1, 3, 3) / cell)
    at, which = np.nonzero(force > _SEEN * force.max(initial=0.0))
    way = cell * axes[at, :, which]
    start = total[at, 1:4] / total[at, :1] - 0.5 * way
    label = f"{network.label}, summed over cells of {quantity(cell, 'm')}"
    return replace(
        network, label=label, position=start, vector=way, value=force[at, which], interface=None,
        width=3.0,
    )  # fmt: skip


def encode(scene: Scene) -> dict[str, Any]:
    """The data of a page that shows ``scene``."""
    scene = _summed(_lightened(scene))
    blobs = _Blobs()
    origin = scene.centre
    contacts = scene.contacts
    data: dict[str, Any] = {
        "format": FORMAT,
        "version": 2,
        "title": scene.title,
        "origin": origin.tolist(),
        "toward": scene.toward.tolist(),
        "flat": scene.plane is not None,
        "half": (0.5 * (scene.bounds[1] - scene.bounds[0])).tolist(),
        "blockSize": scene.block_size,
        "facts": list(scene.facts.items()),
        "made": scene.made,
        "states": {
            str(int(state)): {
                "label": label,
                "light": STATE_COLOUR["light"][state],
                "dark": STATE_COLOUR["dark"][state],
            }
            for state, label in STATE_LABEL.items()
        },
        "colours": ROLE_COLOUR,
        "ramp": {theme: [hexadecimal(c) for c in stops] for theme, stops in FORCE_RAMP.items()},
        "presets": {
            key: {
                "label": one.label,
                "layers": sorted(one.layers),
                "opacity": one.opacity,
                "numbers": one.numbers,
                "ghost": one.ghost,
            }
            for key, one in PRESETS.items()
        },
        "preset": first_preset(scene),
        "opens": scene.opens % len(scene.stages),
        "section": _section(scene),
        "known": sorted(KNOWN),
        "blocks": _blocks(scene, origin, blobs),
        "contacts": _contacts(contacts.joints, origin, blobs),
        "stages": [_stage(stage, scene, blobs) for stage in scene.stages],
    }
    return data | {"blobs": blobs.texts}


def encode_stage(scene: Scene, *, contacts: bool = False) -> dict[str, Any]:
    """The data of the first stage of a scene alone, for a page that shows its model already.

    It has ``stage`` and ``blobs`` as in the data of a page, and those of ``contacts`` that the page
    does not know.
    """
    blobs = _Blobs()
    stage = _stage(scene.stages[0], scene, blobs)
    more = _contacts(scene.contacts.joints, scene.centre, blobs) if contacts else None
    return {"stage": stage, "contacts": more, "blobs": blobs.texts}


def to_text(data: dict[str, Any]) -> str:
    """JSON that is safe inside a ``<script>`` element, for any names."""
    text = json.dumps(data, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _section(scene: Scene) -> list[float] | None:
    """The axis of the section, and its place as a share of half the size from the middle."""
    if scene.section is None:
        return None
    axis, at = scene.section
    half = 0.5 * float(np.ptp(scene.bounds[:, axis]))
    return [axis, (at - float(scene.centre[axis])) / half]


def _contacts(contacts: Contacts, origin: Floats, blobs: _Blobs) -> dict[str, Any]:
    data = {
        "a": blobs.counts(contacts.block_a),
        "b": blobs.counts(contacts.block_b),
        "area": blobs.floats(contacts.area),
        "friction": blobs.floats(contacts.friction),
        "centroid": blobs.floats(contacts.centroid - origin),
        "frame": blobs.floats(contacts.frame.reshape(-1, 9)),
        "corners": blobs.counts(np.diff(contacts.start)),
        "point": blobs.floats(contacts.point - origin),
    }
    if not 0 < contacts.count <= _MANY_INTERFACES:
        return data
    middle, flat = local_corners(contacts)
    kerns = [kern(part) for part in np.split(flat, contacts.start[1:-1])]
    counts = np.array([len(part) for part in kerns])
    owner = np.repeat(np.arange(contacts.count), counts)
    place = middle[owner] + np.einsum(
        "ki,kij->kj", np.concatenate(kerns), contacts.frame[owner, 1:]
    )
    return data | {"kern": blobs.floats(place - origin), "kerns": blobs.counts(counts)}


def _blocks(scene: Scene, origin: Floats, blobs: _Blobs) -> dict[str, Any]:
    assembly = scene.assembly
    faces = assembly.faces
    n = len(assembly)
    points = np.array([len(block.vertices) for block in assembly.blocks])
    first_point = Ragged.from_counts(points).start
    corner_owner = np.repeat(faces.owner, np.diff(faces.start))
    edge, edge_owner, _ = sharp_edges(faces)
    by_block = np.argsort(edge_owner, kind="stable")
    edge, edge_owner = edge[by_block], edge_owner[by_block]
    return {
        "names": list(assembly.names),
        "number": blobs.counts(np.zeros(n) if scene.number is None else scene.number),
        "mass": blobs.floats(assembly.mass),
        "volume": blobs.floats(assembly.volume),
        "centroid": blobs.floats(assembly.centroid - origin),
        "away": blobs.floats(ways_apart(scene)),
        "point": blobs.floats(faces.point - origin),
        "points": blobs.counts(points),
        "faces": blobs.counts(np.bincount(faces.owner, minlength=n)),
        "corners": blobs.counts(np.diff(faces.start)),
        "loop": blobs.counts(faces.loop - first_point[corner_owner]),
        "triangle": blobs.counts(_local_triangles(faces)),
        "edge": blobs.counts(edge - first_point[edge_owner][:, None]),
        "edges": blobs.counts(np.bincount(edge_owner, minlength=n)),
    }


def _local_triangles(faces: Faces) -> Ints:
    triangle, face = triangulate(faces.point[faces.loop], faces.start)
    return triangle - faces.start[face][:, None]


@lru_cache(maxsize=4)
def _triangles_of(position: bytes, start: bytes) -> Ints:
    """Triangles of polygons by their own corners: layers, and load cases of a page, share them."""
    first = np.frombuffer(start, dtype=np.intp)
    triangle, polygon = triangulate(np.frombuffer(position).reshape(-1, 3), first)
    return frozen(triangle - first[polygon][:, None])


def _stage(stage: SceneStage, scene: Scene, blobs: _Blobs) -> dict[str, Any]:
    origin = scene.centre
    data: dict[str, Any] = {
        "label": stage.label,
        "headline": stage.headline,
        "asked": asked_line({**scene.facts, **stage.facts}, scene.made),
        "message": stage.message,
        "role": stage.role.value if stage.role is not None else None,
        "facts": list(stage.facts.items()),
        "virtual": stage.motion_name == VIRTUAL,
        "motionName": stage.motion_name,
        "plays": stage.plays,
        "seconds": max(stage.seconds, 1.0),
        "arrives": stage.arrives,
        "up": stage.up.tolist(),
        "gravity": stage.gravity.tolist(),
        "state": blobs.counts(stage.state),
        "layers": [_layer(layer, scene, blobs) for layer in stage.layers],
    }
    largest = 0.0 if stage.normal is None else float(np.abs(stage.normal).max(initial=0.0))
    for name in ("motion", "path", "prop", "force", "normal", "tangential", "utilisation"):
        value = _of_joints(name, getattr(stage, name), scene.contacts)
        if value is not None and name in ("normal", "tangential"):
            value = np.where(np.abs(value) > FORCE_TOLERANCE * largest, value, 0.0)
        data[name] = blobs.floats(value) if value is not None else None
    centre = _of_joints("pressure_centre", stage.pressure_centre, scene.contacts)
    data["pressureCentre"] = None if centre is None else blobs.floats(centre - origin)
    return data


def _of_joints(name: str, value: Floats | None, contacts: Contacts) -> Floats | None:
    """Values of interfaces and of their corners as those of joints: the page knows no facets."""
    if value is None or contacts.joints is contacts:
        return value
    if name == "force":
        return forces_around(contacts, value)
    if name in ("normal", "tangential", "utilisation", "pressure_centre"):
        return value[np.unique(contacts.joint, return_index=True)[1]]
    return value


def _layer(layer: Layer, scene: Scene, blobs: _Blobs) -> dict[str, Any]:
    data: dict[str, Any] = {
        "key": layer.key,
        "label": layer.label,
        "kind": layer.kind.value,
        "colour": layer.colour,
        "visible": layer.visible,
        "inward": layer.inward,
        "single": layer.single,
        "width": layer.width,
        "shape": layer.shape.value,
        "unit": layer.unit,
        "largest": layer.largest,
        "top": scene.top(layer.key),
        "scale": scene.arrow_scale(layer.group) if layer.kind is LayerKind.ARROWS else 1.0,
        "position": blobs.floats(layer.position - scene.centre),
    }
    if layer.vector is not None:
        data["vector"] = blobs.floats(layer.vector)
    if layer.value is not None:
        data["value"] = blobs.floats(layer.value)
    if layer.interface is not None:
        data["interface"] = blobs.counts(scene.contacts.joint[layer.interface])
    if layer.block is not None:
        data["block"] = blobs.counts(layer.block)
    if layer.text is not None:
        data["text"] = [(i, one) for i, one in enumerate(layer.text) if one]
    if layer.kind is LayerKind.POLYGONS and layer.start is not None:
        data["corners"] = blobs.counts(np.diff(layer.start))
        data["triangle"] = blobs.counts(
            _triangles_of(layer.position.tobytes(), layer.start.tobytes())
        )
    return data
