"""Interlocking: whether an assembly holds by its shape alone under any load.

With some blocks fixed, an assembly without friction is in equilibrium under every load if and only
if no motion of its blocks is free, that is, opens joints or slides along them:

    B q >= 0  has no solution but q = 0,

with a row of B for each corner of a joint: the speed at which it opens. A linear program searches
for a motion that opens some joint. If there is none, a free motion can only slide; it lies in the
null space of B. Source: Wang, Song, Pauly 2018 ("DESIA", ACM Trans. Graph. 37 (6)); Wang, Song,
Isvoranu, Pauly 2019 ("Design and structural optimization of topological interlocking assemblies",
ACM Trans. Graph. 38 (6)), who show that this is the same as equilibrium under every load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Unpack

import numpy as np
from scipy import sparse

from drystone.base.arrays import Bools, Floats
from drystone.base.display import OneLine
from drystone.base.errors import InputError, SolverError
from drystone.base.progress import Clock, Progress, Stop, Workers
from drystone.base.settings import checked_call
from drystone.base.workers import WorkerPool
from drystone.io.opening import Given, How, as_model
from drystone.loads import LoadCase
from drystone.model import Model
from drystone.programs import RBEOptions, solve_rbe
from drystone.results import Verdict
from drystone.sequence.freedom import Joints, free_twists
from drystone.solvers.conic import ConicStatus
from drystone.solvers.program import ProgramBuilder
from drystone.stability import check

OPENS = 1e-6
"""Least mean of the opening speeds that counts as opening, with the largest speed 1; above the
solver's tolerance."""
SLIDES = 1e-7
"""Squares of singular values of B below this share of the largest are zero. Chosen: well above
rounding."""


