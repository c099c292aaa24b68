"""SupportResponse: forces and opening joints when supports move, and whether blocks follow.

To first order, compliant blocks whose supports move are a convex program per step of a fixed
point::

    minimise  1/2 f' C f + d0 . f   subject to   A f = -p,  fn >= 0,  |ft| <= g

C is the compliance of the corners and d0 the displacement there due to the supports. The
multiplier q of equilibrium is the motion of the blocks, and ``d = A'q + d0`` obeys
``fn (d_n + C fn) = 0``, ``d_n + C fn >= 0``, friction against the slide and no dilatancy. Coulomb's
law is the fixed point ``g = mu fn``. Source: Panagiotopoulos 1975 (the fixed point); Haslinger,
Hlavacek and Necas 1996.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Unpack

import numpy as np
from scipy import sparse

from drystone.answer import (
    Answer,
    Layer,
    LayerKind,
    Role,
    Scene,
    SceneStage,
    Sentence,
)
from drystone.answer.chart import Chart
from drystone.answer.drawing import areas, enlargement, seen, state_of
from drystone.assembly import Assembly
from drystone.base.arrays import Bools, Floats, Ints, lengths
from drystone.base.errors import InputError, counted
from drystone.base.settings import Clock, Options, checked_call
from drystone.base.table import Table
from drystone.base.units import quantity
from drystone.checks import block_speed, check_forces, corner_motion
from drystone.contacts import Contacts
from drystone.geometry.frames import rotations
from drystone.io.opening import Given, LongHow, as_model
from drystone.mechanics.bodies import LEAST_AREA
from drystone.mechanics.statics import Statics, build_statics
from drystone.model import Model
from drystone.results import Residuals, Result, Verdict
from drystone.settlement.large_displacement import move_supports
from drystone.settlement.large_types import End, LargeDisplacement
from drystone.settlement.path import support_motion
from drystone.solvers.program import ConicProgram, ConicSolution, ConicStatus, ProgramBuilder

CHECKED = 1e-5
"""Largest residual of a state that is reported as standing, dimensionless: that of an interior
point on a problem whose compliance is small against the motion."""

STIFF, SOFT = 1e-6, 1e-3
"""Compliances that are tried one after the other. Measured: an arch of 60 that spreads opens at its
haunches by 3.94 mm as by hand, and by 0.60 mm with the soft one, which takes the rest into springs
that press. Friction was not met in 18 of 32 questions with the stiff one, most of vaults, domes and
walls, and in 4 with the soft one."""

STEPS = 10
"""Of the stiff one. Measured: 16 of 20 questions of arches and bridges took so many at most, all of
vaults, domes and walls were left after 60, for 5 s."""

LARGE = 0.1
"""Motion of a support by the mean size of a free block from which on the answer is that of finite
steps. Chosen."""


@dataclass(frozen=True)
class SupportResponseOptions(Options):
    """Options of :func:`support_response`.

    Attributes
    ----------
    compliance : > 0, < inf
        Overlap of a corner under the mean weight of a block, relative to the largest motion of a
        support. Small for stiff blocks. Left out, 1e-6, or 1e-3 where friction is not met with it.
    step_limit : >= 1
        Largest number of steps of the fixed-point iteration for Coulomb's law.
    """

    compliance: float | None = None
    step_limit: int = 60


@dataclass(frozen=True, eq=False)
class SupportResponse(Answer):
    """Answer to a motion of supports: to first order, and of blocks that follow by finite steps.

    Where blocks fall on the way, or the motion is large beside them, all of it is of finite steps.

    Attributes
    ----------
    result
        Forces and displacements; those of the supports are the prescribed ones. Of what falls, the
        last ones before. Of finite steps its model is where the blocks are then.
    before
        The same model before its supports move, by the same method.
    followed
        The blocks that follow; ``None`` where no forces balance the loads.
    """

    result: Result
    before: Result
    followed: LargeDisplacement | None = None
    _soft: bool = False
    _OPENS, _SLIDES = 0.005, 0.05

    @cached_property
    def size(self) -> float:
        """[m], largest motion of a support."""
        return _size(self.model)

    def _by_steps(self, followed: LargeDisplacement | None) -> bool:
        """Whether a small motion is that of finite steps: soft springs took much of it."""
        return self._soft and followed is not None and followed.end is End.REACHED

    @cached_property
    def _apart(self) -> Floats:
        moved, contacts = self.result.displacement, self.contacts
        motion = _motion_of(self.model) if moved is None else moved
        if self._steps is None and not self._by_steps(self.followed):
            loose = Assembly(self.assembly.blocks)  # moving supports are free in the kinematics
            return corner_motion(loose, contacts, motion)
        way = np.subtract(*_carried(self.model, motion)[::-1])
        back = rotations(-motion[:, 3:])[contacts.block_a]
        axes = (contacts.frame @ back)[contacts.interface]
        return np.asarray((axes @ way[:, :, None])[:, :, 0])

    @property
    def opening(self) -> Floats:
        """(k,) [m], at the corners; negative in compression."""
        return self._apart[:, 0]

    @property
    def slide(self) -> Floats:
        """(k,) [m], at the corners."""
        return lengths(self._apart[:, 1:])

    def open_joints(self, share: float = _OPENS) -> Ints:
        """Interfaces with a corner that opens by more than a share of the support's motion.

        A tenth of the default counts no joint more of ten arches and bridges; ten times it missed
        all four of one whose pier goes down.

        Joints between two supports carry nothing and are omitted, here and in ``sliding_joints``.
        """
        opened = self._between_blocks() & (self.opening > share * self.size)
        return np.unique(self.result.contacts.interface[opened])

    def sliding_joints(self, share: float = _SLIDES) -> Ints:
        """Interfaces in compression that slide by more than a share of the support's motion."""
        moving = (self.slide > share * self.size) & (self.opening <= share * self.size)
        return np.unique(self.result.contacts.interface[self._between_blocks() & moving])

    def _between_blocks(self) -> Bools:
        """Corners (k,) of joints that have a free block."""
        contacts, fixed = self.result.contacts, self.result.assembly.fixed
        both: Bools = fixed[contacts.block_a] & fixed[contacts.block_b]
        return ~both[contacts.interface]

    def change(self) -> Floats:
        """Change of the force of each interface on its block b, (m, 3) [N], world axes.

        Raises
        ------
        InputError
            There are no forces before or after.
        """
        if self.before.force is None or self.result.force is None:
            raise InputError("there are no forces to compare", remedy="see whether it stands")
        return self.result.resultants.force - self.before.resultants.force

    @cached_property
    def model(self) -> Model:
        """The model, with its supports in their places."""
        return self.before.model.with_load(self.result.model.load)

    @property
    def _steps(self) -> LargeDisplacement | None:
        """What is told in place of the answer to first order."""
        falls = self.followed is not None and self.followed.end is End.FALLS
        return self.followed if falls or _is_large(self.model) else None

    @property
    def title(self) -> str:
        """How many joints open, or how far it was followed."""
        if self._steps is not None:
            return self._steps.title
        if not self.result.stable:
            return self.result.title
        count = len(self.open_joints())
        by = f", by up to {quantity(self._widest, 'm')}" if count else ""
        return f"Settled: {counted(count, 'joint')} open{'s' if count == 1 else ''}{by}"

    @property
    def _widest(self) -> float:
        return float(self.opening[self._between_blocks()].max(initial=0.0))

    def sentences(self) -> Sequence[Sentence]:
        """Whether it stands with its supports moved, what moved, and what opens and slides."""
        if self._steps is not None:
            return self._steps.sentences()
        result = self.result
        word = "SETTLED" if result.stable else result.verdict.upper()
        said = [Sentence(word, Role.of(result.verdict)), Sentence(result.message)]
        for i in self._moved:
            move, turn = np.split(_motion_of(self.model)[i], 2)
            told = f"moved: {self.assembly.names[i]} by {_listed(move)} m"
            told += f", turned by {_listed(np.rad2deg(turn))} degrees" if turn.any() else ""
            said.append(Sentence(told))
        return said + self._joints_told() if self._known else said

    def _joints_told(self) -> list[Sentence]:
        opened, slid = len(self.open_joints()), len(self.sliding_joints())
        least, widest = (quantity(x, "m") for x in (self._OPENS * self.size, self._widest))
        opens, slides = (f"{100.0 * one:g} %" for one in (self._OPENS, self._SLIDES))
        told = f"joints that open: {opened or 'none'} by more than {least}, {opens} of the"
        slid_told = f"joints that slide: {slid or 'none'} by more than {slides} of it"
        remarks = [
            "to first order openings grow as the motion does; --to LENGTH follows a large one"
        ]
        if opened > 1:
            remarks.append("neighbouring joints may share an opening otherwise than here")
        if self.followed is not None and self.followed.code:
            remarks.append(f"to first order; followed by finite steps: {self.followed.title}")
        said = [Sentence(f"{told} motion; the widest by {widest}"), Sentence(slid_told)]
        return said + [Sentence(one, Role.REMARK) for one in remarks]

    @property
    def _moved(self) -> list[int]:
        return np.flatnonzero(np.abs(_motion_of(self.model)).max(axis=1)).tolist()

    @property
    def _known(self) -> bool:
        return self.result.force is not None and self.before.force is not None

    def tables(self) -> Sequence[Table]:
        """Joints that open and slide; forces of supports and joints before and after."""
        if self._steps is not None:
            return self._steps.tables()
        if not self._known:
            return []
        contacts, names = self.contacts, np.array(self.assembly.names)
        a, b = names[contacts.block_a], names[contacts.block_b]
        made = []
        for title, distance, where in (
            ("open", self.opening, self.open_joints()),
            ("sliding", self.slide, self.sliding_joints()),
        ):
            most = np.full(contacts.count, -np.inf)
            np.maximum.at(most, contacts.interface, distance)
            rows = where[np.argsort(-most[where])]
            columns = {"block_a": a[rows], "block_b": b[rows], "interface": rows,
                       "distance": most[rows]}  # fmt: skip
            made.append(Table(title, columns, {"distance": "m"}))
        fixed = np.flatnonzero(self.assembly.fixed)
        was, now = support_forces(self.before)[fixed], support_forces(self.result)[fixed]
        rows = np.argsort(-np.linalg.norm(now - was, axis=1))
        columns = {"block": names[fixed][rows], "before": was[rows], "after": now[rows]}
        made.append(Table("supports", columns, {"before": "N", "after": "N"}))
        change = self.change()
        rows = np.flatnonzero(self.model.active)
        rows = rows[np.argsort(-np.linalg.norm(change[rows], axis=1))]
        first, last = self.before.resultants, self.result.resultants
        columns = {
            "block_a": a[rows],
            "block_b": b[rows],
            "interface": rows,
            "normal_before": first.normal[rows],
            "normal": last.normal[rows],
            "tangential_before": first.tangential[rows],
            "tangential": last.tangential[rows],
            "change": change[rows],
        }
        units = dict.fromkeys(list(columns)[3:], "N")
        return [*made, Table("joints", columns, units)]

    def table(self) -> Table:
        """The first table; of finite steps, the curve."""
        return super().table() if self._steps is None else self._steps.table()

    def numbers(self) -> Mapping[str, Any]:
        """The verdict, and what moved; of finite steps, the curve and the positions too."""
        motion, names = _motion_of(self.model), self.assembly.names
        return {
            "verdict": self.result.verdict,
            "method": self.result.method,
            "message": self.result.message,
            "motion": [
                {"block": names[i], "translation": motion[i, :3], "rotation": motion[i, 3:]}
                for i in self._moved
            ],
            "residuals": self.result.residuals,
            **({} if self._steps is None else self._steps.numbers()),
        }

    def layers(self) -> Scene:
        """The forces before and after, and the motion, enlarged; or that of finite steps."""
        if self._steps is not None:
            return self._steps.layers()
        after = self.result.stage("after")
        motion = self.result.displacement
        if motion is not None:
            after = replace(
                after,
                headline=self.title,
                message=f"{after.message}; the motion is enlarged",
                motion=seen(self.assembly, motion),
                motion_name="Settlement, enlarged",
                layers=(*after.layers, *self._openings()),
            )
        stages = after, self.before.stage("before")
        title = f"drystone: {after.headline.lower()}"
        return Scene(self.assembly, self.contacts, stages, title, self._facts())

    def figure(self) -> Scene | Chart:
        """The blocks moved, enlarged, so that it shows which joints open; or the curve."""
        if self._steps is not None:
            return self._steps.figure()
        motion = self.result.displacement
        if motion is None:
            return self.layers()
        factor = enlargement(self.assembly, motion)
        message = f"{self.result.message}; the motion is drawn {factor:.3g} times as large"
        stage = SceneStage(
            "after", self.title, message, state_of(self.assembly),
            Role.of(self.result.verdict), layers=self._hinges(factor * motion, factor),
        )  # fmt: skip
        moved, title = self.assembly.moved(factor * motion), f"drystone: {self.title.lower()}"
        facts = self._facts()
        return Scene(moved, Contacts.empty(), (stage,), title, facts, preset="solid")

    def _hinges(self, motion: Floats, factor: float) -> tuple[Layer, ...]:
        """Marks on the moved blocks where joints that open stay closed."""
        corners = self.contacts.corners
        closed = self.opening <= self._OPENS * self.size
        joint = np.intersect1d(self.open_joints(), np.flatnonzero(corners.any(closed)))
        if len(joint) == 0:
            return ()
        point = np.where(closed[:, None], _carried(self.model, motion)[1], 0.0)
        at = corners.sum(point)[joint] / corners.sum(closed)[joint, None]
        label = f"turns about an edge; the motion is drawn {factor:.3g} times as large"
        return (Layer("hinges", label, LayerKind.MARKERS, "hinge", at),)

    def _facts(self) -> dict[str, str]:
        names = ", ".join(self.assembly.names[i] for i in self._moved)
        told = f"{names}, by at most {self.size:.3g} m"
        return {**self.asked.facts(), "Supports that move": told}

    def _openings(self) -> tuple[Layer, ...]:
        opens = np.isin(np.arange(self.contacts.count), self.open_joints())
        gaps, _ = areas(self.contacts, opens)
        if gaps is None:
            return ()
        label, kind = "joints that open", LayerKind.POLYGONS
        return (Layer("opening", label, kind, "help", gaps.point, start=gaps.start),)


