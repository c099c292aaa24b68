"""Settlement by implicit steps against an explicit dynamic relaxation, on random models.

``python -m benchmarks.relaxation --count 40`` draws wedges in grooves, keystones and hooked planks,
and compares the largest tilt at which each comes to rest, with the flush ends of joints on either
block. The relaxation integrates masses on the same corner springs by small time steps, and stops
them whenever their kinetic energy has passed a peak: it shares the contact law with the steps, but
neither linearises anything nor solves any equation. All models and tilts of a round go together.

Source: kinetic damping, Cundall 1976; Day 1965 (dynamic relaxation).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

import numpy as np

from benchmarks.settlement import limit_of, rests
from drystone import Assembly, LoadCase, Model, models
from drystone.arrays import Floats, cross
from drystone.models.solids import prism
from drystone.settlement import Carrier, SettlementOptions
from drystone.settlement.bodies import Bodies, build_bodies

FALL, REST = 0.05, 0.02
"""Ways by a block's size from which it falls, and within which it stands."""
BALANCED = 1e-5
"""Unbalanced share of the load at rest."""
STEP = 0.4
"""Time step by that at which the stiffest motion becomes unstable, over two."""
STEPS = 60_000
"""After which a block that neither rests nor falls counts as falling."""


class Lanes:
    """Models of one free block each, side by side: arrays (l, ...), corners padded to (l, k)."""

    def __init__(self, bodies: Sequence[Bodies]) -> None:
        self.count = len(bodies)
        self.width = max(len(one.normal) for one in bodies)

        def padded(values: list[Floats]) -> Floats:
            out = np.zeros((self.count, self.width, *values[0].shape[1:]))
            for lane, value in enumerate(values):
                out[lane, : len(value)] = value
            return out

        free = [int(one.free[0]) for one in bodies]
        pairs = list(zip(bodies, free, strict=True))
        self.load = np.stack([one.load[0] for one in bodies])
        self.load[:, 3:] *= np.array([one.radius[i] for one, i in pairs])[:, None]
        self.radius = np.array([one.radius[i] for one, i in pairs])
        self.size = np.array([one.size[i] for one, i in pairs])
        self.start = np.stack([one.centroid[i] for one, i in pairs])
        is_b = [one.block_b == i for one, i in pairs]
        self.is_b = padded([b.astype(float) for b in is_b]) > 0.5
        self.arm = padded(
            [
                np.where(b[:, None], one.arm_b, one.arm_a)
                for one, b in zip(bodies, is_b, strict=True)
            ]
        )
        self.ground = padded(
            [
                np.where(
                    b[:, None],
                    one.centroid[one.block_a] + one.arm_a,
                    one.centroid[one.block_b] + one.arm_b,
                )
                for one, b in zip(bodies, is_b, strict=True)
            ]
        )
        self.frame = padded([one.frame for one in bodies])
        self.share = padded([one.share for one in bodies])
        self.normal = padded([one.normal for one in bodies])
        self.tangential = padded([one.tangential for one in bodies])
        self.friction = padded([one.friction for one in bodies])
        lever = (self.arm**2).sum(axis=2) / self.radius[:, None] ** 2
        stiffest = (self.normal * (1.0 + lever)).sum(axis=1)
        self.step = STEP * 2.0 / np.sqrt(stiffest)

    def taken(self, kept: np.ndarray) -> Lanes:
        """Some of the lanes."""
        part = object.__new__(Lanes)
        part.count, part.width = int(kept.sum()), self.width
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                setattr(part, name, value[kept])
        return part


def turned(vector: Floats) -> Floats:
    """Rotation matrices (l, 3, 3) of rotation vectors (l, 3), for small angles to second order."""
    x, y, z = vector.T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    return np.eye(3) + skew + 0.5 * skew @ skew


