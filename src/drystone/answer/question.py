"""What was asked: the model, where it came from, its loads, and the options of the analysis."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.base import units
from drystone.base.arrays import Floats, frozen
from drystone.base.display import FEW_NAMES, OneLine, differing, named, shortened
from drystone.base.errors import counted
from drystone.base.version import commit, version
from drystone.contacts import Contacts
from drystone.joint_capacity import DRY
from drystone.loads import LoadCase
from drystone.loads.applied import Shaken, common_acceleration, loads_apart
from drystone.loads.case import STANDARD_GRAVITY
from drystone.model import Model
from drystone.supports import UP as VERTICAL
from drystone.supports import bounds_above_ground, own_blocks
from drystone.ties import strengths, ties_told

UP = frozen(np.array(VERTICAL))
"""The vertical axis of a picture, unless gravity is turned."""


@dataclass(frozen=True)
class Question(OneLine):
    """What was asked.

    Attributes
    ----------
    file, sha256
        The file of the model, and the hash of its content; empty where there was none.
    reading
        How it was read, where that was given: units, axis, supports, gap and others.
    blocks, interfaces, joints
        How many, without the ground that supports lay below them. A curved joint has
        several interfaces.
    size : [m]
        Along x, y and z.
    free_mass : [kg]
    supports
        Names of the fixed blocks.
    density, friction
        Least and largest; ``None`` where there are none.
    smoothest
        The blocks of joints with the least friction, where others have more.
    load
        Name of the load.
    acceleration : [m/s2]
        That most of the masses have under the load.
    earthquake
        Its force [N] on blocks and the masses that they carry, the point at which it acts [m], and
        the weights [N] that it shakes, by kind.
    loads
        Each other load, its block, the force [N], the point at which it acts [m], the moment
        [N m] about this point, and the motion [m, rad] of a support. See
        :class:`drystone.loads.applied.AppliedLoads`.
    joint_capacity
        Least and largest tension, cohesion, shear and compression of the joints [N].
    joint_stress
        Those of them that are one stress on all faces [Pa].
    ties
        Pull at which each tie yields [N], by the names of its blocks; infinite without a limit.
    mortar
        ``brittle`` or ``ductile`` where joints pull or cohere.
    notes
        What was assumed while the model was made.
    options
        Options of the analysis that differ from the defaults.
    version, commit
        Of drystone; the commit is empty where it is not known.
    made
        When.
    """

    file: str = ""
    sha256: str = ""
    reading: Mapping[str, str] = field(default_factory=dict)
    blocks: int = 0
    interfaces: int = 0
    joints: int = 0
    size: tuple[float, ...] = ()
    free_mass: float = 0.0
    supports: tuple[str, ...] = ()
    density: tuple[float, float] | None = None
    friction: tuple[float, float] | None = None
    smoothest: str = ""
    load: str = ""
    acceleration: tuple[float, ...] = ()
    loads: tuple[Mapping[str, Any], ...] = ()
    earthquake: Mapping[str, Any] = field(default_factory=dict)
    joint_capacity: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    joint_stress: Mapping[str, float] = field(default_factory=dict)
    ties: Mapping[str, float] = field(default_factory=dict)
    mortar: str = ""
    notes: tuple[str, ...] = ()
    options: Mapping[str, str] = field(default_factory=dict)
    version: str = ""
    commit: str = ""
    made: str = ""

    @classmethod
    def of(cls, model: Model, options: Any = None, made: str = "") -> Question:
        """What was asked of a model."""
        return cls._of(
            model.assembly,
            model.contacts,
            model.load,
            notes=model.notes,
            file=model.origin.file,
            sha256=model.origin.sha256,
            reading=model.origin.reading,
            options=differing(options) if dataclasses.is_dataclass(options) else {},
            made=made,
        )

    @classmethod
    def of_nothing(cls, options: Any = None, made: str = "") -> Question:
        """Options and version, where no model is known."""
        chosen = differing(options) if dataclasses.is_dataclass(options) else {}
        return cls(options=chosen, version=version(), commit=commit(), made=made)

    def without(self, *names: str) -> Question:
        """The same without attributes that an analysis varies."""
        empty = Question()
        return replace(self, **{name: getattr(empty, name) for name in names})

    @classmethod
    def of_blocks(cls, assembly: Assembly, contacts: Contacts) -> Question:
        """Blocks and their interfaces, without an analysis."""
        return cls._of(assembly, contacts, None)

    @classmethod
    def _of(
        cls, assembly: Assembly, contacts: Contacts, load: LoadCase | None, **more: Any
    ) -> Question:
        free = ~assembly.fixed
        own = own_blocks(assembly)
        density = np.array([block.density for block in assembly.blocks])[own]
        low, high = bounds_above_ground(assembly)
        common, others, shaken = ((), (), {}) if load is None else _loads(assembly, load)
        rubs = contacts.select(~contacts.ties)
        capacity, stress = {}, {}
        if rubs.capacity is not None:
            capacity = {name: _ends(getattr(rubs.capacity, name)) for name in DRY}
            stress = rubs.capacity.stress_on(rubs.area)
        return cls(
            blocks=int(own.sum()),
            interfaces=contacts.count,
            joints=contacts.joints.count,
            size=tuple((high - low).tolist()),
            free_mass=float(assembly.mass[free].sum()),
            supports=tuple(assembly.names[i] for i in np.flatnonzero(assembly.fixed)),
            density=_ends(density),
            friction=_ends(rubs.friction),
            smoothest=_smoothest(assembly, rubs),
            load="" if load is None else load.name,
            acceleration=common,
            loads=others,
            earthquake=shaken,
            joint_capacity={
                name: ends
                for name, ends in capacity.items()
                if ends not in (None, (DRY[name],) * 2)
            },
            joint_stress=stress,
            ties=strengths(assembly, contacts),
            mortar="" if contacts.capacity is None else contacts.capacity.law,
            version=version(),
            commit=commit(),
            **more,
        )

    def facts(self) -> dict[str, str]:
        """The same in words, by name; empty entries are left out."""
        told = {
            "File": PurePath(self.file).name,
            "Read with": _pairs(self.reading),
            "Blocks": f"{self.blocks:,}" if self.blocks else "",
            "Interfaces": f"{self.interfaces:,}{self._in_joints()}" if self.blocks else "",
            "Size": units.extent(self.size) if self.size else "",
            "Supports": _supports(self.supports) if self.blocks else "",
            "Free mass": units.mass(self.free_mass) if self.blocks else "",
            "Density": _range(self.density, " kg/m³"),
            "Friction": _range(self.friction, self.smoothest),
            "Joint capacity": ", ".join(
                f"{name} {self.joint_stress[name] / 1e6:.4g} MPa"
                if name in self.joint_stress
                else f"{name} {_range(ends, ' N')}"
                for name, ends in self.joint_capacity.items()
            )
            + (f" ({self.mortar})" if self.mortar else ""),
            "Ties": ties_told(self.ties),
            "Load": self.load,
            "Earthquake": self.earthquake.get("told", ""),
            "Options": _pairs(self.options),
            "Notes": "; ".join(self.notes),
        }
        return {name: text for name, text in told.items() if text}

    def line(self) -> str:
        """The same in one line, with the number of interfaces and the size."""
        told = self.facts()
        touching = counted(self.interfaces, "interface") + self._in_joints()
        more = [touching, told.get("Size", "")] if self.blocks else []
        return " \N{MIDDLE DOT} ".join(one for one in (asked_line(told), *more) if one)

    def _in_joints(self) -> str:
        return f" in {counted(self.joints, 'joint')}" if self.joints < self.interfaces else ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values; empty entries are left out."""
        values = {one.name: getattr(self, one.name) for one in dataclasses.fields(self)}
        return {
            name: dict(value) if isinstance(value, Mapping) else value
            for name, value in values.items()
            if value not in ("", None, (), {})
        }


