"""Families of models that depend on one parameter.

A family can be called and pickled, so any executor can use it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Protocol

import numpy as np

from drystone.assembly import Assembly
from drystone.base.arrays import Floats
from drystone.base.display import OneLine
from drystone.base.units import NUMBER
from drystone.contacts import Contacts
from drystone.detection import find_contacts
from drystone.geometry.frames import axis_words, rotation_about, unit
from drystone.loads import LoadCase
from drystone.loads.applied import common_acceleration
from drystone.model import FlushEnds, Model
from drystone.virtual import shrink


@dataclass(frozen=True)
class Quantity(OneLine):
    """What a limit varies, and how it is told.

    Attributes
    ----------
    name
    unit
        Empty when it has none.
    phrase
        Words with ``{}`` for a value; when left out, the name, the value and the unit.
    replaces
        Attributes of :class:`drystone.answer.Question` that it decides.
    inverse
        What one divided by the limit is called; empty when it has no meaning.
    remark
        What the answer says of how it is varied.
    acting
        How much of it the model has already, beside what is varied.
    load
        What was asked to act, where it is varied.
    """

    name: str
    unit: str = ""
    phrase: str = ""
    replaces: tuple[str, ...] = ()
    inverse: str = ""
    remark: str = ""
    acting: float = 0.0
    load: str = ""

    @property
    def words(self) -> str:
        """The name as a person writes it."""
        return self.name.replace("_", " ")

    def told(self, number: str) -> str:
        """A value in words."""
        if self.acting:
            every = self.acting + float(number)
            return f"{self.words} {number} on top of what acts: {every:.10g} in all"
        if self.phrase:
            return self.phrase.format(number)
        return f"{self.words} {number}{f' {self.unit}' if self.unit else ''}"


class Family(Protocol):
    """A model for each value of a quantity."""

    @property
    def quantity(self) -> Quantity:
        """What differs between them."""

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

    @property
    def quantity(self) -> Quantity:
        """The angle about that axis."""
        phrase = f"{{}} degrees {axis_words(self.axis)}"
        told = ""
        if self._pushed:
            told = "loads beside weight, such as of fill, keep their direction while it turns"
        return Quantity("tilt", "deg", phrase, ("load", "acceleration", "loads"), remark=told)

    @property
    def _pushed(self) -> bool:
        """Whether anything beside an acceleration of all masses acts."""
        assembly, load = self.model.assembly, self.model.load
        rest = load.wrench.copy()
        rest[:, :3] -= assembly.mass[:, None] * common_acceleration(assembly, load)
        least = 1e-9 * float(np.abs(load.wrench).max(initial=0.0))
        return bool(np.abs(rest[assembly.free]).max(initial=0.0) > least)

    def __call__(self, value: float) -> Model:
        """The model at an angle [degrees]."""
        return self.model.with_load(self.turned(value))

    def turned(self, angle_deg: float) -> LoadCase:
        """The load in the axes of the rotated model."""
        load = self.model.load.turned(rotation_about(self.axis, angle_deg))
        return replace(load, name=f"{self.model.load.name}, tilt {angle_deg:g} deg")

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

    @property
    def quantity(self) -> Quantity:
        """The coefficient, or a share of the coefficients."""
        name = "share of friction" if self.scaled else "friction"
        return Quantity(name, replaces=("friction",))

    def __call__(self, value: float) -> Model:
        """The model at a coefficient, or at a share of the coefficients."""
        friction = value * self.model.contacts.friction if self.scaled else value
        return self.model.with_friction(friction)


@dataclass(frozen=True, eq=False)
class LoadFactor(OneLine):
    """A live load times a factor, on top of the load of the model."""

    model: Model
    live: LoadCase

    @cached_property
    def quantity(self) -> Quantity:
        """The factor, and how much of the live load the model has: by its name, if it fits."""
        load, name = self.model.load, self.live.name
        parts = [one.removesuffix(name).rstrip(" *") for one in load.name.split(" + ")
                 if one.endswith(name)]  # fmt: skip
        known = [1.0 if not one else float(one) if NUMBER.fullmatch(one) else 0.0 for one in parts]
        along = float((load.wrench * self.live.wrench).sum() / (self.live.wrench**2).sum())
        acting = sum(known) if sum(known) <= along * (1.0 + 1e-9) else 0.0
        asked, replaces = f"{load.name}, and {name} times a factor", ("acceleration", "loads")
        return Quantity("load factor", replaces=replaces, acting=acting, load=asked)

    def __call__(self, value: float) -> Model:
        """The model at a factor."""
        return self.model.with_load(self.model.load + value * self.live)


@dataclass(frozen=True, eq=False)
class Shrunk(OneLine):
    """All interfaces scaled about their centroids."""

    model: Model
    quantity: ClassVar[Quantity] = Quantity(
        "size of the joints",
        phrase="{} of the size of the joints",
        inverse="geometric safety factor",
    )

    def __call__(self, value: float) -> Model:
        """The model at a share of the size of the joints, from 0 to 1."""
        return self.model.with_contacts(shrink(self.model.contacts, value))


@dataclass(frozen=True, eq=False)
class Weakened(OneLine):
    """All strengths of the joints times a share."""

    model: Model
    quantity: ClassVar[Quantity] = Quantity(
        "share of strength",
        phrase="{} of the strength of the joints",
        inverse="factor on the strength",
    )

    def __call__(self, value: float) -> Model:
        """The model at a share of the strengths, from 0 to 1."""
        capacity = self.model.contacts.capacity
        return self.model if capacity is None else self.model.with_capacity(capacity.scaled(value))


@dataclass(frozen=True, eq=False)
class Parametric(OneLine):
    """A parametric model under its own weight, with a contact search for every value.

    Attributes
    ----------
    build
        Function from a value to an assembly.
    find
        Function that finds the contacts.
    quantity
    ends
    """

    build: Callable[[float], Assembly]
    find: Callable[[Assembly], Contacts]
    quantity: Quantity = Quantity("thickness")
    ends: FlushEnds | None = None

    def __call__(self, value: float) -> Model:
        """The model at a value of the parameter."""
        assembly = self.build(value)
        return Model(assembly, self.find(assembly), ends=self.ends)


def found(friction: float, assembly: Assembly) -> Contacts:
    """The contacts of an assembly, all with one friction coefficient."""
    return find_contacts(assembly, friction=friction).contacts
