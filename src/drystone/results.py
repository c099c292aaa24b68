"""What an analysis answers: verdict, forces, motion, and the residuals that prove it."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.geometry.arrays import Floats, Ints
from drystone.loads import LoadCase


class Verdict(enum.Enum):
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
class Residuals:
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
        return max(
            self.equilibrium,
            self.tension,
            self.cone,
            self.complementarity,
            self.alignment,
            self.overlap,
        )


@dataclass(frozen=True)
class Samples:
    """Contact stiffness distributions tried, and how many let the structure come to rest."""

    tried: int = 0
    standing: int = 0


@dataclass(frozen=True)
class Resultants:
    """One force per interface.

    Attributes
    ----------
    force : (m, 3) [N]
        On block b, world axes.
    position : (m, 3) [m]
        Centre of pressure; the interface's centroid where the normal force vanishes.
    torque : (m,) [N m]
        Moment about the normal, on block b, at the centre of pressure.
    normal : (m,) [N]
        Component along n, positive in compression.
    tangential : (m,) [N]
        Length of the component in the plane.
    """

    force: Floats
    position: Floats
    torque: Floats
    normal: Floats
    tangential: Floats


@dataclass(frozen=True, eq=False)
class Result:
    """Answer of an analysis, with the model that it belongs to.

    Attributes
    ----------
    method
        ``rbe``, ``rest``, ``cra``, ``cra-penalty``, or ``check`` for the whole cascade.
    verdict
    message
        One sentence for a person, with the remedy where there is one.
    force : (k, 3) [N], local n, u, v, on block b; n >= 0 is compression
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
    spread
        How many times as stiff as another a corner has to be, as far as the search could tell,
        where none of the stiffnesses tried leads to rest.
    stopped
        Why it ended before all was tried: ``the time was up`` or ``it was interrupted``; empty
        where nothing was left out.
    """

    method: str
    verdict: Verdict
    assembly: Assembly
    contacts: Contacts
    load: LoadCase
    message: str = ""
    force: Floats | None = None
    tension: Floats | None = None
    displacement: Floats | None = None
    mechanism: Floats | None = None
    prop: Floats | None = None
    falling: tuple[int, ...] = ()
    samples: Samples = field(default_factory=Samples)
    residuals: Residuals | None = None
    eta: float | None = None
    spread: float | None = None
    stopped: str = ""
    options: Any = None
    solver: str = ""
    iterations: int = 0
    time_s: Mapping[str, float] = field(default_factory=dict)

    def __bool__(self) -> bool:
        raise TypeError("a result is neither true nor false; ask for its .verdict")

    @property
    def falling_names(self) -> tuple[str, ...]:
        """Names of the blocks that fall."""
        return tuple(self.assembly.names[i] for i in self.falling)

    def world_force(self) -> Floats:
        """Corner forces (k, 3) [N] on block b in world axes; zero where there are none."""
        contacts = self.contacts
        if self.force is None:
            return np.zeros((contacts.corner_count, 3))
        frame = contacts.frame[contacts.interface]
        return np.einsum("ki,kij->kj", self.force, frame)

    def resultants(self) -> Resultants:
        """Force, centre of pressure and torque of every interface."""
        contacts = self.contacts
        m = contacts.count
        corner = self.world_force()
        local = self.force if self.force is not None else np.zeros((contacts.corner_count, 3))

        def total(values: Floats) -> Floats:
            return _per_interface(values, contacts.interface, m)

        force = total(corner)
        normal = total(local[:, 0])
        lever = contacts.point - contacts.centroid[contacts.interface]
        shift = total(local[:, :1] * lever)
        pressing = normal > 1e-12 * max(float(np.abs(normal).max(initial=0.0)), 1e-300)
        position = contacts.centroid + np.where(
            pressing[:, None], shift / np.where(pressing, normal, 1.0)[:, None], 0.0
        )
        arm = contacts.point - position[contacts.interface]
        moment = total(np.cross(arm, corner))
        torque = np.einsum("mi,mi->m", moment, contacts.frame[:, 0])
        tangential = np.linalg.norm(force - normal[:, None] * contacts.frame[:, 0], axis=1)
        return Resultants(force, position, torque, normal, tangential)

    def utilisation(self) -> Floats:
        """Friction utilisation (m,): tangential over friction times normal resultant, 0 to 1."""
        resultants = self.resultants()
        capacity = self.contacts.friction * resultants.normal
        scale = max(float(resultants.normal.max(initial=0.0)), 1e-300)
        loaded = resultants.normal > 1e-9 * scale
        share: Floats = np.where(
            loaded & (capacity > 0.0),
            resultants.tangential / np.where(capacity > 0.0, capacity, 1.0),
            np.where(loaded & (resultants.tangential > 1e-9 * scale), np.inf, 0.0),
        )
        return share


def _per_interface(values: Floats, interface: Ints, count: int) -> Floats:
    out: Floats = np.zeros((count, *values.shape[1:]))
    np.add.at(out, interface, values)
    return out
