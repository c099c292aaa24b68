"""Checks that a reader does again by hand: weights, sums of forces and moments, thrust."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.base.display import OneLine
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.checks import normal_force_by_strength
from drystone.joint_capacity import JointCapacity
from drystone.loads.applied import common_acceleration
from drystone.model import Model
from drystone.results import Result


def weights(model: Model) -> Table:
    """Volume, mass and weight of free blocks and supports, a row for each density."""
    assembly = model.assembly
    density = np.array([block.density for block in assembly.blocks]).round(6)
    g = float(np.linalg.norm(common_acceleration(assembly, model.load)))
    rows = []
    for fixed in (False, True):
        for one in np.unique(density[assembly.fixed == fixed]).tolist():
            mine = (density == one) & (assembly.fixed == fixed)
            volume = float(assembly.volume[mine].sum())
            what = "supports" if fixed else "free blocks"
            rows.append((what, int(mine.sum()), one, volume, one * volume, one * volume * g))
    names = ("of", "blocks", "density", "volume", "mass", "weight")
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    units = {"density": "kg/m3", "volume": "m3", "mass": "kg", "weight": "N"}
    return Table("weights", columns, units)


def balance(result: Result) -> Table:
    """Sums of forces, and of moments about the origin, of all free blocks together.

    What acts on each block is the wrench about its centroid; what the supports give is the table of
    reactions.
    """
    assembly, load = result.assembly, result.load
    free = ~assembly.fixed
    own = assembly.mass[:, None] * common_acceleration(assembly, load)
    others = load.wrench[:, :3] - own
    reactions = result.reactions()
    forces = [own[free], others[free], reactions["force"]]
    places = [assembly.centroid[free], assembly.centroid[free], reactions["point"]]
    couples = [np.zeros((1, 3)), load.wrench[free, 3:], reactions["moment"]]
    force = np.array([one.sum(axis=0) for one in forces])
    moment = np.array([
        np.cross(at, one).sum(axis=0) + couple.sum(axis=0)
        for at, one, couple in zip(places, forces, couples, strict=True)
    ])  # fmt: skip
    rounding = 1e-9 * float(np.abs(force).max()) * float(np.ptp(assembly.bounds))
    moment[np.abs(moment) < rounding] = 0.0
    columns = {
        "sum_of": ["acceleration of the masses", "other loads", "reactions", "all (zero)"],
        "force": np.vstack([force, force.sum(axis=0)]),
        "moment": np.vstack([moment, moment.sum(axis=0)]),
    }
    return Table("equilibrium of all free blocks", columns, {"force": "N", "moment": "N m"})


def least_strength(result: Result) -> tuple[float, int]:
    """Largest stress [Pa] of stress blocks about centres of pressure, and its interface.

    Zero where nothing presses; edges and points have no stress and are left out.
    """
    contacts, force = result.contacts, result.force
    if force is None or not contacts.count:
        return 0.0, 0
    unit = replace(contacts, capacity=JointCapacity.of_stress(contacts, compression=1.0))
    stress, _ = normal_force_by_strength(unit, np.maximum(force[:, 0], 0.0))
    stress = np.where(contacts.area > 0.0, stress, 0.0)
    at = int(np.argmax(stress))
    return float(stress[at]), at


@dataclass(frozen=True)
class CrownThrust(OneLine):
    """Thrust at the crown by moments of one half about its springing, and from the joints.

    Attributes
    ----------
    load : [N]
        What acts on the half along gravity.
    arm : [m]
        Of that load about the springing, horizontally.
    moment : [N m]
        Of everything else that acts on the half about the springing, the shear at the crown with
        it.
    rise : [m]
        From the reaction at the springing to the centre of pressure at the crown.
    by_hand, by_joints : [N]
    """

    load: float
    arm: float
    moment: float
    rise: float
    by_hand: float
    by_joints: float

    def table(self) -> Table:
        """The calculation, a row for each quantity."""
        told = [
            ("load on one half, V", self.load, "N"),
            ("its arm about the springing, a", self.arm, "m"),
            ("moment of other forces about the springing, M", self.moment, "N m"),
            ("rise of the thrust, f", self.rise, "m"),
            ("thrust by hand, H = (V a + M) / f", self.by_hand, "N"),
            ("thrust from the forces in the joints", self.by_joints, "N"),
        ]
        least = 1e-9 * self.load * max(self.rise, 1.0)
        columns = {
            "quantity": [name for name, _, _ in told],
            "value": [quantity(value, unit, least, 4) for _, value, unit in told],
        }
        return Table("thrust at the crown", columns)


def crown_thrust(result: Result) -> CrownThrust | None:
    """The thrust at the crown of an arch or a vault on two sides; ``None`` where there is none.

    The crown is the joint with the largest normal force of those that are steeper than 45 degrees,
    in the uppermost tenth of the structure. A vertical plane through it parts the structure. All
    joints across it carry the thrust.
    """
    joints, assembly, contacts = result.contacts.joints, result.assembly, result.contacts
    normal = result.joints()["normal"]
    free = ~(assembly.fixed[joints.block_a] | assembly.fixed[joints.block_b])
    height = float(np.ptp(assembly.bounds[..., 2]))
    high = joints.centroid[:, 2] > assembly.bounds[:, 1, 2].max() - 0.1 * height
    steep = np.abs(joints.frame[:, 0, 2]) < np.sqrt(0.5)
    carries = steep & high & free & (normal > 1e-3 * normal.max(initial=0.0))
    if not carries.any():
        return None
    top = int(np.flatnonzero(carries)[np.argmax(normal[carries])])
    way = joints.frame[top, 0] * np.array([1.0, 1.0, 0.0])
    way /= np.linalg.norm(way)
    beyond = (assembly.centroid - joints.centroid[top]) @ way > 0.0
    half = ~assembly.fixed & ~beyond
    # forces of corners on the half: of the blocks beyond, and of the supports
    a, b = (one[contacts.interface] for one in (contacts.block_a, contacts.block_b))
    onto = half[b].astype(float) - half[a]
    other = np.where(half[b], a, b)
    given = onto[:, None] * result.world_force()
    cut, foot = ((onto != 0.0) & one for one in (~assembly.fixed[other], assembly.fixed[other]))
    if not (cut.any() and foot.any()):
        return None
    crown, springing = (_middle(contacts.point[one], given[one]) for one in (cut, foot))
    rise = float(crown[2] - springing[2])
    wrench, arms = result.load.wrench[half], assembly.centroid[half] - springing
    load, by_joints = float(-wrench[:, 2].sum()), float(-(given[cut] @ way).sum())
    if rise <= 0.05 * height or load <= 0.0 or by_joints <= 0.0:
        return None
    arm = float(-wrench[:, 2] @ (arms @ way)) / load
    every = np.cross(arms, wrench[:, :3]).sum(axis=0) + wrench[:, 3:].sum(axis=0)
    every = every + np.cross(contacts.point - springing, given)[cut | foot].sum(axis=0)
    total = float(every @ np.cross(way, [0.0, 0.0, 1.0]))
    moment = by_joints * rise - load * arm - total
    return CrownThrust(load, arm, moment, rise, (load * arm + moment) / rise, by_joints)


def _middle(points: Floats, forces: Floats) -> Floats:
    """Mean of points (p, 3) by the size of their forces."""
    weight = np.maximum(lengths(forces), 1e-300)
    middle: Floats = weight @ points / weight.sum()
    return middle