def _listed(vector: Floats) -> str:
    return ", ".join(f"{value + 0.0:g}" for value in vector)


def support_forces(result: Result) -> Floats:
    """The force (n, 3) [N] of each fixed block on the free ones; zero for free blocks.

    Parameters
    ----------
    result
        Of a check, with forces.
    """
    assembly, contacts = result.assembly, result.contacts
    force = result.resultants.force
    total = np.zeros((len(assembly), 3))
    np.add.at(total, contacts.block_a, force)
    np.subtract.at(total, contacts.block_b, force)
    return np.where(assembly.fixed[:, None], total, 0.0)


@checked_call
def support_response(
    given: Given,
    motion: Mapping[int | str, Any] | None = None,
    *,
    options: SupportResponseOptions | None = None,
    **how: Unpack[LongHow],
) -> SupportResponse:
    """Forces and joint openings due to motions of supports, and whether the blocks follow.

    Small motions are answered to first order, for stiff, compliant blocks, and all are followed by
    finite steps as by :func:`move_supports`.

    Parameters
    ----------
    given
        A model; or an assembly or a file that ``how`` turns into one.
    motion
        Per fixed block its translation [m] (3,), or translation and rotation [m, rad] (6,) about
        its centroid; world axes. Other supports do not move. It is added to the motion in the load
        (:meth:`drystone.LoadCase.settlement`).
    options

    Raises
    ------
    InputError
        A block that is not fixed, nothing that moves, nothing that loads the free blocks, or joints
        that carry more than friction.

    Examples
    --------
    A plank on three supports loses contact with the middle one when that moves down:

    >>> import drystone
    >>> from drystone.settlement import support_response
    >>> from drystone.models import box
    >>> feet = [box((0.2, 1.0, 0.2), (x, 0.0, 0.0), n) for n, x in zip("abc", (0.0, 1.9, 3.8))]
    >>> plank = box((4.0, 1.0, 0.2), (0.0, 0.0, 0.2), "plank")
    >>> assembly = drystone.Assembly((*feet, plank)).with_fixed(list("abc"))
    >>> model = drystone.Model.of(assembly)
    >>> settled = support_response(model, {"b": (0.0, 0.0, -0.01)})
    >>> [assembly.names[model.contacts.block_a[i]] for i in settled.open_joints()]
    ['b']
    """
    clock = Clock.of(how)
    model = as_model(given, **how)
    motions = support_motion(model, motion)
    if motions is None or not motions.any():
        raise InputError("no support moves", remedy="give a motion")
    model = model.with_load(replace(model.load, motion=motions))
    first = None if _is_large(model) else first_order(model, options)
    if first is not None and not first.result.stable:
        return first
    followed = move_supports(model, **clock.rest)
    states, told = followed.states, (followed.end.verdict, followed.message, followed.stopped)
    if first is not None and followed.end is not End.FALLS:
        if not first._by_steps(followed):
            return replace(first, followed=followed, stopped=followed.stopped)
        told = first.result.verdict, first.result.message, followed.stopped
    stood = (Verdict.STABLE, "the supports have not moved") if len(states) > 1 else told
    still = model.with_load(replace(model.load, motion=None))
    last, before = states[-1], states[0].result(still, *stood)
    after = last.result(last.placed(model), *told)
    soft = first is not None
    if soft and after.force is not None:
        after = replace(after, residuals=check_forces(after.model, after.force))
    return SupportResponse(after, before, followed, soft, stopped=followed.stopped)


