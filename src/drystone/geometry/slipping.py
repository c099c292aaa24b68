"""What a pressed face resists by friction: force and torque together.

A face slips as a rigid whole, with a velocity v and a turn w about its normal. Under a pressure p,
force V and torque T are resisted up to the factor that is the least power of slip (the kinematic
theorem, which is exact here), by the friction coefficient:

    min  P(v, w) = integral p |v + w (-y, x)|    where  V . v + T w = 1

The slip turns about a pole, and P is the integral of p by the distance from it. For a linear
pressure on a polygon it and its derivatives are sums over edges, so that Newton's method finds the
least. Source: Goyal, Ruina, Papadopoulos 1991 for the surface of force and torque.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drystone.base.arrays import Bools, Floats, dot, lengths
from drystone.base.ragged import Ragged
from drystone.geometry.kern import DESCENT

_FAR = 2e-3
"""Least turn of a slip by its velocity over the size of the face. Poles that are farther off change
the power by half the square of it, and rounding spoils the integrals."""
_NARROW = 0.01
"""Least width of a strip by the size of the face. A narrower one is used alike to 5e-5, the square
of the width, and rounding spoils the integrals about a far pole: to 7 % at a width of 2e-5."""
_STEPS = 40
"""Largest number of steps. Of 700 faces of seven kinds most take 2, one takes 13."""
_SAME = 1e-5
"""Newton decrement by the power at which the steps end."""
_AHEAD = 2.0
"""What a power may still lessen, by the decrement: half of it for a quadratic one. Measured on
11,556 faces of 1,132 models: the same ones use more than asked."""


class TurnIntegrals(NamedTuple):
    """Integrals over m pressed polygons. From a pole, r is the distance and e its direction.

    Attributes
    ----------
    moment : (m,)
        ``integral p r``.
    pull : (m, 2)
        ``integral p e``.
    bend : (m, 2, 2)
        ``integral p e e' / r``.
    """

    moment: Floats
    pull: Floats
    bend: Floats


def turned(corners: Floats, loops: Ragged, plane: Floats, poles: Floats) -> TurnIntegrals:
    """The integrals of a turn about poles (m, 2) over polygons, with the pressure ``q + s . x``.

    Each edge spans a triangle with the pole. Over it the integrals are elementary in polar
    coordinates: ``h sec a`` is the radius of the edge, whose distance from the pole is h.
    """
    owner = loops.owner
    local = corners - poles[owner]
    edge = local[loops.following] - local
    length = lengths(edge)
    ax, ay = edge.T / np.maximum(length, 1e-300)
    x, y = local.T
    off = x * ay - y * ax
    sign, h = np.sign(off), np.abs(off)
    cx, cy = sign * ay, -sign * ax  # across the edge, as (ax, ay) is along it
    q = (plane[:, 0] + dot(poles, plane[:, 1:]))[owner]
    _, sx, sy = plane[owner].T
    s, t = sx * cx + sy * cy, sx * ax + sy * ay
    begin = x * ax + y * ay
    rise = np.array([begin, begin + length]) / np.where(h > 0.0, h, 1.0)
    secant = np.sqrt(1.0 + rise**2)
    angle = np.arcsinh(rise)
    changes = np.array([angle, secant, rise * secant, secant**3, rise / secant, 1.0 / secant])
    sec, sec_tan, product, cubed, sin, cos = changes[:, 1] - changes[:, 0]
    sec3, tan3 = 0.5 * (product + sec), cubed / 3.0
    h2, h3 = h**2 / 2.0, h**3 / 3.0
    q1, q2, q3, h4 = q * h, q * h2, q * h3, h**4 / 4.0
    moment = q3 * sec3 + h4 * (s * sec3 + t * tan3)
    by_across = q2 * sec + h3 * (s * sec + t * sec_tan)
    by_along = q2 * sec_tan + h3 * (s * sec_tan + t * (sec3 - sec))
    both = q1 * sin + h2 * (s * sin - t * cos)
    mixed = h2 * (t * (sec - sin) - s * cos) - q1 * cos
    rest = q1 * (sec - sin) + h2 * (s * (sec - sin) + t * (sec_tan + cos))
    parts = sign * np.array(
        [
            moment,
            by_across * cx + by_along * ax,
            by_across * cy + by_along * ay,
            both * cx * cx + rest * ax * ax + 2.0 * mixed * cx * ax,
            both * cx * cy + rest * ax * ay + mixed * (cx * ay + cy * ax),
            both * cy * cy + rest * ay * ay + 2.0 * mixed * cy * ay,
        ]
    )
    total = loops.sum(parts.T)
    return TurnIntegrals(total[:, 0], total[:, 1:3], total[:, [3, 4, 4, 5]].reshape(-1, 2, 2))


def clipped(loops: Ragged, corner: Floats, height: Floats) -> tuple[Ragged, Floats]:
    """What of polygons has a positive height, which is linear over each.

    Parts of a concave one are one loop, joined along the line of no height. They have the integrals
    of the parts.
    """
    after = loops.following
    up = height > 0.0
    crosses = up != up[after]
    share = height / np.where(crosses, height - height[after], 1.0)
    met = corner + share[:, None] * (corner[after] - corner)
    kept = np.stack([up, crosses], axis=1)
    kept &= (loops.sum(kept.sum(axis=1)) > 2)[loops.owner, None]
    owner = np.repeat(loops.owner, kept.sum(axis=1))
    return Ragged.from_owners(owner, len(loops)), np.stack([corner, met], axis=1)[kept]


class Slip(NamedTuple):
    """How m faces slip first.

    Attributes
    ----------
    use : (m,)
        Force and torque by the largest multiple of both that the faces resist.
    pole : (m, 2) [m]
        What they turn about.
    """

    use: Floats
    pole: Floats


def slip_use(
    corners: Floats,
    loops: Ragged,
    plane: Floats,
    force: Floats,
    torque: Floats,
    least: Floats | float = 0.0,
) -> Slip:
    """What of the friction of m faces force and torque use, and how they slip.

    Parameters
    ----------
    corners : (l, 2) [m]
        Of the parts that are pressed, from the point about which the torque is.
    loops : Ragged
        Their corners, counter-clockwise.
    plane : (m, 3)
        The pressure ``q + s . x`` by the mean one, which is not negative there.
    force, torque : (m, 2) [m2], (m,) [m3]
        By the friction coefficient and by the mean pressure. Not both zero.
    least : (m,)
        A use that is surely smaller is not found exactly.

    Examples
    --------
    A square of side 1 resists the torque 0.3826 by an even pressure, about its middle:

    >>> square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    >>> even, torque = np.array([[1.0, 0.0, 0.0]]), np.array([0.3826])
    >>> found = slip_use(square, Ragged.from_counts([4]), even, np.zeros((1, 2)), torque)
    >>> found.use.round(3).tolist(), abs(found.pole).round(3).tolist()
    ([1.0], [[0.0, 0.0]])
    """
    owner = loops.owner
    size = loops.max(lengths(corners))
    corners = corners / size[owner, None]
    plane = np.concatenate([plane[:, :1], plane[:, 1:] * size[:, None]], axis=1)
    corners, plane = _widened(corners, loops, plane)
    wanted = np.concatenate([force, (torque / size)[:, None]], axis=1)
    scale = lengths(wanted)
    wanted /= scale[:, None]
    least, bound = np.broadcast_to(least, scale.shape), scale / size**2
    power, pole = np.empty(len(size)), np.empty((len(size), 2))
    # begun with the slip of friction that grows with the speed. Parallelograms pressed evenly have
    # 3. With 8, 7,845 faces of 1,132 models take a fifth fewer steps: most are pressed in part
    slip = wanted.copy()
    slip[:, 2] *= 8.0 / loops.mean(dot(corners, corners))
    slip /= dot(slip, wanted)[:, None]
    left, share = np.arange(len(size)), np.ones(len(size))
    now = _Power.of(corners, loops, plane, slip, wanted)
    for _ in range(_STEPS):
        power[left], pole[left] = now.value, now.pole
        moves = now.decrement > _SAME * now.value
        moves &= (now.value - _AHEAD * now.decrement) * least[left] < bound[left]
        if not moves.any():
            break
        left, slip, share = left[moves], slip[moves], share[moves]
        now = now.take(moves)
        part, row = loops.take(left)
        trial = slip + share[:, None] * now.step
        then = _Power.of(corners[row], part, plane[left], trial, wanted[left])
        good = then.value <= now.value - DESCENT * share * now.decrement
        slip = np.where(good[:, None], trial, slip)
        share = np.where(good, 1.0, 0.5 * share)
        now = then.where(good, now)
    return Slip(scale / (power * size**2), pole * size[:, None])


def _widened(corners: Floats, loops: Ragged, plane: Floats) -> tuple[Floats, Floats]:
    """Faces of size 1 whose pressed strips are no narrower than :data:`_NARROW`, with their force.

    They are stretched from the origin along the slope of the pressure.
    """
    slope = plane[:, 1:]
    along = (slope / np.maximum(lengths(slope), 1e-300)[:, None])[loops.owner]
    place = dot(corners, along)
    width = loops.max(place) - loops.min(place)
    wider = np.maximum(_NARROW / np.where(width > 0.0, width, _NARROW), 1.0)[:, None]
    stretch = ((wider[loops.owner, 0] - 1.0) * place)[:, None] * along
    return corners + stretch, np.hstack([plane[:, :1], slope / wider]) / wider


class _Power(NamedTuple):
    """The power of slips, by the mean pressure, and Newton's step to a lesser one, damped."""

    value: Floats
    pole: Floats
    step: Floats
    decrement: Floats

    @classmethod
    def of(
        cls, corners: Floats, loops: Ragged, plane: Floats, slip: Floats, wanted: Floats
    ) -> _Power:
        """Of slips (m, 3) that have the power 1 of what is wanted, as their steps have."""
        v, w = slip[:, :2], slip[:, 2]
        least = _FAR * lengths(v)
        w = np.where(np.abs(w) < least, np.copysign(least, w), w)
        far: Floats = v / w[:, None]
        pole = np.array([-far[:, 1], far[:, 0]]).T
        turn = turned(corners, loops, plane, pole)
        speed, sense = np.abs(w), np.sign(w)
        value = speed * turn.moment
        x, y = turn.pull.T
        gradient = (sense * np.array([-y, x, turn.moment + dot(pole, turn.pull)])).T
        matrix, right = np.zeros((len(w), 4, 4)), np.zeros((len(w), 4, 1))
        bent = matrix[:, :3, :3]
        bent[:, :2, :2] = turn.bend / speed[:, None, None]
        bent[:, :2, 2] = bent[:, 2, :2] = -(bent[:, :2, :2] @ far[:, :, None])[:, :, 0]
        bent[:, 2, 2] = -dot(far, bent[:, 2, :2])
        spread = bent[:, 0, 0] + bent[:, 1, 1] + bent[:, 2, 2]
        matrix.reshape(-1, 16)[:, [0, 5, 10]] += 1e-12 * spread[:, None]
        matrix[:, :3, 3] = matrix[:, 3, :3] = wanted
        right[:, :3, 0] = -gradient
        step = np.linalg.solve(matrix, right)[:, :3, 0].astype(np.float64)
        decrement = np.maximum(-dot(gradient, step), 0.0)
        return cls(value, pole, step / (1.0 + np.sqrt(decrement / value))[:, None], decrement)

    def take(self, some: Bools) -> _Power:
        """Those of some faces."""
        return _Power(*(each[some] for each in self))

    def where(self, some: Bools, other: _Power) -> _Power:
        """These of some faces, the others of the rest."""
        pairs = zip(self, other, strict=True)
        return _Power(*(np.where(some if a.ndim == 1 else some[:, None], a, b) for a, b in pairs))