@dataclass(frozen=True, eq=False)
class Interlocking(OneLine):
    """Whether an assembly interlocks.

    Attributes
    ----------
    model
        With the key fixed.
    holds
        Whether no motion is free: it carries every load without friction.
    motion : (n, 6) or None
        Translation [m] and rotation vector [rad] of each block in a free motion; the fastest block
        moves by 1 m. None where it holds.
    moving
        Positions of the blocks that move in it.
    first
        Positions of the blocks that can move while all others are at rest. They can be removed
        first.
    """

    model: Model
    holds: bool
    motion: Floats | None
    moving: tuple[int, ...]
    first: tuple[int, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the blocks that can move alone."""
        return tuple(self.model.assembly.names[b] for b in self.first)


def interlocking(
    given: Given, key: int | str | Sequence[int | str] | None = None, **how: Unpack[How]
) -> Interlocking:
    """Whether an assembly with a fixed key holds under every load without friction.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    key
        The block or blocks that are held; the supports of the model when left out. For a puzzle
        with a sliding key, hold the key and one other piece: with the key alone fixed, all other
        pieces may slide away together.

    Raises
    ------
    InputError
        Nothing is fixed, or a name is not known.

    Examples
    --------
    >>> from drystone.models import tower
    >>> found = interlocking(tower(3))
    >>> found.holds, found.names
    (False, ('block-1', 'block-2'))
    """
    model = as_model(given, **how)
    if key is not None:
        model = model.with_supports([key] if isinstance(key, int | str) else list(key))
    assembly = model.assembly
    if not assembly.fixed.any():
        raise InputError("nothing is fixed", where="key", remedy="name the block that is held")
    first = tuple(b for b in assembly.free.tolist() if not _alone(model, b))
    rows = opening_rows(model)
    motion = _opening(rows) if rows.shape[1] else None
    if motion is None:
        motion = _sliding(rows)
    if motion is None:
        return Interlocking(model, True, None, (), first)
    whole = np.zeros((len(assembly), 6))
    whole[assembly.free] = motion.reshape(-1, 6)
    whole[:, :3] *= assembly.size[:, None]
    speed = np.linalg.norm(whole[:, :3], axis=1) + np.linalg.norm(
        whole[:, 3:] * assembly.size[:, None], axis=1
    )
    moving = tuple(np.flatnonzero(speed > 1e-6 * speed.max()).tolist())
    return Interlocking(model, False, whole / speed.max(), moving, first)


def opening_rows(model: Model) -> sparse.csr_matrix:
    """Rows (k, 6 f) that give the opening speed of each corner from the twists of f free blocks.

    Velocities are relative to the size of each block. Corners between two fixed blocks are omitted.
    """
    assembly, contacts = model.assembly, model.contacts
    place = np.full(len(assembly), -1, dtype=np.intp)
    place[assembly.free] = np.arange(len(assembly.free))
    corner = np.flatnonzero(model.active[contacts.interface])
    joint = contacts.interface[corner]
    normal = contacts.frame[joint, 0]
    row, column, value = [], [], []
    for side, sign in ((contacts.block_b[joint], 1.0), (contacts.block_a[joint], -1.0)):
        size = assembly.size[side][:, None]
        arm = (contacts.point[corner] - assembly.centroid[side]) / size
        entries = sign * np.column_stack([normal, np.cross(arm, normal)]) * size
        some = np.flatnonzero(place[side] >= 0)
        row.append(np.repeat(some, 6))
        column.append((6 * place[side[some]][:, None] + np.arange(6)).ravel())
        value.append(entries[some].ravel())
    scale = float(assembly.size.mean())
    return sparse.csr_matrix(
        (np.concatenate(value) / scale, (np.concatenate(row), np.concatenate(column))),
        shape=(len(corner), 6 * len(assembly.free)),
    )


def _alone(model: Model, block: int) -> bool:
    """Whether the joints with all other blocks block every motion of one block."""
    here = np.ones(len(model.assembly), dtype=bool)
    joints = Joints.of(model.contacts, block, here)
    body = model.assembly.blocks[block]
    return free_twists(joints.rows(body)).blocked


def _opening(rows: sparse.csr_matrix) -> Floats | None:
    """A motion that opens some corners and closes none; None where there is none."""
    count, size = rows.shape
    if not count:
        return np.ones(size)
    # openings are between zero and one
    program = ProgramBuilder()
    motion = program.variable("motion", size, quadratic=1e-9)
    opening = program.variable("opening", count, linear=-1.0)
    program.at_most("speed", np.zeros(count), (motion, -rows), (opening, 1.0))
    program.at_most("largest opening", np.ones(count), (opening, 1.0))
    program.at_most("least opening", np.zeros(count), (opening, -1.0))
    found = program.build().solve()
    if found.status is not ConicStatus.SOLVED:
        raise SolverError("the linear program of interlocking was not solved")
    speed = found.x[motion.place]
    opened = float(np.minimum(rows @ speed, 1.0).sum())
    return speed if opened > OPENS * count else None


def _sliding(rows: sparse.csr_matrix) -> Floats | None:
    """A motion that slides along all joints and opens none; None where there is none."""
    gram = (rows.T @ rows).toarray()
    if not len(gram):
        return None
    square, vector = np.linalg.eigh(gram)
    return vector[:, 0] if square[0] < SLIDES * max(square[-1], 1e-300) else None


@dataclass(frozen=True, eq=False)
class GravityRegion(OneLine):
    """The directions of gravity in which an assembly stands.

    Attributes
    ----------
    model
    direction : (g, 3) unit
        Directions of gravity.
    frictionless : (g,)
        Whether there are contact forces in equilibrium without friction.
    balanced : (g,)
        Whether there are contact forces in equilibrium with the friction of the model.
    stands : (g,) or None
        Whether the verdict of :func:`drystone.check` is STABLE; None if not requested.
    """

    model: Model
    direction: Floats
    frictionless: Bools
    balanced: Bools
    stands: Bools | None = None

    @property
    def shares(self) -> dict[str, float]:
        """Share of the directions for each of the three questions."""
        out = {
            "frictionless": float(self.frictionless.mean()),
            "balanced": float(self.balanced.mean()),
        }
        return out if self.stands is None else out | {"stands": float(self.stands.mean())}


@checked_call
def gravity_region(
    given: Given,
    key: int | str | Sequence[int | str] | None = None,
    *,
    directions: int | Floats = 200,
    stands: bool = False,
    executor: Workers | None = None,
    progress: Progress | None = None,
    stop: Stop | None = None,
    time_limit_s: float = float("inf"),
    **how: Unpack[How],
) -> GravityRegion:
    """The directions of gravity in which an assembly holds, without and with friction.

    Ended early, the result has the first directions, at least one.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    key
        The block or blocks that are held; the supports of the model when left out.
    directions
        Number of directions, evenly spread over the sphere, or the directions (g, 3).
    stands
        Whether to compute the full verdict too. It takes longer.

    Examples
    --------
    >>> from drystone.models import tower
    >>> down = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.5, 0.0, -1.0]])
    >>> found = gravity_region(tower(2), directions=down, friction=0.6)
    >>> found.frictionless.tolist(), found.balanced.tolist()
    ([True, False, False], [True, False, True])
    """
    model = as_model(given, **how)
    if key is not None:
        model = model.with_supports([key] if isinstance(key, int | str) else list(key))
        if not model.assembly.fixed.any():
            raise InputError(
                "no block is held", where="key", remedy="name a block, or leave it out"
            )
    unit = _unit_directions(directions)
    jobs = [(model, tuple(one), stands) for one in unit.tolist()]
    found: list[tuple[bool, bool, bool]] = []
    clock = Clock(time_limit_s, stop)
    with WorkerPool(executor) as pool:
        for answer in pool.answers(_held, jobs, lambda: bool(found) and clock.late()):
            found.append(answer)
            if progress is not None:
                progress("directions", len(found), len(jobs))
    table = np.array(found, dtype=bool).reshape(-1, 3)
    unit = unit[: len(found)]
    return GravityRegion(model, unit, table[:, 0], table[:, 1], table[:, 2] if stands else None)


def _unit_directions(directions: int | Floats) -> Floats:
    """Unit directions (g, 3): so many, or those given."""
    if isinstance(directions, int):
        if directions < 1:
            raise InputError(f"{directions} directions", remedy="give one or more")
        return _spread(directions)
    given = np.asarray(directions, dtype=np.float64).reshape(-1, 3)
    length = np.linalg.norm(given, axis=1, keepdims=True)
    if not (len(length) and np.isfinite(length).all() and (length > 0.0).all()):
        raise InputError("a direction is zero or not finite", where="directions")
    unit: Floats = given / length
    return unit


def _held(job: tuple[Model, tuple[float, float, float], bool]) -> tuple[bool, bool, bool]:
    model, direction, full = job
    pull = LoadCase.gravity(model.assembly, 9.81, direction=direction)
    loaded = model.with_load(pull)
    smooth = _balances(loaded.with_friction(0.0))
    rough = smooth or _balances(loaded)
    return smooth, rough, full and rough and check(loaded).stable


def _balances(model: Model) -> bool:
    found = solve_rbe(model, options=RBEOptions.feasibility())
    return found.verdict is Verdict.EQUILIBRIUM_EXISTS


def _spread(count: int) -> Floats:
    """Directions (count, 3) spread evenly over the sphere: a spiral of equal areas."""
    step = np.arange(count) + 0.5
    height = 1.0 - 2.0 * step / count
    turn = np.pi * (1.0 + np.sqrt(5.0)) * step
    across = np.sqrt(1.0 - height**2)
    return np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
