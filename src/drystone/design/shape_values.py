"""What a shape is changed for: its variables, values as their functions, and derivatives."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

import numpy as np
from scipy import sparse

from drystone.assembly import Assembly
from drystone.base.arrays import SAME, Floats, Ints, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.base.settings import Options, Stop, Stopped
from drystone.design.changed_model import changed
from drystone.design.margin import DesignMargin
from drystone.design.needs import GROUND, Form
from drystone.design.vertex_places import BlockVertices
from drystone.geometry.frames import unit
from drystone.geometry.polyhedron import edges_of
from drystone.model import Model


class ShapeAim(enum.Enum):
    """What a shape is changed for."""

    STAND = "stand"
    """The least share of the load that needs help."""
    VOLUME = "volume"
    """The least volume [m3] with which it stands at the margin."""
    REACH = "reach"
    """The farthest reach [m] with which it stands at the margin."""


MEASURES = {
    ShapeAim.STAND: "share of the load that needs help",
    ShapeAim.VOLUME: "volume [m3]",
    ShapeAim.REACH: "reach [m]",
}
"""What is to be best."""


@dataclass(frozen=True)
class ShapeOptions(Options):
    """Options of :func:`shape`.

    Attributes
    ----------
    aim
        To stand; the least volume, or the farthest reach, with which it stands at the margin.
    margin
        Margin with which it has to stand: ``tilt=2deg`` to each side, ``load=1.2`` times the load,
        ``friction=0.9x``, or ``sensitive``, where STABLE after settling is enough.
    reach : (3,)
        The direction of the farthest reach.
    block
        Name or position of the block that reaches out.
    rounds : >= 1
        Steps of the search at most; contacts are found anew after each.
    iterations : >= 1
        Iterations of the optimiser in one round at most.
    least_edge : [m] >= 0, < inf
        No edge that moves gets shorter: the least thickness of blocks.
    trust : > 0, <= 1
        Largest change of a variable in the first round, by its largest move.
    close : > 0, < 1
        The search ends when a round gains less than this share.
    """

    aim: ShapeAim = ShapeAim.STAND
    margin: DesignMargin = field(default_factory=DesignMargin)
    reach: tuple[float, float, float] = (1.0, 0.0, 0.0)
    block: int | str = -1
    rounds: int = 20
    iterations: int = 40
    least_edge: float = 0.0
    trust: float = 0.25
    close: float = 1e-3


class ShapeValues:
    """What is to be least, the help that is needed and the lengths of edges of one shape.

    Parameters
    ----------
    model
        As given: where all variables are zero.
    moves, options
    late
        Asked before the help is computed; True raises :class:`Stopped`.

    Attributes
    ----------
    least_edge : [m] > 0
        No edge that moves gets shorter; the options' at first.
    crossed
        Whether a shape was refused because blocks crossed themselves.
    """

    def __init__(
        self,
        model: Model,
        moves: ShapeVariables,
        options: ShapeOptions,
        late: Stop,
    ) -> None:
        self.model, self.moves, self.options, self.late = model, moves, options, late
        self.bodies = BlockVertices.of(model.assembly)
        self.known: dict[bytes, tuple[float, Floats]] = {}
        self.forms: list[Form] = []
        self.ground = GROUND
        self.at = np.zeros(moves.count)
        self.here = self.bodies.vertex
        self.matrix: sparse.csr_matrix = moves.matrix_at(self.at)
        self.least_edge = options.least_edge
        self.crossed = False

    def found_anew(self, model: Model, x: Floats) -> None:
        """The forms of the model with variables (p,), in all its cases, with its contacts now.

        From here on vertices are followed along their tangents.
        """
        self.known.clear()
        cases = (model, *self.options.margin.cases(model))
        each = self.options.aim is ShapeAim.STAND
        self.forms = [Form.of(one, self.ground, each=each) for one in cases]
        self.at, self.here = x, self.moves.moved(self.bodies.vertex, x)
        self.matrix = self.moves.matrix_at(x)

    def vertices(self, x: Floats) -> Floats:
        """The vertices (v, 3) with variables (p,), along their tangents."""
        return self.here + (self.matrix @ (x - self.at)).reshape(-1, 3)

    def objective(self, x: Floats) -> tuple[float, Floats]:
        """What is to be least, and its derivative (p,)."""
        aim = self.options.aim
        if aim is ShapeAim.STAND:
            value, gradient = self.help_at(x)
            return value, gradient
        vertex = self.vertices(x)
        if aim is ShapeAim.VOLUME:
            volume, _ = self.bodies.measures(vertex)
            by_vertex = self.bodies.measures_pulled_back(
                vertex, np.ones(len(volume)), np.zeros((len(volume), 3))
            )
            return float(volume.sum()), self.pulled_back(by_vertex)
        block = int(self.model.assembly.indices([self.options.block])[0])
        own = self.bodies.of_block.owner == block
        along = unit(np.asarray(self.options.reach, dtype=np.float64), "the reach")
        by_vertex = np.where(own[:, None], -along / own.sum(), 0.0)
        return float((by_vertex * vertex).sum()), self.pulled_back(by_vertex)

    def pulled_back(self, by_vertex: Floats) -> Floats:
        """The derivative (p,) by the variables, from that by the vertices (v, 3)."""
        return self.matrix.T @ by_vertex.ravel()

    def edges(self, x: Floats) -> tuple[Floats, Floats]:
        """By how much edges (e,) that move are longer than the least, by the least; (e, p).

        Each is measured along its direction where contacts were found. So it is linear, and an edge
        that has turned round is too short.
        """
        vertex, (i, j) = self.vertices(x), self.moving.T
        along = self.here[i] - self.here[j]
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        slope = sum(
            along[:, axis, None] * (self.matrix[3 * i + axis] - self.matrix[3 * j + axis]).toarray()
            for axis in range(3)
        )
        length = ((vertex[i] - vertex[j]) * along).sum(axis=1)
        return length / self.least_edge - 1.0, slope / self.least_edge

    def shortest(self, vertex: Floats) -> float:
        """The length of the shortest edge that moves, for vertices (v, 3) [m]."""
        i, j = self.moving.T
        return float(np.linalg.norm(vertex[i] - vertex[j], axis=1).min(initial=np.inf))

    @cached_property
    def moving(self) -> Ints:
        """The edges (e, 2) of all blocks whose length changes with a variable."""
        matrix = self.moves.matrix_at(np.zeros(self.moves.count))
        pairs = zip(self.bodies.of_block.first, self.model.assembly.blocks, strict=True)
        edges = np.concatenate([first + edges_of(block.faces) for first, block in pairs])
        changes = np.zeros(len(edges), dtype=bool)
        for axis in range(3):
            both = matrix[3 * edges[:, 0] + axis] - matrix[3 * edges[:, 1] + axis]
            changes |= abs(both).max(axis=1).toarray().ravel() > 0.0
        return edges[changes]

    def help_at(self, x: Floats) -> tuple[float, Floats]:
        """Share of the load on the ground, over all cases, and its derivative (p,)."""
        if self.late():
            raise Stopped
        key = np.asarray(x).tobytes()
        if key not in self.known:
            vertex = self.vertices(x)
            both = [form.help_at(vertex) for form in self.forms]
            size = float(np.sqrt(sum(value for value, _ in both)))
            gradient = np.sum([one for _, one in both], axis=0) / (2.0 * max(size, 1e-30))
            self.known[key] = size, self.pulled_back(gradient)
        return self.known[key]

    def made(self, x: Floats) -> Model | None:
        """The model with variables (p,), its contacts found anew; ``None`` where it cannot be."""
        try:
            vertex = self.moves.moved(self.bodies.vertex, x)
            if self.shortest(vertex) < (1.0 - SAME) * self.least_edge:
                return None
            try:
                assembly = self.bodies.assembly_at(vertex)
            except InputError:
                self.crossed = True
                return None
            moved = {
                i: block
                for i, block in enumerate(assembly.blocks)
                if block is not self.model.assembly.blocks[i]
            }
            return changed(self.model, moved)
        except InputError:
            return None


STEP = 6e-6
"""Step of central differences by the size of a variable: the cube root of the rounding, where the
errors of rounding and of the step are equal."""


@runtime_checkable
class ShapeVariables(Protocol):
    """How vertices depend on variables."""

    @property
    def most(self) -> Floats:
        """Largest size (p,) of each variable."""

    @property
    def count(self) -> int:
        """Number of variables, p."""

    def moved(self, vertex: Floats, x: Floats) -> Floats:
        """The vertices (v, 3) of the model as given, moved by variables (p,)."""

    def matrix_at(self, x: Floats) -> sparse.csr_matrix:
        """Derivative (3 v, p) of the vertices by the variables."""


@dataclass(frozen=True, eq=False)
class FamilyMoves(OneLine):
    """The variables of a shape that is one of a parametric family.

    Attributes
    ----------
    build
        Makes an assembly or a model of the parameters, by their names. The blocks and their faces
        are the same for all values.
    start
        The values of the model as given.
    most : (p,)
        Largest change of each value.
    """

    build: Callable[..., Assembly | Model]
    start: Mapping[str, float]
    most: Floats

    def _summary(self) -> str:
        return f"parameters {', '.join(self.start)}"

    @classmethod
    def of(
        cls, build: Callable[..., Any], start: Mapping[str, float], most: Mapping[str, float]
    ) -> FamilyMoves:
        """The variables of a family.

        Parameters
        ----------
        build
        start
            Values of the parameters that change.
        most
            Largest change of each of them.

        Raises
        ------
        InputError
            No parameter changes, the names differ, or a largest change is not above zero.

        Examples
        --------
        >>> from drystone.models import arch
        >>> moves = FamilyMoves.of(arch, {"thickness_ratio": 0.2}, {"thickness_ratio": 0.15})
        >>> moves.count
        1
        """
        if not start or set(start) != set(most):
            raise InputError(
                "the start values and the largest changes name different parameters",
                remedy="give a value and a largest change for each of them",
            )
        largest = np.array([number(most[name], f"the change of {name}") for name in start])
        if not ((largest > 0.0) & np.isfinite(largest)).all():
            raise InputError("a largest change is not above zero", remedy="give numbers above zero")
        return cls(build, dict(start), largest)

    @property
    def count(self) -> int:
        """Number of variables, p."""
        return len(self.start)

    def values(self, x: Floats) -> dict[str, float]:
        """The values of the parameters for variables (p,)."""
        pairs = zip(self.start.items(), x.tolist(), strict=True)
        return {name: value + change for (name, value), change in pairs}

    def moved(self, vertex: Floats, x: Floats) -> Floats:
        """The vertices (v, 3) with variables (p,).

        Raises
        ------
        InputError
            The blocks are others than those of the model as given.
        """
        found = self._vertices(x)
        if found.shape != vertex.shape:
            raise InputError(
                f"the family has {len(found)} vertices here, and {len(vertex)} as given",
                remedy="vary parameters that keep the blocks and their faces",
            )
        return found

    def matrix_at(self, x: Floats) -> sparse.csr_matrix:
        """Derivative (3 v, p) of the vertices by the variables, from central differences."""
        steps = STEP * np.diag(self.most)
        columns = [(self._vertices(x + step) - self._vertices(x - step)).ravel() for step in steps]
        return sparse.csr_matrix(np.stack(columns, axis=1) / (2.0 * STEP * self.most))

    def _vertices(self, x: Floats) -> Floats:
        """The vertices of what is built of variables (p,)."""
        made = self.build(**self.values(x))
        return (made.assembly if isinstance(made, Model) else made).faces.point
