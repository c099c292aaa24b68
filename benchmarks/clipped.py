"""A wedge in its groove, the faces clipped at every step: ``python -m benchmarks.clipped``.

An explicit program that shares nothing with ours: a rigid body with exact rotations on springs at
the corners of both faces, with Coulomb friction by increments and drag. In every step the corners
of a joint are those of the wedge's face, clipped to the groove's. Prints whether the wedge rests,
beside what we find with ``--ends exact``.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass

import numpy as np

from drystone import Assembly, LoadCase, Model, settle
from drystone.base.arrays import Floats
from drystone.models import wedge
from drystone.settlement import Carrier, SettlementOptions

G, STEP, DRAG, SECONDS = 9.81, 0.15, 100.0, 20.0
"""[m/s2]; time step by that of the springs; drag [1/s]; the longest time [s]."""
GONE, STILL = 0.05, 1e-7
"""[m] Way from which it falls; share of the weight, and speed [m/s], below which it rests."""


@dataclass(frozen=True)
class Groove:
    """A side of the groove: a corner, the way up its face, and its normal; it is 1 m long in y."""

    at: Floats
    up: Floats
    normal: Floats

    def clipped(self, corners: Floats) -> Floats:
        """Corners (4, 3) of the wedge's face, on the face of the groove, which is 1 m long."""
        local = corners - self.at
        height = float(np.linalg.norm(self.up))
        along = np.clip(local[:, 1], 0.0, 1.0)
        rise = np.clip(local @ self.up / height, 0.0, height)
        return np.asarray(
            self.at + np.outer(along, [0.0, 1.0, 0.0]) + np.outer(rise, self.up / height)
        )


def sides(groove: Assembly) -> list[Groove]:
    """Both sides of the groove of a wedge."""
    points = groove.blocks[2].vertices
    low = points[:, 2].min()
    shoulder = np.unique(points[:, 2].round(9))[1]
    half = points[:, 0].max()
    found = []
    for side in (-1.0, 1.0):
        up = np.array([side * half, 0.0, shoulder - low])
        normal = np.array([-side * up[2], 0.0, half]) / np.linalg.norm(up)
        found.append(Groove(np.array([0.0, 0.0, low]), up, normal))
    return found


def inertia_by_mass(groove: Assembly) -> Floats:
    """Moments (3,) [m2] about the axes through the centroid of the prism, by the mass."""
    block = groove.blocks[2]
    ring = block.vertices[np.abs(block.vertices[:, 1]) < 1e-9][:, [0, 2]] - block.centroid[[0, 2]]
    ring = ring[np.argsort(np.arctan2(ring[:, 1], ring[:, 0]))]
    after = np.roll(ring, -1, axis=0)
    twice = ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]
    xx, zz = (ring**2 + ring * after + after**2).T @ twice / 6.0 / twice.sum()
    return np.array([zz + 1.0 / 12.0, xx + zz, xx + 1.0 / 12.0])


def turned(turn: Floats, by: Floats) -> Floats:
    """A rotation (3, 3) after a small one about a vector [rad]."""
    angle = float(np.linalg.norm(by))
    x, y, z = by / max(angle, 1e-300)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    small = np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * skew @ skew
    return np.asarray(small @ turn)


def ends(
    groove: Assembly, degrees: float, shear: float, friction: float = 0.84, overlap: float = 1e-5
) -> str:
    """Whether the wedge ``rests`` or ``falls`` at a tilt about x, or is still on its way.

    Parameters
    ----------
    groove
    degrees
    shear
        Stiffness of a corner along its face by that across it.
    friction
    overlap : [m]
        Of all corners under the weight.
    """
    tilt = math.radians(degrees)
    weight = G * np.array([0.0, -math.sin(tilt), -math.cos(tilt)])
    centre, inertia = groove.blocks[2].centroid, inertia_by_mass(groove)
    normal = G / overlap / 8.0  # each of eight corners, by the mass
    step = STEP * math.sqrt(overlap / G)
    place, turn, speed, spin = np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)
    faces = sides(groove)
    rub = np.zeros((2, 4, 3))
    for _ in range(int(SECONDS / step)):
        force, moment = weight.copy(), np.zeros(3)
        for i, face in enumerate(faces):
            own = [face.at + along * np.array([0.0, 1.0, 0.0]) + rise * face.up
                   for along in (0.0, 1.0) for rise in (0.0, 1.0)]  # fmt: skip
            moved = place + centre + (np.array(own) - centre) @ turn.T
            point = face.clipped(moved)
            facing = turn @ face.normal
            gap = (moved[0] - point) @ facing / (face.normal @ facing)
            press = np.maximum(0.0, -normal * gap)
            arm = point - place - centre
            slide = speed + np.cross(spin, arm)
            rub[i] -= shear * normal * step * slide
            rub[i] -= np.outer(rub[i] @ face.normal, face.normal)
            size = np.linalg.norm(rub[i], axis=1)
            rub[i] *= np.minimum(1.0, friction * press / np.maximum(size, 1e-300))[:, None]
            push = np.outer(press, face.normal) + rub[i]
            force += push.sum(axis=0)
            moment += np.cross(arm, push).sum(axis=0)
        if np.linalg.norm(force) < STILL * G and np.linalg.norm(speed) < STILL:
            return "rests"
        speed = speed + step * (force - DRAG * speed)
        own_spin = turn.T @ spin
        own_spin += step * (turn.T @ moment - np.cross(own_spin, inertia * own_spin)) / inertia
        spin = turn @ (own_spin * (1.0 - step * DRAG))
        place, turn = place + step * speed, turned(turn, step * spin)
        if np.linalg.norm(place) > GONE:
            return "falls"
    return "moves"


def ours(groove: Assembly, degrees: float, shear: float) -> str:
    """The same by steps, the ends of faces as drawn."""
    model = Model.of(groove, friction=0.84, load=LoadCase.tilt(groove, (1.0, 0.0, 0.0), degrees))
    chosen = SettlementOptions(carrier=Carrier.EXACT, tangential=shear)
    return "rests" if settle(model, options=chosen).rests else "falls"


def main() -> None:
    """Print both for some tilts and shear stiffnesses."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tilts", type=float, nargs="*", default=[36.0, 38.0, 40.0, 42.0, 45.0])
    asked = parser.parse_args()
    groove = wedge("b")
    for shear in (0.02, 0.17, 1.0):
        for tilt in asked.tilts:
            print(
                f"{shear:g} {tilt:g}: {ends(groove, tilt, shear)}, ours {ours(groove, tilt, shear)}"
            )


if __name__ == "__main__":
    main()
