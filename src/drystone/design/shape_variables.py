"""The variables of a shape: what the search needs of them, and those of a parametric family."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy import sparse

from drystone.assembly import Assembly
from drystone.base.arrays import Floats, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.design.vertex_measures import vertices_of
from drystone.model import Model

STEP = 6e-6
"""Step of central differences by the size of a variable: the cube root of the rounding, where the
errors of rounding and of the step are equal."""


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
        return vertices_of(made.assembly if isinstance(made, Model) else made)
