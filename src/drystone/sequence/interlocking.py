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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np
from scipy import sparse

from drystone.answer import Answer, Role, Scene, Sentence
from drystone.answer.drawing import bare_scene, seen
from drystone.base.arrays import SAME, Floats, places
from drystone.base.declared import Offered
from drystone.base.display import named
from drystone.base.errors import InputError, SolverError, counted
from drystone.io.opening import Given, How, as_model
from drystone.model import Model
from drystone.sequence.freedom import Joints, free_twists
from drystone.solvers.program import ConicStatus, ProgramBuilder

SLIDES = 1e-7
"""Squares of singular values of B below this share of the largest are zero. Chosen: well above
rounding."""


@dataclass(frozen=True, eq=False)
class Interlocking(Answer):
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

    @property
    def title(self) -> str:
        """Whether it interlocks."""
        return "Interlocks" if self.holds else "Does not interlock"

    def sentences(self) -> Sequence[Sentence]:
        """Whether it interlocks, and what can move."""
        if self.holds:
            told = "no motion opens its joints or slides along them: it carries every load"
            return [Sentence(self.title, Role.GOOD), Sentence(told)]
        alone = f"blocks that can move alone: {named(self.names) or 'none'}"
        told = f"{counted(len(self.moving), 'block')} can move together without friction"
        return [Sentence(self.title, Role.BAD), Sentence(told), Sentence(alone)]

    def layers(self) -> Scene:
        """The free motion."""
        scene = bare_scene(self.assembly, self.contacts, self.model)
        motion = None if self.motion is None else seen(self.assembly, self.motion)
        told = "; ".join(one.text for one in self.sentences()[1:])
        stage = replace(
            scene.stages[0], headline=self.title, message=told, motion=motion,
            motion_name="Free motion", plays=motion is not None,
        )  # fmt: skip
        return replace(scene, title=self.title, stages=(stage,))

    def numbers(self) -> Mapping[str, Any]:
        """Whether it holds, what moves, and how."""
        names = self.assembly.names
        return {
            "holds": self.holds,
            "moving": [names[block] for block in self.moving],
            "can_move_alone": self.names,
            "motion": self.motion,
        }


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
    model.require_ends_as_drawn("a search for motions")
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
    place = places(assembly.free, len(assembly))
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
    return speed if opened > SAME * count else None


def _sliding(rows: sparse.csr_matrix) -> Floats | None:
    """A motion that slides along all joints and opens none; None where there is none."""
    gram = (rows.T @ rows).toarray()
    if not len(gram):
        return None
    square, vector = np.linalg.eigh(gram)
    return vector[:, 0] if square[0] < SLIDES * max(square[-1], 1e-300) else None


OFFERED = Offered(interlocking, "arch.json --supports springer-left,springer-right", names=())
