"""Settlement by implicit steps against an explicit dynamic relaxation.

``python -m benchmarks.relaxation [--first 0] [--models 40] [--page FILE]``

Random wedges in grooves, keystones and hooked planks, each with random friction about a random
axis, and with the ends of the joints carried by either block. The tilt limit of settlement is
found by a scan and a bisection. The explicit relaxation integrates the same springs and friction
with inertia, in time steps, and with a viscous drag (Day 1965); the load grows from zero to its
whole. It has to rest 1.5 degrees below the limit and to fall 1.5 degrees above it. All models are
integrated at once.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy import sparse

from benchmarks.settlement import limit_of
from benchmarks.tables import write_table
from drystone import Assembly, LoadCase, Model, settle
from drystone.base.arrays import Bools, Floats, Ints, cross
from drystone.geometry.frames import rotations
from drystone.mechanics.bodies import BlockPositions, Bodies, build_bodies, place_corners
from drystone.mechanics.corners import Ends
from drystone.mechanics.law import respond
from drystone.models.simple import prism
from drystone.settlement import Carrier, Outcome, SettlementOptions

OVERLAP, TANGENTIAL = 1e-5, SettlementOptions().tangential
"""Those of both schemes. The overlap is ten times the default one: the number of explicit steps
until a fall grows with its inverse."""
APART = 1.5
"""Degrees from the limit at which the relaxation is asked."""
HIGHEST = 175.0
FALL, REST_WITHIN = 0.05, 0.02
"""Way by a block's size from which on it falls, and up to which it stands."""
BALANCED = 1e-5
"""Unbalanced force by the load, at rest."""
RAMP, DRAG = 4.0, 60.0
"""Time in which the load grows, and drag per mass, by the time in which a block accelerates by its
size under its weight. Contacts vibrate some 300 times as fast. With less drag contacts that slide
excite vibrations that grow: nonassociated friction has no potential, and its stiffness is not
symmetric. With an overlap of 1e-6 and a tangential stiffness of 0.2 the first wedge falls at 63
degrees at a drag of 2 and of 10, with a quarter of the time step too; at 50 it rests, after the
same displacement as by settlement to three digits. At 67 degrees, 0.3 below the limit of
settlement, it still falls at 50."""
STEPS = 200_000
SORTED_OUT = 500
"""Steps between two looks at which of the models are at an end."""


@dataclass(frozen=True)
class Trial:
    """One random model with one way to carry the ends of its joints."""

    name: str
    model: Model
    axis: tuple[float, float, float]
    carrier: Carrier

    def at(self, tilt: float) -> Model:
        """Turned by an angle [degrees]."""
        return self.model.with_load(LoadCase.tilt(self.model.assembly, self.axis, tilt))


