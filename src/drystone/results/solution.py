"""What an analysis found: the verdict, forces, and motion of a model.

Reactions: what supports give to the blocks on them.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from drystone.answer import Verdict
from drystone.answer.scene import Layer, LayerKind
from drystone.base.arrays import SAME, Floats, dot, lengths
from drystone.base.display import OneLine
from drystone.base.ragged import sum_by_owner
from drystone.base.settings import MayStop
from drystone.base.table import Table
from drystone.checks import Residuals, normal_force_by_strength
from drystone.contacts import Contacts
from drystone.friction_use import utilisation_of
from drystone.joints import Resultants, linear_strength_use, resultants_of, world_forces
from drystone.loads import LoadCase
from drystone.model import Model, OfModel

if TYPE_CHECKING:
    import networkx


class Sensitivity(enum.StrEnum):
    """What a verdict depends on beside shapes, loads and friction."""

    JOINTS = "the stiffness between joints"
    """Which of them press more."""
    PRESSURE = "the pressure within joints"
    """It needs forces at their corners: spread over the faces they do not hold it."""
    SHEAR = "the shear stiffness of the joints"
    """How stiff they are along their faces, by their stiffness across."""
    ENDS = "the ends of the faces"
    """Which block carries them, where both faces end flush."""
    WEIGHTS = "light blocks beside heavy ones"
    """How stiff the joints of light ones are: beside what heavy ones move, uniform stiffness shows
    neither that it holds them nor that it does not."""


MARGINS = 150
"""Blocks up to which a check tells margins by itself. Measured: 0.23 s of CPU time for the tilt of
a vault of 97 blocks and 0.16 s for its friction; 2.2 s for the tilt of one of 399."""


@dataclass(frozen=True)
class Samples:
    """Contact stiffness distributions tried, and how many let the structure come to rest."""

    tried: int = 0
    standing: int = 0


@dataclass(frozen=True, eq=False)
class Solution(MayStop, OfModel, OneLine):
    """What was found about a model; :class:`Result` puts it in words.

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
        Wrench that a prop would have to supply to each block; with all of them it stands at the
        margin only, with less it falls.
    falling
        Positions of the blocks that fall; in the penalty form those that need help, neediest first.
    sensitive_to
        What the verdict depends on; of what stands, only as far as it was asked.
    eta
        Largest displacement (its length) of a corner by the common overlap, where eq. 5.6 is met.
    settlement
        Where the blocks go (:class:`drystone.settlement.Settlement`), where that decided. Where no
        stiffness that was tried holds a structure that stands after settling, its forces balance
        the loads on the moved blocks. It is not written to files.
    tilt_margin, tilt_about : [degrees]
        Up to which forces balance the loads, however it is tilted about x and y, where that was
        asked, and the name of the axis of the least tilt. Necessary for standing, as a limit of
        tilt that is checked by rest may be less.
    friction_margin
        Share of the friction of all joints with which forces balance the loads, where that was
        asked. Necessary for standing too.
    crushing_factor
        Factor on all loads up to which forces within the strength of the joints balance them, where
        joints crush and that was asked.
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
    sensitive_to: tuple[Sensitivity, ...] = ()
    residuals: Residuals | None = None
    eta: float | None = None
    tilt_margin: float | None = None
    tilt_about: str = ""
    friction_margin: float | None = None
    crushing_factor: float | None = None
    settlement: Any = None
    options: Any = None
    solver: str = ""
    iterations: int = 0

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

    def graph(self) -> networkx.MultiDiGraph:
        """The graph of the model (:meth:`drystone.Model.graph`) with forces in its edges.

        Returns
        -------
        networkx.MultiDiGraph
            Its edges also have ``force`` (c, 3) [N] at the corners, local n, u, v, on block b, and
            the world ``resultant`` (3,) [N] with its ``centre`` (3,) [m]; zero without forces. With
            tension they have ``tension`` (c,) [N].
        """
        graph = self.model.graph()
        found, contacts = self.resultants, self.contacts
        for _, _, edge in graph.edges(data=True):
            i = edge["interface"]
            rows = slice(contacts.start[i], contacts.start[i + 1])
            edge["force"] = self._local_force[rows]
            edge["resultant"], edge["centre"] = found.force[i], found.position[i]
            if self.tension is not None:
                edge["tension"] = self.tension[rows]
        return graph

    @property
    def _local_force(self) -> Floats:
        return np.zeros((self.contacts.corner_count, 3)) if self.force is None else self.force

    @cached_property
    def resultants(self) -> Resultants:
        """Force, centre of pressure and torque of every interface; zero without forces."""
        return resultants_of(self.contacts, self._local_force)

    @cached_property
    def utilisation(self) -> Floats:
        """Share (m,) of the force and torque that each interface can bear along its face.

        Above 1 it needs forces at its corners.
        """
        return utilisation_of(self.contacts, self.resultants)

    @cached_property
    def strength_use(self) -> Floats:
        """Normal force (m,) by what a stress block around the centre of pressure carries.

        1 crushes; 0 for joints without a finite strength. Where brittle mortar pulls, or no block
        carries it, it is the largest linear pressure by the strength. Of a tie its pull counts.
        """
        contacts, force = self.contacts, self._local_force
        use = normal_force_by_strength(contacts, np.maximum(force[:, 0], 0.0))[0]
        pulls = contacts.corners.any(force[:, 0] < 0.0) | (use > 1.0 + 1e-6)
        use = np.where(contacts.brittle & pulls, linear_strength_use(contacts, force), use)
        most = contacts.tie_strength
        return np.divide(self.resultants.normal, most, out=use, where=contacts.ties & (most > 0.0))


