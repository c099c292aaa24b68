"""What a limit varies: problems that depend on one number.

A family is a value that can be called, and pickled, so that any executor can work on it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.detection import find_contacts
from drystone.errors import InputError
from drystone.geometry.arrays import Floats
from drystone.geometry.frames import rotation_about, unit
from drystone.loads import LoadCase
from drystone.virtual import shrink


@dataclass(frozen=True, eq=False)
class Problem:
    """One model under one load."""

    assembly: Assembly
    contacts: Contacts
    load: LoadCase


class Family(Protocol):
    """A problem for each value of a parameter."""

    @property
    def parameter(self) -> str:
        """Its name."""

    @property
    def unit(self) -> str:
        """Its unit; empty when it has none."""

    def __call__(self, value: float) -> Problem:
        """The problem at a value."""


@dataclass(frozen=True, eq=False)
class Tilt:
    """The whole assembly turned counter-clockwise about an axis, its loads staying upright.

    Attributes
    ----------
    assembly, contacts
    load
        At rest. Its forces and moments keep their direction in space while the model turns.
    axis : (3,)
    """

    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    axis: Floats
    parameter: ClassVar[str] = "tilt"
    unit: ClassVar[str] = "deg"

    def __call__(self, value: float) -> Problem:
        """The problem at an angle [degrees]."""
        return Problem(self.assembly, self.contacts, self.turned(value))

    def turned(self, angle_deg: float) -> LoadCase:
        """The load as the turned model feels it."""
        turn = rotation_about(self.axis, angle_deg)
        wrench = self.load.wrench
        both = np.concatenate([wrench[:, :3] @ turn, wrench[:, 3:] @ turn], axis=1)
        name = f"{self.load.name}, tilt {angle_deg:g} deg"
        return replace(self.load, wrench=both, name=name)

    def is_planar(self) -> bool:
        """Whether every force and moment lies in the plane that the axis is normal to."""
        along = self.load.wrench.reshape(-1, 3) @ unit(self.axis, "axis")
        return bool(np.abs(along).max() <= 1e-12 * np.abs(self.load.wrench).max())


@dataclass(frozen=True, eq=False)
class Friction:
    """The same friction coefficient at all joints.

    Attributes
    ----------
    assembly, contacts, load
    scaled
        Whether the value multiplies the coefficient of each joint instead of replacing it.
    """

    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    scaled: bool = False
    unit: ClassVar[str] = ""

    @property
    def parameter(self) -> str:
        """Its name."""
        return "share of friction" if self.scaled else "friction"

    def __call__(self, value: float) -> Problem:
        """The problem at a coefficient, or at a share of the coefficients."""
        friction = value * self.contacts.friction if self.scaled else value
        return Problem(self.assembly, self.contacts.with_friction(friction), self.load)


@dataclass(frozen=True, eq=False)
class LoadFactor:
    """A live load times a factor, on top of a dead load."""

    assembly: Assembly
    contacts: Contacts
    dead: LoadCase
    live: LoadCase
    parameter: ClassVar[str] = "load factor"
    unit: ClassVar[str] = ""

    def __call__(self, value: float) -> Problem:
        """The problem at a factor."""
        return Problem(self.assembly, self.contacts, self.dead + value * self.live)


@dataclass(frozen=True, eq=False)
class Shrunk:
    """All interfaces scaled about their centroids."""

    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    parameter: ClassVar[str] = "size of the joints"
    unit: ClassVar[str] = ""

    def __call__(self, value: float) -> Problem:
        """The problem at a share of the size of the joints, from 0 to 1."""
        return Problem(self.assembly, shrink(self.contacts, value), self.load)


@dataclass(frozen=True, eq=False)
class Parametric:
    """A parametric model under its own weight, its contacts found anew for every value.

    Attributes
    ----------
    build
        The model of a value.
    find
        The contacts of a model.
    parameter
        Name of what varies.
    unit
    """

    build: Callable[[float], Assembly]
    find: Callable[[Assembly], Contacts]
    parameter: str = "thickness"
    unit: str = ""

    def __call__(self, value: float) -> Problem:
        """The problem at a value of the parameter."""
        assembly = self.build(value)
        return Problem(assembly, self.find(assembly), LoadCase.gravity(assembly))


def found(friction: float, assembly: Assembly) -> Contacts:
    """The contacts of an assembly, all with one friction coefficient."""
    return find_contacts(assembly, friction=friction).contacts


def resting(assembly: Assembly, load: LoadCase | None) -> LoadCase:
    """The load, or self-weight when there is none."""
    return LoadCase.gravity(assembly) if load is None else load


def number(value: Any, what: str) -> float:
    """A finite number.

    Raises
    ------
    InputError
    """
    try:
        given = float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be a number") from error
    if not np.isfinite(given):
        raise InputError(f"{what} is {given}", remedy="give a finite number")
    return given


__all__ = [
    "Family",
    "Friction",
    "LoadFactor",
    "Parametric",
    "Problem",
    "Shrunk",
    "Tilt",
    "found",
    "number",
    "resting",
]