def relax(bodies: Sequence[Bodies]) -> list[bool]:
    """Whether the free block of each model comes to rest near its place."""
    lanes = Lanes(bodies)
    number = np.arange(lanes.count)
    answer = np.zeros(lanes.count, dtype=bool)
    place, turn = lanes.start.copy(), np.tile(np.eye(3), (lanes.count, 1, 1))
    velocity = np.zeros((lanes.count, 6))
    friction = np.zeros((lanes.count, lanes.width, 2))
    energy = np.zeros(lanes.count)
    for step in range(STEPS):
        free = place[:, None] + np.einsum("lij,lkj->lki", turn, lanes.arm)
        sign = np.where(lanes.is_b, 1.0, -1.0)
        with_free = np.einsum("lkai,lji->lkaj", lanes.frame, turn)
        of_b = lanes.is_b[:, :, None]
        on_a, on_b = np.where(of_b, lanes.ground, free), np.where(of_b, free, lanes.ground)
        frame = np.where(of_b[..., None], lanes.frame, with_free)
        normal_b = np.where(of_b, with_free[:, :, 0], lanes.frame[:, :, 0])
        apart = np.einsum("lkai,lki->lka", frame, on_b - on_a)
        lean = np.einsum("lkai,lki->lka", frame, normal_b)
        carried = np.einsum("lkab,lkb->lka", lanes.share, apart[:, :, 1:])
        gap = lean[:, :, 0] * apart[:, :, 0]
        gap += (lean[:, :, 1:] * (apart[:, :, 1:] - carried)).sum(axis=2)
        left = lean[:, :, 1:] - np.einsum("lkba,lkb->lka", lanes.share, lean[:, :, 1:])
        along = lean[:, :, :1] * frame[:, :, 0] + np.einsum("lka,lkai->lki", left, frame[:, :, 1:])
        along /= np.maximum(np.linalg.norm(along, axis=2), 1e-300)[..., None]
        u = frame[:, :, 1] - (frame[:, :, 1] * along).sum(axis=2)[..., None] * along
        v = cross(along, u)
        point = on_a + np.einsum("lka,lkai->lki", carried, frame[:, :, 1:])
        arm = point - place[:, None]
        speed = velocity[:, None, :3] + cross(
            np.broadcast_to(velocity[:, None, 3:], arm.shape), arm
        )
        slide = np.stack([(speed * u).sum(axis=2), (speed * v).sum(axis=2)], axis=2)
        slide *= (sign * lanes.step[:, None])[..., None]
        press = lanes.normal * np.maximum(0.0, -gap)
        friction = friction - lanes.tangential[..., None] * slide
        size = np.linalg.norm(friction, axis=2)
        limit = lanes.friction * press
        friction *= np.where(size > limit, limit / np.maximum(size, 1e-300), 1.0)[..., None]
        force = press[..., None] * along + friction[..., :1] * u + friction[..., 1:] * v
        force *= sign[..., None]
        wrench = lanes.load + np.concatenate(
            [force.sum(axis=1), cross(arm, force).sum(axis=1)], axis=1
        )
        velocity[:, :3] += lanes.step[:, None] * wrench[:, :3]
        velocity[:, 3:] += (lanes.step / lanes.radius**2)[:, None] * wrench[:, 3:]
        now = (velocity[:, :3] ** 2).sum(axis=1)
        now += lanes.radius**2 * (velocity[:, 3:] ** 2).sum(axis=1)
        over = now < energy
        velocity[over] = 0.0
        energy = np.where(over, 0.0, now)
        place = place + lanes.step[:, None] * velocity[:, :3]
        turn = turned(lanes.step[:, None] * velocity[:, 3:]) @ turn
        if step % 50:
            continue
        if step % 1000 == 0:  # rounding: rotations stay rotations
            left_, _, right_ = np.linalg.svd(turn)
            turn = left_ @ right_
        gone = np.linalg.norm(place - lanes.start, axis=1)
        angle = np.arccos(np.clip(0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0), -1.0, 1.0))
        way = (gone + angle * lanes.radius) / lanes.size
        unbalanced = np.linalg.norm(wrench[:, :3], axis=1)
        unbalanced += np.linalg.norm(wrench[:, 3:], axis=1) / lanes.radius
        still = (step > 200) & (unbalanced < BALANCED)
        ended = still | (way > FALL)
        answer[number[ended]] = (still & (way <= REST))[ended]
        if ended.any():
            kept = ~ended
            if not kept.any():
                break
            lanes, number = lanes.taken(kept), number[kept]
            place, turn, velocity = place[kept], turn[kept], velocity[kept]
            friction, energy = friction[kept], energy[kept]
    return answer.tolist()


