"""The process that computes: it reads models and answers wishes, one after the other.

It is asked through a pipe by :mod:`drystone.live.helper`, and tells what it finds as it
goes.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from drystone.base.arrays import Floats
from drystone.base.errors import DrystoneError, InputError
from drystone.design import Changed
from drystone.io import read
from drystone.io.jsontext import Field, parse
from drystone.live import tasks
from drystone.live.moved_supports import MOST_AT_ONCE, CoarseSteps, at_once, verdict_of
from drystone.live.tasks import Cancelled, Jobs
from drystone.live.wish import Found, Wish, WishedModel, asked, snapshot
from drystone.mcp.answers import answer
from drystone.mcp.folder import Folder
from drystone.model import Model
from drystone.solvers.threads import one_blas_thread
from drystone.stability import QUICK, check, try_rest
from drystone.view import scene_of
from drystone.view.encode import encode, to_text

_STARTS = 16
"""Rest states that are kept to start from, of as many windows and sets of blocks."""
_DRAGGED = 4
"""Models with moved supports that are kept, each of a window and a load case."""
REST, FOLLOWED = "rest", "followed"
"""What is kept of a window: rest states, and where blocks were that followed supports."""
_OFTEN = 0.2
"""[s] between two reports of progress."""
_SMALLER = "give a smaller model"
_WHOLE = "send one whole JSON object"


class Calculator:
    """Models by their numbers, and rest states to start from."""

    def __init__(self, jobs: Jobs) -> None:
        self.jobs = jobs
        self.models: dict[int, Model] = {}
        self.starts: OrderedDict[Any, dict[int, Floats]] = OrderedDict()
        self.dragged: OrderedDict[Any, Future[CoarseSteps]] = OrderedDict()
        self.beside = ThreadPoolExecutor(1)
        self.mends: tuple[str, list[Changed]] = ("", [])
        self.job = 0
        self._reported = 0.0

    def run(self) -> None:
        """Answer one job after the other."""
        while True:
            message = self.jobs.next()
            self.job = message["job"]
            if "blob" in message:
                self.models[message["model"]] = pickle.loads(message["blob"])  # from our own server
            for number in message.get("forget", ()):
                self.models.pop(number, None)
            self.jobs.do(self.job, partial(self._answer, message))
            self.tell("done")

    def _answer(self, message: Mapping[str, Any]) -> None:
        try:
            DO[message["do"]](self, message)
        except DrystoneError as error:
            self.tell("error", **error.parts())
        except MemoryError:
            self.tell("error", what="the memory was used up", where="", remedy=_SMALLER)
        except Exception as error:  # the edge of the process: a fault of ours, told in one line
            what = f"a fault in drystone, please report it: {type(error).__name__}: {error}"
            self.tell("error", what=what, where="", remedy=_SMALLER)

    def tell(self, event: str, **what: Any) -> None:
        """Send an event of the job that is under way."""
        self.jobs.send({"event": event, "job": self.job, **what})

    def stop(self) -> bool:
        """Whether the job was cancelled."""
        return self.jobs.cancelled

    def until(self, seconds: float) -> Callable[[], bool]:
        """Whether the job was cancelled or its time is up."""
        end = time.monotonic() + seconds
        return lambda: self.stop() or time.monotonic() > end

    def progress(self, stage: str, done: int, total: int) -> None:
        """Tell how far it is, not too often."""
        if time.monotonic() - self._reported > _OFTEN:
            self._reported = time.monotonic()
            self.tell("progress", stage=stage, done=done, total=total)

    def require(self) -> None:
        """Raise Cancelled where nobody waits any more."""
        if self.stop():
            raise Cancelled

    def asked(self, message: Mapping[str, Any]) -> tuple[Wish, WishedModel]:
        """The wish in a message, and the model that it makes."""
        wish = Wish.read(Field(message["wish"], "", Path("wish")))
        return wish, asked(self.models[message["model"]], wish)

    def known(self, message: Mapping[str, Any], wish: Wish, what: str = REST) -> dict[int, Floats]:
        """The last rest states of a window with the same blocks, by the number of the stiffness.

        Of blocks that followed there is one, with the number 0.
        """
        key = (what, message["window"], message["model"], wish.removed)
        states = self.starts.setdefault(key, {})
        self.starts.move_to_end(key)
        while len(self.starts) > _STARTS:
            self.starts.popitem(last=False)
        return states

    def rest_of(self, load_case: Any, model: Model) -> Future[CoarseSteps]:
        """The rest from which supports move.

        It is sought beside the wishes: each of those that are dragged would end it.
        """
        if load_case not in self.dragged:
            self.dragged[load_case] = self.beside.submit(CoarseSteps, model)
        while len(self.dragged) > _DRAGGED:
            self.dragged.popitem(last=False)[1].cancel()
        return self.dragged[load_case]

    def keep(self, model: Model, number: int, **more: Any) -> None:
        """Keep a model under a number, and hand it over with its picture."""
        self.models[number] = model
        scene = to_text(encode(scene_of(model)))
        self.tell("model", blob=pickle.dumps(model), scene=scene, facts=facts(model), **more)


def facts(model: Model) -> dict[str, Any]:
    """What the controls of the page begin with."""
    friction = model.contacts.friction
    names = [model.assembly.names[i] for i in range(len(model)) if model.assembly.fixed[i]]
    return {
        "friction": [float(friction.min()), float(friction.max())] if len(friction) else None,
        "gravity": tasks.gravity_of(model),
        "supports": names,
        "moves": model.load.motion is not None,
        "notes": list(model.notes),
    }


def _read(self: Calculator, message: Mapping[str, Any]) -> None:
    folder: Folder = message["folder"]
    name = message["name"]
    if not (folder.path / name).is_file():  # while it was watched
        raise InputError("the file is gone", where=name, remedy="save it again")
    path = folder.model(name)
    model = read(path, **message["how"])
    self.keep(model, message["number"])


def _quick(self: Calculator, message: Mapping[str, Any]) -> None:
    """With uniform stiffness, or to first order where supports move."""
    began = time.perf_counter()
    wish, made = self.asked(message)
    with one_blas_thread():
        if made.motion is None:
            found = _at_rest(self, made, message, wish)
        else:
            found = _first_of_moved(self, made, message, wish)
    self.require()
    _show(self, "quick", wish, made, found, began)


def _first_of_moved(
    self: Calculator, made: WishedModel, message: Mapping[str, Any], wish: Wish
) -> Found:
    """To first order, or from where the blocks of the same load case were followed coarsely."""
    before = self.known(message, wish, FOLLOWED).get(0)
    if len(made.part) <= MOST_AT_ONCE:
        return at_once(made.moving, None, before)
    load_case = _load_case(message, wish)
    sought = self.rest_of(load_case, made.part)
    if not wait([sought], 0.05).done:
        return at_once(made.moving, None, before)
    del self.dragged[load_case]  # where it is interrupted it is not kept
    found = at_once(made.moving, sought.result(), before)
    self.dragged[load_case] = sought
    return found


def _load_case(message: Mapping[str, Any], wish: Wish) -> Any:
    """A window's model with all of a wish but its moves."""
    return message["window"], message["model"], replace(wish, moves=())