def first_order(model: Model, options: SupportResponseOptions | None = None) -> SupportResponse:
    """The answer to the motion of supports in the load, to first order alone.

    What is not listed here is as in :func:`support_response`.
    """
    model.require_ends_as_drawn("the answer to small motions")
    model.require_dry("the answer to small motions", "an open joint would pull on")
    chosen, motion = SupportResponseOptions.of(options), _motion_of(model)
    state, free = partial(_state, model, chosen), chosen.compliance is None
    used = chosen.compliance or STIFF, min(STEPS, chosen.step_limit) if free else chosen.step_limit
    after = state(motion, *used)
    soft = free and not after.stable
    if soft:
        used = SOFT, chosen.step_limit
        after = state(motion, *used)
    return SupportResponse(after, state(np.zeros_like(motion), *used), _soft=soft)


def _motion_of(model: Model) -> Floats:
    """(n, 6) [m, rad] of the supports."""
    motion = model.load.motion
    return np.zeros((len(model), 6)) if motion is None else motion


def _carried(model: Model, motion: Floats) -> Floats:
    """(2, k, 3) [m] each corner where blocks a and b carry it that move by (n, 6)."""
    block = model.contacts.corner_blocks
    centre, move = model.assembly.centroid[block], motion[block]
    arm = rotations(motion[:, 3:])[block] @ (model.contacts.point - centre)[..., None]
    return np.asarray(centre + move[..., :3] + arm[..., 0])


