"""Struts, ropes, clamps and centring: where they hold a block, and how much they bear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drystone.base.arrays import Floats, frozen_floats, number
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted


@dataclass(frozen=True, eq=False)
class ScaffoldItem(OneLine):
    """What holds one block.

    Parameters
    ----------
    block
        Position or name of the block.
    limit : [N]
        Largest force of the whole item; infinite when left out.

    Raises
    ------
    InputError
        A point is none, or a limit is not above zero.
    """

    block: int | str
    limit: float = float("inf")

    def __post_init__(self) -> None:
        self._require_positive("limit", self.limit, "newtons")

    def _require_positive(self, what: str, value: Any, unit: str) -> None:
        if not number(value, f"{self._place()}: its {what}", finite=False) > 0.0:
            raise InputError(
                f"its {what} is {value}", where=self._place(), remedy=f"give {unit} above zero"
            )

    def _points(self, *names: str) -> None:
        """Take the fields of these names as points (3,)."""
        for name in names:
            point = frozen_floats(getattr(self, name), (3,), f"{self._place()}: its {name}")
            object.__setattr__(self, name, point)

    def _place(self) -> str:
        return f"{type(self).__name__.lower()} of block '{self.block}'"

    @property
    def length(self) -> float:
        """[m] of material that it takes."""
        return 0.0


@dataclass(frozen=True, eq=False)
class Strut(ScaffoldItem):
    """Pushes a block from a foot, on the ground or on another block.

    Attributes
    ----------
    head, foot : (3,) [m]
        Where it touches the block, and where it stands.
    on
        Block on which it stands, which bears the force; the ground when left out.
    """

    head: Sequence[float] = (0.0, 0.0, 0.0)
    foot: Sequence[float] = (0.0, 0.0, 0.0)
    on: int | str | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self._points("head", "foot")
        if self.on is not None and self.on == self.block:
            raise InputError(
                "it stands on the block that it props", where=self._place(), remedy="name another"
            )

    @property
    def length(self) -> float:
        """[m]"""
        return float(np.linalg.norm(np.subtract(self.head, self.foot)))


@dataclass(frozen=True, eq=False)
class Rope(ScaffoldItem):
    """Pulls a block towards an anchor.

    Attributes
    ----------
    at, anchor : (3,) [m]
        Where it is tied to the block, and where it hangs from.
    """

    at: Sequence[float] = (0.0, 0.0, 0.0)
    anchor: Sequence[float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._points("at", "anchor")

    @property
    def length(self) -> float:
        """[m]"""
        return float(np.linalg.norm(np.subtract(self.at, self.anchor)))


@dataclass(frozen=True, eq=False)
class Clamp(ScaffoldItem):
    """Holds a block at its centroid, pushing and pulling.

    Attributes
    ----------
    moment : [N m]
        Largest moment about the centroid.
    """

    moment: float = float("inf")

    def __post_init__(self) -> None:
        super().__post_init__()
        self._require_positive("moment", self.moment, "newton metres")


@dataclass(frozen=True, eq=False)
class Centring(ScaffoldItem):
    """Carries the free lower face of a block.

    Attributes
    ----------
    face : (c, 3) [m]
        Its corners, counter-clockwise from outside the block.
    friction
        Coefficient.
    height : [m]
        Of the face above the ground, which counts as length.
    """

    face: Floats = None  # type: ignore[assignment]  # always given
    friction: float = 0.6
    height: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        face = frozen_floats(self.face, (None, 3), f"{self._place()}: its face")
        if len(face) < 3:
            raise InputError(
                f"its face has {counted(len(face), 'corner')}",
                where=self._place(),
                remedy="give three or more",
            )
        object.__setattr__(self, "face", face)

    @property
    def length(self) -> float:
        """[m]"""
        return self.height
