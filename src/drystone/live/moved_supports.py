"""Supports that move: the answer to first order, blocks followed by finite steps, and mends."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from drystone.answer import Role
from drystone.base import units
from drystone.base.arrays import SAME, Floats, cross, marked
from drystone.base.errors import counted
from drystone.base.settings import Progress
from drystone.design import DesignMargin, MendOptions
from drystone.live.wish import Found, WishedModel
from drystone.mechanics.bodies import build_bodies
from drystone.mechanics.corners import CARRIER, Carrier
from drystone.mechanics.drive import Driver
from drystone.mechanics.follow import Bounds
from drystone.mechanics.meeting import Apart, followed_model
from drystone.model import Model
from drystone.results import Result, Verdict
from drystone.settlement import (
    End,
    LargeDisplacement,
    LargeState,
    SettlementOptions,
    move_supports,
)
from drystone.settlement.first_order import first_order
from drystone.settlement.large_displacement import large_state
from drystone.settlement.path import scaled_motion
from drystone.stability import check
from drystone.view import LayerKind, SceneStage, State

MOST_AT_ONCE = 50
"""Blocks of which the answer to first order is given at once. Measured: 0.04 s for an arch of 30
blocks, 7 s for a vault of 97."""
_COARSE_S = 0.04
"""[s] after which no coarse increment of more blocks is begun: the first answer of 100 blocks comes
within 0.1 s."""
_MOTION = "Motion of the supports"
FORCE = "force of the blocks on the moving supports, along their motion"


def at_once(model: Model, steps: CoarseSteps | None = None, before: Floats | None = None) -> Found:
    """The answer to first order; of many blocks, that of few coarse increments.

    Parameters
    ----------
    model
        Its load moves supports.
    steps
        The same model at rest, of more than ``MOST_AT_ONCE`` blocks.
    before : (n, 6) [m, rad]
        Motion of supports and blocks when they were followed last. Where no coarse increment is
        found, blocks are shown in proportion to it.
    """
    if len(model) > MOST_AT_ONCE:
        return _coarsely(model, steps, before)
    found = first_order(model)
    result, size = found.result, units.quantity(found.size, "m")
    if result.displacement is None:
        headline = f"Supports moved by {size}: no first-order answer; it is being followed"
        return Found(result, replace(result.stage("live"), headline=headline, role=None))
    joints = counted(len(found.open_joints()), "joint")
    headline = f"Supports moved by {size}: {joints} open to first order; it is being followed"
    made = _moved(result, _carried(model, result.displacement), result.displacement[None])
    return Found(result, replace(made, headline=headline, role=None), moved=True)


def _coarsely(model: Model, steps: CoarseSteps | None, before: Floats | None) -> Found:
    motion = model.load.motion
    found = None if steps is None or motion is None else steps.moved(motion, _COARSE_S)
    if found is None or motion is None:
        return _in_proportion(model, before)
    state, rests = found
    size = units.quantity(state.displacement, "m")
    yet = "" if rests else ", not at rest yet"
    seen = _on_the_way(model, state)
    headline = f"Supports moved by {size}, in coarse steps{yet}; it is being followed in fine ones"
    return replace(seen, stage=replace(seen.stage, headline=headline))


def _in_proportion(model: Model, before: Floats | None) -> Found:
    """Blocks as if they went on as they went before; where that is not known, supports alone."""
    motion = np.zeros((len(model), 6)) if model.load.motion is None else model.load.motion.copy()
    size = units.quantity(float(np.linalg.norm(motion[:, :3], axis=1).max()), "m")
    if before is not None:
        fixed = model.assembly.fixed
        old, new = before[fixed].ravel(), motion[fixed].ravel()
        share = float(old @ new) / max(float(old @ old), 1e-300)
        motion[~fixed] = share * before[~fixed]
    result = Result("settlement", Verdict.UNDECIDED, model, "the blocks are being followed")
    headline = f"Supports moved by {size}: the blocks are being followed"
    stage = replace(result.stage("live"), headline=headline, role=None, motion=motion,
                    motion_name=_MOTION)  # fmt: skip
    return Found(result, stage, moved=True)


def verdict_of(
    asked: WishedModel,
    *,
    stop: Callable[[], bool],
    progress: Progress | None = None,
    time_limit_s: float = float("inf"),
    watch: Callable[[Found], None] | None = None,
) -> Found:
    """The whole verdict of a load case; where supports move, of the blocks that follow them.

    ``watch`` is given the blocks while they follow.
    """
    moves = asked.motion is not None
    found = _followed(asked.moving, progress, stop, time_limit_s, watch) if moves else None
    if found is not None:
        return found
    found = Found.at_rest(
        check(asked.part, progress=progress, stop=stop, time_limit_s=time_limit_s)
    )
    if not moves:
        return found
    headline = f"{found.stage.headline}, before the supports move"
    return replace(found, stage=replace(found.stage, headline=headline))


def after_moving(model: Model, motion: Floats, stop: Callable[[], bool]) -> Result:
    """The verdict on a model whose supports move (n, 6) [m, rad], as a limit asks for it."""
    moving = model.with_load(replace(model.load, motion=motion))
    found = _followed(moving, None, stop, float("inf"), None)
    return check(model, stop=stop) if found is None else found.result


def follow(
    model: Model,
    *,
    stop: Callable[[], bool] | None,
    progress: Progress | None = None,
    seconds: float = float("inf"),
    watch: Callable[[LargeState], None] | None = None,
    pace: float = 1.0,
) -> LargeDisplacement | None:
    """Blocks that follow the motion in the load; None where they do not stand before.

    ``pace`` is the length of the increments, 1 by default.
    """
    found = move_supports(
        model, options=SettlementOptions(pace=pace), watch=watch, progress=progress, stop=stop,
        time_limit_s=seconds,
    )  # fmt: skip
    return None if len(found.displacement) < 2 and found.end is not End.STOPPED else found


def _followed(
    model: Model,
    progress: Progress | None,
    stop: Callable[[], bool],
    seconds: float,
    watch: Callable[[Found], None] | None,
) -> Found | None:
    """The blocks while the supports move; None where they do not stand before."""

    def seen(state: LargeState) -> None:
        if watch is not None:
            watch(_on_the_way(model, state))

    found = follow(model, watch=seen, progress=progress, stop=stop, seconds=seconds)
    if found is None:
        return None
    last = found.states[-1]
    result = last.result(model, found.end.verdict, f"{FORCE}: {found.message}", found.stopped)
    path = np.stack([one.positions for one in found.states])
    stage = _moved(result, last.placed(model), path)
    state = stage.state.copy()
    state[found.falling] = State.FALLING
    return Found(result, replace(stage, headline=found.title, state=state), moved=True)


def _on_the_way(model: Model, state: LargeState) -> Found:
    """The blocks before the supports have moved all their way."""
    result = state.result(model, Verdict.UNDECIDED, "the blocks are being followed")
    stage = _moved(result, state.placed(model), state.positions[None])
    far = units.quantity(state.displacement, "m")
    headline = f"Supports moved by {far} so far: the blocks are being followed"
    return Found(result, replace(stage, headline=headline, role=None), moved=True)


def _moved(result: Result, placed: Model, path: Floats) -> SceneStage:
    """The picture of blocks that have followed a path (s, n, 6), with the forces at its end.

    The page knows the interfaces of the model only: ``placed``, at the end, has no more.
    """
    # staged as one that stands: where it falls later, the forces are those before it falls
    stage = replace(result, model=placed, verdict=Verdict.STABLE).stage("live")
    layers = tuple(  # marks of a joint would be moved with its blocks once more
        replace(one, interface=None) if one.kind is LayerKind.MARKERS else one
        for one in stage.layers
    )
    return replace(
        stage, role=Role.of(result.verdict), motion=path[-1], path=path if len(path) > 1 else None,
        motion_name=_MOTION, layers=layers,
    )  # fmt: skip


def _carried(model: Model, motion: Floats) -> Model:
    """The model moved, its interfaces with both of their blocks by half, to first order."""
    contacts, centroid = model.contacts, model.assembly.centroid
    moved = np.zeros_like(contacts.point)
    for block in (contacts.block_a, contacts.block_b):
        of = block[contacts.interface]
        moved += motion[of, :3] + cross(motion[of, 3:], contacts.point - centroid[of])
    contacts = replace(contacts, point=contacts.point + 0.5 * moved)
    return replace(model, assembly=model.assembly.moved(motion), contacts=contacts)


class _Place(NamedTuple):
    """The blocks, and the motion (n, 6) of the supports that led there, scaled."""

    driver: Driver
    motion: Floats


class CoarseSteps:
    """A model at rest whose supports are moved again and again.

    Blocks that are apart may be in each other here: faces that may meet are sought for as long as
    everything else takes (1.1 s of 1.4 on a vault of 157 curved voussoirs), and blocks that are
    followed in fine increments have them.

    Parameters
    ----------
    model
    stop

    Raises
    ------
    InputError
        Joints carry more than friction.
    """

    def __init__(self, model: Model, stop: Callable[[], bool] | None = None) -> None:
        model.require_dry("moved supports", "what a joint carries after it has moved is not known")
        chosen = SettlementOptions()
        self.model = model.with_load(replace(model.load, motion=None))
        none = np.zeros(model.contacts.count, dtype=bool)
        self.apart = Apart(model.contacts.select(none), np.zeros((0, 2)))
        part, gap = followed_model(self.model, self.apart)
        carrier = CARRIER[model.ends] or Carrier.MOVING
        self.bodies = build_bodies(
            part, carrier, overlap=chosen.overlap, tangential=chosen.tangential, gap=gap
        )
        self.rest = self._rested(chosen, stop)
        self.last = self.rest

    def _rested(self, chosen: SettlementOptions, stop: Callable[[], bool] | None) -> _Place | None:
        """The blocks at rest; None where none was found."""
        bounds = Bounds(chosen.fall, step_limit=chosen.step_limit)
        driver = Driver(self.bodies, bounds, stop=stop)
        if not driver.rest_at_once():
            return None
        return _Place(driver, np.zeros((len(self.model), 6)))

    def moved(self, motion: Floats, seconds: float) -> tuple[LargeState, bool] | None:
        """Blocks and forces where supports have moved, and whether they rest; None: not found.

        They go on from where they were last, or from rest where that is nearer. No increment but
        the first is begun where ``seconds`` have passed.

        Parameters
        ----------
        motion : (n, 6) [m, rad]
        seconds
        """
        if self.rest is None or self.last is None:
            return None
        wanted = scaled_motion(self.bodies, motion)
        nearer = np.linalg.norm(wanted - self.last.motion) < np.linalg.norm(wanted)
        begin = self.last if nearer else self.rest
        driver, end = begin.driver.again(), time.monotonic() + seconds
        rests = driver.shift_at_once(wanted - begin.motion, lambda: time.monotonic() > end)
        if rests is None:
            return None
        self.last = _Place(driver, wanted)
        length = float(np.linalg.norm(motion[:, :3], axis=1).max())
        moment = driver.now()._replace(displacement=1.0, load=0.0)
        state = large_state(self.model, self.apart, self.bodies, moment, driver.met, length, 1.0)
        return state, rests


FOLLOWED_KINDS = tuple(kind for kind in MendOptions().kinds if kind != "glue")
"""What glue still carries in a joint that has moved is not known."""
_HASTE = 4.0
"""How much longer the increments of a quick look are. What it finds is followed once more in those
of the verdict. Chosen: it takes a quarter of the time."""


@dataclass(frozen=True)
class AfterMoving(DesignMargin):
    """A model is safe where it still stands after its supports have moved.

    Attributes
    ----------
    motion
        Translation and rotation vector (6,) [m, rad] of supports, by their names.
    """

    motion: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @classmethod
    def of_supports(cls, model: Model, motion: Floats) -> AfterMoving:
        """After a motion (n, 6) of the supports of a model."""
        names = model.assembly.names
        return cls(motion={names[i]: tuple(motion[i]) for i in np.flatnonzero(motion.any(axis=1))})

    def holds(
        self,
        model: Model,
        stop: Callable[[], bool] | None = None,
        *,
        settle: bool = True,
        near: list[dict[int, Floats]] | None = None,
    ) -> Result:
        """The answer after the motion; of what falls, of the blocks where they fall."""
        del settle, near  # the blocks are followed
        found = self._followed(model, stop, 1.0)
        if found is None:
            return check(model, stop=stop)
        if found.end is not End.FALLS:
            return Result(
                "settlement", found.end.verdict, model, found.message, stopped=found.stopped
            )
        there = moved_model(found)
        result = check(there, stop=stop)
        if result.falls:
            return result
        return Result("settlement", Verdict.UNSTABLE, there, found.message)

    def stands(
        self,
        model: Model,
        *,
        quick: bool = False,
        stop: Callable[[], bool] | None = None,
        near: list[dict[int, Floats]] | None = None,
    ) -> bool:
        """Whether a model stands after the motion; ``quick`` by longer increments."""
        found = self._followed(model, stop, _HASTE if quick else 1.0)
        if found is None:
            return super().stands(model, quick=quick, stop=stop, near=near)
        return found.end is End.REACHED

    def meets(self, result: Result) -> bool:
        """Whether it stands; there is one contact stiffness."""
        return result.stable

    def _followed(
        self, model: Model, stop: Callable[[], bool] | None, pace: float
    ) -> LargeDisplacement | None:
        """None where no support of the model moves, or nothing follows."""
        assembly = model.assembly
        motion = np.zeros((len(model), 6))
        for name, by in self.motion.items():
            if name in assembly and assembly.fixed[assembly.index(name)]:
                motion[assembly.index(name)] = by
        if not motion.any() or not len(assembly.free):
            return None
        moving = model.with_load(replace(model.load, motion=motion))
        return follow(moving, stop=stop, pace=pace)


def moved_model(found: LargeDisplacement) -> Model:
    """The blocks where they rest or fall, with their joints as far as these press there."""
    model, last = found.model, found.fallen or found.states[-1]
    normal, contacts = last.force[:, 0], last.contacts
    touches = normal > SAME * float(normal.max(initial=0.0))
    joint = marked(contacts.interface[touches], len(contacts))
    corner = touches[joint[contacts.interface]]
    some = contacts.select(joint)
    pressing = replace(some, point=some.point[corner], interface=some.interface[corner])
    pressing = replace(pressing, area=pressing.corners.sum(pressing.tributary))
    there = model.assembly.moved(last.positions)
    return replace(model, assembly=there, contacts=pressing, report=None)
