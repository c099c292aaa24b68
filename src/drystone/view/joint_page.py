"""A page for printing about the most loaded joints: a table, and a plan of each."""

from __future__ import annotations

import html
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from drystone.base.arrays import Floats
from drystone.base.display import NAME, OneLine, name_text, shortened
from drystone.base.files import write_text
from drystone.base.table import Table
from drystone.geometry.kern import kern
from drystone.joints import worst_joints
from drystone.results import Result
from drystone.view.palette import ROLE_COLOUR
from drystone.virtual import local_corners

_SIDE = 150
"""[px] of a plan."""
STYLE = """
:root { color-scheme: light dark; --ink: #1d1b18; --soft: #6b665c; --line: #d5d0c4;
  --paper: #ffffff; --stone: #e9e5da; --kern: KERN; --force: FORCE; --alarm: ALARM; }
@media (prefers-color-scheme: dark) { :root { --ink: #ece8df; --soft: #a49e92; --line: #3b3f45;
  --paper: #14171b; --stone: #33373d; --kern: KERN_DARK; --force: FORCE_DARK;
  --alarm: ALARM_DARK; } }
body { font: 14px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 62rem; margin: 1.5rem auto; padding: 0 1rem; }
h1 { font-size: 1.25rem; margin: 0 0 .25rem; } p { margin: .25rem 0 1rem; color: var(--soft); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .2rem .5rem; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th { color: var(--soft); font-weight: 500; vertical-align: bottom; }
th:nth-child(2), td:nth-child(2) { text-align: left; min-width: 10rem; white-space: normal;
  overflow-wrap: anywhere; }
.alarm { color: var(--alarm); font-weight: 600; }
.plans { display: flex; flex-wrap: wrap; gap: .75rem; margin-top: 1.25rem; }
figure { margin: 0; width: 150px; } figcaption { font-size: 11px; color: var(--soft);
  overflow-wrap: anywhere; }
.stone { fill: var(--stone); stroke: var(--ink); } .kern { fill: none; stroke: var(--kern);
  stroke-dasharray: 4 3; } .force { fill: var(--force); stroke: var(--paper); }
.legend svg { vertical-align: -4px; margin: 0 .25rem 0 1rem; }
@media print { body { margin: 0; max-width: none; } }
"""


def save_report(
    result: Result,
    path: str | PathLike[str],
    *,
    worst: int = 12,
) -> None:
    """Write a self-contained HTML page about the joints nearest to sliding or to a hinge.

    Parameters
    ----------
    result
        With forces.
    path
        Written to a temporary name beside it and renamed.
    worst
        How many joints are shown.

    Raises
    ------
    InputError
        The result has no forces, or the file cannot be written.
    """
    write_text(path, _report_text(result, worst))


def _report_text(result: Result, worst: int) -> str:
    """The page as text."""
    table = result.joints()
    ties = result.contacts.joints.ties
    chosen = [i for i in worst_joints(table, worst).tolist() if not ties[i]]
    light, dark = ROLE_COLOUR["light"], ROLE_COLOUR["dark"]
    style = STYLE
    for mark, role in (("KERN", "pressure"), ("FORCE", "resultant"), ("ALARM", "help")):
        style = style.replace(f"{mark}_DARK", dark[role]).replace(mark, light[role])
    title = "Joints that work hardest"
    free = len(result.assembly.free)
    open_joints = int((table["kern_ratio"] > 1.0 + 1e-9).sum())
    summary = (
        f"{result.verdict.value}: {result.message}. {free} free blocks, {len(table)} joints, "
        f"of which {open_joints} open on one side. Load: {result.load.name}."
    )
    crushes = bool(result.contacts.crushes.any())
    columns = (*_HEAD, "strength used") if crushes else _HEAD
    head = "".join(f"<th>{column}</th>" for column in columns)
    rows = "".join(_row(row, crushes) for row in table.take(chosen))
    plans = "".join(plan_figure(joint_plan(result, table, i)) for i in chosen)
    legend = (
        '<p class="legend">Plan of each joint, seen against its normal:'
        f"{_swatch('stone')}joint{_swatch('kern')}kern{_swatch('force')}centre of pressure</p>"
    )
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{style}</style></head><body>"
        f"<h1>{title}</h1><p>{html.escape(summary)}</p>"
        f'<div class="scroll"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
        f'</div>{legend}<div class="plans">{plans}</div></body></html>\n'
    )


_HEAD = (
    "joint",
    "between",
    "normal [N]",
    "friction [N]",
    "friction used",
    "to the rim",
    "of the kern",
    "mean [Pa]",
    "peak [Pa]",
)


def _row(row: dict[str, Any], crushes: bool) -> str:
    cells = [
        (str(row["joint"]), False),
        (f"{name_text(row['block_a'])} – {name_text(row['block_b'])}", False),
        (_number(row["normal"]), False),
        (_number(row["tangential"]), False),
        (_share(row["friction_use"]), row["friction_use"] > 0.99),
        (_share(row["edge_ratio"]), row["edge_ratio"] > 0.99),
        (_share(row["kern_ratio"]), False),
        (_number(row["mean_pressure"]), False),
        (_number(row["peak_pressure"]), False),
    ]
    if crushes:
        cells.append((_share(row["strength_use"]), row["strength_use"] > 0.99))
    return (
        "<tr>"
        + "".join(f'<td class="alarm">{t}</td>' if alarm else f"<td>{t}</td>" for t, alarm in cells)
        + "</tr>"
    )


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

    def _summary(self) -> str:
        return f"joint {self.joint}, {self.width:.3g} m wide"

    @property
    def width(self) -> float:
        """[m], the larger of both extents."""
        return float(np.ptp(self.corners, axis=0).max())

    def on(self, points: Floats, side: float, margin: float) -> Floats:
        """Points (p, 2) [m] on a square of a side, with a margin, from its lower left corner."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        scale = (side - 2.0 * margin) / self.width if self.width > 0.0 else 1.0
        placed: Floats = 0.5 * side + scale * (points - 0.5 * (low + high))
        return placed


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


def _swatch(kind: str) -> str:
    return (
        f'<svg width="16" height="16" aria-hidden="true"><circle class="{kind}" cx="8" cy="8" '
        'r="6"/></svg>'
    )


def _number(value: float) -> str:
    """Three digits and a prefix: 12.3 k."""
    if not np.isfinite(value):
        return "∞"
    size = abs(float(value))
    for prefix, unit in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if size >= unit:
            return f"{value / unit:.3g}\N{NO-BREAK SPACE}{prefix}"
    return f"{value:.3g}\N{NO-BREAK SPACE}" if size >= 1e-3 else "0\N{NO-BREAK SPACE}"


def _share(value: float) -> str:
    return f"{100.0 * value:.0f}\N{NO-BREAK SPACE}%" if np.isfinite(value) else "∞"
