"""The content of a picture before it is drawn: a model, its stages, their layers."""

from __future__ import annotations

import datetime as dt
import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from drystone.answer.chart import Chart
from drystone.answer.question import UP
from drystone.answer.sentences import Role
from drystone.assembly import Assembly
from drystone.base.arrays import Floats, Ints, marked
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted
from drystone.base.version import version
from drystone.contacts import Contacts, joined_contacts
from drystone.geometry.frames import rotations
from drystone.model import Model
from drystone.supports import bounds_above_ground, with_thin_ground

ROLES = (
    "interface", "pressure", "network", "resultant", "hinge", "help", "missed", "added", "kern",
    "load", "reaction",
)  # fmt: skip
"""What the colour of a layer says."""
_COMMON = 0.97
"""Share of the values that the colours resolve if a few are far above all others. Chosen by eye."""

_LONGEST = 0.35
"""Of an arrow, by the largest side of the model. Chosen by eye."""

_THIN = 0.25
"""A model whose plan is narrower than this share of its length is shown almost from the front."""


def now() -> str:
    """The time and the version of drystone."""
    return with_version(dt.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M"))


def with_version(when: str) -> str:
    """A time, and the version of drystone."""
    return f"{when}, drystone {version()}"


def _round_up(value: float) -> float:
    """The next larger number with two digits."""
    step = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(np.ceil(value / step - 1e-9) * step)


class State(enum.IntEnum):
    """State of a block in a stage; it has a colour."""

    ABSENT = 0
    """Not placed yet: not drawn."""
    FREE = 1
    """Placed, and neither fixed, held nor propped."""
    SUPPORT = 2
    """Fixed."""
    FALLING = 3
    """It needs help."""
    HELD = 4
    """A hand or a robot holds it."""
    PROPPED = 5
    """A prop holds it at this stage."""
    LATER = 6
    """Placed, and propped at a later stage: hatched."""
    COMING = 7
    """Moved into its place at this stage."""
    ADDED = 8
    """In a mended model, a block that was not there before."""


class LayerKind(enum.Enum):
    """How the entries of a layer are drawn."""

    ARROWS = "arrows"
    """A pair of opposite arrows about ``position``, ``vector`` long in all: action and reaction."""
    LINES = "lines"
    """From ``position`` to ``position + vector``."""
    POLYGONS = "polygons"
    """Loops of ``position``, filled."""
    MARKERS = "markers"
    """A mark of constant size on the screen at each ``position``."""


class MarkerShape(enum.Enum):
    """Of markers: told apart without their colour."""

    DISC = "disc"
    """A dot; a ball in space."""
    DIAMOND = "diamond"
    """A square on its corner; an octahedron in space."""


@dataclass(frozen=True, eq=False)
class Layer(OneLine):
    """A part of the drawing that can be switched on and off.

    Attributes
    ----------
    key
        Names the layer; the same layer of another stage has the same key.
    label
        For the legend.
    kind
    colour
        One of ``ROLES``.
    position : (p, 3) [m]
    vector : (p, 3), arrows [N] or [N/m], or lines [m]
    start : (f + 1,) loops of polygons
    value : (p,), not below zero
        Fills polygons with the colours of forces, corner by corner; makes lines thin or wide.
    unit
        Of the value, for the colour bar, or of arrows; empty for a share.
    interface : (f,) or (p,)
        Interface that each polygon, line, arrow or marker belongs to: it moves with its blocks.
    block : (p,)
        Block that each entry belongs to, where that is not an interface.
    visible
        At first, for layers that no preset names.
    inward
        Arrows point to ``position`` instead of away from it: a pull.
    single
        Arrows act on one block: they are not in pairs, and end at ``position``.
    width
        Of lines and arrows, relative to the usual one.
    group
        Arrows of one group have one scale: ``forces``, ``help`` for what is needed to stand,
        ``loads``, ``reactions``, ``acceleration`` of all masses.
    shape
        Of markers.
    text : (p,)
        Written beside each entry; empty strings where there is nothing to write.
    """

    key: str
    label: str
    kind: LayerKind
    colour: str
    position: Floats
    vector: Floats | None = None
    start: Ints | None = None
    value: Floats | None = None
    unit: str = "N"
    interface: Ints | None = None
    block: Ints | None = None
    visible: bool = True
    inward: bool = False
    single: bool = False
    width: float = 1.0
    group: str = "forces"
    shape: MarkerShape = MarkerShape.DISC
    text: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if self.colour not in ROLES:
            raise InputError(
                f"layer '{self.key}' has the colour '{self.colour}'",
                remedy=f"choose one of {', '.join(ROLES)}",
            )
        if (self.start is None) == (self.kind is LayerKind.POLYGONS):
            raise InputError(f"layer '{self.key}': polygons have a start, nothing else has one")
        if (self.vector is None) != (self.kind in (LayerKind.POLYGONS, LayerKind.MARKERS)):
            raise InputError(
                f"layer '{self.key}': arrows and lines have a vector, polygons and markers none"
            )
        points = dict.fromkeys(("vector", "value", "text"), len(self.position))
        for name, count in {**points, "interface": self.count, "block": self.count}.items():
            given = getattr(self, name)
            if given is not None and len(given) != count:
                raise InputError(f"layer '{self.key}': {name} has not {count} entries")

    @property
    def count(self) -> int:
        """Number of entries: polygons, lines, arrows or markers."""
        return len(self.position) if self.start is None else len(self.start) - 1

    @property
    def largest(self) -> float:
        """Largest value; where there are none, length of the longest vector."""
        if self.value is not None:
            return float(self.value.max(initial=0.0))
        if self.vector is None:
            return 0.0
        return float(np.linalg.norm(self.vector, axis=1).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class SceneStage(OneLine):
    """One state of the model: a result, a step of an assembly sequence, a case to compare.

    Attributes
    ----------
    label
        Names the stage on its slider.
    headline
        The answer in one plain sentence.
    message
        How it was found.
    role
        Of the headline, which has its look; None where nothing was computed.
    state : (n,) values of :class:`State`
    motion : (n, 6) [m, rad], translation of the centroid and rotation vector about it
    path : (s, n, 6) [m, rad]
        Positions along the motion, which are played one after the other; the last one is
        ``motion``. Left out, the motion is played in proportion.
    seconds
        Duration of the motion on the page, at least one.
    motion_name
        Name of the motion, for its slider.
    plays
        Whether the page plays the motion once by itself.
    arrives
        The motion leads into the places of the blocks and not out of them.
    prop : (n, 6) [N, N m]
    force : (k, 3) [N], at the corners of the interfaces, local n, u, v, on block b
    normal, tangential, utilisation : (m,) [N, N, 1] of each interface
    pressure_centre : (m, 3) [m]
    up : (3,) unit, up in the picture
    gravity : (3,) unit, where the masses are pulled
    facts
        What was asked, by name, where it differs from that of the scene.
    layers
    spot
        Where the stage is in the first chart of its scene.
    """

    label: str
    headline: str
    message: str
    state: Ints
    role: Role | None = None
    motion: Floats | None = None
    path: Floats | None = None
    seconds: float = 2.4
    motion_name: str = "First motion"
    plays: bool = False
    arrives: bool = False
    prop: Floats | None = None
    force: Floats | None = None
    normal: Floats | None = None
    tangential: Floats | None = None
    utilisation: Floats | None = None
    pressure_centre: Floats | None = None
    up: Floats = field(default_factory=lambda: UP)
    gravity: Floats = field(default_factory=lambda: -UP)
    facts: Mapping[str, str] = field(default_factory=dict)
    layers: tuple[Layer, ...] = ()
    spot: tuple[float, float] | None = None

    def require_rows(self, n: int, contacts: Contacts) -> None:
        """Refuse values of another number of blocks, interfaces or corners.

        Raises
        ------
        InputError
        """
        m = contacts.count
        for name, length in (
            ("state", n), ("motion", n), ("prop", n), ("force", contacts.corner_count),
            ("normal", m), ("tangential", m), ("utilisation", m), ("pressure_centre", m),
        ):  # fmt: skip
            value = getattr(self, name)
            if value is not None and len(value) != length:
                raise InputError(f"stage '{self.label}': {name} has not {length} rows")
        if self.path is not None and (self.motion is None or self.path.shape[1:] != (n, 6)):
            raise InputError(f"stage '{self.label}': its path has no motion, or another shape")


def _about(stage: SceneStage, moved: Floats) -> SceneStage:
    """The stage with its motions about other places than centroids, by (n, 3) [m]."""

    def carried(motion: Floats | None) -> Floats | None:
        if motion is None or not motion[..., 3:][..., moved.any(axis=1), :].any():
            return motion
        turn = rotations(motion[..., 3:].reshape(-1, 3))
        arm = moved + np.zeros_like(motion[..., :3])
        back = (turn @ arm.reshape(-1, 3, 1)).reshape(arm.shape) - arm
        return np.concatenate([motion[..., :3] + back, motion[..., 3:]], axis=-1)

    return replace(stage, motion=carried(stage.motion), path=carried(stage.path))


@dataclass(frozen=True, eq=False)
class Scene(OneLine):
    """A model with its stages, facts and charts.

    Attributes
    ----------
    assembly
        The ground that was laid below a model becomes a thin plate.
    contacts
    stages
        One or more; several are played one after the other.
    title
    facts
        Facts about the input by name: file, blocks, mass, friction, density, load, supports.
    number : (n,)
        A number to write on each block, 0 for none: the order of assembly.
    charts
        For the panel beside the model.
    made
        Date, and version of drystone.
    still
        The stage that a figure shows.
    opens
        The stage that a page shows first.
    preset
        The preset that is shown first: a key of
        ``drystone.view.palette.PRESETS``; left empty, one that suits the first stage.
    section
        The axis (0, 1, 2) across which the model is cut, and the coordinate [m] of the cut: what
        lies between it and the eye is not drawn. None where nothing is cut.
    """

    assembly: Assembly
    contacts: Contacts
    stages: tuple[SceneStage, ...] = field(default_factory=tuple)
    title: str = "drystone"
    facts: Mapping[str, str] = field(default_factory=dict)
    number: Ints | None = None
    charts: tuple[Chart, ...] = ()
    made: str = field(default_factory=now)
    still: int = 0
    opens: int = 0
    preset: str = ""
    section: tuple[int, float] | None = None

    def __post_init__(self) -> None:
        n = len(self.assembly)
        if not self.stages:
            raise InputError("a scene needs a stage")
        self.contacts.require_blocks(n)
        for stage in self.stages:
            stage.require_rows(n, self.contacts)
        shown = with_thin_ground(self.assembly)
        if shown is not self.assembly:
            lower = shown.centroid - self.assembly.centroid
            stages = tuple(_about(one, lower) for one in self.stages)
            object.__setattr__(self, "stages", stages)
            object.__setattr__(self, "assembly", shown)

    def _summary(self) -> str:
        return f"'{self.title}', {counted(len(self.stages), 'stage')}, {self.assembly!r}"

    @cached_property
    def bounds(self) -> Floats:
        """(2, 3) [m], box around all blocks."""
        each = self.assembly.bounds
        return np.stack([each[:, 0].min(axis=0), each[:, 1].max(axis=0)])

    @cached_property
    def _body(self) -> Floats:
        """(2, 3) [m], box around the blocks without the ground laid below them."""
        return bounds_above_ground(self.assembly)

    @cached_property
    def plane(self) -> int | None:
        """The axis (0 or 1) along which one looks first, level; or None.

        No pressure on faces acts along it, but across it: a wall of any length is seen from its
        end. Or blocks reach equally far along it, the model is thin, and they do not move along it.
        One block in ten may reach less far: a prop, or a tie.
        """
        if self._profile is not None:
            return self._profile
        span = self._body[1] - self._body[0]
        away = np.abs(self.assembly.bounds - self._body).max(axis=1)
        for axis in (1, 0):
            alike = np.mean(away[:, axis] <= 1e-6 * span.max()) >= 0.9
            if alike and span[axis] < _THIN * span.max():
                return None if self._leaves(axis) else axis
        return None

    def _leaves(self, axis: int) -> bool:
        """Whether blocks move most along an axis: from its end one would not see it."""
        ways = [x.motion[:, :3] for x in self.stages if x.motion is not None and not x.arrives]
        most = np.abs(np.concatenate([np.zeros((1, 3)), *ways])).max(axis=0)
        return bool(most[axis] > 0.5 * most.max())

    @cached_property
    def _profile(self) -> int | None:
        """The level axis along which no pressure on faces acts, where it acts across it."""
        pressed = [
            one.vector for stage in self.stages for one in stage.layers if one.key == "surface"
        ]
        along = np.max(
            [np.zeros(3), *(np.abs(one).max(axis=0) for one in pressed if one is not None)], axis=0
        )
        end = int(np.argmin(along[:2]))
        return end if along[end] < 1e-6 * along[1 - end] else None

    @cached_property
    def toward(self) -> Floats:
        """(3,) unit, from the model to the eye at first: across its longer side, from above.

        A plane structure is seen from the front.
        """
        if self.plane is not None:
            return np.array([1.0, 0.0, 0.0]) if self.plane == 0 else np.array([0.0, -1.0, 0.0])
        x, y, z = self._body[1] - self._body[0]
        azimuth = np.deg2rad(-60.0 if x >= y else -30.0)
        if min(x, y) < _THIN * max(x, y):
            azimuth = np.deg2rad(-75.0 if x >= y else -15.0)
        elevation = np.deg2rad(35.0 if z < 0.4 * max(x, y) else 15.0)
        level = np.cos(elevation)
        return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])

    @property
    def centre(self) -> Floats:
        """(3,) [m], middle of the box."""
        return self.bounds.mean(axis=0)

    @cached_property
    def block_size(self) -> float:
        """[m], median bounding box diagonal of the blocks."""
        return float(np.median(self.assembly.size))

    def arrow_scale(self, group: str) -> float:
        """[m/N] at which the longest arrow of a group, in any stage, is as long as a block.

        It is no longer than a third of the model, which may have a few large blocks.
        """
        largest = max(
            (
                layer.largest
                for stage in self.stages
                for layer in stage.layers
                if layer.kind is LayerKind.ARROWS and layer.group == group
            ),
            default=0.0,
        )
        longest = min(self.block_size, _LONGEST * float(np.ptp(self._body, axis=0).max()))
        return longest / largest if largest > 0.0 else 0.0

    def top(self, key: str) -> float:
        """The end of the colour bar of a layer in all stages.

        It is the largest value, unless a few are far above all others: those have the last colour.
        """
        found = [
            x.value if x.value is not None else np.array([x.largest])
            for stage in self.stages
            for x in stage.layers
            if x.key == key
        ]
        if not found:
            return 0.0
        value = np.concatenate(found)
        value = value[value > 0.0]
        if len(value) == 0:
            return 0.0
        most, common = float(value.max()), float(np.quantile(value, _COMMON))
        return most if most < 1.5 * common else _round_up(common)


