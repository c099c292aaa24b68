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

from drystone.base.arrays import Floats, dot, lengths
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
    owner, whole = loops.owner, loops.sum(area)
    local = place - centre[owner]
    size = np.sqrt(loops.sum(area * dot(local, local)) / whole)
    x, y = local.T / size[owner]
    weight = area / whole[owner]
    wanted = np.array([1.0, 0.0, 0.0])
    share, pressed, row = np.zeros(len(x)), np.ones(len(x), dtype=bool), np.arange(len(x))
    moments = weight[:, None] * np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1)
    part, w, u, v = loops, weight, x, y  # a face that is done is left out of the steps
    for _ in range(_NEWTON):
        matrix = part.sum(pressed[:, None] * moments)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]]
        matrix = matrix.reshape(-1, 3, 3) + 1e-14 * np.eye(3)
        plane = np.linalg.solve(matrix, np.tile(wanted[:, None], (len(part), 1, 1)))[:, :, 0]
        even, slope_x, slope_y = plane[part.owner].T
        pressure = even + slope_x * u + slope_y * v
        share[row] = w * np.maximum(pressure, 0.0)
        before, pressed = pressed, pressure > 0.0
        changes = part.any(before != pressed)
        if not changes.any():
            break
        kept = changes[part.owner]
        part = Ragged.from_counts(part.counts[changes])
        row, pressed, w, u, v, moments = (each[kept] for each in (row, pressed, w, u, v, moments))
    left = loops.sum(share[:, None] * np.stack([np.ones(len(x)), x, y], axis=1)) - wanted
    missed = np.abs(left).max(axis=1, initial=0.0)
    return np.where(missed <= _BALANCED, 1.0, 0.0)[owner] * share


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
        What is known to be above it is told as some number above it, what is below as one below.
        Each round finds more, and friction that balances both: weights times speeds.

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
    size = np.sqrt(loops.sum(bound * dot(place, place)) / safe)
    size = np.where(size > 0.0, size, 1.0)
    wanted = np.column_stack([force, torque / size])
    loaded = (total > 0.0) & wanted.any(axis=1)
    scale = np.where(loaded, lengths(wanted), 1.0)
    wanted = np.where(loaded[:, None], wanted / scale[:, None], [1.0, 0.0, 0.0])
    power, least = np.ones(len(loops)), scale / (safe * np.maximum(enough, 1e-300))
    left = np.flatnonzero(loaded)  # a face that is done is left out of the rounds
    part, row = loops.take(left)
    x, y = place[row].T / size[left][part.owner]
    share = bound[row] / safe[left][part.owner]
    moments = np.stack([np.ones(len(x)), x, y, x * x + y * y], axis=1)
    speed, before = np.ones(len(row)), np.zeros(len(left))
    for _ in range(_ROUNDS):
        if not len(left):
            break
        goal = wanted[left]
        known = np.maximum(speed, _STILL * part.max(speed)[part.owner])
        weight = share / known
        summed, along, across, polar = part.sum(weight[:, None] * moments).T
        matrix = np.zeros((len(left), 3, 3))
        matrix[:, 0, 0] = matrix[:, 1, 1] = summed
        matrix[:, 0, 2] = matrix[:, 2, 0] = -across
        matrix[:, 1, 2] = matrix[:, 2, 1] = along
        matrix[:, 2, 2] = polar
        matrix += 1e-12 * (2.0 * summed + polar)[:, None, None] * np.eye(3)
        slip = np.linalg.solve(matrix, goal[:, :, None])[:, :, 0]
        v, w, turn = slip[part.owner].T
        speed = np.sqrt((v - turn * y) ** 2 + (w + turn * x) ** 2)
        most = least[left] * part.max(speed / known)  # of that friction, by what is enough
        speed /= (slip * goal).sum(axis=1)[part.owner]
        now = power[left] = part.sum(share * speed)
        moves = (np.abs(now - before) > _SAME * now) & (now >= least[left])
        moves &= (most > 1.0) | (least[left] == 0.0)
        left, before, kept = left[moves], now[moves], moves[part.owner]
        part = Ragged.from_counts(part.counts[moves])
        x, y, share, speed, moments = (each[kept] for each in (x, y, share, speed, moments))
    found = scale / np.where(loaded, safe * power, 1.0)
    return np.where(loaded, found, 0.0)
