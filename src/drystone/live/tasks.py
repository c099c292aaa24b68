"""What a window asks for besides verdicts: the limit of a direction, mends, plans, files.

The jobs that come through a pipe, read by a thread that can interrupt the one under way.
"""

from __future__ import annotations

import contextlib
import ctypes
import itertools
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np

from drystone import io
from drystone.answer import plain
from drystone.base import units
from drystone.base.errors import InputError
from drystone.base.settings import Progress
from drystone.design import (
    Changed,
    CutOptions,
    MendOptions,
    cut_block,
    cut_until_free,
    find_mends,
    recut_joints,
)
from drystone.design.changed_model import acceleration_of, carried_load
from drystone.geometry.polyhedron import edges_of
from drystone.io.jsontext import Field
from drystone.limits import limit_tilt
from drystone.live.moved_supports import FOLLOWED_KINDS, AfterMoving, after_moving, verdict_of
from drystone.live.wish import Wish, WishedModel, asked
from drystone.loads import DOWN
from drystone.model import Model
from drystone.sequence import Order, Plan, PlanOptions, Rules, Status, plan
from drystone.view import scene_of
from drystone.view.encode import encode, to_text

_WITH_MOTION = "it stands with its supports moved: nothing is to be mended"
_MOST_CASES = 20
"""Load cases that one window compares."""

Event = tuple[str, dict[str, Any]]


@dataclass(eq=False)
class Work:
    """A task, and what it may use.

    Attributes
    ----------
    model
        Of the file, or mended.
    wish, asked
        The load case of the window, and its model.
    extra
        What the task is told beside the wish.
    stop, progress
    name
        Of the file.
    tell
        Sends an event before the task has ended.
    mends
        Those that were found last for the window.
    """

    model: Model
    wish: Wish
    asked: WishedModel
    extra: Field
    stop: Callable[[], bool]
    progress: Progress
    name: str
    tell: Callable[..., None]
    mends: list[Changed] = field(default_factory=list)

    def require_still(self, what: str) -> None:
        """Refuse what is done before supports move.

        Raises
        ------
        InputError
            The load case moves supports.
        """
        if self.asked.motion is not None:
            raise InputError(
                f"{what} needs supports that have not moved, and this load case moves them",
                remedy="take the motion of the supports back first",
            )


def gravity_of(model: Model) -> float:
    """[m/s2] of the load of a model."""
    return float(np.linalg.norm(acceleration_of(model)))


def _limit(work: Work) -> Iterator[Event]:
    """How far the model can be tilted in the direction of the wish, supports moved at each tilt."""
    motion = work.asked.motion
    check = None if motion is None else partial(after_moving, motion=motion, stop=work.stop)
    found = limit_tilt(
        work.asked.upright, work.asked.axis, check=check, stop=work.stop, progress=work.progress
    )
    yield "limit", {"direction": work.wish.direction, **plain(found.numbers())}


def _mends(work: Work) -> Iterator[Event]:
    """Changes with which what falls would stand."""
    work.mends.clear()

    def found_one(mend: Changed) -> None:
        work.tell("mend", number=len(work.mends), mend=_told(mend))
        work.mends.append(mend)

    part, motion = work.asked.part, work.asked.motion
    options = MendOptions()
    if motion is not None:
        options = MendOptions(AfterMoving.of_supports(part, motion), FOLLOWED_KINDS)
    found = find_mends(
        part, options=options, stop=work.stop, progress=work.progress, found_one=found_one
    )
    told = [{"number": work.mends.index(one), **_told(one)} for one in found.mends]
    tried = [
        {"blocks": list(blocks), "what": f"{one.kind}: {one.what}"} for blocks, one in found.tried
    ]
    message = found.message
    if motion is not None and message:
        first = found.diagnosis.result
        message = _WITH_MOTION if first.stable else first.message
    yield "mends", {"mends": told, "tried": tried, "message": message, "stopped": work.stop()}


def _told(mend: Changed) -> dict[str, Any]:
    return {
        "kind": mend.change.kind,
        "blocks": list(mend.change.blocks),
        "what": mend.change.description,
        "price": mend.price,
        "ghost": _ghost(mend),
    }


