"""The model: blocks, the contacts between them, and a load. Every analysis takes one."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.assembly import Assembly, Block, Blocks
from drystone.base.arrays import FARTHEST, Bools, Floats, frozen_floats, marked, of_type
from drystone.base.display import Card, OneLine
from drystone.base.errors import InputError, counted, quoted, require
from drystone.base.settings import member_of
from drystone.contacts import DEFAULT_FRICTION, Contacts
from drystone.detection import ContactReport, DetectionOptions, find_contacts
from drystone.detection.advice import among
from drystone.detection.face_overlaps import overlap_lines
from drystone.detection.misses import inexact_lines
from drystone.detection.resample import resampled_lines
from drystone.detection.tolerances import Missed
from drystone.joint_capacity import NO_LIMIT, JointCapacity
from drystone.loads import LoadCase
from drystone.mesh_objects import assembly_of, to_pyvista, to_trimesh
from drystone.supports import UP, GroundPlane, Joints, ground_of, remarks, select, up_of

if TYPE_CHECKING:
    import networkx
    import pyvista
    import trimesh

_REPRESENTED = (1e-100, 1e100)
"""[N, N m], and by mass [m/s2], chosen: far from anything that is built, and products of forces, or
of accelerations, fit a float."""

_FAR = 1e4
"""Largest motion of a support, by the size of all blocks together, and [rad]; chosen. It is farther
than any, also where its direction alone counts and it is given as 1 m."""


class OfModel:
    """A value that belongs to a model, and has its blocks and contacts at hand."""

    if TYPE_CHECKING:

        @property
        def model(self) -> Model: ...  # a field or a property of each such value

    @cached_property
    def assembly(self) -> Assembly:
        """The blocks of the model."""
        return self.model.assembly

    @cached_property
    def contacts(self) -> Contacts:
        """The contacts of the model."""
        return self.model.contacts


@dataclass(frozen=True)
class Origin(OneLine):
    """Where a model came from.

    Attributes
    ----------
    file
        Empty where there was none.
    sha256
        Hash of its content.
    reading
        How it was read, as text by name: what differs from the defaults.
    units
        Unit of length of the file.
    """

    file: str = ""
    sha256: str = ""
    reading: Mapping[str, str] = field(default_factory=dict)
    units: str = "m"


class FlushEnds(enum.StrEnum):
    """What becomes of the end of a joint where the faces of both blocks end, while they move."""

    LONGER = "longer"
    """The face of the block nearer to the supports goes on, as in published programs."""
    EXACT = "exact"
    """Both end where they are drawn."""


@dataclass(frozen=True, eq=False)
class Model(Card):
    """Blocks, the interfaces at which they touch, and the load on them.

    Parameters
    ----------
    assembly
    contacts
        Of this assembly.
    load
        A load case of this assembly. A number is a multiple of gravity along -z, a vector (3,) an
        acceleration [m/s2] of all masses. Self-weight when left out.
    report
        What the contact search found and left out; ``None`` where the contacts were given.
    notes
        What was assumed while it was made, one sentence each.
    cases
        Load cases that came with the model, to choose from.
    unjoined
        Pairs that are near each other and that the contact search did not join. No proof that
        blocks fall rests on them.
    origin
        The file that it was read from.
    ends
        What becomes of flush ends of joints where blocks are followed; ``None``: undecided where
        they decide.

    Raises
    ------
    InputError
        Contacts or load belong to another assembly, or the forces are too small or too large to be
        calculated with.

    Examples
    --------
    >>> from drystone.models import tower
    >>> model = Model.of(tower(3), friction=0.7)
    >>> model.contacts.count
    2
    >>> model.with_load(2.0).load.wrench[1, 2] / model.load.wrench[1, 2]
    np.float64(2.0)
    """

    assembly: Assembly
    contacts: Contacts
    load: LoadCase = None  # type: ignore[assignment]  # filled in below
    report: ContactReport | None = None
    notes: tuple[str, ...] = ()
    cases: tuple[LoadCase, ...] = ()
    unjoined: tuple[Missed, ...] = ()
    origin: Origin = field(default_factory=Origin)
    ends: FlushEnds | None = None

    def __post_init__(self) -> None:
        count = len(self.assembly)
        remedy = "give the .contacts of what find_contacts found, or use Model.of(assembly)"
        of_type(self.contacts, Contacts, "the value of contacts", remedy)
        self.contacts.require_blocks(count)
        object.__setattr__(self, "load", LoadCase.of(self.assembly, self.load))
        size = np.abs(self.load.wrench).max(axis=1, initial=0.0)
        odd = (size != 0.0) & ~((size >= _REPRESENTED[0]) & (size <= _REPRESENTED[1]))
        if odd.any():
            i = int(np.flatnonzero(odd)[0])
            raise InputError(
                f"the load on it is {size[i]:.3g}, which cannot be calculated with",
                where=f"block '{self.assembly.names[i]}'",
                remedy="check units, density and load",
            )
        self._refuse_odd_acceleration(size)
        if self.load.motion is not None:
            reach, turn = np.abs(self.load.motion).reshape(-1, 2, 3).max(axis=2).T
            extent = float(np.ptp(self.assembly.bounds, axis=(0, 1)).max())
            for i in np.flatnonzero(~((reach <= _FAR * extent) & (turn <= _FAR)))[:1]:
                raise InputError(
                    f"it is moved by {reach[i]:.3g} m and {turn[i]:.3g} rad, and all blocks "
                    f"together are {extent:.3g} m long",
                    where=f"block '{self.assembly.names[i]}'",
                    remedy="give metres and radians",
                )
        if self.ends is not None:
            object.__setattr__(self, "ends", member_of(FlushEnds, self.ends, "ends"))
        object.__setattr__(self, "notes", tuple(self.notes))
        object.__setattr__(self, "cases", tuple(self.cases))
        object.__setattr__(self, "unjoined", tuple(self.unjoined))

    def _refuse_odd_acceleration(self, size: Floats) -> None:
        """Refuse loads (n,) that are far from the mass of their block."""
        free = np.flatnonzero(~self.assembly.fixed & (size > 0.0))
        least, most = (np.log10(limit) for limit in _REPRESENTED)
        with np.errstate(divide="ignore"):
            power = np.log10(size[free]) - np.log10(self.assembly.mass[free])
        for i in free[~((power >= least) & (power <= most))][:1]:
            raise InputError(
                f"the load on it is {size[i]:.3g} and its mass {self.assembly.mass[i]:.3g} kg, "
                "and how it would fall freely cannot be calculated",
                where=f"block '{self.assembly.names[i]}'",
                remedy="check units, density and load",
            )

    def _summary(self) -> str:
        touching = counted(self.contacts.count, "interface")
        return f"{self.assembly._summary()}, {touching}, load '{self.load.name}'"

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        sentence, facts = self.assembly._facts()
        friction = sorted({f"{x:.3g}" for x in self.contacts.friction})
        return f"{sentence}; {counted(self.contacts.count, 'interface')}", {
            **facts,
            "friction": " to ".join(friction[:: max(len(friction) - 1, 1)]),
            "load": self.load.name,
            "notes": "; ".join(self.notes),
        }

    def __len__(self) -> int:
        """Number of blocks."""
        return len(self.assembly)

    def graph(self) -> networkx.MultiDiGraph:
        """The contact graph: a node per block, an edge per interface from block a to block b.

        Returns
        -------
        networkx.MultiDiGraph
            Nodes are positions and have ``block``, ``fixed`` and ``load`` (6,) [N, N m]. Edges have
            ``interface``, ``area`` [m2], ``friction``, ``points`` (c, 3) [m] and ``frame`` (3, 3),
            its rows n, u, v.

        Raises
        ------
        MissingDependency
            networkx is not installed.

        Notes
        -----
        Source: Frick et al. 2016, the assembly as a directed graph; Kao 2023, section 4.5.
        """
        require("networkx", "graph", "the graph")
        import networkx  # optional: only for those who ask for the graph

        graph = networkx.MultiDiGraph()
        for i, block in enumerate(self.assembly.blocks):
            fixed = bool(self.assembly.fixed[i])
            graph.add_node(i, block=block, fixed=fixed, load=self.load.wrench[i])
        contacts = self.contacts
        for i, pair in enumerate(zip(contacts.block_a, contacts.block_b, strict=True)):
            graph.add_edge(
                *map(int, pair), interface=i, area=float(contacts.area[i]),
                friction=float(contacts.friction[i]), points=contacts.polygon(i),
                frame=contacts.frame[i],
            )  # fmt: skip
        return graph

    def to_trimesh(self) -> trimesh.Scene:
        """Its blocks for trimesh; see :func:`drystone.mesh_objects.to_trimesh`."""
        return to_trimesh(self.assembly)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Its blocks for pyvista; see :func:`drystone.mesh_objects.to_pyvista`."""
        return to_pyvista(self.assembly)

    @classmethod
    def of(
        cls,
        assembly: Any,
        *,
        supports: str | Sequence[int | str] | GroundPlane | None = None,
        friction: float | None = None,
        density: float | None = None,
        load: LoadCase | float | Sequence[float] | Floats | None = None,
        detection: DetectionOptions | None = None,
        anyway: bool = False,
    ) -> Model:
        """The model of an assembly, its contacts found here.

        Parameters
        ----------
        assembly
            Or meshes of trimesh, pyvista or COMPAS, their scenes and lists.
        supports
            Which blocks are fixed: ``lowest``, ``below:Z``, names and patterns, or positions and
            names of blocks. ``ground``, ``ground:Z`` and :class:`drystone.supports.GroundPlane`
            add a fixed block below the others. Left out, those of the assembly.
        friction
            Coefficient of every interface. Left out, what the blocks bring in their metadata, else
            0.6.
        density : [kg/m3]
            Of every block. Left out, that of each block.
        load
            See :class:`Model`.
        detection
            Tolerances of the contact search.
        anyway
            Accept blocks that overlap by more than a tenth of the smaller one.

        Raises
        ------
        InputError
            Two blocks share more than a tenth of the smaller one.
        """
        assembly = assembly_of(assembly)
        anyway = bool(of_type(anyway, bool | np.bool_, "anyway", "give True or False"))  # type: ignore[arg-type]
        if density is not None:
            assembly = assembly.with_density(density)
        up = up_of_load(load)
        assembly, chosen = ground_of(assembly, supports, up)
        found = find_contacts(
            assembly,
            friction=DEFAULT_FRICTION if friction is None else friction,
            options=detection,
        )
        if not anyway:
            found.report.require_apart()
        contacts = found.contacts
        notes: tuple[str, ...] = ()
        if friction is None:
            contacts, notes = _with_own_friction(assembly, contacts)
        model = cls(assembly, contacts, LoadCase.of(assembly, load), notes=notes)
        model = model.with_report(found.report)
        return model if chosen is None else model.with_supports(chosen, up)

    def with_report(self, report: ContactReport) -> Model:
        """The same model with what the search that found its contacts says of them."""
        said = (
            *report.bridged,
            *inexact_lines(self.assembly.names, report.inexact),
            *resampled_lines(report.resampled),
            *overlap_lines(self.assembly.names, report.overlaps_left),
        )
        notes = (*self.notes, *said)
        return replace(self, report=report, unjoined=report.unjoined, notes=notes)

    @property
    def detection(self) -> DetectionOptions | None:
        """The tolerances with which the contacts were searched; ``None`` where they were given."""
        return None if self.report is None else self.report.options

    def with_load(self, load: Any) -> Model:
        """The same model under another load; see :class:`Model`."""
        return replace(self, load=LoadCase.of(self.assembly, load))

    def with_contacts(self, contacts: Contacts) -> Model:
        """The same blocks and load with other contacts."""
        return replace(self, contacts=contacts)

    def with_friction(self, friction: float | Sequence[float] | Floats) -> Model:
        """The same model with another friction coefficient, one for all interfaces or one each."""
        return self.with_contacts(self.contacts.with_friction(friction))

    def with_capacity(self, capacity: JointCapacity | None) -> Model:
        """The same model with joints that carry more than friction; dry ones with ``None``."""
        return self.with_contacts(self.contacts.with_capacity(capacity))

    def without_crushing(self) -> Model:
        """The same model with joints of any strength in compression."""
        capacity = self.contacts.capacity
        if capacity is None:
            return self
        if self.contacts.dry.all():
            return self.with_capacity(None)
        unlimited = np.full(self.contacts.count, NO_LIMIT)
        return self.with_capacity(replace(capacity, compression=unlimited))

    def cracked(self, interfaces: Bools | None = None) -> Model:
        """The same model where some interfaces (m,), all by default, pull and cohere no more."""
        capacity = self.contacts.capacity
        if capacity is None:
            return self
        which = np.ones(self.contacts.count, dtype=bool) if interfaces is None else interfaces
        other = self.with_capacity(capacity.cracked(which))
        return self.with_capacity(None) if other.contacts.plain.all() else other

    def require_dry(self, what: str, why: str = "", *, yielding: bool = False) -> None:
        """Raise InputError where joints pull or cohere, of an analysis that takes dry joints only.

        Parameters
        ----------
        what
            Name of the analysis.
        why
            Why it takes no others; empty if nothing is to be said.
        yielding
            Whether it takes ties with a strength.
        """
        plain = self.contacts.plain | (self.contacts.ties & yielding)
        if not plain.all():
            i = int(np.argmin(plain))
            if self.contacts.ties[i]:
                what, remedy = f"{what} takes no strength of a tie", "leave the strength out"
                raise InputError(what + (f": {why}" if why else ""), remedy=remedy)
            raise InputError(
                f"{what} takes dry joints only, and interface {i} pulls, coheres or has a limit of "
                "shear or strength" + (f": {why}" if why else ""),
                remedy="ask 'check' or 'solve_rbe', or give model.with_capacity(None)",
            )

    def require_still(self) -> None:
        """Raise InputError where the load moves supports, of an analysis whose supports stay."""
        if self.load.motion is not None:
            raise InputError(
                f"the load case '{self.load.name}' moves supports",
                remedy="ask 'settle' what that does, or take a case without settlement",
            )

    def require_ends_as_drawn(self, what: str) -> None:
        """Raise InputError where ends of joints are chosen, of an analysis that moves no blocks."""
        if self.ends is not None:
            raise InputError(
                f"{what} follows no blocks, so what becomes of ends of joints has no part in it",
                where="ends",
                remedy="leave it out",
            )

    def with_supports(self, supports: str | Sequence[int | str], up: Sequence[float] = UP) -> Model:
        """The same model with exactly these blocks fixed; see :meth:`of`.

        ``lowest`` and ``below:`` look along ``up`` (3,). What is odd about them is added to the
        notes. A plane of ground is not laid here: the contacts with it would be missing.
        """
        if not isinstance(supports, str):
            return replace(self, assembly=self.assembly.with_fixed(supports))
        assembly = select(self.assembly, supports, up=up, joints=self.joints)
        said = remarks(assembly, supports, self.joints, up)
        return replace(self, assembly=assembly, notes=(*self.notes, *said))

    @property
    def joints(self) -> Joints:
        """Blocks a (m,), blocks b (m,) and normals (m, 3) from a to b of all interfaces."""
        return self.contacts.block_a, self.contacts.block_b, self.contacts.frame[:, 0]

    def subset(self, blocks: Blocks) -> Model:
        """The model of some of the blocks, in the given order, with the contacts among them."""
        chosen = self.assembly.indices(blocks)
        return Model(
            self.assembly.subset(chosen.tolist()),
            self.contacts.of_blocks(chosen, len(self.assembly)),
            self.load.of_blocks(chosen),
            None if self.report is None else self.report.of_blocks(chosen),
            notes=self.notes,
            unjoined=among(self.unjoined, chosen),
            origin=self.origin,
            ends=self.ends,
        )

    def without(self, blocks: Blocks) -> Model:
        """The model less some of the blocks."""
        kept = ~marked(self.assembly.indices(blocks), len(self.assembly))
        return self.subset(np.flatnonzero(kept).tolist())

    @property
    def active(self) -> Bools:
        """(m,) interfaces that a free block takes part in: others carry nothing."""
        fixed = self.assembly.fixed
        return ~(fixed[self.contacts.block_a] & fixed[self.contacts.block_b])


