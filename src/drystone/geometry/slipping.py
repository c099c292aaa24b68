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
from drystone.geometry.quadrature import FacePoints

_ROUNDS = 60
_SAME = 1e-4
"""Change of all factors at which the rounds end."""
_STILL = 1e-6
"""Least speed of a point that is divided by, by that of its face."""


def pressed_points(points: FacePoints, plane: Floats, centre: Floats) -> Floats:
    """The shares (p,) of a normal force that press on the points of faces.

    They are ``area max(0, q + s . x)``, but for what the points have other moments than the faces.

    Parameters
    ----------
    points
        Of m faces.
    plane : (m, 3)
        q, and s [1/m], as of :func:`drystone.geometry.pressure.linear_pressure`.
    centre : (m, 2) [m]
        Where the forces act.
    """
    loops, place, area = points
    owner = loops.owner
    share = area * np.maximum(plane[owner, 0] + dot(place, plane[owner, 1:]), 0.0)
    share /= loops.sum(share)[owner]
    local = place - centre[owner]
    local /= np.sqrt(loops.sum(share * dot(local, local)))[owner, None]
    basis = np.column_stack([np.ones(len(local)), local])
    matrix = loops.sum(share[:, None, None] * basis[:, :, None] * basis[:, None, :])
    wanted = np.tile(np.array([1.0, 0.0, 0.0])[:, None], (len(loops), 1, 1))
    mended = np.linalg.solve(matrix, wanted)[owner, :, 0]
    return share * np.maximum(dot(mended, basis), 0.0)


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