def _size(model: Model) -> float:
    """[m], largest motion of a support."""
    return float(block_speed(model.assembly, _motion_of(model)).max())


def _is_large(model: Model) -> bool:
    """Whether the motion of supports is no small one beside the free blocks."""
    free = model.assembly.free
    return bool(_size(model) * len(free) > LARGE * model.assembly.size[free].sum())


def _state(
    model: Model, chosen: SupportResponseOptions, prescribed: Floats, compliance: float, steps: int
) -> Result:
    """Forces and motions under a prescribed motion (n, 6) of the supports, or before it."""
    size = _size(model)
    assembly, contacts, load = model.assembly, model.contacts, model.load
    began = time.perf_counter()
    active = model.active
    part = contacts.select(active)
    statics = build_statics(Model(assembly, part, replace(load, motion=None)))
    if not statics.load.any():
        raise InputError("nothing loads the free blocks", remedy="add their weight")
    loose = Assembly(assembly.blocks)  # moving supports are free in the kinematics
    imposed = corner_motion(loose, part, prescribed) / size
    scaled, motion, raw, defect = _solved(statics, imposed, compliance, steps)
    moved = prescribed + statics.physical_motion(motion, len(assembly), size)
    force = np.zeros((contacts.corner_count, 3))
    force[active[contacts.interface]] = statics.physical_force(scaled)
    solved = raw.status is ConicStatus.SOLVED
    residuals, verdict, message = None, Verdict.UNDECIDED, raw.message
    if raw.status is ConicStatus.INFEASIBLE:
        message = "no contact forces were found that balance the loads; see whether it stands"
    if solved:
        residuals = _residuals(model, force, moved)
        message = f"Coulomb friction is met to {defect:.1e} of the mean load only"
        if residuals.largest <= CHECKED:
            verdict = Verdict.STABLE
            follow = "the blocks follow the supports and come to rest"
            message = follow if prescribed.any() else "the supports have not moved"
    return Result(
        method="settlement",
        verdict=verdict,
        model=model if prescribed.any() else model.with_load(replace(load, motion=None)),
        message=message,
        force=force if solved else None,
        displacement=moved if solved else None,
        residuals=residuals,
        options=chosen,
        solver=raw.solver,
        iterations=raw.iterations,
        time_s={"solve": time.perf_counter() - began},
    )