def up_of_load(load: Any) -> tuple[float, float, float]:
    """The axis (3,) that points up under a load; z unless it is an acceleration.

    Parameters
    ----------
    load
        An acceleration (3,) [m/s2], or any other load.
    """
    if isinstance(load, Sequence | np.ndarray) and np.shape(load) == (3,) and np.any(load):
        return up_of(frozen_floats(load, (3,), "the load").tolist())
    return UP


def _with_own_friction(assembly: Assembly, contacts: Contacts) -> tuple[Contacts, tuple[str, ...]]:
    """Contacts with the friction that blocks bring in their metadata, of two the smaller."""
    own = np.array([_own_friction(block) for block in assembly.blocks])
    if np.isnan(own).all():
        return contacts, ()
    smaller = np.fmin(own[contacts.block_a], own[contacts.block_b])
    friction = np.where(np.isnan(smaller), contacts.friction, smaller)
    return contacts.with_friction(friction), ("joints have the friction that their blocks bring",)


def _own_friction(block: Block) -> float:
    """Friction coefficient in the metadata of a block; NaN where there is none."""
    given = block.metadata.get("friction")
    if isinstance(given, bool) or not isinstance(given, int | float):
        return float("nan")
    if not 0.0 <= given <= FARTHEST:
        told = quoted(given, 20)
        raise InputError(
            f"its friction is {told}", where=f"block '{block.name}'", remedy="give a coefficient"
        )
    return float(given)


__all__ = ["FlushEnds", "Model", "Origin", "up_of_load"]