def wedge(random: np.random.Generator, longer: float) -> Assembly:
    """In a V-shaped groove with two angles."""
    steep = np.tan(np.deg2rad(random.uniform(25.0, 65.0, 2)))
    reach = random.uniform(0.6, 1.2, 2)
    top = float((reach * steep).max() + random.uniform(0.05, 0.6))
    right, left = (
        (float(reach[0]), float(reach[0] * steep[0])),
        (-float(reach[1]), float(reach[1] * steep[1])),
    )
    far, low = 3.0, -1.0
    depth = float(random.uniform(0.6, 1.4))
    groove = (-longer, depth + longer)
    blocks = (
        prism([(-far, low), (0.0, low), (0.0, 0.0), left, (-far, left[1])], groove, "left"),
        prism([(far, low), (0.0, low), (0.0, 0.0), right, (far, right[1])], groove, "right"),
        prism([(0.0, 0.0), right, (right[0], top), (left[0], top), left], (0.0, depth), "free"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def keystone(random: np.random.Generator, longer: float) -> Assembly:
    """Between two walls that lean outwards by two angles."""
    half, height = random.uniform(0.3, 0.6), random.uniform(0.5, 1.2)
    lean = height * np.tan(np.deg2rad(random.uniform(3.0, 25.0, 2)))
    depth = float(random.uniform(0.6, 1.4))
    walls = (-longer, depth + longer)
    right = [(half, 0.0), (half + lean[0], height)]
    left = [(-half, 0.0), (-half - lean[1], height)]
    blocks = (
        prism([left[0], left[1], (-3.0, height), (-3.0, 0.0)], walls, "left"),
        prism([right[0], right[1], (3.0, height), (3.0, 0.0)], walls, "right"),
        prism([left[0], right[0], right[1], left[1]], (0.0, depth), "free"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def hooked_plank(random: np.random.Generator, longer: float) -> Assembly:
    """Under a slab, with a wing that lies on it."""
    thick, deep, wing, web, under, out = random.uniform(
        (0.1, 0.08, 0.2, 0.1, 0.2, 0.3), (0.3, 0.2, 0.7, 0.3, 0.9, 1.5)
    ).tolist()
    high = thick + deep
    depth = float(random.uniform(0.4, 1.0))
    plank = [(-under, -deep), (out, -deep), (out, 0.0), (web, 0.0), (web, high), (-wing, high),
             (-wing, thick), (0.0, thick), (0.0, 0.0), (-under, 0.0)]  # fmt: skip
    slab = [(-1.5, 0.0), (0.0, 0.0), (0.0, thick), (-1.5, thick)]
    blocks = (prism(slab, (-longer, depth + longer), "slab"), prism(plank, (0.0, depth), "free"))
    return Assembly(blocks, np.array([True, False]))


def trials(count: int, seed: int) -> list[Trial]:
    """Models in turn of each kind, every other one with ends that are not flush."""
    random = np.random.default_rng(seed)
    found = []
    for number in range(count):
        kind = (wedge, keystone, hooked_plank)[number % 3]
        longer = 0.0 if (number // 3) % 2 else 0.2
        assembly = kind(random, longer)
        friction, towards = random.uniform(0.2, 0.9), random.uniform(0.0, 2.0 * np.pi)
        axis = (float(np.cos(towards)), float(np.sin(towards)), 0.0)
        model = Model.of(assembly, friction=float(friction))
        ends = "flush" if longer == 0.0 else "longer"
        name = f"{number} {kind.__name__} {ends} mu {friction:.2f}"
        found += [
            Trial(name, model, axis, carrier) for carrier in (Carrier.MOVING, Carrier.RESTING)
        ]
    return found


def settled_limit(trial: Trial, width: float) -> float:
    """[degrees]."""
    options = SettlementOptions(
        fall=FALL, carrier=trial.carrier, overlap=OVERLAP, tangential=TANGENTIAL
    )

    def stands(tilt: float) -> bool:
        found = settle(trial.at(tilt), options=options)
        # the explicit integration has these springs: what rests on stiffer ones only does not count
        return found.outcome is Outcome.RESTS and found.path.overlap == OVERLAP

    return limit_of(stands, HIGHEST, width)


class Relaxation:
    """Explicit steps of many models, until each rests or falls."""

    def __init__(self, parts: Sequence[Bodies]) -> None:
        self.parts = list(parts)
        self.answers = np.full(len(parts), "goes on", dtype=object)
        self.number = np.arange(len(parts))
        self.states = [
            (
                one.centroid.copy(),
                np.tile(np.eye(3), (len(one.centroid), 1, 1)),
                np.zeros((len(one.free), 6)),
                np.zeros((len(one.block_a), 2)),
            )
            for one in parts
        ]
        self.done = 0

    def run(self, steps: int) -> list[str]:
        """``rests``, ``moved`` (rests too far away), ``falls`` or ``goes on`` for each."""
        for _ in range(0, steps, SORTED_OUT):
            if not len(self.number):
                break
            self._some(SORTED_OUT)
            self.done += SORTED_OUT
        return self.answers.tolist()

    def _some(self, steps: int) -> None:
        union = joined([self.parts[i] for i in self.number])
        place, turn, speed, friction = (
            np.concatenate([self.states[i][kind] for i in self.number]) for kind in range(4)
        )
        bodies = union.bodies
        free = bodies.free
        dt = _time_step(bodies)
        by_free, by_corner = dt[free][:, None], dt[bodies.block_b]
        slot_a, slot_b = bodies.slot[bodies.block_a], bodies.slot[bodies.block_b]
        gather = _gather(slot_b, len(free)), _gather(slot_a, len(free))
        radius = bodies.radius[free, None]
        pose = BlockPositions(place, turn)
        rate = np.zeros((len(place), 6))
        for number in range(self.done, self.done + steps):
            placed = place_corners(bodies, pose)
            rate[free, :3], rate[free, 3:] = speed[:, :3], speed[:, 3:] / radius
            arm_a = placed.point - pose.place[bodies.block_a]
            arm_b = placed.point - pose.place[bodies.block_b]
            of_a, of_b = rate[bodies.block_a], rate[bodies.block_b]
            velocity = (
                of_b[:, :3] + cross(of_b[:, 3:], arm_b) - of_a[:, :3] - cross(of_a[:, 3:], arm_a)
            )
            moved = by_corner[:, None] * np.einsum("kij,kj->ki", placed.axes, velocity)
            force = respond(bodies.springs, placed.gap, moved[:, 1:], -friction).force
            friction = force[:, 1:]
            world = np.einsum("ki,kij->kj", force, placed.axes)
            on_b = np.concatenate([world, cross(arm_b, world)], axis=1)
            on_a = np.concatenate([world, cross(arm_a, world)], axis=1)
            wrench = gather[0] @ on_b - gather[1] @ on_a
            wrench[:, 3:] /= radius
            grown = np.minimum(number * by_free / RAMP, 1.0)
            left = grown * bodies.load + wrench
            gained = np.linalg.solve(bodies.turned_mass(pose.turn), left[:, :, None])[:, :, 0]
            speed = (speed + by_free * gained) / (1.0 + DRAG * by_free)
            step = by_free * speed
            step[:, 3:] /= radius
            turned = pose.turn.copy()
            turned[free] = rotations(step[:, 3:]) @ turned[free]
            gone = pose.place.copy()
            gone[free] += step[:, :3]
            pose = BlockPositions(gone, turned)
        self._sort(union, pose, speed, friction, left, (grown >= 1.0)[:, 0])

    def _sort(
        self,
        union: Union,
        pose: BlockPositions,
        speed: Floats,
        friction: Floats,
        left: Floats,
        loaded: Bools,
    ) -> None:
        bodies, cases, count = union.bodies, union.of_free, len(self.number)
        free = bodies.free
        gone = np.linalg.norm(pose.place[free] - bodies.centroid[free], axis=1)
        trace = np.trace(pose.turn[free], axis1=1, axis2=2)
        turned = np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
        way = np.zeros(count)
        np.maximum.at(way, cases, (gone + turned * bodies.radius[free]) / bodies.size[free])
        unbalanced = np.sqrt(np.bincount(cases, (left**2).sum(axis=1), count))
        load = np.sqrt(np.bincount(cases, (bodies.load**2).sum(axis=1), count))
        rests: Bools = (unbalanced < BALANCED * load) & (np.bincount(cases, loaded, count) > 0)
        falls: Bools = way > REST_WITHIN
        on = []
        for place, number in enumerate(self.number):
            block, corner = union.of_block == place, union.of_corner == place
            self.states[number] = (
                pose.place[block], pose.turn[block], speed[cases == place], friction[corner]
            )  # fmt: skip
            if falls[place]:
                self.answers[number] = "falls"
            elif rests[place]:
                self.answers[number] = "rests"
            else:
                on.append(number)
        self.number = np.array(on, dtype=np.intp)


class Union(NamedTuple):
    """Many models side by side as one, and which block and corner belongs to which.

    Attributes
    ----------
    bodies
    of_block, of_corner
        The case of each.
    of_free
        The case of each free block.
    """

    bodies: Bodies
    of_block: Ints
    of_corner: Ints
    of_free: Ints


def joined(parts: Sequence[Bodies]) -> Union:
    """The scaled bodies of many models as those of one."""
    blocks = [len(one.centroid) for one in parts]
    corners = [len(one.block_a) for one in parts]
    frees = [len(one.free) for one in parts]
    first, first_free = np.cumsum([0, *blocks])[:-1], np.cumsum([0, *frees])[:-1]
    shifted = {
        "free": [one.free + at for one, at in zip(parts, first, strict=True)],
        "block_a": [one.block_a + at for one, at in zip(parts, first, strict=True)],
        "block_b": [one.block_b + at for one, at in zip(parts, first, strict=True)],
        "slot": [
            np.where(one.slot >= 0, one.slot + at, -1)
            for one, at in zip(parts, first_free, strict=True)
        ],
    }
    same = {
        field.name: np.concatenate(
            shifted.get(field.name) or [getattr(one, field.name) for one in parts]
        )
        for field in dataclasses.fields(Bodies)
        if field.name not in ("ends", "overlap", "length_unit", "force_unit", "felt")
    }
    ends = _joined_ends([one.ends for one in parts])
    case = np.arange(len(parts))
    return Union(
        Bodies(**same, ends=ends, overlap=parts[0].overlap, length_unit=1.0, force_unit=1.0),
        np.repeat(case, blocks),
        np.repeat(case, corners),
        np.repeat(case, frees),
    )


def _joined_ends(parts: Sequence[Ends]) -> Ends:
    corners = np.cumsum([0, *(len(one.joint) for one in parts)])
    joints = np.cumsum([0, *(int(one.joint.max(initial=-1)) + 1 for one in parts)])
    shifted = [
        one._replace(joint=one.joint + joint, after=one.after + corner)
        for one, joint, corner in zip(parts, joints[:-1], corners[:-1], strict=True)
    ]
    return Ends(*(np.concatenate(arrays) for arrays in zip(*shifted, strict=True)))


def _gather(slot: Ints, count: int) -> sparse.csr_matrix:
    here = np.flatnonzero(slot >= 0)
    return sparse.csr_matrix((np.ones(len(here)), (slot[here], here)), (count, len(slot)))


def _time_step(bodies: Bodies) -> Floats:
    """(n,) nine tenths of what is stable by the sum of the stiffnesses, for one free block each."""
    stiffness, least = np.zeros(len(bodies.centroid)), np.ones(len(bodies.centroid))
    mass = np.ones(len(bodies.centroid))
    mass[bodies.free] = bodies.mass[:, 0, 0]
    least[bodies.free] = np.linalg.eigvalsh(bodies.mass[:, 3:, 3:])[:, 0]
    turning = least / mass * bodies.radius**2
    for block, arm in ((bodies.block_a, bodies.arm_a), (bodies.block_b, bodies.arm_b)):
        far = (arm**2).sum(axis=1) / turning[block]
        np.add.at(stiffness, block, (bodies.normal + bodies.tangential) * (1.0 + far))
    of_free = 1.8 * np.sqrt(mass / np.maximum(stiffness, 1e-300))
    # its supports take its step
    out = np.zeros(len(of_free))
    out[bodies.free] = of_free[bodies.free]
    for block, other in ((bodies.block_a, bodies.block_b), (bodies.block_b, bodies.block_a)):
        out[block] = np.maximum(out[block], out[other])
    return out


def relaxed(
    asked: Sequence[tuple[Trial, float]], steps: int = STEPS, overlap: float = OVERLAP
) -> list[str]:
    """How the explicit relaxation ends for trials at tilts [degrees]."""
    parts = []
    for trial, tilt in asked:
        model = trial.at(tilt)
        part = model.with_contacts(model.contacts.select(model.active))
        parts.append(build_bodies(part, trial.carrier, overlap=overlap, tangential=TANGENTIAL))
    return Relaxation(parts).run(steps)


def main() -> int:
    parser = argparse.ArgumentParser(description="settlement against explicit relaxation")
    parser.add_argument("--models", type=int, default=40)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--first", type=int, default=0, help="leave out this many at the beginning")
    parser.add_argument("--table", type=Path, help="write the table there, .csv")
    given = parser.parse_args()
    began = time.process_time()
    every = trials(given.models, given.seed)[2 * given.first :]
    limits = [settled_limit(trial, 0.25) for trial in every]
    print(f"{len(every)} limits of settlement, {time.process_time() - began:.0f} CPU s", flush=True)
    asked = [
        (trial, tilt)
        for trial, limit in zip(every, limits, strict=True)
        for tilt in (max(limit - APART, 0.0), limit + APART)
    ]
    ends = relaxed(asked, given.steps)
    lines = [
        "| model | ends carried by | settled limit [deg] | 1.5 below | 1.5 above | agree |",
        "|---|---|---|---|---|---|",
    ]
    agree = 0
    for number, (trial, limit) in enumerate(zip(every, limits, strict=True)):
        below, above = ends[2 * number], ends[2 * number + 1]
        never = limit >= HIGHEST
        held = below == "rests" and (never or above == "falls")
        held |= limit < APART and above == "falls"
        agree += held
        lines.append(
            f"| {trial.name} | {trial.carrier.value} | {limit:.1f} | {below} | {above} "
            f"| {'yes' if held else 'NO'} |"
        )
    print("\n".join([*lines, "", f"{agree} of {len(every)} agree to {APART} degrees."]))
    print(f"{time.process_time() - began:.0f} CPU s")
    if given.table is not None:
        write_table(given.table, lines)
    return 0 if agree == len(every) else 1


if __name__ == "__main__":
    raise SystemExit(main())