def wedge(rng: np.random.Generator) -> Assembly:
    """A wedge in a groove of random slope, height and depth, ends flush."""
    slope = np.deg2rad(rng.uniform(25.0, 65.0))
    w, depth, above = rng.uniform(0.4, 1.2), rng.uniform(0.5, 1.5), rng.uniform(0.2, 1.5)
    rise = w * np.tan(slope)
    y = (0.0, depth)
    half = [(-2.0, -0.5), (0.0, -0.5), (0.0, 0.0), (-w, rise), (-2.0, rise)]
    plug = [(0.0, 0.0), (w, rise), (w, rise + above), (-w, rise + above), (-w, rise)]
    blocks = (
        prism(half, y, "left"),
        prism([(-x, z) for x, z in half], y, "right"),
        prism(plug, y, "free"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def keystone(rng: np.random.Generator) -> Assembly:
    """A plug between two piers whose faces lean outwards, longer than the plug or flush."""
    lean, high = np.tan(np.deg2rad(rng.uniform(4.0, 30.0))), rng.uniform(0.5, 1.5)
    w, longer = rng.uniform(0.3, 0.8), rng.choice([0.0, 0.3])
    pier = [(w, 0.0), (w + 1.5, 0.0), (w + 1.5, high), (w + lean * high, high)]
    plug = [(-w, 0.0), (w, 0.0), (w + lean * high, high), (-w - lean * high, high)]
    y = (-longer, 1.0 + longer)
    blocks = (
        prism([(-x, z) for x, z in pier], y, "left"),
        prism(pier, y, "right"),
        prism(plug, (0.0, 1.0), "free"),
    )
    return Assembly(blocks, np.array([True, True, False]))


def plank(rng: np.random.Generator) -> Assembly:
    """The hooked plank of Kao 2023, short or long, stretched at random along each axis."""
    kind = models.concave("short" if rng.random() < 0.5 else "long")
    return kind.transformed(np.diag(rng.uniform(0.6, 1.6, 3)))


KINDS = {"wedge": wedge, "keystone": keystone, "plank": plank}


def compare(count: int, seed: int = 1) -> None:
    """Print both limits of every model, and how far they are apart."""
    rng = np.random.default_rng(seed)
    began = time.process_time()
    cases = []
    for number in range(count):
        name = list(KINDS)[number % len(KINDS)]
        assembly = KINDS[name](rng)
        axis = rng.standard_normal(3)
        model = Model.of(assembly, friction=float(rng.uniform(0.3, 0.9)))
        model = model.with_contacts(model.contacts.select(model.active))
        for carrier in Carrier:
            options = SettlementOptions(fall=FALL, carrier=carrier)

            def stands(
                tilt: float,
                model: Model = model,
                axis: Floats = axis,
                options: SettlementOptions = options,
            ) -> bool:
                return rests(model, axis.tolist(), options, tilt)

            limit = limit_of(stands, width=0.2)
            cases.append((f"{name}-{number}", carrier, model, axis, limit))
    print(f"{count} models by implicit steps: {time.process_time() - began:.0f} CPU s", flush=True)
    offsets = np.array([-1.5, -0.75, 0.75, 1.5])
    lanes, keys = [], []
    for name, carrier, model, axis, limit in cases:
        for offset in offsets:
            load = LoadCase.tilt(model.assembly, axis, limit + offset)
            turned_ = model.with_load(load)
            lanes.append(build_bodies(turned_, carrier, overlap=1e-6, tangential=0.2))
            keys.append((name, carrier, offset))
    began = time.process_time()
    found = dict(zip(keys, relax(lanes), strict=True))
    spent = time.process_time() - began
    agree = close = 0
    for name, carrier, _, _, limit in cases:
        side = [found[name, carrier, offset] for offset in offsets]
        agree += side[0] and not side[3]
        close += side[1] and not side[2]
        if not (side[0] and not side[3]):
            print(f"{name} {carrier.value}: steps {limit:.1f}, relaxation rests at {side}")
    print(
        f"{len(cases)} limits: {agree} within 1.5 degrees, {close} within 0.75; {spent:.0f} CPU s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    compare(given.count, given.seed)


if __name__ == "__main__":
    main()
