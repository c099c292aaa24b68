"""Where a structure works hard: the forces of every joint held against what the joint can take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from drystone.assembly import Assembly
from drystone.contacts import Contacts
from drystone.errors import InputError
from drystone.geometry.arrays import Floats, Ints
from drystone.geometry.kern import edge_ratio, kern_ratio, peak_pressure
from drystone.results import Result
from drystone.virtual import joint_sections

LOADED = 1e-9
"""A joint with less normal force than this share of the largest carries nothing worth a ratio."""


@dataclass(frozen=True, eq=False)
class JointTable:
    """One row per interface, arrays of length m.

    Attributes
    ----------
    blocks : (m,) pairs of names, a and b
    area : [m2]
    normal : [N], positive in compression
    tangential : [N]
    torque : [N m] about the normal, on block b, at the centre of pressure
    position : (m, 3) [m]
        Centre of pressure; the centroid where nothing presses.
    friction_use
        Tangential over friction times normal: 1 slides.
    eccentricity : [m]
        Distance of the centre of pressure from the centroid of the joint.
    kern_ratio
        The same as a share of the way to the rim of the kern: above 1 the joint opens.
    edge_ratio
        The same as a share of the way to the rim of the joint: 1 is a hinge.
    mean_pressure, peak_pressure : [Pa]
        The peak is that of a linear pressure that does not pull; infinite on the rim.
    over_strength : bool
        The peak exceeds the strength, where one was given.
    strength : [Pa] or None
    """

    blocks: tuple[tuple[str, str], ...]
    area: Floats
    normal: Floats
    tangential: Floats
    torque: Floats
    position: Floats
    friction_use: Floats
    eccentricity: Floats
    kern_ratio: Floats
    edge_ratio: Floats
    mean_pressure: Floats
    peak_pressure: Floats
    over_strength: np.ndarray
    strength: float | None

    COLUMNS = (
        "area", "normal", "tangential", "torque", "friction_use", "eccentricity", "kern_ratio",
        "edge_ratio", "mean_pressure", "peak_pressure", "over_strength",
    )  # fmt: skip
    """Names of the plain columns."""

    def __len__(self) -> int:
        return len(self.blocks)

    def rows(self, joints: Sequence[int] | Ints | None = None) -> list[dict[str, Any]]:
        """Plain values of some joints, all when left out; lengths in m, forces in N."""
        chosen = range(len(self)) if joints is None else [int(i) for i in joints]
        return [
            {
                "joint": i,
                "block_a": self.blocks[i][0],
                "block_b": self.blocks[i][1],
                **{name: getattr(self, name)[i].item() for name in self.COLUMNS},
                "x": float(self.position[i, 0]),
                "y": float(self.position[i, 1]),
                "z": float(self.position[i, 2]),
            }
            for i in chosen
        ]

    def worst(self, count: int = 10) -> Ints:
        """Joints nearest to sliding or to turning about an edge, worst first."""
        use = np.maximum(self.friction_use, self.edge_ratio)
        return np.lexsort((-self.normal, -use))[:count]


def joint_table(result: Result, *, strength: float | None = None) -> JointTable:
    """Forces, utilisation, eccentricity and pressure of every joint.

    Parameters
    ----------
    result
        With forces.
    strength : [Pa], optional
        Joints whose peak pressure exceeds it are marked.

    Raises
    ------
    InputError
        The result has no forces, or the strength is not above zero.

    Examples
    --------
    >>> import drystone
    >>> from drystone.models import tower
    >>> assembly = tower(2)
    >>> contacts = drystone.find_contacts(assembly).contacts
    >>> table = joint_table(drystone.check(assembly, contacts))
    >>> table.mean_pressure.round(1).tolist(), table.peak_pressure.round(1).tolist()
    ([23544.0], [23544.0])
    """
    if result.force is None:
        raise InputError(
            "the result has no forces", remedy="ask for those of a structure that stands"
        )
    if strength is not None and not 0.0 < strength < float("inf"):
        raise InputError(f"strength is {strength}", remedy="give a pressure in Pa above zero")
    contacts = result.contacts
    names = result.assembly.names
    resultants = result.resultants()
    normal = resultants.normal
    loaded = normal > LOADED * max(float(np.abs(normal).max(initial=0.0)), 1e-300)
    origin, corners, made = joint_sections(contacts)
    at = np.einsum("mij,mj->mi", contacts.frame[:, 1:], resultants.position - origin)
    at = np.where(loaded[:, None], at, made.centroid)
    start = contacts.start
    within = np.where(loaded, kern_ratio(made, corners, start, at), 0.0)
    rim = np.where(loaded, edge_ratio(made, corners, start, at), 0.0)
    has_area = made.area > 0.0
    mean = np.where(has_area, normal / np.where(has_area, made.area, 1.0), np.inf)
    mean = np.where(loaded, mean, 0.0)
    # the largest rise of a linear pressure is the largest relief of a force on the other side
    opposite = 2.0 * made.centroid - at
    peak = mean * (1.0 + kern_ratio(made, corners, start, opposite))
    for i in np.flatnonzero(loaded & has_area & (within > 1.0)):
        peak[i] = peak_pressure(corners[start[i] : start[i + 1]], float(normal[i]), at[i])
    over = np.zeros(len(mean), dtype=bool) if strength is None else peak > strength
    return JointTable(
        blocks=tuple(
            (names[a], names[b])
            for a, b in zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True)
        ),
        area=contacts.area,
        normal=normal,
        tangential=resultants.tangential,
        torque=resultants.torque,
        position=origin + np.einsum("mi,mij->mj", at, contacts.frame[:, 1:]),
        friction_use=result.utilisation(),
        eccentricity=np.linalg.norm(at - made.centroid, axis=1),
        kern_ratio=within,
        edge_ratio=rim,
        mean_pressure=mean,
        peak_pressure=peak,
        over_strength=over,
        strength=strength,
    )


@dataclass(frozen=True, eq=False)
class ThrustLine:
    """Where the force passes from block to block along a row of voussoirs.

    Attributes
    ----------
    blocks : (s,) positions, in order
    point : (s - 1, 3) [m]
        Centre of pressure between each two successive blocks.
    force : (s - 1, 3) [N]
        What a block exerts on the next one, world axes.
    """

    blocks: tuple[int, ...]
    point: Floats
    force: Floats


def thrust_line(result: Result, blocks: Sequence[int | str] | None = None) -> ThrustLine:
    """The polyline through the centres of pressure of successive joints.

    Parameters
    ----------
    result
        With forces.
    blocks
        Voussoirs in order, by name or position. Left out, the model must be one chain.

    Raises
    ------
    InputError
        No forces, successive blocks that do not touch, or no single chain.
    """
    if result.force is None:
        raise InputError("the result has no forces", remedy="ask for those of one that stands")
    contacts, assembly = result.contacts, result.assembly
    order = chain(assembly, contacts) if blocks is None else assembly.indices(blocks).tolist()
    resultants = result.resultants()
    point, force = np.zeros((len(order) - 1, 3)), np.zeros((len(order) - 1, 3))
    for i, (a, b) in enumerate(pairwise(order)):
        onward = (contacts.block_a == a) & (contacts.block_b == b)
        back = (contacts.block_a == b) & (contacts.block_b == a)
        joints = np.flatnonzero(onward | back)
        if len(joints) == 0:
            raise InputError(
                f"blocks '{assembly.names[a]}' and '{assembly.names[b]}' do not touch",
                remedy="give the voussoirs in the order of the thrust",
            )
        weight = np.maximum(resultants.normal[joints], 0.0)
        weight = weight if weight.any() else np.ones(len(joints))
        point[i] = weight @ resultants.position[joints] / weight.sum()
        sign = np.where(onward[joints], 1.0, -1.0)
        force[i] = sign @ resultants.force[joints]
    return ThrustLine(tuple(order), point, force)


def chain(assembly: Assembly, contacts: Contacts) -> list[int]:
    """Blocks of a model in which each touches the next one only, end to end.

    Raises
    ------
    InputError
        The blocks branch, close to a ring, or fall into parts.
    """
    neighbours: list[set[int]] = [set() for _ in range(len(assembly))]
    for a, b in zip(contacts.block_a.tolist(), contacts.block_b.tolist(), strict=True):
        neighbours[a].add(b)
        neighbours[b].add(a)
    ends = [i for i, others in enumerate(neighbours) if len(others) == 1]
    order = ends[:1]
    while order and len(order) < len(assembly):
        onward = neighbours[order[-1]] - set(order[-2:])
        if len(onward) != 1:
            break
        order.append(onward.pop())
    if len(ends) != 2 or len(order) != len(assembly):
        raise InputError(
            "the blocks are not one row of voussoirs", remedy="name those of a row in order"
        )
    return order


__all__ = ["JointTable", "ThrustLine", "chain", "joint_table", "thrust_line"]
