"""Form finding: a net of bars in compression that carries the shell's own weight.

Every bar has a force density q, its force divided by its length. For given densities, linear
equations give the positions of the nodes: ``sum_j q_ij (x_i - x_j) = p_i``. The net is the middle
surface of the shell, so the thrust stays in the middle of the shell.

Source: Schek 1974, "The force density method for form finding".
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from drystone.assembly import DEFAULT_DENSITY
from drystone.base.arrays import Bools, Floats, Ints
from drystone.base.display import OneLine
from drystone.base.errors import InputError
from drystone.geometry.coincidence import distinct
from drystone.loads import STANDARD_GRAVITY
from drystone.shells.patch import Shape, Side
from drystone.shells.sources import patch_from_grid

_ROUNDS = 60
"""Largest number of iterations of load and form; each reduces the error about ten times."""

SETTLED = 1e-10
"""Relative change of height at which the iteration has converged."""


@dataclass(frozen=True, eq=False)
class FormFound(OneLine):
    """A form that carries its own weight in compression.

    Attributes
    ----------
    shape
        Spline patches through the nodes, with the seams and supports of the plan.
    thickness : [m]
        Thickness from which the load was calculated.
    point : (p, 3) [m] nodes
    bar : (b, 2) nodes at the ends of each bar
    force : (b,) [N] compression in each bar
    reaction : (p, 3) [N] at the supports, zero elsewhere
    residual
        Largest unbalanced force on a free node, relative to the mean load of a node.
    height : [m] reached
    rounds
    """

    shape: Shape
    thickness: float
    point: Floats
    bar: Ints
    force: Floats
    reaction: Floats
    residual: float
    height: float
    rounds: int


@dataclass(frozen=True, eq=False)
class _Net:
    """Nodes of all patches, coincident ones merged."""

    point: Floats
    node: tuple[Ints, ...]
    quad: Ints
    bar: Ints
    density: Floats
    fixed: Bools


def find_form(
    plan: Shape,
    *,
    height: float,
    thickness: float | None = None,
    rows: int = 25,
    columns: int = 25,
    edge_density: float = 8.0,
    density: float = DEFAULT_DENSITY,
) -> FormFound:
    """The form over a plan that carries its weight in compression only.

    Parameters
    ----------
    plan
        A shape whose patches are flat plans. Its supports keep their height; its other borders move
        until the free edges of the net are in equilibrium.
    height : [m] > 0
        Of the highest node above the lowest support.
    thickness : [m] > 0, < inf
        Its weight is the load; that of the plan when left out.
    rows, columns : >= 4
        Nodes of the net along u and v of each patch.
    edge_density : > 0
        Force density of bars on free edges, relative to that of the others. With a high value free
        edges are nearly straight in plan.
    density : [kg/m3] > 0

    Raises
    ------
    InputError
        No support, supports on one line, too few nodes, or a number that is not above zero.

    Examples
    --------
    >>> from drystone.shells import Edge, Side, find_form, rectangular_plan
    >>> plan = rectangular_plan(6.0, 8.0, open_sides=(Side.TOP,))
    >>> form = find_form(plan, height=2.0)
    >>> round(form.height, 6), form.residual < 1e-8
    (2.0, True)
    """
    thickness = thickness if thickness is not None else plan.default_thickness
    if not plan.supports:
        raise InputError("the plan has no support", remedy="name the sides that it stands on")
    net = _net(plan, (rows, columns), edge_density)
    _refuse_line(plan, net)
    point, load, scale, rounds = _balance(net, height, thickness * density)
    force_density = net.density * scale
    spread = point[net.bar[:, 1]] - point[net.bar[:, 0]]
    push = force_density[:, None] * spread
    unbalanced = np.zeros_like(point)
    np.add.at(unbalanced, net.bar[:, 0], -push)
    np.add.at(unbalanced, net.bar[:, 1], push)
    unbalanced[:, 2] -= load
    reaction = np.where(net.fixed[:, None], -unbalanced, 0.0)
    residual = np.linalg.norm(unbalanced[~net.fixed], axis=1).max() / load.mean()
    return FormFound(
        shape=_shape(plan, net, point, thickness),
        thickness=thickness,
        point=point,
        bar=net.bar,
        force=np.linalg.norm(push, axis=1),
        reaction=reaction,
        residual=float(residual),
        height=float(point[:, 2].max() - point[net.fixed, 2].min()),
        rounds=rounds,
    )


def _refuse_line(plan: Shape, net: _Net) -> None:
    """Refuse supports on one line: the net would collapse onto it."""
    held = net.point[net.fixed] - net.point[net.fixed].mean(axis=0)
    spread = np.linalg.svd(held, compute_uv=False)
    if spread[1] <= 1e-6 * np.linalg.norm(np.ptp(net.point, axis=0)):
        raise InputError(
            "its supports lie on one line, over which no net can span",
            where=f"shape '{plan.name}'",
            remedy="support another side too",
        )


def _net(plan: Shape, nodes: tuple[int, int], edge_density: float) -> _Net:
    u, v = (np.linspace(0.0, 1.0, count) for count in nodes)
    grids = [patch.point(u[:, None], v[None, :]) for patch in plan.patches]
    every = np.concatenate([grid.reshape(-1, 3) for grid in grids])
    size = float(np.linalg.norm(np.ptp(every, axis=0)))
    kept, node = distinct(every, 1e-6 * size)
    grid_nodes = tuple(node.reshape(len(grids), *nodes))
    quad = np.concatenate(
        [
            np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, 1:], n[1:, :-1]], axis=2).reshape(-1, 4)
            for n in grid_nodes
        ]
    )
    ends = np.sort(np.stack([quad, np.roll(quad, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    bar, quads = np.unique(ends, axis=0, return_counts=True)
    fixed = np.zeros(len(kept), dtype=bool)
    for edge in plan.supports:
        across = edge.side in (Side.BOTTOM, Side.TOP)
        along = v if across else u
        grid = grid_nodes[edge.patch]
        last = 0 if edge.side in (Side.BOTTOM, Side.LEFT) else -1
        run = grid[last] if across else grid[:, last]
        fixed[run[(along >= edge.low - 1e-9) & (along <= edge.high + 1e-9)]] = True
    density = np.where(quads == 1, edge_density, 1.0)
    return _Net(every[kept], grid_nodes, quad, bar.astype(np.intp), density, fixed)


def _balance(net: _Net, height: float, mass: float) -> tuple[Floats, Floats, float, int]:
    """Nodes in equilibrium, loads [N], force density of an inner bar [N/m], iterations.

    The ``mass`` of the shell is per area [kg/m2].
    """
    count, free, fixed = len(net.point), np.flatnonzero(~net.fixed), np.flatnonzero(net.fixed)
    incidence = sparse.csr_matrix(
        (
            np.tile([1.0, -1.0], len(net.bar)),
            (np.repeat(np.arange(len(net.bar)), 2), net.bar.ravel()),
        ),
        (len(net.bar), count),
    )
    stiffness = (incidence.T @ sparse.diags(net.density) @ incidence).tocsc()
    factor = splu(stiffness[free][:, free])
    base = net.point.copy()
    base[free] = factor.solve(-(stiffness[free][:, fixed] @ net.point[fixed]))
    target = height + float(net.point[fixed, 2].min())
    weight = mass * STANDARD_GRAVITY
    point, scale = base, 1.0
    for done in range(_ROUNDS):
        load = weight * _node_areas(point, net.quad)
        lift = np.zeros(count)
        lift[free] = factor.solve(load[free])
        previous = point[:, 2]
        for _ in range(20):  # the highest node may change with the scale
            top = int(np.argmax(base[:, 2] + lift / scale))
            new = float(lift[top]) / max(target - float(base[top, 2]), 1e-9 * height)
            if abs(new - scale) <= 1e-14 * new:
                break
            scale = new
        point = base.copy()
        point[:, 2] += lift / scale
        if np.abs(point[:, 2] - previous).max() <= SETTLED * height:
            return point, load, scale, done + 1
    return point, load, scale, _ROUNDS


def _node_areas(point: Floats, quad: Ints) -> Floats:
    """(p,) [m2] a quarter of every quadrilateral around each node."""
    corner = point[quad]
    across = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    quarter = np.repeat(np.linalg.norm(across, axis=1) / 8.0, 4)
    shares: Floats = np.zeros(len(point))
    np.add.at(shares, quad.ravel(), quarter)
    return shares


def _shape(plan: Shape, net: _Net, point: Floats, thickness: float) -> Shape:
    patches = []
    for patch, nodes in zip(plan.patches, net.node, strict=True):
        columns = [at * (nodes.shape[1] - 1) for at in patch.breaks]
        if any(abs(c - round(c)) > 1e-9 for c in columns):
            raise InputError(
                f"no column of the net stands at the corner of patch '{patch.name}'",
                remedy="use an odd number of columns",
            )
        found = patch_from_grid(
            point[nodes], breaks=[round(c) for c in columns], name=f"{patch.name}, form found"
        )
        patches.append(found)
    name = f"{plan.name}, form found"
    return replace(plan, patches=tuple(patches), name=name, thickness=thickness)
