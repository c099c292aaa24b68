"""What a joint carries beyond friction, and what crushes it: mortar, glue, studs, dowels, stone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from drystone.base.arrays import Bools, Floats, Ints, frozen, number, one_or_each, whole
from drystone.base.display import OneLine
from drystone.base.errors import InputError, counted, quoted

_PerInterface: TypeAlias = float | Sequence[float] | Floats
"""One number for all interfaces, or one each."""

NO_LIMIT = 1e30
"""[N]. A capacity of this size or more is no limit."""

DRY: Mapping[str, float] = {
    "tension": 0.0,
    "cohesion": 0.0,
    "shear": NO_LIMIT,
    "compression": NO_LIMIT,
}
"""The capacities, and what a dry joint has of each [N]."""


@dataclass(frozen=True, eq=False)
class JointCapacity(OneLine):
    """Largest pull, cohesion, largest shear and strength in compression of each interface.

    The force of an interface is spread over its corners by their tributary areas. With the share w
    of a corner, its normal force fn (positive in compression) and tangential force ft::

        fn >= -w tension,    |ft| <= mu fn + w cohesion,    |ft| <= w shear

    This is the law of Mohr and Coulomb with a limit of tension and one of shear. A joint slides
    open at a pull of cohesion / mu, so a larger ``tension`` is never reached.

    A joint of finite ``compression`` crushes: what presses is carried by a part of the face under
    the stress compression / area, a stress block.

    Parameters
    ----------
    tension : (m,) [N]
        Largest pull of the whole interface, where it pulls evenly.
    cohesion : (m,) [N]
        Tangential force of the whole interface without any normal force.
    shear : (m,) [N]
        Largest tangential force of the whole interface. Left out, without limit.
    compression : (m,) [N]
        Largest force of the whole interface that presses evenly. Left out, without limit.
    brittle
        Whether a joint that exceeds its pull or cohesion loses both, as mortar does. Otherwise it
        keeps pulling (ductile), as studs and dowels do.

    Raises
    ------
    InputError
        The lengths differ, or a value is negative or not a number.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import tower
    >>> model = drystone.Model.of(tower(2), friction=0.6)
    >>> glue = JointCapacity.of_stress(model.contacts, tension=2e5, cohesion=3e5)
    >>> glue.tension.tolist(), glue.cohesion.tolist()
    ([200000.0], [300000.0])
    >>> glued = model.with_capacity(glue)
    """

    tension: Floats
    cohesion: Floats
    shear: Floats = None  # type: ignore[assignment]  # filled in below
    compression: Floats = None  # type: ignore[assignment]
    brittle: bool = True

    def __post_init__(self) -> None:
        count = len(np.atleast_1d(np.asarray(self.tension)))
        for name, dry in DRY.items():
            given = getattr(self, name)
            value = np.full(count, dry) if given is None else given
            object.__setattr__(self, name, _capacities(value, count, name))

    def _summary(self) -> str:
        some = int(((self.tension > 0.0) | (self.cohesion > 0.0)).sum())
        crush = int((self.compression < NO_LIMIT).sum())
        told = f"{counted(len(self.tension), 'interface')}, {some} of them pull or cohere"
        told += f" ({self.law})" if self.law else ""
        return f"{told}, {crush} crush" if crush else told

    @property
    def law(self) -> str:
        """``brittle`` or ``ductile``; empty where nothing pulls or coheres."""
        if not (self.tension.any() or self.cohesion.any()):
            return ""
        return "brittle" if self.brittle else "ductile"

    def scaled(self, share: float) -> JointCapacity:
        """Every capacity times a share; what has no limit keeps none."""
        by = number(share, "the share")
        shares = {
            name: np.where(getattr(self, name) < NO_LIMIT, by * getattr(self, name), NO_LIMIT)
            for name in DRY
        }
        return self.with_values(shares)

    @classmethod
    def of(
        cls,
        contacts: Any,
        *,
        tension: _PerInterface | None = None,
        cohesion: _PerInterface | None = None,
        shear: _PerInterface | None = None,
        compression: _PerInterface | None = None,
        moment: _PerInterface | None = None,
        brittle: bool = True,
    ) -> JointCapacity:
        """From forces, one for all interfaces or one each.

        A joint that pulls with T everywhere and is not pressed opens about an edge at the moment
        T d, where d is the distance of the edge from the centroid. So a limit of moment is one of
        tension: ``T <= moment / d`` with the largest distance d of a corner, for bending about any
        axis.

        Parameters
        ----------
        contacts
        tension, cohesion, shear : [N]
            Left out, the cohesion is friction times tension: just enough for the whole pull.
        compression : [N] > 0
        moment : [N m]
            Largest bending moment of a joint that is not pressed. Pressure adds to it.
        brittle
        """
        m = _interfaces(contacts)
        given = tension if tension is not None else 0.0 if moment is None else NO_LIMIT
        pull = _capacities(given, m, "tension")
        if moment is not None:
            apart = np.linalg.norm(contacts.point - contacts.centroid[contacts.interface], axis=1)
            reach = contacts.corners.max(apart)
            most = _capacities(moment, m, "moment")
            pull = np.minimum(pull, np.divide(most, reach, where=reach > 0.0, out=np.zeros(m)))
        if cohesion is None:
            cohesion = contacts.friction * pull
        slide = NO_LIMIT if shear is None else shear
        return cls(
            pull,
            _capacities(cohesion, m, "cohesion"),
            _capacities(slide, m, "shear"),
            _strengths(compression, m),
            brittle,
        )

    @classmethod
    def of_stress(
        cls,
        contacts: Any,
        *,
        tension: _PerInterface = 0.0,
        cohesion: _PerInterface | None = None,
        shear: _PerInterface | None = None,
        compression: _PerInterface | None = None,
        brittle: bool = True,
    ) -> JointCapacity:
        """From stresses times the areas of the interfaces; see :meth:`of`.

        Parameters
        ----------
        contacts
        tension, cohesion, shear : [Pa]
        compression : [Pa] > 0
            Edges and points have no area: they carry nothing then.
        brittle
        """
        m, area = _interfaces(contacts), contacts.area
        strength = None if compression is None else _strengths(compression, m)

        def forces(value: Any, name: str) -> Any:
            return None if value is None else _capacities(value, m, name) * area

        made = cls.of(
            contacts,
            tension=forces(tension, "tension"),
            cohesion=forces(cohesion, "cohesion"),
            shear=forces(shear, "shear"),
            brittle=brittle,
        )
        return made if strength is None else replace(made, compression=strength * area)

    def stress_on(self, area: Floats) -> dict[str, float]:
        """What is one stress [Pa] on all faces of areas (m,) [m2]; edges carry none of it.

        Of what pulls or slides only where it is not one force as well.

        Examples
        --------
        >>> area = np.array([2.0, 1.0, 0.0])
        >>> JointCapacity(np.zeros(3), np.zeros(3), compression=1e6 * area).stress_on(area)
        {'compression': 1000000.0}
        """
        found = {}
        for name in DRY:
            force = getattr(self, name)
            if (force >= NO_LIMIT).any():
                continue
            each = np.divide(force, area, out=np.zeros(len(area)), where=area > 0.0)
            most = float(each.max(initial=0.0))
            even = most > 0.0 and np.allclose(force, most * area, rtol=1e-9, atol=0.0)
            if even and (name == "compression" or np.ptp(force) > 1e-9 * force.max()):
                found[name] = most
        return found

    @classmethod
    def dry(cls, count: int) -> JointCapacity:
        """Of so many dry joints."""
        most = whole(count, "count", least=0)
        try:
            none: dict[str, Any] = {name: np.full(most, value) for name, value in DRY.items()}
        except (ValueError, OverflowError, MemoryError) as error:
            raise InputError(f"count is {quoted(count)}", remedy="memory holds fewer") from error
        return cls(**none)

    def select(self, interfaces: Bools | Ints) -> JointCapacity:
        """Those of some interfaces (mask or positions)."""
        try:
            return self.with_values({name: getattr(self, name)[interfaces] for name in DRY})
        except (IndexError, OverflowError) as error:
            raise InputError("no such interfaces", remedy="give positions, or a mask") from error

    def summed(self, joint: Ints) -> JointCapacity:
        """Those of joints (m,) that consist of several interfaces."""
        return self.with_values({name: np.bincount(joint, getattr(self, name)) for name in DRY})

    def with_values(self, values: Mapping[str, Any]) -> JointCapacity:
        """The same law with other values (m,) of each capacity."""
        return JointCapacity(**values, brittle=self.brittle)

    def on_faces(self, area: Floats, before: Floats) -> JointCapacity:
        """The same stresses on faces of other areas (m,) [m2] than before; edges keep their forces.

        Examples
        --------
        >>> one = JointCapacity(np.zeros(1), np.zeros(1), compression=np.array([1e6]))
        >>> half = one.on_faces(np.array([0.5]), np.array([1.0]))
        >>> half.compression.tolist(), half.shear.tolist() == one.shear.tolist()
        ([500000.0], True)
        """
        share = np.divide(area, before, out=np.ones(len(before)), where=before > 0.0)
        given = {name: getattr(self, name) for name in DRY}
        return self.with_values(
            {name: np.where(one < NO_LIMIT, share * one, one) for name, one in given.items()}
        )

    def cracked(self, interfaces: Bools) -> JointCapacity:
        """The same where some interfaces (m,) neither pull nor cohere any more."""
        pull, cohesion = (np.where(interfaces, 0.0, one) for one in (self.tension, self.cohesion))
        return replace(self, tension=pull, cohesion=cohesion)


def _strengths(values: Any, count: int) -> Floats:
    """Strengths (count,) in compression, above zero; without limit where left out."""
    out = _capacities(NO_LIMIT if values is None else values, count, "compression")
    if not (out > 0.0).all():
        raise InputError(
            f"the strength in compression of interface {int(np.argmin(out > 0.0))} is 0",
            remedy="give more than zero, or leave it out: joints do not crush then",
        )
    return out


def _interfaces(contacts: Any) -> int:
    """How many interfaces contacts have; anything else is refused."""
    if not hasattr(contacts, "interface"):
        raise InputError(f"contacts is {quoted(contacts)}", remedy="give the .contacts of a model")
    return int(contacts.count)


def _capacities(values: Any, count: int, name: str) -> Floats:
    out = one_or_each(values, count, name)
    least = 1e-100  # that of loads: what is divided by it is still a number
    bad = ~((out == 0.0) | (out >= least))
    if bad.any():
        raise InputError(
            f"the {name} of interface {int(np.argmax(bad))} is {out[np.argmax(bad)]}",
            remedy=f"give newtons: zero, or {least:g} and more",
        )
    return frozen(np.minimum(out, NO_LIMIT))


__all__ = ["DRY", "NO_LIMIT", "JointCapacity"]