def _ghost(mend: Changed) -> list[list[float]]:
    """Edges (six numbers [m] each) of the blocks that a mend changes or adds, as they would be."""
    before = {id(block) for block in mend.before.assembly.blocks}
    ends = [
        block.vertices[edges_of(block.faces)].reshape(-1, 6)
        for block in mend.model.assembly.blocks
        if id(block) not in before
    ]
    return np.round(np.concatenate(ends), 6).tolist() if ends else []


def _apply(work: Work) -> Iterator[Event]:
    """The model with a mend. Tilt and pushes of the wish stay outside of it."""
    number = work.extra["mend"].integer()
    if not 0 <= number < len(work.mends):
        raise InputError("there is no such mend any more", remedy="look for mends again")
    mend = work.mends[number]
    yield "model", _made(work, mend.model, mend.change.description)


def _made(work: Work, made: Model, what: str) -> dict[str, Any]:
    """A changed model of the wish, without its tilt and pushes, and the wish that is left."""
    base = work.model.without(work.wish.removed)
    kept = base.assembly.indices([name for name in made.assembly.names if name in base.assembly])
    load = carried_load(base, made.assembly, kept)
    made = replace(made, load=load, notes=(), report=None, cases=())
    fixed = {made.assembly.names[i] for i in np.flatnonzero(made.assembly.fixed)}
    pushes = tuple(one for one in work.wish.pushes if one[0] in made.assembly)
    moves = tuple(one for one in work.wish.moves if one[0] in fixed)
    wish = replace(work.wish, friction=None, supports=None, removed=(), pushes=pushes, moves=moves)
    return {"made": made, "what": what, "state": as_json(wish)}


def _cut(work: Work) -> Iterator[Event]:
    """The model with a block cut in two by a level plane through its centroid."""
    part, name = work.asked.part, work.extra["block"].text()
    middle = part.assembly.centroid[part.assembly.index(name)]
    gravity = acceleration_of(work.model)
    across = gravity if gravity.any() else np.array(DOWN)
    yield "model", _made(work, cut_block(part, name, middle, across), f"{name} cut in two")


def _recut(work: Work) -> Iterator[Event]:
    """The model with joints changed, or its only block cut, until all is placed without help."""
    work.require_still("a change of joints for the assembly")
    part = work.asked.part
    if len(part.assembly) == 1:
        friction = work.wish.friction
        options = CutOptions() if friction is None else CutOptions(friction=friction)
        cut = cut_until_free(
            part.assembly.blocks[0], options=options, stop=work.stop, progress=work.progress
        )
        message = cut.message
        made = None if cut.plan is None else cut.plan.model.model
    else:
        found = recut_joints(part, stop=work.stop, progress=work.progress)
        message, made = found.message, found.model if found.changes else None
    same = "unchanged", {"message": message}
    yield same if made is None else ("model", _made(work, made, message))


def _plan(work: Work) -> Iterator[Event]:
    """An order of assembly, or what becomes of a given one, as the data of a page."""
    work.require_still("an order of assembly")
    given = work.extra["order"] if work.extra.has("order") else None
    order = [] if given is None else [one.text() for one in given.elements()]
    rules = Rules(order=order or Order.TOP, before=list(itertools.pairwise(order)))
    options = PlanOptions(rules=rules, anyway=True)
    part = work.asked.part
    found = plan(part, options=options, stop=work.stop, progress=work.progress)
    told = {
        **plain(found.numbers()),
        "asked": order,
        "impossible": {part.assembly.names[b]: why for b, why in found.impossible.items()},
        "help": _help(found),
    }
    scene = to_text(encode(scene_of(found))) if found.steps else None
    yield "plan", {"plan": told, "scene": scene}


def _help(found: Plan) -> dict[str, str]:
    """The help that each block needs, by its name."""
    names = found.model.assembly.names
    told = {names[b]: "held" for b, one in enumerate(found.status) if one is Status.HELD}
    for prop in found.props:
        told[names[prop.block]] = f"propped, {units.quantity(prop.force, 'N')}"
    return told


