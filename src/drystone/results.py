"""What an analysis answers: verdict, forces, motion, and the residuals that prove it."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from drystone.assembly import Blocks
from drystone.base.arrays import Floats, number
from drystone.base.display import Card, OneLine
from drystone.base.errors import InputError, counted
from drystone.base.table import Table
from drystone.joints import (
    Resultants,
    ThrustLine,
    joint_table,
    resultants_of,
    thrust_line,
    utilisation_of,
    world_forces,
)
from drystone.loads import LoadCase
from drystone.model import Model, OfModel


class Verdict(enum.StrEnum):
    """The answer to "does it stand?". It never guesses."""

    STABLE = "stable"
    """Forces and a compatible motion were found and checked."""
    UNSTABLE = "unstable"
    """It falls, and a checked proof is attached."""
    UNDECIDED = "undecided"
    """Neither was found; the message says what was tried."""
    EQUILIBRIUM_EXISTS = "equilibrium exists"
    """RBE only: some forces balance the loads. Necessary for standing, not sufficient."""


@dataclass(frozen=True)
class Residuals(OneLine):
    """How well each condition is met, recomputed from points and cross products.

    All dimensionless: forces by mean block weight, lengths by block size.

    Attributes
    ----------
    equilibrium
        Largest unbalanced component on any block.
    tension
        Largest pull.
    cone
        Largest excess of friction over the coefficient times the normal force.
    complementarity
        Largest product of normal force and opening.
    alignment
        Largest component of friction that does not act against the displacement.
    overlap
        Largest difference of the overlaps of pressed corners, by their mean (eq. 5.6 only).
    """

    equilibrium: float = 0.0
    tension: float = 0.0
    cone: float = 0.0
    complementarity: float = 0.0
    alignment: float = 0.0
    overlap: float = 0.0

    @property
    def largest(self) -> float:
        """The worst of them."""
        return max(vars(self).values())


@dataclass(frozen=True)
class Samples:
    """Contact stiffness distributions tried, and how many let the structure come to rest."""

    tried: int = 0
    standing: int = 0


@dataclass(frozen=True, eq=False)
class Result(OfModel, Card):
    """Answer of an analysis, with the model that it belongs to.

    Attributes
    ----------
    method
        ``rbe``, ``rest``, ``cra``, ``cra-penalty``, or ``check`` for the whole cascade.
    verdict
    model
        What was asked about.
    message
        One sentence for a person, with the remedy where there is one.
    force : (k, 3) [N], local n, u, v, on block b; n >= 0 is compression
        They balance the loads, with ``tension`` in a penalty form. None where it falls.
    force_with_props : (k, 3) [N]
        Forces that balance the loads together with ``prop``, where it falls.
    tension : (k,) [N], where a penalty form found some
    displacement : (n, 6) [m, rad]
        Virtual motion of each block: centroid, rotation vector; world axes. Its size is that of the
        contact compliance that was assumed: only its shape has a meaning.
    mechanism : (n, 6)
        A collapse mechanism or first motion, scaled so that its largest translation of a corner is
        the size of a block.
    prop : (n, 6) [N, N m]
        Wrench that a prop would have to supply to each block.
    falling
        Positions of the blocks that fall; in the penalty form those that need help, neediest first.
    eta
        Largest displacement of a corner by the common overlap, where eq. 5.6 is met.
    stiffness_ratio
        The largest contact stiffness by the smallest one in the state that was found, where none
        of the stiffnesses tried leads to rest.
    settlement
        Where the blocks go (:class:`drystone.settlement.Settlement`), where that decided. Where no
        stiffness that was tried holds a structure that stands after settling, its forces balance
        the loads on the moved blocks. It is not written to files.
    stopped
        Why it ended before all was tried: ``the time was up`` or ``it was interrupted``; empty
        where nothing was left out.
    """

    method: str
    verdict: Verdict
    model: Model
    message: str = ""
    force: Floats | None = None
    force_with_props: Floats | None = None
    tension: Floats | None = None
    displacement: Floats | None = None
    mechanism: Floats | None = None
    prop: Floats | None = None
    falling: tuple[int, ...] = ()
    samples: Samples = field(default_factory=Samples)
    residuals: Residuals | None = None
    eta: float | None = None
    stiffness_ratio: float | None = None
    stopped: str = ""
    settlement: Any = None
    options: Any = None
    solver: str = ""
    iterations: int = 0
    time_s: Mapping[str, float] = field(default_factory=dict)

    def _summary(self) -> str:
        blocks, joints = len(self.assembly), self.contacts.count
        return (
            f"{self.verdict}, {counted(blocks, 'block')}, {counted(joints, 'interface')}, "
            f"'{self.message}'"
        )

    def _facts(self) -> tuple[str, Mapping[str, object]]:
        forces = self.force is not None and len(self.contacts) > 0 and not self.falls
        normal, used = self.resultants.normal, self.utilisation
        return f"{self.verdict}: {self.message}", {
            "model": self.model._summary(),
            "falls": ", ".join(self.falling_names),
            "largest normal force": f"{normal.max():.4g} N" if forces else "",
            "largest use of friction": f"{100.0 * used.max():.3g} %" if forces else "",
            "method": self.method,
            "time": f"{sum(self.time_s.values()):.2g} s" if self.time_s else "",
        }

    def __bool__(self) -> bool:
        raise TypeError("a result is neither true nor false; ask for .stable, .falls or .verdict")

    @property
    def stable(self) -> bool:
        """Whether it was shown to stand."""
        return self.verdict is Verdict.STABLE

    @property
    def falls(self) -> bool:
        """Whether it was shown to fall."""
        return self.verdict is Verdict.UNSTABLE

    @property
    def load(self) -> LoadCase:
        """The load of the model."""
        return self.model.load

    @property
    def falling_names(self) -> tuple[str, ...]:
        """Names of the blocks that fall."""
        return tuple(self.assembly.names[i] for i in self.falling)

    def world_force(self) -> Floats:
        """Corner forces (k, 3) [N] on block b in world axes; zero where there are none."""
        return world_forces(self.contacts, self._local_force)

    @property
    def _local_force(self) -> Floats:
        return np.zeros((self.contacts.corner_count, 3)) if self.force is None else self.force

    @cached_property
    def resultants(self) -> Resultants:
        """Force, centre of pressure and torque of every interface; zero without forces."""
        return resultants_of(self.contacts, self._local_force)

    @cached_property
    def utilisation(self) -> Floats:
        """Friction utilisation (m,): tangential over friction times normal resultant, 0 to 1."""
        return utilisation_of(self.contacts, self.resultants)

    def joints(self, *, strength: float | None = None) -> Table:
        """Forces, utilisation, eccentricity and pressure of every interface.

        Parameters
        ----------
        strength : [Pa], optional
            Interfaces whose peak pressure exceeds it are marked.

        Returns
        -------
        Table
            One row per interface.

        Columns
        -------
        joint, block_a, block_b
            Position of the interface, names of its blocks.
        area [m2]
        normal [N]
            Positive in compression.
        tangential [N]
        torque [N m]
            About the normal, on block b, at the centre of pressure.
        friction_use
            Tangential over friction times normal: 1 slides.
        eccentricity [m]
            Distance of the centre of pressure from the centroid of the joint.
        kern_ratio
            The same as a share of the distance to the rim of the kern: above 1 the joint opens.
        edge_ratio
            The same as a share of the distance to the rim of the joint: 1 is a hinge.
        mean_pressure, peak_pressure [Pa]
            The peak is that of a linear pressure that does not pull; infinite on the rim.
        over_strength
            Whether the peak exceeds the strength, where one was given.
        force_x, force_y, force_z [N]
            Resultant on block b, world axes.
        x, y, z [m]
            Centre of pressure; the centroid where nothing presses.

        Raises
        ------
        InputError
            There are no forces, or the strength is not above zero.

        Examples
        --------
        >>> import drystone
        >>> from drystone.models import tower
        >>> table = drystone.check(tower(2)).joints()
        >>> table["mean_pressure"].round(1).tolist(), table["peak_pressure"].round(1).tolist()
        ([23544.0], [23544.0])
        """
        if strength is None:
            return self._joint_table
        if not number(strength, "strength") > 0.0:
            raise InputError(f"strength is {strength}", remedy="give a pressure in Pa above zero")
        made = self._joint_table
        over = {"over_strength": made["peak_pressure"] > strength}
        return Table(made.title, {**made.columns, **over}, made.units)

    @cached_property
    def _joint_table(self) -> Table:
        self._require_forces()
        return joint_table(self.contacts, self.assembly.names, self.resultants, self.utilisation)

    def thrust_line(self, blocks: Blocks | None = None) -> ThrustLine:
        """The polyline through the centres of pressure of successive joints.

        Parameters
        ----------
        blocks
            Voussoirs in order, by name or position. Left out, the model must be one chain.

        Raises
        ------
        InputError
            There are no forces, successive blocks do not touch, or there is no single chain.
        """
        self._require_forces()
        return thrust_line(self.assembly, self.contacts, self.resultants, blocks)

    def _require_forces(self) -> None:
        if self.force is None:
            raise InputError(
                "the result has no forces", remedy="ask for those of a structure that stands"
            )


__all__ = ["Residuals", "Result", "Verdict"]