def _at_rest(self: Calculator, made: WishedModel, message: Mapping[str, Any], wish: Wish) -> Found:
    """From the last rest state of the window with the same blocks."""
    known = self.known(message, wish)
    found = try_rest(made.part, screening=QUICK, start=known.get(0), stop=self.stop)
    self.require()
    if found.stable and found.displacement is not None:
        known[0] = found.displacement
    return Found.at_rest(found, quick=True)


def _whole(self: Calculator, message: Mapping[str, Any]) -> None:
    """The verdict, from the rest states of the last one where no support moves."""
    began = time.perf_counter()
    wish, made = self.asked(message)
    limits: Any = {
        "stop": self.stop, "progress": self.progress, "time_limit_s": message["seconds"],
    }  # fmt: skip

    def watch(found: Found) -> None:
        if found.result.displacement is not None:
            self.known(message, wish, FOLLOWED)[0] = found.result.displacement
        _show(self, "following", wish, made, found, began)

    if made.motion is not None:
        if len(made.part) > MOST_AT_ONCE:  # what it finds is needed here too
            sought = self.rest_of(_load_case(message, wish), made.part)
            while not wait([sought], 0.05).done:
                self.require()
        found = verdict_of(made, watch=watch, **limits)
        if found.moved and found.result.displacement is not None:
            self.known(message, wish, FOLLOWED)[0] = found.result.displacement
    else:
        known = self.known(message, wish)
        result = check(made.part, start=known.get(0), **limits)
        if result.stable and result.settlement is None and result.displacement is not None:
            known[0] = result.displacement
        found = Found.at_rest(result)
    self.require()
    _show(self, "whole", wish, made, found, began)


def _show(
    self: Calculator,
    event: str,
    wish: Wish,
    made: WishedModel,
    found: Found,
    began: float,
) -> None:
    picture = snapshot(made, wish, found)
    result = found.result
    told = {
        "verdict": result.verdict.value,
        "headline": found.stage.headline,
        "falling": list(result.falling_names),
        "stopped": result.stopped,
        "computed_ms": round(1e3 * (time.perf_counter() - began), 1),
    }
    self.tell(event, answer=told, picture=json.dumps(picture, allow_nan=False))


def _task(self: Calculator, message: Mapping[str, Any]) -> None:
    """Something that takes longer: the limit of a direction, mends, a plan, a file."""
    wish, made = self.asked(message)
    extra = Field(message["extra"], "", Path("wish"))
    work = tasks.Work(
        self.models[message["model"]], wish, made, extra, self.until(message["seconds"]),
        self.progress, message["name"], self.tell,
    )  # fmt: skip
    if self.mends[0] == message["window"]:
        work.mends = self.mends[1]
    self.mends = message["window"], work.mends
    for event, what in tasks.TASKS[message["task"]](work):
        self.require()
        if event == "model":
            self.keep(what.pop("made"), message["number"], **what)
        else:
            self.tell(event, **what)


def _tool(self: Calculator, message: Mapping[str, Any]) -> None:
    """A call of the JSON interface."""
    given = parse(message["body"], Path("request"), _WHOLE).object().value
    found = answer(message["tool"], given, message["folder"], message["seconds"])
    if "error" in found:
        self.tell("error", **{part: found[part] for part in ("what", "where", "remedy")})
    else:
        self.tell("answer", answer=json.dumps(found, allow_nan=False))


DO: Mapping[str, Callable[[Calculator, Mapping[str, Any]], None]] = {
    "read": _read,
    "quick": _quick,
    "whole": _whole,
    "task": _task,
    "cases": _task,
    "tool": _tool,
}


def calculate(pipe: Connection) -> None:
    """What the process does. Ctrl-C is for the server, which then closes the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    jobs = Jobs(pipe, gone=lambda: os._exit(0))  # a calculation would go on for nobody
    with one_blas_thread():  # libraries are looked for once: here, not in the first answer
        jobs.send({"event": "ready"})
    Calculator(jobs).run()