def _residuals(model: Model, force: Floats, moved: Floats) -> Residuals:
    """Equilibrium of the free blocks, and contact conditions with the supports in motion."""
    at_rest = check_forces(model, force)
    loose = replace(model, assembly=Assembly(model.assembly.blocks))
    following = check_forces(loose, force, moved)
    return replace(following, equilibrium=at_rest.equilibrium)


TANGENTIAL = 0.1
"""Tangential stiffness divided by normal stiffness. Chosen as in the search for a rest state."""


def _solved(
    statics: Statics, imposed: Floats, compliance: float, steps: int
) -> tuple[Floats, Floats, ConicSolution, float]:
    """Scaled forces and motion under the loads of ``statics`` and a motion of the supports.

    Parameters
    ----------
    statics
    imposed : (k, 3)
        Displacement of b against a at each corner that the supports impose, local n, u, v, by the
        unit of displacement.
    compliance, steps
        As in the options.

    Returns
    -------
    force : (k, 3)
    motion : (n, 6) of the free blocks
    raw
        Its iterations are those of the fixed point.
    defect
        Largest excess of friction over ``mu fn`` or change of the bound, by the mean load.
    """
    k = statics.corner_count
    softness = compliance / np.maximum(statics.tributary, LEAST_AREA)
    diagonal = np.stack([softness, softness / TANGENTIAL, softness / TANGENTIAL], axis=1)
    costs = {"linear": imposed.ravel(), "quadratic": diagonal.ravel()}
    program = _program(statics, np.zeros(k), costs)
    friction = program.rows["friction"]
    bounds = slice(friction.start, friction.stop, 3)
    right = program.right.copy()
    bound = _associative(statics, costs)
    relaxation, last, defect = 1.0, float("inf"), float("inf")
    for step in range(1, steps + 1):  # noqa: B007 - counted
        right[bounds] = bound
        raw = replace(program, right=right).solve()
        if raw.status is not ConicStatus.SOLVED:
            break
        target = statics.friction * np.maximum(0.0, raw.x.reshape(k, 3)[:, 0])
        defect = float(np.abs(target - bound).max(initial=0.0))
        if defect <= 1e-7:  # by the mean load
            break
        relaxation = max(0.1, 0.5 * relaxation) if defect > last else min(1.0, 1.2 * relaxation)
        last = defect
        bound = bound + relaxation * (target - bound)
    motion = raw.z[program.rows["equilibrium"]].reshape(-1, 6)
    return raw.x.reshape(k, 3), motion, replace(raw, iterations=step), defect