def asked_line(facts: Mapping[str, str], made: str = "") -> str:
    """What was asked, in one line.

    Parameters
    ----------
    facts
        Of a scene and its stage; see :meth:`Question.facts`.
    made
        When and with what the picture was made.

    Examples
    --------
    >>> asked_line({"File": "arch.json", "Blocks": "17", "Friction": "0.6", "Supports": "none"})
    'arch.json · 17 blocks · friction 0.6 · no supports'
    """
    shown = [facts.get("File", "")]
    for name, text in (
        ("Blocks", "{} blocks"),
        ("Free mass", "free mass {}"),
        ("Density", "density {}"),
        ("Friction", "friction {}"),
        ("Joint capacity", "joints carry {}"),
        ("Ties", "ties {}"),
        ("Load", "{}"),
        ("Supports", "supports: {}"),
        ("Supports that move", "moved: {}"),
        ("Plan", "plan of {}"),
        ("Changed", "changed: {}"),
        ("Safety", "{}"),
        ("Options", "{}"),
    ):
        if facts.get(name) == "none":
            shown.append(f"no {name.lower()}")
        elif name in facts:
            one = name == "Blocks" and facts[name] == "1"
            shown.append((text[:-1] if one else text).format(facts[name]))
    if "Left out" in facts:
        shown.append("shown without details, see below")
    return " \N{MIDDLE DOT} ".join(one for one in (*shown, made) if one)