def stage_among(
    stage: SceneStage, blocks: int, contacts: Contacts, kept: Ints, interface: Ints
) -> SceneStage:
    """A stage of some blocks as one of all blocks.

    Parameters
    ----------
    stage
    blocks, contacts
        Number of all blocks, and all their interfaces.
    kept, interface : (s,), (j,)
        Positions of the blocks and interfaces of the stage among all.
    """
    here = marked(interface, contacts.count)
    corner = np.flatnonzero(here[contacts.interface])
    count = {"block": blocks, "interface": contacts.count, "corner": contacts.corner_count}
    place = {"block": kept, "interface": interface, "corner": corner}

    def spread(values: Any, kind: str) -> Any:
        if values is None:
            return None
        out = np.zeros((count[kind], *values.shape[1:]), dtype=values.dtype)
        out[place[kind]] = values
        return out

    path = None
    if stage.path is not None:
        path = np.zeros((len(stage.path), blocks, 6))
        path[:, kept] = stage.path
    state = np.full(blocks, State.ABSENT, dtype=np.intp)
    state[kept] = stage.state
    return replace(
        stage,
        state=state,
        motion=spread(stage.motion, "block"),
        path=path,
        prop=spread(stage.prop, "block"),
        force=spread(stage.force, "corner"),
        layers=tuple(_layer_among(layer, interface, kept) for layer in stage.layers),
        **{
            name: spread(getattr(stage, name), "interface")
            for name in ("normal", "tangential", "utilisation", "pressure_centre")
        },
    )