def _program(statics: Statics, coupling: Floats, costs: Mapping[str, Any]) -> ConicProgram:
    """Forces in equilibrium with friction of at most ``coupling`` times the normal force."""
    k = statics.corner_count
    one = sparse.identity(k, format="csr")
    axis = np.zeros((3, 3))
    axis[0, 0] = -1.0
    slide = sparse.kron(one, np.diag([0.0, -1.0, -1.0]))
    program = ProgramBuilder()
    force = program.variable("force", 3 * k, **costs)
    program.equal("equilibrium", -statics.load.ravel(), (force, statics.matrix))
    program.at_most("no pull", np.zeros(k), (force, sparse.kron(one, np.array([[-1.0, 0.0, 0.0]]))))
    bound = sparse.kron(sparse.diags(coupling), axis)
    program.cone("friction", 3, np.zeros(3 * k), (force, bound + slide))
    return program.build()


def _associative(statics: Statics, costs: Mapping[str, Any]) -> Floats:
    """A first bound (k,) on friction: that of joints that open when they slide."""
    raw = _program(statics, statics.friction, costs).solve()
    if raw.status is not ConicStatus.SOLVED:
        return np.zeros(statics.corner_count)
    return statics.friction * np.maximum(0.0, raw.x.reshape(-1, 3)[:, 0])
