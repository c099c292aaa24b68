"""The plan of a joint: its outline, its kern, and where it is pressed."""

from __future__ import annotations

import html
from dataclasses import dataclass

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import NAME, OneLine, name_text, shortened
from drystone.base.table import Table
from drystone.geometry.kern import kern
from drystone.results import Result
from drystone.virtual import local_corners

_SIDE = 150
"""[px] of a plan."""


@dataclass(frozen=True, eq=False)
class JointPlan(OneLine):
    """The plan of a joint, seen against its normal.

    Attributes
    ----------
    joint
        Its number.
    blocks
        Names of both blocks.
    corners, kern : (c, 2), (d, 2) [m], along u and v
    pressed : (2,) [m]
        Centre of pressure.
    axes
        Where u and v point, in words.
    """

    joint: int
    blocks: tuple[str, str]
    corners: Floats
    kern: Floats
    pressed: Floats
    axes: str

    @property
    def width(self) -> float:
        """[m], the larger of both extents."""
        return float(np.ptp(self.corners, axis=0).max())

    def on(self, points: Floats, side: float, margin: float) -> Floats:
        """Points (p, 2) [m] on a square of a side, with a margin, from its lower left corner."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        scale = (side - 2.0 * margin) / self.width if self.width > 0.0 else 1.0
        return 0.5 * side + scale * (points - 0.5 * (low + high))


def joint_plan(result: Result, table: Table, i: int) -> JointPlan:
    """The plan of a row of the joint table of a result."""
    contacts = result.contacts.joints
    origin, flat = local_corners(contacts)
    corners = flat[contacts.start[i] : contacts.start[i + 1]]
    position = np.array([table[axis][i] for axis in "xyz"])
    at = contacts.frame[i, 1:] @ (position - origin[i])
    names = (str(table["block_a"][i]), str(table["block_b"][i]))
    right, up = map(_direction, contacts.frame[i, 1:])
    return JointPlan(i, names, corners, kern(corners), at, f"right: {right}, up: {up}")


def _direction(unit: Floats) -> str:
    """A direction (3,) as an axis of the model with its sign, or its parts."""
    axis = int(np.abs(unit).argmax())
    if abs(unit[axis]) > 0.995:
        return f"{'-' if unit[axis] < 0.0 else '+'}{'xyz'[axis]}"
    return "(" + ", ".join(f"{part + 0.0:.2g}" for part in unit.round(2)) + ")"


def plan_figure(plan: JointPlan) -> str:
    """The joint, its kern and its centre of pressure as a small SVG, u to the right, v up."""

    def pixels(points: Floats) -> Floats:
        return np.array([0.0, _SIDE]) + plan.on(points, _SIDE, 12.0) * np.array([1.0, -1.0])

    def path(points: Floats) -> str:
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in pixels(points))

    x, y = pixels(plan.pressed)
    between = " – ".join(shortened(name, NAME) for name in plan.blocks)
    label = html.escape(f"joint {plan.joint}: {between}")
    return (
        f'<figure><svg viewBox="0 0 {_SIDE} {_SIDE}" width="{_SIDE}" height="{_SIDE}" role="img" '
        f'aria-label="{label}"><polygon class="stone" points="{path(plan.corners)}"/>'
        f'<polygon class="kern" points="{path(plan.kern)}"/>'
        f'<circle class="force" cx="{x:.1f}" cy="{y:.1f}" r="5"/></svg>'
        f"<figcaption>joint {plan.joint}: {' – '.join(map(name_text, plan.blocks))}"
        f"<br>{plan.width:.3g} m wide, {plan.axes}</figcaption></figure>"
    )
