"""Forks of a process whose threads calculate.

A fork inherits the locks of the other threads, but not the threads: who asks for one waits for
ever. OpenBLAS takes such a lock for a moment in almost each product of matrices. Before Python 3.12
each cached property has one.
"""

from __future__ import annotations

import os
import sys
from functools import cached_property
from threading import RLock, enumerate, get_native_id
from time import monotonic

_PACKAGE = __name__.partition(".")[0]
_ALONE_S = 0.5
"""For how long a fork keeps the interpreter to itself, at most."""
_usual: list[float] = []
"""The switch interval [s] that each fork under way found."""


def watch_forks() -> None:
    """See to it that every process that is forked from now on can calculate."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(before=_quiet, after_in_parent=_go_on, after_in_child=_free)


def _quiet() -> None:
    """Keep the lock of the interpreter until no thread calculates without it.

    No thread can begin to: each ends the compiled function that it is in and then waits. Nothing
    here may ask for the lock once they do, so files are read by the functions of C. Threads that
    calculate on for longer than the bound are not waited for.
    """
    others = [one.native_id for one in enumerate() if one.native_id not in (None, get_native_id())]
    if not others:
        return
    from ctypes import PyDLL, create_string_buffer

    system, state = PyDLL(None), create_string_buffer(512)

    def calculates(thread: int | None) -> bool:
        file = system.open(f"/proc/self/task/{thread}/stat".encode(), os.O_RDONLY)
        length = system.read(file, state, len(state))
        system.close(file)
        return length > 0 and state.raw[:length].rpartition(b") ")[2][:1] in b"RD"

    _usual.append(sys.getswitchinterval())
    sys.setswitchinterval(_ALONE_S)
    # who waits since before asks for the lock within the old interval, and has it here
    system.usleep(round(1e6 * min(_usual[0], 0.02 * _ALONE_S)) + 1000)
    end = monotonic() + 0.5 * _ALONE_S
    while any(calculates(each) for each in others) and monotonic() < end:
        system.usleep(500)


def _go_on() -> None:
    """In the process that forked, once no other thread of it forks."""
    if _usual:
        usual = _usual.pop()
        if not _usual:
            sys.setswitchinterval(usual)


def _free() -> None:
    """In the fork."""
    if _usual:
        sys.setswitchinterval(_usual[0])
        _usual.clear()
    if sys.version_info >= (3, 12):
        return
    modules = [one for name, one in list(sys.modules.items()) if name.startswith(_PACKAGE)]
    for kind in {each for one in modules for each in vars(one).values() if isinstance(each, type)}:
        for member in list(vars(kind).values()):
            if isinstance(member, cached_property):
                member.lock = RLock()  # type: ignore[attr-defined]
