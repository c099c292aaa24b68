"""The keywords of everything that may take long: ``executor, progress, stop, time_limit_s``.

Every analysis, limit, plan and settlement takes these four as :class:`LongWork`, and makes a
:class:`Clock` of them. They never change the result of a calculation that is not ended early.
"""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any, TypeAlias, TypedDict, get_type_hints

from drystone.base.hints import left_out
from drystone.base.workers import ExecutorFactory

Progress: TypeAlias = Callable[[str, int, int], None]
"""Called as ``progress(stage, done, total)`` with 0 <= done <= total; it must not raise.
It cannot stop the work: use ``stop``."""

Stop: TypeAlias = Callable[[], bool]
"""Whether to stop. Once True, it must stay True."""

Workers: TypeAlias = Executor | ExecutorFactory
"""Where parts of a calculation run side by side."""


class LongWork(TypedDict, total=False):
    """The four keywords."""

    executor: Workers | None
    progress: Progress | None
    stop: Stop | None
    time_limit_s: float


KEYWORDS = {
    "executor": """\
Computes independent parts side by side: a ``concurrent.futures.Executor``, or a function
that starts one, such as ``drystone.sequence.LocalWorkers(4)``. The result does not depend on it.
Where every step needs the one before, there is nothing to share, and it is not used.""",
    "progress": """\
Called as ``progress(stage, done, total)``, with 0 <= done <= total.""",
    "stop": """\
Called often; True ends the calculation with the results so far.""",
    "time_limit_s": """\
Time [s] after which the calculation ends with the results so far.""",
}
"""Their documentation."""


class Stopped(Exception):
    """A search ends early: ``stop`` asked for it, or its time is over. What it found is kept."""


class Clock:
    """Time since the start, the limit, and the caller's request to stop; once late, always late.

    ``progress`` is what :meth:`tell` calls, ``workers`` the executor or what starts one.
    """

    def __init__(
        self,
        limit_s: float,
        stop: Stop | None = None,
        progress: Progress | None = None,
        workers: Workers | None = None,
    ) -> None:
        self.began = time.perf_counter()
        self.limit_s = limit_s
        self.wish = stop
        self.progress = progress
        self.workers = workers
        self.reason = ""

    @classmethod
    def of(cls, work: LongWork) -> Clock:
        """From the keywords of a function, which are taken out of them."""
        limit_s, stop = work.pop("time_limit_s", math.inf), work.pop("stop", None)
        return cls(limit_s, stop, work.pop("progress", None), work.pop("executor", None))

    @property
    def rest(self) -> LongWork:
        """The keywords of a calculation that is a part of this one."""
        return {
            "executor": self.workers,
            "progress": self.progress,
            "stop": self.wish,
            "time_limit_s": self.left_s,
        }

    def __getstate__(self) -> dict[str, Any]:
        """What travels to another process: the time that is left, not the request to stop."""
        return {"limit_s": self.left_s, "reason": self.reason}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["limit_s"])  # type: ignore[misc]
        self.reason = state["reason"]

    def tell(self, stage: str, done: int, total: int) -> None:
        """Report how far a stage is, where the caller wants to know."""
        if self.progress is not None:
            self.progress(stage, done, total)

    @property
    def elapsed_s(self) -> float:
        """[s]."""
        return time.perf_counter() - self.began

    @property
    def left_s(self) -> float:
        """[s], until the limit."""
        return max(self.limit_s - self.elapsed_s, 0.0)

    def late(self) -> bool:
        """Whether to stop now with the results so far; ``reason`` then says why."""
        if not self.reason:
            if self.wish is not None and self.wish():
                self.reason = "it was interrupted"
            elif self.elapsed_s > self.limit_s:
                self.reason = "the time was up"
        return bool(self.reason)


def with_keywords(documentation: str | None) -> str | None:
    """The documentation of a function with that of the four keywords."""
    if documentation is None:
        return None
    lines = inspect.cleandoc(documentation).splitlines()
    if "Parameters" not in lines:
        at = _section(lines, 0)
        lines[at:at] = ["Parameters", "----------", ""]
    begin = lines.index("Parameters") + 2
    at = _section(lines, begin)
    while not lines[at - 1].strip():
        at -= 1
    for name, words in reversed(KEYWORDS.items()):
        lines[at:at] = [name, *(f"    {line}" for line in words.splitlines())]
    return "\n".join(lines)


def with_parameters(signature: inspect.Signature, keywords: Any) -> inspect.Signature:
    """The signature of a function with its dictionary of keywords by their names.

    Of ``**how``, the arguments of :func:`drystone.read`, those of long work only.
    """
    *own, last = signature.parameters.values()
    named = LongWork if last.name == "how" else keywords
    more = [
        inspect.Parameter(
            name,
            last.KEYWORD_ONLY,
            default=left_out(hint),
            annotation=named.__annotations__[name].__forward_arg__,
        )
        for name, hint in get_type_hints(named).items()
    ]
    return signature.replace(parameters=[*own, *more, *([last] if last.name == "how" else [])])


def _section(lines: list[str], begin: int) -> int:
    """Where the next section of a documentation begins; its end where there is none."""
    for at in range(begin, len(lines) - 1):
        if lines[at].strip() and set(lines[at + 1]) == {"-"}:
            return at
    lines.append("")
    return len(lines)
