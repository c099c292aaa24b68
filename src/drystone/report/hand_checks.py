"""Checks that a reader does again by hand: weights, sums of forces and moments, thrust."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drystone.answer.question import UP
from drystone.base.arrays import ROUNDING, Bools, Floats, Ints, dot
from drystone.base.display import OneLine
from drystone.base.errors import counted
from drystone.base.ragged import linked
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.checks import mechanism_defects, normal_force_by_strength
from drystone.contacts import Contacts
from drystone.geometry.frames import area_vector, unit
from drystone.geometry.kern import level_hull
from drystone.joint_capacity import JointCapacity
from drystone.joints import plane_pressure
from drystone.loads.applied import AppliedLoads, common_acceleration, loads_apart
from drystone.model import Model
from drystone.results import Result
from drystone.stability.problem import FALLING_SHARE, MECHANISM_TOLERANCE, moving_blocks
from drystone.supports import own_blocks


def weights(model: Model) -> Table:
    """Volume, mass and weight of free blocks and supports, a row for each density, and of fill.

    The ground that supports lay has none. What blocks carry has a row for each kind.
    """
    assembly = model.assembly
    own = own_blocks(assembly)
    density = np.array([block.density for block in assembly.blocks]).round(6)
    g = float(np.linalg.norm(common_acceleration(assembly, model.load) - model.load.shake))
    rows = []
    for fixed in (False, True):
        for one in np.unique(density[own & (assembly.fixed == fixed)]).tolist():
            mine = (density == one) & (assembly.fixed == fixed) & own
            volume = float(assembly.volume[mine].sum())
            what = "supports" if fixed else "free blocks"
            rows.append((what, int(mine.sum()), one, volume, one * volume / 1e3, one * volume * g))
    for one in model.load.masses:
        on = (one.mass > 0.0) & ~assembly.fixed
        mass = float(one.mass[on].sum())
        kind = {"mass": "masses in kg", "load": "loads that are shaken"}.get(one.kind, one.kind)
        rows.append((kind, int(on.sum()), np.nan, np.nan, mass / 1e3, mass * g))
    names = ("of", "blocks", "density", "volume", "mass", "weight")
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    units = {"density": "kg/m3", "volume": "m3", "mass": "t", "weight": "N"}
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
    title = "equilibrium of all free blocks, moments about the origin"
    return Table(title, columns, {"force": "N", "moment": "N m"})


def as_one_block(result: Result) -> Table | None:
    """Sliding and overturning of all free blocks as one, about edges of their level foot.

    It overturns about the edge with the least ratio of moments, of those over which horizontal
    loads turn it. Another edge may be nearest to the resultant, by the width of the foot square to
    it. Each load acts where the tables of a report have it.
    ``None`` where the foot is not level, an edge or in parts that do not meet, or nothing pushes
    sideways.
    """
    assembly, contacts = result.assembly, result.contacts
    foot = assembly.fixed[contacts.block_a] != assembly.fixed[contacts.block_b]
    at = contacts.point[foot[contacts.interface]]
    load, free = result.load.wrench, ~assembly.fixed
    total = load[free, :3].sum(axis=0)
    push, down = float(np.hypot(*total[:2])), -float(total[2])
    level = np.abs(contacts.frame[foot, 0, 2]) > 1.0 - 1e-9
    flat = contacts.area[foot].any() and np.ptp(at[:, 2]) < 1e-6 * np.ptp(assembly.bounds)
    if not (flat and level.all()) or down <= 0.0 or push < 1e-6 * down or not _meet(contacts, foot):
        return None
    edges = _moments_about(result, level_hull(at))
    nearest = min(edges)
    turned = [one for one in edges if one[2] > ROUNDING * down * one[3]]
    edge = min(turned, default=nearest, key=lambda one: one[1] / one[2])
    _, holds, turns, _ = edge
    near = "from that edge to the resultant, (Mv - Mh) / V"
    if edge[0] > nearest[0] + ROUNDING:
        near = "from the edge that is nearest to the resultant, to it"
    friction = float(contacts.friction[foot].min())
    told = [
        ("vertical load, V", quantity(down, "N")),
        ("horizontal load, H", quantity(push, "N")),
        ("least friction of the foot, f", f"{friction:.4g}"),
        ("sliding, f V / H", f"{friction * down / push:.4g}"),
        ("moment of vertical loads about the edge it turns over, Mv", quantity(holds, "N m")),
        ("moment of horizontal loads and couples, Mh", quantity(turns, "N m")),
        ("overturning, Mv / Mh", f"{holds / turns:.4g}" if turned else "-"),
        (near, quantity((nearest[1] - nearest[2]) / down, "m")),
        ("a third of the foot: the kern ends there", quantity(nearest[3] / 3.0, "m")),
    ]
    columns = {"quantity": [one for one, _ in told], "value": [one for _, one in told]}
    return Table("all free blocks as one on their foot", columns)


def _moments_about(result: Result, hull: Floats) -> list[tuple[float, float, float, float]]:
    """For edges of a level hull (h, 3): what of the width is left, Mv, Mh, and the width."""
    edges, free = [], ~result.assembly.fixed
    loads = loads_apart(result.assembly, result.load.beside_masses)
    for toe, end in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        out = unit(np.cross(end - toe, UP))
        turn = np.cross(out, UP)
        points, vertical, others = _parts_of_load(result, loads, free, toe, turn)
        holds, over = float(-vertical @ ((points - toe) @ out)), sum(others.values())
        wide = float(np.ptp(hull @ out))
        edges.append(((holds - over) / wide, holds, over, wide))
    return edges


def _meet(contacts: Contacts, foot: Bools) -> bool:
    """Whether some level interfaces (m,) are one patch: boxes around them meet in turn."""
    each = contacts.corners
    low, high = (
        np.stack([one(at)[foot] for at in contacts.point[:, :2].T], axis=1)
        for one in (each.min, each.max)
    )
    beyond = low[:, None] > high + 1e-6 * float((high - low).max())
    apart = beyond.any(axis=2)
    one, other = np.nonzero(~(apart | apart.T))
    return bool(linked(one, other, len(low)).max(initial=-1) == 0)


def least_strength(result: Result) -> tuple[float, int]:
    """Largest stress [Pa] of stress blocks about centres of pressure, and its interface.

    Of joints that pull, that of a linear pressure. Zero where nothing presses; edges, points
    and ties have no stress and are left out, and joints with less than a thousandth of the largest
    force.
    """
    contacts, force = result.contacts, result.force
    if force is None or not contacts.count:
        return 0.0, 0
    unit = replace(contacts, capacity=JointCapacity.of_stress(contacts, compression=1.0))
    stress, _ = normal_force_by_strength(unit, np.maximum(force[:, 0], 0.0))
    if contacts.capacity is not None:
        pulls = (contacts.capacity.tension > 0.0) & contacts.corners.any(force[:, 0] < 0.0)
        linear = contacts.corners.max(plane_pressure(contacts, force))
        stress = np.where(pulls, linear, stress)
    normal = contacts.corners.sum(force[:, 0])
    told = (contacts.area > 0.0) & ~contacts.ties & (normal > 1e-3 * normal.max())
    stress = np.where(told, stress, 0.0)
    at = int(np.argmax(stress))
    return float(stress[at]), at


def mechanism_table(result: Result) -> Table | None:
    """How what falls begins to move, and the work of the loads, a row for each block.

    ``None`` where no motion is known. The fastest corner moves by the size of a block. Works have
    the digits in which their sum shows what joints do not take up.
    """
    motion, assembly = result.mechanism, result.assembly
    if motion is None:
        return None
    moving = list(moving_blocks(assembly, motion))
    seen = np.where(np.abs(motion) > FALLING_SHARE * np.abs(motion).max(), motion, 0.0)[moving]
    works = (result.load.wrench * motion)[moving].sum(axis=1)
    done = float(works.sum())
    proof = _proof(result, done)
    rest = done if proof is None else done - proof[2]
    columns = {
        "block": [assembly.names[i] for i in moving],
        "moves": seen[:, :3],
        "turns": np.degrees(seen[:, 3:]),
        "work_of_loads": _in_digits(works.tolist(), rest),
    }
    title = "motion of what falls, of centroids and about them; its size has no meaning"
    return Table(title, columns, {"moves": "m", "turns": "deg", "work_of_loads": "N m"})


def _in_digits(works: Sequence[float], rest: float) -> list[str]:
    """Works [N m] to three digits of the largest, and a tenth of what is left of their sum."""
    largest = max(map(abs, works), default=0.0) or 1.0
    least = min(1e-2 * largest, max(0.1 * rest / len(works), 1e-12 * largest))
    places = max(-math.floor(math.log10(least)), 0)
    return [f"{one + 0.0:.{places}f}" for one in works]


def _proof(result: Result, done: float) -> tuple[str, float, float] | None:
    """The joints that do not balance the work done [N m], their closing, and what they take up."""
    motion, model = result.mechanism, result.model
    if motion is None:
        return None
    parts = float(np.abs(model.load.wrench * motion)[~result.assembly.fixed].sum())
    without = {"joints without mortar": model.with_capacity(None)} if model.contacts.brittle else {}
    for joints, one in {"all joints": model, **without}.items():
        closing, work = mechanism_defects(one, motion)
        if closing <= MECHANISM_TOLERANCE and work > 0.0:
            return joints, closing, max(done - work * parts, 0.0) / (1.0 + work)
    return None


def fall_words(result: Result) -> str:
    """What proves that it falls: a mechanism with its work, or the steps by which it moved."""
    motion = result.mechanism
    if motion is None:
        return result.message
    moving = list(moving_blocks(result.assembly, motion))
    works = (result.load.wrench * motion)[moving].sum(axis=1)
    done, gross = float(works.sum()), float(np.abs(works).sum())
    count, proof = counted(len(moving), "block"), _proof(result, done)
    if proof is None:
        told = quantity(done, "N m")
        words = f"{result.message}; {count} move as listed"
        return f"{words}, and the loads do work of {told} on the way"
    joints, closing, taken = proof
    taken = taken if taken > 1e-9 * gross else 0.0
    first, second = _in_digits([done, taken], done - taken)
    return (
        f"{result.message}; mechanism of {count}: the loads do work of {first} N m, "
        f"{joints} take up at most {second} N m; the "
        f"rest is {100.0 * (done - taken) / gross:.3g} % of the sum of the absolute works "
        "of blocks, whose rounding is below 1e-9 of it; "
        f"largest closing of a joint {closing:.1e} of the speed"
    )


@dataclass(frozen=True)
class CrownThrust(OneLine):
    """Thrust at the crown by moments of one half of an arch about its springing, and from joints.

    Attributes
    ----------
    load : [N]
        Vertical, on the part of the arch from its springing to the crown, and what that bears.
    arm : [m]
        Of that load about the springing, horizontally; fill and masses act where they lie.
    moments : [N m]
        Of what else acts on that part about the springing, by what it is.
    rise : [m]
        From the reaction at the springing to the centre of pressure at the crown.
    by_hand, by_joints : [N]
    joint
        The blocks beside the crown.
    """

    load: float
    arm: float
    moments: Mapping[str, float]
    rise: float
    by_hand: float
    by_joints: float
    joint: str

    def table(self) -> Table:
        """The calculation, a row for each quantity."""
        least = 1e-9 * self.load * max(self.rise, 1.0)
        seen = {what: x for what, x in self.moments.items() if abs(x) > 1e3 * least}
        told = [
            ("vertical load between the springing and this joint, V", self.load, "N"),
            ("its arm about the springing, a", self.arm, "m"),
            *((f"moment of {what}", x, "N m") for what, x in seen.items()),
            ("sum of these moments, M", sum(seen.values()), "N m"),
            ("rise of the thrust, f", self.rise, "m"),
            ("thrust by hand, H = (V a + M) / f", self.by_hand, "N"),
            ("thrust from the forces in the joints", self.by_joints, "N"),
        ]
        columns = {
            "quantity": [name for name, _, _ in told],
            "value": [quantity(value, unit, least, 4) for _, value, unit in told],
        }
        return Table(f"thrust at the crown, {self.joint}", columns)


def crown_thrusts(result: Result) -> list[CrownThrust]:
    """The thrust at the crown of each arch.

    An arch is made of free blocks over an opening that hang together: nothing bears a part of what
    looks down of them. Its crown is the highest of the joints between them that press most, of
    those steeper than 45 degrees in its uppermost tenth. Its springings are the joints to what lies
    below them. A vertical plane through the crown parts the arch and all that it bears over the
    opening; all joints across it carry the thrust.
    """
    joints, assembly = result.contacts.joints, result.assembly
    normal = result.joints()["normal"]
    over = _over_openings(result)
    both = over[joints.block_a] & over[joints.block_b] & ~joints.ties
    arch = _joined(result, both)
    steep = np.abs(joints.frame[:, 0, 2]) < np.sqrt(0.5)
    carries = steep & both & (normal > 1e-3 * normal.max(initial=0.0))
    found = []
    for one in np.unique(arch[joints.block_a[carries]]):
        mine, level = both & (arch[joints.block_a] == one), joints.centroid[:, 2]
        tall = float(np.ptp(assembly.bounds[arch == one, :, 2]))
        mine = carries & mine & (level > level[mine].max() - 0.1 * tall)
        mine &= normal >= 0.5 * normal[mine].max(initial=0.0)
        if not mine.any():
            continue
        crown = mine & (level > level[mine].max() - 1e-6 * tall)
        top = int(np.argmax(np.where(crown, normal, -1.0)))
        thrust = _thrust_at(result, top, over & (arch == one))
        found += [] if thrust is None else [thrust]
    return found


def _over_openings(result: Result) -> Bools:
    """Which free blocks (n,) have a part that looks down and touches nothing."""
    assembly, contacts = result.assembly, result.contacts
    down = np.array([
        np.maximum([-area_vector(block.vertices[list(loop)])[2] for loop in block.faces], 0.0).sum()
        for block in assembly.blocks
    ])  # fmt: skip
    covered = np.zeros(len(assembly))
    level = np.where(contacts.ties, 0.0, contacts.area * contacts.frame[:, 0, 2])
    np.add.at(covered, contacts.block_b, np.maximum(level, 0.0))
    np.add.at(covered, contacts.block_a, np.maximum(-level, 0.0))
    return ~assembly.fixed & (down - covered > 1e-3 * down)


def _joined(result: Result, through: Bools) -> Ints:
    """The part (n,) of each block, of those that hang together through some joints (j,)."""
    joints = result.contacts.joints
    return linked(joints.block_a[through], joints.block_b[through], len(result.assembly))


def _below(result: Result, arch: Bools) -> Bools:
    """The supports, and the blocks (n,) on which an arch rests, directly or not."""
    joints = result.contacts.joints
    rises = joints.frame[:, 0, 2]
    upper = np.where(rises > 0.0, joints.block_b, joints.block_a)
    lower = np.where(rises > 0.0, joints.block_a, joints.block_b)
    rests = (np.abs(rises) > 1e-3) & ~joints.ties
    bears = result.assembly.fixed.copy()
    while (more := rests & (arch | bears)[upper] & ~(arch | bears)[lower]).any():
        bears |= np.bincount(lower[more], minlength=len(bears)) > 0
    return bears


def _thrust_at(result: Result, top: int, arch: Bools) -> CrownThrust | None:
    """That of an arch (n,) at a joint; ``None`` where it is none there."""
    joints, assembly, contacts = result.contacts.joints, result.assembly, result.contacts
    way = joints.frame[top, 0] * np.array([1.0, 1.0, 0.0])
    way /= np.linalg.norm(way)
    low = min(float((assembly.blocks[i].vertices @ way).min()) for i in np.flatnonzero(arch))
    bears = _below(result, arch)
    hangs = _joined(result, ~(bears[joints.block_a] | bears[joints.block_b]))
    mine = ~bears & (hangs == hangs[joints.block_a[top]])
    at, crown_at = assembly.centroid @ way, float(joints.centroid[top] @ way)
    half, rest = mine & (at >= low) & (at <= crown_at), mine & (at > crown_at)
    # forces of corners on the half: of the blocks beyond, and of what it stands on
    a, b = (one[contacts.interface] for one in (contacts.block_a, contacts.block_b))
    onto = half[b].astype(float) - half[a]
    other = np.where(half[b], a, b)
    forces = result.world_force()
    given, normal = onto[:, None] * forces, dot(forces, contacts.frame[contacts.interface, 0])
    cut, foot = ((onto != 0.0) & one[other] for one in (rest, bears))
    if not (cut.any() and foot.any() and ((rest[a] & bears[b]) | (rest[b] & bears[a])).any()):
        return None
    crown, springing = (_middle(contacts.point[one], normal[one]) for one in (cut, foot))
    rise = float(crown[2] - springing[2])
    turn = np.cross(way, [0.0, 0.0, 1.0])
    loads = loads_apart(assembly, result.load.beside_masses)
    points, vertical, moments = _parts_of_load(result, loads, half, springing, turn)
    load, by_joints = float(vertical.sum()), float(-(given[cut] @ way).sum())
    if rise <= 0.05 * np.ptp(assembly.bounds[arch, :, 2]) or load <= 0.0 or by_joints <= 0.0:
        return None
    arm = float(vertical @ ((points - springing) @ way)) / load
    if arm <= 0.0:  # an arch leans on its springing from the side of the crown
        return None
    shear = -float(given[cut, 2].sum()) * float((crown - springing) @ way)
    turned = float(np.cross(contacts.point - springing, given).sum(axis=0) @ turn)
    moments["shear in this joint (found)"] = shear
    moments["other forces in joints (found)"] = by_joints * rise - turned - shear
    beside = " and ".join(f"'{assembly.names[i]}'" for i in joints[top].blocks)
    by_hand = (load * arm + sum(moments.values())) / rise
    return CrownThrust(load, arm, moments, rise, by_hand, by_joints, beside)


def _parts_of_load(
    result: Result, other: AppliedLoads, half: Bools, about: Floats, turn: Floats
) -> tuple[Floats, Floats, dict[str, float]]:
    """Places (p, 3) and sizes (p,) of vertical loads on blocks (n,), and moments of others.

    Moments are about a point (3,) against the axis ``turn`` (3,); ``other``: beside masses.
    """
    assembly, load = result.assembly, result.load
    mine = half[other.block]
    masses = [(assembly.mass, assembly.centroid, other.acceleration)]
    masses += [(one.mass, one.place(assembly), one.gravity + one.shake) for one in load.masses]
    place = np.concatenate([one[half] for _, one, _ in masses])
    push = np.concatenate([mass[half, None] * g for mass, _, g in masses])
    moved, loaded = (
        -float(np.cross(at - about, one * [1.0, 1.0, 0.0]).sum(axis=0) @ turn)
        for at, one in ((place, push), (other.point[mine], other.force[mine]))
    )
    loaded -= float(other.moment[mine].sum(axis=0) @ turn)
    down = -np.append(push[:, 2], other.force[mine, 2])
    moments = {"masses pushed sideways": moved, "pressure and other loads": loaded}
    return np.vstack([place, other.point[mine]]), down, moments


def _middle(points: Floats, normal: Floats) -> Floats:
    """Mean of points (p, 3) by the normal forces on them, which leaves no couple on a plane."""
    weight = np.maximum(np.abs(normal), 1e-300)
    return weight @ points / weight.sum()