def reaction_table(result: Solution) -> Table:
    """The table of :meth:`drystone.Result.reactions`."""
    contacts, fixed = result.contacts, result.assembly.fixed
    toward = _toward_free(contacts, result)
    corner = np.flatnonzero(toward[contacts.interface])
    interface = contacts.interface[corner]
    side = np.where(fixed[contacts.block_a], contacts.block_a, contacts.block_b)
    support, owner = np.unique(side[interface], return_inverse=True)
    count, place = len(support), contacts.point[corner]
    force = toward[interface, None] * result.world_force()[corner]
    normal = np.maximum(dot(force, toward[interface, None] * contacts.frame[interface, 0]), 0.0)
    weight = np.where((np.bincount(owner, normal, count) > 0.0)[owner], normal, 1.0)
    point = sum_by_owner(weight[:, None] * place, owner, count)
    point /= np.bincount(owner, weight, count)[:, None]
    total = sum_by_owner(force, owner, count)
    moment = sum_by_owner(np.cross(place - point[owner], force), owner, count)
    rounding = SAME * float(result.assembly.size.max())
    point = np.where(np.abs(point) > rounding, point, 0.0)
    moment = np.where((lengths(moment) > rounding * lengths(total))[:, None], moment, 0.0)
    columns = {
        "support": [result.assembly.names[i] for i in support],
        "point": point,
        "force": total,
        "moment": moment,
    }
    return Table("reactions", columns, {"point": "m", "force": "N", "moment": "N m"})


def reaction_layer(result: Solution, resultants: Resultants) -> tuple[Layer, ...]:
    """An arrow at each joint of a support with a free block, which ends at its centre of pressure.

    Parameters
    ----------
    result
    resultants
        Of the joints.
    """
    contacts = result.contacts
    first = np.unique(contacts.joint, return_index=True)[1]
    toward = _toward_free(contacts.joints, result)
    held = np.flatnonzero((toward != 0.0) & resultants.force.any(axis=1))
    if len(held) == 0:
        return ()
    return (
        Layer(
            "reactions", "reactions at joints of supports", LayerKind.ARROWS, "reaction",
            resultants.position[held], toward[held, None] * resultants.force[held],
            interface=first[held], single=True, width=2.4, group="reactions",
        ),
    )  # fmt: skip


def _toward_free(contacts: Contacts, result: Solution) -> Floats:
    """Signs (m,) by which forces on block b become forces on the free block; else zero."""
    fixed = result.assembly.fixed.astype(np.float64)
    return fixed[contacts.block_a] - fixed[contacts.block_b]