def _layer_among(layer: Layer, interface: Ints, kept: Ints) -> Layer:
    return replace(
        layer,
        interface=None if layer.interface is None else interface[layer.interface],
        block=None if layer.block is None else kept[layer.block],
    )


def side_by_side(
    models: Sequence[Model], stages: Sequence[SceneStage], names: Sequence[str]
) -> tuple[Assembly, Contacts, tuple[SceneStage, ...]]:
    """Stages of models with other blocks as stages of all these blocks.

    Parameters
    ----------
    models
    stages
        One of each model, in which the blocks of the others are absent.
    names
        What is added to the names of the blocks of each model.
    """
    first, blocks, fixed = 0, [], []
    contacts = Contacts.empty()
    places = []
    total = sum(len(model) for model in models)
    for model, name in zip(models, names, strict=True):
        kept = np.arange(first, first + len(model))
        joints = np.arange(contacts.count, contacts.count + model.contacts.count)
        own = model.contacts.select(np.ones(model.contacts.count, dtype=bool), kept)
        contacts = joined_contacts(contacts, own) if contacts.count else own
        blocks += [replace(one, name=f"{one.name}{name}") for one in model.assembly.blocks]
        fixed.append(model.assembly.fixed)
        places.append((kept, joints))
        first += len(model)
    made = tuple(
        stage_among(stage, total, contacts, kept, joints)
        for stage, (kept, joints) in zip(stages, places, strict=True)
    )
    return Assembly(tuple(blocks), np.concatenate(fixed)), contacts, made
