"""Products, scalings and step lengths of many second-order cones of three rows each.

A vector x = (x0, x1, x2) lies in the cone where ``x0 >= |(x1, x2)|``. The scaling W of Nesterov and
Todd takes a point x and a dual point z, both inside, to the same point: ``W x = W^-1 z``.

All arrays hold one cone per row (k, 3). Source: Vandenberghe 2010, The CVXOPT linear and quadratic
cone program solvers, sections 4 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats


def inner(x: Floats) -> Floats:
    """Distance (k,) of each vector from the boundary along its axis; negative outside the cone."""
    return np.asarray(x[:, 0] - np.hypot(x[:, 1], x[:, 2]))


def product(x: Floats, y: Floats) -> Floats:
    """The Jordan product (k, 3): ``(x . y, x0 (y1, y2) + y0 (x1, x2))``."""
    out = x[:, :1] * y + y[:, :1] * x
    out[:, 0] = (x * y).sum(axis=1)
    return out


def quotient(x: Floats, y: Floats) -> Floats:
    """The vector (k, 3) whose Jordan product with x is y, for x inside the cone."""
    across = x[:, 1] * y[:, 1] + x[:, 2] * y[:, 2]
    first = (x[:, 0] * y[:, 0] - across) / _determinant(x)
    out = (y - first[:, None] * x) / x[:, :1]
    out[:, 0] = first
    return out


def step_lengths(x: Floats, step: Floats) -> Floats:
    """The largest s <= 1 (k,) for which ``x + s step`` stays in each cone, for x inside them."""
    a = step[:, 0] ** 2 - step[:, 1] ** 2 - step[:, 2] ** 2
    b = x[:, 0] * step[:, 0] - x[:, 1] * step[:, 1] - x[:, 2] * step[:, 2]
    c = _determinant(x)
    # the least positive root of a s^2 + 2 b s + c, in the form that does not cancel
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    ahead = np.where(b < 0.0, c / np.where(b < 0.0, root - b, 1.0), np.inf)
    back = np.where(a < 0.0, -(b + root) / np.where(a < 0.0, a, 1.0), np.inf)
    lengths = np.where(b < 0.0, np.where(b * b >= a * c, ahead, np.inf), back)
    # a step through the apex, where rounding may hide the root
    falling = step[:, 0] < 0.0
    to_apex = np.where(falling, -x[:, 0] / np.where(falling, step[:, 0], 1.0), np.inf)
    return np.minimum(np.minimum(lengths, to_apex), 1.0)


@dataclass(frozen=True, eq=False)
class Scaling:
    """W of each cone, by its eigenvalues ``size (grow, 1, 1 / grow)``.

    Attributes
    ----------
    size, grow : (k,)
    along : (k, 2)
        Unit vectors u. The eigenvectors are (1, u), (0, across u), (1, -u).
    """

    size: Floats
    grow: Floats
    along: Floats

    @classmethod
    def of(cls, point: Floats, dual: Floats) -> Scaling:
        """The scaling of points inside the cones."""
        of_point, of_dual = np.sqrt(_determinant(point)), np.sqrt(_determinant(dual))
        x, z = point / of_point[:, None], dual / of_dual[:, None]
        gamma = np.sqrt(0.5 * (1.0 + (x * z).sum(axis=1)))
        middle = (z - x)[:, 1:] / (2.0 * gamma)[:, None]
        first = (z + x)[:, 0] / (2.0 * gamma)
        length = np.hypot(middle[:, 0], middle[:, 1])
        some = length > 0.0
        along = np.where(
            some[:, None], middle / np.where(some, length, 1.0)[:, None], np.array([1.0, 0.0])
        )
        return cls(np.sqrt(of_dual / of_point), first + length, along)

    def apply(self, x: Floats) -> Floats:
        """W x."""
        return self._combined(x, self.size * self.grow, self.size, self.size / self.grow)

    def undo(self, x: Floats) -> Floats:
        """W^-1 x."""
        return self._combined(
            x, 1.0 / (self.size * self.grow), 1.0 / self.size, self.grow / self.size
        )

    def tangent(self, softness: Floats) -> Floats:
        """(k, 3, 3) the inverse of ``W^2 + softness``, for numbers (k,) >= 0."""
        low, middle, high = (
            1.0 / ((self.size * factor) ** 2 + softness)
            for factor in (self.grow, np.ones_like(self.grow), 1.0 / self.grow)
        )
        u, v = self.along[:, 0], self.along[:, 1]
        mean, half = 0.5 * (low + high), 0.5 * (low - high)
        out = np.empty((len(u), 3, 3))
        out[:, 0, 0] = mean
        out[:, 0, 1] = out[:, 1, 0] = half * u
        out[:, 0, 2] = out[:, 2, 0] = half * v
        out[:, 1, 1] = mean * u * u + middle * v * v
        out[:, 2, 2] = mean * v * v + middle * u * u
        out[:, 1, 2] = out[:, 2, 1] = (mean - middle) * u * v
        return out

    def _combined(self, x: Floats, grown: Floats, kept: Floats, shrunk: Floats) -> Floats:
        u, v = self.along[:, 0], self.along[:, 1]
        ahead, across = u * x[:, 1] + v * x[:, 2], u * x[:, 2] - v * x[:, 1]
        plus, minus = 0.5 * grown * (x[:, 0] + ahead), 0.5 * shrunk * (x[:, 0] - ahead)
        ahead, across = plus - minus, kept * across
        return np.stack([plus + minus, u * ahead - v * across, v * ahead + u * across], axis=1)


def _determinant(x: Floats) -> Floats:
    length = np.hypot(x[:, 1], x[:, 2])
    return np.asarray((x[:, 0] - length) * (x[:, 0] + length))


__all__ = ["Scaling", "inner", "product", "quotient", "step_lengths"]