def _cases(work: Work) -> Iterator[Event]:
    """The verdicts of several load cases, one after the other."""
    listed = list(work.extra["cases"].elements())
    if len(listed) > _MOST_CASES:
        raise InputError(f"there are {len(listed)} cases", remedy=f"compare {_MOST_CASES} at most")
    for number, one in enumerate(listed):
        try:
            found = verdict_of(asked(work.model, Wish.read(one)), stop=work.stop)
            verdict = {"headline": found.stage.headline, "verdict": found.result.verdict.name}
        except InputError as error:
            verdict = {"headline": str(error), "verdict": ""}
        yield "case", {"number": number, **verdict}
        if work.stop():
            return


def _save(work: Work) -> Iterator[Event]:
    """The model of the wish as the text of a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.json"
        io.write(work.asked.moving, path)
        text = path.read_text("utf-8")
    yield "saved", {"text": text}


def as_json(wish: Wish) -> dict[str, Any]:
    """A wish as it was sent."""
    return {
        "tilt": wish.tilt,
        "direction": wish.direction,
        "friction": wish.friction,
        "gravity": wish.gravity,
        "supports": None if wish.supports is None else list(wish.supports),
        "removed": list(wish.removed),
        "pushes": [{"block": block, "force": list(force)} for block, force in wish.pushes],
        "moves": [{"block": block, "by": list(by)} for block, by in wish.moves],
    }


TASKS: Mapping[str, Callable[[Work], Iterator[Event]]] = {
    "limit": _limit,
    "mends": _mends,
    "apply": _apply,
    "plan": _plan,
    "cut": _cut,
    "recut": _recut,
    "cases": _cases,
    "save": _save,
}


class Cancelled(BaseException):
    """Nobody waits for the answer any more.

    No ``Exception``, so that no analysis takes it for a failure of its own: it may come between any
    two lines, as Ctrl-C does.
    """


class Jobs:
    """Messages of the server, one after the other, and the way back.

    The thread that makes it is the one that works. A job that is cancelled is interrupted where it
    is, once: an analysis need not ask. Where the interruption is lost, in a callback of compiled
    code, :attr:`cancelled` still tells. Nothing is interrupted while it is sent.
    """

    def __init__(self, pipe: Connection, gone: Callable[[], None]) -> None:
        self._pipe, self._gone = pipe, gone
        self._messages: SimpleQueue[dict[str, Any]] = SimpleQueue()
        self._gate = threading.RLock()
        self._worker = ctypes.c_ulong(threading.get_ident())
        self._now = self._dropped = 0
        threading.Thread(target=self._read, daemon=True, name="drystone-jobs").start()

    @property
    def cancelled(self) -> bool:
        """Whether nobody waits for the job under way."""
        return self._now == self._dropped

    def next(self) -> dict[str, Any]:
        """The next message; waits for it."""
        return self._messages.get()

    def send(self, event: dict[str, Any]) -> None:
        """Tell the server something, as a whole; it may be gone, as where it was killed."""
        try:
            with self._gate:
                self._pipe.send(event)
        except ConnectionError:
            self._gone()

    def do(self, job: int, work: Callable[[], None]) -> None:
        """Work until it has ended or is cancelled."""
        try:
            with self._gate:
                self._now = job
            if not self.cancelled:
                work()
            self._end()
        except Cancelled:  # once in a job, so that the end is not interrupted again
            self._end()

    def _end(self) -> None:
        self._gate.acquire()
        self._now = 0
        ctypes.pythonapi.PyThreadState_SetAsyncExc(self._worker, None)
        # since Python 3.14 an interruption may come when a gate is taken and not yet to be let go
        with contextlib.suppress(RuntimeError):
            while True:
                self._gate.release()

    def _read(self) -> None:
        """Read until the server is gone."""
        try:
            while True:
                message = self._pipe.recv()
                if "cancel" in message:
                    self._cancel(message["cancel"])
                else:
                    self._messages.put(message)
        except (EOFError, OSError):
            self._gone()

    def _cancel(self, job: int) -> None:
        with self._gate:
            if job == self._now != self._dropped:
                raised = ctypes.py_object(Cancelled)
                ctypes.pythonapi.PyThreadState_SetAsyncExc(self._worker, raised)
            self._dropped = job
