"""Families of models that depend on one parameter.

A family can be called and pickled, so any executor can use it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.contacts import Contacts
from drystone.detection import find_contacts
from drystone.geometry.frames import rotation_about, unit
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.virtual import shrink


class Family(Protocol):
    """A model for each value of a parameter."""

    @property
    def parameter(self) -> str:
        """Its name."""

    @property
    def unit(self) -> str:
        """Its unit; empty when it has none."""

    def __call__(self, value: float) -> Model:
        """The model at a value."""


@dataclass(frozen=True, eq=False)
class Tilt(OneLine):
    """The assembly rotated counter-clockwise about an axis; loads keep their direction.

    Attributes
    ----------
    model
        The model before rotation. Its forces and moments keep their direction in space.
    axis : (3,)
    """

    model: Model
    axis: Floats
    parameter: ClassVar[str] = "tilt"
    unit: ClassVar[str] = "deg"

    def __call__(self, value: float) -> Model:
        """The model at an angle [degrees]."""
        return self.model.with_load(self.turned(value))

    def turned(self, angle_deg: float) -> LoadCase:
        """The load in the axes of the rotated model."""
        turn = rotation_about(self.axis, angle_deg)
        wrench = self.model.load.wrench
        both = np.concatenate([wrench[:, :3] @ turn, wrench[:, 3:] @ turn], axis=1)
        name = f"{self.model.load.name}, tilt {angle_deg:g} deg"
        return replace(self.model.load, wrench=both, name=name)

    def is_planar(self) -> bool:
        """Whether forces are normal to the axis, and moments along it."""
        along = self.model.load.wrench.reshape(-1, 3) @ unit(self.axis, "axis")
        return bool(np.abs(along).max() <= 1e-12 * np.abs(self.model.load.wrench).max())


@dataclass(frozen=True, eq=False)
class Friction(OneLine):
    """The same friction coefficient at all joints.

    Attributes
    ----------
    model
    scaled
        Whether the value multiplies the coefficient of each joint instead of replacing it.
    """

    model: Model
    scaled: bool = False
    unit: ClassVar[str] = ""

    @property
    def parameter(self) -> str:
        """Its name."""
        return "share of friction" if self.scaled else "friction"

    def __call__(self, value: float) -> Model:
        """The model at a coefficient, or at a share of the coefficients."""
        friction = value * self.model.contacts.friction if self.scaled else value
        return self.model.with_friction(friction)


@dataclass(frozen=True, eq=False)
class LoadFactor(OneLine):
    """A live load times a factor, on top of the load of the model."""

    model: Model
    live: LoadCase
    parameter: ClassVar[str] = "load factor"
    unit: ClassVar[str] = ""

    def __call__(self, value: float) -> Model:
        """The model at a factor."""
        return self.model.with_load(self.model.load + value * self.live)


@dataclass(frozen=True, eq=False)
class Shrunk(OneLine):
    """All interfaces scaled about their centroids."""

    model: Model
    parameter: ClassVar[str] = "size of the joints"
    unit: ClassVar[str] = ""

    def __call__(self, value: float) -> Model:
        """The model at a share of the size of the joints, from 0 to 1."""
        return self.model.with_contacts(shrink(self.model.contacts, value))


@dataclass(frozen=True, eq=False)
class Parametric(OneLine):
    """A parametric model under its own weight, with a contact search for every value.

    Attributes
    ----------
    build
        Function from a value to an assembly.
    find
        Function that finds the contacts.
    parameter
        Name of the parameter.
    unit
    """

    build: Callable[[float], Assembly]
    find: Callable[[Assembly], Contacts]
    parameter: str = "thickness"
    unit: str = ""

    def __call__(self, value: float) -> Model:
        """The model at a value of the parameter."""
        assembly = self.build(value)
        return Model(assembly, self.find(assembly))


def found(friction: float, assembly: Assembly) -> Contacts:
    """The contacts of an assembly, all with one friction coefficient."""
    return find_contacts(assembly, friction=friction).contacts
