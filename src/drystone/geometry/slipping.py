"""What a pressed face resists by friction: force and torque together.

A face slips as a rigid whole, with a velocity v and a turn w about its normal. With the friction
``b = mu fn`` of each of its points and their places x, force V and torque T are resisted up to the
factor that is the least power of slip (the kinematic theorem, which is exact here):

    min  sum b |v + w (-y, x)|    where  V . v + T w = 1

It is found by minimising ``sum b |.|^2 / before`` again and again, where ``before`` is the speed of
the last time. Sources: Goyal, Ruina, Papadopoulos 1991 for the surface; Weiszfeld 1937.
"""

from __future__ import annotations

import numpy as np

from drystone.base.arrays import Floats, lengths
from drystone.base.ragged import Ragged

_ROUNDS = 60
_SAME = 1e-4
"""Change of all factors at which the rounds end."""
_STILL = 1e-6
"""Least speed of a point that is divided by, by that of its face."""
_NEWTON = 40
"""Steps to the pressed part of a face. Chosen: 12 are enough half way from the kern to the rim."""
_BALANCED = 1e-6
"""What may be left of a force and its moments, by the force times the size of the face."""


def pressed_points(loops: Ragged, place: Floats, area: Floats, centre: Floats) -> Floats:
    """The shares (p,) of a normal force that press on the points of faces.

    They are those of a linear pressure that does not pull, ``area max(0, q + s . x)``.

    Parameters
    ----------
    loops, place, area
        Points of m faces, as of :func:`drystone.geometry.quadrature.face_points`.
    centre : (m, 2) [m]
        Where the force acts. Where no linear pressure has it, as on the rim, the shares are zero.
    """
    local = place - centre[loops.owner]
    size = np.sqrt(loops.sum(area * (local**2).sum(axis=1)) / loops.sum(area))
    row = np.column_stack([np.ones(len(local)), local / size[loops.owner, None]])
    weight = area / loops.sum(area)[loops.owner]
    wanted = np.tile([1.0, 0.0, 0.0], (len(loops), 1))
    pressed = np.ones(len(local), dtype=bool)
    outer = weight[:, None, None] * row[:, :, None] * row[:, None, :]
    share = np.zeros(len(local))
    for _ in range(_NEWTON):
        matrix = loops.sum(pressed[:, None, None] * outer)
        matrix += 1e-14 * np.eye(3)
        plane = np.linalg.solve(matrix, wanted[:, :, None])[:, :, 0]
        pressure = (row * plane[loops.owner]).sum(axis=1)
        share = weight * np.maximum(pressure, 0.0)
        before, pressed = pressed, pressure > 0.0
        if (before == pressed).all():
            break
    left = np.abs(loops.sum(share[:, None] * row) - wanted).max(axis=1, initial=0.0)
    return np.where(left <= _BALANCED, 1.0, 0.0)[loops.owner] * share


def slip_use(
    loops: Ragged,
    place: Floats,
    bound: Floats,
    force: Floats,
    torque: Floats,
    enough: Floats | float = np.inf,
) -> Floats:
    """Force (m, 2) and torque (m,) by the largest multiple of both that faces resist, (m,).

    Zero where nothing presses.

    Parameters
    ----------
    loops
        Points of m faces.
    place : (p, 2) [m]
        From the point about which the torque is.
    bound : (p,) [N]
        Largest friction of each point.
    force, torque : [N, N m]
    enough : (m,)
        What is known to be above it is told as some number above it. Each round finds more.

    Examples
    --------
    Two points that are 2 m apart, pulled across at one of them:

    >>> two = np.array([[-1.0, 0.0], [1.0, 0.0]])
    >>> pull = (np.array([[0.0, 1.0]]), np.array([1.0]))
    >>> slip_use(Ragged.from_counts([2]), two, np.array([3.0, 3.0]), *pull).round(3).tolist()
    [0.333]
    """
    total = loops.sum(bound)
    safe = np.where(total > 0.0, total, 1.0)
    size = np.sqrt(loops.sum(bound * (place**2).sum(axis=1)) / safe)
    size = np.where(size > 0.0, size, 1.0)
    wanted = np.column_stack([force, torque / size])
    loaded = (total > 0.0) & wanted.any(axis=1)
    scale = np.where(loaded, lengths(wanted), 1.0)
    wanted = np.where(loaded[:, None], wanted / scale[:, None], [1.0, 0.0, 0.0])
    power, least = np.ones(len(loops)), scale / (safe * np.maximum(enough, 1e-300))
    left = np.flatnonzero(loaded)  # a face that is done is left out of the rounds
    part, row = loops.take(left)
    speed, before = np.ones(len(row)), np.zeros(len(left))
    for _ in range(_ROUNDS):
        if not len(left):
            break
        face, goal = left[part.owner], wanted[left]
        x, y = (place[row] / size[face, None]).T
        share = bound[row] / safe[face]
        most = part.max(speed, empty=1.0)[part.owner]
        weight = share / np.maximum(speed, _STILL * most)
        matrix = np.zeros((len(row), 3, 3))
        matrix[:, 0, 0] = matrix[:, 1, 1] = weight
        matrix[:, 0, 2] = matrix[:, 2, 0] = -weight * y
        matrix[:, 1, 2] = matrix[:, 2, 1] = weight * x
        matrix[:, 2, 2] = weight * (x * x + y * y)
        summed = part.sum(matrix)
        summed += 1e-12 * np.trace(summed, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        slip = np.linalg.solve(summed, goal[:, :, None])[:, :, 0]
        slip /= (slip * goal).sum(axis=1)[:, None]
        v = slip[part.owner]
        speed = np.hypot(v[:, 0] - v[:, 2] * y, v[:, 1] + v[:, 2] * x)
        now = power[left] = part.sum(share * speed)
        moves = (np.abs(now - before) > _SAME * now) & (now >= least[left])
        left, before, speed = left[moves], now[moves], speed[moves[part.owner]]
        part, row = loops.take(left)
    found = scale / np.where(loaded, safe * power, 1.0)
    return np.where(loaded, found, 0.0)
