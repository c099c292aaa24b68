"""What a picture shows, before anything is drawn: one model, one or more stages, layers on top."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from drystone.arrays import Floats, Ints
from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.display import OneLine
from drystone.errors import InputError, counted
from drystone.results import Verdict
from drystone.view.palette import ROLE_COLOUR


class LayerKind(enum.Enum):
    """How the entries of a layer are drawn."""

    ARROWS = "arrows"
    """A pair of opposite arrows about ``position``, ``vector`` long in all: action and reaction."""
    LINES = "lines"
    """From ``position`` to ``position + vector``."""
    POLYGONS = "polygons"
    """Loops of ``position``, filled."""


@dataclass(frozen=True, eq=False)
class Layer(OneLine):
    """Something drawn over the blocks that can be switched on and off.

    Attributes
    ----------
    key
        Names the layer; the same layer of another stage has the same key.
    label
        For the legend.
    kind
    colour
        A role of :mod:`drystone.view.palette`.
    position : (p, 3) [m]
    vector : (p, 3), arrows [N] or lines [m]
    start : (f + 1,) loops of polygons
    visible
        At first.
    inward
        Arrows point to ``position`` instead of away from it: a pull.
    width
        Of lines and arrows, relative to the usual one.
    """

    key: str
    label: str
    kind: LayerKind
    colour: str
    position: Floats
    vector: Floats | None = None
    start: Ints | None = None
    visible: bool = True
    inward: bool = False
    width: float = 1.0

    def __post_init__(self) -> None:
        if self.colour not in ROLE_COLOUR["light"]:
            raise InputError(
                f"layer '{self.key}' has the colour '{self.colour}'",
                remedy=f"choose one of {', '.join(ROLE_COLOUR['light'])}",
            )
        if (self.start is None) == (self.kind is LayerKind.POLYGONS):
            raise InputError(f"layer '{self.key}': polygons have a start, nothing else has one")
        if (self.vector is None) != (self.kind is LayerKind.POLYGONS):
            raise InputError(f"layer '{self.key}': arrows and lines have a vector, polygons none")
        if self.vector is not None and self.vector.shape != self.position.shape:
            raise InputError(f"layer '{self.key}': position and vector differ in shape")

    @property
    def largest(self) -> float:
        """Length of the longest vector, 0 where there is none."""
        if self.vector is None:
            return 0.0
        return float(np.linalg.norm(self.vector, axis=1).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Stage(OneLine):
    """One state of the model: a result, a step of an assembly sequence, a case to compare.

    Attributes
    ----------
    label
        Names the stage on its slider.
    headline, message
        The verdict in a word or two; a sentence.
    verdict
        None where nothing was computed.
    state : (n,) values of :class:`State`
    motion : (n, 6) [m, rad], translation of the centroid and rotation vector about it
    prop : (n, 6) [N, N m]
    normal, tangential, utilisation : (m,) [N, N, 1] of each interface
    layers
    """

    label: str
    headline: str
    message: str
    state: Ints
    verdict: Verdict | None = None
    motion: Floats | None = None
    prop: Floats | None = None
    normal: Floats | None = None
    tangential: Floats | None = None
    utilisation: Floats | None = None
    layers: tuple[Layer, ...] = ()


@dataclass(frozen=True, eq=False)
class Scene(OneLine):
    """A model and what is to be shown of it.

    Attributes
    ----------
    assembly
    contacts
    stages
        One or more; several are played one after the other.
    title
    """

    assembly: Assembly
    contacts: Contacts
    stages: tuple[Stage, ...] = field(default_factory=tuple)
    title: str = "drystone"

    def __post_init__(self) -> None:
        n, m = len(self.assembly), self.contacts.count
        if not self.stages:
            raise InputError("a scene needs a stage")
        if m and max(self.contacts.block_a.max(), self.contacts.block_b.max()) >= n:
            raise InputError(
                "the contacts name blocks that the assembly does not have",
                remedy="pass the contacts that were found on this assembly",
            )
        for stage in self.stages:
            for name, length in (
                ("state", n), ("motion", n), ("prop", n),
                ("normal", m), ("tangential", m), ("utilisation", m),
            ):  # fmt: skip
                value = getattr(stage, name)
                if value is not None and len(value) != length:
                    raise InputError(f"stage '{stage.label}': {name} has not {length} rows")

    def _summary(self) -> str:
        return f"'{self.title}', {counted(len(self.stages), 'stage')}, {self.assembly!r}"

    @cached_property
    def bounds(self) -> Floats:
        """(2, 3) [m], box around all blocks."""
        each = self.assembly.bounds
        return np.stack([each[:, 0].min(axis=0), each[:, 1].max(axis=0)])

    @cached_property
    def toward(self) -> Floats:
        """(3,) unit, from the model to the eye at first: across its longer side, from above."""
        x, y, z = self.bounds[1] - self.bounds[0]
        azimuth = np.deg2rad(-60.0 if x >= y else -30.0)
        elevation = np.deg2rad(35.0 if z < 0.4 * max(x, y) else 20.0)
        level = np.cos(elevation)
        return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])

    @property
    def centre(self) -> Floats:
        """(3,) [m], middle of the box."""
        middle: Floats = self.bounds.mean(axis=0)
        return middle

    @cached_property
    def block_size(self) -> float:
        """[m], median bounding box diagonal of the blocks."""
        return float(np.median(self.assembly.size))

    @cached_property
    def force_scale(self) -> float:
        """[m/N] at which the longest arrow of any stage is as long as a block."""
        largest = max(
            (
                layer.largest
                for stage in self.stages
                for layer in stage.layers
                if layer.kind is LayerKind.ARROWS
            ),
            default=0.0,
        )
        return self.block_size / largest if largest > 0.0 else 0.0