def directions(assembly: Assembly, load: LoadCase) -> tuple[Floats, Floats]:
    """The directions of up in the picture and of gravity, both (3,) unit.

    If most free masses have an acceleration of the size of standard gravity, gravity is turned:
    the picture is tilted until it points down. Otherwise up is along z.
    """
    pull = common_acceleration(assembly, load) - load.shake  # an earthquake is drawn apart
    size = float(np.linalg.norm(pull))
    if size == 0.0:
        return UP, -UP
    turned = abs(size / STANDARD_GRAVITY - 1.0) < 1e-6
    return (frozen(-pull / size) if turned else UP), frozen(pull / size)


def _loads(
    assembly: Assembly, load: LoadCase
) -> tuple[tuple[float, ...], tuple[Mapping[str, Any], ...], Mapping[str, Any]]:
    """The acceleration that most masses have, the other loads on blocks, and an earthquake."""
    applied = loads_apart(assembly, load)
    names = [assembly.names[i] for i in applied.block]
    each = (
        applied.words,
        names,
        *(x.tolist() for x in (applied.point, applied.force, applied.moment)),
    )
    keys = "load", "block", "at", "force", "moment"
    rows: list[dict[str, Any]] = [
        dict(zip(keys, one, strict=True)) for one in zip(*each, strict=True)
    ]
    if load.motion is not None:
        for i in np.flatnonzero(load.motion.any(axis=1)).tolist():
            at, motion = assembly.centroid[i].tolist(), load.motion[i].tolist()
            rows.append({"block": assembly.names[i], "at": at, "motion": motion})
    known, shaken = Shaken.of(assembly, load), {}
    if known is not None:
        shaken = {"at": applied.centre.tolist(), "force": applied.earthquake.tolist(),
                  "weights": dict(known.weights), "told": known.words}  # fmt: skip
    return tuple(applied.acceleration.tolist()), tuple(rows), shaken


def _ends(values: Floats | None) -> tuple[float, float] | None:
    """The least and the largest value."""
    if values is None or not len(values):
        return None
    return float(values.min()), float(values.max())


def _smoothest(assembly: Assembly, rubs: Contacts) -> str:
    """Where friction is least, if it is not the same in all joints."""
    least = rubs.friction <= rubs.friction.min(initial=np.inf) * (1.0 + 1e-9)
    if least.all():
        return ""
    ends = np.unique(np.stack([rubs.block_a, rubs.block_b], axis=1)[least], axis=0)
    joints = named([f"{assembly.names[a]} and {assembly.names[b]}" for a, b in ends.tolist()], 1)
    return f" (least between {joints})"


def _range(ends: tuple[float, float] | None, unit: str) -> str:
    if ends is None:
        return ""
    low, high = ends
    text = f"{low:.4g}" if high - low <= 1e-9 * abs(high) else f"{low:.4g} to {high:.4g}"
    return text + unit


def _pairs(given: Mapping[str, str]) -> str:
    words = {name: name.replace("_", " ") for name in given} | {"samples": "stiffnesses sampled:"}
    return ", ".join(f"{words[name]} {value}" for name, value in given.items())


def _supports(fixed: tuple[str, ...]) -> str:
    if not fixed:
        return "none"
    if len(fixed) > FEW_NAMES:
        return (
            f"{len(fixed):,} blocks: {', '.join(shortened(one) for one in fixed[:FEW_NAMES])}, ..."
        )
    told = ", ".join(fixed)
    if any(name.isdecimal() for name in fixed):  # "0" alone would be a count
        return f"block {told}" if len(fixed) == 1 else f"blocks {told}"
    return told
